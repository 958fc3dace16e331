//! The functions of the interface with random arguments.

use std::ptr::null_mut;

use robot_dynamics_c::Status;
use robot_dynamics_c::batch::*;
use robot_dynamics_c::calls::*;
use robot_dynamics_c::configuration::*;
use robot_dynamics_c::constraints::*;
use robot_dynamics_c::control::observer::*;
use robot_dynamics_c::control::task::*;
use robot_dynamics_c::control::*;
use robot_dynamics_c::frames::*;
use robot_dynamics_c::identification::*;
use robot_dynamics_c::inverse_kinematics::*;
use robot_dynamics_c::linearization::rd_linearize_step;
use robot_dynamics_c::model::*;
use robot_dynamics_c::optimal::mpc::*;
use robot_dynamics_c::optimal::solution::*;
use robot_dynamics_c::optimal::*;
use robot_dynamics_c::quantities::functions::*;
use robot_dynamics_c::quantities::*;
use robot_dynamics_c::simulation::contacts::*;
use robot_dynamics_c::simulation::inputs::*;
use robot_dynamics_c::simulation::sensors::*;
use robot_dynamics_c::simulation::snapshots::*;
use robot_dynamics_c::simulation::*;

use crate::memory::*;

/// Makes a random call and returns its name and its status.
pub(crate) fn random(f: &mut Fuzz) -> (&'static str, Status) {
    f.start();
    let table = match f.below(100) {
        0..55 => STATES,
        55..92 => OBJECTS,
        92..95 => SLOW,
        95..99 => return crate::makers::make(f),
        _ => return ("a function that frees", f.free_any()),
    };
    let (name, call) = table[f.below(table.len())];
    // SAFETY: see `calls!`.
    (name, unsafe { call(f) })
}

type Call = unsafe fn(&mut Fuzz) -> Status;

/// A table of calls with their names. Arguments are evaluated from left to right: `f.len` is the length of
/// the array before it.
macro_rules! calls {
    ($table:ident; $f:ident; $($function:ident($($argument:expr),* $(,)?);)*) => {
        const $table: &[(&str, Call)] = &[$((stringify!($function), |$f: &mut Fuzz| {
            // SAFETY: the arguments are as the interface allows.
            #[allow(unused_unsafe)]
            let status = unsafe { Outcome::status($function($($argument),*)) };
            let _: &mut Fuzz = $f;
            status
        })),*];
    };
}

/// The status of a call; queries have none.
trait Outcome {
    fn status(self) -> Status;
}

impl Outcome for Status {
    fn status(self) -> Status {
        self
    }
}

macro_rules! queries {
    ($($kind:ty)*) => { $(impl Outcome for $kind {
        fn status(self) -> Status {
            Status::Ok
        }
    })* };
}

queries! { usize u32 u64 f64 *const std::ffi::c_char }

calls! { STATES; f;
    rd_mass_matrix(f.workspace(), f.q(), f.len, f.out(f.nv * f.nv), f.len);
    rd_inverse_mass_matrix(f.workspace(), f.q(), f.len, f.out(f.nv * f.nv), f.len);
    rd_mass_matrix_factor(f.workspace(), f.q(), f.len, f.out(f.nv * f.nv), f.len);
    rd_gravity(f.workspace(), f.q(), f.len, f.out(f.nv), f.len);
    rd_gravity_derivative(f.workspace(), f.q(), f.len, f.out(f.nv * f.nv), f.len);
    rd_bias(f.workspace(), f.q(), f.len, f.v(), f.len, f.out(f.nv), f.len);
    rd_coriolis_matrix(f.workspace(), f.q(), f.len, f.v(), f.len, f.out(f.nv * f.nv), f.len);
    rd_velocity_product(f.workspace(), f.q(), f.len, f.v(), f.len, f.out(f.nv), f.len);
    rd_momentum(f.workspace(), f.q(), f.len, f.v(), f.len, f.out(f.nv), f.len);
    rd_kinetic_energy(f.workspace(), f.q(), f.len, f.v(), f.len, f.one());
    rd_potential_energy(f.workspace(), f.q(), f.len, f.one());
    rd_inverse_dynamics(f.workspace(), f.q(), f.len, f.v(), f.len, f.v(), f.len, f.out(f.nv), f.len);
    rd_forward_dynamics(f.workspace(), f.q(), f.len, f.v(), f.len, f.v(), f.len, f.out(f.nv), f.len);
    rd_inverse_dynamics_derivatives(
        f.workspace(), f.q(), f.len, f.v(), f.len, f.v(), f.len,
        f.out(f.nv * f.nv), f.len, f.out(f.nv * f.nv), f.len
    );
    rd_forward_dynamics_derivatives(
        f.workspace(), f.q(), f.len, f.v(), f.len, f.v(), f.len,
        f.out(f.nv * f.nv), f.len, f.out(f.nv * f.nv), f.len, f.out(f.nv * f.nv), f.len
    );
    rd_center_of_mass(f.workspace(), f.q(), f.len, f.out(3), f.len);
    rd_center_of_mass_jacobian(f.workspace(), f.q(), f.len, f.out(3 * f.nv), f.len);
    rd_centroidal_momentum_matrix(f.workspace(), f.q(), f.len, f.out(6 * f.nv), f.len);
    rd_frame_poses(f.workspace(), f.q(), f.len, f.out(12 * f.frames), f.len);
    rd_frame_pose(f.workspace(), f.index(f.frames), f.q(), f.len, f.out(12), f.len);
    rd_frame_velocity(
        f.workspace(), f.index(f.frames), f.index(3), f.q(), f.len, f.v(), f.len, f.out(6), f.len
    );
    rd_frame_acceleration(
        f.workspace(), f.index(f.frames), f.index(3), f.q(), f.len, f.v(), f.len, f.v(), f.len, f.out(6), f.len
    );
    rd_frame_jacobian(f.workspace(), f.index(f.frames), f.index(3), f.q(), f.len, f.out(6 * f.nv), f.len);
    rd_frame_bias_acceleration(
        f.workspace(), f.index(f.frames), f.index(3), f.q(), f.len, f.v(), f.len, f.out(6), f.len
    );
    rd_center_of_mass_velocity(f.workspace(), f.q(), f.len, f.v(), f.len, f.out(3), f.len);
    rd_joint_reactions(
        f.workspace(), f.q(), f.len, f.v(), f.len, f.v(), f.len, f.out(6 * f.joints), f.len
    );
    rd_joint_torque_regressor(
        f.workspace(), f.q(), f.len, f.v(), f.len, f.v(), f.len, f.out(regressor(f)), f.len
    );
    rd_inertial_parameters(f.workspace(), f.out(parameters(f)), f.len);
    rd_inertial_parameter_count(f.workspace());
    rd_compute(f.workspace(), f.index(22), inputs(f, 1), results(f, 1));
    rd_compute(f.workspace(), f.index(22), inputs(f, 1), results(f, 1));
    rd_quantity_count();
    rd_quantity_name(f.index(22));
    rd_quantity_named(f.text(&[c"bias", c"mass", c""]), f.one());
    rd_quantity_lengths(f.workspace(), f.index(22), f.count(5), f.out(3), f.len);
    rd_batch_compute(
        f.batch(), f.index(22), { f.kept = f.count(3); f.kept },
        inputs(f, f.kept), results(f, f.kept)
    );
    rd_neutral(f.model(), f.out(f.nq), f.len);
    rd_random_configuration(f.model(), f.bits(), f.out(f.nq), f.len);
    rd_named_pose(f.model(), f.text(&[c"home", c"zero"]), f.out(f.nq), f.len, f.out(f.nv), f.len);
    rd_integrate(f.model(), f.q(), f.len, f.v(), f.len, f.out(f.nq), f.len);
    rd_difference(f.model(), f.q(), f.len, f.q(), f.len, f.out(f.nv), f.len);
    rd_interpolate(f.model(), f.q(), f.len, f.q(), f.len, f.number(), f.out(f.nq), f.len);
    rd_normalize(f.model(), f.q_in_place(), f.len);
}

calls! { OBJECTS; f;
    rd_model_nq(f.model());
    rd_model_nv(f.model());
    rd_model_joint_count(f.model());
    rd_model_frame_count(f.model());
    rd_model_pose_count(f.model());
    rd_model_name(f.model());
    rd_model_report(f.model());
    rd_model_joint_name(f.model(), f.count(9));
    rd_model_coordinate_name(f.model(), f.count(9));
    rd_model_frame_name(f.model(), f.index(9));
    rd_model_pose_name(f.model(), f.count(9));
    rd_model_frame(f.model(), f.text(&[c"base", c"link1", c"\xff"]), f.one());
    rd_model_joint_indices(f.model(), f.count(4), f.one(), f.one(), f.one(), f.one());
    rd_model_lower_limits(f.model(), f.out(f.nv), f.len);
    rd_model_upper_limits(f.model(), f.out(f.nv), f.len);
    rd_model_velocity_limits(f.model(), f.out(f.nv), f.len);
    rd_model_effort_limits(f.model(), f.out(f.nv), f.len);
    rd_model_mass(f.model());
    rd_model_gravity(f.model(), f.out(3), f.len);
    rd_model_fingerprint(f.model());
    rd_status_name(f.bits() as i32);
    rd_constraints_row_count(f.constraints());
    rd_constraints_row_name(f.constraints(), f.count(6));
    rd_computed_torque_set_reference(f.torque(), f.q(), f.len, f.v(), f.len, f.v(), f.len);
    rd_computed_torque_torque(f.torque(), f.q(), f.len, f.v(), f.len, f.out(f.nv), f.len);
    rd_momentum_observer_update(
        f.observer(), f.q(), f.len, f.v(), f.len, f.v(), f.len, f.positive(), f.out(f.nv), f.len
    );
    rd_momentum_observer_reset(f.observer());
    rd_task_control_set_target(f.task(), f.pose(), f.len, f.input(6), f.len, f.input(6), f.len);
    rd_task_control_torque(f.task(), f.q(), f.len, f.v(), f.len, f.out(f.nv), f.len);
    rd_motion_record_set_noise(f.record(), f.input(f.nv), f.len);
    rd_motion_record_push(f.record(), f.q(), f.len, f.v(), f.len, f.v(), f.len, f.v(), f.len);
    rd_motion_record_parameter_count(f.record());
    rd_motion_record_parameter_name(f.record(), f.count(30));
    rd_simulation_method(f.simulation());
    rd_simulation_reason(f.simulation());
    rd_simulation_left_out(f.simulation());
    rd_simulation_control_count(f.simulation());
    rd_simulation_control_name(f.simulation(), f.count(3));
    rd_simulation_time(f.simulation());
    rd_simulation_step(f.simulation(), f.below(3));
    rd_simulation_q(f.simulation(), f.out(f.nq), f.len);
    rd_simulation_v(f.simulation(), f.out(f.nv), f.len);
    rd_simulation_acceleration(f.simulation(), f.out(f.nv), f.len);
    rd_simulation_applied_torques(f.simulation(), f.out(f.nv), f.len);
    rd_simulation_energy(f.simulation(), f.one());
    rd_simulation_contacts(f.simulation(), f.out(2), f.len, f.one());
    rd_simulation_reset(f.simulation(), f.q(), f.len, f.v(), f.len);
    rd_simulation_reset_to(f.simulation(), f.text(&[c"home", c""]));
    rd_simulation_set_state(f.simulation(), f.q(), f.len, f.v(), f.len);
    rd_simulation_set_torques(f.simulation(), f.v(), f.len);
    rd_simulation_set_controls(f.simulation(), f.input(0), f.len);
    rd_simulation_set_wrenches(
        f.simulation(), f.frames(2, f.frames), f.frames(2, 3), 2, f.input(12), f.len
    );
    rd_simulation_sensor_count(f.simulation());
    rd_simulation_sensor_name(f.simulation(), f.count(3));
    rd_simulation_sensor_range(f.simulation(), f.count(3), f.one(), f.one());
    rd_simulation_sensor_value_count(f.simulation());
    rd_simulation_sensors(f.simulation(), f.out(0), f.len);
    rd_simulation_restore(f.simulation(), f.snapshot());
    rd_problem_control_count(f.problem());
    rd_problem_add_cost(
        f.problem(), { f.kept = f.below(7); f.kept as u32 }, f.below(4), f.end(4), f.index(f.frames),
        target(f), f.len, f.input(weights(f)), f.len
    );
    rd_problem_clear_costs(f.problem());
    rd_problem_set_control_bounds(
        f.problem(), f.below(2), f.end(3), f.input(f.nv), f.len, f.input(f.nv), f.len
    );
    rd_problem_set_initial_state(f.problem(), f.x(), f.len);
    rd_problem_state(f.problem(), f.count(4), f.out(f.nq + f.nv), f.len);
    rd_problem_control(f.problem(), f.count(3), f.out(f.nv), f.len);
    rd_problem_gain(f.problem(), f.count(3), f.out(2 * f.nv * f.nv), f.len);
    rd_mpc_set_costs(f.mpc(), f.problem());
    rd_mpc_times(f.mpc(), f.one());
}

calls! { SLOW; f;
    rd_linearize_step(
        f.workspace(), f.text(&[c"rk4", c"semi-implicit-euler", c"euler"]), f.positive(), f.flag(),
        f.q(), f.len, f.v(), f.len, f.v(), f.len, f.out(4 * f.nv * f.nv), f.len, f.out(2 * f.nv * f.nv), f.len
    );
    rd_constrained_forward_dynamics(
        f.workspace(), f.constraints(), f.q(), f.len, f.v(), f.len, f.v(), f.len,
        f.out(f.nv), f.len, f.out(rows(f)), f.len
    );
    rd_project_position(f.workspace(), f.constraints(), f.positive(), f.q_in_place(), f.len);
    rd_inverse_kinematics(
        f.workspace(), f.index(f.frames), f.pose(), f.len, f.q(), f.len, kinematics(f),
        f.out(f.nq), f.len, f.one()
    );
    rd_identify(
        f.record(), f.out(30), { f.kept = f.len; f.out_of(f.kept) }, f.out_of(f.kept), f.kept, f.one(), f.one()
    );
    rd_identify_consistent(f.record(), f.positive(), f.out(parameters(f)), f.len, f.one(), null_mut());
    rd_dlqr(2, 2, f.matrix(), f.matrix(), f.matrix(), f.matrix(), f.out(4), f.len, f.one());
    rd_dlqr(0, f.below(3), f.matrix(), f.matrix(), f.matrix(), f.matrix(), f.out(0), f.len, f.one());
    rd_dlqr(1, 0, f.matrix(), f.matrix(), f.matrix(), f.matrix(), f.out(0), f.len, f.one());
    rd_problem_solve(f.problem(), solver(f), f.one());
    rd_mpc_step(f.mpc(), f.x(), f.len, f.out(f.nv), f.len);
}

fn parameters(f: &Fuzz) -> usize {
    10 * f.moving()
}

fn regressor(f: &Fuzz) -> usize {
    f.nv * parameters(f)
}

/// The rows of the constraints of a robot.
fn rows(f: &Fuzz) -> usize {
    let id = f.live[CONSTRAINTS].first().map_or(0, |entry| entry.0);
    rd_constraints_row_count(ConstraintsHandle { id })
}

/// The inputs of a quantity at some states; all of them, or q alone.
fn inputs(f: &mut Fuzz, rows: usize) -> *const InputsC {
    let mut inputs = InputsC::default();
    (inputs.q, inputs.q_len) = (f.q_rows(rows), f.len);
    if f.chance(70) {
        (inputs.v, inputs.v_len) = (f.v_rows(rows), f.len);
    }
    for (to, len) in [(&mut inputs.a, &mut inputs.a_len), (&mut inputs.tau, &mut inputs.tau_len)] {
        if f.chance(30) {
            (*to, *len) = (f.v_rows(rows), f.len);
        }
    }
    if f.chance(40) {
        (inputs.frames, inputs.frames_len) = (f.frames(1, f.frames), f.len);
    }
    f.options(inputs)
}

/// The results of a quantity: a matrix, a vector, or another size.
fn results(f: &mut Fuzz, rows: usize) -> *const ResultsC {
    let n = f.nv;
    let sizes = [n * n, n, n * n, n, 6 * n, 3 * n, 3, 1, 12 * f.frames];
    let (size, count) = (sizes[f.below(sizes.len())] * rows.min(4), 1 + f.below(3));
    let mut results = ResultsC::default();
    (results.first, results.first_len) = (f.out(size), f.len);
    if count > 1 {
        (results.second, results.second_len) = (f.out(size), f.len);
    }
    if count > 2 {
        (results.third, results.third_len) = (f.out(size), f.len);
    }
    f.options(results)
}

fn kinematics(f: &mut Fuzz) -> *const InverseKinematicsOptionsC {
    let options = InverseKinematicsOptionsC {
        position_tolerance: if f.chance(80) { 1e-6 } else { f.number() },
        angle_tolerance: if f.chance(80) { 1e-6 } else { f.number() },
        max_iterations: 1 + f.below(9),
        max_restarts: 1 + f.below(2),
        from_start_only: f.flag(),
        seed: f.bits(),
    };
    f.always_options(options)
}

fn solver(f: &mut Fuzz) -> *const SolverOptionsC {
    let options = SolverOptionsC {
        max_iterations: 1 + f.below(3),
        threads: f.count(2),
        time_limit: if f.chance(80) { 0.0 } else { f.number() },
        gradient_tolerance: if f.chance(80) { 0.0 } else { f.number() },
    };
    f.always_options(options)
}

/// The target and the number of weights of the kind of costs in `f.kept`.
fn target(f: &mut Fuzz) -> *const f64 {
    match f.kept {
        0 => f.x(),
        1 => f.input(f.nv),
        3 => f.pose(),
        4 => f.input(6),
        _ => f.input(3),
    }
}

fn weights(f: &Fuzz) -> usize {
    [2 * f.nv, f.nv, 3, 6, 6, 3, 3][f.kept]
}
