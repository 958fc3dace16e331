//! The regulator of a linearised step holds robots upright in the nonlinear simulation with that step.

use nalgebra::{DMatrix, Matrix3};
use robot_dynamics::control::{Dlqr, DlqrError, dlqr};
use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::{Model, difference, integrate, neutral};
use robot_dynamics::simulation::{
    Effect, Integrator, Method, RunOptions, Simulation, SimulationBuilder, StepForces,
};

use crate::common::{chain, families};

const H: f64 = 0.01;

/// One control period is one step: A and B describe the map that the run repeats.
fn simulation(model: &Model) -> Simulation {
    SimulationBuilder::new(model)
        .method(Method::Fixed(Integrator::RungeKutta4))
        .dt(H)
        .without(Effect::Dissipation)
        .build()
        .unwrap()
}

/// A of the step at rest in q\* under τ\*, and the gain of the motors named by their coordinates.
fn regulator(model: &Model, q: &[f64], tau: &[f64], motors: &[usize]) -> (DMatrix<f64>, Dlqr) {
    let n = model.nv();
    let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
    let forces = StepForces::new(tau, false);
    let mut workspace = LinearizeStepWorkspace::new(model);
    let row = Integrator::RungeKutta4;
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    linearize_step(model, row, &mut workspace, &forces, H, RobotState { q, v: &vec![0.0; n] }, out).unwrap();
    let a = DMatrix::from_row_slice(2 * n, 2 * n, &a);
    let b = DMatrix::from_row_slice(2 * n, n, &b).select_columns(motors);
    let effort = DMatrix::identity(motors.len(), motors.len()) * 1e-2;
    let found = dlqr(&a, &b, &DMatrix::identity(2 * n, 2 * n), &effort).unwrap();
    (a, found)
}

/// |(q ⊖ q\*, v)| after a number of steps of τ\* − K (q ⊖ q\*, v) from q\* ⊕ δ at rest; K = 0 releases the
/// robot.
fn distance(
    model: &Model,
    target: &[f64],
    tau: &[f64],
    gain: &DMatrix<f64>,
    motors: &[usize],
    delta: &[f64],
    steps: usize,
) -> f64 {
    let n = model.nv();
    let mut start = target.to_vec();
    integrate(model, target, delta, &mut start);
    let state = |q: &[f64], v: &[f64]| {
        let mut x = DMatrix::zeros(2 * n, 1);
        difference(model, target, q, &mut x.as_mut_slice()[..n]);
        x.as_mut_slice()[n..].copy_from_slice(v);
        x
    };
    let mut control = |_: f64, q: &[f64], v: &[f64], out: &mut [f64]| {
        out.copy_from_slice(tau);
        let feedback = gain * state(q, v);
        for (&k, u) in motors.iter().zip(feedback.iter()) {
            out[k] -= u;
        }
    };
    let run = simulation(model)
        .run_steps_from(
            &start,
            &vec![0.0; n],
            steps,
            RunOptions::new().sample_ends().controller(&mut control),
        )
        .unwrap_or_else(|failure| panic!("{failure}"));
    state(&run.q, &run.v).norm()
}

/// Asserts that after 20 s with the gain the distance from q\* has decayed as the slowest mode of the linear
/// loop. Without the gain it grows within a fifth of a second.
#[track_caller]
fn stays(model: &Model, target: &[f64], tau: &[f64], motors: &[usize], delta: &[f64]) {
    let (a, found) = regulator(model, target, tau, motors);
    let grows = a.complex_eigenvalues().iter().map(|x| x.norm()).fold(0.0, f64::max);
    assert!(grows > 1.0 + 1e-3, "{grows}: nothing to hold up");
    let away = DMatrix::from_column_slice(delta.len(), 1, delta).norm();
    let off = |gain: &DMatrix<f64>, steps| distance(model, target, tau, gain, motors, delta, steps);
    assert!(off(&(&found.gain * 0.0), 20) > 1.5 * away, "it stands on its own");
    // ρ²⁰⁰⁰ of the start, times a thousand for modes far from orthogonal, plus rounding.
    let left = found.spectral_radius.powi(2000) * 1e3 + 1e-9;
    let (found_off, radius) = (off(&found.gain, 2000), found.spectral_radius);
    assert!(left < 1e-5 && found_off <= left, "{found_off:e} of {left:e}, radius {radius}");
}

/// Seven upright rods with seven motors, and without a motor at the lowest joint.
#[test]
fn regulator_holds_chain_of_seven() {
    let model = chain(7);
    let mut target = neutral(&model);
    target[0] = std::f64::consts::PI;
    let tau = model.gravity_forces(&target).unwrap();
    let delta = [0.1, -0.1, 0.05, 0.0, 0.1, -0.05, 0.1];
    stays(&model, &target, tau.as_slice(), &[0, 1, 2, 3, 4, 5, 6], &delta);
    stays(&model, &target, tau.as_slice(), &[1, 2, 3, 4, 5, 6], &delta.map(|x| 0.05 * x));
}

/// A rod on a cart; only the cart is driven.
#[test]
fn regulator_balances_rod_on_cart() {
    let body = |mass: f64, at: f64| {
        MassProperties::new(mass, [0.0, 0.0, at].into(), Matrix3::identity() * 0.01 * mass).unwrap()
    };
    let mut robot = RobotDescription::new("cart and rod");
    for (name, mass_properties) in
        [("track", None), ("cart", Some(body(1.0, 0.0))), ("rod", Some(body(0.2, 0.5)))]
    {
        robot.links.push(LinkDescription::new(name, mass_properties));
    }
    let (slide, hinge) =
        (JointKind::Prismatic { axis: [1.0, 0.0, 0.0] }, JointKind::Continuous { axis: [0.0, 1.0, 0.0] });
    robot.joints.push(JointDescription::new("slide", slide, "track", "cart", Pose::IDENTITY));
    robot.joints.push(JointDescription::new("hinge", hinge, "cart", "rod", Pose::IDENTITY));
    let model = Model::new(robot).unwrap();
    stays(&model, &[0.0, 0.0], &[0.0, 0.0], &[0], &[0.3, 0.3]);
}

/// A heavy top on a ball joint, held about any axis: x has six numbers, q a quaternion.
#[test]
fn regulator_holds_top_on_ball_joint() {
    let mut robot = RobotDescription::new("top");
    let top = MassProperties::new(2.0, [0.0, 0.0, 0.4].into(), Matrix3::identity() * 0.02).unwrap();
    for (name, mass_properties) in [("floor", None), ("top", Some(top))] {
        robot.links.push(LinkDescription::new(name, mass_properties));
    }
    robot.joints.push(JointDescription::new("ball", JointKind::Spherical, "floor", "top", Pose::IDENTITY));
    let model = Model::new(robot).unwrap();
    let target = neutral(&model);
    stays(&model, &target, &[0.0; 3], &[0, 1, 2], &[0.4, -0.5, 1.0]);
}

/// Every random robot with a motor on each degree of freedom has a gain at any pose, with steps of 10 ms and
/// 1 ms. The robots include thin rods with κ(M) of 1e10. Without motors on a floating base no gain holds
/// its momentum, and the error names that mode.
///
/// P is the cost of K for a step and all later ones, Q + KᵀR K + (A−BK)ᵀP(A−BK). An error of K enters by its
/// square, and the remainder is the rounding of the sum.
#[test]
fn every_fully_actuated_robot_has_a_gain() {
    let (mut found, mut refused) = (0, 0);
    for robot in families().iter().flat_map(|family| family.robots().take(8)) {
        let (model, n) = (&robot.model, robot.model.nv());
        if n > 30 {
            continue;
        }
        let rest = vec![0.0; n];
        let tau = model.inverse_dynamics(&robot.state.q, &rest, &rest).expect("finite");
        let forces = StepForces::new(tau.as_slice(), false);
        let workspace = &mut LinearizeStepWorkspace::new(model);
        for h in [1e-2, 1e-3] {
            let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
            let row = Integrator::RungeKutta4;
            // Where M is singular there is no step.
            if linearize_step(
                model,
                row,
                workspace,
                &forces,
                h,
                RobotState { q: &robot.state.q, v: &rest },
                LinearizedStep { by_state: &mut a, by_force: &mut b },
            )
            .is_err()
            {
                continue;
            }
            let (a, b) = (DMatrix::from_row_slice(2 * n, 2 * n, &a), DMatrix::from_row_slice(2 * n, n, &b));
            let (q, r) = (DMatrix::identity(2 * n, 2 * n), DMatrix::identity(n, n) * 1e-3);
            let Dlqr { gain, cost, spectral_radius, .. } = dlqr(&a, &b, &q, &r)
                .unwrap_or_else(|error| panic!("{}, seed {}, h {h}: {error}", robot.family, robot.seed));
            let closed = &a - &b * &gain;
            let again = &q + gain.transpose() * &r * &gain + closed.transpose() * &cost * &closed;
            let off = (again - &cost).norm() / cost.norm();
            robot.require("P is the cost of K", off, 10.0 * n as f64 * f64::EPSILON * closed.norm_squared());
            robot.require("A − BK contracts", spectral_radius, 1.0 - 1e-6);
            found += 1;

            if robot.family == "floating trees" {
                let free = b.columns(6, n - 6).into_owned();
                let error = dlqr(&a, &free, &q, &(DMatrix::identity(n - 6, n - 6) * 1e-3)).unwrap_err();
                assert!(matches!(error, DlqrError::NotStabilizable { .. }), "seed {}: {error}", robot.seed);
                refused += 1;
            }
        }
    }
    assert!(found > 80 && refused > 10, "{found} gains, {refused} refused");
}
