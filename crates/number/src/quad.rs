//! Three (padded to four) doubles in vector registers: one of AVX2, or a pair of NEON's or of simd128's.
//!
//! The [`Triple`] of `FmaFloat<f64>`. The instructions are each set's own (`registers`).

use crate::fma_float::FmaFloat;
use crate::registers::four as lanes;
use crate::{Symmetric, Triple};

pub(crate) use crate::registers::four::Quad;

impl Triple<FmaFloat<f64>> for Quad {
    const COLUMNS: bool = true;

    #[inline(always)]
    fn new(components: [FmaFloat<f64>; 3]) -> Self {
        let [x, y, z] = components;
        lanes::new([x.0, y.0, z.0])
    }
    #[inline(always)]
    fn constant(components: &[f64; 4]) -> Self {
        lanes::load(components)
    }
    #[inline(always)]
    fn array(self) -> [FmaFloat<f64>; 3] {
        let [x, y, z, _] = lanes::store(self);
        [FmaFloat(x), FmaFloat(y), FmaFloat(z)]
    }
    #[inline(always)]
    fn get(self, i: usize) -> FmaFloat<f64> {
        FmaFloat(lanes::store(self)[i])
    }
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        lanes::add(self, b)
    }
    #[inline(always)]
    fn minus(self, b: Self) -> Self {
        lanes::sub(self, b)
    }
    #[inline(always)]
    fn negated(self) -> Self {
        lanes::sub(lanes::zero(), self)
    }
    #[inline(always)]
    fn times(self, k: FmaFloat<f64>) -> Self {
        lanes::mul(self, lanes::splat(k.0))
    }
    #[inline(always)]
    fn times_plus(self, k: FmaFloat<f64>, b: Self) -> Self {
        lanes::mul_add(self, lanes::splat(k.0), b)
    }
    #[inline(always)]
    fn minus_times(self, k: FmaFloat<f64>, b: Self) -> Self {
        lanes::neg_mul_add(self, lanes::splat(k.0), b)
    }
    #[inline(always)]
    fn times_lane<const I: usize>(self, v: Self) -> Self {
        lanes::mul(self, lanes::lane::<I>(v))
    }
    #[inline(always)]
    fn times_lane_plus<const I: usize>(self, v: Self, b: Self) -> Self {
        lanes::mul_add(self, lanes::lane::<I>(v), b)
    }
    #[inline(always)]
    fn minus_times_lane<const I: usize>(self, v: Self, b: Self) -> Self {
        lanes::neg_mul_add(self, lanes::lane::<I>(v), b)
    }
    /// (a × b) rotated once is a·yzx(b) − yzx(a)·b.
    #[inline(always)]
    fn cross(self, b: Self) -> Self {
        lanes::yzx(lanes::mul_sub(self, lanes::yzx(b), lanes::mul(lanes::yzx(self), b)))
    }
    #[inline(always)]
    fn cross_sum(self, b: Self, c: Self, d: Self) -> Self {
        let first = lanes::mul_sub(self, lanes::yzx(b), lanes::mul(lanes::yzx(self), b));
        lanes::yzx(lanes::neg_mul_add(lanes::yzx(c), d, lanes::mul_add(c, lanes::yzx(d), first)))
    }
    #[inline(always)]
    fn plus_z(self, z: FmaFloat<f64>) -> Self {
        lanes::add(self, lanes::new([0.0, 0.0, z.0]))
    }
    #[inline(always)]
    fn cross_z(self, z: FmaFloat<f64>) -> Self {
        lanes::mul(lanes::yxww(self), lanes::new([z.0, -z.0, 0.0]))
    }
    /// a × e_j, with the signs of each column.
    #[inline(always)]
    fn skew(self) -> [Self; 3] {
        [
            lanes::mul(lanes::wzyw(self), lanes::load(&[0.0, 1.0, -1.0, 0.0])),
            lanes::mul(lanes::zwxw(self), lanes::load(&[-1.0, 0.0, 1.0, 0.0])),
            lanes::mul(lanes::yxww(self), lanes::load(&[1.0, -1.0, 0.0, 0.0])),
        ]
    }
    #[inline(always)]
    fn spin_gradient(self, alpha: Self) -> [Self; 3] {
        let square = lanes::splat(lanes::sum(lanes::mul(self, self)));
        let [x, y, z] = alpha.skew();
        [
            self.times_lane_plus::<0>(
                self,
                lanes::neg_mul_add(square, lanes::load(&[1.0, 0.0, 0.0, 0.0]), x),
            ),
            self.times_lane_plus::<1>(
                self,
                lanes::neg_mul_add(square, lanes::load(&[0.0, 1.0, 0.0, 0.0]), y),
            ),
            self.times_lane_plus::<2>(
                self,
                lanes::neg_mul_add(square, lanes::load(&[0.0, 0.0, 1.0, 0.0]), z),
            ),
        ]
    }
    #[inline(always)]
    fn dot(self, b: Self) -> FmaFloat<f64> {
        FmaFloat(lanes::sum(lanes::mul(self, b)))
    }
    /// The padding of the rows is not part of the matrix.
    #[inline(always)]
    fn transpose([x, y, z]: [Self; 3]) -> [Self; 3] {
        let (even, odd) = (lanes::evens(x, y), lanes::odds(x, y));
        [lanes::low_halves(even, z), lanes::low_halves(odd, lanes::odds(z, z)), lanes::high_halves(even, z)]
    }
    /// k is used last because it is mostly the result of a division; k b would wait for it longer.
    #[inline(always)]
    fn minus_scaled_outer([x, y, z]: [Self; 3], a: Self, b: Self, k: FmaFloat<f64>, _: Self) -> [Self; 3] {
        let k = lanes::splat(k.0);
        [
            lanes::neg_mul_add(a.times_lane::<0>(b), k, x),
            lanes::neg_mul_add(a.times_lane::<1>(b), k, y),
            lanes::neg_mul_add(a.times_lane::<2>(b), k, z),
        ]
    }
}

/// The three columns of the matrix.
impl Symmetric<FmaFloat<f64>, Quad> for [Quad; 3] {
    #[inline(always)]
    fn from_columns(columns: [Quad; 3]) -> Self {
        columns
    }
    #[inline(always)]
    fn columns(self) -> [Quad; 3] {
        self
    }
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        [lanes::add(self[0], b[0]), lanes::add(self[1], b[1]), lanes::add(self[2], b[2])]
    }
    #[inline(always)]
    fn plus_multiple_of_identity(self, k: FmaFloat<f64>) -> Self {
        let ([x, y, z], k) = (self, lanes::splat(k.0));
        [
            lanes::mul_add(k, lanes::load(&[1.0, 0.0, 0.0, 0.0]), x),
            lanes::mul_add(k, lanes::load(&[0.0, 1.0, 0.0, 0.0]), y),
            lanes::mul_add(k, lanes::load(&[0.0, 0.0, 1.0, 0.0]), z),
        ]
    }
    #[inline(always)]
    fn minus_square(self, a: Quad, k: FmaFloat<f64>, scaled: Quad) -> Self {
        Quad::minus_scaled_outer(self, a, a, k, scaled)
    }
    #[inline(always)]
    fn apply(self, v: Quad) -> Quad {
        let [x, y, z] = self;
        x.times_lane_plus::<0>(v, y.times_lane_plus::<1>(v, z.times_lane::<2>(v)))
    }
}
