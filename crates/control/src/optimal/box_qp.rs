//! The quadratic program with bounds of a node: minimize ½ δᵀH δ + gᵀδ with l ≤ δ ≤ h.
//!
//! A projected Newton method. Each step fixes the entries at a bound whose gradient points outwards, factors
//! H of the free ones, and searches along the projected step. It ends at the exact solution after finitely
//! many sets of free entries.
//!
//! Sources: Tassa, Mansard, Todorov, *Control-limited differential dynamic programming*, ICRA 2014;
//! Bertsekas, *Projected Newton methods for optimization problems with simple constraints*, SIAM J. Control
//! 20 (1982).

use super::dense::{add_matrix_vector, dot, factorize, solve_factored};

/// The steps after which the last point is taken.
const MOST_STEPS: usize = 100;

/// The share of the predicted decrease that a step must reach.
const ARMIJO: f64 = 0.1;

/// The shortest step of the search; a shorter one only changes rounding.
const SHORTEST: f64 = 1e-10;

/// The result of [`BoxQp::solve`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoxQpStatus {
    Solved,
    /// H of the free entries is not positive definite.
    Indefinite,
    /// The steps were used up.
    NotConverged,
}

/// The memory of the quadratic program with m entries.
#[derive(Clone, Debug)]
pub(super) struct BoxQp {
    /// The free entries, ascending.
    free: Vec<usize>,
    /// The free entries of which `factor` is the factor.
    factored: Vec<usize>,
    factor: Vec<f64>,
    gradient: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
}

impl BoxQp {
    pub(super) fn new(m: usize) -> Self {
        Self {
            free: Vec::with_capacity(m),
            factored: Vec::with_capacity(m),
            factor: vec![0.0; m * m],
            gradient: vec![0.0; m],
            step: vec![0.0; m],
            trial: vec![0.0; m],
        }
    }

    /// Minimizes from `delta`, which is first moved within the bounds, and leaves the minimizer there.
    pub(super) fn solve(
        &mut self,
        hessian: &[f64],
        gradient: &[f64],
        bounds: (&[f64], &[f64]),
        delta: &mut [f64],
    ) -> BoxQpStatus {
        clamp(delta, bounds);
        let mut was_exact = false;
        for step in 0..MOST_STEPS {
            self.gradient.copy_from_slice(gradient);
            add_matrix_vector(hessian, delta, &mut self.gradient);
            self.find_free(bounds, delta);
            let is_same = step > 0 && self.free == self.factored;
            if !is_same && !self.factorize_free(hessian) {
                return BoxQpStatus::Indefinite;
            }
            if self.free.is_empty() || (is_same && was_exact) {
                return BoxQpStatus::Solved;
            }
            self.newton_step();
            match self.search(bounds, hessian, delta) {
                Some(exact) => was_exact = exact,
                // Only rounding is left.
                None => return BoxQpStatus::Solved,
            }
        }
        BoxQpStatus::NotConverged
    }

    /// The entries that are not held at a bound by their gradient.
    fn find_free(&mut self, (lower, upper): (&[f64], &[f64]), delta: &[f64]) {
        self.free.clear();
        for (i, &g) in self.gradient.iter().enumerate() {
            let is_held = (delta[i] <= lower[i] && g > 0.0) || (delta[i] >= upper[i] && g < 0.0);
            if !is_held && lower[i] < upper[i] {
                self.free.push(i);
            }
        }
    }

    /// Factors H of the free entries; returns whether it is positive definite.
    fn factorize_free(&mut self, hessian: &[f64]) -> bool {
        let (m, count) = (self.gradient.len(), self.free.len());
        self.factored.clone_from(&self.free);
        for (row, &i) in self.free.iter().enumerate() {
            for (column, &j) in self.free[..=row].iter().enumerate() {
                self.factor[row * count + column] = hessian[i * m + j];
            }
        }
        factorize(count, &mut self.factor[..count * count])
    }

    /// The Newton step −H⁻¹g of the free entries; the others are zero.
    fn newton_step(&mut self) {
        let count = self.free.len();
        for (to, &i) in self.trial.iter_mut().zip(&self.free) {
            *to = -self.gradient[i];
        }
        solve_factored(count, &self.factor[..count * count], 1, &mut self.trial[..count]);
        self.step.fill(0.0);
        for (&i, step) in self.free.iter().zip(&self.trial) {
            self.step[i] = *step;
        }
    }

    /// Moves along the projected step as far as the cost decreases enough. Returns whether it was the full
    /// step within the bounds; `None` if no step decreases the cost.
    fn search(&mut self, bounds: (&[f64], &[f64]), hessian: &[f64], delta: &mut [f64]) -> Option<bool> {
        let mut length = 1.0;
        while length > SHORTEST {
            for ((trial, delta), step) in self.trial.iter_mut().zip(&*delta).zip(&self.step) {
                *trial = delta + length * step;
            }
            let is_clamped = clamp(&mut self.trial, bounds);
            // f(δ + d) − f(δ) = gᵀd + ½ dᵀH d, with d in `trial`.
            self.trial.iter_mut().zip(&*delta).for_each(|(trial, delta)| *trial -= delta);
            let slope = dot(&self.gradient, &self.trial);
            let rows = hessian.chunks_exact(delta.len()).zip(&self.trial);
            let curvature: f64 = rows.map(|(row, d)| d * dot(row, &self.trial)).sum();
            if slope < 0.0 && slope + 0.5 * curvature <= ARMIJO * slope {
                delta.iter_mut().zip(&self.trial).for_each(|(delta, d)| *delta += d);
                clamp(delta, bounds);
                return Some(length == 1.0 && !is_clamped);
            }
            length *= 0.5;
        }
        None
    }

    /// The free entries of the solution, and the factor of their H.
    pub(super) fn free(&self) -> (&[usize], &[f64]) {
        let count = self.free.len();
        (&self.free, &self.factor[..count * count])
    }
}

/// Moves each entry within its bounds; returns whether one moved.
fn clamp(x: &mut [f64], (lower, upper): (&[f64], &[f64])) -> bool {
    let mut is_clamped = false;
    for ((x, low), high) in x.iter_mut().zip(lower).zip(upper) {
        let inside = x.max(*low).min(*high);
        is_clamped |= inside != *x;
        *x = inside;
    }
    is_clamped
}

#[cfg(test)]
mod tests {
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// The conditions of Karush, Kuhn and Tucker on random problems: at a bound the gradient points outwards,
    /// elsewhere it vanishes to the rounding of H δ.
    #[test]
    fn solutions_are_optimal() {
        let mut random = SplitMix64::new(7);
        for case in 0..400 {
            let m = 1 + case % 7;
            let half: Vec<f64> = (0..m * m).map(|_| random.uniform(-1.0, 1.0)).collect();
            let entry = |i: usize, j: usize| dot(&half[i * m..][..m], &half[j * m..][..m]);
            let hessian: Vec<f64> =
                (0..m * m).map(|k| entry(k / m, k % m) + if k % (m + 1) == 0 { 0.1 } else { 0.0 }).collect();
            let gradient: Vec<f64> = (0..m).map(|_| random.uniform(-2.0, 2.0)).collect();
            let lower: Vec<f64> = (0..m).map(|_| random.uniform(-1.0, 0.3)).collect();
            let upper: Vec<f64> = lower.iter().map(|l| l + random.uniform(0.0, 1.0)).collect();
            let (mut qp, mut delta) = (BoxQp::new(m), vec![0.0; m]);
            let status = qp.solve(&hessian, &gradient, (&lower, &upper), &mut delta);
            assert_eq!(status, BoxQpStatus::Solved, "case {case}");
            let mut slope = gradient.clone();
            add_matrix_vector(&hessian, &delta, &mut slope);
            for i in 0..m {
                let tolerance = 1e-12;
                assert!(delta[i] >= lower[i] && delta[i] <= upper[i]);
                assert!(slope[i] >= -tolerance || delta[i] == upper[i], "case {case}, {i}: {}", slope[i]);
                assert!(slope[i] <= tolerance || delta[i] == lower[i], "case {case}, {i}: {}", slope[i]);
            }
        }
    }
}
