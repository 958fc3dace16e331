//! Options of adaptive steps.

use std::ops::RangeInclusive;

use robot_dynamics_number::{InvalidInput, check_positive};

use super::AdaptiveMethod;

/// Options of adaptive Runge–Kutta steps with error control, for accurate motions over short and medium
/// times. The steps are explicit of order 9, or implicit of order 5 if damping is stiff ([`AdaptiveMethod`]).
///
/// One equation integrates the state (q, v), the work and the dissipation. The local error of each entry x
/// stays below tolerance·(1 + |x|) \[rad, m, s, J\]. The steps do not preserve the geometric structure of the
/// motion; for long runs use a variational row.
///
/// ```
/// use robot_dynamics::simulation::{AdaptiveOptions, ControlTiming};
/// let options = AdaptiveOptions { tolerance: 1e-12, ..AdaptiveOptions::default() };
/// assert_eq!((options.control, options.max_steps), (ControlTiming::Continuous, 1_000_000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveOptions {
    /// The allowed local error, relative and absolute, from 1e-13 to 1e-2.
    pub tolerance: f64,
    /// The method of the steps.
    pub method: AdaptiveMethod,
    /// The times at which the controller is called.
    pub control: ControlTiming,
    /// The most attempted steps between two samples or control instants, rejected steps included; beyond it
    /// the run fails.
    pub max_steps: usize,
}

impl Default for AdaptiveOptions {
    /// Tolerance 1e-9, automatic choice of the method, continuous control, and a million steps between
    /// samples.
    fn default() -> Self {
        Self {
            tolerance: Self::DEFAULT_TOLERANCE,
            method: AdaptiveMethod::Automatic,
            control: ControlTiming::Continuous,
            max_steps: 1_000_000,
        }
    }
}

/// The times at which a controller is called.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ControlTiming {
    /// At every evaluation of the motion, as a continuous control law τ(t, q, v). Steps can be rejected, so
    /// the torque must depend smoothly on (t, q, v) and on nothing else.
    #[default]
    Continuous,
    /// At the start and then once a period, with the torque held in between, as a digital controller. Steps
    /// end at these instants.
    Held {
        /// The control period \[s\].
        period: f64,
    },
}

impl AdaptiveOptions {
    /// The default tolerance.
    pub const DEFAULT_TOLERANCE: f64 = 1e-9;

    /// The allowed tolerances. Below, rounding dominates the error of a step; above, the result is not
    /// meaningful.
    pub const TOLERANCE_RANGE: RangeInclusive<f64> = 1e-13..=1e-2;

    pub(crate) fn check(&self) -> Result<(), InvalidInput> {
        if let ControlTiming::Held { period } = self.control {
            check_positive("the control period", period, "s")?;
        }
        let range = Self::TOLERANCE_RANGE;
        if !range.contains(&self.tolerance) {
            let (least, most) = (range.start(), range.end());
            let requirement = format!("between {least:e} and {most:e}");
            return Err(InvalidInput::out_of_range("the tolerance", self.tolerance, "", requirement));
        }
        Ok(())
    }
}
