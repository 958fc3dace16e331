//! min ½xᵀHx + gᵀx with lower ≤ x ≤ upper, H symmetric and positive definite: the minimum is unique.

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::cholesky;

use crate::contact::Interrupt;

/// The limit of iterations. Each one lowers the value, and the active set of bounds converges in a few.
const MOST_ROUNDS: usize = 100;

/// Problems with up to this many unknowns allocate their memory in advance.
const USUAL: usize = 256;

/// Fraction of the distance between its bounds within which an unknown counts as on a bound.
const NEXT_TO: f64 = 1e-10;

/// Relative increase of the diagonal if the matrix is singular to rounding; the step remains a descent
/// direction.
const SOFTER: f64 = 1e-10;

clone_in_place! {
    /// The dense n×n problem and its memory.
    #[derive(Debug, Default)]
    pub(super) struct BoundedProblem {
        pub(super) matrix: Vec<f64>,
        pub(super) gradient: Vec<f64>,
        pub(super) lower: Vec<f64>,
        pub(super) upper: Vec<f64>,
        pub(super) x: Vec<f64>,
        slope: Vec<f64>,
        trial: Vec<f64>,
        step: Vec<f64>,
        free: Vec<usize>,
        factor: Vec<f64>,
        /// Stops the iterations at the current value.
        pub(super) interrupt: Interrupt,
    }
}

impl BoundedProblem {
    /// Creates a problem for at most `most` unknowns; problems larger than usual allocate when they occur.
    pub(super) fn new(most: usize) -> Self {
        let most = most.min(USUAL);
        let zeros = || Vec::with_capacity(most);
        Self {
            matrix: Vec::with_capacity(most * most),
            gradient: zeros(),
            lower: zeros(),
            upper: zeros(),
            x: zeros(),
            slope: zeros(),
            trial: zeros(),
            step: zeros(),
            free: Vec::with_capacity(most),
            factor: Vec::with_capacity(most * most),
            interrupt: Interrupt::default(),
        }
    }

    /// Resizes to n unknowns, all zero.
    pub(super) fn begin(&mut self, n: usize) {
        self.begin_bounds();
        for vector in [&mut self.lower, &mut self.upper, &mut self.x] {
            vector.resize(n, 0.0);
        }
        self.make_room();
    }

    /// Starts with no unknowns; the caller adds bounds.
    pub(super) fn begin_bounds(&mut self) {
        for vector in [&mut self.lower, &mut self.upper, &mut self.x] {
            vector.clear();
        }
    }

    /// Gives unknown i this gradient and no bounds.
    pub(super) fn release(&mut self, i: usize, gradient: f64) {
        self.gradient[i] = gradient;
        (self.lower[i], self.upper[i]) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    /// Gives unknown i this gradient, and removes its bound on the side of `sign`.
    pub(super) fn release_towards(&mut self, sign: f64, i: usize, gradient: f64) {
        self.gradient[i] = gradient;
        let side = if sign > 0.0 { &mut self.upper[i] } else { &mut self.lower[i] };
        *side = sign * f64::INFINITY;
    }

    /// Resizes the matrix and the gradient to the number of bounds, with zeros.
    pub(super) fn make_room(&mut self) {
        let n = self.x.len();
        for (vector, size) in [
            (&mut self.matrix, n * n),
            (&mut self.factor, n * n),
            (&mut self.gradient, n),
            (&mut self.slope, n),
            (&mut self.trial, n),
            (&mut self.step, n),
        ] {
            vector.clear();
            vector.resize(size, 0.0);
        }
    }

    /// Newton's method on the free unknowns, projected onto the bounds. **(Bertsekas 1982)**
    ///
    /// `x` is the initial value, and each iteration lowers the objective. If the iterations do not converge,
    /// the last value is the result. Returns false if a pivot vanishes.
    pub(super) fn solve(&mut self) -> bool {
        let n = self.x.len();
        for i in 0..n {
            self.x[i] = self.x[i].max(self.lower[i]).min(self.upper[i]);
        }
        for _ in 0..MOST_ROUNDS {
            if self.interrupt.is_set() {
                return true;
            }
            self.find_slope();
            self.free.clear();
            for i in 0..n {
                let (lower, upper) = (self.lower[i], self.upper[i]);
                // An unknown next to a bound counts as on it; a step that is clipped at once would leave no
                // descent for the others.
                let range = upper - lower;
                let width =
                    if range.is_finite() { range } else { self.size_of_slope(i) / self.matrix[i * n + i] };
                let is_at = |bound: f64| (self.x[i] - bound).abs() <= NEXT_TO * width;
                if is_at(lower) && self.slope[i] > 0.0 {
                    self.x[i] = lower;
                } else if is_at(upper) && self.slope[i] < 0.0 {
                    self.x[i] = upper;
                } else if lower < upper {
                    self.free.push(i);
                }
            }
            if !self.newton_step(0.0) && !self.newton_step(SOFTER) {
                return false;
            }
            // In units of H x: converged if the step changes no significant digit.
            let is_done = self.free.iter().enumerate().all(|(k, &i)| {
                let scale = self.x[i].abs().max(self.step[k].abs());
                self.step[k].abs() <= 1e-14 * scale || self.slope[i].abs() <= 1e-15 * self.size_of_slope(i)
            });
            if is_done {
                return true;
            }
            if !self.descend() {
                return true;
            }
        }
        true
    }

    /// The gradient Hx + g.
    fn find_slope(&mut self) {
        let n = self.x.len();
        for i in 0..n {
            let row = &self.matrix[i * n..(i + 1) * n];
            self.slope[i] = self.gradient[i] + row.iter().zip(&self.x).map(|(h, x)| h * x).sum::<f64>();
        }
    }

    /// The sum of the magnitudes of the terms in the gradient.
    fn size_of_slope(&self, i: usize) -> f64 {
        let n = self.x.len();
        let row = &self.matrix[i * n..(i + 1) * n];
        self.gradient[i].abs() + row.iter().zip(&self.x).map(|(h, x)| (h * x).abs()).sum::<f64>()
    }

    /// `step` = −H_ff⁻¹ slope_f, where the diagonal of H_ff is larger by this fraction; false if it is not
    /// positive definite.
    fn newton_step(&mut self, larger: f64) -> bool {
        let (n, count) = (self.x.len(), self.free.len());
        let (factor, step) = (&mut self.factor[..count * count], &mut self.step[..count]);
        for (k, &i) in self.free.iter().enumerate() {
            step[k] = -self.slope[i];
            for (l, &j) in self.free[..=k].iter().enumerate() {
                factor[k * count + l] = self.matrix[i * n + j];
            }
            factor[k * count + k] *= 1.0 + larger;
        }
        // A pivot that is not positive makes the step NaN or infinite.
        cholesky::factor(factor, count);
        cholesky::solve(factor, count, step);
        step.iter().all(|step| step.is_finite())
    }

    /// Follows the projected step until the value decreases; returns false at the minimum to rounding.
    fn descend(&mut self) -> bool {
        let mut length = 1.0;
        for _ in 0..40 {
            self.trial.copy_from_slice(&self.x);
            for (k, &i) in self.free.iter().enumerate() {
                self.trial[i] = (self.x[i] + length * self.step[k]).max(self.lower[i]).min(self.upper[i]);
            }
            // f(trial) − f(x) = slopeᵀd + ½dᵀHd with d = trial − x avoids a difference of large numbers.
            let n = self.x.len();
            let mut fall = 0.0;
            for i in 0..n {
                let d = self.trial[i] - self.x[i];
                let row = &self.matrix[i * n..(i + 1) * n];
                let curved: f64 = (0..n).map(|j| row[j] * (self.trial[j] - self.x[j])).sum();
                fall += d * (self.slope[i] + 0.5 * curved);
            }
            if fall < 0.0 {
                self.x.copy_from_slice(&self.trial);
                return true;
            }
            length *= 0.5;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::BoundedProblem;

    /// Random problems with up to 12 unknowns: the result satisfies the conditions of the minimum.
    #[test]
    fn the_answer_is_the_minimum() {
        let mut random = SplitMix64::new(7);
        for case in 0..300 {
            let n = 1 + case % 12;
            let mut problem = BoundedProblem::new(12);
            problem.begin(n);
            let root: Vec<f64> = (0..n * n).map(|_| random.uniform(-1.0, 1.0)).collect();
            for i in 0..n {
                for j in 0..n {
                    let product: f64 = (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum();
                    problem.matrix[i * n + j] = product + if i == j { 1e-3 } else { 0.0 };
                }
                problem.gradient[i] = random.uniform(-1.0, 1.0);
                // Some bounds coincide with the initial value, or differ from it by rounding.
                let nearness = [1.0, 0.0, 1e-17][case % 5 % 3];
                problem.lower[i] = -nearness * random.uniform(0.0, 1.0);
                problem.upper[i] = if case % 3 == 0 { f64::INFINITY } else { random.uniform(0.0, 1.0) };
            }
            assert!(problem.solve(), "case {case}");
            problem.find_slope();
            for i in 0..n {
                let (x, slope) = (problem.x[i], problem.slope[i]);
                assert!(problem.lower[i] <= x && x <= problem.upper[i], "case {case}");
                // κ(H) reaches 1e4, so a gradient of 1e-11 is rounding.
                let is_still = slope.abs() < 1e-11;
                let is_held =
                    (x == problem.lower[i] && slope >= 0.0) || (x == problem.upper[i] && slope <= 0.0);
                assert!(is_still || is_held, "case {case}: x {x}, slope {slope}");
            }
        }
    }
}
