//! Runs: the books balance, controllers act, and what goes wrong is said and keeps what was computed.

use std::ops::ControlFlow;

use crate::common::damped_tree;
use dynamics::{Integrator, PdHold, Reach2R, SplitMix64, hold};
use multibody::simulator::{Effect, Method, RunOptions, Simulation, SimulationBuilder};
use multibody::{
    ConstantTorque, Controller, ControllerError, GravityAt, GravityCompensatedPd, JointDescription,
    JointKind, Limits, LinkDescription, Model, PassiveForces, Pose, RobotDescription, Run, RunError,
    StepInfo, gravity, neutral, random_state,
};
use nalgebra::{Matrix3, Vector3, vector};

fn simulation(model: &Model, integrator: Integrator, step: f64) -> Simulation {
    SimulationBuilder::new(model)
        .method(Method::Fixed(integrator))
        .without(Effect::EffortLimits)
        .step(step)
        .build()
        .unwrap()
}

fn two_link_arm() -> RobotDescription {
    let mut robot = RobotDescription::new("2R");
    robot.links.push(LinkDescription::new("base", None));
    for (name, mass) in [("upper", 2.0), ("fore", 1.0)] {
        let moment = mass / 12.0;
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.0, moment, moment));
        let rod = dynamics::MassProperties::new(mass, Vector3::new(0.5, 0.0, 0.0), inertia).unwrap();
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

/// Motors work, dampers take out, on floating and ball joints: the imbalance falls with the order of the row,
/// and the energy itself does not stay.
#[test]
fn the_books_balance_to_the_order_of_the_row() {
    for seed in 0..6 {
        let model = damped_tree(seed);
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let mut torque = ConstantTorque(state.tau.iter().map(|tau| 0.1 * tau).collect());
        for row in Integrator::ALL {
            let (h, steps) = (2e-3, 250);
            let mut run = |h: f64, steps: usize| -> Run {
                simulation(&model, row, h)
                    .run_from(
                        &state.q,
                        &state.v,
                        steps,
                        RunOptions::new().sample_every(10).controller(&mut torque),
                    )
                    .unwrap()
            };
            let (coarse, fine) = (run(h, steps), run(h / 2.0, 2 * steps));
            let (work, dissipated) = (fine.ledger.work().abs(), fine.ledger.dissipated());
            assert!(work > 0.05 && dissipated > 0.05, "robot {seed}: {work} J, {dissipated} J");
            let order = (coarse.ledger.max_imbalance() / fine.ledger.max_imbalance()).log2();
            let largest = fine.ledger.max_imbalance();
            println!("robot {seed} {row:22} imbalance {largest:.1e} J, order {order:.2}");
            // Below 1e-10 J what is left is rounding; the maximum over a run sits at different times.
            assert!(
                order > f64::from(row.order()) - 0.5 || largest < 1e-10,
                "robot {seed}, {row}: order {order}, {largest:e} J"
            );
        }
    }
}

/// A damped brick afloat, spun: all its kinetic energy ends up in the damper of the ball joint's books.
#[test]
fn damping_takes_all_the_energy_out() {
    let mut robot = RobotDescription::new("top");
    robot.gravity = [0.0; 3];
    let brick = dynamics::MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    for name in ["ground", "brick"] {
        robot.links.push(LinkDescription::new(name, brick));
    }
    let ball = JointDescription::new("ball", JointKind::Spherical, "ground", "brick", Pose::IDENTITY);
    let passive = PassiveForces::default().with_damping(0.05);
    robot.joints.push(ball.with_passive(passive));
    let model = Model::new(robot).unwrap();
    for row in Integrator::ALL {
        let run = simulation(&model, row, 1e-3)
            .run_from(&neutral(&model), &[3.0, -2.0, 4.0], 30_000, RunOptions::new().sample_every(10))
            .unwrap();
        let ledger = &run.ledger;
        assert!(ledger.now() < 1e-6 * ledger.start(), "{row}: {} J left", ledger.now());
        let missing = (ledger.dissipated() / ledger.start() - 1.0).abs();
        // First order: ½ h · (damping/inertia ≈ 2/s, rates ≈ 5/s) = 0.3 %.
        let allowed = if row.order() == 1 { 5e-3 } else { 1e-5 };
        assert!(missing < allowed, "{row}: {missing:e}");
    }
}

/// The controller of the chapter on the described arm: peaks and end as `dynamics::hold` has them.
#[test]
fn the_held_arm_is_the_chapter_s() {
    let model = Model::new(two_link_arm()).unwrap();
    let (target, stiffness, damping) = ([1.6, 0.4], [60.0, 30.0], [20.0, 6.0]);
    let mut control = GravityCompensatedPd::new(&model, &target, &stiffness, &damping).unwrap();
    let run = simulation(&model, Integrator::RungeKutta4, 1e-3)
        .run_from(
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
        // The motion contracts: roundings do not grow.
        assert!((run.q[k] - report.q[k]).abs() < 1e-12, "{} {}", run.q[k], report.q[k]);
        assert!((run.peak_torque[k] - report.peak_torque[k]).abs() < 1e-12);
        assert!((control.peak_demand()[k] - report.peak_demand[k]).abs() < 1e-11);
    }
    assert_eq!(run.peak_torque[0], 20.0, "the shoulder is cut off at its limit");
    assert!(control.peak_demand()[0] > 20.0);
}

/// With g(q) the closed loop without gains floats: the arm stays where it is put, at any pose.
#[test]
fn gravity_at_the_state_lets_the_arm_float() {
    let model = Model::new(two_link_arm()).unwrap();
    let target = [0.0, 0.0];
    let limits = [f64::INFINITY; 2];
    let mut control = GravityCompensatedPd::new(&model, &target, &[0.0; 2], &[0.0; 2])
        .unwrap()
        .with_gravity_at(GravityAt::State)
        .with_limits(&limits);
    let run = simulation(&model, Integrator::RungeKutta4, 1e-3)
        .run_from(&[0.7, 0.9], &[0.0, 0.0], 1000, RunOptions::new().sample_every(10).controller(&mut control))
        .unwrap();
    // Rounding of g, 1e-15 N·m, over a second.
    assert!((run.q[0] - 0.7).abs() < 1e-13 && (run.q[1] - 0.9).abs() < 1e-13, "{:?}", run.q);

    let weak =
        GravityCompensatedPd::new(&model, &target, &[1.0; 2], &[1.0; 2]).unwrap().with_limits(&[5.0, 12.0]);
    assert_eq!(weak.overloaded_coordinates(), [0], "5 N·m do not hold 24.5");
}

/// Samples at the stride, the first and the last; times, torques and energies in them.
#[test]
fn samples_are_kept_at_the_stride() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut ramp = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau.fill(t);
    let run = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_from(&[0.1, 0.2], &[0.0, 0.0], 25, RunOptions::new().sample_every(10).controller(&mut ramp))
        .unwrap();
    let times: Vec<f64> = run.trajectory.iter().map(|sample| sample.time).collect();
    assert_eq!(times, [0.0, 0.1, 0.2, 0.25]);
    assert_eq!(run.trajectory.sample(2).tau, [0.2, 0.2]);
    let last = run.trajectory.sample(3);
    assert_eq!((last.q, last.v, last.energy()), (&run.q[..], &run.v[..], run.ledger.now()));
    assert_eq!(run.trajectory.sample(0).energy(), run.ledger.start());
    assert_eq!((run.steps, run.interrupted), (25, false));
    assert_eq!(run.peak_torque, [0.24, 0.24]);
}

/// An observer that breaks off keeps the run up to there.
#[test]
fn an_interrupted_run_keeps_what_it_did() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut stop_at_17 = |info: &StepInfo<'_>| {
        if info.step == 17 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let run = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            1000,
            RunOptions::new().sample_every(10).observer(&mut stop_at_17),
        )
        .unwrap();
    assert!(run.interrupted && run.steps == 17);
    assert_eq!(run.trajectory.sample(run.trajectory.len() - 1).time, 0.17);
}

/// A controller with the wrong sign blows the arm up: the error names time, step and coordinate, and the
/// samples until then are there, all finite.
#[test]
fn a_blow_up_is_an_error_that_keeps_the_samples() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut runaway = |_: f64, _: &[f64], v: &[f64], tau: &mut [f64]| tau[1] = 1e4 * v[1] + 1.0;
    let failure = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            100_000,
            RunOptions::new().sample_every(10).controller(&mut runaway),
        )
        .unwrap_err();
    let RunError::Diverged { coordinate, step, time, .. } = &failure.error else { panic!("{failure}") };
    assert!(coordinate == "elbow" || coordinate == "shoulder", "{failure}");
    assert!(*step > 0 && (*time - *step as f64 * 0.01).abs() < 1e-9, "{failure}");
    let message = failure.to_string();
    assert!(message.contains("step") && message.contains(coordinate.as_str()), "{message}");
    assert!(failure.until.steps >= 1 && failure.until.steps <= *step);
    assert!(failure.until.trajectory.iter().all(|s| s.q.iter().chain(s.v).all(|x| x.is_finite())));

    let mut broken = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau[0] = 0.0;
        tau[1] = if t > 0.045 { f64::NAN } else { 0.0 };
    };
    let failure = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_from(&[0.1, 0.2], &[0.0, 0.0], 100, RunOptions::new().sample_every(10).controller(&mut broken))
        .unwrap_err();
    assert_eq!(failure.until.steps, 5);
    let message = failure.to_string();
    assert!(message.contains("the controller's torque") && message.contains("`elbow`"), "{message}");
    assert!(message.contains("t = 0.05 s (step 5)"), "{message}");
}

/// A controller that fails ends the run: the error has the time and the cause in its own type, and the run until
/// then is there. A closure that cannot fail needs no `Result`.
#[test]
fn a_controller_that_fails_ends_the_run() {
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
        .run_from(
            &[0.1, 0.2],
            &[0.0, 0.0],
            100,
            RunOptions::new().controller(&mut hot).observer(&mut |_| {
                seen += 1;
                ControlFlow::Continue(())
            }),
        )
        .unwrap_err();
    assert_eq!(
        failure.to_string(),
        "the controller gave no torque at t = 0.07 s (step 7): the motor of `elbow` is too hot"
    );
    let RunError::Controller { step: 7, source: ControllerError::Callback(cause), .. } = &failure.error
    else {
        panic!("{failure}")
    };
    assert_eq!(cause.downcast_ref::<Overheated>(), Some(&Overheated { joint: "elbow" }));
    assert_eq!((seen, failure.until.steps, failure.until.trajectory.len()), (7, 7, 7));
    assert!(failure.until.q[1] != 0.2 && failure.until.q.iter().all(|q| q.is_finite()));
    assert!(failure.until.ledger.work() != 0.0);

    // An error of the library keeps its type on its way through a closure.
    let mut inner = ConstantTorque(vec![f64::NAN, 0.0]);
    let mut outer = |t: f64, q: &[f64], v: &[f64], tau: &mut [f64]| inner.torque(t, q, v, tau);
    let failure = simulation
        .run_from(&[0.1, 0.2], &[0.0, 0.0], 1, RunOptions::new().sample_every(10).controller(&mut outer))
        .unwrap_err();
    let RunError::Controller { source: ControllerError::NotFinite { index: 0, .. }, .. } = &failure.error
    else {
        panic!("{failure}")
    };
}

#[test]
fn a_run_from_no_configuration_does_not_start() {
    let model = damped_tree(1);
    let mut q = neutral(&model);
    q[6] = 0.5;
    let v = vec![0.0; model.nv()];
    let failure = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_from(&q, &v, 10, RunOptions::new().sample_every(10))
        .unwrap_err();
    assert!(matches!(failure.error, RunError::Configuration(_)), "{failure}");
    assert!(failure.until.trajectory.is_empty() && failure.until.steps == 0);
    assert!(failure.to_string().contains("quaternion"), "{failure}");
}

/// A torque equal to the weight holds a robot without followers of any kind still, through `dyn Controller`.
#[test]
fn a_boxed_controller_holds_the_weight() {
    let model = Model::new(two_link_arm()).unwrap();
    let mut weight = vec![0.0; 2];
    gravity(&model, &mut multibody::Workspace::new(&model), &[0.7, 0.9], &mut weight);
    let mut controller: Box<dyn Controller> = Box::new(ConstantTorque(weight));
    let run = simulation(&model, Integrator::VariationalMidpoint, 1e-3)
        .run_from(
            &[0.7, 0.9],
            &[0.0, 0.0],
            100,
            RunOptions::new().sample_every(10).controller(controller.as_mut()),
        )
        .unwrap();
    assert!((run.q[0] - 0.7).abs() < 1e-13 && (run.q[1] - 0.9).abs() < 1e-13, "{:?}", run.q);
}
