//! The kinds of joints: their names, and the names and units of their numbers.

use core::fmt;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// The motion a joint allows, in the joint's frame. Axes need not be normalised.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum JointKind {
    /// None.
    Fixed,
    /// A turn about `axis`: q \[rad\].
    Revolute {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
    },
    /// A turn about `axis` without position limits: one angle q \[rad\], not wrapped.
    Continuous {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
    },
    /// A slide along `axis`: q \[m\].
    Prismatic {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
    },
    /// A screw: a turn q \[rad\] about `axis` and a slide `pitch`·q along it.
    Helical {
        /// Direction of the axis in the joint's frame.
        axis: [f64; 3],
        /// Advance per angle \[m/rad\].
        pitch: f64,
    },
    /// Two turns in series: q = (angle about `first`, angle about `second` in the turned frame) \[rad\].
    Universal {
        /// First axis, in the joint's frame.
        first: [f64; 3],
        /// Second axis, in the frame turned by the first angle.
        second: [f64; 3],
    },
    /// Motion in the plane normal to `normal`, then a turn about it: q = (x, y, θ) in m, m, rad. The x axis
    /// is the coordinate axis after `normal`'s largest component (the first of equals), made perpendicular
    /// to `normal`; y = `normal` × x. For `normal` = z they are the joint's own x and y.
    Planar {
        /// Normal of the plane, in the joint's frame.
        normal: [f64; 3],
    },
    /// Any turn: q = \[qx qy qz qw\], v = angular velocity in the child frame \[rad/s\].
    Spherical,
    /// Any motion: q = \[x y z, qx qy qz qw\], v = \[linear, angular\] in the child frame.
    Floating,
}

impl JointKind {
    /// The kind's name, as robot files spell it where they have it.
    ///
    /// ```
    /// use multibody::JointKind;
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

    /// The numbers of q, in order: what each is called and what it measures.
    ///
    /// ```
    /// use multibody::{JointKind, Measure};
    /// let planar = JointKind::Planar { normal: [0.0, 0.0, 1.0] };
    /// let [x, y, theta] = planar.positions() else { unreachable!("a planar joint has three") };
    /// assert_eq!((x.name, y.name, theta.name), ("x", "y", "theta"));
    /// assert_eq!((x.measure, theta.measure), (Measure::Length, Measure::Angle));
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

    /// The numbers of v and of τ, in order: their names, and what those of v are the rate of.
    ///
    /// ```
    /// use multibody::JointKind;
    /// let names: Vec<&str> = JointKind::Floating.velocities().iter().map(|entry| entry.name).collect();
    /// assert_eq!(names, ["vx", "vy", "vz", "wx", "wy", "wz"]); // linear before angular
    /// ```
    pub fn velocities(&self) -> &'static [Coordinate] {
        match self {
            Self::Spherical => const { &[angle("wx"), angle("wy"), angle("wz")] },
            Self::Floating => {
                const { &[length("vx"), length("vy"), length("vz"), angle("wx"), angle("wy"), angle("wz")] }
            }
            // Where q is plain numbers, v is their rate.
            plain => plain.positions(),
        }
    }

    /// Those numbers of q that are no quaternion's; they come first.
    pub(crate) fn plain_positions(&self) -> &'static [Coordinate] {
        let positions = self.positions();
        let plain = positions.iter().position(|position| position.measure == Measure::Quaternion);
        &positions[..plain.unwrap_or(positions.len())]
    }

    /// Numbers in q.
    ///
    /// ```
    /// assert_eq!(multibody::JointKind::Spherical.nq(), 4); // a quaternion
    /// ```
    pub fn nq(&self) -> usize {
        self.positions().len()
    }

    /// Numbers in v: degrees of freedom.
    ///
    /// ```
    /// assert_eq!(multibody::JointKind::Spherical.nv(), 3); // ω
    /// ```
    pub fn nv(&self) -> usize {
        self.velocities().len()
    }
}

impl fmt::Display for JointKind {
    /// Its name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One number of a joint's q or v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Coordinate {
    /// What it is called beside the joint's other numbers; nothing where there are none.
    pub name: &'static str,
    /// What it measures; of v, what it is the rate of.
    pub measure: Measure,
}

impl Coordinate {
    /// The number's name among those of all joints: the joint's, with its own where the joint has several.
    ///
    /// ```
    /// use multibody::JointKind;
    /// assert_eq!(JointKind::Spherical.velocities()[0].of_joint("hip"), "hip.wx");
    /// assert_eq!(JointKind::Prismatic { axis: [0.0, 0.0, 1.0] }.velocities()[0].of_joint("lift"), "lift");
    /// ```
    pub fn of_joint(&self, joint: &str) -> String {
        if self.name.is_empty() { joint.into() } else { format!("{joint}.{}", self.name) }
    }
}

/// What a number of q measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Measure {
    /// A length \[m\].
    Length,
    /// An angle \[rad\].
    Angle,
    /// A component of a unit quaternion.
    Quaternion,
}

const fn length(name: &'static str) -> Coordinate {
    Coordinate { name, measure: Measure::Length }
}

const fn angle(name: &'static str) -> Coordinate {
    Coordinate { name, measure: Measure::Angle }
}

const fn component(name: &'static str) -> Coordinate {
    Coordinate { name, measure: Measure::Quaternion }
}
