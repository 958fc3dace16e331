//! The number a formula is written over: `f64`, `f32`, dual numbers, or several states side by side.
//!
//! A mass matrix written once over [`Scalar`] yields its value (`f64`), its exact derivatives
//! ([`Dual`](crate::Dual)), or many values at once (lanes). All come from the same source lines.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::{Symmetric, Triple};

/// A real number as the formulas of dynamics need it: ring operations, division, √, sine and cosine.
///
/// Robot constants stay `f64` and enter through [`Scalar::from_f64`] or [`Scalar::scale`].
/// There is no ordering and no branch on a value: a `Scalar` may hold several states at once.
///
/// A number of your own has `type Triple = [Self; 3]` and `type Symmetric = [Self; 6]`.
pub trait Scalar:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// Three of these as one value.
    type Triple: Triple<Self>;

    /// A symmetric 3×3 matrix of these.
    type Symmetric: Symmetric<Self, Self::Triple>;

    /// Whether this is `f64` or `f32`. Libraries may compile their algorithms once for these.
    #[doc(hidden)]
    const IS_FLOAT: bool = false;

    /// The member of a type family, with its type known to the compiler if this is a float.
    #[doc(hidden)]
    #[inline(always)]
    fn specialize<F: TypeFamily>(member: F::Over<Self>) -> Specialization<F, Self> {
        Specialization::Other(member)
    }

    /// The constant `x`, rounded to this type's precision; its derivatives are zero.
    fn from_f64(x: f64) -> Self;

    /// (sin x, cos x), `self` in radians.
    fn sin_cos(self) -> (Self, Self);

    /// √x; NaN where x < 0.
    fn sqrt(self) -> Self;

    /// −1, 0 or +1 by the sign of x (0 at 0); the derivative is zero. Coulomb friction needs it.
    fn signum0(self) -> Self;

    /// 0.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }

    /// 1.
    #[inline(always)]
    fn one() -> Self {
        Self::from_f64(1.0)
    }

    /// k x for a constant k.
    #[inline(always)]
    fn scale(self, k: f64) -> Self {
        self * Self::from_f64(k)
    }

    /// `self · a + b`; only types whose hardware has the instruction fuse it into one rounding.
    #[inline(always)]
    #[must_use]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }

    /// Sine and cosine of each angle; types that can evaluate several at once override it.
    ///
    /// # Panics
    /// If the three slices differ in length.
    #[inline(always)]
    fn sin_cos_each(angles: &[Self], sines: &mut [Self], cosines: &mut [Self]) {
        check_lengths(angles.len(), sines.len(), cosines.len());
        for ((&angle, sine), cosine) in angles.iter().zip(sines).zip(cosines) {
            (*sine, *cosine) = angle.sin_cos();
        }
    }
}

/// A family of types: a type constructor with one member for each number.
#[doc(hidden)]
#[doc(alias = "Form")]
pub trait TypeFamily {
    /// The member over `S`.
    type Over<S: Scalar>;
}

/// A member of a type family, with its type known if the number is a float. See [`Scalar::specialize`].
#[doc(hidden)]
#[doc(alias = "AsFloat")]
pub enum Specialization<F: TypeFamily, S: Scalar> {
    /// The number is `f64`.
    F64(F::Over<f64>),
    /// The number is `f32`.
    F32(F::Over<f32>),
    /// The number is neither.
    Other(F::Over<S>),
}

/// Panics with all three lengths if they differ.
#[inline(always)]
#[track_caller]
pub(crate) fn check_lengths(angles: usize, sines: usize, cosines: usize) {
    assert!(
        angles == sines && angles == cosines,
        "angles, sines and cosines differ in length: {angles}, {sines} and {cosines}"
    );
}

macro_rules! float_scalar {
    ($float:ty, $variant:ident) => {
        impl Scalar for $float {
            const IS_FLOAT: bool = true;
            #[inline(always)]
            fn specialize<F: TypeFamily>(member: F::Over<Self>) -> Specialization<F, Self> {
                Specialization::$variant(member)
            }
            type Triple = [Self; 3];
            type Symmetric = [Self; 6];
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, clippy::cast_lossless)]
            fn from_f64(x: f64) -> Self {
                x as $float
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                <$float>::sin_cos(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            #[inline(always)]
            fn signum0(self) -> Self {
                if self == 0.0 { 0.0 } else { self.signum() }
            }
        }
    };
}
float_scalar!(f64, F64);
float_scalar!(f32, F32);

#[cfg(test)]
mod tests {
    use super::*;

    /// sign(0) is 0, not +1: a joint at rest has no Coulomb friction; NaN stays NaN.
    #[test]
    fn the_sign_of_zero_is_zero() {
        let sign = Scalar::signum0;
        assert_eq!([-2.0_f64, -0.0, 0.0, 3.0].map(sign), [-1.0, 0.0, 0.0, 1.0]);
        assert!(sign(f64::NAN).is_nan());
    }

    #[test]
    fn several_angles_are_each_angle() {
        let angles = [0.3_f64, -2.0, 7.5];
        let (mut sines, mut cosines) = ([0.0; 3], [0.0; 3]);
        f64::sin_cos_each(&angles, &mut sines, &mut cosines);
        for k in 0..3 {
            assert_eq!((sines[k], cosines[k]), angles[k].sin_cos());
        }
    }

    #[test]
    #[should_panic(expected = "2, 2 and 1")]
    fn unequal_lengths_are_refused() {
        f64::sin_cos_each(&[0.0, 1.0], &mut [0.0; 2], &mut [0.0; 1]);
    }

    /// One formula in two precisions: f32 has 24 bits, 6e-8.
    #[test]
    fn precisions_agree() {
        fn formula<S: Scalar>(x: S) -> S {
            (x * x + S::one()).sqrt() * x.sin_cos().0 - x.scale(0.25)
        }
        assert!((f64::from(formula(0.7_f32)) - formula(f64::from(0.7_f32))).abs() < 2e-7);
    }
}
