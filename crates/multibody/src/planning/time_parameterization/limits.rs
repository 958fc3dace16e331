//! What a motion may not exceed.

use thiserror::Error;

use crate::Model;

/// Bounds of a motion, one number a coordinate; infinite where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLimits {
    /// The largest |τ| \[N·m or N\].
    pub torque: Vec<f64>,
    /// The largest |v| \[rad/s or m/s\].
    pub velocity: Vec<f64>,
}

impl MotionLimits {
    /// The limits of the robot's description.
    pub fn of(model: &Model) -> Self {
        let limits = model.coordinate_limits();
        Self {
            torque: limits.iter().map(|limit| limit.effort).collect(),
            velocity: limits.iter().map(|limit| limit.velocity).collect(),
        }
    }
}

/// Why a path has no timing.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterizationError {
    /// A limit that is not positive.
    #[error("the {quantity} limit of coordinate `{coordinate}` is {value}; it must be positive")]
    BadLimit {
        /// `torque` or `velocity`.
        quantity: &'static str,
        /// The coordinate.
        coordinate: String,
        /// The limit.
        value: f64,
    },
    /// The path (its first or last s included) gave a number that is not finite.
    #[error("the path or the torques along it are not finite at s = {s}")]
    NotFinite {
        /// Where.
        s: f64,
    },
    /// The robot cannot be at this point of the path at any speed: as a rule gravity alone asks too much.
    #[error(
        "no speed at s = {s} is within the limits: coordinate `{coordinate}` needs {needed} to stand still, \
         its limit is {limit}"
    )]
    Overloaded {
        /// Where.
        s: f64,
        /// The coordinate nearest to (or farthest beyond) its limit at rest.
        coordinate: String,
        /// |c| there \[N·m or N\].
        needed: f64,
        /// Its limit.
        limit: f64,
    },
    /// A speed asked for at the start or the end that is none.
    #[error("the speed ds/dt at the {place} of the path must be finite and not negative, got {speed}")]
    BadSpeed {
        /// `start` or `end`.
        place: &'static str,
        /// The speed asked for.
        speed: f64,
    },
    /// The motion rests at both ends of an interval, which it then never crosses.
    #[error(
        "the motion never leaves s = {s}: it rests there and at the next grid point; take more intervals"
    )]
    Standstill {
        /// Where.
        s: f64,
    },
    /// The speed asked for at the start or the end is out of reach.
    #[error("the speed ds/dt = {speed} at the {place} of the path is out of reach; the largest is {largest}")]
    EndSpeed {
        /// `start` or `end`.
        place: &'static str,
        /// The speed asked for.
        speed: f64,
        /// What the limits allow.
        largest: f64,
    },
    /// Nothing bounds the motion.
    #[error("nothing bounds the speed at s = {s}: give limits to the coordinates that move there")]
    Unbounded {
        /// Where.
        s: f64,
    },
}
