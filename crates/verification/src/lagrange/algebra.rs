//! Three-vectors and 3×3 matrices over any [`Scalar`], independent of those of the recursions.

use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use robot_dynamics_number::Scalar;

/// A vector of R³.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub(crate) struct V3<S>(pub(crate) [S; 3]);

impl<S: Scalar> V3<S> {
    /// 0.
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self([S::zero(); 3])
    }

    /// The constant vector with these components.
    #[inline(always)]
    pub(crate) fn from_f64(v: [f64; 3]) -> Self {
        Self(v.map(S::from_f64))
    }

    /// a · b.
    #[inline(always)]
    pub(crate) fn dot(self, b: Self) -> S {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, b.0);
        ax.mul_add(bx, ay.mul_add(by, az * bz))
    }

    /// a × b.
    #[inline(always)]
    #[must_use]
    pub(crate) fn cross(self, b: Self) -> Self {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, b.0);
        Self([ay.mul_add(bz, -(az * by)), az.mul_add(bx, -(ax * bz)), ax.mul_add(by, -(ay * bx))])
    }
}

impl<S: Scalar> Add for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] + b.0[i]))
    }
}

impl<S: Scalar> Sub for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] - b.0[i]))
    }
}

impl<S: Scalar> Neg for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<S: Scalar> Mul<S> for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: S) -> Self {
        Self(self.0.map(|x| x * k))
    }
}

impl<S: Scalar> AddAssign for V3<S> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl<S: Scalar> SubAssign for V3<S> {
    #[inline(always)]
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

/// A 3×3 matrix, by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub(crate) struct M3<S>(pub(crate) [[S; 3]; 3]);

impl<S: Scalar> M3<S> {
    /// 1.
    #[inline(always)]
    pub(crate) fn identity() -> Self {
        Self::from_f64([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    }

    /// The constant matrix with these entries.
    #[inline(always)]
    pub(crate) fn from_f64(m: [[f64; 3]; 3]) -> Self {
        Self(m.map(|row| row.map(S::from_f64)))
    }

    /// Row i as a vector.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> V3<S> {
        V3(self.0[i])
    }

    /// Column j as a vector.
    #[inline(always)]
    pub(crate) fn column(&self, j: usize) -> V3<S> {
        V3([self.0[0][j], self.0[1][j], self.0[2][j]])
    }

    /// Mᵀ.
    #[inline(always)]
    #[must_use]
    pub(crate) fn transpose(&self) -> Self {
        Self(core::array::from_fn(|i| self.column(i).0))
    }

    /// Mᵀ v, without forming Mᵀ.
    #[inline(always)]
    pub(crate) fn transpose_mul(&self, v: V3<S>) -> V3<S> {
        let m = &self.0;
        V3(core::array::from_fn(|j| m[0][j].mul_add(v.0[0], m[1][j].mul_add(v.0[1], m[2][j] * v.0[2]))))
    }

    /// A B.
    #[inline(always)]
    #[must_use]
    pub(crate) fn times(&self, b: &Self) -> Self {
        Self(core::array::from_fn(|i| b.transpose_mul(self.row(i)).0))
    }

    /// The cross-product matrix of w: `skew(w) v = w × v`.
    #[inline(always)]
    pub(crate) fn skew(w: V3<S>) -> Self {
        let [x, y, z] = w.0;
        let o = S::zero();
        Self([[o, -z, y], [z, o, -x], [-y, x, o]])
    }
}

impl<S: Scalar> Mul<V3<S>> for M3<S> {
    type Output = V3<S>;
    #[inline(always)]
    fn mul(self, v: V3<S>) -> V3<S> {
        V3(core::array::from_fn(|i| self.row(i).dot(v)))
    }
}

impl<S: Scalar> Add for M3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(core::array::from_fn(|i| (self.row(i) + b.row(i)).0))
    }
}

impl<S: Scalar> Sub for M3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(core::array::from_fn(|i| (self.row(i) - b.row(i)).0))
    }
}
