//! Rollouts on the device.
#![allow(clippy::cast_possible_truncation)] // h in the device's precision

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

use robot_dynamics::model::{Model, normalize_quaternions};
use robot_dynamics::simulation::Integrator;
use robot_dynamics_gpu::{Batches, DeviceError, Function, Rollout, RolloutError, RolloutStates, Torques};

use crate::bounds::{Bounds, size};
use crate::robots::{self, States, row};

const ROWS: [(Integrator, Function); 2] = [
    (Integrator::SemiImplicitEuler, Function::SemiImplicitEulerStep),
    (Integrator::RungeKutta4, Function::Rk4Step),
];

/// Steps by separate calls, with τ of each step by `tau`: the states after each step.
fn by_single_steps(
    batches: &mut Batches<f32>,
    function: &Function,
    how: &Rollout,
    states: &States,
    tau: impl Fn(usize) -> Vec<f32>,
) -> Vec<[Vec<f32>; 2]> {
    let (mut q, mut v) = (states.q.clone(), states.v.clone());
    let h = vec![how.step as f32; states.count];
    let mut after = Vec::new();
    for step in 0..how.steps {
        let (mut q_next, mut v_next) = (q.clone(), v.clone());
        batches.compute(function, &[&q, &v, &tau(step), &h], &mut [&mut q_next, &mut v_next]).unwrap();
        (q, v) = (q_next, v_next);
        after.push([q.clone(), v.clone()]);
    }
    after
}

/// A rollout gives the same bits as its steps, over several calls of the callback: with torques of each step,
/// constant ones, and none. So do the samples of its trajectory.
#[test]
fn a_rollout_has_the_bits_of_its_steps() {
    let Some(device) = crate::device() else { return };
    let model = robots::with_ball();
    let (nq, nv, count) = (model.nq(), model.nv(), 70);
    let states = States::random(&model, count, 8);
    let functions = ROWS.map(|(_, function)| function);
    let mut batches = device.compile::<f32>(&model, &functions).unwrap();
    for ((integrator, function), steps) in ROWS.into_iter().zip([150, 67]) {
        let how = Rollout::new(integrator, 1e-3, steps).with_stride(33);
        let changing =
            |step: usize| -> Vec<f32> { states.tau.iter().map(|tau| tau * (step as f32 * 0.02)).collect() };
        let mut table = Vec::new();
        for state in 0..count {
            for step in 0..steps {
                table.extend_from_slice(&changing(step)[state * nv..][..nv]);
            }
        }
        for torques in [Torques::EachStep(&table), Torques::Held(&states.tau), Torques::Zero] {
            let tau = |step: usize| match torques {
                Torques::EachStep(_) => changing(step),
                Torques::Held(tau) => tau.to_vec(),
                _ => vec![0.0; count * nv],
            };
            let expected = by_single_steps(&mut batches, &function, &how, &states, tau);
            let (mut q, mut v) = (states.q.clone(), states.v.clone());
            let samples = how.samples();
            let mut of_q = vec![f32::NAN; count * samples * nq];
            let mut of_v = vec![f32::NAN; count * samples * nv];
            batches
                .rollout(
                    &how,
                    torques,
                    RolloutStates { q: &mut q, v: &mut v, q_trajectory: &mut of_q, v_trajectory: &mut of_v },
                    None,
                )
                .unwrap();
            assert!([q, v] == expected[steps - 1], "{integrator}, {torques:?}");
            for sample in 0..samples {
                let [q, v] = &expected[(sample + 1) * 33 - 1];
                for state in 0..count {
                    let at = state * samples + sample;
                    assert_eq!(of_q[at * nq..][..nq], q[state * nq..][..nq], "{integrator}, sample {sample}");
                    assert_eq!(of_v[at * nv..][..nv], v[state * nv..][..nv], "{integrator}, sample {sample}");
                }
            }
        }
    }
}

/// One step agrees with the CPU's in doubles. v₁ agrees to h times the bound of an acceleration and a
/// rounding of v, q₁ to h times that and a rounding of q.
#[test]
fn a_step_agrees_with_the_library_to_the_rounding_of_singles() {
    let Some(device) = crate::device() else { return };
    let mut judged = 0;
    for model in [robots::named("panda.urdf"), robots::with_ball(), robots::named("quadruped.urdf")] {
        let functions = ROWS.map(|(_, function)| function);
        let mut batches = device.compile::<f32>(&model, &functions).unwrap();
        let (count, nv) = (70, model.nv());
        let states = States::random(&model, count, 4);
        for (integrator, _) in ROWS {
            let how = Rollout::new(integrator, 1e-3, 1);
            let (mut q, mut v) = (states.q.clone(), states.v.clone());
            batches
                .rollout(&how, Torques::Held(&states.tau), RolloutStates::ends(&mut q, &mut v), None)
                .unwrap();
            let wide = |rows: &[f32]| -> Vec<f64> { rows.iter().map(|&x| f64::from(x)).collect() };
            let (mut q_there, mut v_there, tau) = (wide(&states.q), wide(&states.v), wide(&states.tau));
            // h in the device's precision.
            let h = f64::from(how.step as f32);
            let how = Rollout::new(integrator, h, 1);
            robots::roll_out_on_cpu(&model, &how, &tau, &mut q_there, &mut v_there).unwrap();
            for state in 0..count {
                let of = |rows: &[f32]| row(rows, count, state);
                let (mut at, v0, tau) = (of(&states.q), of(&states.v), of(&states.tau));
                normalize_quaternions(&model, &mut at);
                let a = model.forward_dynamics(&at, &v0, &tau).unwrap();
                let bounds = Bounds::new(&model, &at, &v0, a.as_slice());
                if !bounds.is_known() {
                    continue;
                }
                let allowed = size(&bounds.acceleration(&tau));
                let off = |found: &[f32], expected: &[f64], width: usize| {
                    let found = of(found);
                    let expected = &expected[state * width..][..width];
                    let differences: Vec<f64> = found.iter().zip(expected).map(|(x, y)| x - y).collect();
                    (size(&differences), size(expected))
                };
                let (off_v, size_v) = off(&v, &v_there, nv);
                let (off_q, size_q) = off(&q, &q_there, model.nq());
                let (by_v, by_q) =
                    (h * allowed + bounds.rounding * size_v, bounds.rounding * size_q.max(1.0));
                assert!(
                    off_v <= by_v,
                    "{integrator}, {}, state {state}: v {off_v:e}, {by_v:e}",
                    model.name()
                );
                let by_q = h * by_v + by_q;
                assert!(
                    off_q <= by_q,
                    "{integrator}, {}, state {state}: q {off_q:e}, {by_q:e}",
                    model.name()
                );
                judged += 1;
            }
        }
    }
    assert!(judged > 300, "{judged}");
}

/// A falling pendulum on the device conserves energy: ½ l v² = g sin q from q = 0. RK4's own error is below
/// 1e-9 here. Each of 500 steps rounds q and v by ε/2 of less than 8. Energy changes with v by l v < 4.
#[test]
fn a_falling_pendulum_conserves_energy() {
    let Some(device) = crate::device() else { return };
    let model = Model::new(robot_dynamics::description::pendulum(2.0, 0.5)).unwrap();
    let mut batches = device.compile::<f32>(&model, &[Function::Rk4Step]).unwrap();
    let (mut q, mut v) = (vec![0.0_f32; 3], vec![0.0_f32; 3]);
    let how = Rollout::new(Integrator::RungeKutta4, 1e-3, 500);
    batches.rollout(&how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None).unwrap();
    assert!(v[0].abs() > 1.0, "{v:?}");
    for (q, v) in q.into_iter().zip(v) {
        let (q, v) = (f64::from(q), f64::from(v));
        let off = 0.25 * v * v - 9.81 * q.sin();
        assert!(off.abs() < 500.0 * 8.0 * f64::from(f32::EPSILON) * 4.0, "{off:e}");
    }
}

/// The callback is called after every chunk of steps, and with the total at the end. If it breaks, the states
/// on the device and those after them keep their initial values, and the error names them.
#[test]
fn progress_is_reported_and_a_rollout_can_be_cancelled() {
    if crate::device().is_none() {
        return;
    }
    let model = robots::named("two_r.urdf");
    let device = crate::open_with(robot_dynamics_gpu::Limits::default().with_launch_states(64)).unwrap();
    let mut batches = device.compile::<f32>(&model, &[Function::SemiImplicitEulerStep]).unwrap();
    let states = States::random(&model, 100, 6);
    let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 200);
    let (mut q, mut v) = (states.q.clone(), states.v.clone());
    let last = AtomicU64::new(0);
    let listen = |progress: robot_dynamics_gpu::RolloutProgress| {
        assert!(progress.done > last.swap(progress.done, Ordering::Relaxed) && progress.total == 20_000);
        ControlFlow::Continue(())
    };
    batches.rollout(&how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), Some(&listen)).unwrap();
    assert_eq!(last.into_inner(), 20_000);
    let whole = (q, v);
    // After the first 64 states; halfway through them; at the very end.
    for (limit, first_unfinished) in [(64 * 200, 64), (64 * 100, 0), (20_000, 100)] {
        let (mut q, mut v) = (states.q.clone(), states.v.clone());
        let stop = |progress: robot_dynamics_gpu::RolloutProgress| {
            if progress.done >= limit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let result = batches.rollout(&how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), Some(&stop));
        if first_unfinished == 100 {
            // All states are finished.
            assert!(result.is_ok() && (q, v) == whole);
            continue;
        }
        let Err(DeviceError::Rollout(RolloutError::Cancelled { unfinished, batch: 100 })) = result else {
            panic!("{result:?}")
        };
        assert_eq!(unfinished, (first_unfinished..100).collect::<Vec<_>>());
        let end = first_unfinished * 2;
        assert!(q[..end] == whole.0[..end] && q[end..] == states.q[end..]);
        assert!(v[..end] == whole.1[..end] && v[end..] == states.v[end..]);
    }
}
