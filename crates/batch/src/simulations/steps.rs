//! The steps of one simulation.

use std::sync::atomic::{AtomicBool, Ordering};

use robot_dynamics_simulation::RunError;
use robot_dynamics_simulation::simulator::Simulation;

/// Takes `steps` steps, unless `cancelled` is set during the call.
pub(super) fn advance(
    simulation: &mut Simulation,
    steps: usize,
    cancelled: &AtomicBool,
) -> Result<(), RunError> {
    let go_on = |_: &usize| !cancelled.load(Ordering::Relaxed);
    (0..steps).take_while(go_on).try_for_each(|_| simulation.step())
}
