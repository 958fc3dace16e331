//! Adaptive steps of high order: error control, dense output and events.

mod local_error;
mod method;
mod motion;
mod options;
mod run_loop;
mod statistics;
mod stepper;

pub use method::AdaptiveMethod;
pub use motion::ExternalInputs;
pub(crate) use motion::HeldActuation;
pub use options::{AdaptiveOptions, ControlTiming};
pub use run_loop::AdaptiveRun;
pub use statistics::StepStatistics;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use robot_dynamics_core::algorithms::energy::energies;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::{EnergyAccount, IntegratorError};

use self::motion::{AdaptiveSystem, MotionFailure};
use self::stepper::{AdvanceResult, StepSequence};
use super::{StepError, Stepper};
use crate::{Actuation, StateTransition, StepForces, StepWorkspace};

/// The record of adaptive steps since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct AdaptiveRecord {
    /// The method of the steps: explicit or implicit, once it is chosen.
    pub method: AdaptiveMethod,
    /// The statistics of the steps.
    pub statistics: StepStatistics,
    /// max | |quaternion| − 1 | at the ends of the steps before q is normalized: a measure of the error.
    pub quaternion_error: f64,
}

/// Runge–Kutta steps with error control. One equation integrates the state (q, v) together with the work and
/// the dissipation.
///
/// As a [`Stepper`] it takes as many steps over h as the tolerance requires, with constant forces.
#[derive(Clone, Debug)]
pub struct AdaptiveStepper {
    options: AdaptiveOptions,
    interrupt: Option<Arc<AtomicBool>>,
    pub record: AdaptiveRecord,
    /// Whether the method is chosen.
    is_chosen: bool,
    /// The unit of energy in the equation \[J\].
    energy: f64,
    /// The next step that the tolerance allows \[s\]; 0 if unknown.
    wanted: f64,
    /// Work and dissipation over the last h \[J\].
    last: [f64; 2],
    driven: Option<HeldActuation>,
}

impl AdaptiveStepper {
    pub fn new(options: AdaptiveOptions, interrupt: Option<Arc<AtomicBool>>) -> Self {
        let record = AdaptiveRecord { method: options.method, ..AdaptiveRecord::default() };
        let (energy, wanted, last) = (1.0, 0.0, [0.0; 2]);
        Self { options, interrupt, record, is_chosen: false, energy, wanted, last, driven: None }
    }

    /// Adds tendons, gravity compensation and actuators.
    pub(crate) fn with_actuation(mut self, actuation: &Actuation, nv: usize) -> Self {
        self.driven = Some(HeldActuation::new(actuation.clone(), nv));
        self
    }

    /// Holds these controls, starting with these activations.
    pub(crate) fn set_controls(&mut self, controls: &[f64], activations: &[f64]) {
        if let Some(driven) = &mut self.driven {
            driven.set_controls(controls, activations);
        }
    }

    pub(crate) fn is_driven(&self) -> bool {
        self.driven.is_some()
    }

    /// The states of controllers and motors at the last sample.
    pub(crate) fn controller_states(&self) -> &[f64] {
        self.driven.as_ref().map_or(&[], HeldActuation::states)
    }

    /// The state-dependent forces; the held activations are those at the time `start` \[s\].
    pub(crate) fn driven_from(&mut self, start: f64) -> Option<HeldActuation> {
        let driven = self.driven.as_mut()?;
        driven.start = start;
        Some(driven.clone())
    }

    /// Evaluates the actuators' forces at (t, q, v), and returns the stored energy \[J\].
    fn drive(&mut self, model: &Model, at: (f64, &[f64], &[f64])) -> f64 {
        let Some(driven) = &mut self.driven else { return 0.0 };
        driven.actuate(model, at);
        driven.actuation.stored_energy(&mut driven.memory, at.1)
    }

    /// Chooses between explicit and implicit steps at this state, unless the method is already chosen.
    fn choose(&mut self, model: &Model, workspace: &mut Workspace, (q, v): (&[f64], &[f64]), damping: bool) {
        if core::mem::replace(&mut self.is_chosen, true) {
            return;
        }
        self.record.method = self.options.method.chosen(model, workspace, q, damping);
        self.energy = if self.record.method == AdaptiveMethod::Implicit {
            let (kinetic, potential) = energies(model, workspace, q, v);
            1.0 + (kinetic + potential).abs()
        } else {
            1.0
        };
    }

    fn note_quaternions(&mut self, model: &Model, y: &[f64]) {
        for joint in model.joints().iter().filter(|joint| joint.nq > joint.nv) {
            let four = &y[joint.q_index + joint.nq - 4..joint.q_index + joint.nq];
            let off = (four.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs();
            self.record.quaternion_error = self.record.quaternion_error.max(off);
        }
    }
}

impl Stepper for AdaptiveStepper {
    fn order(&self) -> u32 {
        self.record.method.order()
    }

    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError> {
        crate::motion::integrate::check_step(h)?;
        check_length("q", q.len(), model.nq());
        check_length("v", v.len(), model.nv());
        self.choose(model, &mut workspace.dynamics, (q, v), forces.dissipation);
        let applied = ExternalInputs { driven: self.driven_from(0.0), ..ExternalInputs::held(forces.tau) };
        let motion = AdaptiveSystem::new(model, forces.dissipation, self.energy, applied);
        let y = [&*q, &*v, self.controller_states(), &[0.0, 0.0]].concat();
        let mut steps =
            StepSequence::start(self.record.method, &self.options, self.wanted, &motion, (0.0, h), &y)
                .map_err(MotionFailure::of_step)?;
        let moved = loop {
            match steps.advance(&motion, h, self.interrupt.as_deref()) {
                Ok(AdvanceResult::Moved) if steps.t >= h => break Ok(()),
                Ok(AdvanceResult::Moved) => self.note_quaternions(model, steps.y()),
                Ok(AdvanceResult::Interrupted) => break Err(IntegratorError::Interrupted.into()),
                Err(failure) => break Err(failure.of_step()),
            }
        };
        self.record.statistics.add(&steps.statistics);
        moved?;
        self.note_quaternions(model, steps.y());
        self.wanted = steps.wanted();
        let y = steps.y();
        let (mut end_q, mut end_v) = (Vec::new(), Vec::new());
        motion.split(y, &mut end_q, &mut end_v);
        q.copy_from_slice(&end_q);
        v.copy_from_slice(&end_v);
        if let Some(driven) = &mut self.driven {
            driven.set_states(y);
        }
        self.last = [y[y.len() - 2], y[y.len() - 1]].map(|account| self.energy * account);
        Ok(())
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        let driven = self.driven.as_mut();
        driven.map_or(0.0, |driven| driven.actuation.stored_energy(&mut driven.memory, q))
    }

    /// The forces at the end of the step, not their mean.
    fn actuator_forces(&self) -> &[f64] {
        self.driven.as_ref().map_or(&[], |driven| driven.memory.actuator_forces())
    }

    /// The torques at the end of the step, not their mean.
    fn actuator_torques(&self) -> &[f64] {
        self.driven.as_ref().map_or(&[], |driven| &driven.torques)
    }

    /// Work and dissipation come from the integrated equation.
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        energy_account: &mut EnergyAccount,
        transition: StateTransition<'_>,
    ) {
        let StateTransition { to: (q, v), h, .. } = transition;
        let (kinetic, potential) = energies(model, &mut workspace.dynamics, q, v);
        let stored = self.drive(model, (h, q, v));
        let [work, dissipated] = self.last;
        energy_account.enter(
            kinetic,
            potential + stored,
            energy_account.work() + work,
            energy_account.dissipated() + dissipated,
        );
    }
}
