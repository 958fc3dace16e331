//! The motion of surfaces relative to their shapes, at a contact.

use nalgebra::Vector3;
use robot_dynamics_description::SurfaceVelocity;

use super::ContactSet;
use super::shape_point::{ContactPartner, ShapePoint};
use crate::placement::{Placement, Twist};

impl ContactSet {
    /// The motion of the surface of a contact's first shape relative to that of its partner: the velocity at
    /// a point, and ω. The motion of the bodies is not included. `None` if no surface moves.
    pub(super) fn surface_motion(
        &self,
        placement: &Placement,
        point: &ShapePoint,
        at: Vector3<f64>,
    ) -> Option<Twist> {
        if !self.has_moving_surfaces {
            return None;
        }
        let of_shape = |shape: usize| {
            let shape = &self.shapes[shape];
            let placed = shape.placed(placement);
            let SurfaceVelocity { linear, angular } = shape.surface_velocity;
            let [linear, angular] = [linear, angular].map(|x| placed.rotation * Vector3::from(x));
            [linear + angular.cross(&(at - placed.center)), angular]
        };
        let in_world = |SurfaceVelocity { linear, angular }: SurfaceVelocity| {
            let [linear, angular] = [linear, angular].map(Vector3::from);
            [linear + angular.cross(&at), angular]
        };
        let [velocity, spin] = of_shape(point.shape);
        let [other_velocity, other_spin] = match point.against {
            ContactPartner::Ground(ground) => in_world(self.grounds[ground].0.surface_velocity),
            ContactPartner::Field(field) => in_world(self.fields[field].surface_velocity),
            ContactPartner::Pair(pair) => of_shape(self.pairs[pair].shapes[1]),
        };
        Some([velocity - other_velocity, spin - other_spin])
    }
}
