//! A and B of a step against central differences of the step, on every kind of robot.
//!
//! Fourth-order differences with δ = 1e-3 have a truncation of δ⁴ times a fifth derivative. Their rounding is
//! ε/δ = 2e-13 times the size of q₁ and v₁. States move at about 1 rad/s. With h = 0.01 the displacement of a
//! step is small, and its quaternion terms are far above the tolerance.

use robot_dynamics::batch::{self, BatchOptions, BatchWorkspace, LinearizeInputs, RolloutError};
use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::model::{Model, difference, integrate};
use robot_dynamics::simulation::{Integrator, StepError, StepForces, StepWorkspace, step};

use crate::common::{Robot, families};

const H: f64 = 0.01;

/// (q₁, v₁) from (q₀ ⊕ δq, v₀ + δv) under τ + δτ, where the displacement is δ times the k-th unit.
fn stepped(robot: &Robot, integrator: Integrator, k: usize, delta: f64) -> (Vec<f64>, Vec<f64>) {
    let Robot { model, state, .. } = robot;
    let n = model.nv();
    let mut unit = vec![0.0; 3 * n];
    unit[k] = delta;
    let mut q = state.q.clone();
    integrate(model, &state.q, &unit[..n], &mut q);
    let sum = |x: &[f64], d: &[f64]| -> Vec<f64> { x.iter().zip(d).map(|(x, d)| x + d).collect() };
    let (mut v, tau) = (sum(&state.v, &unit[n..2 * n]), sum(&state.tau, &unit[2 * n..]));
    let forces = StepForces::new(&tau, true);
    step(model, integrator, &mut StepWorkspace::new(model), &forces, H, &mut q, &mut v).expect("a step");
    (q, v)
}

/// δ(q₁, v₁)/δ by the k-th unit.
fn differenced(robot: &Robot, integrator: Integrator, k: usize) -> Vec<f64> {
    let delta = 1e-3;
    let n = robot.model.nv();
    let between = |d: f64| -> Vec<f64> {
        let ((q0, v0), (q1, v1)) = (stepped(robot, integrator, k, -d), stepped(robot, integrator, k, d));
        // From the midpoint, so that the odd terms of the chart vanish.
        let (middle, _) = stepped(robot, integrator, k, 0.0);
        let (mut back, mut forth) = (vec![0.0; n], vec![0.0; n]);
        difference(&robot.model, &middle, &q0, &mut back);
        difference(&robot.model, &middle, &q1, &mut forth);
        let q = forth.iter().zip(&back).map(|(a, b)| a - b);
        q.chain(v1.iter().zip(&v0).map(|(a, b)| a - b)).collect()
    };
    let (near, far) = (between(delta), between(2.0 * delta));
    near.iter().zip(&far).map(|(near, far)| (8.0 * near - far) / (12.0 * delta)).collect()
}

#[test]
fn explicit_methods_match_differences() {
    let mut tested = 0;
    for family in families() {
        // Badly conditioned robots have derivatives too large for differences.
        if family.name.contains("thin") || family.name == "large" {
            continue;
        }
        for robot in family.robots().take(12) {
            let Robot { model, state, .. } = &robot;
            let n = model.nv();
            let condition = robot.condition();
            if condition > 1e4 {
                continue;
            }
            tested += 1;
            let forces = StepForces::new(&state.tau, true);
            let mut workspace = LinearizeStepWorkspace::new(model);
            for integrator in Integrator::ALL.into_iter().filter(|row| row.is_explicit()) {
                let (mut a, mut b) = (vec![7.0; 4 * n * n], vec![7.0; 2 * n * n]);
                let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
                linearize_step(
                    model,
                    integrator,
                    &mut workspace,
                    &forces,
                    H,
                    RobotState { q: &state.q, v: &state.v },
                    out,
                )
                .unwrap_or_else(|error| panic!("{integrator}, seed {}: {error}", robot.seed));
                for k in 0..3 * n {
                    let expected = differenced(&robot, integrator, k);
                    let scale = crate::common::size(&expected).max(1.0);
                    for (i, expected) in expected.iter().enumerate() {
                        let found = if k < 2 * n { a[i * 2 * n + k] } else { b[i * n + k - 2 * n] };
                        robot.require(
                            &format!("{integrator}: entry ({i}, {k})"),
                            (found - expected).abs(),
                            1e-8 * scale,
                        );
                    }
                }
            }
        }
    }
    assert!(tested > 40, "only {tested} robots");
}

/// A turn of several radians in one step: the full series of the exponential's derivative.
#[test]
fn long_turn_is_linearised() {
    let families = families();
    let family = families.iter().find(|family| family.name == "floating trees").expect("a family");
    for mut robot in family.robots().take(5) {
        let n = robot.model.nv();
        // 200 rad/s about a slanted axis: 2 rad in the step.
        robot.state.v[3..6].copy_from_slice(&[120.0, -100.0, 120.0]);
        let forces = StepForces::new(&robot.state.tau, true);
        let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
        let mut workspace = LinearizeStepWorkspace::new(&robot.model);
        let row = Integrator::ExplicitEuler;
        let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
        linearize_step(
            &robot.model,
            row,
            &mut workspace,
            &forces,
            H,
            RobotState { q: &robot.state.q, v: &robot.state.v },
            out,
        )
        .expect("a linearisation");
        for k in 0..2 * n {
            let expected = differenced(&robot, row, k);
            let scale = crate::common::size(&expected).max(1.0);
            for (i, expected) in expected.iter().enumerate().take(6) {
                let defect = (a[i * 2 * n + k] - expected).abs();
                robot.require(&format!("entry ({i}, {k})"), defect, 1e-8 * scale);
            }
        }
    }
}

#[test]
fn implicit_methods_are_errors() {
    let families = families();
    let Robot { model, state, .. } = families[0].robots().next().expect("a robot");
    let n = Model::nv(&model);
    let forces = StepForces::new(&state.tau, false);
    let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
    let integrator = Integrator::VariationalMidpoint;
    let mut workspace = LinearizeStepWorkspace::new(&model);
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let refused = linearize_step(
        &model,
        integrator,
        &mut workspace,
        &forces,
        H,
        RobotState { q: &state.q, v: &state.v },
        out,
    );
    assert_eq!(refused, Err(StepError::NotDifferentiable { integrator }));
    let mut v = state.v.clone();
    v[0] = f64::NAN;
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let refused = linearize_step(
        &model,
        Integrator::RungeKutta4,
        &mut workspace,
        &forces,
        H,
        RobotState { q: &state.q, v: &v },
        out,
    );
    assert!(matches!(refused, Err(StepError::Integrator(_))), "{refused:?}");
}

/// A batch has the bits of its states, for any number of threads. A state that is not finite is bad alone.
#[test]
fn batches_match_their_states() {
    let family = families().into_iter().find(|family| family.name == "floating trees").expect("a family");
    let robot = family.robots().next().expect("a robot");
    let Robot { model, state, .. } = &robot;
    let (n, count, rk4) = (model.nv(), 7, Integrator::RungeKutta4);
    let (mut q, mut tau) = (state.q.repeat(count), state.tau.repeat(count));
    for k in 0..count {
        tau[k * n] += k as f64;
    }
    q[3 * model.nq()] = f64::NAN;
    let v = state.v.repeat(count);
    let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
    for threads in [1, 2] {
        let mut options = BatchOptions::default();
        options.threads = threads;
        let workspace = BatchWorkspace::with_options(model, options).expect("threads");
        let (mut as_, mut bs) = (vec![0.0; count * 4 * n * n], vec![0.0; count * 2 * n * n]);
        let inputs = LinearizeInputs { step: H, dissipation: true, q: &q, v: &v, tau: &tau };
        let results = LinearizedStep { by_state: &mut as_, by_force: &mut bs };
        let bad = batch::linearize_step(model, &workspace, rk4, inputs, results);
        assert!(matches!(bad, Err(RolloutError::BadStates(bad)) if bad.states == [3] && bad.batch == count));
        for k in 0..count {
            let rows = (&as_[k * 4 * n * n..(k + 1) * 4 * n * n], &bs[k * 2 * n * n..(k + 1) * 2 * n * n]);
            if k == 3 {
                assert!(rows.0.iter().chain(rows.1).all(|x| x.is_nan()));
                continue;
            }
            let forces = StepForces::new(&tau[k * n..(k + 1) * n], true);
            let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
            let at = RobotState { q: &state.q, v: &state.v };
            linearize_step(model, rk4, &mut LinearizeStepWorkspace::new(model), &forces, H, at, out)
                .expect("a step");
            assert!(rows.0 == a && rows.1 == b, "state {k}, {threads} threads");
        }
        let variational = Integrator::VariationalMidpoint;
        let results = LinearizedStep { by_state: &mut as_, by_force: &mut bs };
        let refused = batch::linearize_step(model, &workspace, variational, inputs, results);
        assert!(matches!(refused, Err(RolloutError::Implicit { .. })));
    }
}

/// A robot that cannot move has empty derivatives.
#[test]
fn robots_without_degrees_of_freedom_have_empty_derivatives() {
    let text = r#"<robot name="stone"><link name="stone"/></robot>"#;
    let described = robot_dynamics::load_description_from_text(text, &robot_dynamics::LoadOptions::default());
    let model = described.expect("a robot").compile().expect("a robot").model;
    for integrator in Integrator::ALL.iter().copied().filter(|row| row.is_explicit()) {
        let out = LinearizedStep { by_state: &mut [], by_force: &mut [] };
        let (state, forces) = (RobotState { q: &[], v: &[] }, StepForces::new(&[], true));
        let mut workspace = LinearizeStepWorkspace::new(&model);
        linearize_step(&model, integrator, &mut workspace, &forces, H, state, out).expect("no derivatives");
    }
}
