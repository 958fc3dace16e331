//! The motion as one first-order equation: ẏ = (N(q) v, a, τ·v, b·v).

use std::cell::RefCell;

use differential_equations::prelude::ODE;
use dynamics::{DynamicsError, IntegratorError};

use super::super::{Controller, ControllerError, RunError};
use super::error::AdaptiveStepError;
use crate::space::configuration_rate::configuration_rate;
use crate::{
    Actuation, ActuationWorkspace, Model, Workspace, dissipation, forward_dynamics, normalize_quaternions,
};

/// y = (q, v, W, D): configuration, velocity, work of τ, and what damping took out, these two in units of [`energy`](Self::energy).
///
/// Quaternions in y are four numbers whose length the equation keeps and the steps keep to their tolerance; every
/// force is computed at the unit quaternion, so the length acts back on nothing.
pub(super) struct Motion<'a, 'c> {
    pub model: &'a Model,
    pub dissipation: bool,
    /// The unit of the energy account \[J\]: an implicit step is solved for to one absolute error in all of y.
    pub energy: f64,
    scratch: RefCell<Scratch<'c>>,
}

/// Adds generalized forces at q.
type Wrenches<'c> = &'c mut dyn FnMut(&[f64], &mut [f64]);

/// Inputs that act on the joints from outside.
#[derive(Default)]
pub(crate) struct Applied<'c> {
    /// Asked at every evaluation; `None` while τ is held.
    pub(crate) controller: Option<&'c mut dyn Controller>,
    /// τ where it is held.
    pub(crate) torques: &'c [f64],
    /// The limits of |τ|, where they act.
    pub(crate) effort: Option<&'c [f64]>,
    /// Adds the generalized forces of wrenches at q.
    pub(crate) wrenches: Option<Wrenches<'c>>,
    /// Actuators, tendons, further springs and carried weight.
    pub(crate) driven: Option<Driven>,
}

/// What acts beside τ by laws of the state, under controls that are held.
#[derive(Clone, Debug)]
pub(crate) struct Driven {
    pub(super) actuation: Actuation,
    pub(super) memory: ActuationWorkspace,
    controls: Vec<f64>,
    /// The activations at the time `start` \[s\].
    activations: Vec<f64>,
    pub(super) start: f64,
    /// Those of an evaluation.
    now: Vec<f64>,
    /// The generalized forces of all, and of the actuators.
    force: Vec<f64>,
    pub(super) torques: Vec<f64>,
}

impl Driven {
    pub(super) fn new(actuation: Actuation, nv: usize) -> Self {
        let zeros = || vec![0.0; actuation.control_count()];
        Self {
            memory: actuation.workspace(),
            controls: zeros(),
            activations: zeros(),
            start: 0.0,
            now: zeros(),
            force: vec![0.0; nv],
            torques: vec![0.0; nv],
            actuation,
        }
    }

    /// Holds these controls from now on, at these activations.
    pub(super) fn set_controls(&mut self, controls: &[f64], activations: &[f64]) {
        self.controls.copy_from_slice(controls);
        self.activations.copy_from_slice(activations);
    }

    /// Adds all forces at t to τ; returns the power that is put in, and the one that is lost \[W\].
    fn add_to(&mut self, model: &Model, (t, q, v): (f64, &[f64], &[f64]), tau: &mut [f64]) -> (f64, f64) {
        self.actuate(model, (t, q, v));
        let Self { actuation, memory, force, torques, .. } = self;
        force.copy_from_slice(torques);
        actuation.add_passive(memory, q, v, force);
        tau.iter_mut().zip(&*force).for_each(|(tau, force)| *tau += force);
        force.copy_from_slice(torques);
        actuation.add_unstored(memory, force);
        (force.iter().zip(v).map(|(force, v)| force * v).sum(), actuation.dissipated_power(q, v))
    }

    /// Leaves the actuators' forces at t in the memory.
    pub(super) fn actuate(&mut self, model: &Model, (t, q, v): (f64, &[f64], &[f64])) {
        let Self { actuation, memory, controls, activations, start, now, torques, .. } = self;
        now.copy_from_slice(activations);
        if t > *start {
            actuation.activate(controls, t - *start, now);
        }
        actuation.actuator_torques(model, memory, now, q, v, torques);
    }
}

impl<'c> Applied<'c> {
    /// These torques alone.
    pub(crate) fn held(torques: &'c [f64]) -> Self {
        Self { torques, ..Self::default() }
    }
}

struct Scratch<'c> {
    workspace: Workspace,
    applied: Applied<'c>,
    /// As asked for, and within the limits.
    asked: Vec<f64>,
    tau: Vec<f64>,
    /// With the wrenches.
    total: Vec<f64>,
    q: Vec<f64>,
    lost: Vec<f64>,
    force: Vec<f64>,
    evaluations: usize,
    /// What first went wrong in the last evaluations.
    trouble: Option<Trouble>,
}

/// Why there is no rate at a state, or no step from it.
#[derive(Clone, Debug)]
pub(super) enum Trouble {
    /// Entry so of this quantity is not finite.
    NotFinite(&'static str, usize),
    /// The controller failed.
    Controller(ControllerError),
    /// No step is small enough, or too many were taken.
    Step(AdaptiveStepError),
}

impl Trouble {
    /// The first entry that is not finite.
    pub(super) fn of(quantity: &'static str, x: &[f64]) -> Option<Self> {
        x.iter().position(|x| !x.is_finite()).map(|index| Self::NotFinite(quantity, index))
    }

    /// As an error of a run at a time, after so many steps of the run.
    pub(super) fn at(self, model: &Model, time: f64, step: usize) -> RunError<AdaptiveStepError> {
        match self {
            Self::NotFinite(quantity, index) => {
                let coordinate = model.coordinate_names().get(index).cloned().unwrap_or_default();
                RunError::NotFinite { quantity, coordinate, step, time }
            }
            Self::Controller(source) => RunError::Controller { step, time, source },
            Self::Step(source) => RunError::Step { step, time, source },
        }
    }

    /// As an error of a step.
    pub(super) fn of_step(self) -> AdaptiveStepError {
        match self {
            Self::NotFinite(quantity, index) => {
                IntegratorError::Dynamics(DynamicsError::NonFinite { quantity, index }).into()
            }
            // Held torques have no controller.
            Self::Controller(_) => IntegratorError::Interrupted.into(),
            Self::Step(error) => error,
        }
    }
}

impl<'a, 'c> Motion<'a, 'c> {
    pub(super) fn new(model: &'a Model, dissipation: bool, energy: f64, applied: Applied<'c>) -> Self {
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
                trouble: None,
                applied,
            }),
        };
        let torques = motion.scratch.borrow().applied.torques;
        motion.hold(torques);
        motion
    }

    /// Takes the controller, which is then asked no more.
    pub(super) fn take_controller(&self) -> Option<&'c mut dyn Controller> {
        self.scratch.borrow_mut().applied.controller.take()
    }

    /// Holds τ.
    pub(super) fn hold(&self, tau: &[f64]) {
        let mut scratch = self.scratch.borrow_mut();
        scratch.asked.copy_from_slice(tau);
        scratch.bound();
    }

    /// τ at a state: the controller's, or what is held; within the limits.
    pub(super) fn torque(&self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), Trouble> {
        let mut scratch = self.scratch.borrow_mut();
        scratch.ask(t, q, v).map_err(Trouble::Controller)?;
        tau.copy_from_slice(&scratch.tau);
        Trouble::of(TORQUE, &scratch.asked).map_or(Ok(()), Err)
    }

    /// Counts the torques that were cut off when they were asked for last.
    pub(super) fn count_limited(&self, limited: &mut [usize]) {
        let scratch = self.scratch.borrow();
        for (k, count) in limited.iter_mut().enumerate() {
            *count += usize::from(scratch.tau[k] != scratch.asked[k]);
        }
    }

    /// The acceleration at y.
    #[allow(clippy::ptr_arg)] // the methods' type of state
    pub(super) fn acceleration(&self, t: f64, y: &Vec<f64>, acceleration: &mut [f64]) {
        let mut rate = vec![0.0; y.len()];
        self.diff(t, y, &mut rate);
        let nq = self.model.nq();
        acceleration.copy_from_slice(&rate[nq..nq + acceleration.len()]);
    }

    pub(super) fn evaluations(&self) -> usize {
        self.scratch.borrow().evaluations
    }

    /// What first went wrong since this was asked last.
    pub(super) fn take_trouble(&self) -> Option<Trouble> {
        self.scratch.borrow_mut().trouble.take()
    }

    /// (q with unit quaternions, v) of y.
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
    /// τ of the controller, if there is one.
    fn ask(&mut self, t: f64, q: &[f64], v: &[f64]) -> Result<(), ControllerError> {
        let Some(controller) = &mut self.applied.controller else { return Ok(()) };
        controller.torque(t, q, v, &mut self.asked)?;
        self.bound();
        Ok(())
    }

    /// Cuts the torques off at their limits.
    fn bound(&mut self) {
        self.tau.copy_from_slice(&self.asked);
        if let Some(effort) = self.applied.effort {
            for (tau, limit) in self.tau.iter_mut().zip(effort) {
                *tau = tau.clamp(-limit.max(0.0), limit.max(0.0));
            }
        }
    }
}

/// What a torque is called in errors.
pub(super) const TORQUE: &str = "the controller's torque";

impl ODE<f64, Vec<f64>> for Motion<'_, '_> {
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
            // No rate: the step is taken back.
            scratch.trouble.get_or_insert(Trouble::Controller(error));
            rate.fill(f64::NAN);
            return;
        }
        let Scratch { workspace, applied, asked, tau, total, q, lost, force, trouble, .. } = &mut *scratch;
        total.copy_from_slice(tau);
        if let Some(wrenches) = &mut applied.wrenches {
            wrenches(q, total);
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (q_rate, rest) = rate.split_at_mut(nq);
        let (acceleration, account) = rest.split_at_mut(nv);
        account.copy_from_slice(&[dot(total, v) / self.energy, 0.0]);
        if let Some(driven) = &mut applied.driven {
            let (power, losses) = driven.add_to(model, (t, q, v), total);
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
        // The raw quaternion: then its length stays exactly what it is.
        configuration_rate(model, &y[..nq], v, q_rate);
        forward_dynamics(model, workspace, q, v, force, acceleration);
        if trouble.is_none() {
            *trouble = Trouble::of(TORQUE, asked).or_else(|| Trouble::of("the acceleration", acceleration));
        }
    }
}
