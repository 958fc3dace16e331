//! Pivots within rounding of zero.

/// The number of rounding errors of (Σ |zᵢ| √Nᵢ)² that a pivot must exceed.
///
/// A sum of products over a body has about ten rounding errors of its largest terms, and a chain adds a few
/// per body. They mostly cancel.
///
/// The bound was measured on hundreds of singular robots of 2 to 100 joints, with mass ratios up to 1e12 (see
/// the tests). Their vanishing pivots come out below 1. The pivot of a regular robot is at least 0.04/(κ ε),
/// where κ is the condition number of M scaled to a unit diagonal. That is above 1e3 for mass ratios of 1e12,
/// and above 1e8 on all usual robots. With 16, no robot with κ below 1e13 is reported as singular, and such
/// robots have accelerations with correct digits.
pub(super) const ROUNDINGS: f64 = 16.0;

/// If dₖ/Nₖ times the least dᵢ/Nᵢ beyond exceeds the bound by this factor, z is not needed. The |zᵢ| √Nᵢ grow
/// about like √(Nᵢ/dᵢ), and the factor leaves a margin for their sum.
const CLEAR: f64 = 1e6;

/// A vanished pivot.
pub(super) struct VanishedPivot<'a> {
    /// Its coordinate.
    pub index: usize,
    /// dₖ.
    pub pivot: f64,
    /// Nₖ.
    pub inertia: f64,
    /// |zᵢ| √Nᵢ by coordinate, from `index` to the last DoF of its subtree.
    pub share: &'a [f64],
}

/// Whether dₖ/Nₖ is so large compared with the least dᵢ/Nᵢ beyond that z is not needed. False if either is
/// NaN.
#[inline(always)]
pub(super) fn is_clear(left: f64, least: f64, bound: f64) -> bool {
    left > 0.0 && left * least.min(left) > CLEAR * bound
}

/// Whether dₖ is within rounding of zero; `size` is Σ |zᵢ| √Nᵢ. True for negative pivots, false for those
/// that overflowed.
#[inline(always)]
pub(super) fn vanishes(pivot: f64, bound: f64, size: f64) -> bool {
    pivot.is_finite() && pivot <= bound * size * size
}
