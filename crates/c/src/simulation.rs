//! Simulations: everything that a robot's file states, step by step.

pub mod contacts;
pub mod inputs;
mod sensor_layout;
pub mod sensors;
pub mod snapshots;

use std::ffi::{CString, c_char};

use robot_dynamics::contact::Ground;
use robot_dynamics::model::FrameId;
use robot_dynamics::simulation::{AppliedWrench, Effect, Method, Simulation, SimulationBuilder};

use crate::Status;
use crate::arrays::{Arrays, c_text, optional_text, options, result};
use crate::calls::{call, query};
use crate::configuration::check_finite;
use crate::failure::Failure;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel};

use self::sensor_layout::Sensors;

/// A simulation of one robot. It serves one call at a time.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SimulationHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct RobotSimulation {
    simulation: Simulation,
    frames: Vec<FrameId>,
    method: CString,
    reason: CString,
    left_out: CString,
    control_names: Vec<CString>,
    sensors: Sensors,
    /// The memory of `rd_simulation_set_wrenches`.
    wrenches: Vec<AppliedWrench>,
}

object!(RobotSimulation, 5, "the simulation");

impl RobotSimulation {
    /// The simulation, and the frames of its model by number.
    pub(crate) fn parts(&self) -> (&Simulation, &[FrameId]) {
        (&self.simulation, &self.frames)
    }
}

/// Options of a simulation. A structure filled with zeros selects the defaults: everything that the robot's
/// file states, without a ground besides that of the file.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SimulationOptionsC {
    /// The step \[s\]; 0 for the default, 1e-3.
    pub dt: f64,
    /// The method, such as `rk4`, `implicit` or `mujoco`; null selects it by the robot.
    pub method: *const c_char,
    /// Not 0: no effect that removes or adds energy.
    pub conservative: i32,
    /// Effects to leave out, separated by commas, such as `dissipation,link-contacts`; or null.
    pub without: *const c_char,
    /// Not 0: a ground, horizontal at the height `ground_height`.
    pub has_ground: i32,
    /// The height of the ground \[m\].
    pub ground_height: f64,
    /// The friction coefficient of the ground; 0 for the default of the file and the library, negative for a
    /// ground without friction.
    pub ground_friction: f64,
    /// The restitution of the ground, between 0 and 1.
    pub ground_restitution: f64,
}

impl Default for SimulationOptionsC {
    fn default() -> Self {
        let none = std::ptr::null();
        Self {
            dt: 0.0,
            method: none,
            conservative: 0,
            without: none,
            has_ground: 0,
            ground_height: 0.0,
            ground_friction: 0.0,
            ground_restitution: 0.0,
        }
    }
}

/// The energies of a simulation \[J\].
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct EnergyAccountC {
    /// K.
    pub kinetic: f64,
    /// V.
    pub potential: f64,
    /// K + V at the start.
    pub start: f64,
    /// The work of motors and of applied wrenches.
    pub work: f64,
    /// The energy that damping, friction and contacts removed.
    pub dissipated: f64,
    /// K + V − start − work + dissipated: zero for the exact motion.
    pub imbalance: f64,
    /// The largest imbalance relative to the energy that moved.
    pub relative_imbalance: f64,
    /// max |E − E₀| relative to the energy that moved.
    pub drift: f64,
}

unsafe fn build(robot: &RobotModel, given: &SimulationOptionsC) -> Result<Simulation, Failure> {
    let dt = if given.dt == 0.0 { SimulationBuilder::DEFAULT_DT } else { given.dt };
    let mut builder = robot_dynamics::simulation(&robot.model).dt(dt);
    if let Some(name) = optional_text("the method", given.method)? {
        let method: Method = name.parse().map_err(|_| {
            let names: Vec<&str> = Method::names().collect();
            let message = format!("there is no method `{name}`; there are {}", names.join(", "));
            Failure::new(Status::UnknownName, message)
        })?;
        builder = builder.method(method);
    }
    if given.conservative != 0 {
        builder = builder.conservative();
    }
    let without = optional_text("the effects to leave out", given.without)?.unwrap_or_default();
    for name in without.split(',').map(str::trim).filter(|name| !name.is_empty()) {
        let effect: Effect =
            name.parse().map_err(|error| Failure::new(Status::UnknownName, format!("{error}")))?;
        builder = builder.without(effect);
    }
    if given.has_ground != 0 {
        let mut ground = Ground::level(given.ground_height).with_restitution(given.ground_restitution);
        check_finite("the friction of the ground", given.ground_friction)?;
        ground.friction = (given.ground_friction != 0.0).then_some(given.ground_friction.max(0.0));
        builder = builder.ground(ground);
    }
    Ok(builder.build()?)
}

/// Makes a simulation of a model at its initial configuration, at rest. `options` may be null. Free it with
/// `rd_simulation_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_new(
    model: ModelHandle,
    options: *const SimulationOptionsC,
    simulation: *mut SimulationHandle,
) -> Status {
    call(|| {
        let out = result("the result `simulation`", simulation)?;
        let robot = shared::<RobotModel>(model.id)?;
        let simulation = build(&robot, &self::options("the options", options)?)?;
        let left_out: Vec<String> =
            simulation.unsupported_features().iter().map(ToString::to_string).collect();
        out.id = insert(RobotSimulation {
            frames: robot.frames.clone(),
            method: c_text(&simulation.method().to_string()),
            reason: c_text(simulation.reason()),
            left_out: c_text(&left_out.join("\n")),
            control_names: simulation.control_names().map(c_text).collect(),
            sensors: Sensors::of(&simulation),
            wrenches: Vec::new(),
            simulation,
        })?;
        Ok(())
    })
}

/// Frees a simulation. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_free(simulation: SimulationHandle) -> Status {
    call(|| remove::<RobotSimulation>(simulation.id))
}

/// A text of a simulation.
fn text_of(
    simulation: SimulationHandle,
    of: impl FnOnce(&RobotSimulation) -> Option<*const c_char>,
) -> *const c_char {
    query(std::ptr::null(), || {
        let own = shared::<RobotSimulation>(simulation.id)?;
        of(&own).ok_or_else(|| Failure::invalid("the simulation has no such name"))
    })
}

/// The name of the method that takes the steps. This and the other texts of a simulation are valid until it
/// is freed.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_method(simulation: SimulationHandle) -> *const c_char {
    text_of(simulation, |own| Some(own.method.as_ptr()))
}

/// The reason why the library selected this method.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_reason(simulation: SimulationHandle) -> *const c_char {
    text_of(simulation, |own| Some(own.reason.as_ptr()))
}

/// The features of the robot's file that the simulation leaves out, one in a line; empty if there are none.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_left_out(simulation: SimulationHandle) -> *const c_char {
    text_of(simulation, |own| Some(own.left_out.as_ptr()))
}

/// The number of actuators, the length of the controls; 0 if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_control_count(simulation: SimulationHandle) -> usize {
    query(0, || Ok(shared::<RobotSimulation>(simulation.id)?.control_names.len()))
}

/// The name of an actuator; null for any other number.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_control_name(simulation: SimulationHandle, control: usize) -> *const c_char {
    text_of(simulation, |own| own.control_names.get(control).map(|name| name.as_ptr()))
}

/// The time \[s\]; NaN if the handle is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_time(simulation: SimulationHandle) -> f64 {
    query(f64::NAN, || Ok(shared::<RobotSimulation>(simulation.id)?.simulation.time()))
}

/// Takes steps. It stops at the first one that fails; the state is then that before the failed step. A step
/// without a ground and contacts does not allocate.
#[unsafe(no_mangle)]
pub extern "C" fn rd_simulation_step(simulation: SimulationHandle, steps: usize) -> Status {
    call(|| {
        let mut own = exclusive::<RobotSimulation>(simulation.id)?;
        for _ in 0..steps {
            own.simulation.step()?;
        }
        Ok(())
    })
}

/// Copies an array of the simulation.
unsafe fn copy(
    simulation: SimulationHandle,
    (out, len): (*mut f64, usize),
    of: impl FnOnce(&Simulation) -> &[f64],
) -> Status {
    call(|| {
        let own = shared::<RobotSimulation>(simulation.id)?;
        let numbers = of(&own.simulation);
        Arrays::default().output("the result", out, len, numbers.len())?.copy_from_slice(numbers);
        Ok(())
    })
}

/// The configuration, nq numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_q(simulation: SimulationHandle, q: *mut f64, nq: usize) -> Status {
    copy(simulation, (q, nq), Simulation::q)
}

/// The velocity, nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_v(simulation: SimulationHandle, v: *mut f64, nv: usize) -> Status {
    copy(simulation, (v, nv), Simulation::v)
}

/// The mean acceleration of the last step, nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_acceleration(
    simulation: SimulationHandle,
    a: *mut f64,
    nv: usize,
) -> Status {
    copy(simulation, (a, nv), Simulation::acceleration)
}

/// The generalized forces that acted in the last step, after effort limits, nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_applied_torques(
    simulation: SimulationHandle,
    tau: *mut f64,
    nv: usize,
) -> Status {
    copy(simulation, (tau, nv), Simulation::applied_torques)
}

/// The energy account. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_simulation_energy(
    simulation: SimulationHandle,
    energy: *mut EnergyAccountC,
) -> Status {
    call(|| {
        let own = shared::<RobotSimulation>(simulation.id)?;
        let account = own.simulation.energy_account();
        *result("the result `energy`", energy)? = EnergyAccountC {
            kinetic: account.kinetic(),
            potential: account.potential(),
            start: account.start(),
            work: account.work(),
            dissipated: account.dissipated(),
            imbalance: account.imbalance(),
            relative_imbalance: account.relative_imbalance(),
            drift: account.drift(),
        };
        Ok(())
    })
}
