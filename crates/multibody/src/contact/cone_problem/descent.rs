//! How far along a step of Newton's method the value falls.

use super::ConeProblem;
use super::entries::dot;

/// The end of a step is good where the slope there is at most this part of what it was.
const LEVEL: f64 = 0.1;

impl ConeProblem {
    /// Goes along δ to where the value is nearly least, and answers there, as [`respond`](Self::respond): at once to the end of it where the slope is
    /// nearly level there, else where the line search says.
    pub(super) fn go_down(&mut self, bend: f64, fall: f64, is_begun: bool) -> bool {
        let level = dot(&self.drag, &self.step);
        let acts_as_before = self.respond(1.0, false);
        let at_end = level + bend - self.pull();
        if at_end.abs() <= LEVEL * fall {
            self.go(1.0);
            return acts_as_before;
        }
        let first = if is_begun { -fall } else { level - self.evaluate(0.0) };
        let length = self.line_search(level, bend, [first, at_end]);
        self.go(length);
        // Of a place on the way it is not known whether each block acts there as in the last factor.
        self.known.is_factored &= length == 1.0;
        self.respond(0.0, false) && acts_as_before
    }

    /// The length at which the value along δ is least, 0 where it grows. Its derivative δᵀ(M x + f) + t δᵀM δ − (A δ)ᵀp grows with t, from `level` of its
    /// first term; where δ begins and where it ends it is known.
    fn line_search(&mut self, level: f64, bend: f64, [first, at_end]: [f64; 2]) -> f64 {
        let mut slope_at = |t: f64| level + t * bend - self.evaluate(t);
        if first >= 0.0 {
            return 0.0;
        }
        let (mut low, mut high, mut at_low, mut at_high) = (0.0, 1.0, first, at_end);
        if at_high.abs() <= LEVEL * first.abs() {
            return 1.0;
        }
        for _ in 0..60 {
            if at_high >= 0.0 {
                break;
            }
            (low, at_low) = (high, at_high);
            high *= 2.0;
            at_high = slope_at(high);
        }
        // Regula falsi, halving the weight of an end that stays (Illinois).
        let mut side = 0;
        for _ in 0..40 {
            let t = if at_high > at_low {
                low - at_low * (high - low) / (at_high - at_low)
            } else {
                0.5 * (low + high)
            };
            let slope = slope_at(t);
            if slope.abs() <= 0.01 * first.abs() {
                return t;
            }
            if slope < 0.0 {
                (low, at_low) = (t, slope);
                if side == -1 {
                    at_high *= 0.5;
                }
                side = -1;
            } else {
                (high, at_high) = (t, slope);
                if side == 1 {
                    at_low *= 0.5;
                }
                side = 1;
            }
        }
        if low > 0.0 { low } else { 0.5 * (low + high) }
    }
}
