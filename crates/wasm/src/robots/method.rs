//! What takes a robot's steps.

use dynamics::{EnergyLedger, Integrator};
use multibody::{
    ConstraintSet, ContactSet, Implicit, Losses, Model, StepForces, StepWorkspace, Stepper, Workspace,
    check_rank, record_step, step,
};

use crate::LabError;
use crate::input::integrator;

/// The name of [`Method::Implicit`] at the page.
pub(crate) const IMPLICIT: &str = "implicit";

/// What a robot's steps have to hold beside its stops: the ground, and the closed loops and couplings of its file.
pub(crate) type Held<'a> = (Option<&'a ContactSet>, &'a ConstraintSet);

/// Damping, springs and friction implicit, stops, ground and loops that hold; or a row of the library's table, without them.
#[derive(Clone, Debug)]
pub(crate) enum Method {
    Implicit(Box<Implicit>),
    Row(Integrator),
}

impl Method {
    pub(crate) fn implicit(model: &Model, (contacts, loops): Held<'_>) -> Self {
        let implicit = Implicit::new(model).with_constraints(model, loops);
        Self::Implicit(Box::new(match contacts {
            Some(contacts) => implicit.with_contacts(model, contacts.clone()),
            None => implicit,
        }))
    }

    pub(crate) fn named(name: &str, model: &Model, held: Held<'_>) -> Result<Self, LabError> {
        if name == IMPLICIT { Ok(Self::implicit(model, held)) } else { Ok(Self::Row(integrator(name)?)) }
    }

    /// Forgets the forces of steps before, for a robot that was placed anew.
    pub(crate) fn start_anew(&mut self, model: &Model, held: Held<'_>) {
        if let Self::Implicit(_) = self {
            *self = Self::implicit(model, held);
        }
    }

    /// By cause, where the method tells them apart.
    pub(crate) fn losses(&self) -> Option<Losses> {
        match self {
            Self::Implicit(implicit) => implicit.losses(),
            Self::Row(_) => None,
        }
    }

    /// One step from there, to be left in (q, v), and its entry into the books.
    #[allow(clippy::too_many_arguments)] // those of a `Stepper`
    pub(crate) fn step(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        stepping: &mut StepWorkspace,
        ledger: &mut EnergyLedger,
        forces: &StepForces<'_>,
        h: f64,
        from: (&[f64], &[f64]),
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), LabError> {
        q.copy_from_slice(from.0);
        v.copy_from_slice(from.1);
        match self {
            Self::Implicit(implicit) => {
                implicit.step(model, stepping, forces, h, q, v)?;
                implicit.record(model, stepping, ledger, from, (q, v), forces, h);
            }
            Self::Row(row) => {
                check_rank(model, workspace, from.0)?;
                step(model, *row, stepping, forces, h, q, v)?;
                record_step(model, stepping, ledger, from, (q, v), forces, h);
            }
        }
        Ok(())
    }
}
