//! Joint torques from the dynamics of a frame.

use nalgebra::DVector;
use robot_dynamics_description::check_length;
use robot_dynamics_number::{check_finite, check_result};
use robot_dynamics_simulation::ControllerError;

use super::OperationalSpace;
use super::mobility::MOST_ROWS;

impl OperationalSpace {
    /// τ = JᵀF with F = Λ ẍ + μ + p: the torque that gives the frame this acceleration. The motion of the
    /// robot in the null space is not controlled, and gravity acts on it: see
    /// [`torque_with_posture`](Self::torque_with_posture). It allocates.
    ///
    /// # Errors
    /// [`ControllerError`] if ẍ is not finite, or τ overflows.
    ///
    /// # Panics
    /// Panics if ẍ has the wrong length.
    #[track_caller]
    pub fn torque(&self, acceleration: &[f64]) -> Result<DVector<f64>, ControllerError> {
        let mut tau = DVector::zeros(self.jacobian.ncols());
        self.add_force(&self.force(acceleration)?, tau.as_mut_slice())?;
        Ok(tau)
    }

    /// (1 − JᵀJ̄ᵀ) τ₀: a torque without its component that accelerates the frame. It allocates.
    ///
    /// # Errors
    /// [`ControllerError`] if τ₀ is not finite, or the result overflows.
    ///
    /// # Panics
    /// Panics if τ₀ has the wrong length.
    #[track_caller]
    pub fn null_torque(&self, tau: &[f64]) -> Result<DVector<f64>, ControllerError> {
        let mut rest = DVector::zeros(self.jacobian.ncols());
        self.with_null_torque([0.0; MOST_ROWS], tau, rest.as_mut_slice())?;
        Ok(rest)
    }

    /// The torque with a null-space part:
    ///
    /// > τ = JᵀF + (1 − JᵀJ̄ᵀ) τ₀,  F = Λ ẍ + μ + p
    ///
    /// The frame accelerates with ẍ for any τ₀, and τ₀ controls the motion in the null space. τ has nv
    /// entries, ẍ has K, and τ₀ has nv. It does not allocate.
    ///
    /// τ₀ = C v + g − k (q ⊖ q\*) − d v keeps an arm's elbow in place. Without C v + g, which compensates its
    /// weight, the elbow sags, and without the spring it drifts.
    ///
    /// ```
    /// use robot_dynamics::algorithms::forward_dynamics;
    /// use robot_dynamics::algorithms::{ReferenceFrame, frame_acceleration};
    /// use robot_dynamics::constraints::SpatialAxis;
    /// use robot_dynamics::control::operational_space;
    /// use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
    /// use robot_dynamics::model::{Model, Workspace};
    /// let options = RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    /// let model = Model::new(random_robot(4, &options))?;
    /// let hand = model.frame(&model.frames()[model.frames().len() - 1].name).expect("a frame");
    /// let (w, q, v) = (&mut Workspace::new(&model), vec![0.4; 7], vec![0.0; 7]);
    /// let rows = [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z];
    /// let space = operational_space(&model, w, &q, &v, hand, &rows)?;
    /// let (mut tau, mut a) = (vec![0.0; 7], vec![0.0; 7]);
    /// space.torque_with_posture(&[0.1, 0.2, 0.3], &vec![5.0; 7], &mut tau)?;
    /// forward_dynamics(&model, w, &q, &v, &tau, &mut a);
    /// let moved = frame_acceleration(&model, w, &q, &v, &a, hand, ReferenceFrame::LocalWorldAligned).linear;
    /// assert!((moved[1] - 0.2).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ControllerError`] if ẍ or τ₀ is not finite, or τ overflows; τ is then unspecified.
    ///
    /// # Panics
    /// Panics if a slice has the wrong length.
    #[track_caller]
    pub fn torque_with_posture(
        &self,
        acceleration: &[f64],
        posture: &[f64],
        tau: &mut [f64],
    ) -> Result<(), ControllerError> {
        self.with_null_torque(self.force(acceleration)?, posture, tau)
    }

    /// [`torque_with_posture`](Self::torque_with_posture) with a further force f at the frame:
    /// F = Λ ẍ + μ + p + f.
    pub(super) fn torque_with_force(
        &self,
        acceleration: &[f64],
        further: &[f64],
        posture: &[f64],
        tau: &mut [f64],
    ) -> Result<(), ControllerError> {
        let mut force = self.force(acceleration)?;
        force.iter_mut().zip(further).for_each(|(force, further)| *force += further);
        self.with_null_torque(force, posture, tau)
    }

    /// F = Λ ẍ + μ + p.
    fn force(&self, acceleration: &[f64]) -> Result<[f64; MOST_ROWS], ControllerError> {
        let count = self.inertia.nrows();
        check_length("the acceleration", acceleration.len(), count);
        check_finite("the acceleration", acceleration)?;
        let mut force = [0.0; MOST_ROWS];
        for k in 0..count {
            let push: f64 = (0..count).map(|j| self.inertia[(k, j)] * acceleration[j]).sum();
            force[k] = push + self.bias_force[k];
        }
        Ok(force)
    }

    /// τ = JᵀF + (1 − JᵀJ̄ᵀ) τ₀ = τ₀ + Jᵀ(F − J̄ᵀτ₀).
    fn with_null_torque(
        &self,
        mut force: [f64; MOST_ROWS],
        posture: &[f64],
        tau: &mut [f64],
    ) -> Result<(), ControllerError> {
        let nv = self.jacobian.ncols();
        check_length("the posture's torque", posture.len(), nv);
        check_length("tau", tau.len(), nv);
        check_finite("the posture's torque", posture)?;
        for (force, column) in force.iter_mut().zip(self.consistent_inverse.column_iter()) {
            *force -= column.iter().zip(posture).map(|(j, tau)| j * tau).sum::<f64>();
        }
        tau.copy_from_slice(posture);
        self.add_force(&force, tau)
    }

    /// τ ← τ + JᵀF.
    fn add_force(&self, force: &[f64; MOST_ROWS], tau: &mut [f64]) -> Result<(), ControllerError> {
        for (tau, column) in tau.iter_mut().zip(self.jacobian.column_iter()) {
            *tau += column.iter().zip(force).map(|(j, f)| j * f).sum::<f64>();
        }
        Ok(check_result("the torque", &*tau)?)
    }
}
