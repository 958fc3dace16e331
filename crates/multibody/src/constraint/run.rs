//! A run under constraints: controller, step, energy ledger, drift.

use std::ops::ControlFlow;

use super::step::step_in;
use super::{ConstrainedMotionError, ConstraintDrift, ConstraintOptions, ConstraintSet, DriftCorrection};
use crate::place::check_length;
use crate::{Controller, EnergyLedger, Model, Moment, StepForces, StepWorkspace};

/// How a constrained run is made.
#[derive(Clone, Copy, Debug)]
pub struct ConstrainedSimulation<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Its constraints.
    pub constraints: &'a ConstraintSet,
    /// How the constrained motion is computed, and by which integrator.
    pub options: ConstraintOptions,
    /// What is done about drift; nothing more in the variational rows, which hold the constraint themselves.
    pub correction: DriftCorrection,
    /// The step, which is also the control period \[s\].
    pub step: f64,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
}

/// What a constrained run did.
#[derive(Clone, Debug)]
pub struct ConstrainedRun {
    /// The books; constraint forces do no work, so they do not appear.
    pub ledger: EnergyLedger,
    /// The largest φ and A v met at the end of a step, after the correction.
    pub drift: ConstraintDrift,
    /// The largest φ and A v that one step made before its correction.
    pub step_drift: ConstraintDrift,
    /// All kinetic energy that projections took out \[J\].
    pub energy_removed: f64,
    /// The smallest rank of A met; it falls in a singular position.
    pub smallest_rank: usize,
    /// Steps done.
    pub steps: usize,
    /// q at the end.
    pub q: Vec<f64>,
    /// v at the end.
    pub v: Vec<f64>,
}

impl ConstrainedSimulation<'_> {
    /// Runs `steps` steps from (q0, v0), which must be on the constraint to 1e-6. The controller is asked at
    /// the start of each step; the observer sees each of these instants and the end, and may break off.
    ///
    /// # Errors
    /// [`ConstrainedMotionError::OffConstraint`] at the start; later [`ConstrainedMotionError::Step`] with the
    /// time, and inside it what [`constrained_step`](super::constrained_step) says.
    ///
    /// # Panics
    /// If q0 or v0 has the wrong length, or the step is not positive and finite.
    pub fn run(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controller: &mut (impl Controller + ?Sized),
        mut observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<ConstrainedRun, ConstrainedMotionError> {
        let Self { model, constraints, .. } = *self;
        check_length("q0", q0.len(), model.nq());
        check_length("v0", v0.len(), model.nv());
        let mut workspace = StepWorkspace::new(model);
        let rows = constraints.rows(model, &mut workspace.dynamics, q0, v0);
        ConstraintDrift::require_below(constraints, &rows, v0, 1e-6)?;
        let mut run = ConstrainedRun {
            ledger: EnergyLedger::open(model, &mut workspace.dynamics, q0, v0),
            drift: ConstraintDrift::of(&rows, v0),
            step_drift: ConstraintDrift::default(),
            energy_removed: 0.0,
            smallest_rank: constraints.len(),
            steps: 0,
            q: q0.to_vec(),
            v: v0.to_vec(),
        };
        let mut tau = vec![0.0; model.nv()];
        let (mut q, mut v) = (run.q.clone(), run.v.clone());
        for done in 0..=steps {
            let time = done as f64 * self.step;
            controller.torque(time, &run.q, &run.v, &mut tau);
            if let Some(index) = tau.iter().position(|x| !x.is_finite()) {
                return Err(ConstrainedMotionError::NotFinite { quantity: "the controller's torque", index });
            }
            let moment = Moment { step: done, time, q: &run.q, v: &run.v, tau: &tau, ledger: &run.ledger };
            if observer(&moment).is_break() || done == steps {
                break;
            }
            let forces = StepForces { tau: &tau, dissipation: self.dissipation };
            let report = step_in(
                model,
                &mut workspace,
                constraints,
                &self.options,
                self.correction,
                &forces,
                self.step,
                &mut q,
                &mut v,
            )
            .map_err(|source| ConstrainedMotionError::Step {
                step: done,
                time,
                source: Box::new(source),
            })?;
            run.ledger.record(model, &mut workspace.dynamics, (&run.q, &run.v), (&q, &v), &forces, self.step);
            run.q.copy_from_slice(&q);
            run.v.copy_from_slice(&v);
            run.drift = run.drift.max(report.corrected);
            run.step_drift = run.step_drift.max(report.drift);
            run.energy_removed += report.energy_removed;
            run.smallest_rank = run.smallest_rank.min(report.rank);
            run.steps += 1;
        }
        Ok(run)
    }
}
