//! How adaptive steps are taken.

use thiserror::Error;

use super::AdaptiveMethod;

/// The least and the most tolerance: below, a step's error is its rounding; above, it says nothing.
const TOLERANCES: (f64, f64) = (1e-13, 1e-2);

/// How adaptive steps are taken: Runge–Kutta steps with error control, for accurate motions over short and middle times; explicit ones
/// of order 9, or implicit ones of order 5 where damping is stiff ([`AdaptiveMethod`]).
///
/// The state (q, v) together with the work and the dissipation is integrated as one equation; the local error of
/// each entry x is kept below tolerance·(1 + |x|) \[rad, m, s, J\]. Nothing of the motion's structure is kept: for
/// long runs take a variational row.
///
/// ```
/// use multibody::{AdaptiveOptions, ControlTiming};
/// let options = AdaptiveOptions { tolerance: 1e-12, ..AdaptiveOptions::default() };
/// assert_eq!((options.control, options.max_steps), (ControlTiming::Continuous, 1_000_000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveOptions {
    /// The local error allowed, relative and absolute, from 1e-13 to 1e-2.
    pub tolerance: f64,
    /// How steps are taken.
    pub method: AdaptiveMethod,
    /// When a controller is asked.
    pub control: ControlTiming,
    /// Steps from one sample or control instant to the next after which the run is given up, rejected ones counted.
    pub max_steps: usize,
}

impl Default for AdaptiveOptions {
    /// Tolerance 1e-9, the method that the robot needs, continuous control, a million steps between samples.
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            method: AdaptiveMethod::Automatic,
            control: ControlTiming::Continuous,
            max_steps: 1_000_000,
        }
    }
}

/// When a controller is asked for its torque.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ControlTiming {
    /// At every evaluation of the motion: τ(t, q, v) as a continuous law. Steps are tried and taken back, so the
    /// torque must depend on (t, q, v) alone, and smoothly.
    #[default]
    Continuous,
    /// At the start and every so many seconds after it, and held in between, as a digital controller; no step goes
    /// across such an instant.
    Held {
        /// The control period \[s\].
        period: f64,
    },
}

/// Why adaptive steps cannot be taken so.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AdaptiveOptionsError {
    /// A tolerance that no step can meet, or that says nothing.
    #[error("the tolerance must lie between {least:e} and {most:e}, got {tolerance:e}")]
    Tolerance {
        /// The tolerance given.
        tolerance: f64,
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
    /// An invalid control period.
    #[error("the control period must be positive and finite, got {period} s")]
    Period {
        /// The period given \[s\].
        period: f64,
    },
}

impl AdaptiveOptions {
    pub(crate) fn check(&self) -> Result<(), AdaptiveOptionsError> {
        if let ControlTiming::Held { period } = self.control
            && !(period > 0.0 && period.is_finite())
        {
            return Err(AdaptiveOptionsError::Period { period });
        }
        let (least, most) = TOLERANCES;
        if !(least..=most).contains(&self.tolerance) {
            return Err(AdaptiveOptionsError::Tolerance { tolerance: self.tolerance, least, most });
        }
        Ok(())
    }
}
