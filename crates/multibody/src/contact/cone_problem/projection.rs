//! The projection onto a cone, and its slopes.

use super::{MOST_ROWS, Set};

/// Π onto { |p_t| ≤ μp_n }.
pub(super) fn project(slope: f64, p: &mut [f64]) {
    let (normal, side) = (p[0], norm(&p[1..]));
    if side <= slope * normal {
        return;
    }
    if slope * side <= -normal {
        p.fill(0.0);
        return;
    }
    let at = (normal + slope * side) / (1.0 + slope * slope);
    p[0] = at;
    p[1..].iter_mut().for_each(|p| *p *= slope * at / side);
}

/// Π and its slopes: 1 inside, 0 in the polar cone, else wwᵀ + (μp_n/|y_t|)(1 − eeᵀ) with w = (1, μe)/√(1 + μ²).
pub(super) fn project_with_slopes(slope: f64, p: &mut [f64], slopes: &mut [[f64; MOST_ROWS]; MOST_ROWS]) {
    let (normal, side) = (p[0], norm(&p[1..]));
    if side <= slope * normal {
        (0..p.len()).for_each(|k| slopes[k][k] = 1.0);
        return;
    }
    if slope * side <= -normal {
        p.fill(0.0);
        return;
    }
    let share = 1.0 / (1.0 + slope * slope);
    let at = (normal + slope * side) * share;
    let turn = slope * at / side;
    slopes[0][0] = share;
    for i in 1..p.len() {
        let e = p[i] / side;
        slopes[0][i] = share * slope * e;
        slopes[i][0] = slopes[0][i];
        for j in 1..p.len() {
            let other = p[j] / side;
            let own = if i == j { turn } else { 0.0 };
            slopes[i][j] = own + (share * slope * slope - turn) * e * other;
        }
    }
    p[0] = at;
    p[1..].iter_mut().for_each(|p| *p *= turn);
}

/// ∂Π.
pub(super) type Slopes = [[f64; MOST_ROWS]; MOST_ROWS];

/// p ← Π(p); the slopes of Π there.
pub(super) fn project_onto(set: Set, p: &mut [f64]) -> Slopes {
    let mut slopes = [[0.0; MOST_ROWS]; MOST_ROWS];
    match set {
        Set::Interval(lower, upper) => {
            if p[0] > lower && p[0] < upper {
                slopes[0][0] = 1.0;
            }
            p[0] = p[0].max(lower).min(upper);
        }
        Set::Cone(slope) => project_with_slopes(slope, p, &mut slopes),
    }
    slopes
}

/// The slopes of Π at a multiplier that acts and has its place: within its set, or on the border of its cone, where it slides.
pub(super) fn slopes_at(set: Set, p: &[f64]) -> Option<Slopes> {
    let acts = match set {
        Set::Interval(lower, upper) => p[0] > lower && p[0] < upper && p[0] != 0.0,
        Set::Cone(_) => p[0] > 0.0,
    };
    acts.then(|| {
        let mut at = [0.0; MOST_ROWS];
        at[..p.len()].copy_from_slice(p);
        // From a rounding inside of the border to outside.
        at[1..].iter_mut().for_each(|x| *x *= 1.0 + 1e-9);
        project_onto(set, &mut at[..p.len()])
    })
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
