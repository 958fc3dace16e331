//! What gives the motors their torques.

/// A source of generalized forces, asked once at the start of every step.
///
/// Any closure `FnMut(t, q, v, tau)` is one.
pub trait Controller {
    /// Writes τ (nv entries, N·m or N) for the state (q, v) at time t \[s\]; it is held until the next call.
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]);
}

impl<F: FnMut(f64, &[f64], &[f64], &mut [f64])> Controller for F {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) {
        self(t, q, v, tau);
    }
}

/// No torque: the robot is let go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ZeroTorque;

impl Controller for ZeroTorque {
    fn torque(&mut self, _: f64, _: &[f64], _: &[f64], tau: &mut [f64]) {
        tau.fill(0.0);
    }
}

/// The same torques all the time, nv entries \[N·m or N\].
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantTorque(pub Vec<f64>);

impl Controller for ConstantTorque {
    fn torque(&mut self, _: f64, _: &[f64], _: &[f64], tau: &mut [f64]) {
        crate::place::check_length("the constant torque", self.0.len(), tau.len());
        tau.copy_from_slice(&self.0);
    }
}
