//! How a joint turns its body, applied to matrices.

use dynamics::Scalar;

use crate::spatial::algebra::M3;

/// `rest_from_body`, the rotation that a joint's own motion is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Turn<S: Scalar> {
    /// None: the joint slides.
    None,
    /// About z, with sin² and sin·cos.
    AboutZ { sine: S, cosine: S, square: S, product: S },
    /// Any.
    Any(M3<S>),
}

impl<S: Scalar> Turn<S> {
    /// About z, by an angle's sine and cosine.
    #[inline(always)]
    pub(crate) fn about_z(sine: S, cosine: S) -> Self {
        Self::AboutZ { sine, cosine, square: sine * sine, product: sine * cosine }
    }

    /// R A Rᵀ.
    ///
    /// About z the block of x and y keeps its trace and the difference of its corners; what the turn moves is, with
    /// δ = a_xx − a_yy and σ = a_xy + a_yx, k = s² δ + s c σ on the diagonal and l = s c δ − s² σ beside it.
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

    /// By the matrix of the turn: 1e-15 is a few roundings of sums of numbers below 1.
    #[test]
    fn about_z_is_the_matrix() {
        let (sine, cosine) = 0.7_f64.sin_cos();
        let r = M3::from_f64([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]);
        let a = M3::from_f64([[0.3, -0.2, 0.9], [0.4, 0.8, -0.5], [0.1, 0.7, -0.6]]);
        let (found, expected) = (Turn::about_z(sine, cosine).rotated(&a), Turn::Any(r).rotated(&a));
        for (found, expected) in found.rows().as_flattened().iter().zip(expected.rows().as_flattened()) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }
}
