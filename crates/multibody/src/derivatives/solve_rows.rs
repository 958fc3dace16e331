//! −M⁻¹ X for two matrices at once, given M = LᵀL with the tree's zeros.

use dynamics::Scalar;

use crate::dispatch::Route;
use crate::sparse_cholesky::carriers;

/// Columns taken at a time.
pub(super) const BLOCK: usize = 8;

/// Writes −M⁻¹X and −M⁻¹Y, n×n, given L of [`factor`](crate::sparse_cholesky::factor); rows of X and Y are
/// `stride` apart, a multiple of [`BLOCK`], and are overwritten.
///
/// Lᵀ first, from the last row: row i takes L_ki times row k from every k beyond i. Then L, from the first: row k
/// takes L_ki times row i from every i that carries it. `end` is one past the last freedom beyond i; to the right
/// of it X has zeros, as L has.
#[inline(always)]
pub(super) fn solve_rows<S: Scalar, R: Route<S>>(
    carrier: &[usize],
    end: impl Fn(usize) -> usize,
    l: &[R::Number],
    [x, y]: [&mut [R::Number]; 2],
    stride: usize,
    [to_x, to_y]: [&mut [S]; 2],
) {
    let n = carrier.len();
    let mut at = 0;
    while at < n {
        for i in (0..n).rev() {
            let end = end(i);
            if end <= at {
                continue;
            }
            let (mut a, mut b) = (block(x, i * stride + at), block(y, i * stride + at));
            for k in i + 1..end {
                let factor = -l[k * n + i];
                add_scaled(&mut a, factor, &x[k * stride + at..][..BLOCK]);
                add_scaled(&mut b, factor, &y[k * stride + at..][..BLOCK]);
            }
            let scale = l[i * n + i];
            for j in 0..BLOCK {
                a[j] *= scale;
                b[j] *= scale;
            }
            x[i * stride + at..][..BLOCK].copy_from_slice(&a);
            y[i * stride + at..][..BLOCK].copy_from_slice(&b);
        }
        let count = BLOCK.min(n - at);
        for k in 0..n {
            let (mut a, mut b) = (block(x, k * stride + at), block(y, k * stride + at));
            for i in carriers(carrier, k) {
                let factor = l[k * n + i];
                add_scaled(&mut a, factor, &x[i * stride + at..][..BLOCK]);
                add_scaled(&mut b, factor, &y[i * stride + at..][..BLOCK]);
            }
            let scale = -l[k * n + k];
            for j in 0..BLOCK {
                a[j] *= scale;
                b[j] *= scale;
            }
            x[k * stride + at..][..BLOCK].copy_from_slice(&a);
            y[k * stride + at..][..BLOCK].copy_from_slice(&b);
            let (to_x, to_y) = (&mut to_x[k * n + at..][..count], &mut to_y[k * n + at..][..count]);
            for j in 0..count {
                to_x[j] = R::store(a[j]);
                to_y[j] = R::store(b[j]);
            }
        }
        at += BLOCK;
    }
}

#[inline(always)]
fn block<S: Scalar>(x: &[S], at: usize) -> [S; BLOCK] {
    let mut block = [S::zero(); BLOCK];
    block.copy_from_slice(&x[at..at + BLOCK]);
    block
}

/// a ← a + k x.
#[inline(always)]
fn add_scaled<S: Scalar>(a: &mut [S; BLOCK], k: S, x: &[S]) {
    for j in 0..BLOCK {
        a[j] = k.mul_add(x[j], a[j]);
    }
}
