//! Runs whose steps are as long as a tolerance allows.

use robot_dynamics::{AdaptiveSimulation, ControlTiming, Model};

/// What a run with adaptive steps is told beside what every run is.
pub(crate) struct Adaptive {
    pub(super) tolerance: f64,
    /// How long a torque is held; none for a law that is asked all along.
    pub(super) control_period: Option<f64>,
}

impl Adaptive {
    /// The run; `period` is that of torques which say it themselves.
    pub(super) fn of<'a>(
        &self,
        model: &'a Model,
        dissipation: bool,
        period: Option<f64>,
    ) -> AdaptiveSimulation<'a> {
        let held = self.control_period.or(period);
        AdaptiveSimulation {
            tolerance: self.tolerance,
            dissipation,
            control: held.map_or(ControlTiming::Continuous, |period| ControlTiming::Held { period }),
            ..AdaptiveSimulation::of(model)
        }
    }
}

/// The times of the samples: every so many steps, none on the way for 0, and the end.
pub(super) fn times(steps: usize, step: f64, every: usize) -> Vec<f64> {
    let every = if every == 0 { steps.max(1) } else { every };
    let samples = (0..steps).step_by(every).chain([steps]);
    #[allow(clippy::cast_precision_loss)] // below 1e12
    samples.map(|k| k as f64 * step).collect()
}
