//! How generated code computes.

use crate::Precision;

/// Who computes sine and cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sine {
    /// The library's own polynomials, written into the code: the same bits on every machine. For angles below 1e5 rad in double
    /// and 8192 rad in single precision.
    #[default]
    Own,
    /// The platform's library: any angle, bits that differ from platform to platform, and in Rust the standard library.
    Platform,
}

/// How generated code computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Arithmetic {
    /// Its floats.
    pub precision: Precision,
    /// Whether a b + c is rounded once, where the recursions say so: faster on a machine that has the instruction, far slower on
    /// one that has not; in Rust it needs the standard library.
    pub fused: bool,
    /// Its sine.
    pub sine: Sine,
}

impl Arithmetic {
    /// In a precision, nothing fused, with the library's own sine.
    ///
    /// ```
    /// use generate::{Arithmetic, Precision, Sine};
    /// let small = Arithmetic::new(Precision::Single);
    /// assert!(!small.fused && small.sine == Sine::Own && small != Arithmetic::default());
    /// ```
    pub fn new(precision: Precision) -> Self {
        Self { precision, ..Self::default() }
    }

    /// With each multiply-add rounded once.
    ///
    /// ```
    /// assert!(generate::Arithmetic::default().with_fused().fused);
    /// ```
    pub fn with_fused(mut self) -> Self {
        self.fused = true;
        self
    }

    /// With this sine.
    ///
    /// ```
    /// use generate::{Arithmetic, Sine};
    /// assert_eq!(Arithmetic::default().with_sine(Sine::Platform).sine, Sine::Platform);
    /// ```
    pub fn with_sine(mut self, sine: Sine) -> Self {
        self.sine = sine;
        self
    }

    /// Whether generated Rust needs the standard library.
    pub(crate) fn needs_std(self) -> bool {
        self.fused || self.sine == Sine::Platform
    }

    /// In words.
    pub(crate) fn told(self) -> String {
        let fused = if self.fused { "multiply-adds rounded once" } else { "nothing fused" };
        let sine = match (self.sine, self.precision) {
            (Sine::Platform, _) => "the platform's sine",
            (Sine::Own, Precision::Double) => "own sine, for angles below 1e5 rad",
            (Sine::Own, Precision::Single) => "own sine, for angles below 8192 rad",
        };
        format!("{}, {fused}, {sine}", self.precision)
    }
}
