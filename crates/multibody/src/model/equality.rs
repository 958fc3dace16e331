//! An equality between joints or links that a robot's file states beside its tree.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Pose;

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
    /// Time constant \[s\] and damping ratio of a soft constraint, as MJCF has them; kept as data.
    pub solref: [f64; 2],
    /// Its impedance; kept as data.
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
        let crate::Surface { solref, solimp, .. } = crate::Surface::default();
        Self { name: name.into(), kind, active: true, solref, solimp }
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
