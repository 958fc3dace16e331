//! A joint as its file describes it.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{JointKind, JointSolverImpedance, PolynomialStiffnessDamping, Pose, PoseSpring};

/// A joint between two links. The child link's frame moves with the joint.
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
    /// Forces of the joint itself.
    pub passive: PassiveForces,
    /// The spring of a spherical or floating joint.
    #[cfg_attr(feature = "serde", serde(default))]
    pub spring: Option<PoseSpring>,
    /// Polynomial terms of its spring and damper. For a spherical or floating joint, the spring's terms use
    /// the length of the stretch. The damper's terms apply to each DoF, and to linear ones along the axes of
    /// the joint's frame in the parent.
    #[cfg_attr(feature = "serde", serde(default))]
    pub higher_terms: PolynomialStiffnessDamping,
    /// The largest elastic stretch of its spring. Beyond it the spring yields: its rest position follows. 0
    /// for a spring that never yields. Simulations alone take a spring that yields into account: g lacks it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub spring_yield: f64,
    /// Present if it is a mimic joint.
    pub mimic: Option<Mimic>,
    /// Bounds on the total force of its actuators \[N·m or N\]; infinite without bounds. See
    /// [`ActuatorDescription`](crate::ActuatorDescription).
    #[cfg_attr(feature = "serde", serde(with = "numbers_or_infinity", default = "unbounded"))]
    pub actuator_force_range: [f64; 2],
    /// Whether its actuators supply the links' gravity compensation, within that range.
    #[cfg_attr(feature = "serde", serde(default))]
    pub actuator_compensates_gravity: bool,
    /// The softness of its limits and friction under MuJoCo's law; the rigid law ignores it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub softness: JointSolverImpedance,
}

/// Without bounds.
const fn unbounded() -> [f64; 2] {
    [f64::NEG_INFINITY, f64::INFINITY]
}

impl JointDescription {
    /// The passive forces that depend on the state alone: without a spring that yields.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, pendulum};
    /// let mut joint = pendulum(2.0, 0.5).joints.remove(0);
    /// joint.passive = PassiveForces::default().with_spring(20.0, 0.0);
    /// assert_eq!(joint.elastic_forces().stiffness, 20.0);
    /// joint.spring_yield = 0.1;
    /// assert_eq!(joint.elastic_forces().stiffness, 0.0);
    /// ```
    pub fn elastic_forces(&self) -> PassiveForces {
        let stiffness = if self.spring_yield > 0.0 { 0.0 } else { self.passive.stiffness };
        self.passive.with_spring(stiffness, self.passive.rest)
    }

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
            higher_terms: PolynomialStiffnessDamping::default(),
            spring_yield: 0.0,
            mimic: None,
            actuator_force_range: unbounded(),
            actuator_compensates_gravity: false,
            softness: JointSolverImpedance::default(),
        }
    }

    /// With bounds on its motion and effort.
    ///
    /// ```
    /// use robot_dynamics::description::{JointDescription, JointKind, Limits, PassiveForces, Pose};
    /// let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    /// let joint = JointDescription::new("elbow", hinge, "upper_arm", "forearm", Pose::IDENTITY)
    ///     .with_limits(Limits::new(0.0, 2.5))
    ///     .with_passive(PassiveForces::default().with_damping(0.1));
    /// assert!(joint.limits.upper == 2.5 && joint.passive.damping == 0.1 && joint.mimic.is_none());
    /// ```
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// With passive forces.
    pub fn with_passive(self, passive: PassiveForces) -> Self {
        Self { passive, ..self }
    }

    /// As a mimic joint.
    pub fn with_mimic(self, mimic: Mimic) -> Self {
        Self { mimic: Some(mimic), ..self }
    }
}

/// Bounds on a joint's position, speed and effort; infinite if the file gives none.
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
    /// Largest rotation angle of a ball joint from the identity \[rad\].
    #[cfg_attr(feature = "serde", serde(with = "number_or_infinity", default = "unlimited"))]
    pub turn: f64,
}

/// The value of an absent bound.
#[cfg(feature = "serde")]
const fn unlimited() -> f64 {
    f64::INFINITY
}

impl Limits {
    /// Bounds on the position \[rad or m\] only.
    ///
    /// ```
    /// use robot_dynamics::description::Limits;
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

    /// With a largest rotation angle of a ball joint \[rad\].
    pub const fn with_turn(self, turn: f64) -> Self {
        Self { turn, ..self }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::new(f64::NEG_INFINITY, f64::INFINITY)
    }
}

/// Passive forces of a joint: τ = armature·v̇ + damping·v + friction·sign v + stiffness·(q − rest). The same
/// values apply to each degree of freedom of the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct PassiveForces {
    /// Rotor inertia at the joint, I_rotor·ratio² for a gear \[kg·m² or kg\].
    pub armature: f64,
    /// Viscous damping \[N·m·s/rad or N·s/m\].
    pub damping: f64,
    /// Coulomb friction \[N·m or N\].
    pub friction: f64,
    /// Spring stiffness \[N·m/rad or N/m\], for joints without quaternions; the others have a
    /// [`PoseSpring`].
    pub stiffness: f64,
    /// Position at which the spring is relaxed \[rad or m\].
    pub rest: f64,
}

impl PassiveForces {
    /// The stretch (positive) or compression (negative) at a position of a spring with a dead band from
    /// `rest` to `rest` + `dead_band`.
    ///
    /// ```
    /// let spring = robot_dynamics::description::PassiveForces::default().with_spring(10.0, 0.1);
    /// assert_eq!([0.0, 0.2, 0.5].map(|position| spring.stretch(position, 0.2)), [-0.1, 0.0, 0.2]);
    /// ```
    pub fn stretch(&self, position: f64, dead_band: f64) -> f64 {
        let beyond = position - self.rest;
        if beyond < 0.0 { beyond } else { (beyond - dead_band).max(0.0) }
    }

    /// With a rotor inertia at the joint \[kg·m² or kg\].
    ///
    /// ```
    /// use robot_dynamics::description::PassiveForces;
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

    /// With a spring: its stiffness \[N·m/rad or N/m\] and its relaxed position \[rad or m\].
    pub const fn with_spring(self, stiffness: f64, rest: f64) -> Self {
        Self { stiffness, rest, ..self }
    }
}

/// A mimic joint: q = ratio · q_leader + offset.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Mimic {
    /// The name of the leader.
    pub joint: String,
    /// The ratio, in the mimic joint's units per unit of the leader's.
    pub ratio: f64,
    /// The offset \[rad or m\].
    pub offset: f64,
}

impl Mimic {
    /// Follows the joint of this name.
    ///
    /// ```
    /// let finger = robot_dynamics::description::Mimic::new("other_finger", 1.0, 0.0);
    /// assert_eq!(finger.joint, "other_finger");
    /// ```
    pub fn new(joint: impl Into<String>, ratio: f64, offset: f64) -> Self {
        Self { joint: joint.into(), ratio, offset }
    }
}

/// A number, or the strings `inf` and `-inf`, which JSON cannot represent as numbers.
#[cfg(feature = "serde")]
pub(super) mod number_or_infinity {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    enum Value {
        Number(f64),
        Word(String),
    }

    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub(crate) fn serialize<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        if x.is_finite() {
            Value::Number(*x).serialize(serializer)
        } else {
            Value::Word(x.to_string()).serialize(serializer)
        }
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
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

/// The same for several numbers.
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
