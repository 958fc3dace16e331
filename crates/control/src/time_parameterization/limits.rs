//! Limits of a motion, and errors of its parameterization.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

use crate::inverse_kinematics::bounds::Bounds;

/// Limits of a motion, one number per coordinate; infinite without a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLimits {
    /// The largest |τ| \[N·m or N\].
    pub torque: Vec<f64>,
    /// The largest |v| \[rad/s or m/s\].
    pub velocity: Vec<f64>,
    /// The smallest q of each coordinate \[rad or m\]; ignored for joints with a quaternion.
    pub lower: Vec<f64>,
    /// The largest q.
    pub upper: Vec<f64>,
}

impl MotionLimits {
    /// Limits of torque and velocity, without position limits.
    ///
    /// ```
    /// let limits = robot_dynamics::control::MotionLimits::new(vec![40.0, 20.0], vec![2.0; 2]);
    /// assert!(limits.upper == [f64::INFINITY; 2]);
    /// ```
    pub fn new(torque: Vec<f64>, velocity: Vec<f64>) -> Self {
        let count = torque.len();
        Self { torque, velocity, lower: vec![f64::NEG_INFINITY; count], upper: vec![f64::INFINITY; count] }
    }

    /// The limits of the robot's description, including those of its mimic joints.
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

    /// The first coordinate beyond its position limits, as its index in v, and its value.
    ///
    /// ```
    /// use robot_dynamics::control::MotionLimits;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut limits = MotionLimits::of(&model);
    /// limits.upper[0] = 1.0;
    /// assert_eq!(limits.position_beyond(&model, &[0.9]), None);
    /// assert_eq!(limits.position_beyond(&model, &[1.1]), Some((0, 1.1)));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// Panics if a length is wrong.
    #[track_caller]
    pub fn position_beyond(&self, model: &Model, q: &[f64]) -> Option<(usize, f64)> {
        check_length("q", q.len(), model.nq());
        // Rounding can move a spline through a waypoint at the limit this far beyond it.
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

/// The error of [`time_optimal`](crate::time_optimal): an invalid argument, or a path that the limits do not allow.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[doc(alias = "SplineError")]
pub enum ParameterizationError {
    /// There are fewer than two waypoints, two equal ones follow each other, or they have different
    /// lengths. A number of a waypoint, the path or a requested speed is not finite, or a limit is not
    /// positive.
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
        /// The coordinate nearest to, or furthest beyond, its limit at rest.
        coordinate: String,
        /// |c| there \[N·m or N\].
        needed: f64,
        /// The limit of the coordinate.
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
