//! Kinds of joints, with the names and units of their coordinates.

use core::fmt;

use nalgebra::Vector3;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Pose;

/// The motion of a joint, in the joint's frame. Axes need not be normalized.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum JointKind {
    /// No motion.
    Fixed,
    /// Rotation about `axis`: q \[rad\].
    Revolute {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
    },
    /// Rotation about `axis` without position limits: one angle q \[rad\], not wrapped.
    Continuous {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
    },
    /// Translation along `axis`: q \[m\].
    Prismatic {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
    },
    /// Screw motion: rotation q \[rad\] about `axis` with the translation `pitch`·q along it.
    Helical {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
        /// Advance per angle \[m/rad\].
        pitch: f64,
    },
    /// Two rotations in series: q = (angle about `first`, angle about `second` in the rotated frame) \[rad\].
    Universal {
        /// First axis, in the joint's frame.
        first: [f64; 3],
        /// Second axis, in the frame rotated by the first angle.
        second: [f64; 3],
    },
    /// Translation in the plane normal to `normal`, then rotation about it: q = (x, y, θ) in m, m, rad. The x
    /// axis is the coordinate axis after `normal`'s largest component (the first of equals), made
    /// perpendicular to `normal`; y = `normal` × x. For `normal` = z they are the joint's own x and y.
    Planar {
        /// Normal of the plane, in the joint's frame.
        normal: [f64; 3],
    },
    /// Any rotation: q = \[qx qy qz qw\], v = angular velocity in the child frame \[rad/s\].
    Spherical,
    /// Any motion: q = \[x y z, qx qy qz qw\], v = \[linear, angular\] in the child frame.
    Floating,
}

impl JointKind {
    /// The kind's name, in the spelling of robot files if they have it.
    ///
    /// ```
    /// use robot_dynamics::description::JointKind;
    /// assert_eq!(JointKind::Revolute { axis: [0.0, 1.0, 0.0] }.name(), "revolute");
    /// ```
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute { .. } => "revolute",
            Self::Continuous { .. } => "continuous",
            Self::Prismatic { .. } => "prismatic",
            Self::Helical { .. } => "helical",
            Self::Universal { .. } => "universal",
            Self::Planar { .. } => "planar",
            Self::Spherical => "spherical",
            Self::Floating => "floating",
        }
    }

    /// The kind of this name; `axis` is the first axis or the normal, and kinds without axes do not read it.
    /// `second` is the second axis of a universal joint, and `pitch` \[m/rad\] that of a helical one.
    ///
    /// ```
    /// use robot_dynamics::description::JointKind;
    /// let z = [0.0, 0.0, 1.0];
    /// let planar = JointKind::named("planar", z, [0.0, 1.0, 0.0], 0.0);
    /// assert_eq!(planar, Some(JointKind::Planar { normal: z }));
    /// assert_eq!(JointKind::named("hinge", z, z, 0.0), None);
    /// ```
    pub fn named(name: &str, axis: [f64; 3], second: [f64; 3], pitch: f64) -> Option<Self> {
        Some(match name {
            "fixed" => Self::Fixed,
            "revolute" => Self::Revolute { axis },
            "continuous" => Self::Continuous { axis },
            "prismatic" => Self::Prismatic { axis },
            "helical" => Self::Helical { axis, pitch },
            "universal" => Self::Universal { first: axis, second },
            "planar" => Self::Planar { normal: axis },
            "spherical" => Self::Spherical,
            "floating" => Self::Floating,
            _ => return None,
        })
    }

    /// The coordinates of q, in order.
    ///
    /// ```
    /// use robot_dynamics::description::{JointKind, CoordinateKind};
    /// let planar = JointKind::Planar { normal: [0.0, 0.0, 1.0] };
    /// let [x, y, theta] = planar.positions() else { unreachable!("a planar joint has three") };
    /// assert_eq!((x.name, y.name, theta.name), ("x", "y", "theta"));
    /// assert_eq!((x.kind, theta.kind), (CoordinateKind::Length, CoordinateKind::Angle));
    /// ```
    pub fn positions(&self) -> &'static [Coordinate] {
        match self {
            Self::Fixed => &[],
            Self::Revolute { .. } | Self::Continuous { .. } | Self::Helical { .. } => const { &[angle("")] },
            Self::Prismatic { .. } => const { &[length("")] },
            Self::Universal { .. } => const { &[angle("1"), angle("2")] },
            Self::Planar { .. } => const { &[length("x"), length("y"), angle("theta")] },
            Self::Spherical => {
                const { &[component("qx"), component("qy"), component("qz"), component("qw")] }
            }
            Self::Floating => {
                const {
                    &[
                        length("x"),
                        length("y"),
                        length("z"),
                        component("qx"),
                        component("qy"),
                        component("qz"),
                        component("qw"),
                    ]
                }
            }
        }
    }

    /// The coordinates of v and of τ, in order. The kind is that of the quantity whose rate v is.
    ///
    /// ```
    /// use robot_dynamics::description::JointKind;
    /// let names: Vec<&str> = JointKind::Floating.velocities().iter().map(|entry| entry.name).collect();
    /// assert_eq!(names, ["vx", "vy", "vz", "wx", "wy", "wz"]); // linear before angular
    /// ```
    pub fn velocities(&self) -> &'static [Coordinate] {
        match self {
            Self::Spherical => const { &[angle("wx"), angle("wy"), angle("wz")] },
            Self::Floating => {
                const { &[length("vx"), length("vy"), length("vz"), angle("wx"), angle("wy"), angle("wz")] }
            }
            // For kinds without a quaternion, v is the rate of q.
            plain => plain.positions(),
        }
    }

    /// The coordinates of q before the quaternion.
    pub fn plain_positions(&self) -> &'static [Coordinate] {
        let positions = self.positions();
        let plain = positions.iter().position(|position| position.kind == CoordinateKind::Quaternion);
        &positions[..plain.unwrap_or(positions.len())]
    }

    /// The length of q.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::description::JointKind::Spherical.nq(), 4); // a quaternion
    /// ```
    pub fn nq(&self) -> usize {
        self.positions().len()
    }

    /// The length of v: the degrees of freedom.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::description::JointKind::Spherical.nv(), 3); // ω
    /// ```
    pub fn nv(&self) -> usize {
        self.velocities().len()
    }
}

impl fmt::Display for JointKind {
    /// Writes its name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One coordinate of a joint's q or v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Coordinate {
    /// Its name among the joint's coordinates; empty if there is only one.
    pub name: &'static str,
    /// The measured quantity; for v, the quantity whose rate it is.
    pub kind: CoordinateKind,
}

impl Coordinate {
    /// The coordinate's name among those of all joints: the joint's name, with the coordinate's own if there
    /// are several.
    ///
    /// ```
    /// use robot_dynamics::description::JointKind;
    /// assert_eq!(JointKind::Spherical.velocities()[0].of_joint("hip"), "hip.wx");
    /// assert_eq!(JointKind::Prismatic { axis: [0.0, 0.0, 1.0] }.velocities()[0].of_joint("lift"), "lift");
    /// ```
    pub fn of_joint(&self, joint: &str) -> String {
        if self.name.is_empty() { joint.into() } else { format!("{joint}.{}", self.name) }
    }
}

/// The quantity that a coordinate of q measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[doc(alias = "Measure")]
pub enum CoordinateKind {
    /// A length \[m\].
    Length,
    /// An angle \[rad\].
    Angle,
    /// A component of a unit quaternion.
    Quaternion,
}

const fn length(name: &'static str) -> Coordinate {
    Coordinate { name, kind: CoordinateKind::Length }
}

const fn angle(name: &'static str) -> Coordinate {
    Coordinate { name, kind: CoordinateKind::Angle }
}

const fn component(name: &'static str) -> Coordinate {
    Coordinate { name, kind: CoordinateKind::Quaternion }
}

/// A rotation C with C e_z along `axis`. For coordinate axes its entries are exactly 0 and ±1.
#[doc(hidden)]
pub fn z_onto(axis: [f64; 3]) -> Pose {
    let a = Vector3::from(axis).normalize();
    // The triad starts from the coordinate axis after the axis' largest component, so that the three
    // coordinate axes give cyclic permutations.
    let largest = a.iamax();
    let mut seed = Vector3::zeros();
    seed[(largest + 1) % 3] = 1.0;
    let x = (seed - a * a.dot(&seed)).normalize();
    let y = a.cross(&x);
    let rotation = core::array::from_fn(|i| [x[i], y[i], a[i]]);
    Pose { rotation, translation: [0.0; 3] }
}
