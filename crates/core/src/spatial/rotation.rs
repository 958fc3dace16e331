//! The rotation of a joint, applied to matrices.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

/// `rest_from_body`: the rotation of a joint's own motion.
#[derive(Clone, Copy, Debug)]
pub enum JointRotation<S: Scalar> {
    /// The identity: the joint translates.
    None,
    /// A rotation about z, with sin² and sin·cos.
    AboutZ { sine: S, cosine: S, square: S, product: S },
    /// Any rotation.
    Any(M3<S>),
}

impl<S: Scalar> JointRotation<S> {
    /// A rotation about z, by an angle's sine and cosine.
    #[inline(always)]
    pub(crate) fn about_z(sine: S, cosine: S) -> Self {
        Self::AboutZ { sine, cosine, square: sine * sine, product: sine * cosine }
    }

    /// R A Rᵀ.
    ///
    /// A rotation about z preserves the trace of the x-y block and the difference of its off-diagonal
    /// entries. The diagonal changes by −k and k, and both off-diagonal entries by l. Here k = s² δ + s c σ
    /// and l = s c δ − s² σ, with δ = a_xx − a_yy and σ = a_xy + a_yx.
    #[inline(always)]
    pub(crate) fn rotated(&self, a: &M3<S>) -> M3<S> {
        match *self {
            Self::None => *a,
            Self::Any(r) => r.times(a).times_transpose(&r),
            Self::AboutZ { sine, cosine, square, product } => {
                let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = a.rows();
                let (difference, sum) = (xx - yy, xy + yx);
                let k = square.mul_add(difference, product * sum);
                let l = product * difference - square * sum;
                M3::from_rows([
                    [xx - k, xy + l, cosine * xz - sine * yz],
                    [yx + l, yy + k, sine.mul_add(xz, cosine * yz)],
                    [cosine * zx - sine * zy, sine.mul_add(zx, cosine * zy), zz],
                ])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equals the product with the rotation's matrix; 1e-15 is a few rounding errors of sums of numbers below
    /// 1.
    #[test]
    fn about_z_is_the_matrix() {
        let (sine, cosine) = 0.7_f64.sin_cos();
        let r = M3::from_f64([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]);
        let a = M3::from_f64([[0.3, -0.2, 0.9], [0.4, 0.8, -0.5], [0.1, 0.7, -0.6]]);
        let (found, expected) =
            (JointRotation::about_z(sine, cosine).rotated(&a), JointRotation::Any(r).rotated(&a));
        for (found, expected) in found.rows().as_flattened().iter().zip(expected.rows().as_flattened()) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }
}
