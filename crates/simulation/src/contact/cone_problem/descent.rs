//! The line search along a Newton step.

use super::ConeProblem;
use super::entries::dot;
use super::tolerances::TOLERANCES;

impl ConeProblem {
    /// Moves along δ to a point where the objective is nearly minimal, and evaluates the blocks there as
    /// [`respond`](Self::respond) does. It takes the full step if the derivative there is small, and a line
    /// search otherwise. Returns whether every block acts as in the last factor.
    pub(super) fn descend(&mut self, curvature: f64, decrease: f64, is_begun: bool) -> bool {
        let level = dot(&self.residual, &self.step);
        let acts_as_before = self.respond(1.0, false);
        let at_end = level + curvature - self.pull();
        if at_end.abs() <= TOLERANCES.step_slope * decrease {
            self.advance(1.0);
            return acts_as_before;
        }
        let first = if is_begun { -decrease } else { level - self.evaluate(0.0) };
        let length = self.line_search(level, curvature, [first, at_end]);
        self.advance(length);
        // At an intermediate point, the blocks may act differently than in the last factor.
        self.known.is_factored &= length == 1.0;
        self.respond(0.0, false) && acts_as_before
    }

    /// Returns the length at which the objective along δ is minimal, 0 if it increases from the start.
    ///
    /// Its derivative is δᵀ(M x + f) + t δᵀM δ − (A δ)ᵀp, which increases with t. `level` is the first term,
    /// `curvature` the factor of t, and `first` and `at_end` are the derivatives at t = 0 and t = 1.
    fn line_search(&mut self, level: f64, curvature: f64, [first, at_end]: [f64; 2]) -> f64 {
        let mut slope_at = |t: f64| level + t * curvature - self.evaluate(t);
        if first >= 0.0 {
            return 0.0;
        }
        let (mut low, mut high, mut at_low, mut at_high) = (0.0, 1.0, first, at_end);
        if at_high.abs() <= TOLERANCES.step_slope * first.abs() {
            return 1.0;
        }
        for _ in 0..TOLERANCES.step_doublings {
            if at_high >= 0.0 {
                break;
            }
            (low, at_low) = (high, at_high);
            high *= 2.0;
            at_high = slope_at(high);
        }
        // Regula falsi that halves the weight of an end that stays (Illinois).
        let mut side = 0;
        for _ in 0..TOLERANCES.regula_falsi_steps {
            let t = if at_high > at_low {
                low - at_low * (high - low) / (at_high - at_low)
            } else {
                0.5 * (low + high)
            };
            let slope = slope_at(t);
            if slope.abs() <= TOLERANCES.search_slope * first.abs() {
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
