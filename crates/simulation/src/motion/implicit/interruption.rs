//! Interruption of a step; the state returns to the start of the step.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use robot_dynamics_core::Model;
use robot_dynamics_integrators::IntegratorError;

use super::ImplicitIntegrator;
use crate::contact::Interrupt;
use crate::{StepForces, StepWorkspace};

impl ImplicitIntegrator {
    /// Sets a flag that another thread or a signal handler can use to interrupt a step, which then returns
    /// [`IntegratorError::Interrupted`]. Every loop of the solvers checks it. All state is then that of the
    /// start of the step; after the flag is cleared, the same step can be taken again. Copies of the stepper
    /// share the flag.
    pub(crate) fn with_interrupt(mut self, flag: Arc<AtomicBool>) -> Self {
        self.interrupt = Interrupt::new(flag);
        self.impulses.watch(&self.interrupt);
        if let Some(contacts) = &mut self.contacts {
            contacts.watch(&self.interrupt);
        }
        self
    }

    /// # Errors
    /// [`IntegratorError::Interrupted`] if the flag is set.
    pub(super) fn check_interrupt(&self) -> Result<(), IntegratorError> {
        if self.interrupt.is_set() { Err(IntegratorError::Interrupted) } else { Ok(()) }
    }

    /// Takes a step of h, and restores the state if it is interrupted.
    pub(super) fn step_or_go_back(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        if !self.interrupt.is_watched() {
            return self.step_whole(model, workspace, forces, h, (q, v));
        }
        self.store_state(q, v);
        let mut begun = self.begun.take().unwrap_or_else(|| self.kept.clone());
        begun.copy_from(&self.kept);
        let taken = self.step_whole(model, workspace, forces, h, (q, v));
        if taken == Err(IntegratorError::Interrupted) {
            if let Some(contacts) = &mut self.contacts {
                contacts.begin_whole();
            }
            self.kept.copy_from(&begun);
            self.take_back(q, v);
        }
        self.begun = Some(begun);
        taken
    }
}
