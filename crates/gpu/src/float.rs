//! The numbers of a device.

use robot_dynamics::batch::BatchFloat;
use robot_dynamics_generate::Precision;

/// A number for batches on a device: `f32` on every device, `f64` on those that support it.
pub trait DeviceFloat: BatchFloat + bytemuck::Pod {
    #[doc(hidden)]
    const PRECISION: Precision;

    /// The bound on angles \[rad\] of the sine of generated code.
    #[doc(hidden)]
    const MOST_ANGLE: f64;

    #[doc(hidden)]
    const NAN: Self;

    #[doc(hidden)]
    fn wide(self) -> f64;
}

impl DeviceFloat for f32 {
    const PRECISION: Precision = Precision::Single;
    const MOST_ANGLE: f64 = robot_dynamics_number::sine::SHORT_RANGE;
    const NAN: Self = Self::NAN;
    fn wide(self) -> f64 {
        self.into()
    }
}

impl DeviceFloat for f64 {
    const PRECISION: Precision = Precision::Double;
    const MOST_ANGLE: f64 = robot_dynamics_number::sine::RANGE;
    const NAN: Self = Self::NAN;
    fn wide(self) -> f64 {
        self
    }
}
