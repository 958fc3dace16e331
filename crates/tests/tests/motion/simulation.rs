//! Runs: energy accounts, controllers, and errors that keep the steps before them.

use std::ops::ControlFlow;

use dynamics::{PdHold, Reach2R, hold};
use nalgebra::{Matrix3, Vector3, vector};
use robot_dynamics::algorithms::MotionError;
use robot_dynamics::algorithms::gravity;
use robot_dynamics::description::{
    JointDescription, JointKind, Limits, LinkDescription, PassiveForces, Pose, RobotDescription,
};
use robot_dynamics::model::{Model, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    ConstantTorque, Controller, ControllerError, Effect, GravityAt, GravityCompensatedPd, Integrator, Method,
    Run, RunError, RunOptions, Simulation, SimulationBuilder, StepInfo,
};
use robot_dynamics::{Classified, ErrorKind, InputProblem};

use crate::common::damped_tree;

fn simulation(model: &Model, integrator: Integrator, step: f64) -> Simulation {
    SimulationBuilder::new(model)
        .method(Method::Fixed(integrator))
        .without(Effect::EffortLimits)
        .dt(step)
        .build()
        .unwrap()
}

fn two_link_arm() -> RobotDescription {
    let mut robot = RobotDescription::new("2R");
    robot.links.push(LinkDescription::new("base", None));
    for (name, mass) in [("upper", 2.0), ("fore", 1.0)] {
        let moment = mass / 12.0;
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.0, moment, moment));
        let rod =
            robot_dynamics::description::MassProperties::new(mass, Vector3::new(0.5, 0.0, 0.0), inertia)
                .unwrap();
        robot.links.push(LinkDescription::new(name, rod));
    }
    let hinge = JointKind::Revolute { axis: [0.0, -1.0, 0.0] };
    let elbow = Pose::from_translation([1.0, 0.0, 0.0]);
    let limits = |effort| Limits::new(f64::NEG_INFINITY, f64::INFINITY).with_effort(effort);
    let shoulder = JointDescription::new("shoulder", hinge, "base", "upper", Pose::IDENTITY);
    robot.joints.push(shoulder.with_limits(limits(20.0)));
    let elbow = JointDescription::new("elbow", hinge, "upper", "fore", elbow);
    robot.joints.push(elbow.with_limits(limits(12.0)));
    robot
}

/// Motors and dampers act on floating and ball joints: the imbalance decreases with the order of the method,
/// and the energy is not constant.
#[test]
fn energy_account_closes_to_order_of_method() {
    for seed in 0..6 {
        let model = damped_tree(seed);
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let mut torque = ConstantTorque(state.tau.iter().map(|tau| 0.1 * tau).collect());
        for row in Integrator::ALL {
            let (h, steps) = (2e-3, 250);
            let mut run = |h: f64, steps: usize| -> Run {
                simulation(&model, row, h)
                    .run_steps_from(
                        &state.q,
                        &state.v,
                        steps,
                        RunOptions::new().sample_every(10).controller(&mut torque),
                    )
                    .unwrap()
            };
            let (coarse, fine) = (run(h, steps), run(h / 2.0, 2 * steps));
            let (work, dissipated) = (fine.energy_account.work().abs(), fine.energy_account.dissipated());
            assert!(work > 0.05 && dissipated > 0.05, "robot {seed}: {work} J, {dissipated} J");
            let order = (coarse.energy_account.max_imbalance() / fine.energy_account.max_imbalance()).log2();
            let largest = fine.energy_account.max_imbalance();
            println!("robot {seed} {row:22} imbalance {largest:.1e} J, order {order:.2}");
            // Below 1e-10 J only rounding remains; the maximum over a run is at different times.
            assert!(
                order > f64::from(row.order()) - 0.5 || largest < 1e-10,
                "robot {seed}, {row}: order {order}, {largest:e} J"
            );
        }
    }
}

/// A spinning, damped, floating brick: the damper of the ball joint dissipates all of its kinetic energy.
#[test]
fn damping_dissipates_all_energy() {
    let mut robot = RobotDescription::new("top");
    robot.gravity = [0.0; 3];
    let brick =
        robot_dynamics::description::MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    for name in ["ground", "brick"] {
        robot.links.push(LinkDescription::new(name, brick));
    }
    let ball = JointDescription::new("ball", JointKind::Spherical, "ground", "brick", Pose::IDENTITY);
    let passive = PassiveForces::default().with_damping(0.05);
    robot.joints.push(ball.with_passive(passive));
    let model = Model::new(robot).unwrap();
    for row in Integrator::ALL {
        let run = simulation(&model, row, 1e-3)
            .run_steps_from(&neutral(&model), &[3.0, -2.0, 4.0], 30_000, RunOptions::new().sample_every(10))
            .unwrap();
        let energy_account = &run.energy_account;
        assert!(
            energy_account.now() < 1e-6 * energy_account.start(),
            "{row}: {} J left",
            energy_account.now()
        );
        let missing = (energy_account.dissipated() / energy_account.start() - 1.0).abs();
        // First order: ½ h · (damping/inertia ≈ 2/s, rates ≈ 5/s) = 0.3 %.
        let allowed = if row.order() == 1 { 5e-3 } else { 1e-5 };
        assert!(missing < allowed, "{row}: {missing:e}");
    }
}

/// The controller of the chapter on the described arm gives the peaks and the end of `dynamics::hold`.
#[test]
fn held_arm_matches_chapter() {
    let model = Model::new(two_link_arm()).unwrap();
    let (target, stiffness, damping) = ([1.6, 0.4], [60.0, 30.0], [20.0, 6.0]);
    let mut control = GravityCompensatedPd::new(&model, &target, &stiffness, &damping).unwrap();
    let run = simulation(&model, Integrator::RungeKutta4, 1e-3)
        .run_steps_from(
            &[1.0, -0.4],
            &[0.0, 0.0],
            4000,
            RunOptions::new().sample_every(10).controller(&mut control),
        )
        .unwrap();
    let chapter = PdHold {
        target: target.into(),
        stiffness: stiffness.into(),
        damping: damping.into(),
        limits: vector![20.0, 12.0],
    };
    let plan = dynamics::HoldRun { step: 1e-3, steps: 4000, band: 0.01 };
    let report =
        hold(&Reach2R::worked_example(), &chapter, &vector![1.0, -0.4], &vector![0.0, 0.0], &plan).unwrap();
    for k in 0..2 {
        // The motion contracts, so roundings do not grow.
        assert!((run.q[k] - report.q[k]).abs() < 1e-12, "{} {}", run.q[k], report.q[k]);
        assert!((run.peak_torque[k] - report.peak_torque[k]).abs() < 1e-12);
        assert!((control.peak_demand()[k] - report.peak_demand[k]).abs() < 1e-11);
    }
    assert_eq!(run.peak_torque[0], 20.0, "the shoulder is cut off at its limit");
    assert!(control.peak_demand()[0] > 20.0);
}

/// With g(q) as the torque the arm floats: it stays at any pose.
#[test]
fn gravity_at_state_lets_arm_float() {
    let model = Model::new(two_link_arm()).unwrap();
    let target = [0.0, 0.0];
    let limits = [f64::INFINITY; 2];
    let mut control = GravityCompensatedPd::new(&model, &target, &[0.0; 2], &[0.0; 2])
        .unwrap()
        .with_gravity_at(GravityAt::State)
        .with_limits(&limits);
    let run = simulation(&model, Integrator::RungeKutta4, 1e-3)
        .run_steps_from(
            &[0.7, 0.9],
            &[0.0, 0.0],
            1000,
            RunOptions::new().sample_every(10).controller(&mut control),
        )
        .unwrap();
    // Rounding of g, 1e-15 N·m, over a second.
    assert!((run.q[0] - 0.7).abs() < 1e-13 && (run.q[1] - 0.9).abs() < 1e-13, "{:?}", run.q);

    let weak =
        GravityCompensatedPd::new(&model, &target, &[1.0; 2], &[1.0; 2]).unwrap().with_limits(&[5.0, 12.0]);
    assert_eq!(weak.overloaded_coordinates(), [0], "5 N·m do not hold 24.5");
}

/// Samples at the stride, the first one and the last one, with times, torques and energies.
#[test]
fn samples_are_kept_at_the_stride() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut ramp = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau.fill(t);
    let run = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_steps_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            25,
            RunOptions::new().sample_every(10).controller(&mut ramp),
        )
        .unwrap();
    let times: Vec<f64> = run.trajectory.iter().map(|sample| sample.time).collect();
    assert_eq!(times, [0.0, 0.1, 0.2, 0.25]);
    assert_eq!(run.trajectory.sample(2).tau, [0.2, 0.2]);
    let last = run.trajectory.sample(3);
    assert_eq!((last.q, last.v, last.energy()), (&run.q[..], &run.v[..], run.energy_account.now()));
    assert_eq!(run.trajectory.sample(0).energy(), run.energy_account.start());
    assert_eq!((run.steps, run.interrupted), (25, false));
    assert_eq!(run.peak_torque, [0.24, 0.24]);
}

/// If an observer breaks off, the run up to that step is kept.
#[test]
fn interrupted_run_keeps_its_steps() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut stop_at_17 = |info: &StepInfo<'_>| {
        if info.step == 17 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let run = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_steps_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            1000,
            RunOptions::new().sample_every(10).observer(&mut stop_at_17),
        )
        .unwrap();
    assert!(run.interrupted && run.steps == 17);
    assert_eq!(run.trajectory.sample(run.trajectory.len() - 1).time, 0.17);
}

/// A controller with the wrong sign makes the arm diverge. The error names time, step and coordinate, and the
/// samples before it are kept and finite.
#[test]
fn diverging_run_keeps_its_samples() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut runaway = |_: f64, _: &[f64], v: &[f64], tau: &mut [f64]| tau[1] = 1e4 * v[1] + 1.0;
    let failure = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_steps_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            100_000,
            RunOptions::new().sample_every(10).controller(&mut runaway),
        )
        .unwrap_err();
    let RunError::Diverged { coordinate, step, time, .. } = &failure.error else { panic!("{failure}") };
    assert!(coordinate == "elbow" || coordinate == "shoulder", "{failure}");
    assert!(*step > 0 && (*time - *step as f64 * 0.01).abs() < 1e-9, "{failure}");
    assert!(failure.until.steps >= 1 && failure.until.steps <= *step);
    assert!(failure.until.trajectory.iter().all(|s| s.q.iter().chain(s.v).all(|x| x.is_finite())));

    let mut broken = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau[0] = 0.0;
        tau[1] = if t > 0.045 { f64::NAN } else { 0.0 };
    };
    let failure = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_steps_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            100,
            RunOptions::new().sample_every(10).controller(&mut broken),
        )
        .unwrap_err();
    assert_eq!(failure.until.steps, 5);
    let RunError::StepInput { step: 5, time: 0.05, .. } = failure.error else { panic!("{failure}") };
    let text = "t = 0.05 s (step 5): torque[1] (coordinate `elbow`) is NaN; every number must be finite";
    assert_eq!((failure.kind(), failure.to_string()), (ErrorKind::InvalidInput, text.to_owned()));
}

/// A controller that fails ends the run. The error has the time and the cause in its own type, and the steps
/// before it are kept. A closure that cannot fail needs no `Result`.
#[test]
fn failing_controller_ends_run() {
    #[derive(Debug, PartialEq)]
    struct Overheated {
        joint: &'static str,
    }
    impl std::fmt::Display for Overheated {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            write!(f, "the motor of `{}` is too hot", self.joint)
        }
    }
    impl std::error::Error for Overheated {}
    let model = Model::new(two_link_arm()).unwrap();
    let mut hot = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau.fill(0.5);
        if t < 0.065 { Ok(()) } else { Err(Overheated { joint: "elbow" }) }
    };
    let mut seen = 0;
    let mut simulation = simulation(&model, Integrator::RungeKutta4, 0.01);
    let failure = simulation
        .run_steps_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            100,
            RunOptions::new().controller(&mut hot).observer(&mut |_| {
                seen += 1;
                ControlFlow::Continue(())
            }),
        )
        .unwrap_err();
    let RunError::Controller { step: 7, time, source: ControllerError::Callback(cause) } = &failure.error
    else {
        panic!("{failure}")
    };
    assert!((time - 0.07).abs() < 1e-15, "{failure}");
    assert_eq!(cause.downcast_ref::<Overheated>(), Some(&Overheated { joint: "elbow" }));
    assert_eq!((seen, failure.until.steps, failure.until.trajectory.len()), (7, 7, 7));
    assert!(failure.until.q[1] != 0.2 && failure.until.q.iter().all(|q| q.is_finite()));
    assert!(failure.until.energy_account.work() != 0.0);

    // An error of the library keeps its type through a closure.
    let mut inner = ConstantTorque(vec![f64::NAN, 0.0]);
    let mut outer = |t: f64, q: &[f64], v: &[f64], tau: &mut [f64]| inner.torque(t, q, v, tau);
    let failure = simulation
        .run_steps_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            1,
            RunOptions::new().sample_every(10).controller(&mut outer),
        )
        .unwrap_err();
    let RunError::Controller { source: ControllerError::Motion(MotionError::Input(error)), .. } =
        &failure.error
    else {
        panic!("{failure}")
    };
    assert!(matches!(error.problem, InputProblem::NotFinite { index: Some(0), .. }), "{error}");
}

#[test]
fn run_from_invalid_configuration_is_an_error() {
    let model = damped_tree(1);
    let mut q = neutral(&model);
    q[6] = 0.5;
    let v = vec![0.0; model.nv()];
    let failure = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_steps_from(&q, &v, 10, RunOptions::new().sample_every(10))
        .unwrap_err();
    let RunError::Input(error) = &failure.error else { panic!("{failure}") };
    assert!(matches!(error.problem, InputProblem::NotAUnitQuaternion { first: 3, .. }), "{error}");
    assert!(failure.until.trajectory.is_empty() && failure.until.steps == 0);
}

/// A torque equal to the weight holds a robot at rest, through `dyn Controller`.
#[test]
fn boxed_controller_holds_weight() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut weight = vec![0.0; 2];
    gravity(&model, &mut robot_dynamics::model::Workspace::new(&model), &[0.7, 0.9], &mut weight);
    let mut controller: Box<dyn Controller> = Box::new(ConstantTorque(weight));
    let run = simulation(&model, Integrator::VariationalMidpoint, 1e-3)
        .run_steps_from(
            &[0.7, 0.9],
            &[0.0, 0.0],
            100,
            RunOptions::new().sample_every(10).controller(controller.as_mut()),
        )
        .unwrap();
    assert!((run.q[0] - 0.7).abs() < 1e-13 && (run.q[1] - 0.9).abs() < 1e-13, "{:?}", run.q);
}
