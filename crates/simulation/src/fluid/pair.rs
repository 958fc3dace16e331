//! Velocities and forces of shapes.

use nalgebra::Vector3;

/// A linear part, then an angular part: a velocity or a force.
pub(super) type Pair = [Vector3<f64>; 2];
