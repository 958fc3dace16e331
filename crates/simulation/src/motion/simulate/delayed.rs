//! A control law whose torque arrives late.

use std::collections::VecDeque;

use robot_dynamics_number::check_positive;

use super::{Controller, ControllerError};

/// A control law whose torque acts after a delay, as through a bus or a computer: τ(t) is the law's torque of
/// the last call at or before t − d. Until the first torque arrives, τ = 0.
///
/// Calls are in the order of time; a call at an earlier time than the last one begins a new motion. It
/// allocates while its memory of about d/h torques grows.
///
/// ```
/// use robot_dynamics::simulation::{Controller, Delayed};
/// let now = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau[0] = t;
/// let mut late = Delayed::new(now, 0.02)?;
/// let mut tau = [f64::NAN];
/// let mut at = |t: f64| late.torque(t, &[], &[], &mut tau).map(|()| tau[0]);
/// assert_eq!([at(0.0)?, at(0.01)?, at(0.02)?, at(0.03)?], [0.0, 0.0, 0.0, 0.01]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Delayed<C> {
    law: C,
    delay: f64,
    /// The times and torques that are on their way, and the last that arrived.
    sent: VecDeque<(f64, Vec<f64>)>,
    has_arrived: bool,
    /// Memory of torques that are no longer needed.
    spare: Vec<Vec<f64>>,
}

impl<C: Controller> Delayed<C> {
    /// A law with the delay d \[s\].
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if d is not positive and finite.
    pub fn new(law: C, delay: f64) -> Result<Self, ControllerError> {
        check_positive("the delay", delay, "s")?;
        Ok(Self { law, delay, sent: VecDeque::new(), has_arrived: false, spare: Vec::new() })
    }
}

impl<C: Controller> Controller for Delayed<C> {
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        self.law.torque(t, q, v, tau)?;
        let Self { delay, sent, has_arrived, spare, .. } = self;
        if sent.back().is_some_and(|(last, _)| t < *last) {
            spare.extend(sent.drain(..).map(|(_, torque)| torque));
            *has_arrived = false;
        }
        let mut torque = spare.pop().unwrap_or_default();
        torque.clear();
        torque.extend_from_slice(tau);
        sent.push_back((t, torque));
        // Times are sums of steps: a torque that arrives at t up to rounding has arrived.
        let arrives = |sent: f64| sent + *delay <= t + 4.0 * f64::EPSILON * (t.abs() + *delay);
        while sent.get(usize::from(*has_arrived)).is_some_and(|(time, _)| arrives(*time)) {
            if *has_arrived {
                spare.extend(sent.pop_front().map(|(_, torque)| torque));
            }
            *has_arrived = true;
        }
        match sent.front() {
            Some((_, torque)) if *has_arrived => tau.copy_from_slice(torque),
            _ => tau.fill(0.0),
        }
        Ok(())
    }
}
