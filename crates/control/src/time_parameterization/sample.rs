//! The motion at one point of a timed path, by inverse dynamics.

use robot_dynamics_core::{Model, Workspace, dissipation, inverse_dynamics};

use super::{LimitedQuantity, MotionLimits, TimedPath, TreePath, TreePathPoint};

/// The fraction of an interval from its end at which the direction of a velocity counts as that inside.
pub(super) const NEARBY: f64 = 1e-3;

/// A speed ṡ at which friction acts, but no other force.
const SLOWEST: f64 = 1e-150;

/// q, v, a and τ of a motion at one point.
#[derive(Clone, Debug)]
pub(super) struct MotionSample {
    pub(super) s: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) a: Vec<f64>,
    pub(super) tau: Vec<f64>,
}

/// Evaluates a timed path by inverse dynamics and dissipation, without coefficients of the path.
pub(super) struct Sampler<'a, P> {
    model: &'a Model,
    workspace: Workspace,
    path: &'a P,
    timed: &'a TimedPath,
    dissipation: bool,
}

impl<'a, P: TreePath> Sampler<'a, P> {
    pub(super) fn new(model: &'a Model, path: &'a P, timed: &'a TimedPath, dissipation: bool) -> Self {
        Self { model, workspace: Workspace::new(model), path, timed, dissipation }
    }

    /// The motion in an interval, at a fraction of it. At its ends friction has the direction of the motion
    /// inside.
    pub(super) fn at(&mut self, interval: usize, part: f64) -> MotionSample {
        let (grid, x) = (self.timed.grid(), self.timed.squared_speeds());
        let (from, length) = (grid[interval], grid[interval + 1] - grid[interval]);
        let square = x[interval] + (x[interval + 1] - x[interval]) * part;
        let s = from + length * part;
        let TreePathPoint { q, dq, ddq } = self.path.at(s);
        let (speed, acceleration) = (square.sqrt(), self.timed.acceleration(interval));
        let v: Vec<f64> = dq.iter().map(|dq| dq * speed).collect();
        let a: Vec<f64> = dq.iter().zip(&ddq).map(|(dq, ddq)| dq * acceleration + ddq * square).collect();
        let mut tau = vec![0.0; v.len()];
        inverse_dynamics(self.model, &mut self.workspace, &q, &v, &a, &mut tau);
        if self.dissipation {
            let inside_part = part.clamp(NEARBY, 1.0 - NEARBY);
            let inside =
                if part == inside_part { dq.clone() } else { self.path.at(from + length * inside_part).dq };
            // A coordinate that turns here moves in the direction that it has inside the interval.
            let turning = |(dq, inside): (&f64, &f64)| {
                let rate = if dq * inside > 0.0 { *dq } else { SLOWEST * inside.signum() };
                if *inside == 0.0 { 0.0 } else { rate * speed.max(SLOWEST) }
            };
            let moving: Vec<f64> = dq.iter().zip(&inside).map(turning).collect();
            let mut losses = vec![0.0; v.len()];
            dissipation(self.model, &moving, &mut losses);
            tau.iter_mut().zip(losses).for_each(|(tau, loss): (&mut f64, f64)| *tau += loss);
        }
        MotionSample { s, q, v, a, tau }
    }
}

impl MotionSample {
    /// The largest utilization of a limit, with its quantity and coordinate; 1 is the limit itself.
    ///
    /// The utilization of a range of torques is 1 + excess / (the larger magnitude of its ends), which is
    /// |τ|/τ_max for a symmetric range.
    pub(super) fn utilization(&self, limits: &MotionLimits) -> (f64, LimitedQuantity, usize) {
        let mut worst = (0.0, LimitedQuantity::Torque, 0);
        for k in 0..self.v.len() {
            let (tau, v) = (self.tau[k], self.v[k]);
            let uses = [
                (
                    range_utilization(tau, limits.torque_lower[k], limits.torque_upper[k]),
                    LimitedQuantity::Torque,
                ),
                (v.abs() / limits.velocity[k], LimitedQuantity::Velocity),
                (self.a[k].abs() / limits.acceleration[k], LimitedQuantity::Acceleration),
                ((tau * v).abs() / limits.power[k], LimitedQuantity::Power),
            ];
            for (value, quantity) in uses {
                if value > worst.0 {
                    worst = (value, quantity, k);
                }
            }
        }
        worst
    }
}

/// 1 + the excess of x over its range as a fraction of the range's larger finite magnitude.
pub(super) fn range_utilization(x: f64, lower: f64, upper: f64) -> f64 {
    let finite = |limit: f64| if limit.is_finite() { limit.abs() } else { 0.0 };
    let excess = (x - upper).max(lower - x);
    match finite(lower).max(finite(upper)) {
        _ if excess == f64::NEG_INFINITY => 0.0,
        0.0 => 1.0 + excess,
        scale => 1.0 + excess / scale,
    }
}
