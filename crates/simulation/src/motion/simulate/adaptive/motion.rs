//! The motion as one first-order equation: ẏ = (N(q) v, a, ẋ, τ·v, b·v).

use std::cell::RefCell;

use differential_equations::prelude::ODE;
use robot_dynamics_core::configuration::configuration_rate::configuration_rate;
use robot_dynamics_core::{Model, Workspace, dissipation, forward_dynamics, normalize_quaternions};
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::InvalidInput;

use super::super::{Controller, ControllerError, RunError, StepError, check_input_torque};
use crate::{Actuation, ActuationWorkspace};

/// The state is y = (q, v, x, W, D): configuration, velocity, states of controllers and motors, work of τ,
/// and dissipated energy. The last two are in units of [`energy`](Self::energy).
///
/// Quaternions in y are four numbers. The equation preserves their length exactly, the steps to their
/// tolerance. All forces are computed at the unit quaternion, so an error of the length has no effect on the
/// motion.
pub(super) struct AdaptiveSystem<'a, 'c> {
    pub model: &'a Model,
    pub dissipation: bool,
    /// The unit of the energy account \[J\]. An implicit step is solved to one absolute error in all entries
    /// of y.
    pub energy: f64,
    scratch: RefCell<Scratch<'c>>,
}

/// Adds generalized forces at q.
type Wrenches<'c> = &'c mut dyn FnMut(&[f64], &mut [f64]);

/// External inputs of the joints.
#[derive(Default)]
pub struct ExternalInputs<'c> {
    /// Called at every evaluation; `None` while τ is held.
    pub(crate) controller: Option<&'c mut dyn Controller>,
    /// The held τ.
    pub torques: &'c [f64],
    /// The limits of |τ|, if they act.
    pub effort: Option<&'c [f64]>,
    /// Adds the generalized forces of wrenches at q.
    pub wrenches: Option<Wrenches<'c>>,
    /// Actuators, tendons, further springs and gravity compensation.
    pub driven: Option<HeldActuation>,
}

/// State-dependent forces in addition to τ, under held controls.
#[derive(Clone, Debug)]
pub struct HeldActuation {
    pub(super) actuation: Actuation,
    pub(super) memory: ActuationWorkspace,
    controls: Vec<f64>,
    /// The activations at the time `start` \[s\].
    activations: Vec<f64>,
    pub(super) start: f64,
    /// The activations at an evaluation.
    now: Vec<f64>,
    /// The states of controllers and motors at an evaluation.
    states: Vec<f64>,
    /// The generalized forces of all effects, and of the actuators alone.
    force: Vec<f64>,
    pub(super) torques: Vec<f64>,
}

impl HeldActuation {
    pub(super) fn new(actuation: Actuation, nv: usize) -> Self {
        let zeros = || vec![0.0; actuation.activation_count()];
        Self {
            memory: actuation.workspace(),
            controls: vec![0.0; actuation.control_count()],
            activations: zeros(),
            start: 0.0,
            now: zeros(),
            states: vec![0.0; actuation.state_count()],
            force: vec![0.0; nv],
            torques: vec![0.0; nv],
            actuation,
        }
    }

    /// Holds these controls, starting with these activations.
    pub(super) fn set_controls(&mut self, controls: &[f64], activations: &[f64]) {
        self.controls.copy_from_slice(controls);
        self.activations.copy_from_slice(activations);
        self.states.copy_from_slice(&activations[self.controls.len()..]);
    }

    /// The states of controllers and motors.
    pub(super) fn states(&self) -> &[f64] {
        &self.states
    }

    /// Sets the states of controllers and motors from y, which has the energy account as its last two
    /// entries.
    pub(super) fn set_states(&mut self, y: &[f64]) {
        let (end, count) = (y.len() - 2, self.states.len());
        self.states.copy_from_slice(&y[end - count..end]);
    }

    /// The rates of these states at the last evaluation.
    fn state_rates(&self) -> &[f64] {
        self.memory.state_rates()
    }

    /// Adds all forces at t to τ; returns the power that is supplied and the power that is dissipated \[W\].
    fn add_to(&mut self, model: &Model, (t, q, v): (f64, &[f64], &[f64]), tau: &mut [f64]) -> (f64, f64) {
        self.actuate(model, (t, q, v));
        let Self { actuation, memory, force, torques, .. } = self;
        force.copy_from_slice(torques);
        actuation.add_passive(model, memory, (q, v), force);
        tau.iter_mut().zip(&*force).for_each(|(tau, force)| *tau += force);
        force.copy_from_slice(torques);
        actuation.add_unstored(memory, force);
        let lost = actuation.dissipated_power(model, memory, q, v);
        (force.iter().zip(v).map(|(force, v)| force * v).sum(), lost)
    }

    /// Evaluates the actuators' forces at t.
    pub(super) fn actuate(&mut self, model: &Model, (t, q, v): (f64, &[f64], &[f64])) {
        let Self { actuation, memory, controls, activations, start, now, states, torques, .. } = self;
        now.copy_from_slice(activations);
        now[controls.len()..].copy_from_slice(states);
        if t > *start {
            actuation.activate(controls, t - *start, now);
        }
        actuation.actuator_torques(model, memory, now, q, v, torques);
    }
}

impl<'c> ExternalInputs<'c> {
    /// Applies only these torques.
    pub fn held(torques: &'c [f64]) -> Self {
        Self { torques, ..Self::default() }
    }
}

struct Scratch<'c> {
    workspace: Workspace,
    applied: ExternalInputs<'c>,
    /// The requested torques after effort limits.
    asked: Vec<f64>,
    tau: Vec<f64>,
    /// The torques with the wrenches added.
    total: Vec<f64>,
    q: Vec<f64>,
    lost: Vec<f64>,
    force: Vec<f64>,
    evaluations: usize,
    /// The first failure in the last evaluations.
    failure: Option<MotionFailure>,
}

/// The cause of a missing rate or step.
#[derive(Clone, Debug)]
pub(super) enum MotionFailure {
    /// The entry with this index of this quantity is not finite.
    NotFinite(&'static str, usize),
    /// A torque is not finite.
    Input(InvalidInput),
    /// The controller failed.
    Controller(ControllerError),
    /// The step became too small, or there were too many steps.
    Step(StepError),
}

impl MotionFailure {
    /// The failure for the first entry that is not finite, if any.
    pub(super) fn of(quantity: &'static str, x: &[f64]) -> Option<Self> {
        x.iter().position(|x| !x.is_finite()).map(|index| Self::NotFinite(quantity, index))
    }

    /// The failure for the first torque that is not finite, if any.
    pub(super) fn of_torque(model: &Model, tau: &[f64]) -> Option<Self> {
        check_input_torque(model, tau).err().map(Self::Input)
    }

    /// Converts to the error of a run at a time, after a number of steps.
    pub(super) fn at(self, model: &Model, time: f64, step: usize) -> RunError {
        match self {
            Self::NotFinite(quantity, index) => {
                let coordinate = model.coordinate_names().get(index).cloned().unwrap_or_default();
                RunError::NotFinite { quantity, coordinate, step, time }
            }
            Self::Input(source) => RunError::StepInput { step, time, source },
            Self::Controller(source) => RunError::Controller { step, time, source },
            Self::Step(source) => RunError::Step { step, time, source },
        }
    }

    /// Converts to the error of a step.
    pub(super) fn of_step(self) -> StepError {
        match self {
            Self::NotFinite(quantity, index) => IntegratorError::NotFinite { quantity, index }.into(),
            Self::Input(error) => error.into(),
            // This branch is unreachable: with held torques there is no controller.
            Self::Controller(_) => IntegratorError::Interrupted.into(),
            Self::Step(error) => error,
        }
    }
}

impl<'a, 'c> AdaptiveSystem<'a, 'c> {
    pub(super) fn new(model: &'a Model, dissipation: bool, energy: f64, applied: ExternalInputs<'c>) -> Self {
        let nothing = vec![0.0; model.nv()];
        let motion = Self {
            model,
            dissipation,
            energy,
            scratch: RefCell::new(Scratch {
                workspace: Workspace::new(model),
                asked: nothing.clone(),
                tau: nothing.clone(),
                total: nothing.clone(),
                q: vec![0.0; model.nq()],
                lost: nothing.clone(),
                force: nothing,
                evaluations: 0,
                failure: None,
                applied,
            }),
        };
        let torques = motion.scratch.borrow().applied.torques;
        motion.set_torques(torques);
        motion
    }

    /// Removes the controller; it is not called again.
    pub(super) fn take_controller(&self) -> Option<&'c mut dyn Controller> {
        self.scratch.borrow_mut().applied.controller.take()
    }

    /// Holds τ at these values.
    pub(super) fn set_torques(&self, tau: &[f64]) {
        let mut scratch = self.scratch.borrow_mut();
        scratch.asked.copy_from_slice(tau);
        scratch.bound();
    }

    /// τ at a state, from the controller or held, after effort limits.
    pub(super) fn torque(&self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), MotionFailure> {
        let mut scratch = self.scratch.borrow_mut();
        scratch.ask(t, q, v).map_err(MotionFailure::Controller)?;
        tau.copy_from_slice(&scratch.tau);
        MotionFailure::of_torque(self.model, &scratch.asked).map_or(Ok(()), Err)
    }

    /// Counts the torques that were clipped in the last evaluation.
    pub(super) fn count_limited(&self, limited: &mut [usize]) {
        let scratch = self.scratch.borrow();
        for (k, count) in limited.iter_mut().enumerate() {
            *count += usize::from(scratch.tau[k] != scratch.asked[k]);
        }
    }

    /// The acceleration at y.
    #[allow(clippy::ptr_arg)] // the state type of the methods
    pub(super) fn acceleration(&self, t: f64, y: &Vec<f64>, acceleration: &mut [f64]) {
        let mut rate = vec![0.0; y.len()];
        self.diff(t, y, &mut rate);
        let nq = self.model.nq();
        acceleration.copy_from_slice(&rate[nq..nq + acceleration.len()]);
    }

    pub(super) fn evaluations(&self) -> usize {
        self.scratch.borrow().evaluations
    }

    /// Returns the first failure since the last call, and clears it.
    pub(super) fn take_failure(&self) -> Option<MotionFailure> {
        self.scratch.borrow_mut().failure.take()
    }

    /// Splits y into q with unit quaternions and v.
    pub(super) fn split(&self, y: &[f64], q: &mut Vec<f64>, v: &mut Vec<f64>) {
        let (nq, nv) = (self.model.nq(), self.model.nv());
        q.clear();
        q.extend_from_slice(&y[..nq]);
        normalize_quaternions(self.model, q);
        v.clear();
        v.extend_from_slice(&y[nq..nq + nv]);
    }
}

impl Scratch<'_> {
    /// Evaluates the controller, if there is one.
    fn ask(&mut self, t: f64, q: &[f64], v: &[f64]) -> Result<(), ControllerError> {
        let Some(controller) = &mut self.applied.controller else { return Ok(()) };
        controller.torque(t, q, v, &mut self.asked)?;
        self.bound();
        Ok(())
    }

    /// Clips the torques to their limits.
    fn bound(&mut self) {
        self.tau.copy_from_slice(&self.asked);
        if let Some(effort) = self.applied.effort {
            for (tau, limit) in self.tau.iter_mut().zip(effort) {
                *tau = tau.clamp(-limit.max(0.0), limit.max(0.0));
            }
        }
    }
}

impl ODE<f64, Vec<f64>> for AdaptiveSystem<'_, '_> {
    fn diff(&self, t: f64, y: &Vec<f64>, rate: &mut Vec<f64>) {
        let model = self.model;
        let (nq, nv) = (model.nq(), model.nv());
        let mut scratch = self.scratch.borrow_mut();
        scratch.evaluations += 1;
        let mut q = core::mem::take(&mut scratch.q);
        q.copy_from_slice(&y[..nq]);
        normalize_quaternions(model, &mut q);
        let v = &y[nq..nq + nv];
        let asked = scratch.ask(t, &q, v);
        scratch.q = q;
        if let Err(error) = asked {
            // The missing rate rejects the step.
            scratch.failure.get_or_insert(MotionFailure::Controller(error));
            rate.fill(f64::NAN);
            return;
        }
        let Scratch { workspace, applied, asked, tau, total, q, lost, force, failure, .. } = &mut *scratch;
        total.copy_from_slice(tau);
        if let Some(wrenches) = &mut applied.wrenches {
            wrenches(q, total);
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (q_rate, rest) = rate.split_at_mut(nq);
        let (acceleration, rest) = rest.split_at_mut(nv);
        let (state_rates, account) = rest.split_at_mut(rest.len() - 2);
        account.copy_from_slice(&[dot(total, v) / self.energy, 0.0]);
        if let Some(driven) = &mut applied.driven {
            driven.set_states(y);
            let (power, losses) = driven.add_to(model, (t, q, v), total);
            state_rates.copy_from_slice(driven.state_rates());
            account[0] += power / self.energy;
            account[1] = losses / self.energy;
        }
        if self.dissipation {
            dissipation(model, v, lost);
            account[1] += dot(lost, v) / self.energy;
            force.iter_mut().zip(&*total).zip(&*lost).for_each(|((f, tau), b)| *f = tau - b);
        } else {
            force.copy_from_slice(total);
        }
        // The quaternion before normalization, whose length then stays exactly constant.
        configuration_rate(model, &y[..nq], v, q_rate);
        forward_dynamics(model, workspace, q, v, force, acceleration);
        if failure.is_none() {
            *failure = MotionFailure::of_torque(model, asked)
                .or_else(|| MotionFailure::of("the acceleration", acceleration));
        }
    }
}
