//! The memory of a simulation's steps, and the steps of the states of controllers and motors.

use robot_dynamics_core::{Model, difference, integrate};

use super::method::{SimulationStepper, StepperKind};
use crate::{Actuation, ActuationWorkspace};

#[derive(Clone, Debug)]
pub(super) struct SimulationMemory {
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    /// The mean acceleration of the last step.
    pub(super) acceleration: Vec<f64>,
    /// The velocity at the start of a step.
    pub(super) before: Vec<f64>,
    /// The torques after effort limits, with the wrenches added.
    pub(super) tau: Vec<f64>,
    pub(super) applied: Vec<f64>,
    /// The activations in the middle of the step.
    pub(super) middle: Vec<f64>,
    pub(super) states: Option<ControllerSteps>,
    pub(super) jacobian: Vec<f64>,
}

impl SimulationMemory {
    /// Records the mean acceleration of a step of length h.
    pub(super) fn record_acceleration(&mut self, h: f64) {
        let Self { acceleration, before, v, .. } = self;
        for (k, acceleration) in acceleration.iter_mut().enumerate() {
            *acceleration = (v[k] - before[k]) / h;
        }
    }
}

/// Advances the states of controllers and motors, which depend on the motion.
///
/// Explicit steps with actuators and adaptive steps integrate them with the motion. Here they are advanced
/// beside other steps: over half a step from the state at its start, for the forces in its middle, and then
/// over the step with the motion in its middle. For `mujoco` it is the motion at the start of the step.
#[derive(Clone, Debug)]
pub(super) struct ControllerSteps {
    memory: ActuationWorkspace,
    /// The state at the start of the step.
    q: Vec<f64>,
    v: Vec<f64>,
    /// The state in its middle.
    middle_q: Vec<f64>,
    middle_v: Vec<f64>,
}

impl ControllerSteps {
    /// `None` without such states.
    pub(super) fn new(actuation: &Actuation, nq: usize, nv: usize) -> Option<Self> {
        (actuation.state_count() > 0).then(|| Self {
            memory: actuation.workspace(),
            q: vec![0.0; nq],
            v: vec![0.0; nv],
            middle_q: vec![0.0; nq],
            middle_v: vec![0.0; nv],
        })
    }

    /// Stores the state at the start of a step, and writes the states after a time `half` \[s\] to the
    /// activations in its middle.
    pub(super) fn begin(
        &mut self,
        (model, actuation): (&Model, &Actuation),
        (q, v): (&[f64], &[f64]),
        half: f64,
        (activations, middle): (&[f64], &mut [f64]),
    ) {
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        actuation.evaluate(model, &mut self.memory, activations, q, v);
        let count = actuation.control_count();
        middle[count..].copy_from_slice(&activations[count..]);
        actuation.evolve_states(&self.memory, half, &mut middle[count..]);
    }

    /// Advances the states over a step of this length \[s\] that ended at (q, v).
    pub(super) fn end(
        &mut self,
        (model, actuation): (&Model, &Actuation),
        (stepper, length): (&SimulationStepper, f64),
        (q, v): (&[f64], &[f64]),
        (activations, middle): (&mut [f64], &[f64]),
    ) {
        let Self { memory, q: first_q, v: first_v, middle_q, middle_v } = self;
        let count = actuation.control_count();
        match &stepper.kind {
            StepperKind::Actuated(stepper) => return stepper.copy_states(length, &mut activations[count..]),
            StepperKind::Mujoco(_) => actuation.evaluate(model, memory, activations, first_q, first_v),
            _ => {
                difference(model, first_q, q, middle_v);
                for way in middle_v.iter_mut() {
                    *way *= 0.5;
                }
                integrate(model, first_q, middle_v, middle_q);
                for k in 0..v.len() {
                    middle_v[k] = 0.5 * (first_v[k] + v[k]);
                }
                actuation.evaluate(model, memory, middle, middle_q, middle_v);
            }
        }
        actuation.evolve_states(memory, length, &mut activations[count..]);
    }
}
