//! Pullbacks of steps and rollouts against their linearisations, dual numbers and differences; cotangents by
//! the entries of q.
//!
//! Tolerances: a row of a linearised step is computed with M⁻¹ by another route, which differs by κ(M) ε of
//! its largest numbers.

use robot_dynamics::derivatives::{
    LinearizeStepWorkspace, LinearizedStep, MotionCotangents, ParameterCotangents, RobotState, Rollout,
    RolloutPullbackWorkspace, StepPullbackWorkspace, TrajectoryCotangents, linearize_step, parameter_count,
    rollout_pullback, step_pullback,
};
use robot_dynamics::description::{Base, JointKinds, RandomRobotOptions};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::{Dual, Scalar, SplitMix64};
use robot_dynamics::simulation::{Integrator, StepError, StepForces, StepWorkspace, step};
use robot_dynamics::{Classified, ErrorKind};

use crate::common::{Robot, dot, families, max_difference, size};

const H: f64 = 0.01;

type First = Dual<f64, 1>;

fn explicit_rows() -> impl Iterator<Item = Integrator> {
    Integrator::ALL.into_iter().filter(|row| row.is_explicit())
}

fn random_vector(random: &mut SplitMix64, n: usize) -> Vec<f64> {
    (0..n).map(|_| random.uniform(-1.0, 1.0)).collect()
}

/// Robots for which the Jacobians of a step are accurate.
fn robots() -> impl Iterator<Item = Robot> {
    let all: Vec<Robot> =
        families().iter().flat_map(|family| family.robots().take(12).collect::<Vec<_>>()).collect();
    all.into_iter().filter(|robot| robot.condition() < 1e6)
}

/// (Aᵀ x, Bᵀ x) with A and B of `linearize_step`, and the largest of their entries.
fn transposed(
    robot: &Robot,
    row: Integrator,
    (q, v, tau): (&[f64], &[f64], &[f64]),
    x: &[f64],
) -> ([Vec<f64>; 3], f64) {
    let n = robot.model.nv();
    let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
    let forces = StepForces::new(tau, true);
    let w = &mut LinearizeStepWorkspace::new(&robot.model);
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    linearize_step(&robot.model, row, w, &forces, H, RobotState { q, v }, out)
        .unwrap_or_else(|error| panic!("{row}, seed {}: {error}", robot.seed));
    let column = |m: &[f64], width: usize, j: usize| (0..2 * n).map(|i| x[i] * m[i * width + j]).sum::<f64>();
    let of_a = |first: usize| (0..n).map(|j| column(&a, 2 * n, first + j)).collect();
    let of_b = (0..n).map(|j| column(&b, n, j)).collect();
    ([of_a(0), of_a(n), of_b], size(&a).max(size(&b)))
}

#[test]
fn step_pullback_matches_linearisation() {
    let mut tested = 0;
    for mut robot in robots() {
        let n = robot.model.nv();
        // One floating tree of three turns by 2 rad in a step.
        if robot.family == "floating trees" && robot.seed % 3 == 0 {
            robot.state.v[3..6].copy_from_slice(&[120.0, -100.0, 120.0]);
        }
        let rounding = 1e2 * f64::EPSILON * robot.condition().max(10.0);
        let x = random_vector(&mut SplitMix64::new(robot.seed ^ 0xab), 2 * n);
        let Robot { model, state, .. } = &robot;
        let (q, v, tau) = (&state.q[..], &state.v[..], &state.tau[..]);
        let w = &mut StepPullbackWorkspace::new(model);
        for row in explicit_rows() {
            let (expected, largest) = transposed(&robot, row, (q, v, tau), &x);
            let (mut by_q, mut by_v) = (x[..n].to_vec(), x[n..].to_vec());
            let mut by_tau = vec![7.0; n];
            let forces = StepForces::new(tau, true);
            let cotangents = MotionCotangents {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
                parameters: &mut [],
            };
            step_pullback(model, row, w, &forces, H, RobotState { q, v }, cotangents).unwrap();
            for (found, expected) in [&by_q, &by_v, &by_tau].into_iter().zip(&expected) {
                let allowed = rounding * largest * n as f64;
                robot.require(&format!("{row}"), max_difference(found, expected), allowed);
            }
            tested += 1;
        }
    }
    assert!(tested > 200, "only {tested} steps");
}

/// The adjoint of 25 steps is the chain of the transposed linearisations of the steps, bit for bit with any
/// number of checkpoints.
#[test]
fn rollout_pullback_matches_chain_of_linearised_steps() {
    let (steps, stride) = (25, 5);
    for family in ["floating trees", "trees of all joints", "mimic joints", "chains"] {
        let families = families();
        let family = families.iter().find(|f| f.name == family).unwrap();
        for robot in family.robots().filter(|robot| robot.condition() < 1e4).take(2) {
            let Robot { model, state, seed, .. } = &robot;
            let (n, random) = (model.nv(), &mut SplitMix64::new(seed ^ 0xac));
            let tau = random_vector(random, steps * n);
            let samples = steps / stride;
            let [q_path, v_path] = [(); 2].map(|()| random_vector(random, samples * n));
            let end = random_vector(random, 2 * n);
            for row in explicit_rows() {
                // Forwards, with every state kept.
                let (mut q, mut v) = (state.q.clone(), state.v.clone());
                let w = &mut StepWorkspace::new(model);
                let mut states = Vec::new();
                for k in 0..steps {
                    states.push((q.clone(), v.clone()));
                    let forces = StepForces::new(&tau[k * n..(k + 1) * n], true);
                    step(model, row, w, &forces, H, &mut q, &mut v).unwrap();
                }
                let (mut x, mut by_tau) = (end.clone(), vec![0.0; steps * n]);
                for k in (0..steps).rev() {
                    if (k + 1) % stride == 0 {
                        let sample = (k + 1) / stride - 1;
                        for i in 0..n {
                            x[i] += q_path[sample * n + i];
                            x[n + i] += v_path[sample * n + i];
                        }
                    }
                    let (q, v) = &states[k];
                    let tau = &tau[k * n..(k + 1) * n];
                    let ([q, v, own], _) = transposed(&robot, row, (q, v, tau), &x);
                    by_tau[k * n..(k + 1) * n].copy_from_slice(&own);
                    x = [q, v].concat();
                }
                let rollout = Rollout::new(row, H, steps).with_stride(stride);
                let mut first: Option<Vec<f64>> = None;
                for spacing in [0, 1, 4, 25, 1000] {
                    let (mut by_q, mut by_v) = (end[..n].to_vec(), end[n..].to_vec());
                    let (mut found, mut parameters) =
                        (vec![7.0; steps * n], vec![0.0; parameter_count(model)]);
                    let w = &mut RolloutPullbackWorkspace::new(model, &rollout, spacing);
                    let path = (&q_path[..], &v_path[..]);
                    let cotangents = MotionCotangents {
                        by_position: &mut by_q,
                        by_velocity: &mut by_v,
                        by_force: &mut found,
                        parameters: &mut parameters,
                    };
                    rollout_pullback(
                        model,
                        &rollout,
                        w,
                        RobotState { q: &state.q, v: &state.v },
                        &tau,
                        TrajectoryCotangents { by_position: path.0, by_velocity: path.1 },
                        cotangents,
                    )
                    .unwrap();
                    let all = [by_q, by_v, found, parameters].concat();
                    let expected = [&x[..], &by_tau].concat();
                    // Rounding grows along the rollout as the gradient does.
                    let allowed = 1e-11 * robot.condition() * size(&expected).max(1.0);
                    robot.require(
                        &format!("{row}"),
                        max_difference(&all[..expected.len()], &expected),
                        allowed,
                    );
                    let first = first.get_or_insert_with(|| all.clone());
                    assert_eq!(*first, all, "{row}, a checkpoint each {spacing} steps");
                }
            }
        }
    }
}

/// q̇ = v, v̇ by forward dynamics: the classical Runge–Kutta step over any scalar type, written for this
/// test.
fn runge_kutta<S: Scalar>(model: &Model, w: &mut Workspace<S>, tau: &[S], q: &mut Vec<S>, v: &mut Vec<S>) {
    let n = q.len();
    let shifted =
        |x: &[S], k: f64, y: &[S]| -> Vec<S> { x.iter().zip(y).map(|(&x, &y)| x + y.scale(k)).collect() };
    let mut slope = |q: &[S], v: &[S]| {
        let (mut a, mut b) = (vec![S::zero(); n], vec![S::zero(); n]);
        robot_dynamics::algorithms::dissipation(model, v, &mut b);
        robot_dynamics::algorithms::forward_dynamics(model, w, q, v, &shifted(tau, -1.0, &b), &mut a);
        (v.to_vec(), a)
    };
    let one = slope(q, v);
    let two = slope(&shifted(q, 0.5 * H, &one.0), &shifted(v, 0.5 * H, &one.1));
    let three = slope(&shifted(q, 0.5 * H, &two.0), &shifted(v, 0.5 * H, &two.1));
    let four = slope(&shifted(q, H, &three.0), &shifted(v, H, &three.1));
    for (k, slope) in [(1.0, one), (2.0, two), (2.0, three), (1.0, four)] {
        *q = shifted(q, k * H / 6.0, &slope.0);
        *v = shifted(v, k * H / 6.0, &slope.1);
    }
}

/// A rollout over dual numbers along a direction of state and torques: λᵀδ(q, v) at the end is the gradient
/// times δ.
#[test]
fn rollout_pullback_matches_dual_numbers() {
    let options = RandomRobotOptions { kinds: JointKinds::VectorSpace, joints: 6, ..Default::default() };
    let steps = 30;
    for seed in 0..20 {
        let robot = Robot::new("plain trees", seed, &options);
        if robot.condition() > 1e4 {
            continue;
        }
        let Robot { model, state, .. } = &robot;
        let (n, random) = (model.nv(), &mut SplitMix64::new(seed ^ 0xad));
        let [dq, dv, lq, lv] = [(); 4].map(|()| random_vector(random, n));
        let (tau, dtau) = (random_vector(random, steps * n), random_vector(random, steps * n));
        let along = |x: &[f64], dx: &[f64]| -> Vec<First> {
            x.iter().zip(dx).map(|(&value, &dx)| Dual { value, gradient: [dx] }).collect()
        };
        let (mut q, mut v) = (along(&state.q, &dq), along(&state.v, &dv));
        let (forces, w) = (along(&tau, &dtau), &mut Workspace::new(model));
        for tau in forces.chunks_exact(n) {
            runge_kutta(model, w, tau, &mut q, &mut v);
        }
        let change = |x: &[First]| x.iter().map(|x| x.gradient[0]).collect::<Vec<f64>>();
        let expected = dot(&lq, &change(&q)) + dot(&lv, &change(&v));
        let rollout = Rollout::new(Integrator::RungeKutta4, H, steps);
        let w = &mut RolloutPullbackWorkspace::new(model, &rollout, 0);
        let (mut by_q, mut by_v, mut by_tau) = (lq.clone(), lv.clone(), vec![0.0; steps * n]);
        let cotangents = MotionCotangents {
            by_position: &mut by_q,
            by_velocity: &mut by_v,
            by_force: &mut by_tau,
            parameters: &mut [],
        };
        rollout_pullback(
            model,
            &rollout,
            w,
            RobotState { q: &state.q, v: &state.v },
            &tau,
            TrajectoryCotangents::default(),
            cotangents,
        )
        .unwrap();
        let found = dot(&by_q, &dq) + dot(&by_v, &dv) + dot(&by_tau, &dtau);
        let terms = size(&by_q) + size(&by_v) + size(&by_tau);
        robot.require("λᵀδ", (found - expected).abs(), 1e-12 * robot.condition() * terms * n as f64);
    }
}

/// Derivatives by damping, masses and other parameters through 20 steps of a floating tree, by fourth-order
/// differences of rebuilt robots. Their errors are δ⁴ = 1e-12 of a fifth derivative, and ε/δ = 2e-13 of the
/// numbers at the end. An armature of 1 kg·m² keeps the fifth derivative near 1.
#[test]
fn parameters_of_rollout_match_differences() {
    let steps = 20;
    let mut robot = crate::common::damped_tree(5).description().clone();
    robot.joints.iter_mut().for_each(|joint| joint.passive.armature += 1.0);
    let model = Model::new(robot).unwrap();
    let state = robot_dynamics::model::random_state(&model, &mut SplitMix64::new(6));
    let (n, random) = (model.nv(), &mut SplitMix64::new(7));
    let (tau, end) = (random_vector(random, n), random_vector(random, 2 * n));
    let nominal = |model: &Model| {
        let (mut q, mut v) = (state.q.clone(), state.v.clone());
        let (w, forces) = (&mut StepWorkspace::new(model), StepForces::new(&tau, true));
        for _ in 0..steps {
            step(model, Integrator::RungeKutta4, w, &forces, 1e-3, &mut q, &mut v).unwrap();
        }
        (q, v)
    };
    let (q_end, _) = nominal(&model);
    // end·(q ⊖ q_end, v): its gradient by q ⊕ δ at q_end is `end`.
    let loss = |model: &Model| {
        let (q, v) = nominal(model);
        let mut moved = vec![0.0; n];
        robot_dynamics::model::difference(model, &q_end, &q, &mut moved);
        dot(&end[..n], &moved) + dot(&end[n..], &v)
    };
    let rollout = Rollout::new(Integrator::RungeKutta4, 1e-3, steps);
    let w = &mut RolloutPullbackWorkspace::new(&model, &rollout, 0);
    let (mut by_q, mut by_v, mut by_tau) = (end[..n].to_vec(), end[n..].to_vec(), vec![0.0; n]);
    let mut parameters = vec![0.0; parameter_count(&model)];
    let cotangents = MotionCotangents {
        by_position: &mut by_q,
        by_velocity: &mut by_v,
        by_force: &mut by_tau,
        parameters: &mut parameters,
    };
    rollout_pullback(
        &model,
        &rollout,
        w,
        RobotState { q: &state.q, v: &state.v },
        &tau,
        TrajectoryCotangents::default(),
        cotangents,
    )
    .unwrap();
    let by = ParameterCotangents::of(&model, &parameters);
    let slope = |change: &dyn Fn(&mut robot_dynamics::description::RobotDescription, f64)| {
        let side = |delta: f64| {
            let mut changed = model.description().clone();
            change(&mut changed, delta);
            loss(&Model::new(changed).unwrap())
        };
        let between = |delta: f64| side(delta) - side(-delta);
        (8.0 * between(1e-3) - between(2e-3)) / 12e-3
    };
    let mut compared = 0;
    let mut judge = |what: &str, found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{what}: {found} {expected}");
        compared += usize::from(expected.abs() > 1e-6);
    };
    for k in 0..3 {
        judge("gravity", by.gravity[k], slope(&|robot, delta| robot.gravity[k] += delta));
    }
    for (joint, by) in model.moving_joints().zip(by.passive.chunks_exact(5)) {
        let index = model.description().joints.iter().position(|own| own.name == joint.name);
        let Some(index) = index.filter(|_| joint.nv > 0) else { continue };
        judge("armature", by[0], slope(&|robot, delta| robot.joints[index].passive.armature += delta));
        judge("damping", by[1], slope(&|robot, delta| robot.joints[index].passive.damping += delta));
    }
    // The mass alone, with first and second moments about the origin of the link held.
    for (link, by) in model.moving_links().zip(by.inertial.chunks_exact(10)) {
        let index = model.description().links.iter().position(|own| own.name == link).unwrap();
        let Some(own) = &model.description().links[index].mass_properties else { continue };
        // Links that fixed joints attach to this one add to it, so only links without them are changed here.
        let expected = slope(&|robot, delta| {
            let (m, c) = (own.mass() + delta, own.center_of_mass() * own.mass());
            let inertia = own.inertia_about_origin();
            let about = |m: f64, h: nalgebra::Vector3<f64>| {
                inertia - (nalgebra::Matrix3::identity() * h.dot(&h) - h * h.transpose()) / m
            };
            robot.links[index].mass_properties =
                robot_dynamics::description::MassProperties::new(m, c / m, about(m, c)).ok();
        });
        judge("mass", by[0], expected);
    }
    assert!(compared > 15, "only {compared} gradients were not small");
}

/// The Hessian of a number of the end, computed over dual numbers, is symmetric.
#[test]
fn step_over_dual_numbers_has_symmetric_hessian() {
    let options = RandomRobotOptions { kinds: JointKinds::VectorSpace, joints: 6, ..Default::default() };
    for seed in 0..8 {
        let robot = Robot::new("plain trees", seed, &options);
        if robot.condition() > 1e4 {
            continue;
        }
        let Robot { model, state, .. } = &robot;
        let (n, random) = (model.nv(), &mut SplitMix64::new(seed ^ 0xae));
        let [x, y, end] = [(); 3].map(|()| random_vector(random, 2 * n));
        let constants = |x: &[f64]| x.iter().map(|&x| Dual::constant(x)).collect::<Vec<First>>();
        let tau = constants(&state.tau);
        let w = &mut StepPullbackWorkspace::<First>::new(model);
        let mut along = |x: &[f64], y: &[f64]| {
            let vary = |s: &[f64], x: &[f64]| -> Vec<First> {
                s.iter().zip(x).map(|(&value, &x)| Dual { value, gradient: [x] }).collect()
            };
            let (q, v) = (vary(&state.q, &x[..n]), vary(&state.v, &x[n..]));
            let (mut by_q, mut by_v) = (constants(&end[..n]), constants(&end[n..]));
            let mut by_tau = constants(&vec![0.0; n]);
            let forces = StepForces::new(&tau, true);
            let row = Integrator::RungeKutta4;
            let cotangents = MotionCotangents {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
                parameters: &mut [],
            };
            step_pullback(model, row, w, &forces, H, RobotState { q: &q, v: &v }, cotangents).unwrap();
            by_q.iter().chain(&by_v).zip(y).map(|(by, y)| by.gradient[0] * y).sum::<f64>()
        };
        let (one, other) = (along(&x, &y), along(&y, &x));
        robot.require("the Hessian", (one - other).abs(), 1e-11 * robot.condition() * one.abs().max(1.0));
        assert!(one.abs() > 1e-3);
    }
}

/// λᵀτ by each of the nq numbers of q over dual numbers, for quaternions of any length: the extension that
/// depends on their direction only.
#[test]
fn cotangents_in_coordinates_are_gradients_by_them() {
    let options = RandomRobotOptions { base: Base::Floating, ..Default::default() };
    for seed in 0..30 {
        let robot = Robot::new("floating trees", seed, &options);
        let Robot { model, state, .. } = &robot;
        let (n, random) = (model.nv(), &mut SplitMix64::new(seed ^ 0xaf));
        let mut q = state.q.clone();
        for joint in model.joints().iter().filter(|joint| joint.nq > joint.nv) {
            let length = random.uniform(0.5, 2.0);
            let at = joint.q_index + joint.nq - 4;
            q[at..at + 4].iter_mut().for_each(|x| *x *= length);
        }
        let lambda = random_vector(random, n);
        let [mut by_q, mut by_v, mut by_a] = [(); 3].map(|()| vec![0.0; n]);
        let out = robot_dynamics::derivatives::InversePullbackMut {
            by_position: &mut by_q,
            by_velocity: &mut by_v,
            by_acceleration: &mut by_a,
            parameters: &mut [],
        };
        robot_dynamics::derivatives::inverse_dynamics_pullback(
            model,
            &mut Workspace::new(model),
            &q,
            &state.v,
            &state.a,
            &lambda,
            out,
        );
        let mut found = vec![7.0; model.nq()];
        robot_dynamics::model::cotangent_to_coordinates(model, &q, &by_q, &mut found);
        let constants = |x: &[f64]| x.iter().map(|&x| Dual::constant(x)).collect::<Vec<First>>();
        let (w, mut tau) = (&mut Workspace::<First>::new(model), constants(&vec![0.0; n]));
        let expected: Vec<f64> = (0..model.nq())
            .map(|k| {
                let mut varied = constants(&q);
                varied[k].gradient = [1.0];
                robot_dynamics::algorithms::inverse_dynamics(
                    model,
                    w,
                    &varied,
                    &constants(&state.v),
                    &constants(&state.a),
                    &mut tau,
                );
                tau.iter().zip(&lambda).map(|(tau, lambda)| tau.gradient[0] * lambda).sum()
            })
            .collect();
        let scale = size(&expected).max(model.mass() * 9.81 + size(&robot.mass()) * dot(&state.v, &state.v));
        robot.require("by coordinates", max_difference(&found, &expected), 1e-12 * scale * n as f64);
        let mut back = vec![7.0; n];
        robot_dynamics::model::cotangent_from_coordinates(model, &q, &found, &mut back);
        robot.require("back", max_difference(&back, &by_q), 1e-14 * size(&by_q));
        // Any function of the stored numbers, here a sum: its gradient by q ⊕ δ is the rate of the sum along
        // it.
        let weights = random_vector(random, model.nq());
        robot_dynamics::model::cotangent_from_coordinates(model, &state.q, &weights, &mut back);
        let delta = random_vector(random, n);
        let moved = crate::common::moved_along(model, &state.q, &delta);
        let rate: f64 = moved.iter().zip(&weights).map(|(q, w)| q.gradient[0] * w).sum();
        robot.require("a sum", (dot(&back, &delta) - rate).abs(), 1e-14 * n as f64);
    }
}

#[test]
fn invalid_pullbacks_are_errors() {
    let families = families();
    let Robot { model, state, .. } = families[2].robots().next().unwrap();
    let n = model.nv();
    let forces = StepForces::new(&state.tau, false);
    let w = &mut StepPullbackWorkspace::new(&model);
    let integrator = Integrator::VariationalMidpoint;
    let before = vec![1.0; n];
    let (mut x, mut y, mut z) = (before.clone(), before.clone(), before.clone());
    let mut call = |row: Integrator, h: f64, q: &[f64], v: &[f64]| {
        let cotangents = MotionCotangents {
            by_position: &mut x,
            by_velocity: &mut y,
            by_force: &mut z,
            parameters: &mut [],
        };
        let result = step_pullback(&model, row, w, &forces, h, RobotState { q, v }, cotangents);
        assert!(x == before && y == before && z == before);
        result
    };
    let refused = call(integrator, H, &state.q, &state.v);
    assert_eq!(refused, Err(StepError::NotDifferentiable { integrator }));
    let rk4 = Integrator::RungeKutta4;
    let mut v = state.v.clone();
    v[1] = f64::NAN;
    let refused = call(rk4, H, &state.q, &v).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::InvalidInput);
    assert_eq!(refused.to_string(), "v[1] is NaN; every number must be finite");
    assert!(matches!(call(rk4, -1.0, &state.q, &state.v), Err(StepError::Integrator(_))));
    // Numbers that overflow during the computation.
    v.fill(1e200);
    assert!(matches!(call(rk4, H, &state.q, &v), Err(StepError::Integrator(_))));
    // A hinge that moves no inertia.
    let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
    robot.links[1].mass_properties = None;
    let model = Model::new(robot).unwrap();
    let forces = StepForces::new(&[0.0], false);
    let w = &mut StepPullbackWorkspace::new(&model);
    let cotangents = MotionCotangents {
        by_position: &mut [1.0],
        by_velocity: &mut [1.0],
        by_force: &mut [0.0],
        parameters: &mut [],
    };
    let refused = step_pullback(&model, rk4, w, &forces, H, RobotState { q: &[0.0], v: &[0.0] }, cotangents);
    let Err(StepError::SingularMass(mass)) = &refused else { panic!("{refused:?}") };
    assert_eq!(mass.joints(), ["hinge"]);
    let rollout = Rollout::new(integrator, H, 3).with_dissipation(false);
    let w = &mut RolloutPullbackWorkspace::<f64>::new(&model, &rollout, 0);
    let mut pull = |rollout: &Rollout| {
        let cotangents = MotionCotangents {
            by_position: &mut [1.0],
            by_velocity: &mut [1.0],
            by_force: &mut [],
            parameters: &mut [],
        };
        rollout_pullback(
            &model,
            rollout,
            w,
            RobotState { q: &[0.0], v: &[0.0] },
            &[],
            TrajectoryCotangents::default(),
            cotangents,
        )
    };
    assert_eq!(pull(&rollout), Err(StepError::NotDifferentiable { integrator }));
    assert!(matches!(pull(&Rollout::new(rk4, H, 3)), Err(StepError::SingularMass(_))));
}

#[test]
fn short_cotangent_panics() {
    let model = Model::new(robot_dynamics::description::pendulum(2.0, 0.5)).unwrap();
    let (w, x) = (&mut Workspace::<f64>::new(&model), &mut [0.0]);
    let state = &[0.0];
    let call = std::panic::AssertUnwindSafe(|| {
        let (y, z) = (&mut [], &mut [0.0]);
        let out = robot_dynamics::derivatives::InversePullbackMut {
            by_position: x,
            by_velocity: y,
            by_acceleration: z,
            parameters: &mut [],
        };
        robot_dynamics::derivatives::inverse_dynamics_pullback(&model, w, state, state, state, state, out);
    });
    assert!(std::panic::catch_unwind(call).is_err());
}
