//! The steps of one simulation.

use std::sync::atomic::{AtomicBool, Ordering};

use robot_dynamics_simulation::RunError;
use robot_dynamics_simulation::simulator::Simulation;

use super::position_control::PositionControl;

/// Takes `steps` steps, unless `cancelled` is set during the call.
pub(super) fn advance(
    simulation: &mut Simulation,
    steps: usize,
    cancelled: &AtomicBool,
) -> Result<(), RunError> {
    let go_on = |_: &usize| !cancelled.load(Ordering::Relaxed);
    (0..steps).take_while(go_on).try_for_each(|_| simulation.step())
}

/// As [`advance`], with the torques of a position control in each step.
pub(super) fn advance_controlled(
    control: &PositionControl,
    (number, simulation): (usize, &mut Simulation),
    steps: usize,
    cancelled: &AtomicBool,
) -> Result<(), RunError> {
    let go_on = |_: &usize| !cancelled.load(Ordering::Relaxed);
    let given = simulation.torques().to_vec();
    let mut torques = given.clone();
    let result = (0..steps).take_while(go_on).try_for_each(|done| {
        torques.copy_from_slice(&given);
        control.add_torques(number, done, simulation, &mut torques);
        simulation.set_torques(&torques);
        simulation.step()
    });
    simulation.set_torques(&given);
    result
}
