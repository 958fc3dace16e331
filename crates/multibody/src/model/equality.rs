//! An equality between joints or links that a robot's file states beside its tree.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{FrameDescription, Pose, Softness};

/// An equality by name: a constraint of the motion beside the tree, see [`ConstraintSet`](crate::ConstraintSet).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct EqualityDescription {
    /// Its name, unique among equalities.
    pub name: String,
    /// What is equal.
    pub kind: Equality,
    /// Whether it holds from the start.
    pub active: bool,
    /// Time constant \[s\] and damping ratio of a soft constraint, as MJCF has them: [`Softness`].
    pub solref: [f64; 2],
    /// Its impedance: [`Softness`].
    pub solimp: [f64; 5],
}

impl EqualityDescription {
    /// An equality that holds, of MJCF's default softness.
    ///
    /// ```
    /// use multibody::{Equality, EqualityDescription};
    /// let fingers = Equality::Joints {
    ///     joint: ("right".into(), 0.0),
    ///     leader: Some(("left".into(), 0.0)),
    ///     polynomial: [0.0, 1.0, 0.0, 0.0, 0.0],
    /// };
    /// assert!(EqualityDescription::new("fingers", fingers).active);
    /// ```
    pub fn new(name: impl Into<String>, kind: Equality) -> Self {
        let Softness { solref, solimp } = Softness::default();
        Self { name: name.into(), kind, active: true, solref, solimp }
    }
}

impl EqualityDescription {
    /// The name of a side's frame.
    pub(crate) fn frame_name(&self, side: &str) -> String {
        format!("{}.{side}", self.name)
    }

    /// The frames that a robot has for a connection or a weld, joined by the equality: `NAME.a` and `NAME.b`.
    ///
    /// ```
    /// use multibody::{Equality, EqualityDescription};
    /// let pin = Equality::Connect { a: ("coupler".into(), [0.3, 0.0, 0.0]), b: ("rocker".into(), [0.0; 3]) };
    /// let frames = EqualityDescription::new("pin", pin).frames();
    /// assert_eq!((frames[0].name.as_str(), frames[1].link.as_str()), ("pin.a", "rocker"));
    /// ```
    pub fn frames(&self) -> Vec<FrameDescription> {
        let frame = |side: &str, link: &String, link_from_frame: Pose| {
            FrameDescription::new(self.frame_name(side), link, link_from_frame)
        };
        match &self.kind {
            Equality::Joints { .. } => Vec::new(),
            Equality::Connect { a, b } => vec![
                frame("a", &a.0, Pose::from_translation(a.1)),
                frame("b", &b.0, Pose::from_translation(b.1)),
            ],
            Equality::Weld { a, b, a_from_b } => {
                vec![frame("a", a, *a_from_b), frame("b", b, Pose::IDENTITY)]
            }
        }
    }
}

/// What an equality makes equal.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum Equality {
    /// y − y⁰ = Σ cₖ (x − x⁰)ᵏ between positions of two joints of one freedom; without a leader y − y⁰ = c₀.
    Joints {
        /// The joint of position y, and y⁰.
        joint: (String, f64),
        /// The joint of position x, and x⁰.
        leader: Option<(String, f64)>,
        /// c₀ to c₄.
        polynomial: [f64; 5],
    },
    /// A point of one link is a point of another, as by a ball joint.
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
    },
}
