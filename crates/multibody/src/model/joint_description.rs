//! A joint as its file states it.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{HigherTerms, JointKind, JointSoftness, PlacementSpring, Pose};

/// A joint between two links. The child link's frame is the joint's moved frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
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
    /// The spring of a spherical or floating joint.
    #[cfg_attr(feature = "serde", serde(default))]
    pub spring: Option<PlacementSpring>,
    /// What its spring and damper add beyond that: of a joint of one freedom; of a spherical or floating one the spring's by the
    /// length of the stretch, the damper's freedom by freedom, linear ones along the axes that the joint hangs in.
    #[cfg_attr(feature = "serde", serde(default))]
    pub higher_terms: HigherTerms,
    /// Present when the joint follows another one.
    pub mimic: Option<Mimic>,
    /// Bounds on what its actuators give it together \[N·m or N\]; infinite where there are none. See
    /// [`ActuatorDescription`](crate::ActuatorDescription).
    #[cfg_attr(feature = "serde", serde(with = "numbers_or_infinity", default = "unbounded"))]
    pub actuator_force_range: [f64; 2],
    /// Whether the links' gravity compensation comes from its actuators and counts within that range.
    #[cfg_attr(feature = "serde", serde(default))]
    pub actuator_compensates_gravity: bool,
    /// How its limits and friction yield under MuJoCo's law; the rigid law does not read it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub softness: JointSoftness,
}

/// Of a joint without bounds.
const fn unbounded() -> [f64; 2] {
    [f64::NEG_INFINITY, f64::INFINITY]
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
            spring: None,
            higher_terms: HigherTerms::default(),
            mimic: None,
            actuator_force_range: unbounded(),
            actuator_compensates_gravity: false,
            softness: JointSoftness::default(),
        }
    }

    /// With bounds on its motion and effort.
    ///
    /// ```
    /// use multibody::{JointDescription, JointKind, Limits, PassiveForces, Pose};
    /// let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    /// let joint = JointDescription::new("elbow", hinge, "upper_arm", "forearm", Pose::IDENTITY)
    ///     .with_limits(Limits::new(0.0, 2.5))
    ///     .with_passive(PassiveForces::default().with_damping(0.1));
    /// assert!(joint.limits.upper == 2.5 && joint.passive.damping == 0.1 && joint.mimic.is_none());
    /// ```
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// With forces of its own.
    pub fn with_passive(self, passive: PassiveForces) -> Self {
        Self { passive, ..self }
    }

    /// Following another joint.
    pub fn with_mimic(self, mimic: Mimic) -> Self {
        Self { mimic: Some(mimic), ..self }
    }
}

/// Bounds on a joint's position, speed and effort; infinite where the file gives none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
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
    /// Largest angle of a ball joint's turn from q = 1 \[rad\].
    #[cfg_attr(feature = "serde", serde(with = "number_or_infinity", default = "unlimited"))]
    pub turn: f64,
}

/// A bound that is not given.
#[cfg(feature = "serde")]
const fn unlimited() -> f64 {
    f64::INFINITY
}

impl Limits {
    /// Bounds on the position \[rad or m\] alone.
    ///
    /// ```
    /// use multibody::Limits;
    /// let limits = Limits::new(-1.5, 1.5).with_velocity(2.0).with_effort(40.0);
    /// assert_eq!((limits.upper, limits.effort), (1.5, 40.0));
    /// assert_eq!(Limits::default().velocity, f64::INFINITY);
    /// ```
    pub const fn new(lower: f64, upper: f64) -> Self {
        Self { lower, upper, velocity: f64::INFINITY, effort: f64::INFINITY, turn: f64::INFINITY }
    }

    /// With a largest |v| \[rad/s or m/s\].
    pub const fn with_velocity(self, velocity: f64) -> Self {
        Self { velocity, ..self }
    }

    /// With a largest |τ| \[N·m or N\].
    pub const fn with_effort(self, effort: f64) -> Self {
        Self { effort, ..self }
    }

    /// With a largest angle of a ball joint's turn \[rad\].
    pub const fn with_turn(self, turn: f64) -> Self {
        Self { turn, ..self }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::new(f64::NEG_INFINITY, f64::INFINITY)
    }
}

/// What a joint's own mechanics add to the rigid bodies: τ = armature·v̇ + damping·v + friction·sign v
/// + stiffness·(q − rest). The same value applies to each degree of freedom of the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct PassiveForces {
    /// Rotor inertia seen through the gear, I_rotor·ratio² \[kg·m² or kg\].
    pub armature: f64,
    /// Viscous damping \[N·m·s/rad or N·s/m\].
    pub damping: f64,
    /// Coulomb friction \[N·m or N\].
    pub friction: f64,
    /// Spring stiffness \[N·m/rad or N/m\]; for joints whose q is plain numbers, others have a [`PlacementSpring`].
    pub stiffness: f64,
    /// Position at which the spring is relaxed \[rad or m\].
    pub rest: f64,
}

impl PassiveForces {
    /// With a rotor inertia, seen through the gear \[kg·m² or kg\].
    ///
    /// ```
    /// use multibody::PassiveForces;
    /// let joint = PassiveForces::default().with_armature(0.1).with_damping(0.5).with_friction(0.2);
    /// let joint = joint.with_spring(30.0, 0.1); // 30 N·m/rad, relaxed at 0.1 rad
    /// assert_eq!((joint.damping, joint.rest), (0.5, 0.1));
    /// ```
    pub const fn with_armature(self, armature: f64) -> Self {
        Self { armature, ..self }
    }

    /// With viscous damping \[N·m·s/rad or N·s/m\].
    pub const fn with_damping(self, damping: f64) -> Self {
        Self { damping, ..self }
    }

    /// With Coulomb friction \[N·m or N\].
    pub const fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// With a spring: its stiffness \[N·m/rad or N/m\] and where it is relaxed \[rad or m\].
    pub const fn with_spring(self, stiffness: f64, rest: f64) -> Self {
        Self { stiffness, rest, ..self }
    }
}

/// q = ratio · q_leader + offset.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Mimic {
    /// The name of the joint that is followed.
    pub joint: String,
    /// k, follower's units per leader's.
    pub ratio: f64,
    /// c \[rad or m\].
    pub offset: f64,
}

impl Mimic {
    /// To follow that joint.
    ///
    /// ```
    /// let finger = multibody::Mimic::new("other_finger", 1.0, 0.0);
    /// assert_eq!(finger.joint, "other_finger");
    /// ```
    pub fn new(joint: impl Into<String>, ratio: f64, offset: f64) -> Self {
        Self { joint: joint.into(), ratio, offset }
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

/// The same of several numbers.
#[cfg(feature = "serde")]
pub(super) mod numbers_or_infinity {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Bound(#[serde(with = "super::number_or_infinity")] f64);

    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub(crate) fn serialize<S: Serializer>(bounds: &[f64; 2], serializer: S) -> Result<S::Ok, S::Error> {
        bounds.map(Bound).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
        Ok(<[Bound; 2]>::deserialize(deserializer)?.map(|bound| bound.0))
    }
}
