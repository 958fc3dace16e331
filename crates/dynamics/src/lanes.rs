//! Several states side by side: one number of each.
//!
//! A formula over [`Lanes`] is evaluated for L states by the same instructions. On a machine with AVX-512 or
//! AVX2 and FMA the hot algorithms run over [`Scalar::Fused`]: then the L numbers are one vector register,
//! [`F64x8`], [`F32x16`], [`F64x4`] or [`F32x8`]. Elsewhere they are an array, and each operation a loop for the
//! compiler to vectorise. Every lane's arithmetic is that of a lone number: what stands in one lane, be it
//! NaN, changes no bit of another.

mod sincos;

#[cfg(target_arch = "x86_64")]
mod registers;
#[cfg(target_arch = "x86_64")]
pub use registers::{F32x8, F32x16, F64x4, F64x8};

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::{Float, Scalar};

/// L numbers, one of each state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<T, const L: usize>(pub [T; L]);

/// A number for several states, read from and written to tables that hold one state after the other.
pub trait StateLanes: Scalar {
    /// The number of one state.
    type Float: Float;

    /// L, how many states.
    const LANES: usize;

    /// Every lane `x`.
    fn splat(x: Self::Float) -> Self;

    /// The number of state `lane`.
    fn lane(&self, lane: usize) -> Self::Float;

    /// Another number for state `lane`.
    fn set_lane(&mut self, lane: usize, x: Self::Float);

    /// Whether each lane is finite, a bit each.
    fn finite(&self) -> u32;

    /// `to[k]` becomes column k of the L rows, each `to.len()` long.
    ///
    /// `FUSED` promises what [`Scalar::Fused`] promises of the machine.
    ///
    /// # Panics
    /// If there are fewer than L rows.
    fn gather<const FUSED: bool>(rows: &[Self::Float], to: &mut [Self]);

    /// Column k of the L rows becomes `from[k]`, each row `from.len()` long; as [`StateLanes::gather`].
    ///
    /// # Panics
    /// If there are fewer than L rows.
    fn scatter<const FUSED: bool>(from: &[Self], rows: &mut [Self::Float]);
}

macro_rules! operator {
    ($trait:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        impl<T: Float, const L: usize> $trait for Lanes<T, L> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for k in 0..L {
                    self.0[k] = self.0[k].$method(other.0[k]);
                }
                self
            }
        }
        impl<T: Float, const L: usize> $assign for Lanes<T, L> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = (*self).$method(other);
            }
        }
    };
}
operator!(Add, add, AddAssign, add_assign);
operator!(Sub, sub, SubAssign, sub_assign);
operator!(Mul, mul, MulAssign, mul_assign);

impl<T: Float, const L: usize> Div for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        for k in 0..L {
            self.0[k] = self.0[k] / other.0[k];
        }
        self
    }
}

impl<T: Float, const L: usize> Neg for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for k in 0..L {
            self.0[k] = -self.0[k];
        }
        self
    }
}

macro_rules! lanes {
    ($float:ty, $lanes:literal, $register:ident) => {
        impl Scalar for Lanes<$float, $lanes> {
            #[cfg(target_arch = "x86_64")]
            type Fused = $register;
            #[cfg(not(target_arch = "x86_64"))]
            type Fused = Self;
            type Triple = [Self; 3];
            type Symmetric = [Self; 6];
            #[inline(always)]
            fn fuse(self) -> Self::Fused {
                #[cfg(target_arch = "x86_64")]
                return $register::from_array(&self.0);
                #[cfg(not(target_arch = "x86_64"))]
                return self;
            }
            #[inline(always)]
            fn unfuse(fused: Self::Fused) -> Self {
                #[cfg(target_arch = "x86_64")]
                return Self(fused.to_array());
                #[cfg(not(target_arch = "x86_64"))]
                return fused;
            }
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self([<$float as Scalar>::from_f64(x); $lanes])
            }
            fn sin_cos(self) -> (Self, Self) {
                let (mut sine, mut cosine) = (self, self);
                for k in 0..$lanes {
                    (sine.0[k], cosine.0[k]) = self.0[k].sin_cos();
                }
                (sine, cosine)
            }
            #[inline(always)]
            fn sqrt(mut self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = self.0[k].sqrt();
                }
                self
            }
            #[inline(always)]
            fn signum0(mut self) -> Self {
                for k in 0..$lanes {
                    self.0[k] = self.0[k].signum0();
                }
                self
            }
        }

        impl StateLanes for Lanes<$float, $lanes> {
            type Float = $float;
            const LANES: usize = $lanes;
            #[inline(always)]
            fn splat(x: $float) -> Self {
                Self([x; $lanes])
            }
            #[inline(always)]
            fn lane(&self, lane: usize) -> $float {
                self.0[lane]
            }
            #[inline(always)]
            fn set_lane(&mut self, lane: usize, x: $float) {
                self.0[lane] = x;
            }
            #[inline(always)]
            fn finite(&self) -> u32 {
                let mut bits = 0;
                for k in 0..$lanes {
                    bits |= u32::from(self.0[k].is_finite()) << k;
                }
                bits
            }
            #[inline(always)]
            fn gather<const FUSED: bool>(rows: &[$float], to: &mut [Self]) {
                #[cfg(target_arch = "x86_64")]
                if FUSED {
                    return $register::gather(rows, to);
                }
                let width = to.len();
                assert!(rows.len() >= $lanes * width, "{} numbers, not {}", rows.len(), $lanes * width);
                for (k, to) in to.iter_mut().enumerate() {
                    for lane in 0..$lanes {
                        to.0[lane] = rows[lane * width + k];
                    }
                }
            }
            #[inline(always)]
            fn scatter<const FUSED: bool>(from: &[Self], rows: &mut [$float]) {
                #[cfg(target_arch = "x86_64")]
                if FUSED {
                    return $register::scatter(from, rows);
                }
                let width = from.len();
                assert!(rows.len() >= $lanes * width, "{} numbers, not {}", rows.len(), $lanes * width);
                for (k, from) in from.iter().enumerate() {
                    for lane in 0..$lanes {
                        rows[lane * width + k] = from.0[lane];
                    }
                }
            }
        }
    };
}
lanes!(f64, 4, F64x4);
lanes!(f64, 8, F64x8);
lanes!(f32, 8, F32x8);
lanes!(f32, 16, F32x16);
