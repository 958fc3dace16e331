//! The two precisions of an expression, and arithmetic on constants in each.

use core::fmt;

/// The precision of an expression's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits.
    #[default]
    Double,
    /// 32 bits: the precision of floating-point units of small processors and of GPUs.
    Single,
}

impl Precision {
    /// `x` rounded to this precision. Doubles have more than twice the digits of singles. A sum, product,
    /// quotient or root of singles that is rounded to double first therefore gives the same single.
    #[allow(clippy::cast_possible_truncation)]
    pub fn round(self, x: f64) -> f64 {
        match self {
            Self::Double => x,
            Self::Single => f64::from(x as f32),
        }
    }

    /// a b + c, rounded once.
    #[allow(clippy::cast_possible_truncation)]
    pub fn multiply_add(self, a: f64, b: f64, c: f64) -> f64 {
        match self {
            Self::Double => a.mul_add(b, c),
            Self::Single => f64::from((a as f32).mul_add(b as f32, c as f32)),
        }
    }

    /// The distance from 1 to the next number.
    pub fn epsilon(self) -> f64 {
        match self {
            Self::Double => f64::EPSILON,
            Self::Single => f64::from(f32::EPSILON),
        }
    }

    /// Bytes of a number.
    ///
    /// ```
    /// assert_eq!(robot_dynamics_expression::Precision::Single.bytes(), 4);
    /// ```
    pub fn bytes(self) -> usize {
        match self {
            Self::Double => 8,
            Self::Single => 4,
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Double => "double precision",
            Self::Single => "single precision",
        })
    }
}
