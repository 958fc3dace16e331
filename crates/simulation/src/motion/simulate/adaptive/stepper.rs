//! The sequence of adaptive steps, which end exactly at given times.

use std::sync::atomic::{AtomicBool, Ordering};

use super::super::StepError;
use super::local_error::least_accurate;
use super::method::{AdaptiveMethod, Steps};
use super::motion::{AdaptiveSystem, MotionFailure};
use super::options::AdaptiveOptions;
use super::statistics::StepStatistics;

/// The state of the integration.
pub(super) struct StepSequence {
    kind: AdaptiveMethod,
    method: Box<dyn Steps>,
    tolerance: f64,
    end: f64,
    /// The start and the end of the last step.
    pub from: f64,
    pub t: f64,
    /// The next step that the tolerance allows.
    wanted: f64,
    most_steps: usize,
    /// Attempted steps since the last sample or control instant.
    pub since: usize,
    /// The failure of the last attempted step.
    failure: Option<MotionFailure>,
    pub statistics: StepStatistics,
}

/// The result of an attempt to advance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AdvanceResult {
    /// One accepted step.
    Moved,
    /// An interrupt; the state is unchanged.
    Interrupted,
}

impl StepSequence {
    /// Starts at y(t₀); `wanted` is the first step to attempt \[s\].
    pub(super) fn start(
        kind: AdaptiveMethod,
        options: &AdaptiveOptions,
        wanted: f64,
        motion: &AdaptiveSystem<'_, '_>,
        (t, end): (f64, f64),
        y: &[f64],
    ) -> Result<Self, MotionFailure> {
        let tolerance = options.tolerance;
        let mut sequence = Self {
            kind,
            method: kind.start(tolerance, wanted.min(end - t)),
            tolerance,
            end,
            from: t,
            t,
            wanted: end - t,
            most_steps: options.max_steps,
            since: 0,
            failure: None,
            statistics: StepStatistics::default(),
        };
        sequence.begin(motion, &y.to_vec())?;
        sequence.wanted = sequence.method.h();
        Ok(sequence)
    }

    /// Restarts from the current state after a jump of the forces.
    pub(super) fn restart(&mut self, motion: &AdaptiveSystem<'_, '_>) -> Result<(), MotionFailure> {
        let y = self.method.y().clone();
        self.restart_from(motion, &y)
    }

    #[allow(clippy::ptr_arg)] // as in `begin`
    fn restart_from(&mut self, motion: &AdaptiveSystem<'_, '_>, y: &Vec<f64>) -> Result<(), MotionFailure> {
        self.method = self.kind.start(self.tolerance, self.wanted.min(self.end - self.t));
        self.begin(motion, y)
    }

    #[allow(clippy::ptr_arg)] // the state type of the methods
    fn begin(&mut self, motion: &AdaptiveSystem<'_, '_>, y: &Vec<f64>) -> Result<(), MotionFailure> {
        if self.method.begin(motion, self.t, self.end, y) {
            return Ok(());
        }
        // The first step uses the first two evaluations, and one of them was not finite.
        Err(self.failed(motion, y))
    }

    /// y at the end of the last step.
    pub(super) fn y(&self) -> &Vec<f64> {
        self.method.y()
    }

    /// Interpolates y inside the last step.
    pub(super) fn interpolate(&mut self, t: f64) -> Vec<f64> {
        // `t` may be the rounded end of the step.
        let inside = t.clamp(self.method.t_before(), self.method.t());
        if inside >= self.method.t() {
            return self.method.y().clone();
        }
        self.method.inside(inside).unwrap_or_else(|| self.method.y().clone())
    }

    /// Takes one accepted step, at most to `target`.
    pub(super) fn advance(
        &mut self,
        motion: &AdaptiveSystem<'_, '_>,
        target: f64,
        interrupt: Option<&AtomicBool>,
    ) -> Result<AdvanceResult, MotionFailure> {
        loop {
            if interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed)) {
                return Ok(AdvanceResult::Interrupted);
            }
            let left = target - self.t;
            // If the remainder after this step would be tiny, halve the distance first.
            let (h, lands) = match self.wanted {
                wanted if wanted >= left => (left, true),
                wanted if wanted > 0.5 * left => (0.5 * left, false),
                wanted => (wanted, false),
            };
            if h <= self.least() || !h.is_finite() {
                return Err(self.failed(motion, self.y()));
            }
            if self.since >= self.most_steps {
                return Err(MotionFailure::Step(StepError::TooManySteps {
                    steps: self.since,
                    step: self.wanted,
                    coordinate: least_accurate(motion, self.t, self.y(), self.wanted),
                }));
            }
            self.since += 1;
            motion.take_failure();
            if !self.method.step(motion, h) {
                return Err(self.failed(motion, self.y()));
            }
            self.statistics.evaluations = motion.evaluations();
            let moved = self.method.t() > self.t && !self.method.is_rejected();
            if let Some(failure) = motion.take_failure() {
                // The method's error norm ignores NaN. Such a step is rejected here; a shorter one may
                // succeed.
                self.failure = Some(failure);
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
            self.failure = None;
            let first = self.statistics.accepted == 0;
            self.statistics.accepted += 1;
            self.statistics.shortest = if first { h } else { self.statistics.shortest.min(h) };
            self.statistics.longest = self.statistics.longest.max(h);
            // A shortened step gives little information about the next; keep the earlier proposal.
            self.wanted = if h < self.wanted { self.method.h().max(self.wanted) } else { self.method.h() };
            self.from = self.t;
            self.t = if lands { target } else { self.method.t() };
            return Ok(AdvanceResult::Moved);
        }
    }

    /// The shortest step that is above the rounding of time \[s\].
    fn least(&self) -> f64 {
        16.0 * f64::EPSILON * self.t.abs().max(self.end.abs())
    }

    /// The next step that the tolerance allows \[s\].
    pub(super) fn wanted(&self) -> f64 {
        self.wanted
    }

    /// The cause of a failed step from y: a number that is not finite, or forces that are not smooth.
    fn failed(&self, motion: &AdaptiveSystem<'_, '_>, y: &[f64]) -> MotionFailure {
        motion.take_failure().or_else(|| self.failure.clone()).unwrap_or_else(|| {
            let step = self.wanted.min(self.least());
            let coordinate = least_accurate(motion, self.t, y, step);
            MotionFailure::Step(StepError::StepTooSmall { step, coordinate })
        })
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::{Model, random_state};
    use robot_dynamics_description::{Base, RandomRobotOptions, random_robot};

    use super::super::{AdaptiveOptions, ExternalInputs};
    use super::*;

    /// The polynomial has order 9, so its error inside one step of h is O(h¹⁰). The test compares the largest
    /// error over steps of 50 and 70 ms with a run at the smallest tolerance.
    #[test]
    fn dense_output_has_order_nine() {
        let options =
            RandomRobotOptions { joints: 3, base: Base::Floating, massless: 0.0, ..Default::default() };
        let model = Model::new(random_robot(7, &options)).unwrap();
        let state = random_state(&model, &mut robot_dynamics_number::SplitMix64::new(7));
        let y: Vec<f64> = [&state.q[..], &state.v, &[0.0, 0.0]].concat();
        let rest = vec![0.0; model.nv()];
        let motion = AdaptiveSystem::new(&model, false, 1.0, ExternalInputs::held(&rest));
        let errors = [0.07, 0.05].map(|h| {
            let start = |tolerance, max_steps, end| {
                let method = AdaptiveMethod::Explicit;
                let options = AdaptiveOptions { tolerance, method, max_steps, ..AdaptiveOptions::default() };
                StepSequence::start(method, &options, 0.0, &motion, (0.0, end), &y).unwrap()
            };
            let mut step = start(1e-2, 10, h);
            step.wanted = h;
            step.advance(&motion, h, None).unwrap();
            assert_eq!((step.t, step.statistics.rejected), (h, 0), "one step of {h} s");
            let off = |fraction: f64| {
                let t = fraction * h;
                let mut exact = start(1e-13, 1000, t);
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
        // A lower bound: the next term of the error is still visible at these steps, above rounding.
        assert!((9.5..13.0).contains(&order), "{errors:?}: {order}");
    }
}
