//! The number a formula is written over: `f64`, `f32`, dual numbers, or several states side by side.
//!
//! A mass matrix written once over [`Scalar`] yields its value (`f64`), its exact derivatives
//! ([`Dual`](crate::Dual)), or many values at once (lanes), all from the same source lines.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number as the formulas of dynamics need it: ring operations, division, √, sine and cosine.
///
/// Robot constants stay `f64` and enter through [`Scalar::from_f64`] or [`Scalar::scale`].
/// There is no ordering and no branch on a value: a `Scalar` may hold several states at once.
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

    /// `self · a + b`; fused into one rounding only by types that know the hardware can.
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
        assert!(angles.len() == sines.len() && angles.len() == cosines.len());
        for ((&angle, sine), cosine) in angles.iter().zip(sines).zip(cosines) {
            (*sine, *cosine) = angle.sin_cos();
        }
    }
}

macro_rules! float_scalar {
    ($float:ty) => {
        impl Scalar for $float {
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
float_scalar!(f64);
float_scalar!(f32);
