//! Functions of one state give the bits of the library's calls in Rust.
//!
//! Unsafe code: the interface takes pointers. Each call passes slices of this program.
#![allow(unsafe_code)]
// Numbers of frames and seeds are small.
#![allow(clippy::cast_possible_truncation)]

#[macro_use]
mod common;

use common::{Robot, c, ok, robots, same_bits, text};
use robot_dynamics::algorithms::{self, ReferenceFrame};
use robot_dynamics::batch::{BatchOptions, BatchQuantity, BatchWorkspace};
use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{self, FrameId, Model, RandomState, Workspace};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::quantity::{Input, Inputs, Quantity, QuantityMemory};
use robot_dynamics::simulation::{Integrator, StepForces};
use robot_dynamics_c::Status;
use robot_dynamics_c::batch::{BatchHandle, rd_batch_compute, rd_batch_free, rd_batch_new};
use robot_dynamics_c::configuration::*;
use robot_dynamics_c::frames::*;
use robot_dynamics_c::linearization::rd_linearize_step;
use robot_dynamics_c::model::*;
use robot_dynamics_c::quantities::functions::*;
use robot_dynamics_c::quantities::*;
use robot_dynamics_c::workspace::WorkspaceHandle;

/// The numbers of a model's frames.
fn frames(model: &Model) -> Vec<FrameId> {
    model.frames().iter().map(|frame| model.frame(&frame.name).expect("a frame")).collect()
}

fn numbers(pose: &Pose) -> Vec<f64> {
    pose.rotation.iter().flatten().chain(&pose.translation).copied().collect()
}

/// The inputs that a quantity reads.
fn inputs_of(quantity: Quantity, state: &RandomState, frames: &[u32]) -> InputsC {
    let mut inputs = InputsC { q: state.q.as_ptr(), q_len: state.q.len(), ..InputsC::default() };
    if quantity.reads(Input::Velocity) {
        (inputs.v, inputs.v_len) = (state.v.as_ptr(), state.v.len());
    }
    if quantity.reads(Input::Acceleration) {
        (inputs.a, inputs.a_len) = (state.a.as_ptr(), state.a.len());
    }
    if quantity.reads(Input::Force) {
        (inputs.tau, inputs.tau_len) = (state.tau.as_ptr(), state.tau.len());
    }
    if quantity.reads(Input::Frame) {
        (inputs.frames, inputs.frames_len) = (frames.as_ptr(), frames.len());
    }
    inputs
}

fn results_of(out: &mut [Vec<f64>; 3]) -> ResultsC {
    let [x, y, z] = out;
    ResultsC {
        first: x.as_mut_ptr(),
        first_len: x.len(),
        second: y.as_mut_ptr(),
        second_len: y.len(),
        third: z.as_mut_ptr(),
        third_len: z.len(),
    }
}

#[test]
fn enumeration_has_order_and_names_of_table() {
    use QuantityC as C;
    let all = [
        (C::MassMatrix, Quantity::MassMatrix),
        (C::Bias, Quantity::Bias),
        (C::Gravity, Quantity::Gravity),
        (C::CoriolisMatrix, Quantity::CoriolisMatrix),
        (C::VelocityProduct, Quantity::VelocityProduct),
        (C::InverseDynamics, Quantity::InverseDynamics),
        (C::ForwardDynamics, Quantity::ForwardDynamics),
        (C::InverseMassMatrix, Quantity::InverseMassMatrix),
        (C::MassMatrixFactor, Quantity::MassMatrixFactor),
        (C::KineticEnergy, Quantity::KineticEnergy),
        (C::PotentialEnergy, Quantity::PotentialEnergy),
        (C::Momentum, Quantity::Momentum),
        (C::CenterOfMass, Quantity::CenterOfMass),
        (C::CenterOfMassJacobian, Quantity::CenterOfMassJacobian),
        (C::CentroidalMomentumMatrix, Quantity::CentroidalMomentumMatrix),
        (C::FramePoses, Quantity::FramePoses),
        (C::FrameJacobianLocalWorldAligned, Quantity::FrameJacobianLocalWorldAligned),
        (C::FrameJacobianLocal, Quantity::FrameJacobianLocal),
        (C::FrameJacobianWorld, Quantity::FrameJacobianWorld),
        (C::InverseDynamicsDerivatives, Quantity::InverseDynamicsDerivatives),
        (C::ForwardDynamicsDerivatives, Quantity::ForwardDynamicsDerivatives),
        (C::GravityDerivative, Quantity::GravityDerivative),
    ];
    assert_eq!(rd_quantity_count() as usize, Quantity::ALL.len());
    assert_eq!(all.len(), Quantity::ALL.len());
    for (number, ((own, listed), quantity)) in all.into_iter().zip(Quantity::ALL).enumerate() {
        assert_eq!((own as usize, listed), (number, quantity));
        assert_eq!(text(rd_quantity_name(number as u32)), quantity.name());
        let (name, mut found) = (c(quantity.name()), u32::MAX);
        ok(rd!(rd_quantity_named(name.as_ptr(), &raw mut found)));
        assert_eq!(found as usize, number);
    }
    assert!(rd_quantity_name(all.len() as u32).is_null());
}

#[test]
fn table_gives_bits_of_library() {
    for robot in &robots() {
        let (model, state, ids) = (&robot.model, robot.state(1), frames(&robot.model));
        let (mut w, mut memory) = (Workspace::new(model), QuantityMemory::new(model));
        let last = ids.len() - 1;
        for (number, quantity) in Quantity::ALL.into_iter().enumerate() {
            let mut lengths = [0; 3];
            ok(rd!(rd_quantity_lengths(robot.workspace, number as u32, ids.len(), mut lengths)));
            let mut out = lengths.map(|length| vec![0.0; length]);
            let (inputs, results) = (inputs_of(quantity, &state, &[last as u32]), results_of(&mut out));
            ok(rd!(rd_compute(robot.workspace, number as u32, &raw const inputs, &raw const results)));
            let ids = [ids[last]];
            let inputs = Inputs { q: &state.q, v: &state.v, a: &state.a, tau: &state.tau, frames: &ids };
            quantity.compute(model, &mut w, &inputs, &mut memory);
            for (found, expected) in out.iter().zip(memory.results(quantity)) {
                same_bits(&format!("{} of {}", quantity.name(), robot.name), found, expected);
            }
            assert!(out[0].iter().any(|x| *x != 0.0), "{} of {}", quantity.name(), robot.name);
        }
    }
}

type OfState = unsafe extern "C" fn(WorkspaceHandle, *const f64, usize, *mut f64, usize) -> Status;
type OfMotion =
    unsafe extern "C" fn(WorkspaceHandle, *const f64, usize, *const f64, usize, *mut f64, usize) -> Status;

/// The results of the table by the library.
fn expected(robot: &Robot, quantity: Quantity, state: &RandomState) -> [Vec<f64>; 3] {
    let (mut w, mut memory) = (Workspace::new(&robot.model), QuantityMemory::new(&robot.model));
    let inputs = Inputs { q: &state.q, v: &state.v, a: &state.a, tau: &state.tau, frames: &[] };
    quantity.compute(&robot.model, &mut w, &inputs, &mut memory);
    memory.results(quantity).map(<[f64]>::to_vec)
}

#[test]
fn named_functions_give_bits_of_library() {
    let of_q: [(Quantity, OfState); 9] = [
        (Quantity::MassMatrix, rd_mass_matrix),
        (Quantity::InverseMassMatrix, rd_inverse_mass_matrix),
        (Quantity::MassMatrixFactor, rd_mass_matrix_factor),
        (Quantity::Gravity, rd_gravity),
        (Quantity::GravityDerivative, rd_gravity_derivative),
        (Quantity::CenterOfMass, rd_center_of_mass),
        (Quantity::CenterOfMassJacobian, rd_center_of_mass_jacobian),
        (Quantity::CentroidalMomentumMatrix, rd_centroidal_momentum_matrix),
        (Quantity::FramePoses, rd_frame_poses),
    ];
    let of_q_v: [(Quantity, OfMotion); 4] = [
        (Quantity::Bias, rd_bias),
        (Quantity::CoriolisMatrix, rd_coriolis_matrix),
        (Quantity::VelocityProduct, rd_velocity_product),
        (Quantity::Momentum, rd_momentum),
    ];
    for robot in &robots() {
        let (s, w) = (robot.state(2), robot.workspace);
        for (quantity, function) in of_q {
            let [expected, ..] = expected(robot, quantity, &s);
            let mut out = vec![0.0; expected.len()];
            ok(rd!(function(w, in s.q, mut out)));
            same_bits(quantity.name(), &out, &expected);
        }
        for (quantity, function) in of_q_v {
            let [expected, ..] = expected(robot, quantity, &s);
            let mut out = vec![0.0; expected.len()];
            ok(rd!(function(w, in s.q, in s.v, mut out)));
            same_bits(quantity.name(), &out, &expected);
        }
        let mut energies = [0.0; 2];
        ok(rd!(rd_kinetic_energy(w, in s.q, in s.v, &raw mut energies[0])));
        ok(rd!(rd_potential_energy(w, in s.q, &raw mut energies[1])));
        let mut own = Workspace::new(&robot.model);
        let kinetic = algorithms::kinetic_energy(&robot.model, &mut own, &s.q, &s.v);
        same_bits(
            "energies",
            &energies,
            &[kinetic, algorithms::potential_energy(&robot.model, &mut own, &s.q)],
        );
        let n = robot.model.nv();
        let (mut tau, mut a) = (vec![0.0; n], vec![0.0; n]);
        ok(rd!(rd_inverse_dynamics(w, in s.q, in s.v, in s.a, mut tau)));
        same_bits("tau", &tau, &expected(robot, Quantity::InverseDynamics, &s)[0]);
        ok(rd!(rd_forward_dynamics(w, in s.q, in s.v, in s.tau, mut a)));
        same_bits("a", &a, &expected(robot, Quantity::ForwardDynamics, &s)[0]);
        let [mut x, mut y, mut z] = [(); 3].map(|()| vec![0.0; n * n]);
        ok(rd!(rd_inverse_dynamics_derivatives(w, in s.q, in s.v, in s.a, mut x, mut y)));
        let by = expected(robot, Quantity::InverseDynamicsDerivatives, &s);
        same_bits("∂tau/∂q", &x, &by[0]);
        same_bits("∂tau/∂v", &y, &by[1]);
        ok(rd!(rd_forward_dynamics_derivatives(w, in s.q, in s.v, in s.tau, mut x, mut y, mut z)));
        let by = expected(robot, Quantity::ForwardDynamicsDerivatives, &s);
        for (name, found, expected) in [("q", &x, &by[0]), ("v", &y, &by[1]), ("tau", &z, &by[2])] {
            same_bits(&format!("∂a/∂{name}"), found, expected);
        }
    }
}

/// The states of a batch, one after another.
fn rows(robot: &Robot, states: usize) -> RandomState {
    let mut all = RandomState { q: Vec::new(), v: Vec::new(), a: Vec::new(), tau: Vec::new() };
    for state in (0..states).map(|seed| robot.state(100 + seed as u64)) {
        all.q.extend(state.q);
        all.v.extend(state.v);
        all.a.extend(state.a);
        all.tau.extend(state.tau);
    }
    all
}

#[test]
fn batches_give_bits_of_library() {
    const STATES: usize = 37;
    for robot in &robots() {
        let (model, all, ids) = (&robot.model, rows(robot, STATES), frames(&robot.model));
        for threads in [1, 2] {
            let mut batch = BatchHandle { id: 0 };
            ok(rd!(rd_batch_new(robot.handle, threads, &raw mut batch)));
            let mut options = BatchOptions::default();
            options.threads = threads;
            let mut own = BatchWorkspace::with_options(model, options).expect("threads");
            for (number, quantity) in Quantity::ALL.into_iter().enumerate() {
                let frame = if quantity == Quantity::FramePoses { &ids[..] } else { &ids[1..2] };
                let given = if quantity == Quantity::FramePoses { 0..ids.len() as u32 } else { 1..2 };
                let given: Vec<u32> = given.collect();
                let length =
                    |k: usize| quantity.results().get(k).map_or(0, |r| r.shape.len(model, frame.len()));
                let mut out = [0, 1, 2].map(|k| vec![0.0; STATES * length(k)]);
                let (inputs, results) = (inputs_of(quantity, &all, &given), results_of(&mut out));
                let number = number as u32;
                ok(rd!(rd_batch_compute(batch, number, STATES, &raw const inputs, &raw const results)));
                let read = |input, x| if quantity.reads(input) { x } else { &[][..] };
                let inputs = Inputs {
                    q: &all.q,
                    v: read(Input::Velocity, &all.v),
                    a: read(Input::Acceleration, &all.a),
                    tau: read(Input::Force, &all.tau),
                    frames: frame,
                };
                let mut expected = [0, 1, 2].map(|k| vec![0.0; STATES * length(k)]);
                let slices = expected.each_mut().map(|x| &mut x[..]);
                match quantity.compute_batch(model, &mut own, &inputs, slices) {
                    Some(done) => done.expect("valid states"),
                    None => one_by_one(robot, quantity, &inputs, &mut expected[0]),
                }
                for (found, expected) in out.iter().zip(&expected) {
                    same_bits(&format!("{} of {}", quantity.name(), robot.name), found, expected);
                }
            }
            ok(rd_batch_free(batch));
        }
    }
}

/// A quantity of several states, one after another.
fn one_by_one(robot: &Robot, quantity: Quantity, all: &Inputs<'_>, out: &mut [f64]) {
    let (mut w, mut memory) = (Workspace::new(&robot.model), QuantityMemory::new(&robot.model));
    let mut found = Vec::new();
    quantity.compute_each(&robot.model, &mut w, all, &mut memory, &mut |memory| {
        found.extend_from_slice(memory.results(quantity)[0]);
    });
    out.copy_from_slice(&found);
}

#[test]
fn motions_of_frames_give_bits_of_library() {
    let axes = [
        (ReferenceFrameC::LocalWorldAligned, ReferenceFrame::LocalWorldAligned),
        (ReferenceFrameC::Local, ReferenceFrame::Local),
        (ReferenceFrameC::World, ReferenceFrame::World),
    ];
    for robot in &robots() {
        let (s, model, n) = (robot.state(5), &robot.model, robot.model.nv());
        let (c, mut w) = (robot.workspace, Workspace::new(model));
        for (k, id) in frames(model).into_iter().enumerate() {
            let (k, mut pose) = (k as u32, [0.0; 12]);
            ok(rd!(rd_frame_pose(c, k, in s.q, mut pose)));
            same_bits("pose", &pose, &numbers(&algorithms::frame_pose(model, &mut w, &s.q, id)));
            for (number, reference) in axes {
                let (number, mut x, mut jacobian) = (number as u32, [0.0; 6], vec![0.0; 6 * n]);
                ok(rd!(rd_frame_velocity(c, k, number, in s.q, in s.v, mut x)));
                let twist = algorithms::frame_velocity(model, &mut w, &s.q, &s.v, id, reference);
                same_bits("velocity", &x, &[twist.linear, twist.angular].concat());
                ok(rd!(rd_frame_acceleration(c, k, number, in s.q, in s.v, in s.a, mut x)));
                let rate = algorithms::frame_acceleration(model, &mut w, &s.q, &s.v, &s.a, id, reference);
                same_bits("acceleration", &x, &[rate.linear, rate.angular].concat());
                ok(rd!(rd_frame_bias_acceleration(c, k, number, in s.q, in s.v, mut x)));
                let rate = algorithms::frame_bias_acceleration(model, &mut w, &s.q, &s.v, id, reference);
                same_bits("bias acceleration", &x, &[rate.linear, rate.angular].concat());
                ok(rd!(rd_frame_jacobian(c, k, number, in s.q, mut jacobian)));
                let mut own = vec![0.0; 6 * n];
                algorithms::frame_jacobian(model, &mut w, &s.q, id, reference, &mut own);
                same_bits("Jacobian", &jacobian, &own);
            }
        }
        let mut velocity = [0.0; 3];
        ok(rd!(rd_center_of_mass_velocity(c, in s.q, in s.v, mut velocity)));
        same_bits("ċ", &velocity, &algorithms::center_of_mass_velocity(model, &mut w, &s.q, &s.v));
        let count = rd_inertial_parameter_count(c);
        let (mut parameters, mut regressor) = (vec![0.0; count], vec![0.0; n * count]);
        ok(rd!(rd_inertial_parameters(c, mut parameters)));
        same_bits("p", &parameters, &algorithms::inertial_parameters(model));
        ok(rd!(rd_joint_torque_regressor(c, in s.q, in s.v, in s.a, mut regressor)));
        let mut own = vec![0.0; n * count];
        algorithms::joint_torque_regressor(model, &mut w, &s.q, &s.v, &s.a, &mut own);
        same_bits("Y", &regressor, &own);
        let [mut found, mut own] = [(); 2].map(|()| vec![0.0; 6 * model.joints().len()]);
        ok(rd!(rd_joint_reactions(c, in s.q, in s.v, in s.a, mut found)));
        algorithms::joint_reactions(model, &mut w, &s.q, &s.v, &s.a, &[], &mut own);
        same_bits("reactions", &found, &own);
    }
}

#[test]
fn configuration_space_gives_bits_of_library() {
    for robot in &robots() {
        let (h, own, [s, t]) = (robot.handle, &robot.model, [8, 9].map(|seed| robot.state(seed)));
        let [mut q, mut expected] = [(); 2].map(|()| vec![0.0; own.nq()]);
        ok(rd!(rd_neutral(h, mut q)));
        same_bits("neutral", &q, &model::neutral(own));
        ok(rd!(rd_random_configuration(h, 77, mut q)));
        same_bits("random", &q, &model::random_within_limits(own, &mut SplitMix64::new(77)));
        ok(rd!(rd_integrate(h, in s.q, in s.v, mut q)));
        model::integrate(own, &s.q, &s.v, &mut expected);
        same_bits("q ⊕ v", &q, &expected);
        let [mut v, mut difference] = [(); 2].map(|()| vec![0.0; own.nv()]);
        ok(rd!(rd_difference(h, in s.q, in t.q, mut v)));
        model::difference(own, &s.q, &t.q, &mut difference);
        same_bits("q1 ⊖ q0", &v, &difference);
        ok(rd!(rd_interpolate(h, in s.q, in t.q, 0.3, mut q)));
        model::interpolate(own, &s.q, &t.q, 0.3, &mut expected);
        same_bits("between", &q, &expected);
        let mut long: Vec<f64> = s.q.iter().map(|x| 2.0 * x).collect();
        expected.copy_from_slice(&long);
        ok(rd!(rd_normalize(h, mut long)));
        model::normalize_quaternions(own, &mut expected);
        same_bits("normalized", &long, &expected);
    }
    let robot = Robot::load("robots/arm.xml", false);
    let (mut q, mut v) = (vec![1.0; robot.model.nq()], vec![1.0; robot.model.nv()]);
    ok(rd!(rd_named_pose(robot.handle, c"home".as_ptr(), mut q, mut v)));
    let (pose, velocity) = robot.model.named_pose("home").expect("a pose");
    same_bits("home", &q, &pose);
    same_bits("home at rest", &v, &velocity);
    assert_eq!(text(rd_model_pose_name(robot.handle, 0)), "home");
}

#[test]
fn linearized_steps_give_bits_of_library() {
    for robot in &robots() {
        let (s, model, n) = (robot.state(6), &robot.model, robot.model.nv());
        for integrator in [Integrator::RungeKutta4, Integrator::SemiImplicitEuler] {
            for dissipation in [false, true] {
                let name = c(&integrator.to_string());
                let [mut a, mut own_a] = [(); 2].map(|()| vec![0.0; 4 * n * n]);
                let [mut b, mut own_b] = [(); 2].map(|()| vec![0.0; 2 * n * n]);
                let (w, lossy) = (robot.workspace, i32::from(dissipation));
                ok(rd!(rd_linearize_step(
                    w, name.as_ptr(), 1e-3, lossy, in s.q, in s.v, in s.tau, mut a, mut b
                )));
                let mut memory = LinearizeStepWorkspace::new(model);
                let (forces, state) = (StepForces::new(&s.tau, dissipation), RobotState { q: &s.q, v: &s.v });
                let out = LinearizedStep { by_state: &mut own_a, by_force: &mut own_b };
                linearize_step(model, integrator, &mut memory, &forces, 1e-3, state, out).expect("a step");
                same_bits("A", &a, &own_a);
                same_bits("B", &b, &own_b);
            }
        }
    }
}
