//! What can be wrong with a robot or an input.

use thiserror::Error;

/// Why a [`RobotDescription`](crate::RobotDescription) is not a robot.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// There is no link.
    #[error("the robot has no links; add at least one")]
    NoLinks,
    /// Two things of one sort share a name.
    #[error("two {sort}s are named `{name}`; rename one")]
    DuplicateName {
        /// `link`, `joint` or `frame`.
        sort: &'static str,
        /// The shared name.
        name: String,
    },
    /// A joint, frame or follower names something that is not there.
    #[error("{user} refers to {sort} `{name}`, which does not exist")]
    UnknownName {
        /// Who refers to it, for example ``joint `elbow` ``.
        user: String,
        /// `link` or `joint`.
        sort: &'static str,
        /// The missing name.
        name: String,
    },
    /// A link is the child of two joints.
    #[error("link `{link}` is the child of both joint `{first}` and joint `{second}`; a tree allows one")]
    TwoParents {
        /// The link.
        link: String,
        /// One joint.
        first: String,
        /// The other joint.
        second: String,
    },
    /// Not exactly one root: several links are no joint's child.
    #[error("links {} are all roots; connect them with joints", .links.join(", "))]
    SeveralRoots {
        /// The roots.
        links: Vec<String>,
    },
    /// Links that no path from the root reaches: their joints form a loop.
    #[error("links {} form a loop of joints that the root does not reach", .links.join(", "))]
    Cycle {
        /// The links on or behind the loop.
        links: Vec<String>,
    },
    /// An axis has no direction.
    #[error("joint `{joint}`: the axis {axis:?} has no direction; give a finite, non-zero vector")]
    ZeroAxis {
        /// The joint.
        joint: String,
        /// The axis given.
        axis: [f64; 3],
    },
    /// A number is NaN or infinite, or out of its range.
    #[error("{owner}: {quantity} = {value} is not {expected}")]
    BadNumber {
        /// Whose number, for example ``joint `elbow` ``.
        owner: String,
        /// Which quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What it should be, for example `finite`.
        expected: &'static str,
    },
    /// A placement's matrix is not a rotation.
    #[error("{owner}: the rotation matrix is not orthonormal with determinant 1 (off by {defect:e})")]
    NotARotation {
        /// Whose placement.
        owner: String,
        /// max |RᵀR − 1| and |det R − 1|.
        defect: f64,
    },
    /// A follower cannot follow: itself, a joint of several freedoms, or in a circle.
    #[error("joint `{joint}` cannot follow joint `{leader}`: {reason}")]
    BadMimic {
        /// The follower.
        joint: String,
        /// The joint it names.
        leader: String,
        /// Why not.
        reason: &'static str,
    },
}
