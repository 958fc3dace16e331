//! Steps that are shortened to end at a terminal event.

use robot_dynamics_integrators::EnergyAccount;

use super::event::EventDetector;
use super::interpolation::{Ends, StepInterpolation};
use super::{EventOccurrence, Run, RunError, RunLoop, Stepper};
use crate::{StepForces, StepWorkspace};

/// The least fraction of a step; implicit rows cannot solve a step of zero length.
const SHORTEST: f64 = 1e-9;

/// A step that can be repeated with another length.
pub(super) struct RepeatableStep<'a, S> {
    pub run_loop: &'a RunLoop<'a>,
    /// The run at the start of the step.
    pub run: &'a Run,
    /// The stepper at the start of the step.
    pub stepper: &'a S,
    pub forces: &'a StepForces<'a>,
    pub ends: Ends<'a>,
}

/// The result of a shortened step.
pub(super) struct ShortenedStep<S> {
    pub stepper: S,
    pub energy_account: EnergyAccount,
    pub time: f64,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// The event's function at the end.
    g: f64,
}

impl<S: Stepper + Clone> RepeatableStep<'_, S> {
    /// Takes the step from the same start to an event inside it. The time of the event is a root between the
    /// ends. One step of Newton's method on g at the end of the shortened step refines it, but not below the
    /// time `after`.
    ///
    /// # Errors
    /// The shorter step fails, or g has no value at its end.
    pub(super) fn shorten(
        &self,
        occurrence: &EventOccurrence,
        after: f64,
        workspace: &mut StepWorkspace,
        detector: &mut EventDetector<'_, '_>,
        between: &mut StepInterpolation<'_>,
    ) -> Result<ShortenedStep<S>, RunError> {
        let (event, h, (t0, t1)) = (occurrence.event, self.run_loop.step, self.ends.times);
        let cut = self.step_to(occurrence.time - t0, event, workspace, detector)?;
        if cut.g == 0.0 {
            return Ok(cut);
        }
        let around = (h / 64.0, t0, t1);
        let derivative = detector
            .derivative(event, cut.time, around, &mut |t, q, v| between.state(&self.ends, t, q, v))?;
        let better = cut.time - cut.g / derivative;
        // The step's polynomial is accurate; if Newton's method moves far from its root, g is not smooth.
        let is_close = (better - cut.time).abs() < h / 8.0;
        if !is_close || better < after {
            return Ok(cut);
        }
        let again = self.step_to(better - t0, event, workspace, detector)?;
        Ok(if again.g.abs() < cut.g.abs() { again } else { cut })
    }

    /// Takes the step of length `s` \[s\].
    fn step_to(
        &self,
        s: f64,
        event: usize,
        workspace: &mut StepWorkspace,
        detector: &mut EventDetector<'_, '_>,
    ) -> Result<ShortenedStep<S>, RunError> {
        let s = s.clamp(SHORTEST * self.run_loop.step, self.run_loop.step);
        let time = (self.ends.times.0 + s).min(self.ends.times.1);
        let (mut stepper, mut q, mut v) = (self.stepper.clone(), self.run.q.clone(), self.run.v.clone());
        let energy_account =
            self.run_loop.take_step(&mut stepper, workspace, self.run, self.forces, s, (&mut q, &mut v))?;
        let g = detector.value(event, time, &q, &v)?;
        Ok(ShortenedStep { stepper, energy_account, time, q, v, g })
    }
}
