//! How an expression is computed.

use crate::Precision;

/// Who computes sine and cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sine {
    /// The library's own polynomials, a part of the expression: the same bits on every machine. For angles below 1e5 rad in double
    /// and 8192 rad in single precision.
    #[default]
    Own,
    /// The platform's library: any angle, bits that differ from platform to platform; generated Rust needs the standard library for it.
    Platform,
}

/// How an expression is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Arithmetic {
    /// Its floats.
    pub precision: Precision,
    /// Whether a b + c is rounded once, where the recursions say so: faster on a machine that has the instruction, far slower on
    /// one that has not; generated Rust needs the standard library for it.
    pub fused: bool,
    /// Its sine.
    pub sine: Sine,
}

impl Arithmetic {
    /// In a precision, nothing fused, with the library's own sine.
    ///
    /// ```
    /// use expression::{Arithmetic, Precision, Sine};
    /// let small = Arithmetic::new(Precision::Single);
    /// assert!(!small.fused && small.sine == Sine::Own && small != Arithmetic::default());
    /// ```
    pub fn new(precision: Precision) -> Self {
        Self { precision, ..Self::default() }
    }

    /// With each multiply-add rounded once.
    ///
    /// ```
    /// assert!(expression::Arithmetic::default().with_fused().fused);
    /// ```
    pub fn with_fused(mut self) -> Self {
        self.fused = true;
        self
    }

    /// With this sine.
    ///
    /// ```
    /// use expression::{Arithmetic, Sine};
    /// assert_eq!(Arithmetic::default().with_sine(Sine::Platform).sine, Sine::Platform);
    /// ```
    pub fn with_sine(mut self, sine: Sine) -> Self {
        self.sine = sine;
        self
    }
}
