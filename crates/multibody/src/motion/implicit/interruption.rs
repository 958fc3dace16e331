//! Steps that are interrupted from outside, and leave the state where they began.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use dynamics::IntegratorError;

use super::Implicit;
use crate::contact::Interrupt;
use crate::{Model, StepForces, StepWorkspace};

impl Implicit {
    /// A step ends with [`IntegratorError::Interrupted`] soon after this flag is set, by another thread or a signal's handler. Every loop of the solvers
    /// looks at it. q, v and all that goes on from step to step are then those of the step's start: with the flag cleared the same step can be
    /// taken again. Copies of the stepper share the flag.
    pub(crate) fn with_interrupt(mut self, flag: Arc<AtomicBool>) -> Self {
        self.interrupt = Interrupt::new(flag);
        self.impulses.watch(&self.interrupt);
        if let Some(contacts) = &mut self.contacts {
            contacts.watch(&self.interrupt);
        }
        self
    }

    /// # Errors
    /// [`IntegratorError::Interrupted`] where the flag is set.
    pub(super) fn check_interrupt(&self) -> Result<(), IntegratorError> {
        if self.interrupt.is_set() { Err(IntegratorError::Interrupted) } else { Ok(()) }
    }

    /// A step of h; where it is interrupted, all is as before it.
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
        self.keep(q, v);
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
