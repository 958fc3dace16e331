//! Limits of an online motion.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;
use robot_dynamics_number::InvalidInput;

use super::OnlineMotionError;
use crate::inverse_kinematics::bounds::Bounds;

/// Limits of an online motion, one number per coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct OnlineLimits {
    /// The largest |v| \[rad/s or m/s\]; it may be infinite.
    pub velocity: Vec<f64>,
    /// The largest |a| \[rad/s² or m/s²\].
    pub acceleration: Vec<f64>,
    /// The largest |ȧ| \[rad/s³ or m/s³\].
    pub jerk: Vec<f64>,
    /// The smallest q \[rad or m\]; it may be infinite.
    pub lower: Vec<f64>,
    /// The largest q \[rad or m\]; it may be infinite.
    pub upper: Vec<f64>,
}

impl OnlineLimits {
    /// Limits of velocity, acceleration and jerk, without limits of position.
    pub fn new(velocity: Vec<f64>, acceleration: Vec<f64>, jerk: Vec<f64>) -> Self {
        let none = vec![f64::INFINITY; velocity.len()];
        let lower = vec![f64::NEG_INFINITY; velocity.len()];
        Self { velocity, acceleration, jerk, lower, upper: none }
    }

    /// The limits of velocity and position of the robot's description, with these of acceleration and jerk.
    ///
    /// ```
    /// use robot_dynamics::control::online_motion::OnlineLimits;
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-1.0, 2.0).with_velocity(3.0);
    /// let limits = OnlineLimits::of(&Model::new(robot)?, vec![10.0], vec![100.0]);
    /// assert!(limits.velocity == [3.0] && limits.lower == [-1.0] && limits.jerk == [100.0]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn of(model: &Model, acceleration: Vec<f64>, jerk: Vec<f64>) -> Self {
        let velocity = model.coordinate_limits().iter().map(|limit| limit.velocity).collect();
        let mut all = Self::new(velocity, acceleration, jerk);
        for bound in Bounds::new(model).0 {
            (all.lower[bound.v], all.upper[bound.v]) = (bound.lower, bound.upper);
        }
        all
    }

    pub(super) fn has_positions(&self) -> bool {
        self.lower.iter().chain(&self.upper).any(|x| x.is_finite())
    }

    #[track_caller]
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        let names = model.coordinate_names();
        let limit = |quantity: &str, k: usize| format!("the {quantity} limit of coordinate `{}`", names[k]);
        let magnitudes =
            [("velocity", &self.velocity), ("acceleration", &self.acceleration), ("jerk", &self.jerk)];
        for (quantity, values) in magnitudes {
            check_length("the limits", values.len(), model.nv());
            let valid = |x: f64| x > 0.0 && (x.is_finite() || quantity == "velocity");
            if let Some(k) = values.iter().position(|&x| !valid(x)) {
                let requirement = format!("is {}; it must be positive and finite", values[k]);
                return Err(InvalidInput::unmet(limit(quantity, k), requirement));
            }
        }
        check_length("the limits", self.lower.len(), model.nv());
        check_length("the limits", self.upper.len(), model.nv());
        let valid = |k: usize| self.lower[k] < self.upper[k];
        match (0..model.nv()).find(|&k| !valid(k)) {
            None => Ok(()),
            Some(k) => {
                let requirement =
                    format!("is {}; it must be above the lower limit {}", self.upper[k], self.lower[k]);
                Err(InvalidInput::unmet(limit("position", k), requirement))
            }
        }
    }

    /// Checks that the target is within the limits, and that a motion within them can reach it.
    ///
    /// The acceleration a > 0 of a target grew from zero at the velocity v − a²/2j, which must be above
    /// −v_max.
    pub(super) fn check_target(
        &self,
        names: &[String],
        [q, v, a]: [&[f64]; 3],
    ) -> Result<(), OnlineMotionError> {
        for k in 0..names.len() {
            let turn = 0.5 * a[k] * a[k] / self.jerk[k];
            let checks = [
                ("position", q[k], self.lower[k], self.upper[k]),
                ("velocity", v[k], -self.velocity[k], self.velocity[k]),
                ("acceleration", a[k], -self.acceleration[k], self.acceleration[k]),
                ("velocity", v[k] - turn * a[k].signum(), -self.velocity[k], self.velocity[k]),
            ];
            for (quantity, value, lower, upper) in checks {
                if !(lower..=upper).contains(&value) {
                    let limit = if value > upper { upper } else { lower };
                    let coordinate = names[k].clone();
                    return Err(OnlineMotionError::TargetBeyondLimit { quantity, coordinate, value, limit });
                }
            }
        }
        Ok(())
    }
}
