//! One adaptive step after another, ending exactly where it must.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::AdaptiveStepError;
use super::local_error::least_accurate;
use super::method::{AdaptiveMethod, Steps};
use super::motion::{Motion, Trouble};
use super::{AdaptiveStepper, StepStatistics};

/// The integration so far.
pub(super) struct StepSequence {
    kind: AdaptiveMethod,
    method: Box<dyn Steps>,
    tolerance: f64,
    end: f64,
    /// Where the last step began, and where it ended.
    pub from: f64,
    pub t: f64,
    /// The step the tolerance allows next.
    wanted: f64,
    most_steps: usize,
    /// Steps tried since the last sample or control instant.
    pub since: usize,
    /// What went wrong in the last step tried.
    trouble: Option<Trouble>,
    pub statistics: StepStatistics,
}

/// What an attempt to move on came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Advance {
    /// One step further.
    Moved,
    /// Told to stop: where it was.
    Interrupted,
}

impl StepSequence {
    /// At y(t₀), before the first step.
    pub(super) fn start(
        stepper: &AdaptiveStepper,
        motion: &Motion<'_, '_>,
        (t, end): (f64, f64),
        y: &[f64],
    ) -> Result<Self, Trouble> {
        let (kind, tolerance) = (stepper.record.method, stepper.options.tolerance);
        let mut sequence = Self {
            kind,
            method: kind.start(tolerance, stepper.wanted.min(end - t)),
            tolerance,
            end,
            from: t,
            t,
            wanted: end - t,
            most_steps: stepper.options.max_steps,
            since: 0,
            trouble: None,
            statistics: StepStatistics::default(),
        };
        sequence.begin(motion, &y.to_vec())?;
        sequence.wanted = sequence.method.h();
        Ok(sequence)
    }

    /// Starts anew from the present state: the forces have jumped.
    pub(super) fn restart(&mut self, motion: &Motion<'_, '_>) -> Result<(), Trouble> {
        let y = self.method.y().clone();
        self.restart_from(motion, &y)
    }

    #[allow(clippy::ptr_arg)] // as begin
    fn restart_from(&mut self, motion: &Motion<'_, '_>, y: &Vec<f64>) -> Result<(), Trouble> {
        self.method = self.kind.start(self.tolerance, self.wanted.min(self.end - self.t));
        self.begin(motion, y)
    }

    #[allow(clippy::ptr_arg)] // the method's type of state
    fn begin(&mut self, motion: &Motion<'_, '_>, y: &Vec<f64>) -> Result<(), Trouble> {
        if self.method.begin(motion, self.t, self.end, y) {
            return Ok(());
        }
        // The first step comes from the first two evaluations: one of them was not finite.
        Err(self.failed(motion, y))
    }

    /// y at the end of the last step.
    pub(super) fn y(&self) -> &Vec<f64> {
        self.method.y()
    }

    /// y inside the last step.
    pub(super) fn interpolate(&mut self, t: f64) -> Vec<f64> {
        // `t` may be the rounded end of the step.
        let inside = t.clamp(self.method.t_before(), self.method.t());
        if inside >= self.method.t() {
            return self.method.y().clone();
        }
        self.method.inside(inside).unwrap_or_else(|| self.method.y().clone())
    }

    /// One accepted step, to `target` at most.
    pub(super) fn advance(
        &mut self,
        motion: &Motion<'_, '_>,
        target: f64,
        interrupt: Option<&AtomicBool>,
    ) -> Result<Advance, Trouble> {
        loop {
            if interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed)) {
                return Ok(Advance::Interrupted);
            }
            let left = target - self.t;
            // A rest that would be a sliver is halved beforehand.
            let (h, lands) = match self.wanted {
                wanted if wanted >= left => (left, true),
                wanted if wanted > 0.5 * left => (0.5 * left, false),
                wanted => (wanted, false),
            };
            if h <= self.least() || !h.is_finite() {
                return Err(self.failed(motion, self.y()));
            }
            if self.since >= self.most_steps {
                return Err(Trouble::Step(AdaptiveStepError::TooManySteps {
                    steps: self.since,
                    step: self.wanted,
                    coordinate: least_accurate(motion, self.t, self.y(), self.wanted),
                }));
            }
            self.since += 1;
            motion.take_trouble();
            if !self.method.step(motion, h) {
                return Err(self.failed(motion, self.y()));
            }
            self.statistics.evaluations = motion.evaluations();
            let moved = self.method.t() > self.t && !self.method.is_rejected();
            if let Some(trouble) = motion.take_trouble() {
                // The method's error norm passes over NaN: such a step is taken back here, and a shorter one may do.
                self.trouble = Some(trouble);
                self.statistics.rejected += 1;
                self.wanted = 0.2 * h;
                if moved {
                    let y = self.method.y_before().clone();
                    self.restart_from(motion, &y)?;
                }
                continue;
            }
            if !moved {
                self.statistics.rejected += 1;
                self.wanted = self.method.h().min(h);
                continue;
            }
            self.trouble = None;
            let first = self.statistics.accepted == 0;
            self.statistics.accepted += 1;
            self.statistics.shortest = if first { h } else { self.statistics.shortest.min(h) };
            self.statistics.longest = self.statistics.longest.max(h);
            // A step cut short says little about the next: the wish from before it stands.
            self.wanted = if h < self.wanted { self.method.h().max(self.wanted) } else { self.method.h() };
            self.from = self.t;
            self.t = if lands { target } else { self.method.t() };
            return Ok(Advance::Moved);
        }
    }

    /// The shortest step that moves the time on by more than its rounding \[s\].
    fn least(&self) -> f64 {
        16.0 * f64::EPSILON * self.t.abs().max(self.end.abs())
    }

    /// The step that the tolerance allows next \[s\].
    pub(super) fn wanted(&self) -> f64 {
        self.wanted
    }

    /// Why no step can be taken from y: a number that is not finite, or forces that are not smooth.
    fn failed(&self, motion: &Motion<'_, '_>, y: &[f64]) -> Trouble {
        motion.take_trouble().or_else(|| self.trouble.clone()).unwrap_or_else(|| {
            let step = self.wanted.min(self.least());
            let coordinate = least_accurate(motion, self.t, y, step);
            Trouble::Step(AdaptiveStepError::StepTooSmall { step, coordinate })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{AdaptiveOptions, Applied};
    use super::*;
    use crate::{Base, Model, RandomRobotOptions, random_robot, random_state};

    /// Inside one step of h from the same start the polynomial is off by O(h¹⁰), its order being 9: the largest
    /// error over the step, at 50 and 70 ms, against a run of the least tolerance.
    #[test]
    fn dense_output_has_order_nine() {
        let options =
            RandomRobotOptions { joints: 3, base: Base::Floating, massless: 0.0, ..Default::default() };
        let model = Model::new(random_robot(7, &options)).unwrap();
        let state = random_state(&model, &mut dynamics::SplitMix64::new(7));
        let y: Vec<f64> = [&state.q[..], &state.v, &[0.0, 0.0]].concat();
        let rest = vec![0.0; model.nv()];
        let motion = Motion::new(&model, false, 1.0, Applied::held(&rest));
        let errors = [0.07, 0.05].map(|h| {
            let at = |tolerance, max_steps| {
                let method = AdaptiveMethod::Explicit;
                let options = AdaptiveOptions { tolerance, method, max_steps, ..AdaptiveOptions::default() };
                AdaptiveStepper::new(options, None)
            };
            let mut step = StepSequence::start(&at(1e-2, 10), &motion, (0.0, h), &y).unwrap();
            step.wanted = h;
            step.advance(&motion, h, None).unwrap();
            assert_eq!((step.t, step.statistics.rejected), (h, 0), "one step of {h} s");
            let off = |fraction: f64| {
                let t = fraction * h;
                let mut exact = StepSequence::start(&at(1e-13, 1000), &motion, (0.0, t), &y).unwrap();
                while exact.t < t {
                    exact.advance(&motion, t, None).unwrap();
                }
                let found = step.interpolate(t);
                found.iter().zip(exact.y()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            [0.15, 0.35, 0.5, 0.65, 0.85].map(off).into_iter().fold(0.0, f64::max)
        });
        let order = (errors[0] / errors[1]).log2() / 1.4f64.log2();
        println!("errors {errors:?}, local order {order:.2}");
        assert!(errors[1] > 1e-13, "above rounding: {errors:?}");
        // At least; the next term of the error still shows at these steps, above rounding.
        assert!((9.5..13.0).contains(&order), "{errors:?}: {order}");
    }
}
