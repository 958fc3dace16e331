//! Limits of a motion.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;
use robot_dynamics_number::InvalidInput;

use crate::inverse_kinematics::bounds::Bounds;

/// A quantity with a limit for each coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LimitedQuantity {
    /// τ \[N·m or N\].
    Torque,
    /// v \[rad/s or m/s\].
    Velocity,
    /// a \[rad/s² or m/s²\].
    Acceleration,
    /// τ v \[W\].
    Power,
}

impl core::fmt::Display for LimitedQuantity {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Torque => "torque",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Power => "power",
        })
    }
}

/// Limits of a motion, one number per coordinate of v; infinite without a limit.
///
/// The torques are those that the motors supply. They include damping and friction of the joints, as in
/// simulations, unless [`dissipation`](Self::dissipation) is false.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLimits {
    /// The smallest τ \[N·m or N\].
    pub torque_lower: Vec<f64>,
    /// The largest τ \[N·m or N\].
    pub torque_upper: Vec<f64>,
    /// The largest |v| \[rad/s or m/s\].
    pub velocity: Vec<f64>,
    /// The largest |a| \[rad/s² or m/s²\].
    pub acceleration: Vec<f64>,
    /// The largest |τ v| of each coordinate \[W\].
    pub power: Vec<f64>,
    /// The smallest q of each coordinate \[rad or m\]; ignored for joints with a quaternion.
    pub lower: Vec<f64>,
    /// The largest q.
    pub upper: Vec<f64>,
    /// Whether τ includes [`dissipation`](robot_dynamics_core::dissipation): damping · v + friction · sign v.
    pub dissipation: bool,
}

impl MotionLimits {
    /// Limits |τ| ≤ `torque` and |v| ≤ `velocity`, with damping and friction of the joints in τ.
    ///
    /// ```
    /// let limits = robot_dynamics::control::MotionLimits::new(vec![40.0, 20.0], vec![2.0; 2]);
    /// assert!(limits.torque_lower == [-40.0, -20.0] && limits.upper == [f64::INFINITY; 2]);
    /// ```
    pub fn new(torque: Vec<f64>, velocity: Vec<f64>) -> Self {
        let none = vec![f64::INFINITY; torque.len()];
        Self {
            torque_lower: torque.iter().map(|limit| -limit).collect(),
            torque_upper: torque,
            velocity,
            acceleration: none.clone(),
            power: none.clone(),
            lower: vec![f64::NEG_INFINITY; none.len()],
            upper: none,
            dissipation: true,
        }
    }

    /// The limits of effort, velocity and position of the robot's description, including the positions of its
    /// mimic joints.
    ///
    /// ```
    /// use robot_dynamics::control::MotionLimits;
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-1.0, 2.0).with_effort(30.0);
    /// let limits = MotionLimits::of(&Model::new(robot)?);
    /// assert!(limits.torque_lower == [-30.0] && limits.lower == [-1.0] && limits.upper == [2.0]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
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

    /// Sets the smallest and the largest τ of each coordinate \[N·m or N\].
    ///
    /// ```
    /// use robot_dynamics::control::MotionLimits;
    /// // A cable pulls and never pushes.
    /// let limits = MotionLimits::new(vec![40.0], vec![2.0]).with_torque_range(vec![0.0], vec![40.0]);
    /// assert_eq!((limits.torque_lower[0], limits.torque_upper[0]), (0.0, 40.0));
    /// ```
    #[must_use]
    pub fn with_torque_range(mut self, lower: Vec<f64>, upper: Vec<f64>) -> Self {
        (self.torque_lower, self.torque_upper) = (lower, upper);
        self
    }

    /// Sets the largest |a| of each coordinate \[rad/s² or m/s²\].
    ///
    /// ```
    /// let limits = robot_dynamics::control::MotionLimits::new(vec![40.0], vec![2.0]).with_acceleration(vec![9.0]);
    /// assert_eq!(limits.acceleration, [9.0]);
    /// ```
    #[must_use]
    pub fn with_acceleration(mut self, acceleration: Vec<f64>) -> Self {
        self.acceleration = acceleration;
        self
    }

    /// Sets the largest |τ v| of each coordinate \[W\].
    ///
    /// ```
    /// let limits = robot_dynamics::control::MotionLimits::new(vec![40.0], vec![2.0]).with_power(vec![50.0]);
    /// assert_eq!(limits.power, [50.0]);
    /// ```
    #[must_use]
    pub fn with_power(mut self, power: Vec<f64>) -> Self {
        self.power = power;
        self
    }

    /// Sets whether τ includes damping and friction of the joints.
    ///
    /// ```
    /// let limits = robot_dynamics::control::MotionLimits::new(vec![40.0], vec![2.0]).with_dissipation(false);
    /// assert!(!limits.dissipation);
    /// ```
    #[must_use]
    pub fn with_dissipation(mut self, dissipation: bool) -> Self {
        self.dissipation = dissipation;
        self
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

    /// Checks lengths and values: no NaN, positive magnitudes, and ranges of torque with a number in them.
    #[track_caller]
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        let bad = |quantity: &str, k: usize, needed: String| {
            let limit = format!("the {quantity} limit of coordinate `{}`", model.coordinate_names()[k]);
            Err(InvalidInput::unmet(limit, needed))
        };
        let ranges = [
            ("lower torque", &self.torque_lower),
            ("torque", &self.torque_upper),
            ("lower", &self.lower),
            ("upper", &self.upper),
        ];
        let magnitudes =
            [("velocity", &self.velocity), ("acceleration", &self.acceleration), ("power", &self.power)];
        for (quantity, values) in ranges.into_iter().chain(magnitudes) {
            check_length("the limits", values.len(), model.nv());
            if let Some(k) = values.iter().position(|x| x.is_nan()) {
                return bad(quantity, k, "is NaN; it must be a number".into());
            }
        }
        for (quantity, values) in magnitudes {
            if let Some(k) = values.iter().position(|&x| x <= 0.0) {
                return bad(quantity, k, format!("is {}; it must be positive", values[k]));
            }
        }
        let range = |k: &usize| (self.torque_lower[*k], self.torque_upper[*k]);
        match (0..model.nv()).find(|k| range(k).0 >= range(k).1) {
            None => Ok(()),
            Some(k) => {
                let (lower, upper) = range(&k);
                if lower == -upper {
                    return bad("torque", k, format!("is {upper}; it must be positive"));
                }
                bad("torque", k, format!("is {upper}; it must be above the lower limit {lower}"))
            }
        }
    }
}
