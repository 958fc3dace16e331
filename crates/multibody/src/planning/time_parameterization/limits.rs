//! What a motion may not exceed.

use thiserror::Error;

use crate::Model;
use crate::control::inverse_kinematics::bounds::Bounds;
use crate::model::length::check_length;

/// Bounds of a motion, one number a coordinate; infinite where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLimits {
    /// The largest |τ| \[N·m or N\].
    pub torque: Vec<f64>,
    /// The largest |v| \[rad/s or m/s\].
    pub velocity: Vec<f64>,
    /// The least q of each coordinate \[rad or m\]; not read for joints with a quaternion.
    pub lower: Vec<f64>,
    /// The largest q.
    pub upper: Vec<f64>,
}

impl MotionLimits {
    /// Bounds of torque and velocity, and none of position.
    ///
    /// ```
    /// let limits = multibody::MotionLimits::new(vec![40.0, 20.0], vec![2.0; 2]);
    /// assert!(limits.upper == [f64::INFINITY; 2]);
    /// ```
    pub fn new(torque: Vec<f64>, velocity: Vec<f64>) -> Self {
        let count = torque.len();
        Self { torque, velocity, lower: vec![f64::NEG_INFINITY; count], upper: vec![f64::INFINITY; count] }
    }

    /// The limits of the robot's description, of its mimic joints as well.
    pub fn of(model: &Model) -> Self {
        let limits = model.coordinate_limits();
        let mut all = Self::new(
            limits.iter().map(|limit| limit.effort).collect(),
            limits.iter().map(|limit| limit.velocity).collect(),
        );
        for bound in Bounds::new(model).0 {
            (all.lower[bound.v], all.upper[bound.v]) = (bound.lower, bound.upper);
        }
        all
    }

    /// The first coordinate of q that is beyond its limits, by its place in v, with its value.
    ///
    /// ```
    /// use multibody::{Model, MotionLimits, pendulum};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut limits = MotionLimits::of(&model);
    /// limits.upper[0] = 1.0;
    /// assert_eq!(limits.position_beyond(&model, &[0.9]), None);
    /// assert_eq!(limits.position_beyond(&model, &[1.1]), Some((0, 1.1)));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// If a length is wrong.
    #[track_caller]
    pub fn position_beyond(&self, model: &Model, q: &[f64]) -> Option<(usize, f64)> {
        check_length("q", q.len(), model.nq());
        // Rounding takes a spline through a waypoint at the limit this far beyond it.
        let slack = |limit: f64| 1e-9 * limit.abs().max(1.0);
        let places = model.joints().iter().filter(|joint| joint.nq == joint.nv);
        let places =
            places.flat_map(|joint| (0..joint.nv).map(|k| (joint.v_index + k, q[joint.q_index + k])));
        places.into_iter().find(|&(k, x)| {
            let (lower, upper) = (self.lower[k], self.upper[k]);
            x < lower - slack(lower) || x > upper + slack(upper)
        })
    }
}

/// Why a path has no timing.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterizationError {
    /// A limit of torque or velocity that is not positive, or one of position that is no number.
    #[error(
        "the {quantity} limit of coordinate `{coordinate}` is {value}; it must be {}",
        if value.is_nan() { "a number" } else { "positive" }
    )]
    BadLimit {
        /// `torque`, `velocity`, `lower` or `upper`.
        quantity: &'static str,
        /// The coordinate.
        coordinate: String,
        /// The limit.
        value: f64,
    },
    /// The path leaves the limits of position.
    #[error(
        "the path leaves the limits of position at s = {s}: coordinate `{coordinate}` is at {value}, its limits are {lower} and {upper}; \
         move the waypoints inside"
    )]
    BeyondPosition {
        /// Where.
        s: f64,
        /// The coordinate.
        coordinate: String,
        /// Its q there \[rad or m\].
        value: f64,
        /// The least it may be.
        lower: f64,
        /// The largest it may be.
        upper: f64,
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
