//! The numbers that a device computes in.

use generate::Precision;
use multibody::batch::BatchFloat;

/// A number that batches on a device are computed in: `f32` on every device, `f64` on those that have it.
pub trait DeviceFloat: BatchFloat + bytemuck::Pod {
    #[doc(hidden)]
    const PRECISION: Precision;

    /// The largest angle \[rad\] that the sine of generated code takes.
    #[doc(hidden)]
    const MOST_ANGLE: f64;

    #[doc(hidden)]
    const NAN: Self;

    #[doc(hidden)]
    fn wide(self) -> f64;
}

impl DeviceFloat for f32 {
    const PRECISION: Precision = Precision::Single;
    const MOST_ANGLE: f64 = number::sine::SHORT_RANGE;
    const NAN: Self = Self::NAN;
    fn wide(self) -> f64 {
        self.into()
    }
}

impl DeviceFloat for f64 {
    const PRECISION: Precision = Precision::Double;
    const MOST_ANGLE: f64 = number::sine::RANGE;
    const NAN: Self = Self::NAN;
    fn wide(self) -> f64 {
        self
    }
}
