//! A step cut short where a terminal event happens.

use dynamics::EnergyLedger;

use super::between::{Between, Ends};
use super::event::Watch;
use super::{Course, EventOccurrence, Run, RunError, Stepper};
use crate::{StepForces, StepWorkspace};

/// No step is cut to less than this part of its length: implicit rows solve nothing in no time.
const SHORTEST: f64 = 1e-9;

/// A step that may be taken again.
pub(super) struct Whole<'a, S> {
    pub course: &'a Course<'a>,
    /// The run up to its start.
    pub run: &'a Run,
    /// As it was then.
    pub stepper: &'a S,
    pub forces: &'a StepForces<'a>,
    pub ends: Ends<'a>,
}

/// What a shorter step came to.
pub(super) struct Cut<S> {
    pub stepper: S,
    pub ledger: EnergyLedger,
    pub time: f64,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// The event's function there.
    g: f64,
}

impl<S: Stepper + Clone> Whole<'_, S> {
    /// The step from the same start to an event inside it. The time of the occurrence, a root between the ends, is
    /// improved by one step of Newton's method on g at the cut step's end; not before the time `after`.
    ///
    /// # Errors
    /// The shorter step cannot be taken, or g has no value at its end.
    pub(super) fn cut(
        &self,
        occurrence: &EventOccurrence,
        after: f64,
        workspace: &mut StepWorkspace,
        watch: &mut Watch<'_, '_>,
        between: &mut Between<'_>,
    ) -> Result<Cut<S>, RunError<S::Error>> {
        let (event, h, (t0, t1)) = (occurrence.event, self.course.step, self.ends.times);
        let cut = self.take(occurrence.time - t0, event, workspace, watch)?;
        if cut.g == 0.0 {
            return Ok(cut);
        }
        let around = (h / 64.0, t0, t1);
        let slope =
            watch.slope(event, cut.time, around, &mut |t, q, v| between.state(&self.ends, t, q, v))?;
        let better = cut.time - cut.g / slope;
        // The step's polynomial is close: where Newton's method leaves it, g is not smooth.
        let is_close = (better - cut.time).abs() < h / 8.0;
        if !is_close || better < after {
            return Ok(cut);
        }
        let again = self.take(better - t0, event, workspace, watch)?;
        Ok(if again.g.abs() < cut.g.abs() { again } else { cut })
    }

    /// The step of `s` \[s\].
    fn take(
        &self,
        s: f64,
        event: usize,
        workspace: &mut StepWorkspace,
        watch: &mut Watch<'_, '_>,
    ) -> Result<Cut<S>, RunError<S::Error>> {
        let s = s.clamp(SHORTEST * self.course.step, self.course.step);
        let time = (self.ends.times.0 + s).min(self.ends.times.1);
        let (mut stepper, mut q, mut v) = (self.stepper.clone(), self.run.q.clone(), self.run.v.clone());
        let ledger = self.course.take(&mut stepper, workspace, self.run, self.forces, s, (&mut q, &mut v))?;
        let g = watch.value(event, time, &q, &v)?;
        Ok(Cut { stepper, ledger, time, q, v, g })
    }
}
