//! Without machine code each simulation takes its own steps.

use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use robot_dynamics_simulation::RunError;
use robot_dynamics_simulation::simulator::Simulation;

use crate::Threads;

pub(super) const SIDE_BY_SIDE: usize = 1;

/// The kernels of steps by machine code; the type has no values.
#[derive(Debug)]
pub(super) enum StepKernels {}

pub(super) fn kernels_for(_: Option<&Simulation>, _: &Threads) -> Vec<Mutex<StepKernels>> {
    Vec::new()
}

pub(super) fn advance_side_by_side(
    kernels: &mut StepKernels,
    _: Vec<(usize, &mut Simulation)>,
    _: usize,
    _: &AtomicBool,
) -> Vec<(usize, RunError)> {
    match *kernels {}
}
