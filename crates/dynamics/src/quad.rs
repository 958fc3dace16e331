//! Three (padded to four) doubles in one vector register.
//!
//! On x86-64 the operations are AVX2 and FMA instructions, on other machines loops over four numbers. The type
//! is the [`Triple`] of `Fused<f64>`, and like it belongs behind a run-time check of the machine.

use crate::{Fused, Symmetric, Triple};

#[cfg(target_arch = "x86_64")]
mod lanes {
    //! Every operation is `unsafe` for one reason alone: it needs AVX2 and FMA. A `Fused<f64>` promises them.
    #![allow(unsafe_code)]

    use core::arch::x86_64::{
        __m256d, _mm_add_sd, _mm_cvtsd_f64, _mm_hadd_pd, _mm256_add_pd, _mm256_castpd256_pd128,
        _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_fmsub_pd, _mm256_fnmadd_pd, _mm256_loadu_pd,
        _mm256_mul_pd, _mm256_permute2f128_pd, _mm256_permute4x64_pd, _mm256_set_pd, _mm256_set1_pd,
        _mm256_setzero_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
    };

    /// Four doubles.
    #[derive(Clone, Copy, Debug)]
    #[repr(transparent)]
    pub struct Quad(__m256d);

    macro_rules! operations {
        ($($name:ident($($x:ident),*) => $body:expr;)*) => {
            $(
                #[inline(always)]
                pub(super) fn $name($($x: Quad),*) -> Quad {
                    // SAFETY: see the module.
                    unsafe { Quad($body) }
                }
            )*
        };
    }
    operations! {
        add(a, b) => _mm256_add_pd(a.0, b.0);
        sub(a, b) => _mm256_sub_pd(a.0, b.0);
        mul(a, b) => _mm256_mul_pd(a.0, b.0);
        mul_add(a, b, c) => _mm256_fmadd_pd(a.0, b.0, c.0);
        mul_sub(a, b, c) => _mm256_fmsub_pd(a.0, b.0, c.0);
        neg_mul_add(a, b, c) => _mm256_fnmadd_pd(a.0, b.0, c.0);
        zero() => _mm256_setzero_pd();
        yzx(a) => _mm256_permute4x64_pd::<0b11_00_10_01>(a.0);
        yxww(a) => _mm256_permute4x64_pd::<0b11_11_00_01>(a.0);
        wzyw(a) => _mm256_permute4x64_pd::<0b11_01_10_11>(a.0);
        zwxw(a) => _mm256_permute4x64_pd::<0b11_00_11_10>(a.0);
        evens(a, b) => _mm256_unpacklo_pd(a.0, b.0);
        odds(a, b) => _mm256_unpackhi_pd(a.0, b.0);
        low_halves(a, b) => _mm256_permute2f128_pd::<0x20>(a.0, b.0);
        high_halves(a, b) => _mm256_permute2f128_pd::<0x31>(a.0, b.0);
    }

    #[inline(always)]
    pub(super) fn splat(x: f64) -> Quad {
        // SAFETY: see the module.
        unsafe { Quad(_mm256_set1_pd(x)) }
    }

    #[inline(always)]
    pub(super) fn lane<const I: usize>(a: Quad) -> Quad {
        // SAFETY: see the module.
        unsafe {
            Quad(match I {
                0 => _mm256_permute4x64_pd::<0>(a.0),
                1 => _mm256_permute4x64_pd::<0x55>(a.0),
                _ => _mm256_permute4x64_pd::<0xAA>(a.0),
            })
        }
    }

    #[inline(always)]
    pub(super) fn new([x, y, z]: [f64; 3]) -> Quad {
        // SAFETY: see the module.
        unsafe { Quad(_mm256_set_pd(0.0, z, y, x)) }
    }

    #[inline(always)]
    pub(super) fn load(x: &[f64; 4]) -> Quad {
        // SAFETY: see the module; `x` points at four doubles, of any alignment.
        unsafe { Quad(_mm256_loadu_pd(x.as_ptr())) }
    }

    #[inline(always)]
    pub(super) fn store(a: Quad) -> [f64; 4] {
        let mut x = [0.0; 4];
        // SAFETY: see the module; `x` has room for four doubles, of any alignment.
        unsafe { _mm256_storeu_pd(x.as_mut_ptr(), a.0) };
        x
    }

    /// The sum of all four; the fourth is zero by convention.
    #[inline(always)]
    pub(super) fn sum(a: Quad) -> f64 {
        // SAFETY: see the module.
        unsafe {
            let low = _mm256_castpd256_pd128(a.0);
            let high = _mm256_extractf128_pd::<1>(a.0);
            _mm_cvtsd_f64(_mm_add_sd(_mm_hadd_pd(low, low), high))
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod lanes {
    //! The same operations as loops, for the compiler to vectorise.

    /// Four doubles.
    #[derive(Clone, Copy, Debug)]
    #[repr(C, align(32))]
    pub struct Quad([f64; 4]);

    macro_rules! operations {
        ($($name:ident($($x:ident),*) => $body:expr;)*) => {
            $(
                #[inline(always)]
                pub(super) fn $name($($x: Quad),*) -> Quad {
                    Quad(core::array::from_fn(|i| { $(let $x = $x.0[i];)* let _ = i; $body }))
                }
            )*
        };
    }
    operations! {
        add(a, b) => a + b;
        sub(a, b) => a - b;
        mul(a, b) => a * b;
        mul_add(a, b, c) => a.mul_add(b, c);
        mul_sub(a, b, c) => a.mul_add(b, -c);
        neg_mul_add(a, b, c) => (-a).mul_add(b, c);
        zero() => 0.0;
    }

    #[inline(always)]
    pub(super) fn yzx(a: Quad) -> Quad {
        let [x, y, z, w] = a.0;
        Quad([y, z, x, w])
    }
    #[inline(always)]
    pub(super) fn yxww(a: Quad) -> Quad {
        let [x, y, _, w] = a.0;
        Quad([y, x, w, w])
    }
    #[inline(always)]
    pub(super) fn wzyw(a: Quad) -> Quad {
        let [_, y, z, w] = a.0;
        Quad([w, z, y, w])
    }
    #[inline(always)]
    pub(super) fn zwxw(a: Quad) -> Quad {
        let [x, _, z, w] = a.0;
        Quad([z, w, x, w])
    }
    /// (a₀, b₀, a₂, b₂).
    #[inline(always)]
    pub(super) fn evens(a: Quad, b: Quad) -> Quad {
        Quad([a.0[0], b.0[0], a.0[2], b.0[2]])
    }
    /// (a₁, b₁, a₃, b₃).
    #[inline(always)]
    pub(super) fn odds(a: Quad, b: Quad) -> Quad {
        Quad([a.0[1], b.0[1], a.0[3], b.0[3]])
    }
    #[inline(always)]
    pub(super) fn low_halves(a: Quad, b: Quad) -> Quad {
        Quad([a.0[0], a.0[1], b.0[0], b.0[1]])
    }
    #[inline(always)]
    pub(super) fn high_halves(a: Quad, b: Quad) -> Quad {
        Quad([a.0[2], a.0[3], b.0[2], b.0[3]])
    }
    #[inline(always)]
    pub(super) fn splat(x: f64) -> Quad {
        Quad([x; 4])
    }
    #[inline(always)]
    pub(super) fn lane<const I: usize>(a: Quad) -> Quad {
        Quad([a.0[I]; 4])
    }
    #[inline(always)]
    pub(super) fn new([x, y, z]: [f64; 3]) -> Quad {
        Quad([x, y, z, 0.0])
    }
    #[inline(always)]
    pub(super) fn load(x: &[f64; 4]) -> Quad {
        Quad(*x)
    }
    #[inline(always)]
    pub(super) fn store(a: Quad) -> [f64; 4] {
        a.0
    }
    #[inline(always)]
    pub(super) fn sum(a: Quad) -> f64 {
        a.0[0] + a.0[1] + a.0[2]
    }
}

pub use lanes::Quad;

impl Triple<Fused<f64>> for Quad {
    const COLUMNS: bool = true;

    #[inline(always)]
    fn new(components: [Fused<f64>; 3]) -> Self {
        let [x, y, z] = components;
        lanes::new([x.0, y.0, z.0])
    }
    #[inline(always)]
    fn constant(components: &[f64; 4]) -> Self {
        lanes::load(components)
    }
    #[inline(always)]
    fn array(self) -> [Fused<f64>; 3] {
        let [x, y, z, _] = lanes::store(self);
        [Fused(x), Fused(y), Fused(z)]
    }
    #[inline(always)]
    fn get(self, i: usize) -> Fused<f64> {
        Fused(lanes::store(self)[i])
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
    fn times(self, k: Fused<f64>) -> Self {
        lanes::mul(self, lanes::splat(k.0))
    }
    #[inline(always)]
    fn times_plus(self, k: Fused<f64>, b: Self) -> Self {
        lanes::mul_add(self, lanes::splat(k.0), b)
    }
    #[inline(always)]
    fn minus_times(self, k: Fused<f64>, b: Self) -> Self {
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
    fn plus_z(self, z: Fused<f64>) -> Self {
        lanes::add(self, lanes::new([0.0, 0.0, z.0]))
    }
    #[inline(always)]
    fn cross_z(self, z: Fused<f64>) -> Self {
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
    fn dot(self, b: Self) -> Fused<f64> {
        Fused(lanes::sum(lanes::mul(self, b)))
    }
    /// The padding of the rows is no number of the matrix's.
    #[inline(always)]
    fn transpose([x, y, z]: [Self; 3]) -> [Self; 3] {
        let (even, odd) = (lanes::evens(x, y), lanes::odds(x, y));
        [lanes::low_halves(even, z), lanes::low_halves(odd, lanes::odds(z, z)), lanes::high_halves(even, z)]
    }
    /// k, mostly the result of a division, is waited for last: k b would take a while longer.
    #[inline(always)]
    fn minus_scaled_outer([x, y, z]: [Self; 3], a: Self, b: Self, k: Fused<f64>, _: Self) -> [Self; 3] {
        let k = lanes::splat(k.0);
        [
            lanes::neg_mul_add(a.times_lane::<0>(b), k, x),
            lanes::neg_mul_add(a.times_lane::<1>(b), k, y),
            lanes::neg_mul_add(a.times_lane::<2>(b), k, z),
        ]
    }
}

/// Its three columns.
impl Symmetric<Fused<f64>, Quad> for [Quad; 3] {
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
    fn plus_multiple_of_identity(self, k: Fused<f64>) -> Self {
        let ([x, y, z], k) = (self, lanes::splat(k.0));
        [
            lanes::mul_add(k, lanes::load(&[1.0, 0.0, 0.0, 0.0]), x),
            lanes::mul_add(k, lanes::load(&[0.0, 1.0, 0.0, 0.0]), y),
            lanes::mul_add(k, lanes::load(&[0.0, 0.0, 1.0, 0.0]), z),
        ]
    }
    #[inline(always)]
    fn minus_square(self, a: Quad, k: Fused<f64>, scaled: Quad) -> Self {
        Quad::minus_scaled_outer(self, a, a, k, scaled)
    }
    #[inline(always)]
    fn apply(self, v: Quad) -> Quad {
        let [x, y, z] = self;
        x.times_lane_plus::<0>(v, y.times_lane_plus::<1>(v, z.times_lane::<2>(v)))
    }
}
