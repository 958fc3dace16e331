//! The projection onto a friction cone, and its derivative.

use super::set::{MOST_ROWS, Set};
use super::tolerances::TOLERANCES;

/// Projects p onto the cone |p_t| ≤ μp_n.
#[inline(always)]
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
    let turn = slope * at / side;
    p[1..].iter_mut().for_each(|p| *p *= turn);
}

/// Projects p. Returns the derivative: 1 inside, 0 in the polar cone, and that of [`project_to_border`]
/// elsewhere.
#[inline(always)]
pub(super) fn project_with_derivative(slope: f64, p: &mut [f64]) -> ProjectionDerivative {
    let (normal, side) = (p[0], norm(&p[1..]));
    if side <= slope * normal {
        return ProjectionDerivative::WITHIN;
    }
    if slope * side <= -normal {
        p.fill(0.0);
        return ProjectionDerivative::ELSEWHERE;
    }
    project_to_border(slope, p)
}

/// Projects p by the formula for points between the cone and its polar, whatever p is. Returns the derivative
/// wwᵀ + (μp_n/|y_t|)(1 − eeᵀ) with w = (1, μe)/√(1 + μ²).
#[inline(always)]
pub(super) fn project_to_border(slope: f64, p: &mut [f64]) -> ProjectionDerivative {
    let mut derivatives =
        ProjectionDerivative { place: MultiplierZone::Border, slope, ..ProjectionDerivative::ELSEWHERE };
    let (normal, side) = (p[0], norm(&p[1..]));
    derivatives.share = 1.0 / (1.0 + slope * slope);
    let at = (normal + slope * side) * derivatives.share;
    derivatives.turn = slope * at / side;
    for (e, p) in derivatives.direction.iter_mut().zip(&mut p[1..]) {
        *e = *p / side;
        *p *= derivatives.turn;
    }
    p[0] = at;
    derivatives
}

/// The derivative ∂Π.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProjectionDerivative {
    /// The zone: the derivative is 1 within the cone, 0 elsewhere, and on the border that of the fields
    /// below.
    pub(super) place: MultiplierZone,
    /// μ, 1/(1 + μ²), μp_n/|y_t| and the direction e.
    slope: f64,
    share: f64,
    turn: f64,
    direction: [f64; MOST_ROWS - 1],
}

impl ProjectionDerivative {
    pub(super) const WITHIN: Self = Self { place: MultiplierZone::Interior, ..Self::ELSEWHERE };
    pub(super) const ELSEWHERE: Self = Self {
        place: MultiplierZone::Elsewhere,
        slope: 0.0,
        share: 0.0,
        turn: 0.0,
        direction: [0.0; MOST_ROWS - 1],
    };

    /// ∂Π_i/∂y_n on the border.
    #[inline(always)]
    pub(super) fn by_normal(&self, i: usize) -> f64 {
        self.share * if i == 0 { 1.0 } else { self.slope * self.direction[i - 1] }
    }

    /// ∂Π_i/∂y_j on the border.
    #[inline(always)]
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        if i == 0 || j == 0 {
            return self.by_normal(i + j);
        }
        let own = if i == j { self.turn } else { 0.0 };
        let along = self.share * self.slope * self.slope - self.turn;
        own + along * self.direction[i - 1] * self.direction[j - 1]
    }
}

/// The zone of a multiplier in its set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MultiplierZone {
    /// On a bound, or zero.
    Elsewhere,
    /// Inside its set: the row sticks.
    Interior,
    /// On the border of its cone: the contact slides.
    Border,
}

/// Whether p is between the bounds and farther from both than rounding errors.
#[inline(always)]
pub(super) fn is_between(p: f64, lower: f64, upper: f64) -> bool {
    let rounding = TOLERANCES.bound_rounding * lower.abs().min(upper.abs()).max(p.abs());
    p - lower > rounding && upper - p > rounding
}

/// The zone of p in its set.
pub(super) fn place_of(set: Set, p: &[f64]) -> MultiplierZone {
    match set {
        Set::Interval(lower, upper) if is_between(p[0], lower, upper) => MultiplierZone::Interior,
        // The tolerance allows for rounding.
        Set::Cone(slope)
            if p[0] > 0.0 && norm(&p[1..]) * (1.0 + TOLERANCES.bound_rounding) <= slope * p[0] =>
        {
            MultiplierZone::Interior
        }
        Set::Cone(_) if p[0] > 0.0 && p.len() > 1 => MultiplierZone::Border,
        _ => MultiplierZone::Elsewhere,
    }
}

#[inline(always)]
pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
