//! The arithmetic of an expression.

use crate::Precision;

/// The implementation of sine and cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sine {
    /// The library's own polynomials, as a part of the expression: the same bits on every machine. Valid for
    /// angles below 1e5 rad in double precision and 8192 rad in single precision.
    #[default]
    Own,
    /// The platform's library: any angle, but bits that differ from platform to platform. Generated Rust
    /// needs the standard library for it.
    Platform,
}

/// The arithmetic of an expression.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Arithmetic {
    /// The precision of its numbers.
    pub precision: Precision,
    /// Whether a b + c is rounded once where the recursions ask for it. This is faster on a machine that has
    /// the instruction and far slower on one that does not. Generated Rust needs the standard library for it.
    pub fused: bool,
    /// The implementation of sine and cosine.
    pub sine: Sine,
}

impl Arithmetic {
    /// Arithmetic in a precision, with nothing fused and the library's own sine.
    ///
    /// ```
    /// use robot_dynamics_expression::{Arithmetic, Precision, Sine};
    /// let small = Arithmetic::new(Precision::Single);
    /// assert!(!small.fused && small.sine == Sine::Own && small != Arithmetic::default());
    /// ```
    pub fn new(precision: Precision) -> Self {
        Self { precision, ..Self::default() }
    }

    /// The same arithmetic with each multiply-add rounded once.
    ///
    /// ```
    /// assert!(robot_dynamics_expression::Arithmetic::default().with_fused().fused);
    /// ```
    pub fn with_fused(mut self) -> Self {
        self.fused = true;
        self
    }

    /// The same arithmetic with this sine.
    ///
    /// ```
    /// use robot_dynamics_expression::{Arithmetic, Sine};
    /// assert_eq!(Arithmetic::default().with_sine(Sine::Platform).sine, Sine::Platform);
    /// ```
    pub fn with_sine(mut self, sine: Sine) -> Self {
        self.sine = sine;
        self
    }
}
