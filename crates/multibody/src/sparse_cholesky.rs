//! The factorisation M = LᵀL that keeps the zeros of a tree's mass matrix, O(n depth²).
//!
//! M_ij is zero where neither freedom carries the other. Eliminating from the last freedom to the first fills
//! in nothing: row k of L has entries only at k and at the freedoms λ(k), λ(λ(k)), ... that carry it.
//! **(RBDA §6.5)**

use dynamics::Scalar;

/// λ of a freedom that nothing carries.
pub(crate) const NONE: usize = usize::MAX;

/// The freedoms that carry freedom k, nearest first.
#[inline(always)]
fn carriers(parent: &[usize], k: usize) -> impl Iterator<Item = usize> + '_ {
    // `NONE` is no index: the chain ends there.
    core::iter::successors(parent.get(parent[k]).map(|_| parent[k]), |&i| {
        parent.get(parent[i]).map(|_| parent[i])
    })
}

/// Overwrites the lower triangle of M, row-major, with L; 1/L_kk stands on the diagonal. `parent` is λ.
#[inline(always)]
pub(crate) fn factor<S: Scalar>(parent: &[usize], m: &mut [S]) {
    let n = parent.len();
    for k in (0..n).rev() {
        let inverse = S::one() / m[k * n + k].sqrt();
        m[k * n + k] = inverse;
        for i in carriers(parent, k) {
            m[k * n + i] *= inverse;
        }
        for i in carriers(parent, k) {
            let factor = m[k * n + i];
            m[i * n + i] -= factor * factor;
            for j in carriers(parent, i) {
                let product = factor * m[k * n + j];
                m[i * n + j] -= product;
            }
        }
    }
}

/// x ← M⁻¹ x, given what [`factor`] left: Lᵀy = x from the last freedom, then L x = y from the first.
#[inline(always)]
pub(crate) fn solve<S: Scalar>(parent: &[usize], l: &[S], x: &mut [S]) {
    let n = parent.len();
    for k in (0..n).rev() {
        x[k] *= l[k * n + k];
        for i in carriers(parent, k) {
            let product = l[k * n + i] * x[k];
            x[i] -= product;
        }
    }
    for k in 0..n {
        let mut sum = x[k];
        for i in carriers(parent, k) {
            sum -= l[k * n + i] * x[i];
        }
        x[k] = sum * l[k * n + k];
    }
}

/// The first freedom (from the last one on) whose pivot in M = LᵀL is zero as far as f64 can tell, with that
/// pivot: below the rounding error of its own row.
pub(crate) fn singular_pivot(parent: &[usize], m: &mut [f64]) -> Option<(usize, f64)> {
    let n = parent.len();
    let diagonal: Vec<f64> = (0..n).map(|k| m[k * n + k]).collect();
    for k in (0..n).rev() {
        let pivot = m[k * n + k];
        if pivot <= f64::EPSILON * diagonal[k].abs() * n as f64 || !pivot.is_finite() {
            return Some((k, pivot));
        }
        for i in carriers(parent, k) {
            let factor = m[k * n + i] / pivot;
            m[i * n + i] -= factor * m[k * n + i];
            for j in carriers(parent, i) {
                m[i * n + j] -= factor * m[k * n + j];
            }
        }
    }
    None
}
