//! Steps of a custom method.

use core::fmt;
use core::ops::{Deref, DerefMut};

use robot_dynamics_core::{Model, SingularMass, Workspace};
use robot_dynamics_integrators::{DynamicsError, EnergyLedger, IntegratorError};

use super::MethodError;
use crate::constraints::ConstraintError;
use crate::motion::simulate::{Losses, StepError, StepFault, Stepper};
use crate::{ActiveSet, CallbackError, ContactLaws, StepForces, StepWorkspace};

/// A custom stepper of any type.
pub(super) struct OwnStepper(Box<dyn AnyStepper>);

impl OwnStepper {
    pub(super) fn new<S>(stepper: S) -> Self
    where
        S: Stepper<Error: Send + Sync + 'static> + Clone + Send + Sync + 'static,
    {
        Self(Box::new(Widened(stepper)))
    }
}

impl Clone for OwnStepper {
    fn clone(&self) -> Self {
        Self(self.0.copy())
    }
}

impl Deref for OwnStepper {
    type Target = dyn AnyStepper;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl DerefMut for OwnStepper {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.0
    }
}

impl fmt::Debug for OwnStepper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnStepper").finish_non_exhaustive()
    }
}

/// A cloneable stepper behind a pointer.
pub(super) trait AnyStepper: Stepper<Error = MethodError> + Send + Sync {
    fn copy(&self) -> Box<dyn AnyStepper>;
}

/// A stepper whose errors are converted to those of a simulation.
#[derive(Clone)]
struct Widened<S>(S);

impl<S> AnyStepper for Widened<S>
where
    S: Stepper<Error: Send + Sync + 'static> + Clone + Send + Sync + 'static,
{
    fn copy(&self) -> Box<dyn AnyStepper> {
        Box::new(self.clone())
    }
}

fn widened<E: StepError + Send + Sync + 'static>(error: E, model: &Model) -> MethodError {
    if error.is_interruption() {
        return IntegratorError::Interrupted.into();
    }
    match error.fault(model) {
        StepFault::NotFinite { quantity, index } => {
            IntegratorError::Dynamics(DynamicsError::NonFinite { quantity, index }).into()
        }
        StepFault::SingularMass(source) => ConstraintError::SingularMass(source).into(),
        StepFault::Other(error) => CallbackError::new(error).into(),
    }
}

impl<S: Stepper<Error: Send + Sync + 'static>> Stepper for Widened<S> {
    type Error = MethodError;

    fn check_start(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), MethodError> {
        self.0.check_start(model, workspace, h, q, v).map_err(|error| widened(error, model))
    }

    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), MethodError> {
        self.0.step(model, workspace, forces, h, q, v).map_err(|error| widened(error, model))
    }

    fn order(&self) -> u32 {
        self.0.order()
    }

    fn check_mass(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
    ) -> Result<(), SingularMass> {
        self.0.check_mass(model, workspace, q)
    }

    fn losses(&self) -> Option<Losses> {
        self.0.losses()
    }

    fn contact_forces(&self) -> &[[f64; 3]] {
        self.0.contact_forces()
    }

    fn actuator_forces(&self) -> &[f64] {
        self.0.actuator_forces()
    }

    fn actuator_torques(&self) -> &[f64] {
        self.0.actuator_torques()
    }

    fn explicit_gains(&self, model: &Model, dissipation: bool, stiffness: &mut [f64], damping: &mut [f64]) {
        self.0.explicit_gains(model, dissipation, stiffness, damping);
    }

    fn active_set(&self) -> Option<ActiveSet> {
        self.0.active_set()
    }

    fn fix_active_set(&mut self, set: Option<ActiveSet>) {
        self.0.fix_active_set(set);
    }

    fn contact_laws(&self) -> Option<ContactLaws> {
        self.0.contact_laws()
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        self.0.stored_energy(q)
    }

    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        ledger: &mut EnergyLedger,
        from: (&[f64], &[f64]),
        to: (&[f64], &[f64]),
        forces: &StepForces<'_>,
        h: f64,
    ) {
        self.0.record(model, workspace, ledger, from, to, forces, h);
    }
}
