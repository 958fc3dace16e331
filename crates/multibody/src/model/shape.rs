//! The shapes a robot's file draws on its links: plain data, read for what they tell about sizes.

use core::f64::consts::PI;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Pose;

/// A shape on a link.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct LinkShape {
    /// The link that carries it.
    pub link: String,
    /// What it is drawn for.
    pub role: ShapeRole,
    /// The shape's frame in the link's frame.
    pub link_from_shape: Pose,
    /// Form and size.
    pub shape: Shape,
}

impl LinkShape {
    /// A shape on that link.
    ///
    /// ```
    /// use multibody::{LinkShape, Pose, Shape, ShapeRole};
    /// let ball = LinkShape::new("rod", ShapeRole::Visual, Pose::IDENTITY, Shape::Sphere { radius: 0.1 });
    /// assert_eq!(ball.shape.bounding_radius(), Some(0.1));
    /// ```
    pub fn new(link: impl Into<String>, role: ShapeRole, link_from_shape: Pose, shape: Shape) -> Self {
        Self { link: link.into(), role, link_from_shape, shape }
    }
}

/// What a shape is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum ShapeRole {
    /// How the link looks.
    Visual,
    /// What it hits.
    Collision,
}

/// Form and size; every one but a mesh is centred at its frame's origin.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Shape {
    /// A box with these edges along x, y, z \[m\].
    Box {
        /// Edges.
        size: [f64; 3],
    },
    /// A cylinder about z.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Length along z \[m\].
        length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A cylinder about z, closed by two half balls.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Length of the cylinder between the half balls \[m\].
        length: f64,
    },
    /// A file, which is never opened: its size is not known here.
    Mesh {
        /// As the robot's file names it.
        name: String,
        /// Factors along x, y, z.
        scale: [f64; 3],
    },
}

impl Shape {
    /// Volume \[m³\]; `None` for a mesh.
    pub fn volume(&self) -> Option<f64> {
        match *self {
            Self::Box { size: [x, y, z] } => Some(x * y * z),
            Self::Cylinder { radius, length } => Some(PI * radius * radius * length),
            Self::Sphere { radius } => Some(4.0 / 3.0 * PI * radius.powi(3)),
            Self::Capsule { radius, length } => Some(PI * radius * radius * (length + 4.0 / 3.0 * radius)),
            Self::Mesh { .. } => None,
        }
    }

    /// Radius of the smallest ball about its frame's origin that holds the shape \[m\]; `None` for a mesh.
    pub fn bounding_radius(&self) -> Option<f64> {
        match *self {
            Self::Box { size: [x, y, z] } => Some(0.5 * x.hypot(y).hypot(z)),
            Self::Cylinder { radius, length } => Some(radius.hypot(0.5 * length)),
            Self::Sphere { radius } => Some(radius),
            Self::Capsule { radius, length } => Some(radius + 0.5 * length),
            Self::Mesh { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A capsule between its limits: without a cylinder it is a ball, long it is a cylinder.
    #[test]
    fn volumes_and_radii() {
        let ball = Shape::Sphere { radius: 0.3 };
        let short = Shape::Capsule { radius: 0.3, length: 0.0 };
        let volumes = (ball.volume().unwrap(), short.volume().unwrap());
        assert!((volumes.0 - volumes.1).abs() < 1e-15, "{volumes:?}");
        assert_eq!(ball.bounding_radius(), short.bounding_radius());
        let brick = Shape::Box { size: [2.0, 3.0, 6.0] };
        assert_eq!((brick.volume(), brick.bounding_radius()), (Some(36.0), Some(3.5)));
        let can = Shape::Cylinder { radius: 3.0, length: 8.0 };
        assert_eq!(can.bounding_radius(), Some(5.0));
        assert!((can.volume().unwrap() - 72.0 * PI).abs() < 1e-12);
        let mesh = Shape::Mesh { name: "arm.stl".into(), scale: [0.001; 3] };
        assert_eq!((mesh.volume(), mesh.bounding_radius()), (None, None));
    }
}
