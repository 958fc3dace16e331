//! The lanes of one number in one vector register: AVX2 with FMA, or AVX-512.
//!
//! Like [`Fused`](crate::Fused) these types promise a machine with their instructions and belong behind a
//! run-time check of it. Every operation is `unsafe` for that reason; what touches memory says why it may.
#![allow(unsafe_code)]
#![allow(clippy::wildcard_imports)] // some fifty instructions

mod avx2;
mod avx512;

use core::arch::x86_64::*;
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::sincos::{sin_cos_f32, sin_cos_f64};
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

            /// As [`StateLanes::gather`](super::StateLanes::gather).
            #[inline(always)]
            pub(super) fn gather(rows: &[$float], stride: usize, to: &mut [super::Lanes<$float, $lanes>]) {
                let width = to.len();
                let mut k = 0;
                while k < width {
                    // The last block reaches back over columns already done rather than beyond the row.
                    let (start, count) =
                        if width < $lanes { (0, width) } else { (k.min(width - $lanes), $lanes) };
                    let mut block = [Self::from_f64(0.0); $lanes];
                    for lane in 0..$lanes {
                        let row = &rows[lane * stride + start..];
                        block[lane] =
                            if count == $lanes { Self::load(row) } else { Self::load_part(row, count) };
                    }
                    let block = Self::transpose(block);
                    let to = &mut to[start..start + count];
                    for i in 0..$lanes {
                        if i < count {
                            to[i].0 = block[i].to_array();
                        }
                    }
                    k += $lanes;
                }
            }

            /// As [`StateLanes::scatter_columns`](super::StateLanes::scatter_columns).
            #[inline(always)]
            pub(super) fn scatter<'a>(
                width: usize,
                column: impl Fn(usize) -> &'a super::Lanes<$float, $lanes>,
                rows: &mut [$float],
                stride: usize,
            ) {
                let mut k = 0;
                while k < width {
                    let (start, count) =
                        if width < $lanes { (0, width) } else { (k.min(width - $lanes), $lanes) };
                    let mut block = [Self::from_f64(0.0); $lanes];
                    for i in 0..$lanes {
                        if i < count {
                            block[i] = Self::from_array(&column(start + i).0);
                        }
                    }
                    let block = Self::transpose(block);
                    for lane in 0..$lanes {
                        let row = &mut rows[lane * stride + start..];
                        if count == $lanes {
                            block[lane].store(row);
                        } else {
                            block[lane].store_part(row, count);
                        }
                    }
                    k += $lanes;
                }
            }

            #[inline(always)]
            fn load(row: &[$float]) -> Self {
                let row = &row[..$lanes];
                // SAFETY: see the module; the slice has as many numbers as the register, of any alignment.
                unsafe { Self($load(row.as_ptr())) }
            }

            #[inline(always)]
            fn store(self, row: &mut [$float]) {
                let row = &mut row[..$lanes];
                // SAFETY: see the module; the slice has as many numbers as the register, of any alignment.
                unsafe { $store(row.as_mut_ptr(), self.0) };
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

/// Fewer numbers of a row than a register holds, from its start on.
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
                if row.len() >= $lanes {
                    // What lies beyond `count` lands in columns that nobody reads.
                    return Self::load(row);
                }
                let mut lanes = [0.0; $lanes];
                for i in 0..count {
                    lanes[i] = row[i];
                }
                Self::from_array(&lanes)
            }
            #[inline(always)]
            fn store_part(self, row: &mut [$float], count: usize) {
                let (lanes, row) = (self.to_array(), &mut row[..count]);
                for i in 0..count {
                    row[i] = lanes[i];
                }
            }
        }
    };
}
parts_copied!(F64x4, f64, 4);
parts_copied!(F32x8, f32, 8);

/// Angles out of range, and those that are none, one by one.
#[cold]
#[inline(never)]
fn repair<T: Scalar>(angles: &[T], sines: &mut [T], cosines: &mut [T])
where
    f64: From<T>,
{
    for ((&angle, sine), cosine) in angles.iter().zip(sines).zip(cosines) {
        let size = f64::from(angle).abs();
        if size.is_nan() || size >= RANGE {
            (*sine, *cosine) = angle.sin_cos();
        }
    }
}
