//! Intervals as numbers of the recursions.

use robot_dynamics_number::Scalar;

use crate::Interval;
use crate::elementary;

impl Scalar for Interval {
    type Triple = [Self; 3];
    type Symmetric = [Self; 6];

    fn from_f64(x: f64) -> Self {
        Self::from(x)
    }

    /// Enclosures of sine and cosine; see the rounding rules of the crate.
    fn sin_cos(self) -> (Self, Self) {
        elementary::sin_cos(self)
    }

    /// The roots of the numbers that are not negative; the whole line if there are none.
    fn sqrt(self) -> Self {
        if self.upper() < 0.0 {
            return Self::ENTIRE;
        }
        let lower = self.lower().max(0.0).sqrt().next_down().max(0.0);
        Self::new(lower, if self.upper() == 0.0 { 0.0 } else { self.upper().sqrt().next_up() })
    }

    fn signum0(self) -> Self {
        Self::new(self.lower().signum0(), self.upper().signum0())
    }
}
