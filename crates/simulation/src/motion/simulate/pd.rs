//! Holding a pose: PD control with gravity compensation and torque limits.

use std::borrow::Borrow;

use robot_dynamics_core::{Model, Workspace, check_configuration, check_vector, difference, gravity};

use super::implicit_gains::{ImplicitGains, set_limits};
use super::{Controller, ControllerError, check_controller_input, check_torque};

/// The configuration of the gravity term in [`GravityCompensatedPd`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GravityAt {
    /// g(q\*): constant.
    #[default]
    Target,
    /// g(q) at the current configuration.
    State,
}

/// τ = g + Kp (q\* ⊖ q) − Kd v with diagonal gains. Effort limits clip each coordinate, and τ is 0 on
/// coordinates without a motor ([`Model::actuated_dofs`]), such as those of a floating base. **(MLS §4.5; MR
/// §11.4)**
///
/// g is g(q\*) by default. q\* ⊖ q is [`difference`]; for a quaternion joint it is the rotation vector to the
/// target in body axes.
///
/// [`new`](GravityCompensatedPd::new) borrows the robot as `GravityCompensatedPd<&Model>`.
/// [`owning`](Self::owning) stores an `Arc<Model>` or a `Model`, and the controller then has no lifetime.
///
/// ```
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, neutral};
/// use robot_dynamics::simulation::{Controller, GravityCompensatedPd};
/// use std::sync::Arc;
/// let model = Arc::new(Model::new(random_robot(3, &RandomRobotOptions::default()))?);
/// let (n, q) = (model.nv(), neutral(&model));
/// let mut control = GravityCompensatedPd::owning(Arc::clone(&model), &q, &vec![50.0; n], &vec![5.0; n])?;
/// let held = q.clone();
/// let tau = std::thread::spawn(move || {
///     let mut tau = vec![0.0; n];
///     control.torque(0.0, &held, &vec![0.0; n], &mut tau).map(|()| tau)
/// });
/// let tau = tau.join().expect("no panic")?;
/// // At the target and at rest, τ is the gravity term on actuated coordinates.
/// let weight = model.gravity_forces(&q)?;
/// let expected: Vec<f64> =
///     (0..n).map(|k| if model.actuated_dofs()[k] { weight[k] } else { 0.0 }).collect();
/// assert_eq!(tau, expected);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GravityCompensatedPd<R> {
    model: R,
    workspace: Workspace,
    target: Vec<f64>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    limits: Vec<f64>,
    gravity_at: GravityAt,
    implicit: Option<ImplicitGains>,
    gravity: Vec<f64>,
    error: Vec<f64>,
    peak_demand: Vec<f64>,
}

impl<'a> GravityCompensatedPd<&'a Model> {
    /// Holds `target`. The diagonals of Kp \[N·m/rad or N/m\] and Kd have nv entries. The limits are the
    /// joints' effort limits.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if the target is an invalid configuration, or if a gain vector has the
    /// wrong length or an entry that is not finite.
    pub fn new(
        model: &'a Model,
        target: &[f64],
        stiffness: &[f64],
        damping: &[f64],
    ) -> Result<Self, ControllerError> {
        Self::owning(model, target, stiffness, damping)
    }
}

impl<R: Borrow<Model>> GravityCompensatedPd<R> {
    /// [`new`](GravityCompensatedPd::new) with a robot that the controller stores: an `Arc<Model>`, a `Model`, or a reference.
    ///
    /// # Errors
    /// As [`new`](GravityCompensatedPd::new).
    pub fn owning(
        robot: R,
        target: &[f64],
        stiffness: &[f64],
        damping: &[f64],
    ) -> Result<Self, ControllerError> {
        let model: &Model = robot.borrow();
        check_configuration(model, target)?;
        check_vector(model, "the stiffness", stiffness)?;
        check_vector(model, "the damping", damping)?;
        let nv = model.nv();
        let mut workspace = Workspace::new(model);
        let mut weight = vec![0.0; nv];
        gravity(model, &mut workspace, target, &mut weight);
        Ok(Self {
            workspace,
            target: target.to_vec(),
            stiffness: stiffness.to_vec(),
            damping: damping.to_vec(),
            limits: model.coordinate_limits().iter().map(|limits| limits.effort).collect(),
            gravity_at: GravityAt::Target,
            implicit: None,
            gravity: weight,
            error: vec![0.0; nv],
            peak_demand: vec![0.0; nv],
            model: robot,
        })
    }

    /// Sets the configuration of the gravity term.
    #[must_use]
    pub fn with_gravity_at(mut self, gravity_at: GravityAt) -> Self {
        self.gravity_at = gravity_at;
        self
    }

    /// Replaces the joints' effort limits; nv entries \[N·m or N\].
    ///
    /// # Panics
    /// Panics if the length is wrong, or a limit is negative or NaN.
    #[must_use]
    #[track_caller]
    pub fn with_limits(mut self, limits: &[f64]) -> Self {
        set_limits(&mut self.limits, limits);
        self
    }

    /// Applies the gains at the end of the period h \[s\] in which the torque is held: see [`ImplicitGains`].
    /// The law is then stable for any stiffness and damping.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Controller, GravityCompensatedPd};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let hold = || GravityCompensatedPd::new(&model, &[0.5], &[1e8], &[0.0]);
    /// let (mut explicit, mut implicit) = (hold()?, hold()?.with_implicit_gains(1e-3)?);
    /// let [mut large, mut small] = [[0.0]; 2];
    /// explicit.torque(0.0, &[0.4], &[0.0], &mut large)?;
    /// implicit.torque(0.0, &[0.4], &[0.0], &mut small)?;
    /// // The torque that brings 0.5 kg m² by 0.1 rad to the target in 1 ms is 5e4 N m.
    /// assert!(large[0] > 9e6 && small[0] < 6e4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if h is not positive, or a gain is negative.
    pub fn with_implicit_gains(mut self, period: f64) -> Result<Self, ControllerError> {
        self.implicit =
            Some(ImplicitGains::new(self.model.borrow(), &self.stiffness, &self.damping, period)?);
        Ok(self)
    }

    /// The largest |τ| before the limits, per coordinate, over all calls \[N·m or N\].
    pub fn peak_demand(&self) -> &[f64] {
        &self.peak_demand
    }

    /// The coordinates whose limit is below |g(q\*)|. If there are any, the pose cannot be held. Coordinates
    /// without a motor are excluded.
    pub fn overloaded_coordinates(&self) -> Vec<usize> {
        let model: &Model = self.model.borrow();
        let mut weight = vec![0.0; self.limits.len()];
        gravity(model, &mut Workspace::new(model), &self.target, &mut weight);
        let actuated = model.actuated_dofs();
        (0..weight.len()).filter(|&k| actuated[k] && weight[k].abs() > self.limits[k]).collect()
    }
}

impl<R: Borrow<Model>> Controller for GravityCompensatedPd<R> {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        let model: &Model = self.model.borrow();
        check_controller_input(model, t, q, v)?;
        if self.gravity_at == GravityAt::State {
            gravity(model, &mut self.workspace, q, &mut self.gravity);
        }
        difference(model, q, &self.target, &mut self.error);
        for k in 0..tau.len() {
            tau[k] = self.gravity[k] + self.stiffness[k] * self.error[k] - self.damping[k] * v[k];
        }
        for (tau, _) in tau.iter_mut().zip(model.actuated_dofs()).filter(|(_, actuated)| !**actuated) {
            *tau = 0.0;
        }
        if let Some(gains) = &mut self.implicit {
            gains.apply(model, &mut self.workspace, q, v, tau)?;
        }
        // The check precedes the limits, which would hide an infinity.
        check_torque(tau)?;
        for ((tau, limit), peak) in tau.iter_mut().zip(&self.limits).zip(&mut self.peak_demand) {
            *peak = peak.max(tau.abs());
            *tau = tau.clamp(-limit, *limit);
        }
        Ok(())
    }
}
