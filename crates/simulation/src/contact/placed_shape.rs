//! A shape in the world.

use nalgebra::{Matrix3, Vector3};

/// A shape in the world.
pub(super) struct PlacedShape {
    pub(super) center: Vector3<f64>,
    pub(super) rotation: Matrix3<f64>,
}

impl PlacedShape {
    /// The position of a point of the shape in the world.
    pub(super) fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.center + self.rotation * point
    }
}
