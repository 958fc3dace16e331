//! Typical tasks of a user, with the facade alone. Each task checks its own result and prints one line.

use std::error::Error;

use robot_dynamics::algorithms::{ReferenceFrame, frame_jacobian, frame_pose};
use robot_dynamics::batch::{
    BatchOptions, BatchWorkspace, ForwardDynamicsDerivativesMut, Rollout, RolloutStates, Torques,
    forward_dynamics_derivatives, rollout,
};
use robot_dynamics::constraints::{
    Constraint, ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis, constrained_forward_dynamics,
};
use robot_dynamics::control::{InverseKinematicsOptions, TaskControl, TaskGains, TaskReference, dlqr};
use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::description::{MassProperties, Pose};
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::nalgebra::{DMatrix, Matrix3, Vector3};
use robot_dynamics::simulation::{
    Effect, GravityCompensatedPd, Integrator, Method, RunOptions, Simulation, SimulationBuilder, StepForces,
};
use robot_dynamics::{LoadOptions, load, load_description, load_with};

type Outcome = Result<String, Box<dyn Error>>;

const PANDA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
const HUMANOID: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/humanoid.urdf");
const READY: [f64; 7] = [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8];
const HAND: &str = "panda_link8";

fn main() -> Result<(), Box<dyn Error>> {
    let tasks: [(&str, fn() -> Outcome); 9] = [
        ("hold a pose by PD", pd),
        ("inverse kinematics", inverse_kinematics),
        ("impedance at the hand", impedance),
        ("stand on two feet", two_feet),
        ("ten thousand rollouts", rollouts),
        ("derivatives on a small stack", batch_derivatives),
        ("LQR about a pose", lqr),
        ("errors name the problem", errors),
        ("a payload in the hand", payload),
    ];
    for (name, task) in tasks {
        println!("{name:24} {}", task().map_err(|error| format!("{name}: {error}"))?);
    }
    Ok(())
}

fn panda() -> Result<Model, Box<dyn Error>> {
    Ok(load(PANDA)?.model)
}

fn simulation(model: &Model) -> Simulation {
    let rk4 = Method::Fixed(Integrator::RungeKutta4);
    SimulationBuilder::new(model).method(rk4).without(Effect::Dissipation).build().expect("a simulation")
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// The arm starts a fifth of a radian away and comes to rest at its target.
fn pd() -> Outcome {
    let model = panda()?;
    let start = READY.map(|q| q + 0.2);
    // The torque is held over each step: the damping of a light joint must not exceed the limit of stability.
    let (stiffness, damping) =
        ([200.0, 200.0, 200.0, 200.0, 50.0, 50.0, 10.0], [40.0, 40.0, 40.0, 40.0, 5.0, 5.0, 0.5]);
    let mut control = GravityCompensatedPd::new(&model, &READY, &stiffness, &damping)?;
    let run = simulation(&model).run_from(
        &start,
        &[0.0; 7],
        5.0,
        RunOptions::new().sample_ends().controller(&mut control),
    )?;
    let off: Vec<f64> = run.q.iter().zip(&READY).map(|(q, target)| q - target).collect();
    assert!(largest(&off) < 1e-2, "{off:?}");
    Ok(format!("{:.1e} rad off after 5 s", largest(&off)))
}

/// Moves the hand by 24 cm and turns it by half a radian about its own axis, within the joint limits.
fn inverse_kinematics() -> Outcome {
    let model = panda()?;
    let hand = model.frame_named(HAND)?;
    let mut workspace = Workspace::new(&model);
    let start: Pose = frame_pose(&model, &mut workspace, &READY, hand).into();
    let mut target = start.compose(&Pose::exp([0.0; 3], [0.0, 0.0, 0.5]));
    target.translation = (Vector3::from(start.translation) + Vector3::new(-0.1, 0.2, 0.1)).into();
    let options = InverseKinematicsOptions::default();
    let found =
        robot_dynamics::control::inverse_kinematics(&model, &mut workspace, hand, target, &READY, &options)?;
    let reached = frame_pose(&model, &mut workspace, &found.q, hand);
    let off: Vec<f64> = (0..3).map(|i| reached.translation[i] - target.translation[i]).collect();
    let limits = model.coordinate_limits();
    let is_within = found.q.iter().zip(&limits).all(|(q, limit)| limit.lower <= *q && *q <= limit.upper);
    assert!(largest(&off) < 1e-9 && is_within, "{off:?} {:?}", found.q);
    Ok(format!("{:.1e} m off after {} steps", largest(&off), found.iterations))
}

/// A spring of 400 N/m per kg of the hand's effective mass pulls the hand to a point 5 cm away.
fn impedance() -> Outcome {
    let model = panda()?;
    let hand = model.frame_named(HAND)?;
    let mut workspace = Workspace::new(&model);
    let [x, y, z] = frame_pose(&model, &mut workspace, &READY, hand).translation;
    let there = move |_: f64| TaskReference {
        position: [x, y + 0.05, z],
        velocity: [0.0; 3],
        acceleration: [0.0; 3],
    };
    let gains = TaskGains { stiffness: 400.0, damping: 40.0, null_damping: 5.0 };
    let mut control = TaskControl::new(&model, hand, there, gains)?;
    let run = simulation(&model).run_from(
        &READY,
        &[0.0; 7],
        1.0,
        RunOptions::new().sample_ends().controller(&mut control),
    )?;
    let [_, found, _] = frame_pose(&model, &mut workspace, &run.q, hand).translation;
    // Critically damped at 20 rad/s: after 1 s (1 + 20) e⁻²⁰ is left.
    assert!((found - y - 0.05).abs() < 1e-6, "{found}");
    Ok(format!("{:.1e} m off after 1 s", (found - y - 0.05).abs()))
}

/// Both feet are welded to the floor: without torques they carry the forces of Newton's law.
fn two_feet() -> Outcome {
    let model = load_with(HUMANOID, &LoadOptions::default().with_floating_base())?.model;
    let (q, rest) = (neutral(&model), vec![0.0; model.nv()]);
    let mut workspace = Workspace::new(&model);
    let mut contacts = Vec::new();
    for name in ["left_foot", "right_foot"] {
        let foot = model.frame_named(name)?;
        let pose = frame_pose(&model, &mut workspace, &q, foot);
        contacts.push((
            name,
            Constraint::FrameConstraint(FrameConstraint::contact(foot, pose, &FrameConstraint::WELD)),
        ));
    }
    let set = ConstraintSet::new(&model, contacts)?;
    let options = ConstraintOptions::default();
    // The torques of the pose held at the pelvis, which has no motor: the feet carry that weight.
    let mut tau = model.gravity_forces(&q)?.as_slice().to_vec();
    tau[..6].fill(0.0);
    let motion = constrained_forward_dynamics(&model, &mut workspace, &set, &options, &q, &rest, &tau)?;
    let vertical: f64 = set
        .row_names()
        .iter()
        .zip(motion.multipliers.iter())
        .filter(|(name, _)| name.ends_with(" z") || name.ends_with(".z") || name.ends_with("/z"))
        .map(|(_, force)| force)
        .sum();
    let falling = (model.center_of_mass_jacobian(&q)? * &motion.acceleration)[2];
    let carried = model.mass() * (9.81 + falling);
    assert!((vertical.abs() - carried).abs() < 1e-6 * carried, "{vertical} {carried}");
    Ok(format!("{:.2} N on both feet", vertical.abs()))
}

/// Ten thousand rollouts from different states; a single rollout gives the same result.
fn rollouts() -> Outcome {
    const COUNT: usize = 10_000;
    let model = panda()?;
    let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 10);
    let mut q: Vec<f64> = (0..COUNT).flat_map(|i| READY.map(|q| q + 1e-5 * i as f64)).collect();
    let mut v = vec![0.0; COUNT * 7];
    let (mut q_last, mut v_last) = (q[(COUNT - 1) * 7..].to_vec(), vec![0.0; 7]);
    let mut workspace = BatchWorkspace::new(&model);
    rollout(&model, &mut workspace, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None)?;
    rollout(
        &model,
        &mut workspace,
        &how,
        Torques::Zero,
        RolloutStates::ends(&mut q_last, &mut v_last),
        None,
    )?;
    assert_eq!((&q[(COUNT - 1) * 7..], &v[(COUNT - 1) * 7..]), (&q_last[..], &v_last[..]));
    assert!(largest(&v_last) > 1e-3);
    Ok(format!("{COUNT} states, the last at {:.4} rad/s", largest(&v_last)))
}

/// Derivatives of a batch on a thread with the default stack size, in an unoptimised build, where the kernels
/// use most of it. M⁻¹ of each state times its M is the identity.
fn batch_derivatives() -> Outcome {
    let compute = || -> Result<f64, String> {
        let model = panda().map_err(|error| error.to_string())?;
        let (n, states) = (model.nv(), 20);
        let (q, x) = (READY.repeat(states), vec![0.1; n * states]);
        let mut options = BatchOptions::default();
        options.threads = 1;
        let mut workspace =
            BatchWorkspace::with_options(&model, options).map_err(|error| error.to_string())?;
        let [mut by_q, mut by_v, mut inverse] = [(); 3].map(|()| vec![0.0; n * n * states]);
        let [by_q, by_v, by_tau] = [&mut by_q, &mut by_v, &mut inverse];
        forward_dynamics_derivatives(
            &model,
            &mut workspace,
            &q,
            &x,
            &x,
            ForwardDynamicsDerivativesMut { by_position: by_q, by_velocity: by_v, by_force: by_tau },
        )
        .map_err(|error| error.to_string())?;
        let mass = model.mass_matrix(&READY).map_err(|error| error.to_string())?;
        let last = DMatrix::from_row_slice(n, n, &inverse[n * n * (states - 1)..]);
        Ok((mass * last - DMatrix::identity(n, n)).amax())
    };
    let small = std::thread::Builder::new().stack_size(2 << 20);
    let defect = small.spawn(compute)?.join().map_err(|_| "the thread panicked")??;
    // κ(M) of a Panda is below 1e3.
    assert!(defect < 1e-11, "M⁻¹M is off by {defect:e}");
    Ok(format!("M⁻¹M is one to {defect:.0e}"))
}

/// K of u = τ₀ − K δx for one linearised step; the closed loop contracts.
fn lqr() -> Outcome {
    let model = panda()?;
    let hold = model.gravity_forces(&READY)?;
    let (mut a, mut b) = (vec![0.0; 14 * 14], vec![0.0; 14 * 7]);
    let forces = StepForces::new(hold.as_slice(), false);
    let mut workspace = LinearizeStepWorkspace::new(&model);
    linearize_step(
        &model,
        Integrator::RungeKutta4,
        &mut workspace,
        &forces,
        1e-2,
        RobotState { q: &READY, v: &[0.0; 7] },
        LinearizedStep { by_state: &mut a, by_force: &mut b },
    )?;
    let (a, b) = (DMatrix::from_row_slice(14, 14, &a), DMatrix::from_row_slice(14, 7, &b));
    let found = dlqr(&a, &b, &DMatrix::identity(14, 14), &(DMatrix::identity(7, 7) * 1e-3))?;
    let closed = &a - &b * &found.gain;
    let radius = |m: &DMatrix<f64>| m.complex_eigenvalues().iter().map(|x| x.norm()).fold(0.0, f64::max);
    assert!(radius(&closed) < 0.999 && radius(&a) > 1.0, "{} {}", radius(&closed), radius(&a));
    Ok(format!("spectral radius {:.3}, {:.3} without", radius(&closed), radius(&a)))
}

/// Invalid data are errors that name the quantity and its place.
fn errors() -> Outcome {
    let missing = load("no such file.urdf").expect_err("there is no such file").to_string();
    assert!(missing.contains("no such file.urdf"), "{missing}");
    let model = panda()?;
    let short = model.mass_matrix(&[0.0; 3]).expect_err("three numbers for seven joints").to_string();
    assert!(short.contains('3') && short.contains('7'), "{short}");
    let nan = model.gravity_forces(&[f64::NAN; 7]).expect_err("no numbers").to_string();
    assert!(nan.contains("NaN"), "{nan}");
    Ok(nan)
}

/// Two kilograms in the hand have the weight 2 g along the Jacobian of the hand.
fn payload() -> Outcome {
    let mut described = load_description(PANDA, &LoadOptions::default())?;
    let load = MassProperties::new(2.0, Vector3::zeros(), Matrix3::zeros())?;
    described.description.attach_payload(HAND, &load)?;
    let loaded = described.compile()?.model;
    let model = panda()?;
    let hand = model.frame_named(HAND)?;
    let mut jacobian = vec![0.0; 6 * 7];
    frame_jacobian(
        &model,
        &mut Workspace::new(&model),
        &READY,
        hand,
        ReferenceFrame::LocalWorldAligned,
        &mut jacobian,
    );
    let more = loaded.gravity_forces(&READY)? - model.gravity_forces(&READY)?;
    for (i, more) in more.iter().enumerate() {
        let expected = 2.0 * 9.81 * jacobian[2 * 7 + i];
        assert!((more - expected).abs() < 1e-12 * 20.0, "joint {i}: {more} {expected}");
    }
    let rows = [SpatialAxis::Z];
    let space = robot_dynamics::control::operational_space(
        &loaded,
        &mut Workspace::new(&loaded),
        &READY,
        &[0.0; 7],
        loaded.frame_named(HAND)?,
        &rows,
    )?;
    Ok(format!("{:.3} N m more at the shoulder, {:.2} kg felt upwards", more[1], space.inertia[(0, 0)]))
}
