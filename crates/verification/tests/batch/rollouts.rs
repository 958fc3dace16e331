//! Rollouts of batches against the integrators of single states.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

use robot_dynamics::batch::{
    BatchFloat, BatchOptions, BatchWorkspace, PolicyInput, Rollout, RolloutError, RolloutStates, Torques,
    rollout,
};
use robot_dynamics::model::{InstructionSet, Model, difference, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, step};

use crate::common::{Robot, families, size};

fn explicit_rows() -> impl Iterator<Item = Integrator> {
    Integrator::ALL.into_iter().filter(|row| row.is_explicit())
}

fn workspace(model: &Model, threads: usize, no_avx512: bool) -> BatchWorkspace<f64> {
    let mut options = BatchOptions::default();
    options.threads = threads;
    options.limit = no_avx512.then_some(InstructionSet::Avx2);
    BatchWorkspace::with_options(model, options).unwrap()
}

/// q, v and tau of `count` slow states, which steps of 1e-4 s resolve.
fn states(model: &Model, count: usize, seed: u64) -> [Vec<f64>; 3] {
    let mut random = SplitMix64::new(seed);
    let [mut q, mut v, mut tau] = [(); 3].map(|()| Vec::new());
    for _ in 0..count {
        let state = random_state(model, &mut random);
        q.extend(state.q);
        v.extend(state.v);
        tau.extend(state.tau);
    }
    [q, v, tau]
}

fn how(integrator: Integrator, steps: usize) -> Rollout {
    Rollout::new(integrator, 1e-4, steps)
}

/// Robots with κ(M) below 1e4, whose accelerations are accurate to 1e-12 of their size.
fn robots() -> Vec<Robot> {
    families()
        .iter()
        .flat_map(|family| family.robots().take(6).collect::<Vec<_>>())
        .filter(|robot| robot.condition() < 1e4)
        .collect()
}

/// 100 steps of 1e-4 s: to 1e-12 of the largest number of the state, the accuracy of accelerations.
#[test]
fn rollouts_match_single_steps() {
    let mut kinds = 0;
    for robot in robots() {
        let model = &robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        let [q, v, tau] = states(model, 9, robot.seed);
        for integrator in explicit_rows() {
            for dissipation in [false, true] {
                let how = how(integrator, 100).with_dissipation(dissipation);
                let (mut q_end, mut v_end) = (q.clone(), v.clone());
                let mut batch = workspace(model, 1, robot.seed % 2 == 0);
                let trajectories = (&mut [][..], &mut [][..]);
                let held = Torques::Held(&tau[..]);
                let states = RolloutStates {
                    q: &mut q_end,
                    v: &mut v_end,
                    q_trajectory: trajectories.0,
                    v_trajectory: trajectories.1,
                };
                let result = rollout(model, &mut batch, &how, held, states, None);
                assert_eq!(result, Ok(()), "{} seed {}", robot.family, robot.seed);
                let mut single = StepWorkspace::new(model);
                for i in 0..9 {
                    let (mut q, mut v) = (q[i * nq..(i + 1) * nq].to_vec(), v[i * nv..(i + 1) * nv].to_vec());
                    let forces = StepForces::new(&tau[i * nv..(i + 1) * nv], dissipation);
                    for _ in 0..100 {
                        step(model, integrator, &mut single, &forces, 1e-4, &mut q, &mut v).unwrap();
                    }
                    let law = format!("{integrator} of state {i}");
                    let defect = crate::common::max_difference(&q_end[i * nq..(i + 1) * nq], &q);
                    robot.require(&format!("q by {law}"), defect, 1e-12 * size(&q).max(1.0));
                    let defect = crate::common::max_difference(&v_end[i * nv..(i + 1) * nv], &v);
                    robot.require(&format!("v by {law}"), defect, 1e-12 * size(&v).max(1.0));
                    kinds += 1;
                }
            }
        }
    }
    assert!(kinds > 500, "only {kinds} rollouts were judged");
}

fn floating() -> Robot {
    families().iter().find(|family| family.name == "floating trees").unwrap().robots().next().unwrap()
}

/// Held torques given step by step, with any number of threads and lanes, with and without a trajectory:
/// equal bit for bit.
#[test]
fn rollouts_are_the_same_bits_for_any_split() {
    let model = &floating().model;
    let (nq, nv, count, steps) = (model.nq(), model.nv(), 21, 70);
    let [q, v, tau] = states(model, count, 4);
    let each: Vec<f64> = tau.chunks(nv).flat_map(|tau| tau.repeat(steps)).collect();
    for integrator in explicit_rows() {
        let mut expected = None;
        for threads in [1, 2, 3] {
            for (no_avx512, torques, stride) in [
                (false, Torques::Held(&tau), 0),
                (true, Torques::EachStep(&each), 0),
                (false, Torques::EachStep(&each), 7),
            ] {
                let how = how(integrator, steps).with_stride(stride);
                let (mut q_end, mut v_end) = (q.clone(), v.clone());
                let mut q_path = vec![0.0; count * how.samples() * nq];
                let mut v_path = vec![0.0; count * how.samples() * nv];
                let mut batch = workspace(model, threads, no_avx512);
                let paths = (&mut q_path[..], &mut v_path[..]);
                let states = RolloutStates {
                    q: &mut q_end,
                    v: &mut v_end,
                    q_trajectory: paths.0,
                    v_trajectory: paths.1,
                };
                rollout(model, &mut batch, &how, torques, states, None).unwrap();
                if stride != 0 {
                    assert_eq!(how.samples(), 10);
                    for i in 0..count {
                        let last = (i + 1) * 10 * nq;
                        assert_eq!(q_path[last - nq..last], q_end[i * nq..(i + 1) * nq]);
                        let last = (i + 1) * 10 * nv;
                        assert_eq!(v_path[last - nv..last], v_end[i * nv..(i + 1) * nv]);
                    }
                }
                let (q_expected, v_expected) = expected.get_or_insert((q_end.clone(), v_end.clone()));
                assert!(*q_expected == q_end && *v_expected == v_end, "{integrator}, {threads} threads");
            }
        }
        // A part of the batch alone.
        let (q_expected, _) = expected.unwrap();
        let (mut q_end, mut v_end) = (q[5 * nq..].to_vec(), v[5 * nv..].to_vec());
        let mut batch = workspace(model, 1, false);
        let held = Torques::Held(&tau[5 * nv..]);
        let paths = (&mut [][..], &mut [][..]);
        let states =
            RolloutStates { q: &mut q_end, v: &mut v_end, q_trajectory: paths.0, v_trajectory: paths.1 };
        rollout(model, &mut batch, &how(integrator, steps), held, states, None).unwrap();
        assert_eq!(q_end, q_expected[5 * nq..]);
    }
}

#[test]
fn bad_state_is_named_and_others_move() {
    let model = &floating().model;
    let (nq, nv) = (model.nq(), model.nv());
    let [q, v, tau] = states(model, 10, 4);
    let how = how(Integrator::RungeKutta4, 5);
    let run = |q: &[f64], tau: &[f64]| {
        let (mut q, mut v) = (q.to_vec(), v.clone());
        let paths = (&mut [][..], &mut [][..]);
        let held = Torques::Held(tau);
        let states = RolloutStates { q: &mut q, v: &mut v, q_trajectory: paths.0, v_trajectory: paths.1 };
        let result = rollout(model, &mut workspace(model, 2, false), &how, held, states, None);
        (q, result)
    };
    let expected = run(&q, &tau).0;
    let (mut spoilt, mut pushed) = (q.clone(), tau.clone());
    spoilt[2 * nq + 1] = f64::NAN;
    pushed[7 * nv] = f64::INFINITY;
    let (found, result) = run(&spoilt, &pushed);
    let Err(RolloutError::BadStates(bad)) = result else { panic!("{result:?}") };
    assert_eq!((bad.states, bad.batch), (vec![2, 7], 10));
    for i in (0..10).filter(|i| ![2, 7].contains(i)) {
        assert_eq!(found[i * nq..(i + 1) * nq], expected[i * nq..(i + 1) * nq], "state {i}");
    }
}

#[test]
fn cancelled_rollout_leaves_other_states() {
    let model = &floating().model;
    let nq = model.nq();
    let [q, v, _] = states(model, 40, 4);
    let calls = AtomicU64::new(0);
    let stop = |progress: robot_dynamics::batch::RolloutProgress| {
        assert_eq!(progress.total, 40 * 100);
        assert!(progress.done <= progress.total);
        // The callback runs twice in a block of 100 steps: the second block stops before its end.
        if calls.fetch_add(1, Ordering::Relaxed) == 2 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let (mut q_end, mut v_end) = (q.clone(), v.clone());
    let mut batch = workspace(model, 1, true);
    let lanes = batch.lanes();
    let how = how(Integrator::SemiImplicitEuler, 100);
    let paths = (&mut [][..], &mut [][..]);
    let states = RolloutStates { q: &mut q_end, v: &mut v_end, q_trajectory: paths.0, v_trajectory: paths.1 };
    let result = rollout(model, &mut batch, &how, Torques::Zero, states, Some(&stop));
    let Err(RolloutError::Cancelled { unfinished, batch: 40 }) = result else { panic!("{result:?}") };
    assert_eq!(unfinished, (lanes..40).collect::<Vec<_>>());
    assert_eq!(q_end[lanes * nq..], q[lanes * nq..]);
    assert!(q_end[..lanes * nq].chunks(nq).zip(q.chunks(nq)).all(|(end, start)| end != start));
    // Without cancellation the last report is complete.
    let last = AtomicU64::new(0);
    let watch = |progress: robot_dynamics::batch::RolloutProgress| {
        last.fetch_max(progress.done, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let paths = (&mut [][..], &mut [][..]);
    let three = &mut workspace(model, 3, false);
    let states = RolloutStates { q: &mut q_end, v: &mut v_end, q_trajectory: paths.0, v_trajectory: paths.1 };
    rollout(model, three, &how, Torques::Zero, states, Some(&watch)).unwrap();
    assert_eq!(last.into_inner(), 40 * 100);
}

#[test]
fn implicit_integrators_are_errors() {
    let model = &floating().model;
    let [mut q, mut v, _] = states(model, 1, 4);
    let how = how(Integrator::VariationalMidpoint, 5);
    let paths = (&mut [][..], &mut [][..]);
    let states = RolloutStates { q: &mut q, v: &mut v, q_trajectory: paths.0, v_trajectory: paths.1 };
    let result = rollout(model, &mut workspace(model, 1, false), &how, Torques::Zero, states, None);
    assert_eq!(result, Err(RolloutError::Implicit { integrator: Integrator::VariationalMidpoint }));
}

/// A spring to the neutral configuration and a damper, for one state; weak enough for steps of 1e-4 s.
fn pd(model: &Model, q: &[f64], v: &[f64], tau: &mut [f64]) {
    difference(model, &neutral(model), q, tau);
    for k in 0..v.len() {
        tau[k] = -0.5 * tau[k] - 0.02 * v[k];
    }
}

/// 100 steps of 1e-4 s under a feedback law: to 1e-12 of the largest number of the state, as with held
/// torques.
#[test]
fn policy_matches_law_of_single_states() {
    let mut kinds = 0;
    for robot in robots().iter().step_by(2) {
        let model = &robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        let [q, v, _] = states(model, 9, robot.seed);
        let policy = |at: PolicyInput<'_, f64>, tau: &mut [f64]| {
            assert_eq!((at.q.len(), at.v.len(), tau.len()), (at.states * nq, at.states * nv, at.states * nv));
            for i in 0..at.states {
                let own = i * nv..(i + 1) * nv;
                pd(model, &at.q[i * nq..(i + 1) * nq], &at.v[own.clone()], &mut tau[own]);
            }
        };
        for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            let (mut q_end, mut v_end) = (q.clone(), v.clone());
            let mut batch = workspace(model, 1, robot.seed % 2 == 0);
            let (how, policy) = (how(integrator, 100), Torques::Policy(&policy));
            let paths = (&mut [][..], &mut [][..]);
            let states =
                RolloutStates { q: &mut q_end, v: &mut v_end, q_trajectory: paths.0, v_trajectory: paths.1 };
            rollout(model, &mut batch, &how, policy, states, None).unwrap();
            let (mut single, mut tau) = (StepWorkspace::new(model), vec![0.0; nv]);
            for i in 0..9 {
                let (mut q, mut v) = (q[i * nq..(i + 1) * nq].to_vec(), v[i * nv..(i + 1) * nv].to_vec());
                for _ in 0..100 {
                    pd(model, &q, &v, &mut tau);
                    let forces = StepForces::new(&tau, true);
                    step(model, integrator, &mut single, &forces, 1e-4, &mut q, &mut v).unwrap();
                }
                let law = format!("{integrator} of state {i} under a policy");
                let defect = crate::common::max_difference(&q_end[i * nq..(i + 1) * nq], &q);
                robot.require(&format!("q by {law}"), defect, 1e-12 * size(&q).max(1.0));
                let defect = crate::common::max_difference(&v_end[i * nv..(i + 1) * nv], &v);
                robot.require(&format!("v by {law}"), defect, 1e-12 * size(&v).max(1.0));
                kinds += 1;
            }
        }
    }
    assert!(kinds > 200, "only {kinds} rollouts were judged");
}

/// A rollout under a law of (time, q, v) equals, bit for bit, rollouts of single steps with the torques of
/// the law held. This holds with any number of threads and lanes, in full or partial blocks.
fn policies_are_held_torques_of_each_step<T: BatchFloat + PartialEq>() {
    let model = &floating().model;
    let (nq, nv, count, steps) = (model.nq(), model.nv(), 21, 70);
    let [q, v, tau] =
        states(model, count, 4).map(|numbers| numbers.into_iter().map(T::from_f64).collect::<Vec<T>>());
    // A function of the state's index, the time and its state.
    let law = |i: usize, time: f64, q: &[T], v: &[T], tau_out: &mut [T]| {
        for k in 0..nv {
            let push = tau[i * nv + k] * T::from_f64(1.0 - 50.0 * time);
            tau_out[k] = push - q[k] - v[k] * T::from_f64(0.1);
        }
    };
    let policy = |at: PolicyInput<'_, T>, tau: &mut [T]| {
        assert_eq!(at.time.to_bits(), (at.step as f64 * 1e-4).to_bits());
        for i in 0..at.states {
            let (q, own) = (&at.q[i * nq..(i + 1) * nq], i * nv..(i + 1) * nv);
            law(at.first + i, at.time, q, &at.v[own.clone()], &mut tau[own]);
        }
    };
    for integrator in explicit_rows() {
        let batch = |threads: usize, limit: Option<InstructionSet>| {
            let mut options = BatchOptions::default();
            (options.threads, options.limit) = (threads, limit);
            BatchWorkspace::<T>::with_options(model, options).unwrap()
        };
        let (mut q_expected, mut v_expected) = (q.clone(), v.clone());
        let mut one = batch(1, None);
        let mut held = vec![T::zero(); count * nv];
        for done in 0..steps {
            for i in 0..count {
                let (q, own) = (&q_expected[i * nq..(i + 1) * nq], i * nv..(i + 1) * nv);
                law(i, done as f64 * 1e-4, q, &v_expected[own.clone()], &mut held[own]);
            }
            let (how, held) = (how(integrator, 1), Torques::Held(&held));
            let ends = (&mut q_expected, &mut v_expected);
            rollout(model, &mut one, &how, held, RolloutStates::ends(ends.0, ends.1), None).unwrap();
        }
        for (threads, limit) in [(1, None), (1, Some(InstructionSet::Avx2)), (3, None)] {
            let (mut q_end, mut v_end) = (q.clone(), v.clone());
            let (how, torques) = (how(integrator, steps), Torques::Policy(&policy));
            let paths = (&mut [][..], &mut [][..]);
            let mut batch = batch(threads, limit);
            let states =
                RolloutStates { q: &mut q_end, v: &mut v_end, q_trajectory: paths.0, v_trajectory: paths.1 };
            rollout(model, &mut batch, &how, torques, states, None).unwrap();
            assert!(q_end == q_expected && v_end == v_expected, "{integrator}, {threads} threads, {limit:?}");
        }
        assert!(q_expected != q && v_expected != v, "{integrator}: nothing moved");
    }
}

#[test]
fn policies_are_held_torques_of_each_step_in_f64() {
    policies_are_held_torques_of_each_step::<f64>();
}

#[test]
fn policies_are_held_torques_of_each_step_in_f32() {
    policies_are_held_torques_of_each_step::<f32>();
}

/// A NaN from a policy late in a rollout affects its state only.
#[test]
fn policy_of_nan_makes_its_state_bad() {
    let model = &floating().model;
    let (nq, nv) = (model.nq(), model.nv());
    let [q, v, _] = states(model, 10, 4);
    let run = |lost: usize| {
        let policy = move |at: PolicyInput<'_, f64>, tau: &mut [f64]| {
            tau.fill(0.1);
            if at.step == 3 && (at.first..at.first + at.states).contains(&lost) {
                tau[(lost - at.first) * nv + 1] = f64::NAN;
            }
        };
        let (mut q, mut v) = (q.clone(), v.clone());
        let (how, policy) = (how(Integrator::RungeKutta4, 5), Torques::Policy(&policy));
        assert_eq!(format!("{policy:?}"), "Policy(..)");
        let paths = (&mut [][..], &mut [][..]);
        let states = RolloutStates { q: &mut q, v: &mut v, q_trajectory: paths.0, v_trajectory: paths.1 };
        let result = rollout(model, &mut workspace(model, 2, false), &how, policy, states, None);
        (q, result)
    };
    let (expected, result) = run(usize::MAX);
    assert_eq!(result, Ok(()));
    let (found, result) = run(6);
    let Err(RolloutError::BadStates(bad)) = result else { panic!("{result:?}") };
    assert_eq!((bad.states, bad.batch), (vec![6], 10));
    for i in 0..10 {
        let (found, expected) = (&found[i * nq..(i + 1) * nq], &expected[i * nq..(i + 1) * nq]);
        assert!(if i == 6 { found.iter().all(|q| q.is_nan()) } else { found == expected }, "state {i}");
    }
}
