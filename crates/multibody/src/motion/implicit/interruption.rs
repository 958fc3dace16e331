//! Steps that are interrupted from outside, and leave the state where they began.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use dynamics::IntegratorError;

use super::Implicit;
use super::advance::{PARTS, Whole};
use super::equalities::Equalities;
use crate::contact::Interrupt;
use crate::{Model, StepForces, StepWorkspace};

/// Each trial leaves of the error of the first forces a part of order h.
const TRIALS: usize = 3;

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
            self.kept.copy_from(&begun);
            self.take_back(q, v);
        }
        self.begun = Some(begun);
        taken
    }

    /// Before the first step of all, finds the forces of the equalities with which it begins: a step that begins without them is off by what they do to
    /// light links.
    fn try_equalities(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) {
        if self.equalities.as_ref().is_none_or(Equalities::is_begun) {
            return;
        }
        for _ in 0..TRIALS {
            let taken = self.advance(model, &mut workspace.dynamics, forces.tau, h, (q, v), Whole::AsItIs);
            if let (true, Some(equalities)) = (taken.is_ok(), &mut self.equalities) {
                equalities.note_trial();
            }
            self.take_back(q, v);
            if let Some(equalities) = &mut self.equalities {
                equalities.begin_with_trial();
            }
        }
        self.keep(q, v);
    }

    /// A step of h, in parts where it has to be.
    fn step_whole(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        if let Some(contacts) = &mut self.contacts {
            contacts.memory().clear_impulses();
        }
        if let Some(equalities) = &mut self.equalities {
            equalities.clear_impulses();
        }
        self.keep(q, v);
        self.try_equalities(model, workspace, forces, h, (q, v));
        let taken = self.advance_whole(model, &mut workspace.dynamics, forces.tau, h, (q, v));
        self.check_interrupt()?;
        if taken.is_err()
            || (self.is_suspect(h)
                && self.books_are_off(model, workspace, forces, (h, h / f64::from(PARTS)), (q, v)))
        {
            self.divide(model, workspace, forces, h, (q, v))?;
        }
        if let Some(contacts) = &mut self.contacts {
            contacts.memory().average_impulses(h);
        }
        if let Some(equalities) = &mut self.equalities {
            equalities.average_impulses(h);
        }
        Ok(())
    }
}
