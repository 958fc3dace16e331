//! The error of a time parameterization.

use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

/// The error of [`time_optimal`](crate::time_optimal): an invalid argument, or a path that the limits do not allow.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[doc(alias = "SplineError")]
pub enum ParameterizationError {
    /// There are fewer than two waypoints, two equal ones follow each other, or they have different
    /// lengths. A number of a waypoint, the path or a requested speed is not finite, or a limit is not
    /// positive, or a range of torques is empty.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// The path exceeds the position limits.
    #[error(
        "the path leaves the limits of position at s = {s}: coordinate `{coordinate}` is at {value}, its limits are {lower} and {upper}; \
         move the waypoints inside"
    )]
    BeyondPosition {
        /// The path parameter.
        s: f64,
        /// The name of the coordinate.
        coordinate: String,
        /// Its q there \[rad or m\].
        value: f64,
        /// The smallest allowed value.
        lower: f64,
        /// The largest allowed value.
        upper: f64,
    },
    /// No speed is admissible at this point of the path, usually because gravity alone exceeds the torque
    /// limits.
    #[error(
        "no speed at s = {s} is within the limits: coordinate `{coordinate}` needs {needed} to stand still, \
         its limit is {limit}"
    )]
    Overloaded {
        /// The path parameter.
        s: f64,
        /// The coordinate nearest to, or furthest beyond, its limit of torque at the beginning of the motion.
        coordinate: String,
        /// Its τ there: gravity, springs and dry friction \[N·m or N\].
        needed: f64,
        /// Its limit of torque on that side.
        limit: f64,
    },
    /// The speed is zero at both ends of an interval, so the motion cannot cross it.
    #[error(
        "the motion never leaves s = {s}: it rests there and at the next grid point; take more intervals"
    )]
    Standstill {
        /// The path parameter.
        s: f64,
    },
    /// The requested speed at the start or the end is not reachable.
    #[error("the speed ds/dt = {speed} at the {place} of the path is out of reach; the largest is {largest}")]
    EndSpeed {
        /// `start` or `end`.
        place: &'static str,
        /// The requested speed.
        speed: f64,
        /// The largest speed within the limits.
        largest: f64,
    },
    /// No limit bounds the speed.
    #[error("nothing bounds the speed at s = {s}: give limits to the coordinates that move there")]
    Unbounded {
        /// The path parameter.
        s: f64,
    },
}

impl Classified for ParameterizationError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            _ => ErrorKind::Infeasible,
        }
    }
}
