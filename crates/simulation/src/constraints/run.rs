//! Steps with constraints, and their drift.

use robot_dynamics_core::{Model, SingularMass, Workspace};

use super::step::step_in;
use super::{ConstraintDrift, ConstraintOptions, ConstraintSet, DriftCorrection, StepConstraints};
use crate::{StepError, StepForces, StepWorkspace, Stepper};

/// The constraint errors and corrections of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ConstraintRecord {
    /// The largest φ and A v at the end of a step, after the correction.
    pub drift: ConstraintDrift,
    /// The largest φ and A v that one step caused before its correction.
    pub step_drift: ConstraintDrift,
    /// The kinetic energy that all projections took out \[J\].
    pub energy_removed: f64,
    /// The smallest rank of A; it drops in a singular position.
    pub smallest_rank: usize,
}

/// Constrained steps of an explicit or variational method, and the record of their errors.
#[derive(Clone, Debug)]
pub struct ConstrainedStepper {
    constraints: ConstraintSet,
    options: ConstraintOptions,
    correction: DriftCorrection,
    pub record: ConstraintRecord,
}

impl ConstrainedStepper {
    pub fn new(constraints: ConstraintSet, options: ConstraintOptions, correction: DriftCorrection) -> Self {
        let record = ConstraintRecord { smallest_rank: constraints.len(), ..Default::default() };
        Self { constraints, options, correction, record }
    }
}

impl Stepper for ConstrainedStepper {
    fn order(&self) -> u32 {
        self.options.integrator.order()
    }

    /// The start must be on the constraint.
    fn check_start(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        _: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), StepError> {
        self.options.check()?;
        let rows = self.constraints.rows(model, workspace, q, v);
        ConstraintDrift::require_below(&self.constraints, &rows, v, self.options.dependence.max(1e-6))?;
        self.record.drift = ConstraintDrift::of(&rows, v);
        Ok(())
    }

    /// Each step factors M.
    fn check_mass(&mut self, _: &Model, _: &mut Workspace, _: &[f64]) -> Result<(), SingularMass> {
        Ok(())
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
        let Self { constraints, options, correction, record } = self;
        let law = StepConstraints { set: constraints, options, correction: *correction };
        let report = step_in(model, workspace, law, forces, h, q, v)?;
        record.drift = record.drift.max(report.corrected);
        record.step_drift = record.step_drift.max(report.drift);
        record.energy_removed += report.energy_removed;
        record.smallest_rank = record.smallest_rank.min(report.rank);
        Ok(())
    }
}
