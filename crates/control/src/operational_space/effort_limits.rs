//! Effort limits of a control law: the task keeps its direction, and the posture gives way first.

use robot_dynamics_core::Model;
use robot_dynamics_simulation::motion::simulate::set_limits;

/// The fractions of a command that fit into the effort limits; 1 is the whole command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortScales {
    /// The fraction of the frame's acceleration and force.
    pub task: f64,
    /// The fraction of the acceleration in the null space.
    pub posture: f64,
    /// The first coordinate at which the torque without any acceleration exceeds the limit. It is clipped
    /// there, and the frame does not follow.
    pub overloaded: Option<usize>,
}

impl EffortScales {
    /// The whole command.
    const ONE: Self = Self { task: 1.0, posture: 1.0, overloaded: None };
}

/// Effort limits, and memory for the parts of a torque.
#[derive(Clone, Debug)]
pub(super) struct EffortLimits {
    limits: Vec<f64>,
    /// τ that holds the frame and the posture without acceleration.
    pub(super) hold: Vec<f64>,
    /// τ with the task, without acceleration of the posture.
    pub(super) with_task: Vec<f64>,
    pub(super) scales: EffortScales,
}

impl EffortLimits {
    /// The effort limits of the robot's joints.
    pub(super) fn new(model: &Model) -> Self {
        let limits = model.coordinate_limits().iter().map(|limits| limits.effort).collect();
        let zeros = vec![0.0; model.nv()];
        Self { limits, hold: zeros.clone(), with_task: zeros, scales: EffortScales::ONE }
    }

    /// Replaces the limits.
    ///
    /// # Panics
    /// Panics if the length is wrong, or a limit is negative or NaN.
    #[track_caller]
    pub(super) fn set(&mut self, limits: &[f64]) {
        set_limits(&mut self.limits, limits);
    }

    /// Whether a torque is within the limits; the scales are 1 then.
    pub(super) fn allow(&mut self, tau: &[f64]) -> bool {
        self.scales = EffortScales::ONE;
        tau.iter().zip(&self.limits).all(|(tau, limit)| tau.abs() <= *limit)
    }

    /// τ ← τ_hold + s₁ (τ_task − τ_hold) + s₂ (τ − τ_task): the largest s₁ ≤ 1 within the limits, then the
    /// largest s₂ ≤ 1. Coordinates at which τ_hold exceeds its limit are clipped.
    pub(super) fn scale(&mut self, tau: &mut [f64]) {
        let Self { limits, hold, with_task, scales } = self;
        for k in 0..tau.len() {
            tau[k] -= with_task[k];
            with_task[k] -= hold[k];
        }
        scales.overloaded = hold.iter().zip(&*limits).position(|(tau, limit)| tau.abs() > *limit);
        scales.task = largest_fraction(hold, with_task, limits);
        hold.iter_mut().zip(&*with_task).for_each(|(hold, task)| *hold += scales.task * task);
        scales.posture = largest_fraction(hold, tau, limits);
        for k in 0..tau.len() {
            tau[k] = (hold[k] + scales.posture * tau[k]).clamp(-limits[k], limits[k]);
        }
    }
}

/// The largest s in \[0, 1\] with |base + s part| ≤ limit; 0 if it is beyond a limit and would move on.
fn largest_fraction(base: &[f64], part: &[f64], limits: &[f64]) -> f64 {
    let mut fraction = 1.0_f64;
    for ((base, part), limit) in base.iter().zip(part).zip(limits) {
        if *part != 0.0 {
            fraction = fraction.min((limit.copysign(*part) - base) / part);
        }
    }
    fraction.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_end_at_the_first_limit() {
        assert_eq!(largest_fraction(&[1.0, -1.0], &[2.0, -8.0], &[2.0, 3.0]), 0.25);
        assert_eq!(largest_fraction(&[1.0], &[0.5], &[2.0]), 1.0);
        assert_eq!(largest_fraction(&[3.0], &[1.0], &[2.0]), 0.0);
        assert_eq!(largest_fraction(&[3.0], &[-10.0], &[2.0]), 0.5);
        assert_eq!(largest_fraction(&[3.0], &[0.0], &[f64::INFINITY]), 1.0);
    }
}
