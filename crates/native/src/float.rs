//! The numbers that kernels compute with.

use robot_dynamics_expression::Precision;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for f32 {}
}

/// A number that kernels compute with.
pub trait Float:
    Copy + PartialOrd + Into<f64> + Send + Sync + core::fmt::Debug + sealed::Sealed + 'static
{
    /// Its precision.
    const PRECISION: Precision;

    /// The nearest number.
    fn nearest(x: f64) -> Self;
}

impl Float for f64 {
    const PRECISION: Precision = Precision::Double;
    fn nearest(x: f64) -> Self {
        x
    }
}

impl Float for f32 {
    const PRECISION: Precision = Precision::Single;
    #[allow(clippy::cast_possible_truncation)]
    fn nearest(x: f64) -> Self {
        x as f32
    }
}
