//! Computed torque: inverse dynamics of the reference motion with feedback through M.

use std::borrow::Borrow;

use robot_dynamics_core::{
    Model, Workspace, check_configuration, check_vector, difference, dissipation, inverse_dynamics,
};
use robot_dynamics_simulation::motion::simulate::{check_controller_input, check_torque};
use robot_dynamics_simulation::{Controller, ControllerError, IntoCallbackResult};

use super::actuated_part::ActuatedPart;

/// The reference of a motion at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// q\*, nq.
    pub q: Vec<f64>,
    /// v\*, nv \[rad/s or m/s\].
    pub v: Vec<f64>,
    /// a\*, nv.
    pub a: Vec<f64>,
}

/// τ = M(q)(a\* + Kp (q\* ⊖ q) + Kd (v\* − v)) + C v + g + b with diagonal gains. **(MLS §4.5; MR §11.4)**
///
/// The error of coordinates without quaternions then obeys ë + Kd ė + Kp e = 0 for any robot. Optionally, the
/// joints' damping and friction are compensated.
///
/// Coordinates without a motor ([`Model::actuated_dofs`]), such as those of a floating base, get no torque.
/// Without contacts they accelerate with a_u = −M_uu⁻¹(M_ua a_a + h_u). The torque accounts for this: the
/// error of the actuated coordinates still obeys ë + Kd ė + Kp e = 0. The entries of q\*, v\* and a\* for the
/// others are ignored. **(Spong 1994)** For a robot that stands on the ground see
/// [`supported_inverse_dynamics`](robot_dynamics_simulation::supported_inverse_dynamics).
///
/// [`new`](ComputedTorque::new) borrows the robot; [`owning`](Self::owning) stores it, for example as an `Arc<Model>`.
#[derive(Clone, Debug)]
pub struct ComputedTorque<M, F> {
    model: M,
    workspace: Workspace,
    reference: F,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    with_dissipation: bool,
    error: Vec<f64>,
    acceleration: Vec<f64>,
    part: Option<ActuatedPart>,
}

impl<'a, F, R> ComputedTorque<&'a Model, F>
where
    F: FnMut(f64) -> R,
    R: IntoCallbackResult<Reference>,
{
    /// Follows `reference(t)`, which returns a [`Reference`] or a `Result` of one. Kp \[1/s²\] and Kd \[1/s\]
    /// have nv entries; Kd = 2 √Kp is critically damped.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if a gain vector has the wrong length or an entry that is not finite.
    pub fn new(
        model: &'a Model,
        reference: F,
        stiffness: &[f64],
        damping: &[f64],
    ) -> Result<Self, ControllerError> {
        Self::owning(model, reference, stiffness, damping)
    }
}

impl<M, F, R> ComputedTorque<M, F>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> R,
    R: IntoCallbackResult<Reference>,
{
    /// [`new`](ComputedTorque::new) with a robot that the controller stores: an `Arc<Model>`, a `Model`, or a reference.
    ///
    /// # Errors
    /// As [`new`](ComputedTorque::new).
    pub fn owning(
        robot: M,
        reference: F,
        stiffness: &[f64],
        damping: &[f64],
    ) -> Result<Self, ControllerError> {
        let model: &Model = robot.borrow();
        let nv = model.nv();
        check_vector(model, "the stiffness", stiffness)?;
        check_vector(model, "the damping", damping)?;
        Ok(Self {
            workspace: Workspace::new(model),
            reference,
            stiffness: stiffness.to_vec(),
            damping: damping.to_vec(),
            with_dissipation: false,
            error: vec![0.0; nv],
            acceleration: vec![0.0; nv],
            part: ActuatedPart::new(model),
            model: robot,
        })
    }

    /// Compensates the joints' damping and friction.
    #[must_use]
    pub fn with_dissipation(mut self) -> Self {
        self.with_dissipation = true;
        self
    }
}

impl<M: Borrow<Model>, F> ComputedTorque<M, F> {
    /// Writes τ for the state (q, v) and this reference at the time t \[s\], instead of that of the function.
    /// It does not allocate.
    ///
    /// ```
    /// use robot_dynamics::control::{ComputedTorque, Reference};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let still = Reference { q: vec![0.0], v: vec![0.0], a: vec![0.0] };
    /// let mut control = ComputedTorque::new(&model, |_t| still.clone(), &[100.0], &[20.0])?;
    /// let mut tau = [0.0];
    /// control.torque_toward(&still, 0.0, &[0.0], &[0.0], &mut tau)?;
    /// assert!((tau[0] + 2.0 * 9.81 * 0.5).abs() < 1e-12); // the weight
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ControllerError`] if an argument is invalid, or τ is not finite.
    ///
    /// # Panics
    /// Panics if τ has the wrong length.
    pub fn torque_toward(
        &mut self,
        reference: &Reference,
        t: f64,
        q: &[f64],
        v: &[f64],
        tau: &mut [f64],
    ) -> Result<(), ControllerError> {
        let model: &Model = self.model.borrow();
        check_controller_input(model, t, q, v)?;
        let Reference { q: q_wanted, v: v_wanted, a } = reference;
        check_configuration(model, q_wanted).map_err(|error| error.of("the reference's q"))?;
        check_vector(model, "the reference's v", v_wanted)?;
        check_vector(model, "the reference's a", a)?;
        let nv = model.nv();
        difference(model, q, q_wanted, &mut self.error);
        for k in 0..nv {
            self.acceleration[k] =
                a[k] + self.stiffness[k] * self.error[k] + self.damping[k] * (v_wanted[k] - v[k]);
        }
        if let Some(part) = &mut self.part {
            part.factor(model, &mut self.workspace, q)?;
            part.clear_unactuated(&mut self.acceleration);
        }
        inverse_dynamics(model, &mut self.workspace, q, v, &self.acceleration, tau);
        if self.with_dissipation {
            dissipation(model, v, &mut self.error);
            tau.iter_mut().zip(&self.error).for_each(|(tau, b)| *tau += b);
        }
        if let Some(part) = &mut self.part {
            part.reduce(tau);
        }
        Ok(check_torque(tau)?)
    }
}

impl<M, F, R> Controller for ComputedTorque<M, F>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> R,
    R: IntoCallbackResult<Reference>,
{
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        check_controller_input(self.model.borrow(), t, q, v)?;
        let reference = (self.reference)(t).outcome()?;
        self.torque_toward(&reference, t, q, v, tau)
    }
}
