//! Batches: pullbacks beside the calls and the Jacobians.

use std::hint::black_box;

use bench::StateTable;
use robot_dynamics::batch;
use robot_dynamics::batch::{BatchOptions, BatchWorkspace, Torques};
use robot_dynamics::derivatives::{
    ForwardDynamicsDerivativesMut, ForwardPullbackMut, InverseDynamicsDerivativesMut, InversePullbackMut,
    MotionCotangents, Rollout, TrajectoryCotangents, parameter_count,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::Integrator;

use crate::{Item, Row, STATES, STEP, STEPS};

/// All states at once with one thread; rollouts of 64 steps with checkpoints.
pub(crate) fn batches<'a>(model: &'a Model, table: &'a StateTable) -> Vec<Row<'a>> {
    let n = model.nv();
    let tables =
        [0, 1, 2, 3].map(|k| (0..STATES).flat_map(|i| table.get(i)[k]).copied().collect::<Vec<f64>>());
    let tables: &'a [Vec<f64>; 4] = Box::leak(Box::new(tables));
    let [q, v, a, tau] = tables;
    let mut options = BatchOptions::default();
    options.threads = 1;
    let workspace = move || BatchWorkspace::with_options(model, options).expect("the calling thread");
    let vector = move || vec![0.0; STATES * n];
    let square = move || vec![0.0; STATES * n * n];
    let count = STATES * parameter_count(model);
    let inverse = {
        let (mut w, mut x) = (workspace(), vector());
        Item::many(STATES, move |_| drop(black_box(batch::inverse_dynamics(model, &mut w, q, v, a, &mut x))))
    };
    let inverse_pullback = |count: usize| {
        let (mut w, mut x, mut y, mut z, mut p) =
            (workspace(), vector(), vector(), vector(), vec![0.0; count]);
        Item::many(STATES, move |_| {
            let out = InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: &mut p,
            };
            let done = batch::inverse_dynamics_pullback(model, &mut w, q, v, a, tau, out);
            black_box(done).ok();
        })
    };
    let inverse_jacobians = {
        let (mut w, mut x, mut y, mut z) = (workspace(), square(), square(), square());
        Item::many(STATES, move |_| {
            let out = InverseDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y };
            let done = batch::inverse_dynamics_derivatives(model, &mut w, q, v, a, out);
            black_box((done, batch::mass_matrix(model, &mut w, q, &mut z))).0.ok();
        })
    };
    let forward = {
        let (mut w, mut x) = (workspace(), vector());
        Item::many(STATES, move |_| {
            drop(black_box(batch::forward_dynamics(model, &mut w, q, v, tau, &mut x)));
        })
    };
    let forward_pullback = |count: usize| {
        let mut w = workspace();
        let ([mut r, mut x, mut y, mut z], mut p) =
            ([vector(), vector(), vector(), vector()], vec![0.0; count]);
        Item::many(STATES, move |_| {
            let out = ForwardPullbackMut {
                acceleration: &mut r,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: &mut p,
            };
            let done = batch::forward_dynamics_pullback(model, &mut w, q, v, tau, a, out);
            black_box(done).ok();
        })
    };
    let forward_jacobians = {
        let (mut w, mut x, mut y, mut z) = (workspace(), square(), square(), square());
        Item::many(STATES, move |_| {
            let out =
                ForwardDynamicsDerivativesMut { by_position: &mut x, by_velocity: &mut y, by_force: &mut z };
            let done = batch::forward_dynamics_derivatives(model, &mut w, q, v, tau, out);
            black_box(done).ok();
        })
    };
    let integrator = Integrator::SemiImplicitEuler;
    let how = Rollout::new(integrator, STEP, STEPS).with_dissipation(false);
    let few = 64;
    let rollout = || {
        let (mut w, mut x, mut y) = (workspace(), vec![0.0; few * model.nq()], vec![0.0; few * n]);
        Item::many(few * STEPS, move |_| {
            x.copy_from_slice(&q[..few * model.nq()]);
            y.fill(0.0);
            let done = batch::rollout(
                model,
                &mut w,
                &how,
                Torques::Zero,
                batch::RolloutStates::ends(&mut x, &mut y),
                None,
            );
            black_box(done).ok();
        })
    };
    let rollout_pullback = |count: usize, spacing: usize| {
        let (mut w, mut x, mut y, mut p) =
            (workspace(), vec![0.0; few * n], vec![0.0; few * n], vec![0.0; count]);
        let still = vec![0.0; few * n];
        Item::many(few * STEPS, move |_| {
            x.copy_from_slice(&a[..few * n]);
            y.copy_from_slice(&a[..few * n]);
            let (ends, from) = ((&mut x[..], &mut y[..]), &q[..few * model.nq()]);
            let inputs = batch::RolloutPullbackInputs {
                spacing,
                torques: Torques::Zero,
                q: from,
                v: &still,
                trajectory: TrajectoryCotangents::default(),
            };
            let cotangents = MotionCotangents {
                by_position: ends.0,
                by_velocity: ends.1,
                by_force: &mut [],
                parameters: &mut p,
            };
            let done = batch::rollout_pullback(model, &mut w, &how, &inputs, cotangents, None);
            black_box(done).ok();
        })
    };
    let of_few = few * parameter_count(model);
    vec![
        (
            "inverse dynamics, batch",
            [inverse, inverse_pullback(0), inverse_pullback(count)],
            Some(inverse_jacobians),
        ),
        (
            "forward dynamics, batch",
            [forward, forward_pullback(0), forward_pullback(count)],
            Some(forward_jacobians),
        ),
        ("rollout, batch, a step", [rollout(), rollout_pullback(0, 0), rollout_pullback(of_few, 0)], None),
        (
            "the same, all steps kept",
            [rollout(), rollout_pullback(0, STEPS), rollout_pullback(of_few, STEPS)],
            None,
        ),
    ]
}
