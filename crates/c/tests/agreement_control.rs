//! Control, identification and optimal control give the bits of the library's calls in Rust.
//!
//! Unsafe code: the interface takes pointers. Each call passes slices of this program.
#![allow(unsafe_code)]
// Numbers of frames and seeds are small.
#![allow(clippy::cast_possible_truncation)]

#[macro_use]
mod common;

use std::ptr::null;
use std::sync::Arc;

use common::{Robot, ok, robots, same_bits, text};
use nalgebra::DMatrix;
use robot_dynamics::algorithms::{self, ReferenceFrame, SpatialAcceleration, Twist};
use robot_dynamics::control::identification::{
    BaseParameters, ConsistentOptions, JointTerm, JointTermKind, MotionRecord, identify_consistent,
};
use robot_dynamics::control::optimal::{
    ActuationMatrix, CenterOfMassResidual, ControlBounds, ControlResidual, Cost, Fddp, FddpOptions,
    FramePlacementResidual, FrameTranslationResidual, FrameVelocityResidual, Mpc, MpcOptions, Problem,
    SimulationStep, SmoothStep, StateResidual, StateSpace,
};
use robot_dynamics::control::{
    ComputedTorque, FrameTarget, InverseKinematicsOptions, MomentumObserver, PoseReference, Reference,
    TaskControl, TaskGains, TaskReference, dlqr, inverse_kinematics,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{FrameId, Workspace, neutral};
use robot_dynamics::simulation::{Controller, Integrator};
use robot_dynamics_c::control::observer::*;
use robot_dynamics_c::control::task::*;
use robot_dynamics_c::control::*;
use robot_dynamics_c::identification::*;
use robot_dynamics_c::inverse_kinematics::*;
use robot_dynamics_c::load::rd_model_free;
use robot_dynamics_c::model::{ModelHandle, rd_model_mass};
use robot_dynamics_c::optimal::mpc::*;
use robot_dynamics_c::optimal::solution::*;
use robot_dynamics_c::optimal::*;
use robot_dynamics_c::simulation::*;

/// The last frame of a robot: its number and its id.
fn tip(robot: &Robot) -> (u32, FrameId) {
    let last = robot.model.frames().len() - 1;
    (last as u32, robot.model.frame(&robot.model.frames()[last].name).expect("a frame"))
}

fn numbers(pose: &Pose) -> [f64; 12] {
    let all: Vec<f64> = pose.rotation.iter().flatten().chain(&pose.translation).copied().collect();
    all.try_into().expect("twelve numbers")
}

#[test]
fn inverse_kinematics_gives_bits_of_library() {
    let robot = Robot::load("robots/panda.urdf", false);
    let (number, id) = tip(&robot);
    let (model, mut w) = (&robot.model, Workspace::new(&robot.model));
    let goal = [0.3, -0.5, 0.2, -1.9, 0.1, 1.6, 0.4];
    let pose = algorithms::frame_pose(model, &mut w, &goal, id);
    let (twelve, start) = (numbers(&pose), [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8]);
    for (target, own) in
        [(&twelve[..], FrameTarget::Pose(pose)), (&twelve[9..], FrameTarget::Position(pose.translation))]
    {
        for seed in [0, 5] {
            let mut report = InverseKinematicsReportC::default();
            let options = InverseKinematicsOptionsC {
                position_tolerance: 1e-8,
                max_iterations: 60,
                seed,
                ..InverseKinematicsOptionsC::default()
            };
            let (mut q, o, r) = ([0.0; 7], &raw const options, &raw mut report);
            ok(rd!(rd_inverse_kinematics(robot.workspace, number, in target, in start, o, mut q, r)));
            let mut options = InverseKinematicsOptions::default();
            (options.position_tolerance, options.max_iterations, options.seed) = (1e-8, 60, seed);
            let found = inverse_kinematics(model, &mut w, id, own, &start, &options).expect("a solution");
            same_bits("q", &q, &found.q);
            same_bits("error", &[report.position_error], &[found.position_error]);
            assert_eq!((report.iterations, report.restarts), (found.iterations, found.restarts));
        }
    }
}

#[test]
fn computed_torque_gives_bits_of_library() {
    for robot in &robots() {
        let (n, s, target) = (robot.model.nv(), robot.state(1), robot.state(2));
        let (kp, kd) = (vec![30.0; n], vec![4.0; n]);
        for dissipation in [false, true] {
            let mut handle = ComputedTorqueHandle { id: 0 };
            let lossy = i32::from(dissipation);
            ok(rd!(rd_computed_torque_new(robot.handle, in kp, in kd, lossy, &raw mut handle)));
            ok(rd!(rd_computed_torque_set_reference(handle, in target.q, in target.v, in target.a)));
            let [mut tau, mut expected] = [(); 2].map(|()| vec![0.0; n]);
            ok(rd!(rd_computed_torque_torque(handle, in s.q, in s.v, mut tau)));
            let (q, v, a) = (target.q.clone(), target.v.clone(), target.a.clone());
            let reference = move |_: f64| Reference { q: q.clone(), v: v.clone(), a: a.clone() };
            let mut law = ComputedTorque::new(&robot.model, reference, &kp, &kd).expect("gains");
            if dissipation {
                law = law.with_dissipation();
            }
            law.torque(0.0, &s.q, &s.v, &mut expected).expect("a torque");
            same_bits(&robot.name, &tau, &expected);
            ok(rd_computed_torque_free(handle));
        }
    }
}

#[test]
fn task_control_gives_bits_of_library() {
    let robot = Robot::load("robots/panda.urdf", false);
    let (s, posture, (number, id)) = (robot.state(3), neutral(&robot.model), tip(&robot));
    let pose = algorithms::frame_pose(&robot.model, &mut Workspace::new(&robot.model), &robot.state(4).q, id);
    let (v, a) = ([0.1, 0.2, 0.3, 0.4, 0.5, 0.6], [0.6, 0.5, 0.4, 0.3, 0.2, 0.1]);
    let half = |x: [f64; 6], k: usize| [x[k], x[k + 1], x[k + 2]];
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 3.0 };
    let reference = PoseReference {
        pose,
        velocity: Twist { linear: half(v, 0), angular: half(v, 3) },
        acceleration: SpatialAcceleration { linear: half(a, 0), angular: half(a, 3) },
    };
    let point = TaskReference { position: pose.translation, velocity: half(v, 0), acceleration: half(a, 0) };
    for has_orientation in [false, true] {
        let (mut handle, kind) = (TaskControlHandle { id: 0 }, i32::from(has_orientation));
        ok(rd!(rd_task_control_new(
            robot.handle, number, kind, 100.0, 20.0, 3.0, in posture, 7.0, &raw mut handle
        )));
        let twelve = numbers(&pose);
        let target = if has_orientation { &twelve[..] } else { &twelve[9..] };
        ok(rd!(rd_task_control_set_target(handle, in target, in v, in a)));
        let [mut tau, mut expected] = [(); 2].map(|()| vec![0.0; robot.model.nv()]);
        ok(rd!(rd_task_control_torque(handle, in s.q, in s.v, mut tau)));
        if has_orientation {
            let law = TaskControl::new(&robot.model, id, |_: f64| reference, gains).expect("gains");
            let mut law = law.with_posture(&posture, 7.0).expect("a posture");
            law.torque(0.0, &s.q, &s.v, &mut expected).expect("a torque");
        } else {
            let law = TaskControl::new(&robot.model, id, |_: f64| point, gains).expect("gains");
            let mut law = law.with_posture(&posture, 7.0).expect("a posture");
            law.torque(0.0, &s.q, &s.v, &mut expected).expect("a torque");
        }
        same_bits("tau", &tau, &expected);
        ok(rd_task_control_free(handle));
    }
}

#[test]
fn observer_gives_bits_of_library() {
    for robot in &robots() {
        let (n, mut handle) = (robot.model.nv(), MomentumObserverHandle { id: 0 });
        let gains = vec![25.0; n];
        ok(rd!(rd_momentum_observer_new(robot.handle, in gains, 1, &raw mut handle)));
        let own = MomentumObserver::new(&robot.model, &gains).expect("gains");
        let mut own = own.with_dissipation();
        let mut torques = vec![0.0; n];
        for round in 0..2 {
            for sample in 0..4 {
                let s = robot.state(sample);
                ok(rd!(rd_momentum_observer_update(handle, in s.q, in s.v, in s.tau, 1e-3, mut torques)));
                same_bits("torques", &torques, own.update(&s.q, &s.v, &s.tau, 1e-3).expect("a sample"));
            }
            assert!(torques.iter().any(|tau| *tau != 0.0), "round {round}");
            ok(rd_momentum_observer_reset(handle));
            own.reset();
        }
        ok(rd_momentum_observer_free(handle));
    }
}

#[test]
fn regulator_gives_bits_of_library() {
    let (a, b) = ([1.0, 0.1, -0.2, 0.9], [0.0, 0.3, 0.1, 0.2]);
    let (q, r) = ([1.0, 0.0, 0.0, 0.1], [0.01, 0.0, 0.0, 0.02]);
    let (mut gain, mut radius) = ([0.0; 4], 0.0);
    let of = |x: &[f64; 4]| x.as_ptr();
    ok(rd!(rd_dlqr(2, 2, of(&a), of(&b), of(&q), of(&r), mut gain, &raw mut radius)));
    let matrix = |x: &[f64]| DMatrix::from_row_slice(2, 2, x);
    let own = dlqr(&matrix(&a), &matrix(&b), &matrix(&q), &matrix(&r)).expect("a gain");
    let rows: Vec<f64> = own.gain.transpose().iter().copied().collect();
    same_bits("K", &gain, &rows);
    same_bits("radius", &[radius], &[own.spectral_radius]);
    assert!(radius < 1.0);
}

#[test]
fn identification_gives_bits_of_library() {
    let robot = Robot::load("robots/dual_arm.urdf", false);
    let (model, n, mut handle) = (&robot.model, robot.model.nv(), MotionRecordHandle { id: 0 });
    let bits = RD_TERM_DAMPING | RD_TERM_FRICTION;
    ok(rd!(rd_motion_record_new(robot.handle, 1, bits, &raw mut handle)));
    let noise = vec![0.05; n];
    ok(rd!(rd_motion_record_set_noise(handle, in noise)));
    let terms = JointTerm::of_all(model, &[JointTermKind::Damping, JointTermKind::Friction]);
    let record = MotionRecord::new(model, true).with_terms(&terms).expect("terms");
    let mut record = record.with_noise(&noise).expect("noise");
    for seed in 0..40 {
        let mut s = robot.state(seed);
        algorithms::inverse_dynamics(model, &mut Workspace::new(model), &s.q, &s.v, &s.a, &mut s.tau);
        s.tau[seed as usize % n] += 0.03;
        ok(rd!(rd_motion_record_push(handle, in s.q, in s.v, in s.a, in s.tau)));
        record.push(&s.q, &s.v, &s.a, &s.tau).expect("a sample");
    }
    let names = record.parameter_names();
    let count = rd_motion_record_parameter_count(handle);
    let found: Vec<String> = (0..count).map(|k| text(rd_motion_record_parameter_name(handle, k))).collect();
    assert_eq!(found, names);
    let (base, mut residual, mut size) = (BaseParameters::of_record(&record), 0.0, 0);
    let own = base.identify(&record).expect("an estimate");
    let (mut indices, [mut values, mut deviations]) = (vec![0; count], [(); 2].map(|()| vec![0.0; count]));
    let (i, v, d) = (indices.as_mut_ptr(), values.as_mut_ptr(), deviations.as_mut_ptr());
    ok(rd!(rd_identify(handle, i, v, d, count, &raw mut size, &raw mut residual)));
    assert_eq!(size, base.len());
    let numbers: Vec<usize> = indices[..size].iter().map(|index| *index as usize).collect();
    assert_eq!(numbers, base.parameters.iter().map(|parameter| parameter.index).collect::<Vec<_>>());
    same_bits("values", &values[..size], own.values.as_slice());
    same_bits("deviations", &deviations[..size], own.standard_deviations.as_slice());
    same_bits("residual", &[residual], &[own.residual]);
    assert!(residual > 0.0);

    let (mut parameters, mut estimated) = (vec![0.0; count], ModelHandle { id: 0 });
    let (r, m) = (&raw mut residual, &raw mut estimated);
    ok(rd!(rd_identify_consistent(handle, 1e-3, mut parameters, r, m)));
    let own = identify_consistent(&record, &ConsistentOptions::new(1e-3)).expect("an estimate");
    same_bits("parameters", &parameters, &own.parameters);
    same_bits("residual", &[residual], &[own.residual]);
    let mass =
        robot_dynamics::model::Model::new(own.description(model).expect("a robot")).expect("a model").mass();
    same_bits("mass", &[rd_model_mass(estimated)], &[mass]);
    ok(rd_model_free(estimated));
    ok(rd_motion_record_free(handle));
}

/// The costs of the tests: by handle, and at the running and the last nodes.
fn costs(robot: &Robot, problem: ProblemHandle, nodes: usize, controls: usize) -> [Cost; 2] {
    let (model, (number, id)) = (Arc::new(robot.model.clone()), tip(robot));
    let (space, n, nv) = (StateSpace::robot(model.clone()), nodes, robot.model.nv());
    let rest = [neutral(&robot.model), vec![0.0; nv]].concat();
    let goal = algorithms::frame_pose(&robot.model, &mut Workspace::new(&robot.model), &robot.state(4).q, id);
    let (twelve, zero, still) = (numbers(&goal), vec![0.0; controls], [0.0; 6]);
    let add = |kind: CostKindC, first: usize, end: usize, target: &[f64], weights: &[f64]| {
        ok(rd!(rd_problem_add_cost(problem, kind as u32, first, end, number, in target, in weights)));
    };
    add(CostKindC::State, 0, n + 1, &rest, &vec![0.1; 2 * nv]);
    add(CostKindC::Control, 0, n, &zero, &vec![0.01; controls]);
    add(CostKindC::FramePosition, n, n + 1, &twelve[9..], &[10.0; 3]);
    add(CostKindC::FramePose, n, n + 1, &twelve, &[1.0; 6]);
    add(CostKindC::FrameVelocity, n, n + 1, &still, &[0.2; 6]);
    add(CostKindC::CenterOfMass, 0, n, &[0.1, 0.2, 0.3], &[0.5; 3]);
    let (mut running, mut terminal) = (Cost::new(), Cost::new());
    let state = || StateResidual::new(&space, &rest).expect("a state");
    running.add(state(), vec![0.1; 2 * nv]).expect("weights");
    running.add(ControlResidual::new(&zero).expect("controls"), vec![0.01; controls]).expect("weights");
    let center = CenterOfMassResidual::new(model.clone(), [0.1, 0.2, 0.3]).expect("a target");
    running.add(center, vec![0.5; 3]).expect("weights");
    terminal.add(state(), vec![0.1; 2 * nv]).expect("weights");
    let reach = FrameTranslationResidual::new(model.clone(), id, goal.translation).expect("a target");
    terminal.add(reach, vec![10.0; 3]).expect("weights");
    terminal
        .add(FramePlacementResidual::new(model.clone(), id, goal).expect("a target"), vec![1.0; 6])
        .expect("ok");
    let axes = ReferenceFrame::LocalWorldAligned;
    let stop = FrameVelocityResidual::new(model, id, axes, still).expect("a target");
    terminal.add(stop, vec![0.2; 6]).expect("weights");
    [running, terminal]
}

/// Solves the problem and runs the controller, by handle and by value.
fn same_solutions(robot: &Robot, handle: ProblemHandle, mut own: Problem, x0: &[f64]) {
    let (nodes, controls) = (own.nodes(), own.controls(0));
    assert_eq!(rd_problem_control_count(handle), controls);
    let (lower, upper) = (vec![-20.0; controls], vec![20.0; controls]);
    ok(rd!(rd_problem_set_control_bounds(handle, 0, nodes, in lower, in upper)));
    own.set_control_bounds(0..nodes, ControlBounds::new(&lower, &upper).expect("bounds")).expect("bounds");
    let [running, terminal] = costs(robot, handle, nodes, controls);
    own.set_running_cost(0..nodes, running).expect("a cost");
    own.set_terminal_cost(terminal).expect("a cost");
    let (mut report, options) =
        (SolverReportC::default(), SolverOptionsC { threads: 1, ..Default::default() });
    ok(rd!(rd_problem_solve(handle, &raw const options, &raw mut report)));
    let mut solver = Fddp::new(own.clone(), FddpOptions::default()).expect("options");
    let found = solver.solve().expect("a solution");
    assert_eq!((report.iterations, report.is_solved != 0), (found.iterations, found.is_solved()));
    same_bits(
        "report",
        &[report.cost, report.defect, report.gradient],
        &[found.cost, found.defect, found.gradient],
    );
    for node in 0..=nodes {
        let mut x = vec![0.0; x0.len()];
        ok(rd!(rd_problem_state(handle, node, mut x)));
        same_bits("x", &x, solver.state(node));
        if node < nodes {
            let (mut u, mut gain) = (vec![0.0; controls], vec![0.0; controls * 2 * robot.model.nv()]);
            ok(rd!(rd_problem_control(handle, node, mut u)));
            ok(rd!(rd_problem_gain(handle, node, mut gain)));
            same_bits("u", &u, solver.control(node));
            same_bits("K", &gain, solver.gain(node));
        }
    }
    let mut mpc = MpcHandle { id: 0 };
    ok(rd!(rd_mpc_new(handle, null(), 3, 0.0, &raw mut mpc)));
    let mut options = MpcOptions::default();
    options.iterations = 3;
    let mut own = Mpc::new(own, options).expect("options");
    let mut u = vec![0.0; controls];
    for period in 0..4 {
        let mut x = x0.to_vec();
        x[0] += 0.01 * f64::from(period);
        ok(rd!(rd_mpc_step(mpc, in x, mut u)));
        same_bits("u of a period", &u, own.step(&x).expect("controls"));
    }
    let mut times = MpcTimesC::default();
    ok(rd!(rd_mpc_times(mpc, &raw mut times)));
    assert_eq!(times.periods, own.times().periods);
    ok(rd_mpc_set_costs(mpc, handle));
    ok(rd_mpc_free(mpc));
    ok(rd_problem_free(handle));
}

#[test]
fn optimal_control_gives_bits_of_library() {
    let robot = Robot::load("robots/three_r.urdf", false);
    let (model, integrator) = (Arc::new(robot.model.clone()), Integrator::SemiImplicitEuler);
    let x0 = [neutral(&robot.model), vec![0.0; robot.model.nv()]].concat();
    let (name, mut handle) = (common::c(&integrator.to_string()), ProblemHandle { id: 0 });
    ok(rd!(rd_problem_new(robot.handle, name.as_ptr(), 0.02, 1, 12, in x0, &raw mut handle)));
    let step = SmoothStep::new(model.clone(), integrator, 0.02).expect("a step");
    let step = step.with_actuation(ActuationMatrix::actuated(&model)).expect("motors").with_dissipation(true);
    same_solutions(&robot, handle, Problem::new(step, &x0, 12).expect("a problem"), &x0);
}

#[test]
fn optimal_control_of_simulations_gives_bits_of_library() {
    let robot = Robot::load("robots/three_r.urdf", false);
    let x0 = [neutral(&robot.model), vec![0.0; robot.model.nv()]].concat();
    let options = SimulationOptionsC { dt: 0.02, method: c"implicit".as_ptr(), ..Default::default() };
    let (mut simulation, mut handle) = (SimulationHandle { id: 0 }, ProblemHandle { id: 0 });
    ok(rd!(rd_simulation_new(robot.handle, &raw const options, &raw mut simulation)));
    ok(rd!(rd_problem_from_simulation(simulation, 0, 8, in x0, &raw mut handle)));
    let method = "implicit".parse().expect("a method");
    let own = robot_dynamics::simulation(&robot.model).dt(0.02).method(method).build().expect("a simulation");
    let step = SimulationStep::new(&own);
    let step = step.with_actuation(ActuationMatrix::actuated(own.model())).expect("motors");
    same_solutions(&robot, handle, Problem::new(step, &x0, 8).expect("a problem"), &x0);
    ok(rd_simulation_free(simulation));
}
