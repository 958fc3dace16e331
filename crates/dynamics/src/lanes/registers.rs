//! The lanes of one number in one vector register: AVX2 with FMA, or AVX-512.
//!
//! Like [`Fused`](crate::Fused) these types promise a machine with their instructions and belong behind a
//! run-time check of it. Every operation is `unsafe` for that reason; what touches memory says why it may.
#![allow(unsafe_code)]

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::sincos::{Quadrants, sin_cos_f32, sin_cos_f64};
use crate::Scalar;
use crate::sincos::RANGE;

macro_rules! operator {
    ($name:ident, $trait:ident, $method:ident, $assign:ident, $assign_method:ident, $instruction:ident) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: see the module.
                unsafe { Self($instruction(self.0, other.0)) }
            }
        }
        impl $assign for $name {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }
    };
}

macro_rules! register {
    (
        $(#[$doc:meta])* $name:ident($register:ty), $float:ty, $lanes:literal, wide: $wide:literal,
        $set:ident, $load:ident, $store:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $fma:ident,
        $sqrt:ident, $sin_cos:ident
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($register);

        operator!($name, Add, add, AddAssign, add_assign, $add);
        operator!($name, Sub, sub, SubAssign, sub_assign, $sub);
        operator!($name, Mul, mul, MulAssign, mul_assign, $mul);

        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                // SAFETY: see the module.
                unsafe { Self($div(self.0, other.0)) }
            }
        }

        impl Neg for $name {
            type Output = Self;
            /// −0 − x, which the compiler knows as a change of sign.
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see the module.
                unsafe { Self($sub($set(-0.0), self.0)) }
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.to_array().fmt(f)
            }
        }

        impl $name {
            /// From the lanes.
            #[inline(always)]
            pub fn from_array(lanes: &[$float; $lanes]) -> Self {
                // SAFETY: see the module; the array has as many numbers as the register, of any alignment.
                unsafe { Self($load(lanes.as_ptr())) }
            }

            /// The lanes.
            #[inline(always)]
            pub fn to_array(self) -> [$float; $lanes] {
                let mut lanes = [0.0; $lanes];
                // SAFETY: see the module; the array has as many numbers as the register, of any alignment.
                unsafe { $store(lanes.as_mut_ptr(), self.0) };
                lanes
            }

            /// As [`StateLanes::gather`](super::StateLanes::gather), into memory of another type of lanes.
            #[inline(always)]
            pub(super) fn gather(rows: &[$float], stride: usize, to: &mut [super::Lanes<$float, $lanes>]) {
                let width = to.len();
                let mut k = 0;
                while k < width {
                    let count = $lanes.min(width - k);
                    let mut block = [Self::from_f64(0.0); $lanes];
                    for lane in 0..$lanes {
                        let row = &rows[lane * stride + k..];
                        block[lane] = Self::load_part(row, count);
                    }
                    let block = Self::transpose(block);
                    for i in 0..count {
                        to[k + i].0 = block[i].to_array();
                    }
                    k += count;
                }
            }

            /// As [`StateLanes::scatter`](super::StateLanes::scatter).
            #[inline(always)]
            pub(super) fn scatter(from: &[super::Lanes<$float, $lanes>], rows: &mut [$float], stride: usize) {
                let width = from.len();
                let mut k = 0;
                while k < width {
                    let count = $lanes.min(width - k);
                    let mut block = [Self::from_f64(0.0); $lanes];
                    for i in 0..count {
                        block[i] = Self::from_array(&from[k + i].0);
                    }
                    let block = Self::transpose(block);
                    for lane in 0..$lanes {
                        Self::store_part(block[lane], &mut rows[lane * stride + k..], count);
                    }
                    k += count;
                }
            }
        }

        impl Scalar for $name {
            type Fused = Self;
            type Triple = [Self; 3];
            type Symmetric = [Self; 6];
            const NEEDS_AVX512: bool = $wide;
            #[inline(always)]
            fn fuse(self) -> Self {
                self
            }
            #[inline(always)]
            fn unfuse(fused: Self) -> Self {
                fused
            }
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn from_f64(x: f64) -> Self {
                // SAFETY: see the module.
                unsafe { Self($set(x as $float)) }
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let result = $sin_cos(self);
                if self.all_in_range() {
                    return result;
                }
                #[cold]
                #[inline(never)]
                fn repair(
                    angles: &[$float; $lanes],
                    sines: &mut [$float; $lanes],
                    cosines: &mut [$float; $lanes],
                ) {
                    for k in 0..$lanes {
                        // Also NaN.
                        if !(f64::from(angles[k]).abs() < RANGE) {
                            (sines[k], cosines[k]) = angles[k].sin_cos();
                        }
                    }
                }
                let (mut sines, mut cosines) = (result.0.to_array(), result.1.to_array());
                repair(&self.to_array(), &mut sines, &mut cosines);
                (Self::from_array(&sines), Self::from_array(&cosines))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: see the module.
                unsafe { Self($sqrt(self.0)) }
            }
            #[inline(always)]
            fn signum0(self) -> Self {
                self.sign()
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                // SAFETY: see the module.
                unsafe { Self($fma(self.0, a.0, b.0)) }
            }
        }
    };
}

register!(
    /// Four doubles: one AVX2 register.
    F64x4(__m256d), f64, 4, wide: false,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd,
    _mm256_div_pd, _mm256_fmadd_pd, _mm256_sqrt_pd, sin_cos_f64
);
register!(
    /// Eight doubles: one AVX-512 register.
    F64x8(__m512d), f64, 8, wide: true,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd,
    _mm512_div_pd, _mm512_fmadd_pd, _mm512_sqrt_pd, sin_cos_f64
);
register!(
    /// Eight singles: one AVX2 register.
    F32x8(__m256), f32, 8, wide: false,
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps,
    _mm256_div_ps, _mm256_fmadd_ps, _mm256_sqrt_ps, sin_cos_f32
);
register!(
    /// Sixteen singles: one AVX-512 register.
    F32x16(__m512), f32, 16, wide: true,
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps,
    _mm512_div_ps, _mm512_fmadd_ps, _mm512_sqrt_ps, sin_cos_f32
);

/// The numbers of a row from its start on, or fewer than a register holds (the rest zero).
macro_rules! parts_masked {
    ($name:ident, $float:ty, $lanes:literal, $mask:ty, $load:ident, $store:ident) => {
        impl $name {
            #[inline(always)]
            fn load_part(row: &[$float], count: usize) -> Self {
                let row = &row[..count];
                let mask = (!0 as $mask) >> ($lanes - count);
                // SAFETY: see the module; the mask admits the first `count` numbers, which the row has.
                unsafe { Self($load(mask, row.as_ptr())) }
            }
            #[inline(always)]
            fn store_part(self, row: &mut [$float], count: usize) {
                let row = &mut row[..count];
                let mask = (!0 as $mask) >> ($lanes - count);
                // SAFETY: see the module; the mask admits the first `count` numbers, which the row has.
                unsafe { $store(row.as_mut_ptr(), mask, self.0) };
            }
        }
    };
}
parts_masked!(F64x8, f64, 8, __mmask8, _mm512_maskz_loadu_pd, _mm512_mask_storeu_pd);
parts_masked!(F32x16, f32, 16, __mmask16, _mm512_maskz_loadu_ps, _mm512_mask_storeu_ps);

macro_rules! parts_copied {
    ($name:ident, $float:ty, $lanes:literal) => {
        impl $name {
            #[inline(always)]
            fn load_part(row: &[$float], count: usize) -> Self {
                if let Some(whole) = row.first_chunk::<$lanes>() {
                    // What lies beyond `count` lands in columns that nobody reads.
                    return Self::from_array(whole);
                }
                let mut lanes = [0.0; $lanes];
                for i in 0..count {
                    lanes[i] = row[i];
                }
                Self::from_array(&lanes)
            }
            #[inline(always)]
            fn store_part(self, row: &mut [$float], count: usize) {
                let lanes = self.to_array();
                if count == $lanes {
                    row[..$lanes].copy_from_slice(&lanes);
                } else {
                    for i in 0..count {
                        row[i] = lanes[i];
                    }
                }
            }
        }
    };
}
parts_copied!(F64x4, f64, 4);
parts_copied!(F32x8, f32, 8);

impl F64x4 {
    #[inline(always)]
    fn all_in_range(self) -> bool {
        // SAFETY: see the module.
        unsafe {
            let size = _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0);
            _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(size, _mm256_set1_pd(RANGE))) == 0b1111
        }
    }
    #[inline(always)]
    fn sign(self) -> Self {
        // SAFETY: see the module.
        unsafe {
            let zero = _mm256_setzero_pd();
            let one = _mm256_or_pd(_mm256_and_pd(self.0, _mm256_set1_pd(-0.0)), _mm256_set1_pd(1.0));
            let sign = _mm256_and_pd(one, _mm256_cmp_pd::<_CMP_NEQ_UQ>(self.0, zero));
            Self(_mm256_blendv_pd(sign, self.0, _mm256_cmp_pd::<_CMP_UNORD_Q>(self.0, self.0)))
        }
    }
    #[inline(always)]
    fn transpose(rows: [Self; 4]) -> [Self; 4] {
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
    fn all_in_range(self) -> bool {
        // SAFETY: see the module.
        unsafe {
            let size = _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(size, _mm256_set1_ps(RANGE as f32))) == 0xff
        }
    }
    #[inline(always)]
    fn sign(self) -> Self {
        // SAFETY: see the module.
        unsafe {
            let zero = _mm256_setzero_ps();
            let one = _mm256_or_ps(_mm256_and_ps(self.0, _mm256_set1_ps(-0.0)), _mm256_set1_ps(1.0));
            let sign = _mm256_and_ps(one, _mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, zero));
            Self(_mm256_blendv_ps(sign, self.0, _mm256_cmp_ps::<_CMP_UNORD_Q>(self.0, self.0)))
        }
    }
    /// Pairs within quarters, then quarters.
    #[inline(always)]
    fn transpose(rows: [Self; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        // SAFETY: see the module.
        unsafe {
            let quarter = |a: Self, b: Self, c: Self, d: Self| {
                let (ab, ba) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
                let (cd, dc) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
                [
                    _mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
                    _mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
                    _mm256_shuffle_ps::<0b01_00_01_00>(ba, dc),
                    _mm256_shuffle_ps::<0b11_10_11_10>(ba, dc),
                ]
            };
            let [l0, l1, l2, l3] = quarter(a, b, c, d);
            let [h0, h1, h2, h3] = quarter(e, f, g, h);
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

impl F64x8 {
    #[inline(always)]
    fn all_in_range(self) -> bool {
        // SAFETY: see the module.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(_mm512_abs_pd(self.0), _mm512_set1_pd(RANGE)) == 0xff }
    }
    #[inline(always)]
    fn sign(self) -> Self {
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
    fn transpose(rows: [Self; 8]) -> [Self; 8] {
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
    fn all_in_range(self) -> bool {
        // SAFETY: see the module.
        unsafe {
            let range = _mm512_set1_ps(RANGE as f32);
            _mm512_cmp_ps_mask::<_CMP_LT_OQ>(_mm512_abs_ps(self.0), range) == 0xffff
        }
    }
    #[inline(always)]
    fn sign(self) -> Self {
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
    fn transpose(rows: [Self; 16]) -> [Self; 16] {
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
