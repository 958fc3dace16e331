//! A shape of a link that can touch.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{Surface, SurfaceVelocity};

use super::contact_geometry::ContactGeometry;
use super::convex::Convex;
use super::placed_shape::PlacedShape;
use crate::placement::Placement;

/// A shape of a link.
#[derive(Clone, Debug)]
pub(super) struct ContactShape {
    pub(super) name: String,
    pub(super) link: String,
    /// The index of its link among those that can touch the ground.
    pub(super) on_ground: Option<usize>,
    /// The body that moves it, or [`WORLD`](robot_dynamics_core::model::WORLD).
    pub(super) body: usize,
    /// The coordinates that move it, in increasing order.
    pub(super) coordinates: Vec<usize>,
    /// `body_from_shape`.
    pub(super) rotation: Matrix3<f64>,
    pub(super) translation: Vector3<f64>,
    pub(super) form: ContactGeometry,
    /// The convex form, if one of its pairs needs it.
    pub(super) convex: Option<Convex>,
    pub(super) reach: f64,
    /// Half the size of the bounding box of its points, along its axes and centred on its origin \[m\].
    pub(super) extent: Vector3<f64>,
    pub(super) surface: Surface,
    pub(super) surface_velocity: SurfaceVelocity,
    /// The planes and height fields paired with it, by name, each with the surface of that pair. A ground
    /// without a name represents the first.
    pub(super) on_grounds: Vec<(String, Surface)>,
    /// The number of its first point among those of all shapes.
    pub(super) first: usize,
}

impl ContactShape {
    /// The shape in the world.
    pub(super) fn placed(&self, placement: &Placement) -> PlacedShape {
        let (rotation, p) = placement.body(self.body);
        PlacedShape { center: p + rotation * self.translation, rotation: rotation * self.rotation }
    }
}
