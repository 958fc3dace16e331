//! The integral term of a controller.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Adds k z to f, where ż = u − ℓ is the error of the position, and |z| stops at a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct IntegralAction {
    /// k.
    pub gain: f64,
    /// The largest |z|; infinite for an unlimited one.
    #[cfg_attr(feature = "serde", serde(with = "crate::joint::number_or_infinity"))]
    pub limit: f64,
}

impl IntegralAction {
    /// ż, which is 0 at the limit for an error that would pass it.
    ///
    /// ```
    /// let integral = robot_dynamics::description::IntegralAction { gain: 3.0, limit: 0.5 };
    /// assert_eq!((integral.rate(0.2, 0.1), integral.rate(0.2, 0.5), integral.rate(-0.2, 0.5)), (0.2, 0.0, -0.2));
    /// ```
    pub fn rate(&self, error: f64, integral: f64) -> f64 {
        if integral >= self.limit {
            error.min(0.0)
        } else if integral <= -self.limit {
            error.max(0.0)
        } else {
            error
        }
    }
}
