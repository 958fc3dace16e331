//! Limits of positions, velocities and accelerations, as bounds on a step.

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;

use super::solution::KinematicLimit;
use crate::dof_limits::check_dof_limits;
use crate::inverse_kinematics::bounds::Bounds;

/// Limits of each degree of freedom, nv entries each; infinite entries do not limit.
///
/// A step Δt with the velocity v satisfies |v| ≤ `velocity`, |v − v₀| ≤ `acceleration` Δt, and γ (q_min − q)
/// ≤ v Δt ≤ γ (q_max − q). With a finite acceleration limit a, a joint can stop before its position limit:
///
/// > v Δt + v²/2a ≤ q_max − q, and the same at the lower limit.
///
/// If they contradict each other, acceleration limits win over those of the velocity, and these over those of
/// the position.
#[derive(Clone, Debug, PartialEq)]
pub struct KinematicLimits {
    /// The smallest and the largest q \[rad, m\]; joints with a quaternion have no limits.
    pub position: Vec<[f64; 2]>,
    /// The largest |v| \[rad/s, m/s\].
    pub velocity: Vec<f64>,
    /// The largest |v̇| \[rad/s², m/s²\].
    pub acceleration: Vec<f64>,
    /// γ: the share of the distance to a position limit that one step may use, above 0 and at most 1.
    pub position_gain: f64,
}

impl KinematicLimits {
    /// The limits of the robot's description and of its mimic joints, without acceleration limits, and γ = 1.
    pub fn of(model: &Model) -> Self {
        let mut limits = Self::none(model);
        for bound in &Bounds::new(model).0 {
            limits.position[bound.v] = [bound.lower, bound.upper];
        }
        limits.velocity = model.coordinate_limits().iter().map(|limits| limits.velocity).collect();
        limits
    }

    /// No limits.
    pub fn none(model: &Model) -> Self {
        let infinite = vec![f64::INFINITY; model.nv()];
        Self {
            position: vec![[f64::NEG_INFINITY, f64::INFINITY]; model.nv()],
            velocity: infinite.clone(),
            acceleration: infinite,
            position_gain: 1.0,
        }
    }

    /// Checks lengths, signs and order.
    pub(super) fn check(&self, model: &Model) -> Result<(), InvalidInput> {
        let is_share = self.position_gain > 0.0 && self.position_gain <= 1.0;
        if !is_share {
            let range = "above 0 and at most 1";
            return Err(InvalidInput::out_of_range("the position gain", self.position_gain, "", range));
        }
        let magnitudes: [(&str, &[f64]); 2] =
            [("the velocity limits", &self.velocity), ("the acceleration limits", &self.acceleration)];
        check_dof_limits(model, &magnitudes, &self.position)
    }

    /// The position limits as bounds, for coordinates that have one of their own.
    pub(super) fn bounds(&self, model: &Model) -> Bounds {
        let mut bounds = Bounds(Vec::with_capacity(model.nv()));
        for (q, v) in plain_coordinates(model) {
            let [lower, upper] = self.position[v];
            bounds.0.push(crate::inverse_kinematics::bounds::Bound { q, v, lower, upper });
        }
        bounds
    }
}

/// The indices in q and v of coordinates without quaternions.
fn plain_coordinates(model: &Model) -> impl Iterator<Item = (usize, usize)> {
    let joints = model.joints().iter().filter(|joint| joint.nv > 0 && joint.nq == joint.nv);
    joints.flat_map(|joint| (0..joint.nv).map(|k| (joint.q_index + k, joint.v_index + k)))
}

/// The kind of the limit that a bound comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum LimitKind {
    #[default]
    Position,
    Velocity,
    Acceleration,
}

impl LimitKind {
    pub(super) fn of_dof(self, dof: usize) -> KinematicLimit {
        match self {
            Self::Position => KinematicLimit::Position { dof },
            Self::Velocity => KinematicLimit::Velocity { dof },
            Self::Acceleration => KinematicLimit::Acceleration { dof },
        }
    }
}

/// The bounds on the displacement of one degree of freedom, and their kinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StepBound {
    pub(super) bounds: [f64; 2],
    pub(super) kinds: [LimitKind; 2],
}

impl StepBound {
    /// The bounds for the step Δt after the velocity v₀, at the distances `room` from the position limits.
    pub(super) fn new(limits: &KinematicLimits, dof: usize, room: [f64; 2], (v0, dt): (f64, f64)) -> Self {
        let (most, a) = (limits.velocity[dof], limits.acceleration[dof]);
        let mut own =
            Self { bounds: [f64::NEG_INFINITY, f64::INFINITY], kinds: [LimitKind::Acceleration; 2] };
        own.restrict([(v0 - a * dt) * dt, (v0 + a * dt) * dt], LimitKind::Acceleration);
        own.restrict([-most * dt, most * dt], LimitKind::Velocity);
        let gain = limits.position_gain;
        let upper = (gain * room[1]).min(braking(room[1], a, dt));
        let lower = (gain * room[0]).max(-braking(-room[0], a, dt));
        own.restrict([lower, upper], LimitKind::Position);
        own
    }

    /// Narrows the bounds, or moves the nearer one if they would contradict each other.
    fn restrict(&mut self, [lower, upper]: [f64; 2], kind: LimitKind) {
        let [low, high] = self.bounds;
        if lower > low {
            self.bounds[0] = lower.min(high);
            self.kinds[0] = kind;
        }
        if upper < high {
            self.bounds[1] = upper.max(low);
            self.kinds[1] = kind;
        }
    }
}

/// The longest first step after which a joint with the deceleration a stops within the room: v Δt with v Δt +
/// v²/2a = room.
fn braking(room: f64, a: f64, dt: f64) -> f64 {
    if a.is_infinite() || room <= 0.0 || room.is_infinite() {
        return room;
    }
    // a (√(Δt² + 2 room/a) − Δt) Δt without cancellation.
    2.0 * room * dt / ((dt * dt + 2.0 * room / a).sqrt() + dt)
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::pendulum;

    use super::*;

    #[test]
    fn a_joint_at_its_bounds_stays_within_its_limits() {
        let model = Model::new(pendulum(1.0, 1.0)).expect("a robot");
        let mut limits = KinematicLimits::none(&model);
        (limits.position[0], limits.velocity[0], limits.acceleration[0]) = ([-1.0, 1.0], 2.0, 5.0);
        let (mut q, mut v, dt) = (0.0, 0.0, 0.01);
        for _ in 0..400 {
            let room = [-1.0 - q, 1.0 - q];
            let StepBound { bounds, .. } = StepBound::new(&limits, 0, room, (v, dt));
            let next = bounds[1] / dt;
            assert!((next - v).abs() <= 5.0 * dt + 1e-12 && next <= 2.0 + 1e-12);
            v = next;
            q += v * dt;
            assert!(q <= 1.0 + 1e-12);
        }
        assert!(q > 0.999);
    }

    #[test]
    fn bounds_are_ordered() {
        let model = Model::new(pendulum(1.0, 1.0)).expect("a robot");
        let mut limits = KinematicLimits::none(&model);
        (limits.position[0], limits.velocity[0], limits.acceleration[0]) = ([-1.0, 1.0], 2.0, 5.0);
        for q in [-2.0, -0.5, 0.9, 3.0] {
            for v in [-5.0, 0.0, 1.9, 5.0] {
                let bound = StepBound::new(&limits, 0, [-1.0 - q, 1.0 - q], (v, 0.01));
                assert!(bound.bounds[0] <= bound.bounds[1], "{q} {v}");
                assert!(
                    bound.bounds[0] >= (v - 0.05) * 0.01 - 1e-15
                        && bound.bounds[1] <= (v + 0.05) * 0.01 + 1e-15
                );
            }
        }
    }
}
