//! Numbers of several states in vector registers, with a file for each instruction set.
//!
//! Only kernels use these types, on machines that have their instructions ([`crate::dispatch`]). Every
//! operation is `unsafe` for that reason alone. Operations that touch memory state why it is valid.
#![allow(unsafe_code)]
#![allow(clippy::wildcard_imports)] // some fifty instructions

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::{F32x8, F64x4, four};
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::{F32x16, F64x8};
#[cfg(target_arch = "aarch64")]
pub(crate) use neon::{F32x8, F64x4, four};
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub(crate) use simd128::{F32x8, F64x4, four};

use crate::Scalar;
use crate::sine::RANGE;

/// An operator and its assigning variant.
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

pub(crate) use operator;

/// A register of states and its arithmetic, from the instructions of one set.
macro_rules! register {
    (
        $(#[$doc:meta])* $name:ident($register:ty), $float:ty, $lanes:literal, $set:ident, $load:ident, $store:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $fma:ident,
        $sqrt:ident, $sin_cos:ident
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $name($register);

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
            /// −0 − x, which the compiler recognizes as a change of sign.
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
            pub(crate) fn from_array(lanes: &[$float; $lanes]) -> Self {
                // SAFETY: see the module; the array has as many numbers as the register, of any alignment.
                unsafe { Self($load(lanes.as_ptr())) }
            }

            /// The lanes.
            #[inline(always)]
            pub(crate) fn to_array(self) -> [$float; $lanes] {
                let mut lanes = [0.0; $lanes];
                // SAFETY: see the module; the array has as many numbers as the register, of any alignment.
                unsafe { $store(lanes.as_mut_ptr(), self.0) };
                lanes
            }

            pub(crate) const LANES: usize = $lanes;

            #[inline(always)]
            pub(crate) fn load(row: &[$float]) -> Self {
                let row = &row[..$lanes];
                // SAFETY: see the module; the slice has as many numbers as the register, of any alignment.
                unsafe { Self($load(row.as_ptr())) }
            }

            #[inline(always)]
            pub(crate) fn store(self, row: &mut [$float]) {
                let row = &mut row[..$lanes];
                // SAFETY: see the module; the slice has as many numbers as the register, of any alignment.
                unsafe { $store(row.as_mut_ptr(), self.0) };
            }
        }

        impl Scalar for $name {
            type Triple = [Self; 3];
            type Symmetric = [Self; 6];
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn from_f64(x: f64) -> Self {
                // SAFETY: see the module.
                unsafe { Self($set(x as $float)) }
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let result = $sin_cos(self);
                if self.all_within(RANGE) {
                    return result;
                }
                let (mut sines, mut cosines) = (result.0.to_array(), result.1.to_array());
                recompute_far_angles(&self.to_array(), &mut sines, &mut cosines);
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

        impl StateLanes for $name {
            type Float = $float;
            const LANES: usize = $lanes;

            #[inline(always)]
            fn from_lanes(lane: impl Fn(usize) -> $float) -> Self {
                let mut lanes = [0.0; $lanes];
                for k in 0..$lanes {
                    lanes[k] = lane(k);
                }
                Self::from_array(&lanes)
            }

            #[inline(always)]
            fn lane(&self, lane: usize) -> $float {
                self.to_array()[lane]
            }

            #[inline(always)]
            fn finite(&self) -> u32 {
                let (lanes, mut bits) = (self.to_array(), 0);
                for k in 0..$lanes {
                    bits |= u32::from(lanes[k].is_finite()) << k;
                }
                bits
            }

            #[inline(always)]
            fn all_within(&self, range: f64) -> bool {
                $name::all_within(*self, range)
            }

            /// Transposes blocks of as many columns as rows in registers.
            #[inline(always)]
            fn gather(rows: &[$float], stride: usize, to: &mut [Self]) {
                let width = to.len();
                let mut k = 0;
                while k < width {
                    // The last block overlaps columns already done instead of reaching beyond the row.
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
                            to[i] = block[i];
                        }
                    }
                    k += $lanes;
                }
            }

            #[inline(always)]
            fn scatter<'a>(
                width: usize,
                column: impl Fn(usize) -> &'a Self,
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
                            block[i] = *column(start + i);
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
        }
    };
}
pub(crate) use register;

/// Loads and stores of fewer numbers of a row than a register holds, for sets without masks.
macro_rules! copy_parts {
    ($name:ident, $float:ty, $lanes:literal) => {
        impl $name {
            #[inline(always)]
            fn load_part(row: &[$float], count: usize) -> Self {
                if row.len() >= $lanes {
                    // Numbers beyond `count` are loaded into columns that are never read.
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
pub(crate) use copy_parts;

/// Recomputes the sines of angles that are out of range or NaN, one by one.
#[cold]
#[inline(never)]
fn recompute_far_angles<T: Scalar>(angles: &[T], sines: &mut [T], cosines: &mut [T])
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
