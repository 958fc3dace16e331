//! A run under constraints: controller, step, energy ledger, drift.

use std::ops::ControlFlow;

use super::error::check_entries;
use super::step::step_in;
use super::{
    ConstrainedMotionError, ConstrainedRunFailure, ConstraintDrift, ConstraintOptions, ConstraintSet,
    DriftCorrection,
};
use crate::model::length::check_length;
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
    /// [`ConstrainedRunFailure`] with what was computed until then, and the cause: q0, v0, the step or an option is not
    /// finite,
    /// [`ConstrainedMotionError::OffConstraint`] at the start; later a controller that fails or gives a torque that
    /// is not finite, or [`ConstrainedMotionError::Step`], each with the time, and inside the last what
    /// [`constrained_step`](super::constrained_step) says.
    ///
    /// # Panics
    /// If q0 or v0 has the wrong length.
    pub fn run(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controller: &mut (impl Controller + ?Sized),
        mut observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<ConstrainedRun, Box<ConstrainedRunFailure>> {
        let Self { model, constraints, .. } = *self;
        check_length("q0", q0.len(), model.nq());
        check_length("v0", v0.len(), model.nv());
        let mut workspace = StepWorkspace::new(model);
        let start = self.check_start(&mut workspace, q0, v0);
        let drift = *start.as_ref().unwrap_or(&ConstraintDrift::default());
        let overflow = |_, value| ConstrainedMotionError::BadNumber { quantity: "the energy", value };
        let start = start.map(|_| ());
        let (ledger, q, v, start) =
            EnergyLedger::open_start(model, &mut workspace.dynamics, q0, v0, start, overflow);
        let mut run = ConstrainedRun {
            ledger,
            drift,
            step_drift: ConstraintDrift::default(),
            energy_removed: 0.0,
            smallest_rank: constraints.len(),
            steps: 0,
            q,
            v,
        };
        let advanced =
            start.and_then(|()| self.advance(&mut run, steps, &mut workspace, controller, &mut observer));
        match advanced {
            Ok(()) => Ok(run),
            Err(error) => Err(Box::new(ConstrainedRunFailure { error, until: run })),
        }
    }

    /// The drift of a start that is on the constraint.
    fn check_start(
        &self,
        workspace: &mut StepWorkspace,
        q0: &[f64],
        v0: &[f64],
    ) -> Result<ConstraintDrift, ConstrainedMotionError> {
        if !(self.step > 0.0 && self.step.is_finite()) {
            return Err(ConstrainedMotionError::BadStep { step: self.step });
        }
        self.options.check()?;
        check_entries("q0", q0)?;
        check_entries("v0", v0)?;
        let rows = self.constraints.rows(self.model, &mut workspace.dynamics, q0, v0);
        ConstraintDrift::require_below(self.constraints, &rows, v0, 1e-6)?;
        Ok(ConstraintDrift::of(&rows, v0))
    }

    /// The loop: torque, observer, step, books.
    fn advance(
        &self,
        run: &mut ConstrainedRun,
        steps: usize,
        workspace: &mut StepWorkspace,
        controller: &mut (impl Controller + ?Sized),
        observer: &mut impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<(), ConstrainedMotionError> {
        let Self { model, constraints, .. } = *self;
        let mut tau = vec![0.0; model.nv()];
        let (mut q, mut v) = (run.q.clone(), run.v.clone());
        for step in 0..=steps {
            let time = step as f64 * self.step;
            controller
                .torque(time, &run.q, &run.v, &mut tau)
                .map_err(|source| ConstrainedMotionError::Controller { step, time, source })?;
            if let Some(index) = tau.iter().position(|x| !x.is_finite()) {
                let coordinate = model.coordinate_names()[index].clone();
                return Err(ConstrainedMotionError::TorqueNotFinite { coordinate, step, time });
            }
            let moment = Moment { step, time, q: &run.q, v: &run.v, tau: &tau, ledger: &run.ledger };
            if observer(&moment).is_break() || step == steps {
                break;
            }
            let forces = StepForces { tau: &tau, dissipation: self.dissipation };
            let report = step_in(
                model,
                workspace,
                constraints,
                &self.options,
                self.correction,
                &forces,
                self.step,
                &mut q,
                &mut v,
            )
            .map_err(|source| ConstrainedMotionError::Step {
                step,
                time,
                source: Box::new(source),
            })?;
            let (from, to) = ((&run.q[..], &run.v[..]), (&q[..], &v[..]));
            if let Err((_, value)) =
                run.ledger.record_finite(model, &mut workspace.dynamics, from, to, &forces, self.step)
            {
                let source = Box::new(ConstrainedMotionError::BadNumber { quantity: "the energy", value });
                return Err(ConstrainedMotionError::Step { step, time, source });
            }
            run.q.copy_from_slice(&q);
            run.v.copy_from_slice(&v);
            run.drift = run.drift.max(report.corrected);
            run.step_drift = run.step_drift.max(report.drift);
            run.energy_removed += report.energy_removed;
            run.smallest_rank = run.smallest_rank.min(report.rank);
            run.steps += 1;
        }
        Ok(())
    }
}
