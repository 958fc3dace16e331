//! The results of a run, and the state that an observer receives.

use std::ops::ControlFlow;

use robot_dynamics_integrators::EnergyAccount;

use super::{EventOccurrence, Losses, Stepper, Trajectory};
use crate::ContactLaws;

/// The state that an observer receives: at a control instant, before the torque acts.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
#[doc(alias = "Moment")]
pub struct StepInfo<'a> {
    /// Completed steps.
    pub step: usize,
    /// Time since the start \[s\].
    pub time: f64,
    /// The configuration.
    pub q: &'a [f64],
    /// The velocity.
    pub v: &'a [f64],
    /// The torque of the controller at this state \[N·m or N\].
    pub tau: &'a [f64],
    /// The current energy account.
    pub energy_account: &'a EnergyAccount,
    /// The energy dissipated so far, by cause; `None` if the method does not separate the causes.
    pub losses: Option<Losses>,
    /// The force of the ground on each link that can touch it, along the world's axes, as the mean of the
    /// step before \[N\]. The order is that of [`ContactSet::links`](crate::ContactSet::links); empty if
    /// contact is not computed.
    pub contact_forces: &'a [[f64; 3]],
    /// The force of each actuator before its gear, as the mean of the step before \[N·m or N\]:
    /// [`Stepper::actuator_forces`]. Empty if the method has no actuators.
    pub actuator_forces: &'a [f64],
    /// The generalized force of the actuators, as the mean of the step before \[N·m or N\]:
    /// [`Stepper::actuator_torques`].
    pub actuator_torques: &'a [f64],
}

/// The results of a run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Run {
    /// The samples.
    pub trajectory: Trajectory,
    /// The energy account.
    pub energy_account: EnergyAccount,
    /// The dissipated energy by cause, if the method separates the causes; the sum is
    /// [`EnergyAccount::dissipated`].
    pub losses: Option<Losses>,
    /// The largest |τ| that acted on each coordinate \[N·m or N\].
    pub peak_torque: Vec<f64>,
    /// The events, sorted by time.
    pub events: Vec<EventOccurrence>,
    /// Completed steps; a last step that a terminal event shortened counts as one.
    pub steps: usize,
    /// The end time since the start \[s\].
    pub time: f64,
    /// Whether the observer or an interrupt flag ended the run early
    /// ([`SimulationBuilder::interrupt`](crate::simulator::SimulationBuilder::interrupt)).
    pub interrupted: bool,
    /// Whether a terminal event ended the run; it is the last of [`events`](Self::events).
    pub ended_by_event: bool,
    /// The accuracy of the solutions of rigid contact, if the method solves for them.
    pub contact_laws: Option<ContactLaws>,
    /// The last of [`StepInfo::contact_forces`].
    pub contact_forces: Vec<[f64; 3]>,
    /// q at the end.
    pub q: Vec<f64>,
    /// v at the end.
    pub v: Vec<f64>,
}

impl Run {
    /// The observer's view of the current state, after a number of steps.
    pub(crate) fn step_info<'a>(
        &'a self,
        step: usize,
        tau: &'a [f64],
        stepper: &'a impl Stepper,
    ) -> StepInfo<'a> {
        StepInfo {
            step,
            time: self.time,
            q: &self.q,
            v: &self.v,
            tau,
            energy_account: &self.energy_account,
            losses: self.losses,
            contact_forces: stepper.contact_forces(),
            actuator_forces: stepper.actuator_forces(),
            actuator_torques: stepper.actuator_torques(),
        }
    }

    /// Adds the current state to the samples.
    pub(crate) fn keep_sample(&mut self, tau: &[f64], stepper: &impl Stepper) {
        let Self { trajectory, time, q, v, energy_account, .. } = self;
        trajectory.push(*time, (q, v), tau, energy_account, stepper.contact_forces());
    }
}

/// A callback that receives the state at the start of each step and at the end, and can stop the run.
pub type Observer<'a> = &'a mut dyn FnMut(&StepInfo<'_>) -> ControlFlow<()>;
