//! The state and the inputs of the next steps.

use std::ffi::c_char;

use robot_dynamics::simulation::{AppliedWrench, RunError, Simulation};

use crate::Status;
use crate::arrays::{Arrays, text};
use crate::calls::call;
use crate::failure::Failure;
use crate::frames::reference_frame;
use crate::handle::exclusive;
use crate::model::frame_of;

use super::{RobotSimulation, SimulationHandle};

/// Passes a state to a function of the simulation.
unsafe fn with_state(
    simulation: SimulationHandle,
    (q, nq): (*const f64, usize),
    (v, nv): (*const f64, usize),
    set: impl FnOnce(&mut Simulation, &[f64], &[f64]) -> Result<(), RunError>,
) -> Status {
    call(|| {
        let mut own = exclusive::<RobotSimulation>(simulation.id)?;
        let mut arrays = Arrays::default();
        let q = arrays.input("q", q, nq, own.simulation.q().len())?;
        let v = arrays.input("v", v, nv, own.simulation.v().len())?;
        Ok(set(&mut own.simulation, q, v)?)
    })
}

/// Sets the state, and time and energy account to their start.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_reset(
    simulation: SimulationHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
) -> Status {
    with_state(simulation, (q, nq), (v, nv), Simulation::reset)
}

/// Resets the state to a named pose of the robot's files.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_reset_to(simulation: SimulationHandle, pose: *const c_char) -> Status {
    call(|| {
        let mut own = exclusive::<RobotSimulation>(simulation.id)?;
        Ok(own.simulation.reset_to(text("the name of the pose", pose)?)?)
    })
}

/// Sets the state; the time goes on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_set_state(
    simulation: SimulationHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
) -> Status {
    with_state(simulation, (q, nq), (v, nv), Simulation::set_state)
}

/// Sets the torques of the next steps, nv numbers \[N m or N\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_set_torques(
    simulation: SimulationHandle,
    tau: *const f64,
    nv: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<RobotSimulation>(simulation.id)?;
        let expected = own.simulation.torques().len();
        let tau = Arrays::default().input("tau", tau, nv, expected)?;
        own.simulation.set_torques(tau);
        Ok(())
    })
}

/// Sets the controls of the actuators for the next steps. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_set_controls(
    simulation: SimulationHandle,
    controls: *const f64,
    count: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<RobotSimulation>(simulation.id)?;
        let expected = own.simulation.controls().len();
        let controls = Arrays::default().input("the controls", controls, count, expected)?;
        own.simulation.set_controls(controls);
        Ok(())
    })
}

/// Sets the wrenches on frames for the next steps, in place of all earlier ones. `references` has a reference
/// frame for each, `wrenches` six numbers: force \[N\] and moment \[N m\]. Does not allocate for as many
/// wrenches as an earlier call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_set_wrenches(
    simulation: SimulationHandle,
    frames: *const u32,
    references: *const u32,
    count: usize,
    wrenches: *const f64,
    wrenches_len: usize,
) -> Status {
    call(|| {
        let mut own = exclusive::<RobotSimulation>(simulation.id)?;
        let RobotSimulation { simulation, frames: ids, wrenches: applied, .. } = &mut *own;
        let mut arrays = Arrays::default();
        let frames = arrays.any("the frames", frames, count)?;
        let references = arrays.any("the reference frames", references, count)?;
        let numbers = arrays.input("the wrenches", wrenches, wrenches_len, count.saturating_mul(6))?;
        applied.clear();
        for ((frame, reference), w) in frames.iter().zip(references).zip(numbers.chunks_exact(6)) {
            if let Some(bad) = w.iter().find(|x| !x.is_finite()) {
                return Err(Failure::invalid(format!("a wrench has the entry {bad}; it must be finite")));
            }
            applied.push(AppliedWrench {
                frame: frame_of(ids, simulation.model(), *frame)?,
                axes: reference_frame(*reference)?,
                force: [w[0], w[1], w[2]],
                moment: [w[3], w[4], w[5]],
            });
        }
        simulation.set_wrenches(applied);
        Ok(())
    })
}
