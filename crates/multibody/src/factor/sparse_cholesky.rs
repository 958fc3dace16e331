//! The factorisation M = LᵀL that keeps the zeros of a tree's mass matrix, O(n depth²).
//!
//! M_ij is zero where neither freedom carries the other. Eliminating from the last freedom to the first fills
//! in nothing: row k of L has entries only at k and at the freedoms λ(k), λ(λ(k)), ... that carry it.
//! **(RBDA §6.5)** Where joints follow others the coordinates form no tree; then λ(k) = k − 1, which leaves the
//! dense factorisation.

use dynamics::Scalar;

use crate::Model;
use crate::model::Dof;

/// λ of a freedom that nothing carries.
pub(crate) const NONE: usize = usize::MAX;

/// λ of each freedom of the tree: the one before it on its body, or the last one of the parent's.
pub(crate) fn freedom_carriers(model: &Model) -> Vec<usize> {
    let carrier = |(k, dof): (usize, &Dof)| {
        let body = &model.bodies[dof.body];
        if k > body.dof {
            return k - 1;
        }
        model.bodies.get(body.parent).map_or(NONE, |parent| parent.dof + parent.motion.nv() - 1)
    };
    model.dofs.iter().enumerate().map(carrier).collect()
}

/// λ of each coordinate. Followers couple branches; then each coordinate counts as carried by the one before it.
pub(crate) fn coordinate_carriers(model: &Model) -> Vec<usize> {
    if model.has_mimic {
        return (0..model.nv).map(|k| k.checked_sub(1).unwrap_or(NONE)).collect();
    }
    freedom_carriers(model)
}

/// The freedoms that carry freedom k, nearest first.
#[inline(always)]
pub(crate) fn carriers(carrier: &[usize], k: usize) -> impl Iterator<Item = usize> + '_ {
    // `NONE` is no index: the chain ends there.
    core::iter::successors(carrier.get(carrier[k]).map(|_| carrier[k]), |&i| {
        carrier.get(carrier[i]).map(|_| carrier[i])
    })
}

/// Overwrites the lower triangle of M, row-major, with L; 1/L_kk stands on the diagonal. `carrier` is λ.
#[inline(always)]
pub(crate) fn factor<S: Scalar>(carrier: &[usize], m: &mut [S]) {
    let n = carrier.len();
    for k in (0..n).rev() {
        let inverse = S::one() / m[k * n + k].sqrt();
        m[k * n + k] = inverse;
        for i in carriers(carrier, k) {
            m[k * n + i] *= inverse;
        }
        for i in carriers(carrier, k) {
            let factor = m[k * n + i];
            m[i * n + i] -= factor * factor;
            for j in carriers(carrier, i) {
                let product = factor * m[k * n + j];
                m[i * n + j] -= product;
            }
        }
    }
}

/// x ← M⁻¹ x, given what [`factor`] left: Lᵀy = x from the last freedom, then L x = y from the first.
#[inline(always)]
pub(crate) fn solve<S: Scalar>(carrier: &[usize], l: &[S], x: &mut [S]) {
    let n = carrier.len();
    for k in (0..n).rev() {
        x[k] *= l[k * n + k];
        for i in carriers(carrier, k) {
            let product = l[k * n + i] * x[k];
            x[i] -= product;
        }
    }
    for k in 0..n {
        let mut sum = x[k];
        for i in carriers(carrier, k) {
            sum -= l[k * n + i] * x[i];
        }
        x[k] = sum * l[k * n + k];
    }
}

/// M⁻¹, row-major, given what [`factor`] left, O(n² depth).
///
/// L X = L⁻ᵀ, whose right side has no entry below the diagonal: row i of X, left of the diagonal, is
/// −Σ L_ij X_j / L_ii over the carriers j of i, and X is symmetric.
#[inline(always)]
pub(crate) fn invert<S: Scalar>(carrier: &[usize], l: &[S], inverse: &mut [S]) {
    let n = carrier.len();
    for i in 0..n {
        let (above, below) = inverse.split_at_mut(i * n);
        let row = &mut below[..n];
        let scale = l[i * n + i];
        row[..i].fill(S::zero());
        for j in carriers(carrier, i) {
            let factor = -(l[i * n + j] * scale);
            for (entry, x) in row[..i].iter_mut().zip(&above[j * n..j * n + i]) {
                *entry = factor.mul_add(*x, *entry);
            }
        }
        let mut diagonal = scale;
        for j in carriers(carrier, i) {
            diagonal -= l[i * n + j] * row[j];
        }
        row[i] = diagonal * scale;
        for (j, &entry) in row[..i].iter().enumerate() {
            above[j * n + i] = entry;
        }
    }
}
