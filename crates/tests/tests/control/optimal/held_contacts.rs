//! Steps with held contacts and impacts: against constrained dynamics with another factor, and differences.

use std::sync::Arc;

use robot_dynamics::constraints::{
    Baumgarte, ConstraintOptions, ConstraintSet, Coupling, FrameConstraint, HeldDynamics, LinearizedImpact,
    RowFeedback, constrained_forward_dynamics,
};
use robot_dynamics::control::optimal::{
    ActuationMatrix, ContactForceResidual, DiscreteDynamics, HeldContactStep, ImpactStep, LinearizedDynamics,
    Residual, ResidualJacobian,
};
use robot_dynamics::derivatives::{
    RobotState, constrained_forward_dynamics_derivatives, contact_impulse_derivatives,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{Model, RandomState, Workspace, random_state};
use robot_dynamics::nalgebra::DMatrix;
use robot_dynamics::number::SplitMix64;

use super::derivatives::{STEP, difference_by_state, random_x};
use super::floating_tree;

const TWO_R: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");

/// Both routes factor the same rows, in another order of operations. The rows of these trees are short for
/// some joints, so that twelve digits remain of sixteen at least.
const AGREEMENT: f64 = 1e-10;

/// Central differences of numbers of size s are right to about nine digits of s.
const DIFFERENCES: f64 = 1e-7;

/// The last frame welded to a pose, and the first link held at a point of another axis.
fn held_rows(model: &Model, twice: bool) -> ConstraintSet {
    let frames = model.frames();
    let [first, last] = [1, frames.len() - 1].map(|i| model.frame_named(&frames[i].name).expect("a frame"));
    let pose = Pose::exp([0.3, -0.2, 0.5], [0.4, 0.1, -0.3]);
    let [x, _, z] = FrameConstraint::BALL;
    let held = [
        ("tip", FrameConstraint::contact(last, pose, &FrameConstraint::HINGE).into()),
        ("first", FrameConstraint::contact(first, Pose::IDENTITY, &[x, z]).into()),
    ];
    let again = ("again", FrameConstraint::contact(first, Pose::IDENTITY, &[z]).into());
    ConstraintSet::new(model, held.into_iter().chain(twice.then_some(again))).expect("a set")
}

fn rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// Columns `first..first + width` of a row-major matrix.
fn columns(matrix: &[f64], all: usize, first: usize, width: usize) -> Vec<f64> {
    matrix.chunks_exact(all).flat_map(|row| row[first..first + width].to_vec()).collect()
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, name: &str) {
    assert_eq!(found.len(), expected.len(), "{name}");
    let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "{name} [{k}]: {a} {b}, of {scale}");
    }
}

#[test]
fn motions_and_derivatives_are_those_of_constrained_dynamics() {
    for seed in 1..6 {
        let model = floating_tree(seed);
        let (set, nv) = (held_rows(&model, false), model.nv());
        let RandomState { q, v, tau, .. } = random_state(&model, &mut SplitMix64::new(seed));
        let options = ConstraintOptions {
            stabilization: Some(Baumgarte { rate: 3.0 }),
            ..ConstraintOptions::default()
        };
        let w = &mut Workspace::new(&model);
        let expected = constrained_forward_dynamics_derivatives(&model, w, &set, &options, &q, &v, &tau)
            .expect("motion");
        let mut held = HeldDynamics::new(&model, &set, Baumgarte { rate: 3.0 }.into()).expect("rows");
        let mut identity = vec![0.0; nv * nv];
        (0..nv).for_each(|i| identity[i * (nv + 1)] = 1.0);
        held.linearize(&model, RobotState { q: &q, v: &v }, &tau, &identity).expect("derivatives");
        assert_eq!(held.rank(), expected.motion.rank);
        let close = |found: &[f64], expected: &[f64], name| assert_close(found, expected, AGREEMENT, name);
        close(held.acceleration(), expected.motion.acceleration.as_slice(), "a");
        close(held.multipliers(), expected.motion.multipliers.as_slice(), "λ");
        let (a, multipliers) = (held.motion_by_inputs(), held.multipliers_by_inputs());
        let part = |matrix: &[f64], k: usize| columns(matrix, 3 * nv, k * nv, nv);
        close(&part(a, 0), &rows(&expected.acceleration_by_position), "∂a/∂q");
        close(&part(a, 1), &rows(&expected.acceleration_by_velocity), "∂a/∂v");
        close(&part(a, 2), &rows(&expected.acceleration_by_force), "∂a/∂τ");
        close(&part(multipliers, 0), &rows(&expected.multipliers_by_position), "∂λ/∂q");
        close(&part(multipliers, 1), &rows(&expected.multipliers_by_velocity), "∂λ/∂v");
        close(&part(multipliers, 2), &rows(&expected.multipliers_by_force), "∂λ/∂τ");
    }
}

#[test]
fn impacts_and_derivatives_are_those_of_contact_impulses() {
    for seed in 1..6 {
        let model = floating_tree(seed);
        let (set, nv) = (held_rows(&model, false), model.nv());
        let RandomState { q, v, .. } = random_state(&model, &mut SplitMix64::new(seed));
        let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
        let expected =
            contact_impulse_derivatives(&model, w, &set, &options, &q, &v, 0.4).expect("an impact");
        let mut held = HeldDynamics::new(&model, &set, RowFeedback::default()).expect("rows");
        let mut by_state = vec![0.0; 4 * nv * nv];
        let out = LinearizedImpact { by_state: &mut by_state };
        held.linearize_impact(&model, RobotState { q: &q, v: &v }, 0.4, out).expect("derivatives");
        let close = |found: &[f64], expected: &[f64], name| assert_close(found, expected, AGREEMENT, name);
        close(held.multipliers(), expected.impact.impulse.as_slice(), "ι");
        let part = |matrix: &[f64], k: usize| columns(matrix, 2 * nv, k * nv, nv);
        let lower = &by_state[2 * nv * nv..];
        close(&part(lower, 0), &rows(&expected.velocity_by_position), "∂v/∂q");
        close(&part(lower, 1), &rows(&expected.velocity_by_velocity), "∂v/∂v");
        close(&part(held.multipliers_by_inputs(), 0), &rows(&expected.impulse_by_position), "∂ι/∂q");
        close(&part(held.multipliers_by_inputs(), 1), &rows(&expected.impulse_by_velocity), "∂ι/∂v");
    }
}

/// A row that repeats another adds no force, and changes no motion.
#[test]
fn dependent_rows_have_no_force() {
    let model = floating_tree(2);
    let [once, twice] = [false, true].map(|twice| held_rows(&model, twice));
    let RandomState { q, v, tau, .. } = random_state(&model, &mut SplitMix64::new(4));
    let mut held = HeldDynamics::new(&model, &twice, RowFeedback::default()).expect("rows");
    held.solve(&model, RobotState { q: &q, v: &v }, &tau).expect("a motion");
    let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
    let expected = constrained_forward_dynamics(&model, w, &once, &options, &q, &v, &tau).expect("a motion");
    assert_eq!((held.rank(), held.rows()), (7, 8));
    assert_eq!(held.multipliers()[7], 0.0);
    assert_close(held.acceleration(), expected.acceleration.as_slice(), AGREEMENT, "a");
    assert_close(&held.multipliers()[..7], expected.multipliers.as_slice(), AGREEMENT, "λ");
}

/// A set without frames: a gear between two coordinates.
#[test]
fn coupled_coordinates_are_held() {
    let model = Arc::new(robot_dynamics::load(TWO_R).expect("an arm").model);
    let names: Vec<String> = model.joints().iter().map(|joint| joint.name.clone()).collect();
    let gear = Coupling::new(&model, &[(&names[0], 1.0), (&names[1], -2.0)], 0.0).expect("a coupling");
    let set = ConstraintSet::new(&model, [("gear", gear.into())]).expect("a set");
    let mut step = HeldContactStep::new(model, &set, RowFeedback::default(), 0.01).expect("a step");
    let mut next = [0.0; 4];
    step.step(&[0.2, 0.1, 1.0, 0.5], &[0.3, -0.4], &mut next).expect("a step");
    assert!((next[2] - 2.0 * next[3]).abs() < 1e-14 && (next[2] - 1.0).abs() > 1e-3);
}

fn step_of(seed: u64) -> HeldContactStep {
    let model = floating_tree(seed);
    let set = held_rows(&model, false);
    let motors = ActuationMatrix::actuated(&model);
    let feedback = RowFeedback { position: 5.0, velocity: 2.0 };
    let step = HeldContactStep::new(model, &set, feedback, 0.02).expect("a step");
    step.with_actuation(motors).expect("motors")
}

/// A, B and the derivatives of forces, along the manifold.
#[test]
fn derivatives_of_steps_and_forces_are_those_of_differences() {
    for seed in 1..4 {
        let (step, mut random) = (step_of(seed), SplitMix64::new(seed));
        let model = floating_tree(seed);
        let set = held_rows(&model, false);
        let impact = ImpactStep::new(model.clone(), &set, 0.3).expect("an impact");
        let x = random_x(&model, &mut random);
        let force = ContactForceResidual::friction_pyramid(&step, [5, 0, 2], 0.6).expect("rows");
        check_force(&step, force, &x, &mut random);
        let all: [Box<dyn DiscreteDynamics>; 2] = [Box::new(step), Box::new(impact)];
        for mut dynamics in all {
            let u: Vec<f64> = (0..dynamics.controls()).map(|_| random.uniform(-1.0, 1.0)).collect();
            check_dynamics(dynamics.as_mut(), &x, &u);
        }
    }
}

fn check_dynamics(dynamics: &mut dyn DiscreteDynamics, x: &[f64], u: &[f64]) {
    let space = dynamics.state_space().clone();
    let (n, m) = (space.tangent(), u.len());
    let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n * m]);
    dynamics
        .linearize(x, u, LinearizedDynamics { by_state: &mut a, by_control: &mut b })
        .expect("derivatives");
    let mut next = x.to_vec();
    dynamics.step(x, u, &mut next).expect("a step");
    let mut displaced = |x: &[f64], u: &[f64]| {
        let (mut moved, mut displacement) = (x.to_vec(), vec![0.0; n]);
        dynamics.step(x, u, &mut moved).expect("a step");
        space.difference(&next, &moved, &mut displacement);
        displacement
    };
    for k in 0..n {
        let column = difference_by_state(&space, x, k, |x| displaced(x, u));
        assert_close(&columns(&a, n, k, 1), &column, DIFFERENCES, &format!("A, column {k}"));
    }
    for k in 0..m {
        let mut at = |h: f64| {
            let mut moved = u.to_vec();
            moved[k] += h;
            displaced(x, &moved)
        };
        let (above, below) = (at(STEP), at(-STEP));
        let column: Vec<f64> = above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * STEP)).collect();
        assert_close(&columns(&b, m, k, 1), &column, DIFFERENCES, &format!("B, column {k}"));
    }
}

fn check_force(step: &HeldContactStep, mut force: ContactForceResidual, x: &[f64], random: &mut SplitMix64) {
    let space = step.state_space().clone();
    let u: Vec<f64> = (0..step.controls()).map(|_| random.uniform(-1.0, 1.0)).collect();
    let (n, m) = (space.tangent(), u.len());
    let (mut r, mut by_x, mut by_u) = (vec![0.0; 5], vec![0.0; 5 * n], vec![0.0; 5 * m]);
    let jacobian = ResidualJacobian { by_state: &mut by_x, by_control: &mut by_u };
    force.linearize(x, &u, &mut r, jacobian).expect("derivatives");
    // The pyramid μλ_n ± λ_x, μλ_n ± λ_y, λ_n of the rows 5, 0 and 2.
    let mut fresh = step.clone();
    fresh.step(x, &u, &mut x.to_vec()).expect("a step");
    let lambda = fresh.contact_forces().expect("forces").multipliers;
    let (x_force, y_force, normal) = (lambda[5], lambda[0], lambda[2]);
    let expected = [
        0.6 * normal + x_force,
        0.6 * normal - x_force,
        0.6 * normal + y_force,
        0.6 * normal - y_force,
        normal,
    ];
    assert_close(&r, &expected, 1e-12, "the pyramid");
    let mut evaluate = |x: &[f64], u: &[f64]| {
        let mut r = vec![0.0; 5];
        force.evaluate(x, u, &mut r).expect("values");
        r
    };
    for k in 0..n {
        let column = difference_by_state(&space, x, k, |x| evaluate(x, &u));
        assert_close(&columns(&by_x, n, k, 1), &column, DIFFERENCES, &format!("∂r/∂x, column {k}"));
    }
    for k in 0..m {
        let mut at = |h: f64| {
            let mut moved = u.clone();
            moved[k] += h;
            evaluate(x, &moved)
        };
        let (above, below) = (at(STEP), at(-STEP));
        let column: Vec<f64> = above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * STEP)).collect();
        assert_close(&columns(&by_u, m, k, 1), &column, DIFFERENCES, &format!("∂r/∂u, column {k}"));
    }
}

#[test]
fn invalid_contacts_are_refused() {
    let model = floating_tree(1);
    let (set, feedback) = (held_rows(&model, false), RowFeedback::default());
    assert!(HeldContactStep::new(model.clone(), &set, feedback, 0.0).is_err());
    let bad = RowFeedback { velocity: f64::NAN, ..feedback };
    assert!(HeldContactStep::new(model.clone(), &set, bad, 0.01).is_err());
    assert!(HeldContactStep::new(model.clone(), &ConstraintSet::default(), feedback, 0.01).is_err());
    assert!(ImpactStep::new(model.clone(), &set, 1.5).is_err());
    let step = HeldContactStep::new(model, &set, feedback, 0.01).expect("a step");
    assert!(ContactForceResidual::tracking(&step, &[0.0; 3]).is_err());
    assert!(ContactForceResidual::new(&step, &[1.0; 6], &[0.0]).is_err());
    assert!(ContactForceResidual::friction_pyramid(&step, [0, 1, 7], 0.5).is_err());
    assert!(ContactForceResidual::friction_pyramid(&step, [0, 1, 2], 0.0).is_err());
}
