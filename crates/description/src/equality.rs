//! Equalities between joints, tendons or links that a robot's file states in addition to its tree.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{FrameDescription, Pose, SolverImpedance};

/// A named equality, a constraint of the motion in addition to the tree; see `ConstraintSet`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct EqualityDescription {
    /// Its name, unique among equalities.
    pub name: String,
    /// The constraint.
    pub kind: Equality,
    /// Whether it holds from the start.
    pub active: bool,
    /// Time constant \[s\] and damping ratio of a soft constraint, as in MJCF: [`SolverImpedance`].
    pub solref: [f64; 2],
    /// Its impedance: [`SolverImpedance`].
    pub solimp: [f64; 5],
}

impl EqualityDescription {
    /// An active equality with MJCF's default softness.
    ///
    /// ```
    /// use robot_dynamics::description::{Equality, EqualityDescription};
    /// let fingers = Equality::Joints {
    ///     joint: ("right".into(), 0.0),
    ///     leader: Some(("left".into(), 0.0)),
    ///     polynomial: [0.0, 1.0, 0.0, 0.0, 0.0],
    /// };
    /// assert!(EqualityDescription::new("fingers", fingers).active);
    /// ```
    pub fn new(name: impl Into<String>, kind: Equality) -> Self {
        let SolverImpedance { solref, solimp } = SolverImpedance::default();
        Self { name: name.into(), kind, active: true, solref, solimp }
    }
}

impl EqualityDescription {
    /// The name of a side's frame.
    pub fn frame_name(&self, side: &str) -> String {
        format!("{}.{side}", self.name)
    }

    /// The two frames of a connection or a weld, which the equality joins: `NAME.a` and `NAME.b`.
    ///
    /// ```
    /// use robot_dynamics::description::{Equality, EqualityDescription};
    /// let pin = Equality::Connect { a: ("coupler".into(), [0.3, 0.0, 0.0]), b: ("rocker".into(), [0.0; 3]) };
    /// let frames = EqualityDescription::new("pin", pin).frames();
    /// assert_eq!((frames[0].name.as_str(), frames[1].link.as_str()), ("pin.a", "rocker"));
    /// ```
    pub fn frames(&self) -> Vec<FrameDescription> {
        let frame = |side: &str, link: &String, link_from_frame: Pose| {
            FrameDescription::new(self.frame_name(side), link, link_from_frame)
        };
        match &self.kind {
            Equality::Joints { .. } | Equality::Tendons { .. } => Vec::new(),
            Equality::Connect { a, b } => vec![
                frame("a", &a.0, Pose::from_translation(a.1)),
                frame("b", &b.0, Pose::from_translation(b.1)),
            ],
            Equality::Weld { a, b, a_from_b, anchor, .. } => {
                let b_from_anchor = Pose::from_translation(*anchor);
                vec![frame("a", a, a_from_b.compose(&b_from_anchor)), frame("b", b, b_from_anchor)]
            }
        }
    }
}

/// The kind of an equality.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Equality {
    /// y − y⁰ = Σ cₖ (x − x⁰)ᵏ between positions of two joints of one DoF; without a leader y − y⁰ = c₀.
    Joints {
        /// The joint of position y, and y⁰.
        joint: (String, f64),
        /// The joint of position x, and x⁰.
        leader: Option<(String, f64)>,
        /// c₀ to c₄.
        polynomial: [f64; 5],
    },
    /// y − y⁰ = Σ cₖ (x − x⁰)ᵏ between lengths of two tendons; without a leader y − y⁰ = c₀.
    Tendons {
        /// The tendon of length y, over joints or along a path, and y⁰.
        tendon: (String, f64),
        /// The tendon of length x, and x⁰.
        leader: Option<(String, f64)>,
        /// c₀ to c₄.
        polynomial: [f64; 5],
    },
    /// A point of one link coincides with a point of another, as in a ball joint.
    Connect {
        /// A link, and the point in its frame \[m\].
        a: (String, [f64; 3]),
        /// The other link, and the point in its frame \[m\].
        b: (String, [f64; 3]),
    },
    /// Two links move as one.
    Weld {
        /// A link.
        a: String,
        /// The other link.
        b: String,
        /// Link b in link a.
        a_from_b: Pose,
        /// The point in link b \[m\] at which a soft weld acts.
        #[cfg_attr(feature = "serde", serde(default))]
        anchor: [f64; 3],
        /// Factor of the angular violation in MuJoCo's soft law, in m; 1 by default.
        #[cfg_attr(feature = "serde", serde(default = "one_meter"))]
        torque_scale: f64,
    },
}

#[cfg(feature = "serde")]
fn one_meter() -> f64 {
    1.0
}

impl Equality {
    /// A weld that acts at the origin of link b, with MJCF's default softness.
    ///
    /// ```
    /// use robot_dynamics::description::{Equality, Pose};
    /// let weld = Equality::weld("hand", "tool", Pose::from_translation([0.0, 0.0, 0.1]));
    /// assert!(matches!(weld, Equality::Weld { torque_scale: 1.0, .. }));
    /// ```
    pub fn weld(a: impl Into<String>, b: impl Into<String>, a_from_b: Pose) -> Self {
        Self::Weld { a: a.into(), b: b.into(), a_from_b, anchor: [0.0; 3], torque_scale: 1.0 }
    }
}
