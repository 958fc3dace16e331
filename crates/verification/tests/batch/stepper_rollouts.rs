//! Rollouts of batches by a stepper against single steps, with any number of threads.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::Vector3;
use robot_dynamics::InvalidInput;
use robot_dynamics::batch::{
    BatchOptions, BatchWorkspace, PolicyInput, RolloutError, RolloutProgress, RolloutStates, StepperRollout,
    Torques, rollout_by_stepper,
};
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    Base, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Method, SimulationBuilder, SimulationStepper, StepForces, StepWorkspace, Stepper,
};

const STEPS: usize = 150;

fn brick() -> (Model, SimulationStepper) {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    let mass = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    robot.links.push(LinkDescription::new("brick", mass));
    let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    let model = Model::new(robot).unwrap();
    let builder = SimulationBuilder::new(&model).method(Method::Implicit).ground(Ground::level(0.0));
    let implicit = builder.build().unwrap().stepper();
    (model, implicit)
}

/// Bricks thrown at the ground.
fn thrown(model: &Model, count: usize) -> (Vec<f64>, Vec<f64>) {
    let mut random = SplitMix64::new(5);
    let (mut q, mut v) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let mut state = random_state(model, &mut random);
        state.q[2] = 0.25;
        q.extend(state.q);
        v.extend(state.v);
    }
    (q, v)
}

fn workspace(model: &Model, threads: usize) -> BatchWorkspace<f64> {
    let mut options = BatchOptions::default();
    options.threads = threads;
    BatchWorkspace::with_options(model, options).unwrap()
}

/// The torques of a policy: a force against the velocity, and an upward force.
fn brake(at: PolicyInput<'_, f64>, tau: &mut [f64]) {
    assert_eq!(at.states, 1);
    tau.iter_mut().zip(at.v).for_each(|(tau, v)| *tau = -0.5 * v);
    tau[2] += 2.0 * (1.0 - at.time);
}

#[test]
fn threads_match_single_steps_bit_for_bit() {
    let (model, implicit) = brick();
    let (q0, v0) = thrown(&model, 23);
    // One after the other.
    let (mut q1, mut v1, mut way) = (q0.clone(), v0.clone(), Vec::new());
    for (k, (q, v)) in q1.chunks_mut(7).zip(v1.chunks_mut(6)).enumerate() {
        let (mut stepper, mut w, mut tau) = (implicit.clone(), StepWorkspace::new(&model), [0.0; 6]);
        for step in 0..STEPS {
            tau.iter_mut().zip(&*v).for_each(|(tau, v)| *tau = -0.5 * v);
            tau[2] += 2.0 * (1.0 - step as f64 * 1e-3);
            stepper.step(&model, &mut w, &StepForces::new(&tau, true), 1e-3, q, v).unwrap();
            if (step + 1) % 40 == 0 {
                way.push((k, q.to_vec(), v.to_vec()));
            }
        }
    }
    for threads in [1, 2, 3] {
        let (mut q, mut v) = (q0.clone(), v0.clone());
        let how = StepperRollout::new(&implicit, 1e-3, STEPS).with_stride(40);
        assert_eq!(how.samples(), 3);
        let (mut q_way, mut v_way) = (vec![0.0; 23 * 3 * 7], vec![0.0; 23 * 3 * 6]);
        let (w, policy) = (workspace(&model, threads), Torques::Policy(&brake));
        let counted = AtomicU64::new(0);
        let count = |progress: RolloutProgress| {
            assert_eq!(progress.total, 23 * STEPS as u64);
            counted.fetch_max(progress.done, Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        let states =
            RolloutStates { q: &mut q, v: &mut v, q_trajectory: &mut q_way, v_trajectory: &mut v_way };
        rollout_by_stepper(&model, &w, &how, policy, states, Some(&count)).unwrap();
        assert_eq!((&q, &v), (&q1, &v1), "{threads} threads");
        assert_eq!(counted.into_inner(), 23 * STEPS as u64);
        for ((_, q, v), (q_row, v_row)) in way.iter().zip(q_way.chunks(7).zip(v_way.chunks(6))) {
            assert_eq!((&q[..], &v[..]), (q_row, v_row));
        }
    }
}

#[test]
fn tables_of_torques_are_read_by_rows() {
    let (model, implicit) = brick();
    let (q0, v0) = thrown(&model, 4);
    let run = |torques: Torques<'_, f64>| {
        let (mut q, mut v) = (q0.clone(), v0.clone());
        let (w, how) = (workspace(&model, 2), StepperRollout::new(&implicit, 1e-3, 10));
        rollout_by_stepper(&model, &w, &how, torques, RolloutStates::ends(&mut q, &mut v), None).unwrap();
        (q, v)
    };
    let held: Vec<f64> = (0..24).map(|k| 0.1 * f64::from(k)).collect();
    let each: Vec<f64> = held.chunks(6).flat_map(|row| row.repeat(10)).collect();
    assert_eq!(run(Torques::Held(&held)), run(Torques::EachStep(&each)));
    assert_ne!(run(Torques::Held(&held)), run(Torques::Zero));
}

/// A bad state is named and affects no other state; a cancelled state is unchanged.
#[test]
fn bad_and_cancelled_states_are_named() {
    let (model, implicit) = brick();
    let (q0, mut v0) = thrown(&model, 6);
    v0[6 * 4 + 1] = f64::NAN;
    let how = StepperRollout::new(&implicit, 1e-3, STEPS);
    let (mut q, mut v) = (q0.clone(), v0.clone());
    let w = workspace(&model, 2);
    let error =
        rollout_by_stepper(&model, &w, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None);
    let Err(RolloutError::BadStates(bad)) = error else { panic!("{error:?}") };
    assert_eq!((bad.states, bad.batch), (vec![4], 6));
    assert!(q[7 * 4..7 * 5].iter().all(|x| x.is_nan()) && q[..7 * 4].iter().all(|x| x.is_finite()));

    let (mut q, mut v) = (q0.clone(), v0.clone());
    let w = workspace(&model, 1);
    let stop = |progress: RolloutProgress| match progress.done {
        0..200 => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    };
    let error =
        rollout_by_stepper(&model, &w, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), Some(&stop));
    let Err(RolloutError::Cancelled { unfinished, batch: 6 }) = error else { panic!("{error:?}") };
    assert_eq!(unfinished, [1, 2, 3, 4, 5]);
    assert_eq!(q[7..], q0[7..]);
    assert_ne!(q[..7], q0[..7]);

    let how = StepperRollout::new(&implicit, -1.0, 1);
    let error =
        rollout_by_stepper(&model, &w, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None);
    let bad_step = InvalidInput::out_of_range("the step", -1.0, "s", "positive and finite");
    assert_eq!(error, Err(RolloutError::Input(bad_step)));
}
