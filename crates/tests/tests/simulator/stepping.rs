//! Single steps, restored snapshots and copies give the same results as one run, bit for bit.

use robot_dynamics::description::{
    ActuatorDescription, Limits, PassiveForces, RandomRobotOptions, Transmission, pendulum, random_robot,
};
use robot_dynamics::model::{Model, neutral};
use robot_dynamics::simulation::{
    Event, Integrator, Method, RunError, RunOptions, Simulation, SimulationBuilder,
};
use robot_dynamics::{Classified, ErrorKind};

use crate::hopper::hopper;

/// A random robot with damping, friction, limits and a servo.
fn robot(seed: u64) -> Model {
    let mut robot = random_robot(seed, &RandomRobotOptions::default());
    for joint in &mut robot.joints {
        joint.passive = PassiveForces::default().with_damping(0.05).with_friction(0.02);
    }
    let model = Model::new(robot.clone()).expect("a robot");
    if let Some(joint) = model.joints().iter().find(|joint| joint.nv == 1) {
        let servo = ActuatorDescription::new("servo", Transmission::joint(joint.name.clone(), 1.0));
        robot.actuators.push(servo.servo(5.0, 0.5));
    }
    Model::new(robot).expect("a robot")
}

fn simulations(model: &Model) -> Vec<Simulation> {
    let rows = [Integrator::RungeKutta4, Integrator::SemiImplicitEuler].map(Method::Fixed);
    let methods = rows.into_iter().chain([Method::Implicit, Method::Mujoco]);
    methods
        .map(|method| SimulationBuilder::new(model).method(method).build().expect("a simulation"))
        .collect()
}

fn start(simulation: &mut Simulation, model: &Model) {
    let v: Vec<f64> = (0..model.nv()).map(|k| 0.3 * (k as f64).cos()).collect();
    simulation.reset(&neutral(model), &v).expect("a start");
    let torques: Vec<f64> = (0..model.nv()).map(|k| 0.1 * (k as f64 + 1.0).sin()).collect();
    simulation.set_torques(&torques);
    let controls = vec![0.4; simulation.control_names().count()];
    simulation.set_controls(&controls);
}

#[test]
fn single_steps_equal_run_bit_for_bit() {
    for seed in 0..6 {
        let model = robot(seed);
        for mut one in simulations(&model) {
            let mut other = one.clone();
            start(&mut one, &model);
            start(&mut other, &model);
            let run = one.run_steps(60, RunOptions::new()).expect("a run");
            for k in 1..=60 {
                other.step().expect("a step");
                assert_eq!(run.trajectory.sample(k).q, other.q(), "robot {seed}, {}, step {k}", one.method());
                assert_eq!(run.trajectory.sample(k).time, other.time());
            }
            assert_eq!((one.v(), one.energy_account()), (other.v(), other.energy_account()), "robot {seed}");
            assert_eq!(one.acceleration(), other.acceleration());
        }
    }
}

#[test]
fn two_runs_equal_one_bit_for_bit() {
    for seed in 0..4 {
        let model = robot(seed);
        for mut one in simulations(&model) {
            let mut other = one.clone();
            start(&mut one, &model);
            start(&mut other, &model);
            one.run_steps(60, RunOptions::new()).expect("a run");
            other.run_steps(23, RunOptions::new()).expect("a run");
            let second = other.run_steps(37, RunOptions::new()).expect("a run");
            assert_eq!((one.q(), one.v(), one.time()), (other.q(), other.v(), other.time()));
            assert_eq!(second.trajectory.sample(0).time, 0.023);
        }
    }
}

#[test]
fn snapshots_and_copies_continue_bit_for_bit() {
    for seed in 0..4 {
        let model = robot(seed);
        for mut simulation in simulations(&model) {
            start(&mut simulation, &model);
            simulation.run_for(0.03).expect("steps");
            let (snapshot, mut copy) = (simulation.snapshot(), simulation.clone());
            simulation.run_for(0.03).expect("steps");
            let (q, v) = (simulation.q().to_vec(), simulation.v().to_vec());
            copy.run_for(0.03).expect("steps");
            assert_eq!((copy.q(), copy.v()), (&q[..], &v[..]));
            simulation.set_torques(&vec![0.0; model.nv()]);
            simulation.run_for(0.01).expect("steps");
            simulation.restore(&snapshot);
            simulation.run_for(0.03).expect("steps");
            assert_eq!((simulation.q(), simulation.v()), (&q[..], &v[..]));
            assert_eq!(simulation.energy_account(), copy.energy_account());
        }
    }
}

/// A robot that stands on the ground: its contacts also continue from a snapshot.
#[test]
fn contacts_continue_from_snapshot() {
    let (mut simulation, _) = hopper();
    simulation.run_for(0.3).expect("steps");
    let snapshot = simulation.snapshot();
    simulation.run_for(0.1).expect("steps");
    let (q, contacts) = (simulation.q().to_vec(), simulation.contacts().len());
    assert!(contacts > 0);
    simulation.restore(&snapshot);
    for _ in 0..100 {
        simulation.step().expect("a step");
    }
    assert_eq!(simulation.q(), q);
}

/// After a terminal event the next steps count from its time.
#[test]
fn simulation_continues_after_terminal_event() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).conservative().build().expect("a simulation");
    let mut events = [Event::new("low", |_, q: &[f64], _: &[f64]| q[0] - 0.7).rising().terminal()];
    let run = simulation.run_steps(10_000, RunOptions::new().events(&mut events)).expect("a run");
    assert!(run.ended_by_event && (run.q[0] - 0.7).abs() < 1e-12);
    let time = simulation.time();
    simulation.run_for(0.1).expect("steps");
    assert!((simulation.time() - time - 0.1).abs() < 1e-15);
    assert!(simulation.energy_account().drift() < 1e-9);
}

/// A failed step leaves the state unchanged.
#[test]
fn failed_step_leaves_state_unchanged() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].limits = Limits::default().with_effort(5.0);
    let model = Model::new(robot).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    simulation.run_for(0.1).expect("steps");
    let before = (simulation.q().to_vec(), simulation.time());
    simulation.set_torques(&[f64::INFINITY]);
    let error = simulation.step().expect_err("no torque");
    assert!(matches!(error, RunError::StepInput { step: 100, .. }), "{error}");
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    let text = "t = 0.1 s (step 100): torque[0] (coordinate `hinge`) is inf; every number must be finite";
    assert_eq!(error.to_string(), text);
    assert_eq!((simulation.q().to_vec(), simulation.time()), before);
    simulation.set_torques(&[0.0]);
    simulation.step().expect("a step");
}

/// A duration counts as the nearest whole number of steps, in a run, between samples, and in `run_for`.
#[test]
fn durations_are_rounded_to_whole_steps() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).dt(0.01).build().expect("a simulation");
    let mut by_steps = simulation.clone();
    let options = RunOptions::new().sample_period(0.03);
    let run = simulation.run_from(&[0.3], &[0.0], 0.104, options).expect("a run");
    let same = by_steps.run_steps_from(&[0.3], &[0.0], 10, RunOptions::new().sample_every(3)).expect("a run");
    assert_eq!((run.steps, &run.q, &run.trajectory), (10, &same.q, &same.trajectory));
    let times: Vec<f64> = run.trajectory.iter().map(|sample| sample.time).collect();
    assert_eq!(times, [0.0, 0.03, 0.06, 0.09, 0.1]);
    simulation.run_for(0.0951).expect("steps");
    assert_eq!((simulation.steps_in(0.0951).unwrap(), simulation.record().steps), (10, 20));
    let ends = simulation.run(0.05, RunOptions::new().sample_ends()).expect("a run");
    assert_eq!((ends.trajectory.len(), ends.steps), (2, 25));
}

/// An invalid duration or interval is an error, and the simulation is unchanged.
#[test]
fn invalid_durations_are_errors() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    simulation.run_for(0.1).expect("steps");
    let before = (simulation.q().to_vec(), simulation.time());
    for duration in [-0.1, f64::NAN, f64::INFINITY, 1e10] {
        let is_bad = |error: &RunError| matches!(error, RunError::Input(_));
        let failure = simulation.run(duration, RunOptions::new()).expect_err("a bad duration");
        assert!(is_bad(&failure.error) && failure.until.q == before.0, "{failure}");
        assert!(is_bad(&simulation.run_for(duration).expect_err("a bad duration")));
        let options = RunOptions::new().sample_period(duration);
        assert!(is_bad(&simulation.run(0.1, options).expect_err("a bad interval").error));
        assert_eq!((simulation.q().to_vec(), simulation.time()), before);
    }
}

/// A restored snapshot also has the results of its last step, which the sensors read.
#[test]
fn snapshots_restore_the_results_of_their_last_step() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a robot");
    let mut simulation = SimulationBuilder::new(&model).build().expect("a simulation");
    simulation.set_torques(&[1.5]);
    simulation.run_for(0.1).expect("steps");
    let results = |simulation: &Simulation| {
        (
            simulation.acceleration().to_vec(),
            simulation.applied_torques().to_vec(),
            simulation.joint_reactions(),
        )
    };
    let (snapshot, before) = (simulation.snapshot(), results(&simulation));
    simulation.set_torques(&[-4.0]);
    simulation.run_for(0.1).expect("steps");
    assert_ne!(results(&simulation), before);
    simulation.restore(&snapshot);
    assert_eq!(results(&simulation), before);
}
