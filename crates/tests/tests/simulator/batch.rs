//! Simulations of a batch equal single simulations bit for bit, whether or not they run in the lanes of one
//! register.

use std::sync::atomic::AtomicBool;

use robot_dynamics::batch::{SimulationBatch, Threads};
use robot_dynamics::description::{JointKinds, Limits, RandomRobotOptions, pendulum, random_robot};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Integrator, Method, RunError, Simulation, SimulationBuilder};

/// A random robot with effort limits that some torques exceed.
fn robot(number: usize, kinds: JointKinds) -> Model {
    let options = RandomRobotOptions { joints: 1 + (3 * number) % 9, kinds, ..Default::default() };
    let mut robot = random_robot(number as u64, &options);
    for joint in &mut robot.joints {
        joint.limits = Limits::default().with_effort(0.8);
    }
    Model::new(robot).expect("a robot")
}

/// Copies of a simulation in random states under random torques.
fn copies(simulation: &Simulation, count: usize, seed: u64) -> Vec<Simulation> {
    let mut random = SplitMix64::new(seed);
    let model = simulation.model();
    let mut copies = vec![simulation.clone(); count];
    for copy in &mut copies {
        let state = random_state(model, &mut random);
        copy.reset(&state.q, &state.v).expect("a start");
        copy.set_torques(&state.tau);
    }
    copies
}

fn batch_of(copies: &[Simulation], threads: usize) -> SimulationBatch {
    let threads = Threads::start(threads).expect("threads");
    let mut batch = SimulationBatch::new(&copies[0], copies.len(), &threads);
    batch.simulations_mut().clone_from_slice(copies);
    batch
}

/// Asserts that all that a step changes is equal bit for bit.
fn assert_same(one: &Simulation, other: &Simulation, case: &str) {
    assert_eq!((one.q(), one.v()), (other.q(), other.v()), "{case}");
    assert_eq!((one.time(), one.steps()), (other.time(), other.steps()), "{case}");
    assert_eq!(one.acceleration(), other.acceleration(), "{case}");
    assert_eq!(one.energy_account(), other.energy_account(), "{case}");
    assert_eq!(one.applied_torques(), other.applied_torques(), "{case}");
    assert_eq!(one.steps_at_effort_limits(), other.steps_at_effort_limits(), "{case}");
}

#[test]
fn batches_equal_single_simulations_bit_for_bit() {
    let rows = Integrator::ALL.into_iter().filter(|row| row.is_explicit());
    for (row, number) in rows.flat_map(|row| (0..6).map(move |number| (row, number))) {
        let kinds = [JointKinds::SingleDof, JointKinds::VectorSpace, JointKinds::All][number % 3];
        let model = robot(number, kinds);
        let builder = SimulationBuilder::new(&model).method(Method::Fixed(row)).dt(2e-3);
        let simulation = if number < 3 { builder.build() } else { builder.conservative().build() };
        let mut single = copies(&simulation.expect("a simulation"), 21, number as u64);
        let mut batch = batch_of(&single, 1 + number % 2);
        for steps in [1, 7, 12] {
            assert!(batch.step(steps, &AtomicBool::new(false)).is_empty());
            for own in &mut single {
                (0..steps).for_each(|_| own.step().expect("a step"));
            }
        }
        for (own, other) in single.iter().zip(batch.simulations()) {
            assert_same(own, other, &format!("{row:?}, robot {number}"));
        }
    }
}

/// One simulation has a torque of NaN, one an angle beyond the range of the lanes' sine, and one moves so
/// fast that it diverges. Each ends or continues as it does alone, and the others are not affected.
#[test]
fn failed_simulations_do_not_affect_others() {
    let model = Model::new(pendulum(2.0, 0.5)).expect("a pendulum");
    let builder = SimulationBuilder::new(&model).method(Method::Fixed(Integrator::RungeKutta4));
    let mut single = copies(&builder.build().expect("a simulation"), 19, 5);
    single[3].set_torques(&[f64::NAN]);
    single[4].reset(&[2.5e5], &[1.0]).expect("a start");
    single[9].reset(&[0.0], &[1e11 - 1e5]).expect("a start");
    single[9].set_torques(&[1e10]);
    single[12].set_torques(&[1e308]);
    let mut batch = batch_of(&single, 2);
    let which: Vec<bool> = (0..19).map(|number| number != 7).collect();
    let failed = batch.step_where(&which, 40, &AtomicBool::new(false));
    let mut expected: Vec<(usize, RunError)> = Vec::new();
    for (number, own) in single.iter_mut().enumerate().filter(|(number, _)| which[*number]) {
        if let Err(failure) = (0..40).try_for_each(|_| own.step()) {
            expected.push((number, failure));
        }
    }
    // As texts, because the first error contains NaN.
    assert_eq!(format!("{failed:?}"), format!("{expected:?}"));
    assert_eq!(failed.iter().map(|(number, _)| *number).collect::<Vec<_>>(), [3, 9, 12]);
    assert!(matches!(failed[1].1, RunError::Diverged { .. }), "{}", failed[1].1);
    for (number, (own, other)) in single.iter().zip(batch.simulations()).enumerate() {
        assert_same(own, other, &format!("simulation {number}"));
    }
    assert_eq!((batch.simulations()[7].steps(), batch.simulations()[4].steps()), (0, 40));
}

/// A batch may hold simulations of different robots and steps.
#[test]
fn simulations_of_batch_may_differ() {
    let of = |length: f64, step: f64| {
        let model = Model::new(pendulum(2.0, length)).expect("a pendulum");
        SimulationBuilder::new(&model).dt(step).build().expect("a simulation")
    };
    let mut single = copies(&of(0.5, 1e-3), 9, 3);
    (single[2], single[8]) = (of(0.7, 1e-3), of(0.5, 2e-3));
    let mut batch = batch_of(&single, 1);
    assert!(batch.step(15, &AtomicBool::new(false)).is_empty());
    for (number, (own, other)) in single.iter_mut().zip(batch.simulations()).enumerate() {
        (0..15).for_each(|_| own.step().expect("a step"));
        assert_same(own, other, &format!("simulation {number}"));
    }
}
