//! Floats whose multiply-add is one instruction.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::Scalar;
use crate::sincos::{Float, sin_cos_each};

/// A float that promises a machine with fused multiply-add: `a.mul_add(b, c)` rounds once.
///
/// On a machine without it the results are the same but each multiply-add is a slow library call, so code
/// over this type belongs behind a run-time check of the machine.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[repr(transparent)]
pub struct Fused<T>(pub T);

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<T: Float> $trait for Fused<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<T: Float> Neg for Fused<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<T: Float> AddAssign for Fused<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.0 = self.0 + other.0;
    }
}

impl<T: Float> SubAssign for Fused<T> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.0 = self.0 - other.0;
    }
}

impl<T: Float> MulAssign for Fused<T> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        self.0 = self.0 * other.0;
    }
}

impl<T: Float> Scalar for Fused<T> {
    type Fused = Self;
    type Triple = T::FusedTriple;
    type Symmetric = T::FusedSymmetric;
    #[inline(always)]
    fn fuse(self) -> Self {
        self
    }
    #[inline(always)]
    fn unfuse(fused: Self) -> Self {
        fused
    }
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self(<T as Scalar>::from_f64(x))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = Scalar::sin_cos(self.0);
        (Self(sine), Self(cosine))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(Scalar::sqrt(self.0))
    }
    #[inline(always)]
    fn signum0(self) -> Self {
        Self(self.0.signum0())
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(self.0.fused_mul_add(a.0, b.0))
    }
    #[inline(always)]
    fn sin_cos_each(angles: &[Self], sines: &mut [Self], cosines: &mut [Self]) {
        sin_cos_each(angles, sines, cosines);
    }
    #[inline(always)]
    fn fused_sin_cos_each(angles: &[Self], sines: &mut [Self], cosines: &mut [Self]) {
        sin_cos_each(angles, sines, cosines);
    }
}
