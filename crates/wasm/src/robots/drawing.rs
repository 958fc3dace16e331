//! Data for drawing a robot: shapes, masses and axes once, poses for every frame.

use dynamics::MassProperties;
use robot_dynamics::algorithms::frame_poses;
use robot_dynamics::description::{JointKind, LinkShape, Shape, ShapeRole};
use robot_dynamics::model::Joint;
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;
use super::text::shown;

/// A shape on a link.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct DrawnShape {
    /// Its index among the shapes of the file.
    #[wasm_bindgen(readonly)]
    pub number: usize,
    /// The link's index.
    #[wasm_bindgen(readonly)]
    pub link: usize,
    /// Whether it is a visual shape; otherwise it is a collision shape.
    #[wasm_bindgen(readonly)]
    pub visual: bool,
    /// `box`, `cylinder`, `sphere`, `capsule`, `ellipsoid`, `plane`, `mesh`, or `other`.
    #[wasm_bindgen(readonly)]
    pub kind: String,
    /// Box: edges. Cylinder, capsule: radius, length. Sphere: radius. Ellipsoid: semi-axes. Plane: half
    /// sizes, 0 if unbounded. Mesh: scale factors along x, y, z \[m\].
    #[wasm_bindgen(readonly)]
    pub size: Vec<f64>,
    /// Link from shape: the rotation in row-major order, then the origin \[m\].
    #[wasm_bindgen(readonly)]
    pub pose: Vec<f64>,
    /// Red, green, blue, opacity; empty if the file has none.
    #[wasm_bindgen(readonly)]
    pub color: Vec<f64>,
    /// The path of a mesh in the robot's file; otherwise empty.
    #[wasm_bindgen(readonly)]
    pub file: String,
}

/// The mass of a link and its distribution.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct DrawnBody {
    /// The link's name.
    #[wasm_bindgen(readonly)]
    pub name: String,
    /// Mass \[kg\], 0 for a link without mass.
    #[wasm_bindgen(readonly)]
    pub mass: f64,
    /// Centre of mass in the link's frame \[m\].
    #[wasm_bindgen(readonly)]
    pub center: Vec<f64>,
    /// The semi-axes of the uniform ellipsoid with this mass and inertia \[m\].
    #[wasm_bindgen(readonly)]
    pub semiaxes: Vec<f64>,
    /// Link frame from principal axes, in row-major order.
    #[wasm_bindgen(readonly)]
    pub axes: Vec<f64>,
}

/// A joint between two links.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct DrawnJoint {
    /// The index of the parent link.
    #[wasm_bindgen(readonly)]
    pub parent: usize,
    /// The index of the child link.
    #[wasm_bindgen(readonly)]
    pub child: usize,
    /// The index of its coordinate; `undefined` if it has none or several.
    #[wasm_bindgen(readonly)]
    pub coordinate: Option<usize>,
    /// The indices of its coordinates.
    #[wasm_bindgen(readonly)]
    pub coordinates: Vec<usize>,
    /// Its axis in the child's frame; zero if it has none.
    #[wasm_bindgen(readonly)]
    pub axis: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// Every shape of the file.
    pub fn shapes(&self) -> Vec<DrawnShape> {
        let description = self.model.description();
        let number = |name: &str| description.links.iter().position(|link| link.name == name);
        let drawn = |(at, shape): (usize, &LinkShape)| Some(drawn_shape(at, shape, number(&shape.link)?));
        description.shapes.iter().enumerate().filter_map(drawn).collect()
    }

    /// Every link's mass, in the order of [`poses`](Self::poses).
    pub fn bodies(&self) -> Vec<DrawnBody> {
        let links = &self.model.description().links;
        links.iter().map(|link| drawn_body(&shown(&link.name), link.mass_properties.as_ref())).collect()
    }

    /// Every joint of the file.
    pub fn joints(&self) -> Vec<DrawnJoint> {
        let description = self.model.description();
        let number = |name: &str| description.links.iter().position(|link| link.name == name);
        let drawn = description.joints.iter().filter_map(|joint| {
            let axis = match joint.kind {
                JointKind::Revolute { axis }
                | JointKind::Continuous { axis }
                | JointKind::Prismatic { axis }
                | JointKind::Helical { axis, .. } => axis,
                JointKind::Fixed
                | JointKind::Universal { .. }
                | JointKind::Planar { .. }
                | JointKind::Spherical
                | JointKind::Floating => [0.0; 3],
            };
            let moves = self.model.joint(&joint.name).map_or(0..0, Joint::v);
            Some(DrawnJoint {
                parent: number(&joint.parent)?,
                child: number(&joint.child)?,
                coordinate: (moves.len() == 1).then_some(moves.start),
                coordinates: moves.collect(),
                axis: axis.to_vec(),
            })
        });
        drawn.collect()
    }

    /// Rows of twelve, one for each link: the rotation world from link in row-major order, then the origin
    /// \[m\].
    pub fn poses(&mut self) -> Vec<f64> {
        frame_poses(&self.model, &mut self.workspace, self.simulation.q(), &mut self.poses);
        let links = self.model.description().links.len();
        self.poses[..links]
            .iter()
            .flat_map(|pose| pose.rotation.iter().flatten().chain(&pose.translation).copied())
            .collect()
    }
}

fn drawn_shape(number: usize, shape: &LinkShape, link: usize) -> DrawnShape {
    let (kind, size) = match &shape.shape {
        Shape::Box { size } => ("box", size.to_vec()),
        Shape::Cylinder { radius, length } => ("cylinder", vec![*radius, *length]),
        Shape::Sphere { radius } => ("sphere", vec![*radius]),
        Shape::Capsule { radius, length } => ("capsule", vec![*radius, *length]),
        Shape::Ellipsoid { half_axes } => ("ellipsoid", half_axes.to_vec()),
        Shape::Plane { half_size } => ("plane", half_size.to_vec()),
        Shape::Mesh { scale, .. } => ("mesh", scale.to_vec()),
        Shape::HeightField { .. } => ("other", Vec::new()),
    };
    let place = &shape.link_from_shape;
    DrawnShape {
        number,
        link,
        visual: shape.role == ShapeRole::Visual,
        kind: kind.to_owned(),
        size,
        pose: place.rotation.iter().flatten().chain(&place.translation).copied().collect(),
        color: shape.color.map_or_else(Vec::new, |color| color.to_vec()),
        file: shape.shape.file().map_or_else(String::new, |(name, _)| name.to_owned()),
    }
}

/// The principal moments are I₁ = m(σ₂² + σ₃²) and so on. The mean square distance from the centre along an
/// axis is σ₁² = (I₂ + I₃ − I₁)/(2m). For an ellipsoid of semi-axis a it is a²/5.
fn drawn_body(name: &str, body: Option<&MassProperties>) -> DrawnBody {
    let name = name.to_owned();
    let Some(body) = body else {
        let (center, semiaxes) = (vec![0.0; 3], vec![0.0; 3]);
        return DrawnBody {
            name,
            mass: 0.0,
            center,
            semiaxes,
            axes: vec![1., 0., 0., 0., 1., 0., 0., 0., 1.],
        };
    };
    let principal = body.principal();
    let i = principal.moments;
    // The triangle inequality holds up to rounding.
    let semiaxis = |k: usize| (2.5 * (i.sum() - 2.0 * i[k]).max(0.0) / body.mass()).sqrt();
    DrawnBody {
        name,
        mass: body.mass(),
        center: body.center_of_mass().as_slice().to_vec(),
        semiaxes: (0..3).map(semiaxis).collect(),
        axes: principal.body_from_principal.matrix().transpose().as_slice().to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn an_ellipsoid_is_drawn_as_itself() -> Result<(), dynamics::InertiaError> {
        let body = MassProperties::solid_ellipsoid(700.0, Vector3::new(0.3, 0.2, 0.1))?;
        let drawn = drawn_body("egg", Some(&body));
        // Ascending moments mean descending semi-axes.
        for (found, expected) in drawn.semiaxes.iter().zip([0.3, 0.2, 0.1]) {
            assert!((found - expected).abs() < 1e-14, "{drawn:?}");
        }
        Ok(())
    }
}
