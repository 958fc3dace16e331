//! Element-wise loops over vectors, four entries at a time.

use core::array::from_fn;

use robot_dynamics_core::factorization::paths::{Four, WIDTH};

/// `to` ← f of the entries of the others, and of `to` itself.
#[inline(always)]
pub(super) fn map<const K: usize>(to: &mut [f64], from: [&[f64]; K], f: impl Fn(f64, [f64; K]) -> f64) {
    let count = to.len();
    let from: [_; K] = from_fn(|i| from[i][..count].as_chunks::<WIDTH>());
    let (fours, rest) = to.as_chunks_mut::<WIDTH>();
    for (at, to) in fours.iter_mut().enumerate() {
        let from: [_; K] = from_fn(|i| from[i].0[at]);
        *to = from_fn(|k| f(to[k], from_fn(|i| from[i][k])));
    }
    for (at, to) in rest.iter_mut().enumerate() {
        *to = f(*to, from_fn(|i| from[i].1[at]));
    }
}

/// The sum of f over the entries, in four partial sums.
#[inline(always)]
pub(super) fn sum<const K: usize>(from: [&[f64]; K], f: impl Fn([f64; K]) -> f64) -> f64 {
    let sums = fold(from, [0.0; WIDTH], |sum, from| sum + f(from));
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// The largest f of the entries, at least `least`; NaN is ignored.
#[inline(always)]
pub(super) fn largest<const K: usize>(least: f64, from: [&[f64]; K], f: impl Fn([f64; K]) -> f64) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let most = fold(from, [least; WIDTH], |most, from| larger(most, f(from)));
    larger(larger(most[0], most[1]), larger(most[2], most[3]))
}

/// Folds every fourth entry into each of four results.
#[inline(always)]
fn fold<const K: usize>(from: [&[f64]; K], start: Four, f: impl Fn(f64, [f64; K]) -> f64) -> Four {
    let count = from.first().map_or(0, |from| from.len());
    let from: [_; K] = from_fn(|i| from[i][..count].as_chunks::<WIDTH>());
    let mut found = start;
    for at in 0..count / WIDTH {
        let from: [_; K] = from_fn(|i| from[i].0[at]);
        found = from_fn(|k| f(found[k], from_fn(|i| from[i][k])));
    }
    for at in 0..count % WIDTH {
        found[at] = f(found[at], from_fn(|i| from[i].1[at]));
    }
    found
}

/// aᵀb.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    sum([a, b], |[a, b]| a * b)
}
