//! Torques of a payload of 1 kg.
//!
//! With a row Y of the regressor, Y π = y₀ + h · c + cᵀ S c + ⟨Y_I, G⟩. c is the center of mass, G the
//! inertia about it for each kg. S = tr(Y_I) 1 − Y_I, as the inertia of a point is |c|² 1 − c cᵀ.
//!
//! G = tr(Σ) 1 − Σ with a positive semidefinite second moment Σ, so ⟨Y_I, G⟩ = ⟨S, Σ⟩. No principal moment
//! exceeds r² if no two eigenvalues of Σ have a larger sum. A linear function of such eigenvalues is largest
//! for Σ = 0, for a rod (one eigenvalue r²), or for a sphere (three of r²/2): a disc lies between two rods.

use nalgebra::{Matrix3, SymmetricEigen};

use crate::Interval;
use crate::linear::is_positive_definite;
use crate::support::{Vector, dot};

/// A row of the regressor for one link.
type Row = [Interval; 10];

/// The range of Y π over payloads of 1 kg with the center in a box and radii of gyration up to `radius`.
pub(super) fn range(row: &Row, center: Vector, radius: f64) -> Interval {
    let quadratic = quadratic(row);
    let middle = center.map(|x| Interval::from(x.middle()));
    // The mean-value form about the middle of the box, with the gradient h + 2 S c.
    let slope = |i: usize| row[1 + i] + Interval::from(2.0) * dot(quadratic[i], center);
    let mut mean_value = of_point(row, middle);
    for i in 0..3 {
        mean_value += slope(i) * (center[i] - middle[i]);
    }
    let located = mean_value.intersection(of_point(row, center)).unwrap_or(mean_value);
    let square = Interval::from(radius) * Interval::from(radius);
    let half = Interval::from(0.5) * (quadratic[0][0] + quadratic[1][1] + quadratic[2][2]);
    let most = eigenvalue_bound(quadratic).max(half.upper()).max(0.0);
    let least = -eigenvalue_bound(quadratic.map(|row| row.map(|x| -x))).max(-half.lower()).max(0.0);
    located + square * Interval::new(least, most)
}

/// Y π of a point of 1 kg.
pub(super) fn of_point(row: &Row, c: Vector) -> Interval {
    let s = quadratic(row);
    row[0] + dot([row[1], row[2], row[3]], c) + dot(c, s.map(|s| dot(s, c)))
}

/// The largest (`sign` 1) or least (−1) part of an extended payload of 1 kg: the best of a
/// point, a sphere, and rods near the axes of S.
pub(super) fn of_extension(row: &Row, radius: f64, sign: f64) -> Interval {
    let s = quadratic(row);
    let square = Interval::from(radius) * Interval::from(radius);
    let sphere = square * Interval::from(0.5) * (s[0][0] + s[1][1] + s[2][2]);
    let mut best = Interval::from(0.0);
    let eigen = SymmetricEigen::new(Matrix3::from_fn(|i, j| s[i][j].middle()));
    let rods = eigen.eigenvectors.column_iter().map(|u| {
        let u = [u[0], u[1], u[2]].map(Interval::from);
        // The vector has the length 1 up to rounding.
        square * dot(u, s.map(|s| dot(s, u))) / dot(u, u)
    });
    for value in rods.chain([sphere]) {
        if sign * value.middle() > sign * best.middle() {
            best = value;
        }
    }
    best
}

/// S = tr(Y_I) 1 − Y_I, where the columns of products of inertia count twice.
fn quadratic(row: &Row) -> [Vector; 3] {
    let [_, _, _, _, xx, xy, yy, xz, yz, zz] = *row;
    let half = Interval::from(-0.5);
    let [xy, xz, yz] = [xy * half, xz * half, yz * half];
    [[yy + zz, xy, xz], [xy, xx + zz, yz], [xz, yz, xx + yy]]
}

/// A number that no eigenvalue of a symmetric matrix in the intervals exceeds.
fn eigenvalue_bound(matrix: [Vector; 3]) -> f64 {
    let middle = Matrix3::from_fn(|i, j| matrix[i][j].middle());
    let near = SymmetricEigen::new(middle).eigenvalues.max();
    let size = matrix.iter().flatten().fold(0.0, |most: f64, x| most.max(x.magnitude()));
    let spread = matrix.iter().flatten().fold(0.0, |most: f64, x| most.max(x.width()));
    // Weyl: the radii of the entries change an eigenvalue by at most 3 of them. The proof is β 1 − A > 0.
    let mut margin = 1.5 * spread + 1e-14 * size;
    loop {
        let bound = near + margin;
        let shifted: Vec<Interval> = (0..9)
            .map(|k| Interval::from(if k % 4 == 0 { bound } else { 0.0 }) - matrix[k / 3][k % 3])
            .collect();
        if margin == 0.0 || is_positive_definite(&shifted, 3) {
            return bound;
        }
        margin *= 2.0;
        if !margin.is_finite() {
            return f64::INFINITY;
        }
    }
}
