//! Level ground under a robot that floats.
//!
//! It lies where the file lays a plane under the robot, else at z = 0. The implicit method alone knows it: the robot falls, lands, and
//! stays, with Coulomb's friction, without sinking.

use core::f64::consts::PI;
use std::collections::HashMap;

use multibody::{ContactSet, Ground, Shape, ShapeRole, Workspace};
use nalgebra::Vector3;
use wasm_bindgen::prelude::wasm_bindgen;

use super::method::Method;
use super::robot::Robot;
use crate::LabError;

/// How far above the ground a robot starts that would else start in it \[m\].
const DROP: f64 = 0.1;

/// The ground, and the meshes that were given for shapes which touch it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Floor {
    /// What touches it, where it is laid.
    pub(crate) contacts: Option<ContactSet>,
    /// Corners of convex hulls by the number of their shape, in the shape's frame \[m\].
    meshes: HashMap<usize, Vec<[f64; 3]>>,
}

/// Directions in which a mesh of many points keeps its outermost ones, as a hull of thousands of corners would take seconds.
const DIRECTIONS: usize = 256;

/// A few hundred points on a hull.
fn outermost(points: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    if points.len() <= 2 * DIRECTIONS {
        return points;
    }
    let farthest = |d: Vector3<f64>| points.iter().max_by(|a, b| a.dot(&d).total_cmp(&b.dot(&d))).copied();
    on_sphere(DIRECTIONS).filter_map(farthest).collect()
}

/// So many points about evenly on the sphere: a spiral by the golden angle.
fn on_sphere(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sine, cosine) = (golden * k as f64).sin_cos();
        Vector3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
    })
}

#[wasm_bindgen]
impl Robot {
    /// Lays the ground, or takes it away. A robot that does not float stands on nothing.
    ///
    /// # Errors
    /// If a size or a surface of a shape that touches it is no number.
    #[wasm_bindgen(js_name = setGround)]
    pub fn set_ground(&mut self, on: bool) -> Result<(), LabError> {
        self.floor.contacts = None;
        if on && self.floats() {
            let (shapes, meshes) = (&self.model.description().shapes, &self.floor.meshes);
            let corners = |shape: &multibody::LinkShape| {
                let number = shapes.iter().position(|one| core::ptr::eq(one, shape));
                let given = number.and_then(|number| meshes.get(&number));
                given.cloned().ok_or_else(|| "its file was not given".to_owned())
            };
            let ground = [Ground::level(self.ground_height())];
            let contacts = ContactSet::with_meshes(&self.model, &ground, corners)?;
            self.floor.contacts = Some(contacts).filter(ContactSet::has_shapes);
        }
        if let Method::Implicit(_) = self.method {
            self.method = Method::implicit(&self.model, (self.floor.contacts.as_ref(), &self.loops));
        }
        Ok(())
    }

    /// The points of a shape's mesh, three numbers each, in the shape's frame \[m\]: it touches as their convex hull, of many points as
    /// that of some hundred outermost ones, once [`set_ground`](Self::set_ground) is called.
    #[wasm_bindgen(js_name = giveMesh)]
    pub fn give_mesh(&mut self, shape: usize, points: &[f64]) {
        let points: Vec<Vector3<f64>> = points.chunks_exact(3).map(Vector3::from_column_slice).collect();
        if points.iter().flatten().all(|x| x.is_finite()) {
            let corners = robot_mesh::corners(&outermost(points));
            self.floor.meshes.insert(shape, corners.into_iter().map(Into::into).collect());
        }
    }

    /// Where the ground is, or would be \[m\].
    #[wasm_bindgen(getter, js_name = groundHeight)]
    pub fn ground_height(&self) -> f64 {
        let description = self.model.description();
        let hangs = |link: &str| description.joints.iter().any(|joint| joint.child == link);
        let is_plane = |shape: &&multibody::LinkShape| {
            matches!(shape.shape, Shape::Plane { .. })
                && shape.role == ShapeRole::Collision
                && !hangs(&shape.link)
        };
        description.shapes.iter().find(is_plane).map_or(0.0, |plane| plane.link_from_shape.translation[2])
    }

    /// Whether the robot meets the ground as it moves.
    #[wasm_bindgen(getter)]
    pub fn grounded(&self) -> bool {
        self.floor.contacts.is_some() && matches!(self.method, Method::Implicit(_))
    }

    /// Shapes that would touch the ground and cannot, each with the reason.
    #[wasm_bindgen(getter, js_name = leftOut)]
    pub fn left_out(&self) -> Vec<String> {
        self.floor.contacts.as_ref().map_or_else(Vec::new, |contacts| contacts.left_out().to_vec())
    }

    /// Where the robot touches and what it feels there, six numbers a contact: the point \[m\], the force on the robot \[N\], in the world.
    #[wasm_bindgen(js_name = contactForces)]
    pub fn contact_forces(&self) -> Vec<f64> {
        match &self.method {
            Method::Implicit(implicit) => {
                implicit.touches().flat_map(|touch| touch.point.into_iter().chain(touch.force)).collect()
            }
            Method::Row(_) => Vec::new(),
        }
    }
}

impl Robot {
    /// Lifts a pose that is in the ground until its lowest point is above it.
    pub(crate) fn lift(&self, q: &mut [f64]) {
        let Some(contacts) = &self.floor.contacts else { return };
        let base = self.model.joints().iter().find(|joint| joint.kind == multibody::JointKind::Floating);
        let gap = contacts.clearance(&self.model, &mut Workspace::new(&self.model), q);
        if let (Some(base), Some(gap)) = (base, gap.filter(|gap| *gap < 0.0)) {
            q[base.q_index + 2] += DROP - gap;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of ten thousand points keeps its size but for the caps between 256 directions: 1 − cos of half their distance.
    #[test]
    fn many_points_keep_their_outline() {
        let kept = outermost(on_sphere(10_000).collect());
        assert_eq!(kept.len(), DIRECTIONS);
        for direction in
            [Vector3::z(), -Vector3::z(), Vector3::new(0.6, 0.0, -0.8), Vector3::new(0.0, -1.0, 0.0)]
        {
            let reach = kept.iter().map(|point| point.dot(&direction)).fold(0.0, f64::max);
            assert!(reach > 0.98 && reach < 1.0 + 1e-12, "{reach}");
        }
    }
}
