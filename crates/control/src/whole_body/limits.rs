//! Limits of torques and of the motion of joints.

use robot_dynamics_core::Model;
use robot_dynamics_number::{InvalidInput, check_positive};

use crate::dof_limits::check_dof_limits;

/// Limits of each degree of freedom, nv entries each; infinite entries do not limit.
///
/// Torques satisfy |τ| ≤ `torque`. The others bound the acceleration, with the rate κ:
///
/// > |q̈| ≤ `acceleration`,  −κ (v_max + v) ≤ q̈ ≤ κ (v_max − v),
/// > κ² (q_min − q) − 2κ v ≤ q̈ ≤ κ² (q_max − q) − 2κ v
///
/// A joint at one of these bounds approaches its limit like a critically damped spring with the rate κ, and
/// does not pass it. If they contradict each other, acceleration limits win over those of the velocity, and
/// these over those of the position.
#[derive(Clone, Debug, PartialEq)]
pub struct WholeBodyLimits {
    /// The largest |τ| \[N·m, N\]; ignored for degrees of freedom without a motor.
    pub torque: Vec<f64>,
    /// The largest |q̈| \[rad/s², m/s²\].
    pub acceleration: Vec<f64>,
    /// The largest |v| \[rad/s, m/s\].
    pub velocity: Vec<f64>,
    /// The smallest and the largest q \[rad, m\] of joints with one coordinate; others are not limited.
    pub position: Vec<[f64; 2]>,
    /// κ \[1/s\]; at most half the frequency at which torques are computed.
    pub rate: f64,
}

impl WholeBodyLimits {
    /// The limits of the robot's description, no acceleration limits, and κ = 20 1/s.
    pub fn of(model: &Model) -> Self {
        let limits = model.coordinate_limits();
        let mut position = vec![[f64::NEG_INFINITY, f64::INFINITY]; model.nv()];
        for joint in model.joints().iter().filter(|joint| (joint.nq, joint.nv) == (1, 1)) {
            position[joint.v_index] = [joint.limits.lower, joint.limits.upper];
        }
        Self {
            torque: limits.iter().map(|limits| limits.effort).collect(),
            acceleration: vec![f64::INFINITY; model.nv()],
            velocity: limits.iter().map(|limits| limits.velocity).collect(),
            position,
            rate: 20.0,
        }
    }

    /// No limits.
    pub fn none(model: &Model) -> Self {
        let infinite = vec![f64::INFINITY; model.nv()];
        Self {
            torque: infinite.clone(),
            acceleration: infinite.clone(),
            velocity: infinite,
            position: vec![[f64::NEG_INFINITY, f64::INFINITY]; model.nv()],
            rate: 20.0,
        }
    }

    /// Checks lengths and signs.
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        check_positive("the rate of the limits", self.rate, "1/s")?;
        let magnitudes: [(&str, &[f64]); 3] = [
            ("the torque limits", &self.torque),
            ("the acceleration limits", &self.acceleration),
            ("the velocity limits", &self.velocity),
        ];
        check_dof_limits(model, &magnitudes, &self.position)
    }

    /// The bounds on the acceleration of a degree of freedom with the velocity v; `q` is its coordinate, if
    /// it has one of its own.
    pub(super) fn acceleration_bounds(&self, dof: usize, q: Option<f64>, v: f64) -> [f64; 2] {
        let k = self.rate;
        let mut bounds = [-self.acceleration[dof], self.acceleration[dof]];
        let mut restrict = |lower: f64, upper: f64| {
            bounds = [lower.clamp(bounds[0], bounds[1]), upper.clamp(bounds[0], bounds[1])];
        };
        let most = self.velocity[dof];
        restrict(-k * (most + v), k * (most - v));
        if let Some(q) = q {
            let [lower, upper] = self.position[dof];
            restrict(k * k * (lower - q) - 2.0 * k * v, k * k * (upper - q) - 2.0 * k * v);
        }
        bounds
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::pendulum;

    use super::*;

    #[test]
    fn bounds_are_ordered_and_lead_back() {
        let model = Model::new(pendulum(1.0, 1.0)).expect("a robot");
        let mut limits = WholeBodyLimits::none(&model);
        assert_eq!(limits.acceleration_bounds(0, Some(3.0), 4.0), [f64::NEG_INFINITY, f64::INFINITY]);
        limits.position[0] = [-1.0, 1.0];
        limits.velocity[0] = 2.0;
        limits.acceleration[0] = 30.0;
        for q in [-2.0, -0.5, 0.9, 3.0] {
            for v in [-5.0, 0.0, 1.9, 5.0] {
                let [lower, upper] = limits.acceleration_bounds(0, Some(q), v);
                assert!(lower <= upper, "{q} {v}");
                assert!(q < 1.0 || v < 0.0 || upper <= 0.0);
                assert!(v < 2.0 || upper < 0.0);
            }
        }
    }

    #[test]
    fn a_joint_at_its_bounds_stays_within_its_limits() {
        let model = Model::new(pendulum(1.0, 1.0)).expect("a robot");
        let mut limits = WholeBodyLimits::none(&model);
        limits.position[0] = [-1.0, 1.0];
        limits.velocity[0] = 2.0;
        let (mut q, mut v, step) = (0.0, 0.0, 1e-3);
        for _ in 0..3000 {
            let [_, upper] = limits.acceleration_bounds(0, Some(q), v);
            v += step * upper.min(50.0);
            q += step * v;
            assert!(v <= 2.0 + 1e-12 && q <= 1.0 + 1e-12);
        }
        assert!(q > 0.999);
    }
}
