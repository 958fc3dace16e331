//! The projection onto a cone, and its slopes.

use super::{MOST_ROWS, Set};

/// Π onto { |p_t| ≤ μp_n }.
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

/// Π and its slopes: 1 inside, 0 in the polar cone, else those of [`project_to_border`].
#[inline(always)]
pub(super) fn project_with_slopes(slope: f64, p: &mut [f64]) -> Slopes {
    let (normal, side) = (p[0], norm(&p[1..]));
    if side <= slope * normal {
        return Slopes::WITHIN;
    }
    if slope * side <= -normal {
        p.fill(0.0);
        return Slopes::ELSEWHERE;
    }
    project_to_border(slope, p)
}

/// Π as it is between the cone and its polar, wherever p is, and its slopes wwᵀ + (μp_n/|y_t|)(1 − eeᵀ) with w = (1, μe)/√(1 + μ²).
#[inline(always)]
pub(super) fn project_to_border(slope: f64, p: &mut [f64]) -> Slopes {
    let mut slopes = Slopes { place: Place::Border, slope, ..Slopes::ELSEWHERE };
    let (normal, side) = (p[0], norm(&p[1..]));
    slopes.share = 1.0 / (1.0 + slope * slope);
    let at = (normal + slope * side) * slopes.share;
    slopes.turn = slope * at / side;
    for (e, p) in slopes.direction.iter_mut().zip(&mut p[1..]) {
        *e = *p / side;
        *p *= slopes.turn;
    }
    p[0] = at;
    slopes
}

/// ∂Π.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    /// On the border as below; within 1, elsewhere 0.
    pub(super) place: Place,
    /// μ, 1/(1 + μ²), μp_n/|y_t| and e.
    slope: f64,
    share: f64,
    turn: f64,
    direction: [f64; MOST_ROWS - 1],
}

impl Slopes {
    pub(super) const WITHIN: Self = Self { place: Place::Within, ..Self::ELSEWHERE };
    pub(super) const ELSEWHERE: Self =
        Self { place: Place::Elsewhere, slope: 0.0, share: 0.0, turn: 0.0, direction: [0.0; MOST_ROWS - 1] };

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

/// Whether p is between the bounds and not, but for rounding, on one of them.
#[inline(always)]
pub(super) fn is_between(p: f64, lower: f64, upper: f64) -> bool {
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

#[inline(always)]
pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
