//! Computed torque: the motion's own inverse dynamics, and feedback through M.

use std::borrow::Borrow;

use super::actuated_part::ActuatedPart;
use crate::algorithms::motion_error::check_vector;
use crate::motion::simulate::{check_moment, check_torque};
use crate::{
    Controller, ControllerError, Model, MotionError, Outcome, Workspace, check_configuration, difference,
    dissipation, inverse_dynamics,
};

/// Where a motion should be at a time.
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
/// The error of plain coordinates then obeys ë + Kd ė + Kp e = 0, whatever the robot. The joints' damping and
/// friction are compensated when asked for.
///
/// Coordinates without a motor ([`Model::actuated_dofs`]), a floating base for one, get no torque. They move as they must,
/// a_u = −M_uu⁻¹(M_ua a_a + h_u) where nothing touches the robot, and the torque takes that into account: the error of the actuated
/// coordinates still obeys ë + Kd ė + Kp e = 0. q\*, v\* and a\* of the others are not read. **(Spong 1994)** For a robot that stands on
/// the ground see [`supported_inverse_dynamics`](crate::supported_inverse_dynamics).
///
/// The robot is borrowed ([`new`](ComputedTorque::new)) or kept, as an
/// `Arc<Model>` for one ([`owning`](Self::owning)).
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
    R: Outcome<Reference>,
{
    /// Follows `reference(t)`, a [`Reference`] or a `Result` of one where it can fail; Kp \[1/s²\] and Kd \[1/s\] have nv entries, Kd = 2 √Kp is critically damped.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if a gain vector has the wrong length or a number that is not finite.
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
    R: Outcome<Reference>,
{
    /// [`new`](ComputedTorque::new) with a robot that it keeps: an `Arc<Model>`, a `Model`, or a reference.
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

    /// With the joints' damping and friction compensated.
    #[must_use]
    pub fn with_dissipation(mut self) -> Self {
        self.with_dissipation = true;
        self
    }
}

impl<M, F, R> Controller for ComputedTorque<M, F>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> R,
    R: Outcome<Reference>,
{
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        let model: &Model = self.model.borrow();
        check_moment(model, t, q, v)?;
        let Reference { q: q_wanted, v: v_wanted, a } = (self.reference)(t).outcome()?;
        check_configuration(model, &q_wanted)
            .map_err(MotionError::from)
            .and_then(|()| check_vector(model, "v", &v_wanted))
            .and_then(|()| check_vector(model, "a", &a))
            .map_err(ControllerError::Reference)?;
        let nv = model.nv();
        difference(model, q, &q_wanted, &mut self.error);
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
        check_torque(tau)
    }
}
