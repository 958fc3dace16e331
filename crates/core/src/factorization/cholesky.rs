//! Dense Cholesky factorization M = L Lᵀ over any scalar type, row-major, in place. Cost: n³/3 operations.
//!
//! Only the lower triangle is read and written. A pivot that is not positive gives NaN or infinity.

use robot_dynamics_number::Scalar;

/// Overwrites the lower triangle of M with L.
#[inline(always)]
pub fn factor<S: Scalar>(m: &mut [S], n: usize) {
    for j in 0..n {
        for k in 0..j {
            let factor = m[j * n + k];
            for i in j..n {
                let product = factor * m[i * n + k];
                m[i * n + j] -= product;
            }
        }
        let inverse = S::one() / m[j * n + j].sqrt();
        for i in j..n {
            m[i * n + j] *= inverse;
        }
    }
}

/// x ← M⁻¹ x, given L.
#[inline(always)]
pub fn solve<S: Scalar>(l: &[S], n: usize, x: &mut [S]) {
    for i in 0..n {
        for k in 0..i {
            let product = l[i * n + k] * x[k];
            x[i] -= product;
        }
        x[i] = x[i] / l[i * n + i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            let product = l[k * n + i] * x[k];
            x[i] -= product;
        }
        x[i] = x[i] / l[i * n + i];
    }
}
