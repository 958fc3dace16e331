//! A robot as its file states it: links, joints, frames, by name, in the file's own axes.
//!
//! A [`RobotDescription`] is plain data: readers of robot files fill it, users edit it, serde writes it.
//! [`Model::new`](crate::Model::new) checks it and turns it into the form the recursions need.

use std::collections::{HashMap, HashSet};

use dynamics::MassProperties;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{JointKind, Pose};

/// Earth's gravity along −z of the world frame \[m/s²\].
pub const EARTH_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A robot: a tree of links connected by joints.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct RobotDescription {
    /// The robot's name.
    pub name: String,
    /// The gravitational acceleration in the world frame \[m/s²\].
    pub gravity: [f64; 3],
    /// How the root link hangs in the world.
    pub base: Base,
    /// Every link; exactly one, the root, is no joint's child.
    pub links: Vec<LinkDescription>,
    /// Every joint; each connects a parent link to a child link.
    pub joints: Vec<JointDescription>,
    /// Further named frames, fixed to links; every link is a frame already.
    pub frames: Vec<FrameDescription>,
}

impl RobotDescription {
    /// An empty robot in Earth's gravity, its base fixed to the world.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            gravity: EARTH_GRAVITY,
            base: Base::Fixed,
            links: Vec::new(),
            joints: Vec::new(),
            frames: Vec::new(),
        }
    }

    /// The name of the joint that a floating base adds: [`FLOATING_BASE`], or `floating_base_2` and so on where
    /// joints of the robot have taken it.
    ///
    /// ```
    /// let mut robot = multibody::pendulum(2.0, 0.5);
    /// assert_eq!(robot.floating_base_name(), "floating_base");
    /// robot.joints[0].name = "floating_base".into();
    /// assert_eq!(robot.floating_base_name(), "floating_base_2");
    /// ```
    pub fn floating_base_name(&self) -> String {
        let is_taken = |name: &str| self.joints.iter().any(|joint| joint.name == name);
        let numbered = (2..).map(|number| format!("{FLOATING_BASE}_{number}"));
        core::iter::once(FLOATING_BASE.to_owned())
            .chain(numbered)
            .find(|name| !is_taken(name))
            .unwrap_or_default()
    }

    /// Whether the robot floats by joints of its own: the root link, with all that is fixed to it, has no mass, and
    /// every joint from there is a floating one. Freeing its base as well would add motions of nothing.
    ///
    /// ```
    /// use multibody::{JointKind, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// assert!(!robot.root_floats());
    /// robot.joints[0].kind = JointKind::Floating; // from a ceiling without mass: a free rod
    /// assert!(robot.root_floats());
    /// ```
    pub fn root_floats(&self) -> bool {
        let children: HashSet<&str> = self.joints.iter().map(|joint| joint.child.as_str()).collect();
        let Some(root) = self.links.iter().find(|link| !children.contains(link.name.as_str())) else {
            return false;
        };
        let has_mass: HashSet<&str> = self
            .links
            .iter()
            .filter(|link| link.mass_properties.is_some())
            .map(|link| link.name.as_str())
            .collect();
        let mut from = HashMap::<&str, Vec<&JointDescription>>::new();
        for joint in &self.joints {
            from.entry(&joint.parent).or_default().push(joint);
        }
        let (mut floats, mut pending) = (false, vec![root.name.as_str()]);
        while let Some(link) = pending.pop() {
            if has_mass.contains(link) {
                return false;
            }
            for joint in from.remove(link).unwrap_or_default() {
                match joint.kind {
                    JointKind::Fixed => pending.push(&joint.child),
                    JointKind::Floating => floats = true,
                    _ => return false,
                }
            }
        }
        floats
    }
}

/// How the root link hangs in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Base {
    /// The root link's frame is the world frame.
    Fixed,
    /// Six degrees of freedom, a joint named [`FLOATING_BASE`] (see there) before all others:
    /// q = \[x y z, qx qy qz qw\], v = \[linear, angular\] in the root link's frame.
    Floating,
}

/// The name of the joint that a floating base adds; where a joint of the robot has it, a number follows:
/// see [`RobotDescription::floating_base_name`].
pub const FLOATING_BASE: &str = "floating_base";

/// A rigid link.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct LinkDescription {
    /// Its name, unique among links.
    pub name: String,
    /// Mass, centre of mass and inertia in the link's frame; `None` for a link without mass.
    #[cfg_attr(feature = "serde", serde(with = "mass_properties_as_numbers"))]
    pub mass_properties: Option<MassProperties>,
}

/// A joint between two links. The child link's frame is the joint's moved frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointDescription {
    /// Its name, unique among joints.
    pub name: String,
    /// The motion it allows.
    pub kind: JointKind,
    /// The name of the parent link.
    pub parent: String,
    /// The name of the child link.
    pub child: String,
    /// The joint's frame in the parent link's frame, at q = 0.
    pub parent_from_joint: Pose,
    /// Position, velocity and effort limits.
    pub limits: Limits,
    /// Forces the joint itself adds.
    pub passive: PassiveForces,
    /// Present when the joint follows another one.
    pub mimic: Option<Mimic>,
}

impl JointDescription {
    /// A joint without limits or passive forces.
    pub fn new(
        name: impl Into<String>,
        kind: JointKind,
        parent: impl Into<String>,
        child: impl Into<String>,
        parent_from_joint: Pose,
    ) -> Self {
        Self {
            name: name.into(),
            kind,
            parent: parent.into(),
            child: child.into(),
            parent_from_joint,
            limits: Limits::default(),
            passive: PassiveForces::default(),
            mimic: None,
        }
    }
}

/// Bounds on a joint's position, speed and effort; infinite where the file gives none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Limits {
    /// Smallest q \[rad or m\].
    #[cfg_attr(feature = "serde", serde(with = "number_or_infinity"))]
    pub lower: f64,
    /// Largest q \[rad or m\].
    #[cfg_attr(feature = "serde", serde(with = "number_or_infinity"))]
    pub upper: f64,
    /// Largest |v| \[rad/s or m/s\].
    #[cfg_attr(feature = "serde", serde(with = "number_or_infinity"))]
    pub velocity: f64,
    /// Largest |τ| \[N·m or N\].
    #[cfg_attr(feature = "serde", serde(with = "number_or_infinity"))]
    pub effort: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity: f64::INFINITY,
            effort: f64::INFINITY,
        }
    }
}

/// What a joint's own mechanics add to the rigid bodies: τ = armature·v̇ + damping·v + friction·sign v
/// + stiffness·(q − rest). The same value applies to each degree of freedom of the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct PassiveForces {
    /// Rotor inertia seen through the gear, I_rotor·ratio² \[kg·m² or kg\].
    pub armature: f64,
    /// Viscous damping \[N·m·s/rad or N·s/m\].
    pub damping: f64,
    /// Coulomb friction \[N·m or N\].
    pub friction: f64,
    /// Spring stiffness \[N·m/rad or N/m\]; for joints whose q is plain numbers.
    pub stiffness: f64,
    /// Position at which the spring is relaxed \[rad or m\].
    pub rest: f64,
}

/// q = ratio · q_leader + offset.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Mimic {
    /// The name of the joint that is followed.
    pub joint: String,
    /// k, follower's units per leader's.
    pub ratio: f64,
    /// c \[rad or m\].
    pub offset: f64,
}

/// A named frame fixed to a link.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct FrameDescription {
    /// Its name, unique among frames and links.
    pub name: String,
    /// The link that carries it.
    pub link: String,
    /// The frame in the link's frame.
    pub link_from_frame: Pose,
}

/// Mass properties written as numbers; reading them back takes them as written, if they are finite and symmetric.
#[cfg(feature = "serde")]
mod mass_properties_as_numbers {
    use dynamics::MassProperties;
    use nalgebra::{Matrix3, Vector3};
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    #[derive(Serialize, Deserialize)]
    struct Numbers {
        mass: f64,
        center_of_mass: [f64; 3],
        /// About the centre of mass, along the link's axes: xx, xy, xz, yy, yz, zz.
        inertia: [f64; 6],
    }

    #[allow(clippy::ref_option)] // serde's `with` passes a reference to the field
    pub(super) fn serialize<S: Serializer>(
        properties: &Option<MassProperties>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let numbers = properties.as_ref().map(|p| {
            let i = p.inertia_about_center_of_mass();
            Numbers {
                mass: p.mass(),
                center_of_mass: p.center_of_mass().into(),
                inertia: [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]],
            }
        });
        numbers.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<MassProperties>, D::Error> {
        let Some(numbers) = Option::<Numbers>::deserialize(deserializer)? else { return Ok(None) };
        let [xx, xy, xz, yy, yz, zz] = numbers.inertia;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        MassProperties::as_written(numbers.mass, Vector3::from(numbers.center_of_mass), inertia)
            .map(Some)
            .map_err(D::Error::custom)
    }
}

/// A number, or the words `inf` and `-inf`, which JSON has no number for.
#[cfg(feature = "serde")]
mod number_or_infinity {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    enum Value {
        Number(f64),
        Word(String),
    }

    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub(super) fn serialize<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        if x.is_finite() {
            Value::Number(*x).serialize(serializer)
        } else {
            Value::Word(x.to_string()).serialize(serializer)
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::Number(x) => Ok(x),
            Value::Word(word) if word == "inf" => Ok(f64::INFINITY),
            Value::Word(word) if word == "-inf" => Ok(f64::NEG_INFINITY),
            Value::Word(word) => {
                Err(D::Error::custom(format!("expected a number, \"inf\" or \"-inf\", found {word:?}")))
            }
        }
    }
}
