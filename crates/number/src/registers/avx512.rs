//! AVX-512: eight doubles or sixteen singles a register.
#![allow(clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::{RANGE, operator, recompute_far_angles, register};
use crate::sine::{Quadrants, sin_cos_f32, sin_cos_f64};
use crate::{Scalar, StateLanes};

register!(
    /// Eight doubles: one AVX-512 register.
    F64x8(__m512d), f64, 8,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd,
    _mm512_div_pd, _mm512_fmadd_pd, _mm512_sqrt_pd, sin_cos_f64
);
register!(
    /// Sixteen singles: one AVX-512 register.
    F32x16(__m512), f32, 16,
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps,
    _mm512_div_ps, _mm512_fmadd_ps, _mm512_sqrt_ps, sin_cos_f32
);

/// Loads and stores of fewer numbers of a row than a register holds, by masks.
macro_rules! mask_parts {
    ($name:ident, $float:ty, $lanes:literal, $mask:ty, $load:ident, $store:ident) => {
        impl $name {
            #[inline(always)]
            fn load_part(row: &[$float], count: usize) -> Self {
                let row = &row[..count];
                let mask = (!0 as $mask) >> ($lanes - count);
                // SAFETY: see the module; the mask selects the first `count` numbers, which the row has.
                unsafe { Self($load(mask, row.as_ptr())) }
            }
            #[inline(always)]
            fn store_part(self, row: &mut [$float], count: usize) {
                let row = &mut row[..count];
                let mask = (!0 as $mask) >> ($lanes - count);
                // SAFETY: see the module; the mask selects the first `count` numbers, which the row has.
                unsafe { $store(row.as_mut_ptr(), mask, self.0) };
            }
        }
    };
}
mask_parts!(F64x8, f64, 8, __mmask8, _mm512_maskz_loadu_pd, _mm512_mask_storeu_pd);
mask_parts!(F32x16, f32, 16, __mmask16, _mm512_maskz_loadu_ps, _mm512_mask_storeu_ps);

impl F64x8 {
    #[inline(always)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        // SAFETY: see the module.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(_mm512_abs_pd(self.0), _mm512_set1_pd(range)) == 0xff }
    }
    #[inline(always)]
    pub(crate) fn sign(self) -> Self {
        // SAFETY: see the module.
        unsafe {
            let one = _mm512_or_pd(_mm512_and_pd(self.0, _mm512_set1_pd(-0.0)), _mm512_set1_pd(1.0));
            let sign =
                _mm512_maskz_mov_pd(_mm512_cmp_pd_mask::<_CMP_NEQ_UQ>(self.0, _mm512_setzero_pd()), one);
            Self(_mm512_mask_mov_pd(sign, _mm512_cmp_pd_mask::<_CMP_UNORD_Q>(self.0, self.0), self.0))
        }
    }
    /// Pairs, then quarters, then halves.
    #[inline(always)]
    #[allow(clippy::large_types_passed_by_value)] // inlined
    pub(crate) fn transpose(rows: [Self; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        // SAFETY: see the module.
        unsafe {
            let (ab, ba) = (_mm512_unpacklo_pd(a.0, b.0), _mm512_unpackhi_pd(a.0, b.0));
            let (cd, dc) = (_mm512_unpacklo_pd(c.0, d.0), _mm512_unpackhi_pd(c.0, d.0));
            let (ef, fe) = (_mm512_unpacklo_pd(e.0, f.0), _mm512_unpackhi_pd(e.0, f.0));
            let (gh, hg) = (_mm512_unpacklo_pd(g.0, h.0), _mm512_unpackhi_pd(g.0, h.0));
            // Quarters 0 and 2 of both, or 1 and 3 of both.
            let (p0, p1) = (
                _mm512_shuffle_f64x2::<0b10_00_10_00>(ab, cd),
                _mm512_shuffle_f64x2::<0b10_00_10_00>(ba, dc),
            );
            let (p2, p3) = (
                _mm512_shuffle_f64x2::<0b11_01_11_01>(ab, cd),
                _mm512_shuffle_f64x2::<0b11_01_11_01>(ba, dc),
            );
            let (r0, r1) = (
                _mm512_shuffle_f64x2::<0b10_00_10_00>(ef, gh),
                _mm512_shuffle_f64x2::<0b10_00_10_00>(fe, hg),
            );
            let (r2, r3) = (
                _mm512_shuffle_f64x2::<0b11_01_11_01>(ef, gh),
                _mm512_shuffle_f64x2::<0b11_01_11_01>(fe, hg),
            );
            [
                Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(p0, r0)),
                Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(p1, r1)),
                Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(p2, r2)),
                Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(p3, r3)),
                Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(p0, r0)),
                Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(p1, r1)),
                Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(p2, r2)),
                Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(p3, r3)),
            ]
        }
    }
}

impl Quadrants for F64x8 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        // SAFETY: see the module. The steps are those of `F64x4`.
        unsafe {
            let n = _mm512_castpd_si512(shifted.0);
            let odd = _mm512_test_epi64_mask(n, _mm512_set1_epi64(1));
            let sign = _mm512_set1_epi64(i64::MIN);
            let next = _mm512_add_epi64(n, _mm512_set1_epi64(1));
            let sine_sign = _mm512_castsi512_pd(_mm512_and_si512(_mm512_slli_epi64::<62>(n), sign));
            let cosine_sign = _mm512_castsi512_pd(_mm512_and_si512(_mm512_slli_epi64::<62>(next), sign));
            (
                Self(_mm512_xor_pd(_mm512_mask_mov_pd(sine.0, odd, cosine.0), sine_sign)),
                Self(_mm512_xor_pd(_mm512_mask_mov_pd(cosine.0, odd, sine.0), cosine_sign)),
            )
        }
    }
}

impl F32x16 {
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn all_within(self, range: f64) -> bool {
        // SAFETY: see the module.
        unsafe {
            let range = _mm512_set1_ps(range as f32);
            _mm512_cmp_ps_mask::<_CMP_LT_OQ>(_mm512_abs_ps(self.0), range) == 0xffff
        }
    }
    #[inline(always)]
    pub(crate) fn sign(self) -> Self {
        // SAFETY: see the module.
        unsafe {
            let one = _mm512_or_ps(_mm512_and_ps(self.0, _mm512_set1_ps(-0.0)), _mm512_set1_ps(1.0));
            let sign =
                _mm512_maskz_mov_ps(_mm512_cmp_ps_mask::<_CMP_NEQ_UQ>(self.0, _mm512_setzero_ps()), one);
            Self(_mm512_mask_mov_ps(sign, _mm512_cmp_ps_mask::<_CMP_UNORD_Q>(self.0, self.0), self.0))
        }
    }
    /// Blocks of 4×4 within quarters, then the quarters.
    #[inline(always)]
    #[allow(clippy::large_types_passed_by_value)] // inlined
    pub(crate) fn transpose(rows: [Self; 16]) -> [Self; 16] {
        // SAFETY: see the module.
        unsafe {
            let zero = _mm512_setzero_ps();
            // blocks[b][j]: column j of each quarter, of rows 4b to 4b + 3.
            let mut blocks = [[zero; 4]; 4];
            for b in 0..4 {
                let [a, b_, c, d] = [rows[4 * b].0, rows[4 * b + 1].0, rows[4 * b + 2].0, rows[4 * b + 3].0];
                let (ab, ba) = (_mm512_unpacklo_ps(a, b_), _mm512_unpackhi_ps(a, b_));
                let (cd, dc) = (_mm512_unpacklo_ps(c, d), _mm512_unpackhi_ps(c, d));
                blocks[b] = [
                    _mm512_shuffle_ps::<0b01_00_01_00>(ab, cd),
                    _mm512_shuffle_ps::<0b11_10_11_10>(ab, cd),
                    _mm512_shuffle_ps::<0b01_00_01_00>(ba, dc),
                    _mm512_shuffle_ps::<0b11_10_11_10>(ba, dc),
                ];
            }
            let mut columns = [Self(zero); 16];
            for j in 0..4 {
                let (even_low, odd_low) = (
                    _mm512_shuffle_f32x4::<0b10_00_10_00>(blocks[0][j], blocks[1][j]),
                    _mm512_shuffle_f32x4::<0b11_01_11_01>(blocks[0][j], blocks[1][j]),
                );
                let (even_high, odd_high) = (
                    _mm512_shuffle_f32x4::<0b10_00_10_00>(blocks[2][j], blocks[3][j]),
                    _mm512_shuffle_f32x4::<0b11_01_11_01>(blocks[2][j], blocks[3][j]),
                );
                columns[j] = Self(_mm512_shuffle_f32x4::<0b10_00_10_00>(even_low, even_high));
                columns[j + 4] = Self(_mm512_shuffle_f32x4::<0b10_00_10_00>(odd_low, odd_high));
                columns[j + 8] = Self(_mm512_shuffle_f32x4::<0b11_01_11_01>(even_low, even_high));
                columns[j + 12] = Self(_mm512_shuffle_f32x4::<0b11_01_11_01>(odd_low, odd_high));
            }
            columns
        }
    }
}

impl Quadrants for F32x16 {
    #[inline(always)]
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        // SAFETY: see the module. The steps are those of `F64x4`.
        unsafe {
            let n = _mm512_castps_si512(shifted.0);
            let odd = _mm512_test_epi32_mask(n, _mm512_set1_epi32(1));
            let sign = _mm512_set1_epi32(i32::MIN);
            let next = _mm512_add_epi32(n, _mm512_set1_epi32(1));
            let sine_sign = _mm512_castsi512_ps(_mm512_and_si512(_mm512_slli_epi32::<30>(n), sign));
            let cosine_sign = _mm512_castsi512_ps(_mm512_and_si512(_mm512_slli_epi32::<30>(next), sign));
            (
                Self(_mm512_xor_ps(_mm512_mask_mov_ps(sine.0, odd, cosine.0), sine_sign)),
                Self(_mm512_xor_ps(_mm512_mask_mov_ps(cosine.0, odd, sine.0), cosine_sign)),
            )
        }
    }
}
