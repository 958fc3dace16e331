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

/// Π and its slopes: 1 inside, 0 in the polar cone, else those of [`project_to_border`].
pub(super) fn project_with_slopes(slope: f64, p: &mut [f64]) -> Slopes {
    let (normal, side) = (p[0], norm(&p[1..]));
    if side <= slope * normal {
        return within(p.len());
    }
    if slope * side <= -normal {
        p.fill(0.0);
        return within(0);
    }
    project_to_border(slope, p)
}

/// Π as it is between the cone and its polar, wherever p is, and its slopes wwᵀ + (μp_n/|y_t|)(1 − eeᵀ) with w = (1, μe)/√(1 + μ²).
pub(super) fn project_to_border(slope: f64, p: &mut [f64]) -> Slopes {
    let mut slopes = within(0);
    let (normal, side) = (p[0], norm(&p[1..]));
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
    slopes
}

/// ∂Π.
pub(super) type Slopes = [[f64; MOST_ROWS]; MOST_ROWS];

/// p ← Π(p); the slopes of Π there.
pub(super) fn project_onto(set: Set, p: &mut [f64]) -> Slopes {
    match set {
        Set::Interval(lower, upper) => {
            let slopes = within(usize::from(p[0] > lower && p[0] < upper));
            p[0] = p[0].max(lower).min(upper);
            slopes
        }
        Set::Cone(slope) => project_with_slopes(slope, p),
    }
}

/// The slopes of so many rows that stick: 1. Of none: 0.
pub(super) fn within(rows: usize) -> Slopes {
    let mut slopes = [[0.0; MOST_ROWS]; MOST_ROWS];
    (0..rows).for_each(|k| slopes[k][k] = 1.0);
    slopes
}

/// Where a multiplier acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// On a bound, or it does not act.
    Elsewhere,
    /// Within its set: its row sticks.
    Within,
    /// On the border of its cone: its contact slides.
    Border,
}

/// Where the projection with these slopes put it: the normal's own tells.
pub(super) fn place_by(slopes: &Slopes) -> Place {
    match slopes[0][0] {
        0.0 => Place::Elsewhere,
        1.0 => Place::Within,
        _ => Place::Border,
    }
}

/// Whether p is between the bounds and not, but for rounding, on one of them.
fn is_between(p: f64, lower: f64, upper: f64) -> bool {
    let rounding = 1e-9 * lower.abs().min(upper.abs()).max(p.abs());
    p - lower > rounding && upper - p > rounding
}

/// Where this one is.
pub(super) fn place_of(set: Set, p: &[f64]) -> Place {
    match set {
        Set::Interval(lower, upper) if is_between(p[0], lower, upper) => Place::Within,
        // But for rounding.
        Set::Cone(slope) if p[0] > 0.0 && norm(&p[1..]) * (1.0 + 1e-9) <= slope * p[0] => Place::Within,
        Set::Cone(_) if p[0] > 0.0 && p.len() > 1 => Place::Border,
        _ => Place::Elsewhere,
    }
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
