//! A run under constraints: the loop of every run, and the drift of its steps.

use std::ops::ControlFlow;

use super::step::step_in;
use super::{
    ConstrainedMotionError, ConstrainedRunFailure, ConstraintDrift, ConstraintOptions, ConstraintSet,
    DriftCorrection,
};
use crate::motion::simulate::Course;
use crate::{
    Controller, Event, Model, Moment, Run, RunFailure, SingularMass, StepError, StepFault, StepForces,
    StepWorkspace, Stepper, Workspace,
};

/// How a constrained run is made.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
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
    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub sample_every: usize,
}

impl<'a> ConstrainedSimulation<'a> {
    /// Steps of that length \[s\] by the default options; damping and friction act, every state is kept, drift is
    /// corrected as by default.
    pub fn new(model: &'a Model, constraints: &'a ConstraintSet, step: f64) -> Self {
        Self {
            model,
            constraints,
            options: ConstraintOptions::default(),
            correction: DriftCorrection::default(),
            step,
            dissipation: true,
            sample_every: 1,
        }
    }

    /// With another way to compute the motion, or another integrator.
    pub fn with_options(self, options: ConstraintOptions) -> Self {
        Self { options, ..self }
    }

    /// With something else done about drift.
    pub fn with_correction(self, correction: DriftCorrection) -> Self {
        Self { correction, ..self }
    }

    /// Whether the joints' damping and friction act.
    pub fn with_dissipation(self, dissipation: bool) -> Self {
        Self { dissipation, ..self }
    }

    /// A sample is kept every so many steps; the first and the last state always, only they if this is 0.
    pub fn with_samples_every(self, steps: usize) -> Self {
        Self { sample_every: steps, ..self }
    }
}

/// What a constrained run did.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ConstrainedRun {
    /// Samples, books, state at the end; constraint forces do no work, so they do not appear in the books.
    pub motion: Run,
    /// What the steps did to the constraint.
    pub record: ConstraintRecord,
}

/// What the steps of a run did to the constraint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ConstraintRecord {
    /// The largest φ and A v met at the end of a step, after the correction.
    pub drift: ConstraintDrift,
    /// The largest φ and A v that one step made before its correction.
    pub step_drift: ConstraintDrift,
    /// All kinetic energy that projections took out \[J\].
    pub energy_removed: f64,
    /// The smallest rank of A met; it falls in a singular position.
    pub smallest_rank: usize,
}

impl ConstrainedSimulation<'_> {
    /// Runs `steps` steps from (q0, v0), which must be on the constraint to 1e-6, or to
    /// [`ConstraintOptions::dependence`]. The controller is asked at
    /// the start of each step; the observer sees each of these instants and the end, and may break off.
    ///
    /// # Errors
    /// [`ConstrainedRunFailure`] with what was computed until then, and the cause: as
    /// [`Simulation::run`](crate::Simulation::run) says, of a start off the constraint
    /// [`ConstrainedMotionError::OffConstraint`], of a step what [`constrained_step`](super::constrained_step) says.
    ///
    /// # Panics
    /// If q0 or v0 has the wrong length.
    #[track_caller]
    pub fn run(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controller: &mut (impl Controller + ?Sized),
        observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<ConstrainedRun, Box<ConstrainedRunFailure>> {
        self.run_with_events(q0, v0, steps, controller, &mut [], observer)
    }

    /// As [`run`](Self::run), with events watched for all along, as
    /// [`Simulation::run_with_events`](crate::Simulation::run_with_events) says. Between the ends of a step the state
    /// is on the constraint to the interpolation's order, at a terminal event as at any step's end.
    ///
    /// # Errors
    /// As [`run`](Self::run), and where the function of an event fails or is not finite.
    ///
    /// # Panics
    /// If q0 or v0 has the wrong length.
    #[track_caller]
    pub fn run_with_events(
        &self,
        q0: &[f64],
        v0: &[f64],
        steps: usize,
        controller: &mut (impl Controller + ?Sized),
        events: &mut [Event<'_>],
        observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
    ) -> Result<ConstrainedRun, Box<ConstrainedRunFailure>> {
        let Self { model, constraints, options, correction, step, dissipation, sample_every } = *self;
        let course = Course { model, step, dissipation, sample_every, base: (0, 0.0) };
        let mut stepper = ConstrainedStepper::new(constraints.clone(), options, correction);
        match course.run(&mut stepper, (q0, v0), steps, controller, events, observer) {
            Ok(motion) => Ok(ConstrainedRun { motion, record: stepper.record }),
            Err(failure) => {
                let RunFailure { error, until } = *failure;
                let until = ConstrainedRun { motion: until, record: stepper.record };
                Err(Box::new(ConstrainedRunFailure { error, until }))
            }
        }
    }
}

/// Steps of an explicit or variational row that hold constraints, and the record of what they did.
#[derive(Clone, Debug)]
pub(crate) struct ConstrainedStepper {
    constraints: ConstraintSet,
    options: ConstraintOptions,
    correction: DriftCorrection,
    pub(crate) record: ConstraintRecord,
}

impl ConstrainedStepper {
    pub(crate) fn new(
        constraints: ConstraintSet,
        options: ConstraintOptions,
        correction: DriftCorrection,
    ) -> Self {
        let record = ConstraintRecord { smallest_rank: constraints.len(), ..Default::default() };
        Self { constraints, options, correction, record }
    }
}

impl Stepper for ConstrainedStepper {
    type Error = ConstrainedMotionError;

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
    ) -> Result<(), ConstrainedMotionError> {
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
    ) -> Result<(), ConstrainedMotionError> {
        let Self { constraints, options, correction, record } = self;
        let report = step_in(model, workspace, constraints, options, *correction, forces, h, q, v)?;
        record.drift = record.drift.max(report.corrected);
        record.step_drift = record.step_drift.max(report.drift);
        record.energy_removed += report.energy_removed;
        record.smallest_rank = record.smallest_rank.min(report.rank);
        Ok(())
    }
}

impl StepError for ConstrainedMotionError {
    fn fault(self, _: &Model) -> StepFault<Self> {
        match self {
            Self::NotFinite { quantity, index } => StepFault::NotFinite { quantity, index },
            Self::SingularMass(source) => StepFault::SingularMass(source),
            other => StepFault::Other(other),
        }
    }
}
