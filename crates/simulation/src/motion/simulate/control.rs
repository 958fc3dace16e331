//! Controllers: sources of the torques.

use robot_dynamics_description::check_length;
use robot_dynamics_number::check_finite;

use super::callback::IntoCallbackResult;
use super::control_error::ControllerError;

/// A source of generalized forces, called once at the start of every step.
///
/// Any closure `FnMut(t, q, v, tau)` is a controller. It returns nothing, or a `Result<(), E>` with any
/// error. If a controller fails, the run ends with the time and the cause, and keeps the results up to then.
///
/// ```
/// use robot_dynamics::simulation::{Controller, ControllerError};
/// let mut spring = |_t: f64, q: &[f64], _v: &[f64], tau: &mut [f64]| tau[0] = -3.0 * q[0];
/// let mut guarded = |_t: f64, q: &[f64], _v: &[f64], tau: &mut [f64]| {
///     tau[0] = -3.0 * q[0];
///     if q[0].abs() < 1.0 { Ok(()) } else { Err("the encoder left its range") }
/// };
/// let mut tau = [0.0];
/// spring.torque(0.0, &[2.0], &[0.0], &mut tau)?;
/// assert_eq!(tau, [-6.0]);
/// let error = guarded.torque(0.0, &[2.0], &[0.0], &mut tau).unwrap_err();
/// assert_eq!(error.to_string(), "the encoder left its range");
/// # Ok::<(), ControllerError>(())
/// ```
pub trait Controller {
    /// Writes τ (nv entries, N·m or N) for the state (q, v) at time t \[s\]; the simulation holds it until
    /// the next call.
    ///
    /// # Errors
    /// [`ControllerError`] if there is no torque; the contents of `tau` are then unspecified.
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError>;
}

impl<F, R> Controller for F
where
    F: FnMut(f64, &[f64], &[f64], &mut [f64]) -> R,
    R: IntoCallbackResult<()>,
{
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        Ok(self(t, q, v, tau).outcome()?)
    }
}

/// Zero torque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ZeroTorque;

impl Controller for ZeroTorque {
    fn torque(&mut self, _: f64, _: &[f64], _: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        tau.fill(0.0);
        Ok(())
    }
}

/// Constant torques, nv entries \[N·m or N\].
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantTorque(pub Vec<f64>);

impl Controller for ConstantTorque {
    /// # Panics
    /// Panics if the number of torques is not nv.
    fn torque(&mut self, _: f64, _: &[f64], _: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        check_length("the constant torque", self.0.len(), tau.len());
        check_finite("the constant torque", &self.0)?;
        tau.copy_from_slice(&self.0);
        Ok(())
    }
}
