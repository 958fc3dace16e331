//! Three-vectors and 3×3 matrices over any [`Scalar`], as the recursions need them.
//!
//! They are thin: the layout and the operations are the scalar's own ([`Scalar::Triple`]), so one source line
//! serves one state in vector registers, eight states side by side, and dual numbers. No closure passes a
//! vector register: the compiler would make a function of it that may not use the machine's vector
//! instructions.

use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use crate::{Scalar, Symmetric, Triple};

/// A vector of R³.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct V3<S: Scalar>(S::Triple);

impl<S: Scalar> V3<S> {
    /// From its components.
    #[inline(always)]
    pub fn new(components: [S; 3]) -> Self {
        Self(S::Triple::new(components))
    }

    /// 0.
    #[inline(always)]
    pub fn zero() -> Self {
        Self(S::Triple::constant(&[0.0; 4]))
    }

    /// A constant vector.
    #[inline(always)]
    pub fn constant(v: &Padded) -> Self {
        Self(S::Triple::constant(v))
    }

    /// A constant vector.
    #[inline(always)]
    pub fn from_f64([x, y, z]: [f64; 3]) -> Self {
        Self(S::Triple::constant(&[x, y, z, 0.0]))
    }

    /// The components.
    #[inline(always)]
    pub fn array(self) -> [S; 3] {
        self.0.array()
    }

    /// Component `i`.
    #[inline(always)]
    pub fn get(self, i: usize) -> S {
        self.0.get(i)
    }

    /// The z component changed by `x`.
    #[inline(always)]
    pub fn bump_z(&mut self, x: S) {
        self.0 = self.0.plus_z(x);
    }

    /// a × (0, 0, z).
    #[inline(always)]
    pub fn cross_z(self, z: S) -> Self {
        Self(self.0.cross_z(z))
    }

    /// a · b.
    #[inline(always)]
    pub fn dot(self, b: Self) -> S {
        self.0.dot(b.0)
    }

    /// a × b.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Self(self.0.cross(b.0))
    }

    /// a × b + c × d.
    #[inline(always)]
    pub fn cross_sum(self, b: Self, c: Self, d: Self) -> Self {
        Self(self.0.cross_sum(b.0, c.0, d.0))
    }

    /// a − k b.
    #[inline(always)]
    pub fn sub_scaled(self, k: S, b: Self) -> Self {
        Self(b.0.minus_times(k, self.0))
    }

    /// a + k b.
    #[inline(always)]
    pub fn add_scaled(self, k: S, b: Self) -> Self {
        Self(b.0.times_plus(k, self.0))
    }
}

impl<S: Scalar> Add for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(self.0.plus(b.0))
    }
}

impl<S: Scalar> Sub for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(self.0.minus(b.0))
    }
}

impl<S: Scalar> Neg for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.negated())
    }
}

impl<S: Scalar> Mul<S> for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: S) -> Self {
        Self(self.0.times(k))
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

/// Three constants and a zero: one vector register's load.
pub type Padded = [f64; 4];

/// A constant 3×3 matrix by columns.
pub type PaddedColumns = [Padded; 3];

/// Pads three constants.
pub fn padded([x, y, z]: [f64; 3]) -> Padded {
    [x, y, z, 0.0]
}

/// The columns of a matrix given by rows.
pub fn padded_columns(rows: [[f64; 3]; 3]) -> PaddedColumns {
    core::array::from_fn(|j| [rows[0][j], rows[1][j], rows[2][j], 0.0])
}

/// A 3×3 matrix, by columns.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct M3<S: Scalar>([S::Triple; 3]);

impl<S: Scalar> M3<S> {
    /// From its columns.
    #[inline(always)]
    pub fn from_columns(columns: [V3<S>; 3]) -> Self {
        let [x, y, z] = columns;
        Self([x.0, y.0, z.0])
    }

    /// Whether [`M3::transpose_mul`] is slower than keeping the transpose beside the matrix.
    pub const KEEPS_TRANSPOSE: bool = S::Triple::COLUMNS;

    /// Whether known zeros and ones cost nothing: inertias are then turned from body to body instead of kept
    /// in one frame.
    pub const FOLDS_ZEROS: bool = S::Triple::FOLDS_ZEROS;

    /// \[α\]× + \[ω\]×\[ω\]×.
    #[inline(always)]
    pub fn spin_gradient(omega: V3<S>, alpha: V3<S>) -> Self {
        Self(omega.0.spin_gradient(alpha.0))
    }

    /// From its rows.
    #[inline(always)]
    pub fn from_rows(rows: [[S; 3]; 3]) -> Self {
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = rows;
        Self([S::Triple::new([xx, yx, zx]), S::Triple::new([xy, yy, zy]), S::Triple::new([xz, yz, zz])])
    }

    /// 0.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([S::Triple::constant(&[0.0; 4]); 3])
    }

    /// A constant matrix.
    #[inline(always)]
    pub fn constant(columns: &PaddedColumns) -> Self {
        Self([
            S::Triple::constant(&columns[0]),
            S::Triple::constant(&columns[1]),
            S::Triple::constant(&columns[2]),
        ])
    }

    /// A constant matrix given by rows.
    #[inline(always)]
    pub fn from_f64(rows: [[f64; 3]; 3]) -> Self {
        Self::constant(&padded_columns(rows))
    }

    /// The entries, by rows.
    #[inline(always)]
    pub fn rows(&self) -> [[S; 3]; 3] {
        let [x, y, z] = self.0;
        let ([xx, yx, zx], [xy, yy, zy], [xz, yz, zz]) = (x.array(), y.array(), z.array());
        [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]]
    }

    /// Column j.
    #[inline(always)]
    pub fn column(&self, j: usize) -> V3<S> {
        // No index: the columns could not stay in registers.
        let [x, y, z] = self.0;
        V3(match j {
            0 => x,
            1 => y,
            _ => z,
        })
    }

    /// Mᵀ.
    #[inline(always)]
    pub fn transpose(&self) -> Self {
        Self(S::Triple::transpose(self.0))
    }

    /// M v + b.
    #[inline(always)]
    pub fn times_plus(&self, v: V3<S>, b: V3<S>) -> V3<S> {
        let [x, y, z] = self.0;
        V3(x.times_lane_plus::<0>(v.0, y.times_lane_plus::<1>(v.0, z.times_lane_plus::<2>(v.0, b.0))))
    }

    /// Mᵀ v, without forming Mᵀ.
    #[inline(always)]
    pub fn transpose_mul(&self, v: V3<S>) -> V3<S> {
        V3::new([self.0[0].dot(v.0), self.0[1].dot(v.0), self.0[2].dot(v.0)])
    }

    /// A B.
    #[inline(always)]
    pub fn times(&self, b: &Self) -> Self {
        let [x, y, z] = b.0;
        Self([(*self * V3(x)).0, (*self * V3(y)).0, (*self * V3(z)).0])
    }

    /// A Bᵀ.
    #[inline(always)]
    pub fn times_transpose(&self, b: &Self) -> Self {
        let ([x, y, z], [bx, by, bz]) = (self.0, b.0);
        Self([
            x.times_lane_plus::<0>(bx, y.times_lane_plus::<0>(by, z.times_lane::<0>(bz))),
            x.times_lane_plus::<1>(bx, y.times_lane_plus::<1>(by, z.times_lane::<1>(bz))),
            x.times_lane_plus::<2>(bx, y.times_lane_plus::<2>(by, z.times_lane::<2>(bz))),
        ])
    }

    /// The cross-product matrix of w: `skew(w) v = w × v`.
    #[inline(always)]
    pub fn skew(w: V3<S>) -> Self {
        Self(w.0.skew())
    }

    /// M − k a bᵀ; `scaled` is k b.
    #[inline(always)]
    pub fn minus_scaled_outer(&self, a: V3<S>, b: V3<S>, k: S, scaled: V3<S>) -> Self {
        Self(S::Triple::minus_scaled_outer(self.0, a.0, b.0, k, scaled.0))
    }

    /// M − a bᵀ.
    #[inline(always)]
    pub fn minus_outer(&self, a: V3<S>, b: V3<S>) -> Self {
        Self([
            a.0.minus_times_lane::<0>(b.0, self.0[0]),
            a.0.minus_times_lane::<1>(b.0, self.0[1]),
            a.0.minus_times_lane::<2>(b.0, self.0[2]),
        ])
    }
}

impl<S: Scalar> Mul<V3<S>> for M3<S> {
    type Output = V3<S>;
    #[inline(always)]
    fn mul(self, v: V3<S>) -> V3<S> {
        let [x, y, z] = self.0;
        V3(x.times_lane_plus::<0>(v.0, y.times_lane_plus::<1>(v.0, z.times_lane::<2>(v.0))))
    }
}

impl<S: Scalar> Add for M3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self([self.0[0].plus(b.0[0]), self.0[1].plus(b.0[1]), self.0[2].plus(b.0[2])])
    }
}

impl<S: Scalar> Sub for M3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self([self.0[0].minus(b.0[0]), self.0[1].minus(b.0[1]), self.0[2].minus(b.0[2])])
    }
}

/// A symmetric 3×3 matrix.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Sym3<S: Scalar>(S::Symmetric);

impl<S: Scalar> Sym3<S> {
    /// 0.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::from_columns(&M3::zero())
    }

    /// k 1.
    #[inline(always)]
    pub fn multiple_of_identity(k: S) -> Self {
        Self::zero().plus_multiple_of_identity(k)
    }

    /// A constant matrix.
    #[inline(always)]
    pub fn constant(columns: &PaddedColumns) -> Self {
        Self::from_columns(&M3::constant(columns))
    }

    /// From a full matrix that is symmetric; one triangle is read.
    #[inline(always)]
    pub fn from_columns(m: &M3<S>) -> Self {
        Self(S::Symmetric::from_columns(m.0))
    }

    /// All nine entries.
    #[inline(always)]
    pub fn full(&self) -> M3<S> {
        M3(self.0.columns())
    }

    /// R A Rᵀ.
    #[inline(always)]
    pub fn rotated(&self, r: &M3<S>) -> Self {
        Self::from_columns(&r.times(&self.full()).times_transpose(r))
    }

    /// A + k 1.
    #[inline(always)]
    pub fn plus_multiple_of_identity(&self, k: S) -> Self {
        Self(self.0.plus_multiple_of_identity(k))
    }

    /// A − k a aᵀ; `scaled` is k a.
    #[inline(always)]
    pub fn minus_square(&self, a: V3<S>, k: S, scaled: V3<S>) -> Self {
        Self(self.0.minus_square(a.0, k, scaled.0))
    }
}

impl<S: Scalar> Add for Sym3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(self.0.plus(b.0))
    }
}

impl<S: Scalar> Mul<V3<S>> for Sym3<S> {
    type Output = V3<S>;
    #[inline(always)]
    fn mul(self, v: V3<S>) -> V3<S> {
        V3(self.0.apply(v.0))
    }
}
