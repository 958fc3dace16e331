//! AVX2 with FMA: four doubles or eight singles a register, and one state's three components as one.
#![allow(clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::{RANGE, copy_parts, operator, recompute_far_angles, register};
use crate::sine::{Quadrants, sin_cos_f32, sin_cos_f64};
use crate::{Scalar, StateLanes};

register!(
    /// Four doubles: one AVX2 register.
    F64x4(__m256d), f64, 4,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd,
    _mm256_div_pd, _mm256_fmadd_pd, _mm256_sqrt_pd, sin_cos_f64
);
register!(
    /// Eight singles: one AVX2 register.
    F32x8(__m256), f32, 8,
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps,
    _mm256_div_ps, _mm256_fmadd_ps, _mm256_sqrt_ps, sin_cos_f32
);
copy_parts!(F64x4, f64, 4);
copy_parts!(F32x8, f32, 8);

impl F64x4 {
    #[inline(always)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        // SAFETY: see the module.
        unsafe {
            let size = _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0);
            _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(size, _mm256_set1_pd(range))) == 0b1111
        }
    }
    #[inline(always)]
    pub(crate) fn sign(self) -> Self {
        // SAFETY: see the module.
        unsafe {
            let zero = _mm256_setzero_pd();
            let one = _mm256_or_pd(_mm256_and_pd(self.0, _mm256_set1_pd(-0.0)), _mm256_set1_pd(1.0));
            let sign = _mm256_and_pd(one, _mm256_cmp_pd::<_CMP_NEQ_UQ>(self.0, zero));
            Self(_mm256_blendv_pd(sign, self.0, _mm256_cmp_pd::<_CMP_UNORD_Q>(self.0, self.0)))
        }
    }
    #[inline(always)]
    pub(crate) fn transpose(rows: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = rows;
        // SAFETY: see the module.
        unsafe {
            let (ab, ba) = (_mm256_unpacklo_pd(a.0, b.0), _mm256_unpackhi_pd(a.0, b.0));
            let (cd, dc) = (_mm256_unpacklo_pd(c.0, d.0), _mm256_unpackhi_pd(c.0, d.0));
            [
                Self(_mm256_permute2f128_pd::<0x20>(ab, cd)),
                Self(_mm256_permute2f128_pd::<0x20>(ba, dc)),
                Self(_mm256_permute2f128_pd::<0x31>(ab, cd)),
                Self(_mm256_permute2f128_pd::<0x31>(ba, dc)),
            ]
        }
    }
}

impl Quadrants for F64x4 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        // SAFETY: see the module.
        unsafe {
            let n = _mm256_castpd_si256(shifted.0);
            // Bit 0 of n selects the swap, bit 1 of n (of n + 1) the sign of the sine (cosine).
            let odd = _mm256_castsi256_pd(_mm256_slli_epi64::<63>(n));
            let sign = _mm256_set1_epi64x(i64::MIN);
            let next = _mm256_add_epi64(n, _mm256_set1_epi64x(1));
            let sine_sign = _mm256_castsi256_pd(_mm256_and_si256(_mm256_slli_epi64::<62>(n), sign));
            let cosine_sign = _mm256_castsi256_pd(_mm256_and_si256(_mm256_slli_epi64::<62>(next), sign));
            (
                Self(_mm256_xor_pd(_mm256_blendv_pd(sine.0, cosine.0, odd), sine_sign)),
                Self(_mm256_xor_pd(_mm256_blendv_pd(cosine.0, sine.0, odd), cosine_sign)),
            )
        }
    }
}

impl F32x8 {
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        // SAFETY: see the module.
        unsafe {
            let size = _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(size, _mm256_set1_ps(range as f32))) == 0xff
        }
    }
    #[inline(always)]
    pub(crate) fn sign(self) -> Self {
        // SAFETY: see the module.
        unsafe {
            let zero = _mm256_setzero_ps();
            let one = _mm256_or_ps(_mm256_and_ps(self.0, _mm256_set1_ps(-0.0)), _mm256_set1_ps(1.0));
            let sign = _mm256_and_ps(one, _mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, zero));
            Self(_mm256_blendv_ps(sign, self.0, _mm256_cmp_ps::<_CMP_UNORD_Q>(self.0, self.0)))
        }
    }
    /// Column j of each quarter of four rows.
    #[inline(always)]
    fn quarters(a: Self, b: Self, c: Self, d: Self) -> [__m256; 4] {
        // SAFETY: see the module.
        unsafe {
            let (ab, ba) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
            let (cd, dc) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
            [
                _mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
                _mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
                _mm256_shuffle_ps::<0b01_00_01_00>(ba, dc),
                _mm256_shuffle_ps::<0b11_10_11_10>(ba, dc),
            ]
        }
    }
    /// Pairs within quarters, then quarters.
    #[inline(always)]
    pub(crate) fn transpose(rows: [Self; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        // SAFETY: see the module.
        unsafe {
            let [l0, l1, l2, l3] = Self::quarters(a, b, c, d);
            let [h0, h1, h2, h3] = Self::quarters(e, f, g, h);
            [
                Self(_mm256_permute2f128_ps::<0x20>(l0, h0)),
                Self(_mm256_permute2f128_ps::<0x20>(l1, h1)),
                Self(_mm256_permute2f128_ps::<0x20>(l2, h2)),
                Self(_mm256_permute2f128_ps::<0x20>(l3, h3)),
                Self(_mm256_permute2f128_ps::<0x31>(l0, h0)),
                Self(_mm256_permute2f128_ps::<0x31>(l1, h1)),
                Self(_mm256_permute2f128_ps::<0x31>(l2, h2)),
                Self(_mm256_permute2f128_ps::<0x31>(l3, h3)),
            ]
        }
    }
}

impl Quadrants for F32x8 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        // SAFETY: see the module. The steps are those of `F64x4`.
        unsafe {
            let n = _mm256_castps_si256(shifted.0);
            let odd = _mm256_castsi256_ps(_mm256_slli_epi32::<31>(n));
            let sign = _mm256_set1_epi32(i32::MIN);
            let next = _mm256_add_epi32(n, _mm256_set1_epi32(1));
            let sine_sign = _mm256_castsi256_ps(_mm256_and_si256(_mm256_slli_epi32::<30>(n), sign));
            let cosine_sign = _mm256_castsi256_ps(_mm256_and_si256(_mm256_slli_epi32::<30>(next), sign));
            (
                Self(_mm256_xor_ps(_mm256_blendv_ps(sine.0, cosine.0, odd), sine_sign)),
                Self(_mm256_xor_ps(_mm256_blendv_ps(cosine.0, sine.0, odd), cosine_sign)),
            )
        }
    }
}

/// Three doubles, padded to four, of one state.
pub(crate) mod four {
    use core::arch::x86_64::{
        __m256d, _mm_add_sd, _mm_cvtsd_f64, _mm_hadd_pd, _mm256_add_pd, _mm256_castpd256_pd128,
        _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_fmsub_pd, _mm256_fnmadd_pd, _mm256_loadu_pd,
        _mm256_mul_pd, _mm256_permute2f128_pd, _mm256_permute4x64_pd, _mm256_set_pd, _mm256_set1_pd,
        _mm256_setzero_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
    };

    /// Four doubles.
    #[derive(Clone, Copy, Debug)]
    #[repr(transparent)]
    pub(crate) struct Quad(__m256d);

    macro_rules! operations {
        ($($name:ident($($x:ident),*) => $body:expr;)*) => {
            $(
                #[inline(always)]
                pub(crate) fn $name($($x: Quad),*) -> Quad {
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
    pub(crate) fn splat(x: f64) -> Quad {
        // SAFETY: see the module.
        unsafe { Quad(_mm256_set1_pd(x)) }
    }

    #[inline(always)]
    pub(crate) fn lane<const I: usize>(a: Quad) -> Quad {
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
    pub(crate) fn new([x, y, z]: [f64; 3]) -> Quad {
        // SAFETY: see the module.
        unsafe { Quad(_mm256_set_pd(0.0, z, y, x)) }
    }

    #[inline(always)]
    pub(crate) fn load(x: &[f64; 4]) -> Quad {
        // SAFETY: see the module; `x` points at four doubles, of any alignment.
        unsafe { Quad(_mm256_loadu_pd(x.as_ptr())) }
    }

    #[inline(always)]
    pub(crate) fn store(a: Quad) -> [f64; 4] {
        let mut x = [0.0; 4];
        // SAFETY: see the module; `x` holds four doubles, of any alignment.
        unsafe { _mm256_storeu_pd(x.as_mut_ptr(), a.0) };
        x
    }

    /// The sum of all four; the fourth is zero by convention.
    #[inline(always)]
    pub(crate) fn sum(a: Quad) -> f64 {
        // SAFETY: see the module.
        unsafe {
            let low = _mm256_castpd256_pd128(a.0);
            let high = _mm256_extractf128_pd::<1>(a.0);
            _mm_cvtsd_f64(_mm_add_sd(_mm_hadd_pd(low, low), high))
        }
    }
}
