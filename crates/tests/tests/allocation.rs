//! Calls that take a workspace do not allocate memory.
//!
//! Unsafe code: counting needs a global allocator, and `GlobalAlloc` is an unsafe trait. This allocator
//! counts each request and passes it to the system's allocator. It exists in this test program only.
#![allow(unsafe_code)]

#[path = "../../verification/tests/common/mod.rs"]
mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use common::{Robot, chain, families};
use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::{FrameWrench, ReferenceFrame};
use robot_dynamics::batch::{BatchOptions, BatchWorkspace};
use robot_dynamics::constraints::FrameConstraint;
use robot_dynamics::contact::{ContactSet, Ground, HeightField};
use robot_dynamics::control::identification::PayloadEstimator;
use robot_dynamics::control::online_motion::{OnlineLimits, OnlineMotion};
use robot_dynamics::control::optimal::{
    ControlBounds, ControlResidual, Cost, Fddp, FddpOptions, FrameTranslationResidual, Problem, SmoothStep,
    StateResidual,
};
use robot_dynamics::control::task_kinematics::{
    CollisionAvoidance, KinematicObjective, KinematicTask, TaskKinematics,
};
use robot_dynamics::control::whole_body::{
    ContactGeometry, HeldContact, Objective, PdGains, WholeBodyControl,
};
use robot_dynamics::control::{
    Admittance, ControlAllocation, ImpedanceControl, ImpedanceGains, MomentumObserver, OperationalSpace,
    OperationalSpaceInputs, OperationalSpaceWorkspace, PoseReference, Reference, TaskControl, TaskGains,
    TaskReference,
};
use robot_dynamics::derivatives::LinearizeStepWorkspace;
use robot_dynamics::description::{
    ActuatorDescription, Base, JointDescription, JointKind, JointKinds, LinkDescription, LinkShape,
    MassProperties, Pose, RandomRobotOptions, RobotDescription, SensorDescription, SensorKind, SensorObject,
    Shape, ShapeRole, Transmission, random_robot,
};
use robot_dynamics::model::{FrameId, Model, RandomState, Workspace};
use robot_dynamics::number::Dual;
use robot_dynamics::quantity::{Inputs, Quantity, QuantityMemory};
use robot_dynamics::simulation::{
    ConstantTorque, Controller, Effect, GravityAt, GravityCompensatedPd, ImplicitIntegrator, Integrator,
    Method, PointForce, RunOptions, SensorInputs, SensorSet, Simulation, SimulationBuilder, StepForces,
    StepWorkspace, Stepper,
};
use robot_dynamics::{batch, with_native_code};

struct Counting;

thread_local! {
    /// Number of requests by this thread; tests run in parallel.
    static REQUESTS: Cell<usize> = const { Cell::new(0) };
    /// Number of bytes requested.
    static BYTES: Cell<usize> = const { Cell::new(0) };
}

fn count(size: usize) {
    // This fails only while a thread is being torn down; nothing is measured then.
    let _ = REQUESTS.try_with(|requests| requests.set(requests.get() + 1));
    let _ = BYTES.try_with(|bytes| bytes.set(bytes.get() + size));
}

// SAFETY: every method hands its arguments to `System` unchanged and returns what it returns.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size);
        unsafe { System.realloc(pointer, layout, size) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The number of requests for memory that a call makes.
fn allocations<T>(call: impl FnOnce() -> T) -> usize {
    let before = REQUESTS.get();
    black_box(call());
    REQUESTS.get() - before
}

/// A floating tree with all kinds of joints, a tree with mimic joints, and a large tree.
fn robots() -> Vec<Robot> {
    let families = families();
    let one_of = |name: &str| families.iter().find(|f| f.name == name).unwrap().robots().next().unwrap();
    ["floating trees", "mimic joints", "large", "single-coordinate trees with massless links"]
        .map(one_of)
        .into()
}

#[test]
fn allocations_are_counted() {
    assert_eq!(allocations(|| 1 + 1), 0);
    assert_eq!(allocations(|| vec![1.0; 10]), 1);
    let mut grown = Vec::with_capacity(1);
    grown.push(1);
    assert_eq!(allocations(|| grown.push(2)), 1);
}

/// Every row of the table of quantities.
#[test]
fn quantities_allocate_nothing() {
    for robot in robots() {
        let Robot { model, state, .. } = &robot;
        let frames = [model.frame("frame0").unwrap()];
        let inputs = Inputs { q: &state.q, v: &state.v, a: &state.a, tau: &state.tau, frames: &frames };
        let (mut w, mut memory) = (Workspace::new(model), QuantityMemory::new(model));
        for quantity in Quantity::ALL {
            let count = allocations(|| quantity.compute(model, &mut w, &inputs, &mut memory));
            assert_eq!(count, 0, "{} allocates on \"{}\"", quantity.name(), robot.family);
        }
    }
}

/// The first call of a function compiles its machine code. Later calls do not allocate, for one state and for
/// batches.
#[test]
fn machine_code_allocates_in_first_call_only() {
    for robot in robots() {
        let model = &with_native_code(robot.model.clone());
        let frames = [model.frame("frame0").unwrap()];
        let RandomState { q, v, a, tau } = &robot.state;
        let inputs = Inputs { q, v, a, tau, frames: &frames };
        let (mut w, mut memory) = (Workspace::new(model), QuantityMemory::new(model));
        for quantity in Quantity::ALL {
            quantity.compute(model, &mut w, &inputs, &mut memory);
            let count = allocations(|| quantity.compute(model, &mut w, &inputs, &mut memory));
            assert_eq!(count, 0, "{} allocates on \"{}\"", quantity.name(), robot.family);
        }
        let (mut jacobian, frame) = (vec![0.0; 6 * model.nv()], frames[0]);
        let mut call = || {
            robot_dynamics::algorithms::frame_jacobian(
                model,
                &mut w,
                q,
                frame,
                ReferenceFrame::World,
                &mut jacobian,
            );
            robot_dynamics::algorithms::frame_pose(model, &mut w, q, frame)
        };
        call();
        assert_eq!(allocations(call), 0, "a frame allocates on \"{}\"", robot.family);
        let (mut options, zeros) = (BatchOptions::default(), vec![0.0; model.nv()]);
        let [mut r, mut x, mut y, mut z] = [(); 4].map(|()| zeros.clone());
        let mut call = || {
            let out = robot_dynamics::derivatives::InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: &mut [],
            };
            robot_dynamics::derivatives::inverse_dynamics_pullback(model, &mut w, q, v, a, tau, out);
            let out = robot_dynamics::derivatives::ForwardPullbackMut {
                acceleration: &mut r,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: &mut [],
            };
            robot_dynamics::derivatives::forward_dynamics_pullback(model, &mut w, q, v, tau, a, out);
        };
        call();
        assert_eq!(allocations(call), 0, "a pullback allocates on \"{}\"", robot.family);
        options.threads = 1;
        let w = &mut BatchWorkspace::<f64>::with_options(model, options).unwrap();
        let (mut force, mut end) = (zeros.clone(), (q.clone(), zeros.clone()));
        let how = batch::Rollout::new(Integrator::SemiImplicitEuler, 1e-6, 3);
        let mut call = || {
            let (q, v) = (&mut end.0, &mut end.1);
            let of_frame = batch::frame_jacobian(model, w, q, frame, ReferenceFrame::Local, &mut jacobian);
            let bad = of_frame
                .and_then(|()| batch::inverse_dynamics(model, w, q, v, a, &mut force))
                .and_then(|()| {
                    let out = batch::InversePullbackMut {
                        by_position: &mut x,
                        by_velocity: &mut y,
                        by_acceleration: &mut z,
                        parameters: &mut [],
                    };
                    batch::inverse_dynamics_pullback(model, w, q, v, a, tau, out)
                })
                .and_then(|()| {
                    let out = batch::ForwardPullbackMut {
                        acceleration: &mut r,
                        by_position: &mut x,
                        by_velocity: &mut y,
                        by_force: &mut z,
                        parameters: &mut [],
                    };
                    batch::forward_dynamics_pullback(model, w, q, v, tau, a, out)
                });
            let ended =
                batch::rollout(model, w, &how, batch::Torques::Zero, batch::RolloutStates::ends(q, v), None);
            (bad.is_ok(), ended.is_ok())
        };
        assert_eq!(call(), (true, true), "{}", robot.family);
        assert_eq!(allocations(call), 0, "a batch allocates on \"{}\"", robot.family);
    }
}

/// The calls that the table of quantities does not have, one a line.
#[test]
fn hot_calls_allocate_nothing() {
    for robot in robots() {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, tau) = (&state.q[..], &state.v[..], &state.a[..], &state.tau[..]);
        let (nv, frame) = (model.nv(), model.frame("frame0").unwrap());
        let w = &mut Workspace::new(model);
        let (x, m) = (&mut vec![0.0; nv][..], &mut vec![0.0; nv * nv][..]);
        let symbols = &mut vec![0.0; nv * nv * nv][..];
        let wrench = [FrameWrench { frame, force_in_frame: [1.0, 2.0, 3.0], moment_in_frame: [0.1; 3] }];
        let dual = &mut Workspace::<Dual<f64, 1>>::new(model);
        let nothing = |call: &str, count: usize| {
            assert_eq!(count, 0, "{call} allocates on \"{}\" (nv = {nv})", robot.family);
        };

        nothing("mass_rank", allocations(|| robot_dynamics::algorithms::mass_rank(model, w, q)));
        nothing("check_rank", allocations(|| robot_dynamics::algorithms::check_rank(model, w, q).unwrap()));
        nothing(
            "mass_matrix_rate",
            allocations(|| robot_dynamics::algorithms::mass_matrix_rate(model, dual, q, v, m)),
        );
        let call =
            || robot_dynamics::algorithms::inverse_dynamics_with_wrenches(model, w, q, v, a, &wrench, x);
        nothing("inverse_dynamics_with_wrenches", allocations(call));
        nothing("dissipation", allocations(|| robot_dynamics::algorithms::dissipation(model, v, x)));
        let call = || robot_dynamics::algorithms::forward_dynamics_by_cholesky(model, w, q, v, tau, x);
        nothing("forward_dynamics_by_cholesky", allocations(call));
        let call =
            || robot_dynamics::algorithms::forward_dynamics_with_wrenches(model, w, q, v, tau, &wrench, x);
        nothing("forward_dynamics_with_wrenches", allocations(call));
        nothing(
            "christoffel_symbols",
            allocations(|| robot_dynamics::algorithms::christoffel_symbols(model, w, q, symbols)),
        );
        nothing("frame_pose", allocations(|| robot_dynamics::algorithms::frame_pose(model, w, q, frame)));
        for seen in ReferenceFrame::ALL {
            let call = || robot_dynamics::algorithms::frame_velocity(model, w, q, v, frame, seen);
            nothing("frame_velocity", allocations(call));
            let call = || robot_dynamics::algorithms::frame_acceleration(model, w, q, v, a, frame, seen);
            nothing("frame_acceleration", allocations(call));
            let call = || robot_dynamics::algorithms::frame_bias_acceleration(model, w, q, v, frame, seen);
            nothing("frame_bias_acceleration", allocations(call));
        }
        nothing(
            "center_of_mass_velocity",
            allocations(|| robot_dynamics::algorithms::center_of_mass_velocity(model, w, q, v)),
        );
        nothing(
            "centroidal_momentum",
            allocations(|| robot_dynamics::algorithms::centroidal_momentum(model, w, q, v)),
        );
        let call = || robot_dynamics::algorithms::centroidal_momentum_rate(model, w, q, v, a);
        nothing("centroidal_momentum_rate", allocations(call));
        let reactions = &mut vec![0.0; 6 * model.joints().len()][..];
        let call = || robot_dynamics::algorithms::joint_reactions(model, w, q, v, a, &wrench, reactions);
        nothing("joint_reactions", allocations(call));
    }
}

/// Every kind of sensor that a random robot can have.
#[test]
fn sensors_allocate_nothing() {
    for robot in robots() {
        let mut description = robot.model.description().clone();
        let link = robot.model.joints()[0].child_link.clone();
        let of_robot = [SensorKind::Clock, SensorKind::KineticEnergy, SensorKind::PotentialEnergy];
        let of_frame = [
            SensorKind::Accelerometer,
            SensorKind::Force,
            SensorKind::Torque,
            SensorKind::Touch,
            SensorKind::FrameQuaternion,
            SensorKind::FrameLinearVelocity,
        ];
        let of_link = [SensorKind::SubtreeCenterOfMass, SensorKind::SubtreeAngularMomentum];
        for kind in of_robot {
            description.sensors.push(SensorDescription::new(kind.name(), kind, SensorObject::Robot));
        }
        for kind in of_frame {
            description.sensors.push(SensorDescription::new(kind.name(), kind, "frame0"));
        }
        for kind in of_link {
            description.sensors.push(SensorDescription::new(kind.name(), kind, link.as_str()));
        }
        let model = Model::new(description).unwrap();
        let set = SensorSet::new(&model).unwrap();
        let (mut memory, mut values) = (set.memory(&model), vec![0.0; set.value_count()]);
        let push = [PointForce::new(model.frame("frame0").unwrap(), [0.1; 3], [1.0, 2.0, 3.0])];
        let mut inputs = SensorInputs::new(&robot.state.q, &robot.state.v, &robot.state.a);
        inputs.wrenches = &push;
        let count = allocations(|| set.evaluate(&model, &mut memory, &inputs, &mut values));
        assert_eq!(count, 0, "sensors allocate on \"{}\"", robot.family);
    }
}

/// The derivatives that the table of quantities does not have, one call a line.
#[test]
fn derivatives_allocate_nothing() {
    for robot in robots() {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, tau) = (&state.q[..], &state.v[..], &state.a[..], &state.tau[..]);
        let (nv, frame) = (model.nv(), model.frame("frame0").unwrap());
        let w = &mut Workspace::new(model);
        let x = &mut vec![0.0; nv][..];
        let (j, k) = (&mut vec![0.0; 6 * nv][..], &mut vec![0.0; 6 * nv][..]);
        let nothing = |call: &str, count: usize| {
            assert_eq!(count, 0, "{call} allocates on \"{}\" (nv = {nv})", robot.family);
        };
        let call = || robot_dynamics::algorithms::dissipation_derivative(model, x);
        nothing("dissipation_derivative", allocations(call));
        for seen in ReferenceFrame::ALL {
            let call =
                || robot_dynamics::derivatives::frame_velocity_derivative(model, w, q, v, frame, seen, j);
            nothing("frame_velocity_derivative", allocations(call));
            let call = || {
                robot_dynamics::derivatives::frame_acceleration_derivatives(
                    model,
                    w,
                    robot_dynamics::derivatives::FrameAccelerationInputs {
                        q,
                        v,
                        a,
                        frame,
                        reference_frame: seen,
                    },
                    robot_dynamics::derivatives::FrameAccelerationDerivativesMut {
                        by_position: j,
                        by_velocity: k,
                    },
                );
            };
            nothing("frame_acceleration_derivatives", allocations(call));
        }
        let call = || {
            robot_dynamics::derivatives::center_of_mass_velocity_derivative(model, w, q, v, &mut j[..3 * nv]);
        };
        nothing("center_of_mass_velocity_derivative", allocations(call));

        let (y, z, r) = (&mut vec![0.0; nv][..], &mut vec![0.0; nv][..], &mut vec![0.0; nv][..]);
        let parameters = &mut vec![0.0; robot_dynamics::derivatives::parameter_count(model)][..];
        let wrench = [FrameWrench { frame, force_in_frame: [1.0, 2.0, 3.0], moment_in_frame: [0.1; 3] }];
        let call = || {
            let out = robot_dynamics::derivatives::InversePullbackMut {
                by_position: x,
                by_velocity: y,
                by_acceleration: z,
                parameters,
            };
            robot_dynamics::derivatives::inverse_dynamics_pullback_with_parameters(
                model,
                w,
                robot_dynamics::derivatives::InversePullbackInputs {
                    q,
                    v,
                    a,
                    wrenches: &wrench,
                    cotangent: tau,
                },
                out,
            );
        };
        nothing("inverse_dynamics_pullback", allocations(call));
        let call = || {
            let out = robot_dynamics::derivatives::ForwardPullbackMut {
                acceleration: r,
                by_position: x,
                by_velocity: y,
                by_force: z,
                parameters,
            };
            robot_dynamics::derivatives::forward_dynamics_pullback_with_parameters(
                model,
                w,
                robot_dynamics::derivatives::ForwardPullbackInputs {
                    q,
                    v,
                    tau,
                    wrenches: &wrench,
                    cotangent: a,
                },
                out,
            );
        };
        nothing("forward_dynamics_pullback", allocations(call));
        let second = &mut robot_dynamics::derivatives::SecondOrderWorkspace::new(model);
        let hessian = &mut vec![0.0; 9 * nv * nv][..];
        let inputs =
            robot_dynamics::derivatives::InversePullbackInputs { q, v, a, wrenches: &[], cotangent: tau };
        let call = || robot_dynamics::derivatives::inverse_dynamics_hessian(model, second, inputs, hessian);
        nothing("inverse_dynamics_hessian", allocations(call));
        let call = || {
            let (directions, results) = (
                robot_dynamics::derivatives::ForwardDirections { position: v, velocity: a, force: tau },
                robot_dynamics::derivatives::ForwardHessianProductMut {
                    by_position: x,
                    by_velocity: y,
                    by_force: z,
                },
            );
            let inputs =
                robot_dynamics::derivatives::ForwardPullbackInputs { q, v, tau, wrenches: &[], cotangent: a };
            robot_dynamics::derivatives::forward_dynamics_hessian_product(
                model, second, inputs, directions, results,
            );
        };
        nothing("forward_dynamics_hessian_product", allocations(call));
        nothing(
            "dissipation_pullback",
            allocations(|| robot_dynamics::derivatives::dissipation_pullback(model, v, a, x, &mut [])),
        );
        let on_coordinates = &mut vec![0.0; model.nq()][..];
        let call = || {
            robot_dynamics::model::cotangent_to_coordinates(model, q, a, on_coordinates);
            robot_dynamics::model::cotangent_from_coordinates(model, q, on_coordinates, x);
        };
        nothing("cotangents in coordinates", allocations(call));
        let w = &mut robot_dynamics::derivatives::StepPullbackWorkspace::new(model);
        let forces = StepForces::new(tau, true);
        for row in Integrator::ALL.into_iter().filter(|row| row.is_explicit()) {
            let mut done = Ok(());
            let call = || {
                done = robot_dynamics::derivatives::step_pullback(
                    model,
                    row,
                    w,
                    &forces,
                    1e-4,
                    robot_dynamics::derivatives::RobotState { q, v },
                    robot_dynamics::derivatives::MotionCotangents {
                        by_position: x,
                        by_velocity: y,
                        by_force: z,
                        parameters,
                    },
                );
            };
            nothing("step_pullback", allocations(call));
            done.unwrap();
        }
        let integrator = Integrator::RungeKutta4;
        let how = robot_dynamics::derivatives::Rollout::new(integrator, 1e-5, 10);
        let w = &mut robot_dynamics::derivatives::RolloutPullbackWorkspace::new(model, &how, 0);
        let mut done = Ok(());
        let call = || {
            done = robot_dynamics::derivatives::rollout_pullback(
                model,
                &how,
                w,
                robot_dynamics::derivatives::RobotState { q, v },
                tau,
                robot_dynamics::derivatives::TrajectoryCotangents::default(),
                robot_dynamics::derivatives::MotionCotangents {
                    by_position: x,
                    by_velocity: y,
                    by_force: z,
                    parameters,
                },
            );
        };
        nothing("rollout_pullback", allocations(call));
        done.unwrap();

        let w = &mut LinearizeStepWorkspace::new(model);
        let forces = StepForces::new(tau, true);
        let (a, b) = (&mut vec![0.0; 4 * nv * nv][..], &mut vec![0.0; 2 * nv * nv][..]);
        for row in Integrator::ALL.into_iter().filter(|row| row.is_explicit()) {
            let mut done = Ok(());
            let call = || {
                done = robot_dynamics::derivatives::linearize_step(
                    model,
                    row,
                    w,
                    &forces,
                    1e-6,
                    robot_dynamics::derivatives::RobotState { q, v },
                    robot_dynamics::derivatives::LinearizedStep { by_state: a, by_force: b },
                );
            };
            nothing("linearize_step", allocations(call));
            done.unwrap_or_else(|error| panic!("{row} on \"{}\": {error}", robot.family));
        }
    }
}

/// One step of every fixed-step integrator.
#[test]
fn steps_allocate_nothing() {
    for robot in robots() {
        let mut w = StepWorkspace::new(&robot.model);
        let forces = StepForces::new(&robot.state.tau, true);
        for integrator in Integrator::ALL {
            let (mut q, mut v) = (robot.state.q.clone(), robot.state.v.clone());
            let mut step = || {
                robot_dynamics::simulation::step(
                    &robot.model,
                    integrator,
                    &mut w,
                    &forces,
                    1e-6,
                    &mut q,
                    &mut v,
                )
            };
            let mut done = Ok(());
            let count = allocations(|| done = step());
            assert_eq!(count, 0, "{integrator} allocates on \"{}\"", robot.family);
            done.unwrap_or_else(|error| panic!("{integrator} on \"{}\": {error}", robot.family));
        }
    }
}

/// An arm with seven hinges, and its last frame.
fn arm() -> (Model, FrameId) {
    let options =
        RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    let model = Model::new(robot_dynamics::description::random_robot(4, &options)).unwrap();
    let hand = model.frame(&model.frames()[model.frames().len() - 1].name).unwrap();
    (model, hand)
}

/// Operational space and controllers, one call a line.
#[test]
fn controls_allocate_nothing() {
    let (model, hand) = arm();
    let (q, v, tau0, tau) = ([0.4; 7], [0.1; 7], [1.0; 7], &mut [0.0; 7]);
    let w = &mut OperationalSpaceWorkspace::new(&model);
    for rows in [&FrameConstraint::BALL[..], &FrameConstraint::WELD[..]] {
        let mut space = OperationalSpace::zeros(&model, rows.len());
        let mut done = Ok(());
        let call = || {
            done = robot_dynamics::control::operational_space_into(
                &model,
                w,
                OperationalSpaceInputs { q: &q, v: &v, frame: hand, rows },
                &mut space,
            );
        };
        assert_eq!(allocations(call), 0, "operational_space_into");
        done.unwrap();
        let mut done = Ok(());
        let call = || done = space.torque_with_posture(&[0.1; 6][..rows.len()], &tau0, tau);
        assert_eq!(allocations(call), 0, "torque_with_posture");
        done.unwrap();
    }
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 10.0 };
    let rest = [0.0; 3];
    let position = |_| TaskReference { position: [0.1, 0.2, 0.3], velocity: rest, acceleration: rest };
    let pose = |_| PoseReference::at_rest(Pose::from_translation([0.1, 0.2, 0.3]));
    let impedance = ImpedanceGains { stiffness: [100.0; 6], damping: [20.0; 6], null_damping: 1.0 };
    let impedance = ImpedanceControl::new(&model, hand, pose, impedance).unwrap();
    let mut controllers: [(&str, Box<dyn Controller>); 7] = [
        ("TaskControl of a position", Box::new(TaskControl::new(&model, hand, position, gains).unwrap())),
        (
            "TaskControl of a pose",
            Box::new(TaskControl::new(&model, hand, pose, gains).unwrap().with_posture(&q, 25.0).unwrap()),
        ),
        (
            "GravityCompensatedPd",
            Box::new(
                GravityCompensatedPd::new(&model, &q, &tau0, &tau0)
                    .unwrap()
                    .with_gravity_at(GravityAt::State),
            ),
        ),
        ("ConstantTorque", Box::new(ConstantTorque(vec![1.0; 7]))),
        (
            "TaskControl at effort limits",
            Box::new(TaskControl::new(&model, hand, position, gains).unwrap().with_limits(&[1.0; 7])),
        ),
        (
            "ImpedanceControl",
            Box::new(impedance.with_inertia([2.0; 6], hand, |_| [1.0; 6]).unwrap().with_limits(&[1.0; 7])),
        ),
        (
            "GravityCompensatedPd with implicit gains",
            Box::new(
                GravityCompensatedPd::new(&model, &q, &[1e6; 7], &[1e3; 7])
                    .unwrap()
                    .with_implicit_gains(1e-3)
                    .unwrap(),
            ),
        ),
    ];
    for (name, controller) in &mut controllers {
        let mut done = Ok(());
        let call = || done = controller.torque(0.0, &q, &v, tau);
        assert_eq!(allocations(call), 0, "{name}");
        done.unwrap();
    }
}

/// The momentum observer, the admittance, and the controls of actuators.
#[test]
fn interaction_allocates_nothing() {
    let (model, _) = arm();
    let mut robot = model.description().clone();
    for joint in model.joints().iter().filter(|joint| joint.nv == 1) {
        let (name, gear) = (format!("{} motor", joint.name), 10.0);
        robot.actuators.push(ActuatorDescription::new(name, Transmission::joint(&joint.name, gear)));
        robot.actuators.last_mut().unwrap().control_range = [-0.5, 0.5];
    }
    let model = Model::new(robot).unwrap();
    let (q, v, tau) = ([0.3; 7], [0.1; 7], [3.0; 7]);
    let mut observer = MomentumObserver::new(&model, &[50.0; 7]).unwrap().with_dissipation();
    observer.update(&q, &v, &tau, 1e-3).unwrap();
    assert_eq!(allocations(|| drop(observer.update(&q, &v, &tau, 1e-3).map(|r| black_box(r[0])))), 0);
    let mut lead = Admittance::new([1.0; 6], [1.0; 6], [1.0; 6]).unwrap();
    let at_rest = PoseReference::at_rest(Pose::IDENTITY);
    assert_eq!(allocations(|| drop(black_box(lead.step(&at_rest, &[1.0; 6], 1e-3)))), 0);
    let mut allocation = ControlAllocation::new(&model).unwrap();
    let mut controls = [0.0; 7];
    allocation.controls(&q, &v, &tau, &mut controls).unwrap();
    assert_eq!(allocations(|| drop(black_box(allocation.controls(&q, &v, &tau, &mut controls)))), 0);
}

/// The maps between a robot's coordinates and those of the robot with one joint locked.
#[test]
fn reduced_coordinates_allocate_nothing() {
    let (model, _) = arm();
    let mut description = model.description().clone();
    let joint = model.joints().iter().find(|joint| joint.nq > 0).unwrap();
    description.lock_joint(&joint.name, &vec![0.0; joint.nq]).unwrap();
    let reduced = Model::new(description).unwrap();
    let map = robot_dynamics::model::JointMap::new(&model, &reduced, &robot_dynamics::model::neutral(&model))
        .unwrap();
    let (mut q, mut v) = (robot_dynamics::model::neutral(&reduced), vec![0.1; reduced.nv()]);
    let (mut full_q, mut full_v) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
    let call = || {
        map.expand_configuration(&q, &mut full_q);
        map.expand_velocity(&v, &mut full_v);
        map.restrict_configuration(&full_q, &mut q);
        map.restrict_velocity(&full_v, &mut v);
    };
    assert_eq!(allocations(call), 0);
}

/// A run allocates at its start, for any number of steps.
#[test]
fn controlled_run_allocates_at_start_only() {
    let (model, hand) = arm();
    let q = [0.4; 7];
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 10.0 };
    let pose = robot_dynamics::algorithms::frame_pose(&model, &mut Workspace::new(&model), &q, hand);
    let here = PoseReference::at_rest(Pose { rotation: pose.rotation, translation: pose.translation });
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(Integrator::RungeKutta4))
        .dt(1e-3)
        .build()
        .unwrap();
    let mut count = |steps: usize| {
        let control = TaskControl::new(&model, hand, |_| here, gains).unwrap();
        let mut control = control.with_posture(&q, 25.0).unwrap();
        let mut done = false;
        let call = || {
            let run = simulation.run_steps_from(
                &q,
                &[0.0; 7],
                steps,
                RunOptions::new().sample_ends().controller(&mut control),
            );
            done = run.is_ok_and(|run| run.steps == steps);
        };
        let count = allocations(call);
        assert!(done);
        count
    };
    assert_eq!(count(10), count(300));
}

/// A whipping chain with h times its rates near 1. Most steps end at the rounding of v, and some need
/// Newton's method.
#[test]
fn steps_of_a_long_chain_allocate_nothing() {
    let model = chain(20);
    let mut w = StepWorkspace::new(&model);
    let forces = StepForces::new(&[0.0; 20], false);
    let (mut q, mut v) = ([0.0; 20], [0.0; 20]);
    q[0] = 1.5;
    for k in 0..180 {
        let mut done = Ok(());
        let row = Integrator::VariationalMidpoint;
        let count = allocations(|| {
            done = robot_dynamics::simulation::step(&model, row, &mut w, &forces, 0.01, &mut q, &mut v);
        });
        assert_eq!(count, 0, "step {k} allocates");
        done.unwrap_or_else(|error| panic!("step {k}: {error}"));
    }
}

/// On the calling thread, after the first call of each kind. Several threads also allocate for the pool's
/// queue.
#[test]
fn batches_on_one_thread_allocate_nothing() {
    for robot in robots() {
        let Robot { model, state, .. } = &robot;
        let mut options = BatchOptions::default();
        options.threads = 1;
        let w = &mut BatchWorkspace::with_options(model, options).unwrap();
        let nv = model.nv();
        let [q, v, a] = [&state.q, &state.v, &state.a].map(|x| x.repeat(19));
        let (x, m) = (&mut vec![0.0; 19 * nv][..], &mut vec![0.0; 19 * nv * nv][..]);
        let [y, z, r] = &mut [(); 3].map(|()| vec![0.0; 19 * nv]);
        let parameters = &mut vec![0.0; 19 * robot_dynamics::derivatives::parameter_count(model)][..];
        let integrator = Integrator::RungeKutta4;
        let how = batch::Rollout::new(integrator, 1e-5, 5);
        let packed = &mut vec![0.0; 19 * batch::mass_matrix_related_entries(model).len()][..];
        let mut calls = || {
            batch::mass_matrix_related(model, w, &q, packed).unwrap();
            batch::inverse_dynamics(model, w, &q, &v, &a, x).unwrap();
            batch::forward_dynamics(model, w, &q, &v, &a, x).unwrap();
            batch::mass_matrix(model, w, &q, m).unwrap();
            batch::inverse_mass_matrix(model, w, &q, m).unwrap();
            let out =
                batch::InversePullbackMut { by_position: x, by_velocity: y, by_acceleration: z, parameters };
            batch::inverse_dynamics_pullback(model, w, &q, &v, &a, &a, out).unwrap();
            let out = batch::ForwardPullbackMut {
                acceleration: r,
                by_position: x,
                by_velocity: y,
                by_force: z,
                parameters,
            };
            batch::forward_dynamics_pullback(model, w, &q, &v, &a, &a, out).unwrap();
            let (held, results) = (batch::Torques::Held(&a), (&mut x[..], &mut y[..]));
            let inputs = batch::RolloutPullbackInputs {
                spacing: 0,
                torques: held,
                q: &q,
                v: &v,
                trajectory: batch::TrajectoryCotangents::default(),
            };
            let cotangents = batch::MotionCotangents {
                by_position: results.0,
                by_velocity: results.1,
                by_force: z,
                parameters,
            };
            batch::rollout_pullback(model, w, &how, &inputs, cotangents, None).unwrap();
        };
        calls();
        assert_eq!(allocations(calls), 0, "\"{}\" (nv = {nv})", robot.family);
    }
}

/// Threads can share a model; each thread has its own workspace.
#[test]
fn model_is_sync() {
    fn shared<T: Send + Sync>() {}
    shared::<Model>();
    shared::<dynamics::FixedSize<3>>();
}

/// A step with friction and limits at all joints.
#[test]
fn implicit_steps_allocate_nothing() {
    for robot in robots() {
        let mut description = robot.model.description().clone();
        for joint in &mut description.joints {
            joint.passive = joint.passive.with_damping(10.0).with_friction(0.5);
            joint.limits = robot_dynamics::description::Limits::new(-0.1, 0.1);
        }
        let model = Model::new(description).unwrap();
        let (mut implicit, mut workspace) = (ImplicitIntegrator::new(&model), StepWorkspace::new(&model));
        let (mut q, mut v) = (robot_dynamics::model::neutral(&model), vec![0.5; model.nv()]);
        let tau = vec![0.0; model.nv()];
        let forces = StepForces::new(&tau, true);
        let mut step = || {
            for _ in 0..100 {
                implicit.step(&model, &mut workspace, &forces, 1e-3, &mut q, &mut v).unwrap();
            }
        };
        assert_eq!(allocations(&mut step), 0, "{} {}", robot.family, robot.seed);
    }
}

/// Steps with a closed loop and a gear, with a ball joint at its limit, in the air and on the ground.
#[test]
fn equalities_allocate_nothing() {
    let mut robot = RobotDescription::new("loop");
    robot.links.push(LinkDescription::new("world", None));
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    // Two bars hang down, and a third one lies across their ends.
    let bars = [
        ("world", [0.0; 3], [0.0, 0.0, -0.3]),
        ("bar0", [0.0, 0.0, -0.3], [0.6, 0.0, 0.0]),
        ("world", [0.6, 0.0, 0.0], [0.0, 0.0, -0.3]),
    ];
    for (k, (parent, from, to)) in bars.into_iter().enumerate() {
        let name = format!("bar{k}");
        let mass = MassProperties::new(1.0, Vector3::from(to) * 0.5, Matrix3::identity() * 2e-2).unwrap();
        robot.links.push(LinkDescription::new(&name, mass));
        let at = Pose::from_translation(from);
        robot.joints.push(JointDescription::new(format!("turn{k}"), hinge, parent, &name, at));
        let shape = Shape::Sphere { radius: 0.05 };
        robot.shapes.push(LinkShape::new(&name, ShapeRole::Collision, Pose::from_translation(to), shape));
    }
    let mass = MassProperties::new(1.0, Vector3::new(0.0, 0.0, 0.3), Matrix3::identity() * 0.1).unwrap();
    robot.links.push(LinkDescription::new("hand", mass));
    let mut limits = robot_dynamics::description::Limits::default();
    limits.turn = 0.1;
    let ball = JointDescription::new("ball", JointKind::Spherical, "world", "hand", Pose::IDENTITY);
    robot.joints.push(ball.with_limits(limits));
    for (name, link) in [("a", "bar1"), ("b", "bar2")] {
        let at = Pose::from_translation(if name == "a" { [0.6, 0.0, 0.0] } else { [0.0, 0.0, -0.3] });
        robot.frames.push(robot_dynamics::description::FrameDescription::new(name, link, at));
    }
    let model = Model::new(robot).unwrap();
    let [a, b] = ["a", "b"].map(|frame| model.frame(frame).unwrap());
    let rows = [robot_dynamics::constraints::SpatialAxis::X, robot_dynamics::constraints::SpatialAxis::Z];
    let set = [("pin", FrameConstraint::between(a, b, &rows).into())];
    let set = robot_dynamics::constraints::ConstraintSet::new(&model, set).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(-0.35)]).unwrap();
    for contacts in [None, Some(contacts)] {
        let builder = SimulationBuilder::new(&model).method(Method::Implicit).constraints(set.clone());
        let builder = match contacts {
            Some(contacts) => builder.contacts(contacts),
            None => builder.without(Effect::Contacts),
        };
        let mut implicit = builder.build().unwrap().into_stepper();
        let (mut q, mut v) = (robot_dynamics::model::neutral(&model), vec![0.0; model.nv()]);
        v[3..].fill(0.1);
        let (mut workspace, tau) = (StepWorkspace::new(&model), vec![0.0; model.nv()]);
        let mut step = || {
            let forces = StepForces::new(&tau, true);
            implicit.step(&model, &mut workspace, &forces, 1e-3, &mut q, &mut v).unwrap();
        };
        (0..300).for_each(|_| step());
        assert_eq!(allocations(|| (0..300).for_each(|_| step())), 0);
        assert!(
            implicit.constraint_forces().into_iter().any(|(name, force)| name == "pin.z" && force != 0.0)
        );
    }
}

/// A stack of a capsule and three balls.
fn pile() -> Model {
    let mut robot = RobotDescription::new("pile");
    robot.links.push(LinkDescription::new("world", None));
    for k in 0..4 {
        let name = format!("body{k}");
        let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * 4e-3).unwrap();
        robot.links.push(LinkDescription::new(&name, mass));
        let height = if k == 0 { 0.16 } else { 0.21 + 0.21 * f64::from(k) };
        let at = Pose::from_translation([0.001 * f64::from(k), 0.0, height]);
        robot.joints.push(JointDescription::new(format!("free{k}"), JointKind::Floating, "world", &name, at));
        let shape =
            if k == 0 { Shape::Capsule { radius: 0.1, length: 0.1 } } else { Shape::Sphere { radius: 0.1 } };
        robot.shapes.push(LinkShape::new(&name, ShapeRole::Collision, Pose::IDENTITY, shape));
    }
    Model::new(robot).unwrap()
}

/// Steps with contacts on the ground and between links, after the first step.
#[test]
fn contacts_allocate_nothing() {
    let model = pile();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap().with_links(&model);
    let field = HeightField::new(2, 3, [1.0, 1.0], vec![0.0, 0.001, 0.0, 0.0, 0.001, 0.0]).unwrap();
    let contacts = contacts.with_height_field(&field).unwrap();
    let builder = SimulationBuilder::new(&model).method(Method::Implicit).contacts(contacts);
    let mut implicit = builder.build().unwrap().into_stepper();
    let (mut q, mut v) = (robot_dynamics::model::neutral(&model), vec![0.0; model.nv()]);
    let (mut workspace, tau) = (StepWorkspace::new(&model), vec![0.0; model.nv()]);
    let mut step = || {
        let forces = StepForces::new(&tau, true);
        implicit.step(&model, &mut workspace, &forces, 1e-3, &mut q, &mut v).unwrap();
    };
    (0..300).for_each(|_| step());
    assert_eq!(allocations(|| (0..300).for_each(|_| step())), 0);
    assert!(implicit.contacts().iter().any(|contact| contact.other_link.is_some()));
    assert!(implicit.contacts().iter().any(|contact| contact.ground == Some(1)));
}

/// A step does not allocate after a reset, after a snapshot is restored, or in a copy of the simulation.
#[test]
fn steps_after_a_reset_allocate_nothing() {
    let model = pile();
    for method in [Method::Implicit, Method::Mujoco] {
        let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap().with_links(&model);
        let builder = SimulationBuilder::new(&model).method(method).contacts(contacts);
        let mut simulation = builder.build().unwrap();
        let (q, v) = (simulation.q().to_vec(), simulation.v().to_vec());
        let count =
            |simulation: &mut Simulation| allocations(|| (0..300).for_each(|_| simulation.step().unwrap()));
        count(&mut simulation);
        let snapshot = simulation.snapshot();
        assert_eq!(count(&mut simulation), 0, "{method}");
        simulation.reset(&q, &v).unwrap();
        assert_eq!(count(&mut simulation), 0, "{method}, after a reset");
        simulation.set_state(&q, &v).unwrap();
        assert_eq!(count(&mut simulation), 0, "{method}, after a state was set");
        simulation.restore(&snapshot);
        assert_eq!(count(&mut simulation), 0, "{method}, after a restored snapshot");
        assert_eq!(count(&mut simulation.clone()), 0, "{method}, a copy");
    }
}

/// The implicit stepper of many free balls on the ground and its first step allocate no dense matrix over all
/// coordinates. Together they request fewer bytes than one dense M.
#[test]
fn stepper_of_many_bodies_has_no_dense_matrix() {
    let mut robot = RobotDescription::new("many balls");
    robot.links.push(LinkDescription::new("world", None));
    for k in 0..500 {
        let name = format!("ball {k}");
        let mass = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity() * 0.004).unwrap();
        robot.links.push(LinkDescription::new(&name, mass));
        let at = Pose::from_translation([f64::from(k), 0.0, 0.1 + 1e-4 * f64::from(k % 7)]);
        robot.joints.push(JointDescription::new(
            format!("free {k}"),
            JointKind::Floating,
            "world",
            &name,
            at,
        ));
        let shape = Shape::Sphere { radius: 0.1 };
        robot.shapes.push(LinkShape::new(&name, ShapeRole::Collision, Pose::IDENTITY, shape));
    }
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap();
    let builder = SimulationBuilder::new(&model).method(Method::Implicit).contacts(contacts);
    let simulation = builder.build().unwrap();
    let (mut q, mut v, tau) = (simulation.q().to_vec(), simulation.v().to_vec(), vec![0.0; model.nv()]);
    let (made, mut workspace) = (simulation.stepper(), StepWorkspace::new(&model));
    let before = BYTES.get();
    let mut stepper = made.clone();
    stepper.step(&model, &mut workspace, &StepForces::new(&tau, true), 1e-3, &mut q, &mut v).unwrap();
    let bytes = BYTES.get() - before;
    let dense = size_of::<f64>() * model.nv() * model.nv();
    assert!(bytes < dense, "{bytes} bytes, a dense M takes {dense}");
}

/// The second solution, from the first one shifted, allocates nothing: linearizations, the Riccati recursion
/// with bounds, rollouts and the log.
#[test]
fn iterations_of_optimal_control_do_not_allocate() {
    let model = std::sync::Arc::new(chain(4));
    let step = SmoothStep::new(model.clone(), Integrator::SemiImplicitEuler, 0.01).expect("a step");
    let x0 = vec![0.1; 2 * model.nv()];
    let mut problem = Problem::new(step, &x0, 15).expect("a problem");
    let space = problem.state_space().clone();
    let tip = model.frame_named(&model.frames()[model.frames().len() - 1].name).expect("a frame");
    let mut terminal = Cost::new();
    terminal.add(StateResidual::new(&space, &vec![0.0; x0.len()]).expect("a state"), 1.0).expect("weights");
    let mut running = terminal.clone();
    let reach = FrameTranslationResidual::new(model.clone(), tip, [0.1; 3]).expect("a target");
    terminal.add(reach, 10.0).expect("weights");
    let effort = ControlResidual::new(&vec![0.0; model.nv()]).expect("controls");
    running.add(effort, 0.1).expect("weights");
    problem.set_running_cost(0..15, running).expect("a cost");
    problem.set_terminal_cost(terminal).expect("a cost");
    let limits = vec![1.0; model.nv()];
    let lower: Vec<f64> = limits.iter().map(|limit| -limit).collect();
    problem.set_control_bounds(0..15, ControlBounds::new(&lower, &limits).expect("bounds")).expect("bounds");
    let mut solver = Fddp::new(problem, FddpOptions::default()).expect("options");
    solver.solve().expect("a solution");
    let requests = allocations(|| {
        solver.shift();
        solver.solve().expect("a solution").iterations
    });
    assert_eq!(requests, 0);
}

/// Differential steps after the first, with other targets, on two levels and with distances of capsules.
#[test]
fn task_kinematics_allocates_nothing() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let loaded = robot_dynamics::load_description(file, &robot_dynamics::LoadOptions::default());
    let mut robot = loaded.expect("a robot").description;
    for link in ["panda_link1", "panda_link4", "panda_link7"] {
        let ball = Shape::Sphere { radius: 0.05 };
        robot.shapes.push(LinkShape::new(link, ShapeRole::Collision, Pose::IDENTITY, ball));
    }
    let model = Model::new(robot).expect("a robot");
    let (q, v) = ([0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8], [0.0; 7]);
    let hand = model.frame_named("panda_link8").expect("a frame");
    let at = robot_dynamics::algorithms::frame_pose(&model, &mut Workspace::new(&model), &q, hand);
    let mut kinematics = TaskKinematics::new(&model);
    let reach = kinematics.add_task(KinematicObjective::pose(hand, at)).expect("a task");
    let center = KinematicTask::new(KinematicObjective::center_of_mass([0.0; 3])).with_weight(0.1);
    kinematics.add_task(center).expect("a task");
    let posture = KinematicTask::new(KinematicObjective::Posture { target: q.to_vec() }).with_level(1);
    kinematics.add_task(posture).expect("a task");
    let contacts = ContactSet::new(&model, &[]).expect("shapes").with_links(&model);
    let law = CollisionAvoidance { range: 2.0, ..CollisionAvoidance::new(0.01) };
    kinematics.avoid_collisions(contacts, law).expect("a law");
    assert!(kinematics.step(&q, &v, 0.01).expect("a step").distance.is_some());
    let (mut steps, targets) = (0, [0.05, -0.1, 0.2]);
    let requests = allocations(|| {
        for x in targets {
            let mut target = at;
            target.translation[0] += x;
            *kinematics.objective_mut(reach) = KinematicObjective::pose(hand, target);
            steps += kinematics.step(&q, &v, 0.01).expect("a step").steps;
        }
    });
    assert_eq!(requests, 0);
    assert!(steps > 0, "limits are active");
}

/// New targets, moving targets and steps of an online motion.
#[test]
fn online_motion_allocates_nothing() {
    let options = RandomRobotOptions { kinds: JointKinds::Turning, joints: 7, ..Default::default() };
    let model = Model::new(random_robot(5, &options)).expect("a robot");
    let (rest, nv) = ([0.0; 7], model.nv());
    let limits = OnlineLimits::new(vec![1.0; nv], vec![4.0; nv], vec![40.0; nv]);
    let mut motion = OnlineMotion::new(&model, limits, 0.001).expect("limits");
    let mut moved = 0.0f64;
    let requests = allocations(|| {
        for target in [0.5, -0.3, 0.8] {
            motion.set_target(&[target; 7], &rest, &rest).expect("a target");
            for _ in 0..50 {
                motion.step().expect("a step");
            }
            motion.follow_target(&[target; 7], &[0.1; 7], &rest).expect("a target");
            motion.step().expect("a step");
            moved = moved.max(motion.v()[3].abs());
        }
    });
    assert_eq!(requests, 0);
    assert!(moved > 0.05, "{moved}");
}

/// Calls after the first, with other active limits, references and held contacts.
#[test]
fn whole_body_control_allocates_nothing() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
    let loaded = robot_dynamics::load_description(file, &robot_dynamics::LoadOptions::default());
    let mut robot = loaded.expect("a robot").description;
    robot.base = Base::Floating;
    let model = Model::new(robot).expect("a robot");
    let (mut q, v) = (robot_dynamics::model::neutral(&model), vec![0.0; model.nv()]);
    for leg in 0..4 {
        q[7 + 3 * leg..10 + 3 * leg].copy_from_slice(&[0.0, 0.7, -1.4]);
    }
    let mut control = WholeBodyControl::new(&model);
    let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"].map(|foot| {
        let frame = model.frame_named(foot).expect("a foot");
        control.add_contact(HeldContact::new(frame, ContactGeometry::Ball(0.02))).expect("a contact")
    });
    let center = |z: f64| Objective::CenterOfMass {
        reference: TaskReference { position: [0.0; 3], velocity: [0.0; 3], acceleration: [0.0, 0.0, z] },
        gains: PdGains { stiffness: 0.0, damping: 0.0 },
    };
    let jump = control.add_task_at(0, center(0.0), 1.0).expect("a task");
    let reference = Reference { q: q.clone(), v: v.clone(), a: v.clone() };
    let posture = Objective::Posture { reference, gains: PdGains::critical(100.0) };
    control.add_task_at(1, posture, 1.0).expect("a task");
    control.add_task_at(2, Objective::ContactForces, 1.0).expect("a task");
    control.add_task_at(2, Objective::Torque { torque: v.clone() }, 1.0).expect("a task");
    control.solve(&q, &v).expect("a solution");
    let mut active = 0;
    let requests = allocations(|| {
        for (z, are_held) in [(0.0, [true; 4]), (60.0, [true; 4]), (5.0, [true, false, true, true])] {
            *control.objective_mut(jump) = center(z);
            feet.iter().zip(are_held).for_each(|(foot, is_held)| control.hold_contact(*foot, is_held));
            active += control.solve(&q, &v).expect("a solution").active_limits.len();
        }
    });
    assert_eq!(requests, 0);
    assert!(active > 0, "limits are active");
}

/// A sample of the recursive estimate of a payload, and its results.
#[test]
fn payload_estimates_allocate_nothing() {
    for Robot { model, state, .. } in &robots() {
        let frame = model.frame(model.moving_links().last().unwrap()).unwrap();
        let (noise, offsets) = (vec![0.1; model.nv()], vec![0.2; model.nv()]);
        let estimator = PayloadEstimator::new(model, frame, &noise).unwrap();
        let estimator = estimator.with_forgetting(0.99).unwrap();
        let mut estimator = estimator.with_dissipation_and_offsets(&offsets).unwrap();
        // Machine code is made at the first call.
        estimator.push(&state.q, &state.v, &state.a, &state.tau).unwrap();
        let mut call = || estimator.push(&state.q, &state.v, &state.a, &state.tau);
        assert_eq!(allocations(&mut call), 0, "push");
        assert_eq!(allocations(|| estimator.payload()), 0, "payload");
    }
}
