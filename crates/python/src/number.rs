//! The numbers that batches are computed in, and each robot's memory for them.

use crate::ffi::ArrayNumber;
use crate::robot::Robot;
use crate::scratch::{Batch, Slots};

/// A number that arrays hold and batches are computed in.
pub(crate) trait Number: ArrayNumber {
    /// The robot's memory for batches.
    fn batches(robot: &Robot) -> &Slots<Batch<Self>>;
}

impl Number for f64 {
    fn batches(robot: &Robot) -> &Slots<Batch<Self>> {
        &robot.batches_f64
    }
}

impl Number for f32 {
    fn batches(robot: &Robot) -> &Slots<Batch<Self>> {
        &robot.batches_f32
    }
}
