//! The algorithms as methods of [`Model`], which check their input and allocate their memory.
//!
//! In a loop, call the functions of the same names with a [`Workspace`] instead: they do not allocate.

mod pullback;
mod second_order;

use nalgebra::{DMatrix, DVector, Vector3};
use robot_dynamics_description::Pose;
use robot_dynamics_number::check_result;

use crate::{
    CentroidalMomentum, FrameId, Model, MotionError, ReferenceFrame, Workspace, check_configuration,
    check_vector,
};

pub use pullback::{ForwardPullback, InversePullback};
pub use second_order::{
    ForwardHessianProduct, ForwardSecondDerivatives, InverseHessianProduct, InverseSecondDerivatives,
};

/// The three nv×nv derivatives of τ(q, v, a).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "InverseSlopes")]
pub struct InverseDynamicsDerivatives {
    /// ∂τ/∂q; along [`integrate`](crate::integrate)(q, δ eⱼ) for quaternion joints.
    pub by_position: DMatrix<f64>,
    /// ∂τ/∂v.
    pub by_velocity: DMatrix<f64>,
    /// ∂τ/∂a = M.
    pub by_acceleration: DMatrix<f64>,
}

/// The three nv×nv derivatives of a(q, v, τ).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "ForwardSlopes")]
pub struct ForwardDynamicsDerivatives {
    /// ∂a/∂q; along [`integrate`](crate::integrate)(q, δ eⱼ) for quaternion joints.
    pub by_position: DMatrix<f64>,
    /// ∂a/∂v.
    pub by_velocity: DMatrix<f64>,
    /// ∂a/∂τ = M⁻¹.
    pub by_force: DMatrix<f64>,
}

type Result<T> = core::result::Result<T, MotionError>;

/// Checked forms of the algorithms.
///
/// q has `nq` finite numbers with quaternions of unit length; v, a and tau have `nv` finite numbers.
///
/// # Errors
/// Every method returns [`MotionError`], which names the number at fault. The cause is an invalid
/// configuration, a vector of the wrong length, a number that is not finite, or an overflow. Methods that
/// invert M return [`MotionError::SingularMass`] with the joints that move no inertia.
///
/// ```
/// use robot_dynamics::ErrorKind;
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, neutral};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let (q, v) = (neutral(&model), vec![0.1; model.nv()]);
/// let a = model.forward_dynamics(&q, &v, &vec![0.0; model.nv()])?;
/// let tau = model.inverse_dynamics(&q, &v, a.as_slice())?;
/// assert!(tau.amax() < 1e-9);
/// let mut wrong = v;
/// wrong[2] = f64::NAN;
/// let error = model.bias(&q, &wrong).unwrap_err();
/// let error = robot_dynamics::Error::from(error);
/// assert_eq!(error.kind(), ErrorKind::InvalidInput);
/// assert!(error.to_string().starts_with("v[2]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[allow(clippy::missing_errors_doc)] // documented on the block
impl Model {
    /// M(q), nv×nv; see [`mass_matrix`](crate::mass_matrix).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mass = Model::new(pendulum(2.0, 0.5))?.mass_matrix(&[0.3])?;
    /// assert!((mass[(0, 0)] - 2.0 * 0.5 * 0.5).abs() < 1e-15); // m l²
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mass_matrix(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        check_configuration(self, q)?;
        self.matrix("M", self.nv, |w, m| crate::mass_matrix(self, w, q, m))
    }

    /// M(q)⁻¹, nv×nv; see [`inverse_mass_matrix`](crate::inverse_mass_matrix).
    pub fn inverse_mass_matrix(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        check_configuration(self, q)?;
        self.check_mass(q)?;
        self.matrix("M⁻¹", self.nv, |w, m| crate::inverse_mass_matrix(self, w, q, m))
    }

    /// C(q,v), nv×nv; see [`coriolis_matrix`](crate::coriolis_matrix).
    pub fn coriolis_matrix(&self, q: &[f64], v: &[f64]) -> Result<DMatrix<f64>> {
        self.check_state(q, v)?;
        self.matrix("C", self.nv, |w, m| crate::coriolis_matrix(self, w, q, v, m))
    }

    /// C(q,v) v; see [`velocity_product`](crate::velocity_product).
    pub fn velocity_product(&self, q: &[f64], v: &[f64]) -> Result<DVector<f64>> {
        self.check_state(q, v)?;
        self.vector("C v", |w, x| crate::velocity_product(self, w, q, v, x))
    }

    /// g(q) = ∂V/∂q; see [`gravity`](crate::gravity). [`Model::gravity`] is the gravitational acceleration.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let hold = Model::new(pendulum(2.0, 0.5))?.gravity_forces(&[0.3])?;
    /// assert!((hold[0] + 2.0 * 9.81 * 0.5 * 0.3_f64.cos()).abs() < 1e-14); // −m g l cos q
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn gravity_forces(&self, q: &[f64]) -> Result<DVector<f64>> {
        check_configuration(self, q)?;
        self.vector("g", |w, x| crate::gravity(self, w, q, x))
    }

    /// C(q,v) v + g(q); see [`bias`](crate::bias).
    pub fn bias(&self, q: &[f64], v: &[f64]) -> Result<DVector<f64>> {
        self.check_state(q, v)?;
        self.vector("C v + g", |w, x| crate::bias(self, w, q, v, x))
    }

    /// τ = M a + C v + g; see [`inverse_dynamics`](crate::inverse_dynamics).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let tau = Model::new(pendulum(2.0, 0.5))?.inverse_dynamics(&[0.3], &[1.0], &[2.0])?;
    /// assert!((tau[0] - (0.5 * 2.0 - 9.81 * 0.3_f64.cos())).abs() < 1e-14); // m l² a − m g l cos q
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], a: &[f64]) -> Result<DVector<f64>> {
        self.check_state(q, v)?;
        check_vector(self, "a", a)?;
        self.vector("tau", |w, x| crate::inverse_dynamics(self, w, q, v, a, x))
    }

    /// a = M⁻¹(τ − C v − g); see [`forward_dynamics`](crate::forward_dynamics).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let a = Model::new(pendulum(2.0, 0.5))?.forward_dynamics(&[0.3], &[1.0], &[0.7])?;
    /// assert!((a[0] - (0.7 + 9.81 * 0.3_f64.cos()) / 0.5).abs() < 1e-13); // (τ + m g l cos q)/(m l²)
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forward_dynamics(&self, q: &[f64], v: &[f64], tau: &[f64]) -> Result<DVector<f64>> {
        self.check_state(q, v)?;
        check_vector(self, "tau", tau)?;
        self.check_mass(q)?;
        self.vector("a", |w, x| crate::forward_dynamics(self, w, q, v, tau, x))
    }

    /// K \[J\]; see [`kinetic_energy`](crate::kinetic_energy).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let energy = Model::new(pendulum(2.0, 0.5))?.kinetic_energy(&[0.3], &[3.0])?;
    /// assert!((energy - 0.5 * 2.0 * 1.5 * 1.5).abs() < 1e-14); // ½ m (l v)²
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn kinetic_energy(&self, q: &[f64], v: &[f64]) -> Result<f64> {
        self.check_state(q, v)?;
        let energy = crate::kinetic_energy(self, &mut Workspace::new(self), q, v);
        check_result("the kinetic energy", &[energy])?;
        Ok(energy)
    }

    /// V \[J\]; see [`potential_energy`](crate::potential_energy).
    pub fn potential_energy(&self, q: &[f64]) -> Result<f64> {
        check_configuration(self, q)?;
        let energy = crate::potential_energy(self, &mut Workspace::new(self), q);
        check_result("the potential energy", &[energy])?;
        Ok(energy)
    }

    /// The centre of mass of the moving bodies in the world \[m\]; see
    /// [`center_of_mass`](crate::center_of_mass).
    pub fn center_of_mass(&self, q: &[f64]) -> Result<Vector3<f64>> {
        check_configuration(self, q)?;
        self.check_has_mass()?;
        let center = crate::center_of_mass(self, &mut Workspace::new(self), q);
        check_result("the centre of mass", &center)?;
        Ok(center.into())
    }

    /// ċ = J v, 3×nv; see [`center_of_mass_jacobian`](crate::center_of_mass_jacobian).
    pub fn center_of_mass_jacobian(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        check_configuration(self, q)?;
        self.check_has_mass()?;
        self.matrix("the centre of mass's J", 3, |w, m| crate::center_of_mass_jacobian(self, w, q, m))
    }

    /// Momentum about the centre of mass; see [`centroidal_momentum`](crate::centroidal_momentum).
    pub fn centroidal_momentum(&self, q: &[f64], v: &[f64]) -> Result<CentroidalMomentum> {
        self.check_state(q, v)?;
        self.check_has_mass()?;
        let momentum = crate::centroidal_momentum(self, &mut Workspace::new(self), q, v);
        check_result("the momentum", &[momentum.linear, momentum.angular].concat())?;
        Ok(momentum)
    }

    /// A_G, 6×nv; see [`centroidal_momentum_matrix`](crate::centroidal_momentum_matrix).
    pub fn centroidal_momentum_matrix(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        check_configuration(self, q)?;
        self.check_has_mass()?;
        self.matrix("A_G", 6, |w, m| crate::centroidal_momentum_matrix(self, w, q, m))
    }

    /// `world_from_frame`; see [`frame_pose`](crate::frame_pose).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let tip = model.frame_pose(&[0.3], model.frame_named("tip")?)?.translation;
    /// assert!((tip[0] - 0.5 * 0.3_f64.cos()).abs() < 1e-15 && (tip[2] + 0.5 * 0.3_f64.sin()).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn frame_pose(&self, q: &[f64], frame: FrameId) -> Result<Pose> {
        check_configuration(self, q)?;
        let pose = crate::frame_pose(self, &mut Workspace::new(self), q, frame);
        check_result("the frame's position", &pose.translation)?;
        Ok(pose)
    }

    /// J, 6×nv, linear then angular; see [`frame_jacobian`](crate::frame_jacobian).
    ///
    /// ```
    /// use robot_dynamics::algorithms::ReferenceFrame;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let tip = model.frame_named("tip")?;
    /// let jacobian = model.frame_jacobian(&[0.3], tip, ReferenceFrame::LocalWorldAligned)?; // 6×1
    /// assert!((jacobian[(2, 0)] + 0.5 * 0.3_f64.cos()).abs() < 1e-15 && jacobian[(4, 0)] == 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias = "frame_jacobian_in_frame")]
    #[doc(alias = "frame_jacobian_in_world")]
    #[doc(alias = "frame_jacobian_world_aligned")]
    pub fn frame_jacobian(
        &self,
        q: &[f64],
        frame: FrameId,
        reference_frame: ReferenceFrame,
    ) -> Result<DMatrix<f64>> {
        check_configuration(self, q)?;
        self.matrix("J", 6, |w, m| crate::frame_jacobian(self, w, q, frame, reference_frame, m))
    }

    /// Y with τ = Y π, nv×10·links; see [`joint_torque_regressor`](crate::joint_torque_regressor).
    pub fn joint_torque_regressor(&self, q: &[f64], v: &[f64], a: &[f64]) -> Result<DMatrix<f64>> {
        self.check_state(q, v)?;
        check_vector(self, "a", a)?;
        let columns = crate::PARAMETERS_PER_LINK * self.moving_links().count();
        let mut entries = vec![0.0; self.nv * columns];
        crate::joint_torque_regressor(self, &mut Workspace::new(self), q, v, a, &mut entries);
        check_result("Y", &entries)?;
        Ok(DMatrix::from_row_slice(self.nv, columns, &entries))
    }

    /// ∂τ/∂q, ∂τ/∂v and ∂τ/∂a = M; see [`inverse_dynamics_derivatives`](crate::inverse_dynamics_derivatives).
    pub fn inverse_dynamics_derivatives(
        &self,
        q: &[f64],
        v: &[f64],
        a: &[f64],
    ) -> Result<InverseDynamicsDerivatives> {
        self.check_state(q, v)?;
        check_vector(self, "a", a)?;
        let w = &mut Workspace::new(self);
        let [mut x, mut y, mut m] = [(); 3].map(|()| vec![0.0; self.nv * self.nv]);
        let out = crate::InverseDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y };
        crate::inverse_dynamics_derivatives(self, w, q, v, a, out);
        crate::mass_matrix(self, w, q, &mut m);
        Ok(InverseDynamicsDerivatives {
            by_position: self.square("∂τ/∂q", &x)?,
            by_velocity: self.square("∂τ/∂v", &y)?,
            by_acceleration: self.square("M", &m)?,
        })
    }

    /// ∂a/∂q, ∂a/∂v and ∂a/∂τ = M⁻¹; see
    /// [`forward_dynamics_derivatives`](crate::forward_dynamics_derivatives).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let derivatives = Model::new(pendulum(2.0, 0.5))?.forward_dynamics_derivatives(&[0.3], &[1.0], &[0.7])?;
    /// assert!((derivatives.by_position[(0, 0)] + 9.81 / 0.5 * 0.3_f64.sin()).abs() < 1e-13); // −(g/l) sin q
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forward_dynamics_derivatives(
        &self,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
    ) -> Result<ForwardDynamicsDerivatives> {
        self.check_state(q, v)?;
        check_vector(self, "tau", tau)?;
        self.check_mass(q)?;
        let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; self.nv * self.nv]);
        let w = &mut Workspace::new(self);
        let out = crate::ForwardDynamicsDerivativesMut {
            by_position: &mut x,
            by_velocity: &mut y,
            by_force: &mut z,
        };
        crate::forward_dynamics_derivatives(self, w, q, v, tau, out);
        Ok(ForwardDynamicsDerivatives {
            by_position: self.square("∂a/∂q", &x)?,
            by_velocity: self.square("∂a/∂v", &y)?,
            by_force: self.square("∂a/∂τ", &z)?,
        })
    }

    /// ∂g/∂q; see [`gravity_derivative`](crate::gravity_derivative).
    pub fn gravity_derivative(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        check_configuration(self, q)?;
        self.matrix("∂g/∂q", self.nv, |w, m| crate::gravity_derivative(self, w, q, m))
    }

    fn square(&self, quantity: &'static str, entries: &[f64]) -> Result<DMatrix<f64>> {
        check_result(quantity, entries)?;
        Ok(DMatrix::from_row_slice(self.nv, self.nv, entries))
    }

    fn check_state(&self, q: &[f64], v: &[f64]) -> Result<()> {
        check_configuration(self, q)?;
        Ok(check_vector(self, "v", v)?)
    }

    fn check_has_mass(&self) -> Result<()> {
        if self.mass() > 0.0 {
            return Ok(());
        }
        Err(MotionError::NoMass { robot: self.name().to_owned() })
    }

    fn vector(
        &self,
        quantity: &'static str,
        compute: impl FnOnce(&mut Workspace, &mut [f64]),
    ) -> Result<DVector<f64>> {
        let mut vector = DVector::zeros(self.nv);
        compute(&mut Workspace::new(self), vector.as_mut_slice());
        check_result(quantity, vector.as_slice())?;
        Ok(vector)
    }

    fn matrix(
        &self,
        quantity: &'static str,
        rows: usize,
        compute: impl FnOnce(&mut Workspace, &mut [f64]),
    ) -> Result<DMatrix<f64>> {
        let mut entries = vec![0.0; rows * self.nv];
        compute(&mut Workspace::new(self), &mut entries);
        check_result(quantity, &entries)?;
        Ok(DMatrix::from_row_slice(rows, self.nv, &entries))
    }
}
