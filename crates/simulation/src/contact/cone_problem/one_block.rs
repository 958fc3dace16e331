//! The impulse of one block, with all others fixed: it separates, sticks or slides.

use super::projection::norm;
use super::set::{MOST_ROWS, Set};
use super::tolerances::TOLERANCES;

/// Computes the impulse p of one block by its law. c is its velocity under the previous p. Returns the
/// sliding speed, 0 if it sticks.
#[inline(always)]
pub(super) fn solve_block(set: Set, inertia: &[f64], c: &[f64], p: &mut [f64]) -> f64 {
    let rows = c.len();
    match set {
        Set::Interval(lower, upper) => {
            if inertia[0] > 0.0 {
                p[0] = (p[0] - c[0] / inertia[0]).max(lower).min(upper);
            }
            0.0
        }
        Set::Cone(slope) => {
            if inertia[0] <= 0.0 {
                return 0.0;
            }
            let mut free = [0.0; MOST_ROWS];
            for i in 0..rows {
                let own: f64 = (0..rows).map(|j| inertia[i * rows + j] * p[j]).sum();
                free[i] = c[i] - own;
            }
            if free[0] >= 0.0 {
                p.fill(0.0);
                return norm(&free[1..rows]);
            }
            let mut stuck = free.map(|c| -c);
            let mut factor = [0.0; MOST_ROWS * MOST_ROWS];
            factor[..rows * rows].copy_from_slice(inertia);
            if factor_dense(&mut factor, rows) {
                solve_dense(&factor, &mut stuck[..rows]);
                if norm(&stuck[1..rows]) <= slope * stuck[0] {
                    p.copy_from_slice(&stuck[..rows]);
                    return 0.0;
                }
            }
            slip(slope, inertia, &free[..rows], p)
        }
    }
}

/// Computes the impulse of a sliding contact. Returns the sliding speed.
#[inline(always)]
fn slip(slope: f64, inertia: &[f64], free: &[f64], p: &mut [f64]) -> f64 {
    let rows = free.len();
    let along = |r: usize, p: &[f64]| free[r] + (0..rows).map(|j| inertia[r * rows + j] * p[j]).sum::<f64>();
    let side: f64 = (1..rows).map(|r| inertia[r * rows + r]).fold(0.0, f64::max);
    let mut speeds = [0.0; MOST_ROWS];
    for _ in 0..TOLERANCES.slip_iterations {
        let before = p[0];
        p[0] = (p[0] - along(0, p) / inertia[0]).max(0.0);
        let mut changed = (p[0] - before).abs();
        for r in 1..rows {
            speeds[r] = along(r, p);
        }
        let mut next = [0.0; MOST_ROWS];
        for r in 1..rows {
            next[r] = p[r] - speeds[r] / side;
        }
        let length = norm(&next[1..rows]);
        let shrink = if length > slope * p[0] { slope * p[0] / length } else { 1.0 };
        for r in 1..rows {
            changed = changed.max((shrink * next[r] - p[r]).abs());
            p[r] = shrink * next[r];
        }
        if changed <= TOLERANCES.slip_change * p[0] {
            break;
        }
    }
    for r in 1..rows {
        speeds[r] = along(r, p);
    }
    norm(&speeds[1..rows])
}

/// Computes L of a square matrix given by its lower half. Returns false if it is not positive definite.
#[inline(always)]
pub(super) fn factor_dense(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            let left = a[i * n + j] - known;
            if i > j {
                a[i * n + j] = left / a[j * n + j];
            } else if left > 0.0 && left.is_finite() {
                a[i * n + i] = left.sqrt();
            } else {
                return false;
            }
        }
    }
    true
}

/// x ← (L Lᵀ)⁻¹x.
#[inline(always)]
pub(super) fn solve_dense(factor: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let known: f64 = (0..i).map(|k| factor[i * n + k] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i * n + i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| factor[k * n + i] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i * n + i];
    }
}
