//! What differs between the two kinds of AVX2 register: ranges, signs, transposes, quadrants.

use core::arch::x86_64::*;

use super::super::sincos::Quadrants;
use super::{F32x8, F64x4};
use crate::sincos::RANGE;

impl F64x4 {
    #[inline(always)]
    pub(super) fn all_in_range(self) -> bool {
        // SAFETY: see the module.
        unsafe {
            let size = _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0);
            _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(size, _mm256_set1_pd(RANGE))) == 0b1111
        }
    }
    #[inline(always)]
    pub(super) fn sign(self) -> Self {
        // SAFETY: see the module.
        unsafe {
            let zero = _mm256_setzero_pd();
            let one = _mm256_or_pd(_mm256_and_pd(self.0, _mm256_set1_pd(-0.0)), _mm256_set1_pd(1.0));
            let sign = _mm256_and_pd(one, _mm256_cmp_pd::<_CMP_NEQ_UQ>(self.0, zero));
            Self(_mm256_blendv_pd(sign, self.0, _mm256_cmp_pd::<_CMP_UNORD_Q>(self.0, self.0)))
        }
    }
    #[inline(always)]
    pub(super) fn transpose(rows: [Self; 4]) -> [Self; 4] {
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
            // Bit 0 of n says whether to swap, bit 1 of n (of n + 1) the sign of the sine (cosine).
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
    pub(super) fn all_in_range(self) -> bool {
        // SAFETY: see the module.
        unsafe {
            let size = _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(size, _mm256_set1_ps(RANGE as f32))) == 0xff
        }
    }
    #[inline(always)]
    pub(super) fn sign(self) -> Self {
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
    pub(super) fn transpose(rows: [Self; 8]) -> [Self; 8] {
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
