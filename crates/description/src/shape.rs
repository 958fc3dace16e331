//! Shapes of a robot's links, for sizes, appearance and contact. No algorithm of dynamics reads them.

use core::f64::consts::PI;
use std::path::{Path, PathBuf};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{InertiaError, MassProperties, Pose, SolverImpedance};

/// A shape on a link.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct LinkShape {
    /// The link that carries it.
    pub link: String,
    /// Its purpose.
    pub role: ShapeRole,
    /// The shape's frame in the link's frame.
    pub link_from_shape: Pose,
    /// Form and size.
    pub shape: Shape,
    /// Its own name; empty if the file gives none.
    #[cfg_attr(feature = "serde", serde(default))]
    pub name: String,
    /// Red, green, blue and opacity, 0 to 1; `None` if the file gives none.
    #[cfg_attr(feature = "serde", serde(default))]
    pub color: Option<[f64; 4]>,
    /// Its contact parameters, if the file gives them.
    #[cfg_attr(feature = "serde", serde(default))]
    pub surface: Surface,
    /// The motion of its surface, for example of a conveyor belt.
    #[cfg_attr(feature = "serde", serde(default))]
    pub surface_velocity: SurfaceVelocity,
}

/// The motion of a surface relative to its shape, as contacts see it: σ(x) = v + ω × x in the shape's frame.
///
/// Friction acts on the sum of this and the motion of the shape. Only the part of σ tangential to a contact
/// counts, and the normal part of ω drives torsional friction. The contacts do work on the other body, which
/// counts as a negative friction loss.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct SurfaceVelocity {
    /// v in the shape's frame \[m/s\].
    pub linear: [f64; 3],
    /// ω in the shape's frame, about its origin \[rad/s\].
    pub angular: [f64; 3],
}

impl SurfaceVelocity {
    /// Whether the surface is at rest relative to its shape.
    ///
    /// ```
    /// use robot_dynamics::description::SurfaceVelocity;
    /// assert!(SurfaceVelocity::default().is_zero());
    /// ```
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    /// The same motion, where `a_from_b` places this frame b in a.
    ///
    /// ```
    /// use robot_dynamics::description::{Pose, SurfaceVelocity};
    /// let turntable = SurfaceVelocity { linear: [0.0; 3], angular: [0.0, 0.0, 2.0] };
    /// let moved = turntable.in_frame(&Pose::from_translation([1.0, 0.0, 0.0]));
    /// assert_eq!((moved.linear, moved.angular), ([0.0, -2.0, 0.0], [0.0, 0.0, 2.0]));
    /// ```
    #[must_use]
    pub fn in_frame(&self, a_from_b: &Pose) -> Self {
        let turn = Pose { rotation: a_from_b.rotation, translation: [0.0; 3] };
        let ([x, y, z], [a, b, c]) = (a_from_b.translation, turn.apply(self.angular));
        let [u, v, w] = turn.apply(self.linear);
        // −ω × p for the origin p.
        let linear = [u - (b * z - c * y), v - (c * x - a * z), w - (a * y - b * x)];
        Self { linear, angular: [a, b, c] }
    }

    /// All six numbers: v, then ω.
    ///
    /// ```
    /// use robot_dynamics::description::SurfaceVelocity;
    /// let belt = SurfaceVelocity { linear: [0.3, 0.0, 0.0], angular: [0.0, 0.0, 1.0] };
    /// assert_eq!(belt.to_array(), [0.3, 0.0, 0.0, 0.0, 0.0, 1.0]);
    /// ```
    pub fn to_array(&self) -> [f64; 6] {
        let ([a, b, c], [d, e, f]) = (self.linear, self.angular);
        [a, b, c, d, e, f]
    }
}

impl LinkShape {
    /// A shape on this link.
    ///
    /// ```
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole};
    /// let ball = LinkShape::new("rod", ShapeRole::Visual, Pose::IDENTITY, Shape::Sphere { radius: 0.1 });
    /// assert_eq!(ball.shape.bounding_radius(), Some(0.1));
    /// ```
    pub fn new(link: impl Into<String>, role: ShapeRole, link_from_shape: Pose, shape: Shape) -> Self {
        Self {
            link: link.into(),
            role,
            link_from_shape,
            shape,
            name: String::new(),
            color: None,
            surface: Surface::default(),
            surface_velocity: SurfaceVelocity::default(),
        }
    }

    /// With a name.
    ///
    /// ```
    /// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole};
    /// let ball = LinkShape::new("rod", ShapeRole::Visual, Pose::IDENTITY, Shape::Sphere { radius: 0.1 });
    /// let ball = ball.with_name("bob").with_color([1.0, 0.0, 0.0, 1.0]);
    /// assert_eq!((ball.name.as_str(), ball.color), ("bob", Some([1.0, 0.0, 0.0, 1.0])));
    /// ```
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// With a colour: red, green, blue and opacity, 0 to 1.
    pub fn with_color(self, color: [f64; 4]) -> Self {
        Self { color: Some(color), ..self }
    }

    /// With these contact parameters.
    pub fn with_surface(self, surface: Surface) -> Self {
        Self { surface, ..self }
    }
}

/// Contact parameters of a shape, with the names and defaults of MJCF.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Surface {
    /// Coefficients of friction: sliding, torsional \[m\], rolling \[m\].
    pub friction: [f64; 3],
    /// The dimension of a contact's force: 1 for normal, 3 with sliding, 4 with torsional, 6 with rolling
    /// friction.
    pub condim: u8,
    /// Two shapes can collide if a bit of one's `contype` is set in the other's `conaffinity`.
    pub contype: u32,
    /// See `contype`.
    pub conaffinity: u32,
    /// The shape of higher priority determines the contact's parameters; equal priorities mix them.
    pub priority: i32,
    /// The weight in that mix.
    pub solmix: f64,
    /// Time constant \[s\] and damping ratio of the contact; if both are negative, −stiffness and −damping.
    pub solref: [f64; 2],
    /// The contact's impedance as a function of penetration depth.
    pub solimp: [f64; 5],
    /// The distance within which a contact is detected \[m\].
    pub margin: f64,
    /// The part of the margin within which a contact has no force \[m\].
    pub gap: f64,
    /// `solref` of a pair's friction, if it differs from that of the normal force: see
    /// [`ContactPairDescription`](crate::ContactPairDescription).
    #[cfg_attr(feature = "serde", serde(default))]
    pub solreffriction: Option<[f64; 2]>,
}

impl Default for Surface {
    fn default() -> Self {
        let SolverImpedance { solref, solimp } = SolverImpedance::default();
        Self {
            friction: [1.0, 0.005, 1e-4],
            condim: 3,
            contype: 1,
            conaffinity: 1,
            priority: 0,
            solmix: 1.0,
            solref,
            solimp,
            margin: 0.0,
            gap: 0.0,
            solreffriction: None,
        }
    }
}

impl Surface {
    /// The first of its quantities with a number that is not finite.
    pub fn not_finite(&self) -> Option<&'static str> {
        let solreffriction = self.solreffriction.unwrap_or_default();
        let quantities: [(&'static str, &[f64]); 7] = [
            ("solreffriction", &solreffriction),
            ("friction", &self.friction),
            ("solref", &self.solref),
            ("solimp", &self.solimp),
            ("margin", &[self.margin]),
            ("gap", &[self.gap]),
            ("solmix", &[self.solmix]),
        ];
        quantities.iter().find(|(_, numbers)| numbers.iter().any(|x| !x.is_finite())).map(|(name, _)| *name)
    }
}

/// The purpose of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum ShapeRole {
    /// Appearance.
    Visual,
    /// Collision.
    Collision,
}

/// Geometry; every shape except a mesh is centred at its frame's origin.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
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
    /// A cylinder about z with two hemispherical caps.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Length of the cylinder between the caps \[m\].
        length: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Half axes along x, y, z \[m\].
        half_axes: [f64; 3],
    },
    /// The half space below the plane z = 0.
    Plane {
        /// Half lengths along x and y for drawing \[m\]; 0 if unlimited. For contact the plane is always
        /// unlimited.
        half_size: [f64; 2],
    },
    /// A height field over a rectangle: its heights, or a file with them, which this crate does not open.
    HeightField {
        /// As the robot's file names it.
        name: String,
        /// The path of the file, if it was found.
        file: Option<PathBuf>,
        /// Half lengths along x and y, largest height, depth of the base below 0 \[m\].
        size: [f64; 4],
        /// Its heights, if the robot's file contains them.
        #[cfg_attr(feature = "serde", serde(default))]
        elevation: Option<Elevation>,
    },
    /// A triangle mesh in a file that this crate does not open, so its size is unknown.
    Mesh {
        /// As the robot's file names it.
        name: String,
        /// The path of the file, if it was found.
        file: Option<PathBuf>,
        /// Factors along x, y, z.
        scale: [f64; 3],
    },
}

/// Heights on a grid, the argument of `HeightField::new`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Elevation {
    /// Number of rows along y, ascending.
    pub rows: usize,
    /// Number of columns along x.
    pub columns: usize,
    /// Row by row \[m\].
    pub heights: Vec<f64>,
}

impl Elevation {
    /// Heights from these numbers, shifted and scaled so that the least is 0 and the largest is `highest`
    /// \[m\], as MuJoCo does for files. All are 0 if the numbers are equal.
    ///
    /// ```
    /// let elevation = robot_dynamics::description::Elevation::stretched(2, 2, &[3.0, 5.0, 4.0, 3.0], 0.6);
    /// assert_eq!(elevation.heights, [0.0, 0.6, 0.3, 0.0]);
    /// ```
    pub fn stretched(rows: usize, columns: usize, numbers: &[f64], highest: f64) -> Self {
        let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let range = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max) - least;
        let height = |number: &f64| if range > 0.0 { highest * ((number - least) / range) } else { 0.0 };
        Self { rows, columns, heights: numbers.iter().map(height).collect() }
    }
}

impl Shape {
    /// A mesh of this name at the scale of its file; the file is not searched for.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::description::Shape::mesh("arm.stl").volume(), None);
    /// ```
    pub fn mesh(name: impl Into<String>) -> Self {
        Self::Mesh { name: name.into(), file: None, scale: [1.0; 3] }
    }

    /// The file of a mesh, or of a height field without its own heights. Returns the name in the robot's
    /// file, and the path if it was found.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::description::Shape::mesh("arm.stl").file(), Some(("arm.stl", None)));
    /// ```
    pub fn file(&self) -> Option<(&str, Option<&Path>)> {
        match self {
            Self::Mesh { name, file, .. } | Self::HeightField { name, file, elevation: None, .. } => {
                Some((name, file.as_deref()))
            }
            _ => None,
        }
    }

    /// Volume \[m³\]; `None` for a mesh, a height field and a half space.
    pub fn volume(&self) -> Option<f64> {
        match *self {
            Self::Box { size: [x, y, z] } => Some(x * y * z),
            Self::Cylinder { radius, length } => Some(PI * radius * radius * length),
            Self::Sphere { radius } => Some(4.0 / 3.0 * PI * radius.powi(3)),
            Self::Capsule { radius, length } => Some(PI * radius * radius * (length + 4.0 / 3.0 * radius)),
            Self::Ellipsoid { half_axes: [x, y, z] } => Some(4.0 / 3.0 * PI * x * y * z),
            Self::Plane { .. } | Self::HeightField { .. } | Self::Mesh { .. } => None,
        }
    }

    /// Mass properties at a density \[kg/m³\] in the shape's frame; `None` for a mesh, a height field and a
    /// half space.
    ///
    /// # Errors
    /// [`InertiaError`] if the density or a length is not positive and finite.
    pub fn solid(&self, density: f64) -> Option<Result<MassProperties, InertiaError>> {
        match *self {
            Self::Box { size } => Some(MassProperties::solid_box(density, size.into())),
            Self::Cylinder { radius, length } => {
                Some(MassProperties::solid_cylinder(density, radius, length))
            }
            Self::Sphere { radius } => Some(MassProperties::solid_sphere(density, radius)),
            Self::Capsule { radius, length } => Some(MassProperties::solid_capsule(density, radius, length)),
            Self::Ellipsoid { half_axes } => Some(MassProperties::solid_ellipsoid(density, half_axes.into())),
            Self::Plane { .. } | Self::HeightField { .. } | Self::Mesh { .. } => None,
        }
    }

    /// Radius of the smallest ball about its frame's origin that contains the shape \[m\]; `None` for a mesh,
    /// a height field and a half space.
    pub fn bounding_radius(&self) -> Option<f64> {
        match *self {
            Self::Box { size: [x, y, z] } => Some(0.5 * x.hypot(y).hypot(z)),
            Self::Cylinder { radius, length } => Some(radius.hypot(0.5 * length)),
            Self::Sphere { radius } => Some(radius),
            Self::Capsule { radius, length } => Some(radius + 0.5 * length),
            Self::Ellipsoid { half_axes: [x, y, z] } => Some(x.max(y).max(z)),
            Self::Plane { .. } | Self::HeightField { .. } | Self::Mesh { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Limits of a capsule: without a cylinder it is a ball, and a long one is nearly a cylinder.
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
        let egg = Shape::Ellipsoid { half_axes: [0.3; 3] };
        assert_eq!(egg.bounding_radius(), ball.bounding_radius());
        assert!((egg.volume().unwrap() - volumes.0).abs() < 1e-15);
        let mesh = Shape::mesh("arm.stl");
        assert_eq!((mesh.volume(), mesh.bounding_radius()), (None, None));
    }
}
