//! Variational steps of long chains, whose mass matrix has a high condition number.

use robot_dynamics::algorithms::{
    frame_pose, gravity, kinetic_energy, kinetic_energy_gradient, mass_matrix, momentum, potential_energy,
};
use robot_dynamics::constraints::{
    ConstraintOptions, ConstraintSet, DriftCorrection, FrameConstraint, SpatialAxis, StepConstraints,
    constrained_step,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, step};

use crate::common::chain;

/// At rest with the first hinge turned: the straight chain hangs at this angle.
fn let_go(model: &Model, angle: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut q, v) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    q[0] = angle;
    (q, v)
}

fn energy(model: &Model, workspace: &mut Workspace, q: &[f64], v: &[f64]) -> f64 {
    kinetic_energy(model, workspace, q, v) + potential_energy(model, workspace, q)
}

/// The energy of 20 links over 10⁵ steps stays bounded: the mean error over the last tenth is at most twice
/// that over the first. Accumulated rounding or errors of the iteration would cause a drift.
///
/// 10⁴ steps before them spread the motion over the modes of the chain: the error is that of the fastest
/// modes, which are excited slowly.
#[test]
fn energy_of_twenty_links_stays_bounded() {
    let model = chain(20);
    let (before, steps) = (10_000, 100_000);
    let (mut q, mut v) = let_go(&model, 1.5);
    let (mut workspace, mut scratch) = (StepWorkspace::new(&model), Workspace::new(&model));
    let tau = vec![0.0; model.nv()];
    let forces = StepForces::new(&tau, false);
    let start = energy(&model, &mut scratch, &q, &v);
    let (mut first, mut last, mut most, mut kinetic) = (0.0, 0.0, 0.0f64, 0.0f64);
    for done in 0..before + steps {
        step(&model, Integrator::VariationalMidpoint, &mut workspace, &forces, 5e-4, &mut q, &mut v)
            .unwrap_or_else(|error| panic!("step {done}: {error}"));
        let error = (energy(&model, &mut scratch, &q, &v) - start).abs();
        kinetic = kinetic.max(kinetic_energy(&model, &mut scratch, &q, &v));
        first += if (before..before + steps / 10).contains(&done) { error } else { 0.0 };
        last += if done >= before + steps - steps / 10 { error } else { 0.0 };
        most = most.max(error);
    }
    let [first, last] = [first, last].map(|sum| sum / f64::from(steps / 10));
    println!("mean error {first:.2e} J, then {last:.2e} J, largest {most:.2e} J; K up to {kinetic:.2e} J");
    assert!(last < 2.0 * first, "{first:e} J grows to {last:e} J");
    // The chain swings, and the error is small relative to that energy.
    assert!(kinetic > 5.0 && most < 0.1 * kinetic, "{most:e} J of {kinetic:e} J");
}

/// The solution of a step is the same to rounding forwards and backwards, so that v and −v of 20 links lead
/// back. A step that Newton's method solves is as accurate as one of the fixed-point iteration. Along the
/// chain v is accurate to κ(M) ε ~ 1e-10 of its size.
#[test]
fn steps_of_whipping_chain_are_reversible() {
    let model = chain(20);
    let tau = vec![0.0; model.nv()];
    let forces = StepForces::new(&tau, false);
    let mut workspace = StepWorkspace::new(&model);
    let (mut q, mut v) = let_go(&model, 1.5);
    for done in 0..180 {
        let (q0, v0) = (q.clone(), v.clone());
        let mut advance = |q: &mut [f64], v: &mut [f64]| {
            step(&model, Integrator::VariationalMidpoint, &mut workspace, &forces, 0.01, q, v)
                .unwrap_or_else(|error| panic!("step {done}: {error}"));
        };
        advance(&mut q, &mut v);
        let (mut back, mut reversed) = (q.clone(), v.iter().map(|v| -v).collect::<Vec<_>>());
        advance(&mut back, &mut reversed);
        let size = v0.iter().fold(1.0, |most: f64, v| most.max(v.abs()));
        for k in 0..model.nv() {
            let off = (back[k] - q0[k]).abs().max((reversed[k] + v0[k]).abs());
            assert!(off < 1e-8 * size, "step {done}, hinge {k}: {off:e} of {size}");
        }
    }
}

/// With 50 links and κ(M) ~ 10⁷ every step solves its equation to rounding. p₁ = p₀ + hF(q_m, v_m) with
/// v_m = (q₁ − q₀)/h and p = M(q) v, to 1e-13 of the terms Σ|M_ij v_j|. M(q_m) v_m = p₀ + ½hF.
#[test]
fn steps_of_fifty_links_solve_their_equation() {
    let model = chain(50);
    let n = model.nv();
    let tau = vec![0.0; n];
    let forces = StepForces::new(&tau, false);
    for h in [1e-4, 1e-3, 5e-3] {
        let (mut q, mut v) = let_go(&model, 1.5);
        let (mut workspace, mut scratch) = (StepWorkspace::new(&model), Workspace::new(&model));
        let mut worst = 0.0f64;
        for done in 0..100 {
            let (q0, v0) = (q.clone(), v.clone());
            step(&model, Integrator::VariationalMidpoint, &mut workspace, &forces, h, &mut q, &mut v)
                .unwrap_or_else(|error| panic!("step {done} of {h} s: {error}"));
            let middle: Vec<f64> = q.iter().zip(&q0).map(|(a, b)| 0.5 * (a + b)).collect();
            let velocity: Vec<f64> = q.iter().zip(&q0).map(|(a, b)| (a - b) / h).collect();
            let [mut p0, mut p, mut p1, mut slope, mut g] = [(); 5].map(|()| vec![0.0; n]);
            momentum(&model, &mut scratch, &q0, &v0, &mut p0);
            momentum(&model, &mut scratch, &middle, &velocity, &mut p);
            momentum(&model, &mut scratch, &q, &v, &mut p1);
            kinetic_energy_gradient(&model, &mut scratch, &middle, &velocity, &mut slope);
            gravity(&model, &mut scratch, &middle, &mut g);
            let mut mass = vec![0.0; n * n];
            mass_matrix(&model, &mut scratch, &middle, &mut mass);
            let speed = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            for i in 0..n {
                let force = slope[i] - g[i];
                let terms: f64 = mass[i * n..][..n].iter().map(|m| m.abs() * speed).sum();
                let terms = terms + h * (slope[i].abs() + g[i].abs());
                // v_m comes from positions, which are rounded.
                let read_off: f64 = mass[i * n..][..n].iter().map(|m| m.abs() * f64::EPSILON * 4.0 / h).sum();
                let allowed = 1e-13 * terms + 4.0 * read_off;
                for residual in [p[i] - p0[i] - 0.5 * h * force, p1[i] - p0[i] - h * force] {
                    worst = worst.max(residual.abs() / allowed);
                }
            }
        }
        println!("h = {h} s: residual {worst:.1e} of what is allowed");
        assert!(worst < 1.0, "h = {h} s: residual {worst:e} of what is allowed");
    }
}

/// A chain of 20 links is nailed to the ceiling at both ends and released bent to one side. Constrained steps
/// converge to the same rounding. φ stays at the rounding of lengths of 1 m, and the energy within 1e-2 J of
/// about 10 J.
#[test]
fn chain_nailed_at_both_ends_keeps_constraint() {
    let model = chain(20);
    let (mut q, mut v) = let_go(&model, 1.2);
    for (k, q) in q.iter_mut().enumerate().skip(1) {
        *q = if k < 8 { -0.25 } else { -0.05 };
    }
    let (mut workspace, tau) = (Workspace::new(&model), vec![0.0; model.nv()]);
    let frame = model.frame("rod 19").unwrap();
    let Pose { rotation, translation } = frame_pose(&model, &mut workspace, &q, frame);
    let nail =
        FrameConstraint::contact(frame, Pose { rotation, translation }, &[SpatialAxis::X, SpatialAxis::Z]);
    let set = ConstraintSet::new(&model, [("nail", nail.into())]).unwrap();
    let options = ConstraintOptions { integrator: Integrator::VariationalMidpoint, ..Default::default() };
    let forces = StepForces::new(&tau, false);
    let start = energy(&model, &mut workspace, &q, &v);
    let (mut gap, mut most, mut speed) = (0.0f64, 0.0f64, 0.0f64);
    for done in 0..1000 {
        constrained_step(
            &model,
            &mut workspace,
            StepConstraints { set: &set, options: &options, correction: DriftCorrection::None },
            &forces,
            1e-3,
            &mut q,
            &mut v,
        )
        .unwrap_or_else(|error| panic!("step {done}: {error}"));
        let at = frame_pose(&model, &mut workspace, &q, frame).translation;
        gap = gap.max((at[0] - translation[0]).abs()).max((at[2] - translation[2]).abs());
        most = most.max((energy(&model, &mut workspace, &q, &v) - start).abs());
        speed = v.iter().fold(speed, |most, v| most.max(v.abs()));
    }
    println!("gap {gap:.1e} m, energy {most:.1e} J, speed {speed:.1} rad/s");
    assert!(gap < 1e-13, "{gap:e} m");
    assert!(most < 1e-2 && speed > 3.0, "{most:e} J, {speed} rad/s");
}
