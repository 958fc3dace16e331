//! The Lagrange recipe against every route of this machine: portable code, AVX2 and AVX-512, single states
//! and lanes, f64 and f32.
//!
//! Instruction sets that the machine lacks are listed on standard error and skipped.

use std::io::Write;

use robot_dynamics::algorithms::ReferenceFrame;
use robot_dynamics::batch;
use robot_dynamics::batch::{BatchFloat, BatchOptions, BatchWorkspace, Rollout, Torques};
use robot_dynamics::description::{RandomRobotOptions, random_robot};
use robot_dynamics::model::{InstructionSet, Model, Workspace, random_state};
use robot_dynamics::number::{Dual, Scalar, SplitMix64};
use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, step};
use robot_dynamics::verification::lagrange;

use crate::common::{Robot, dot, families, max_difference, size, times};

/// Terms are summed along paths of at most 60 joints; 1e-13 of the largest allows 450 roundings.
const ROUNDING: f64 = 1e-13;

/// The instruction sets of this machine; the others are listed.
fn available() -> Vec<InstructionSet> {
    let (here, missing): (Vec<_>, Vec<_>) = InstructionSet::ALL.iter().partition(|set| set.is_available());
    for set in missing {
        // Not by a macro, whose output the test harness captures.
        let _ = writeln!(std::io::stderr(), "this machine has no {set}: not checked");
    }
    here
}

/// A workspace for single states on each set that can run it; on AVX2 without and with AVX-512 for the
/// functions that benefit from it.
fn workspaces<S: Scalar>(model: &Model) -> Vec<Workspace<S>> {
    let here = InstructionSet::ALL.iter().copied().filter(|set| set.is_available());
    here.map(|set| Workspace::limited(model, set)).collect()
}

/// A workspace for batches that runs on this set.
fn batch_workspace<T: BatchFloat>(model: &Model, set: InstructionSet, threads: usize) -> BatchWorkspace<T> {
    let mut options = BatchOptions::default();
    options.threads = threads;
    options.limit = Some(set);
    BatchWorkspace::with_options(model, options).unwrap()
}

/// Robots of every family.
fn robots(each: usize) -> Vec<Robot> {
    families().iter().flat_map(|family| family.robots().take(each).collect::<Vec<_>>()).collect()
}

/// Each set is reached by the workspaces that name it, with the lanes of a register.
#[test]
fn workspaces_run_on_their_instruction_set() {
    let model = Model::new(random_robot(1, &RandomRobotOptions::default())).unwrap();
    assert_eq!(
        Workspace::<f64>::limited(&model, InstructionSet::Portable).instruction_set(),
        InstructionSet::Portable
    );
    let best = available().pop().unwrap();
    // The recursions of single states do not benefit from AVX-512.
    let single = if best == InstructionSet::Avx512 { InstructionSet::Avx2 } else { best };
    assert_eq!(Workspace::<f64>::new(&model).instruction_set(), single);
    assert_eq!(Workspace::<f32>::new(&model).instruction_set(), single);
    for set in available() {
        let (doubles, singles) =
            (batch_workspace::<f64>(&model, set, 1), batch_workspace::<f32>(&model, set, 1));
        assert_eq!((doubles.instruction_set(), singles.instruction_set()), (set, set));
        let lanes = match set {
            InstructionSet::Avx512 => (8, 16),
            InstructionSet::Avx2 | InstructionSet::Neon | InstructionSet::Simd128 => (4, 8),
            _ => (1, 1),
        };
        assert_eq!((doubles.lanes(), singles.lanes()), lanes, "{set}");
    }
    assert_eq!(BatchWorkspace::<f64>::new(&model).instruction_set(), best);
}

/// M, K, V, C v, g, τ, poses and Jacobians of a single state match the recipe by every route.
#[test]
fn one_state_matches_lagrange() {
    for robot in robots(14) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, nv) = (&state.q[..], &state.v[..], &state.a[..], model.nv());
        let oracle_mass = lagrange::mass_matrix(model, q);
        let oracle = [
            lagrange::velocity_product(model, q, v),
            lagrange::gravity(model, q),
            lagrange::bias(model, q, v),
            lagrange::inverse_dynamics(model, q, v, a),
        ];
        let (kinetic, potential) =
            (lagrange::kinetic_energy(model, q, v), lagrange::potential_energy(model, q));
        let mass_size = size(&oracle_mass);
        // C v is an inertia times two velocities, g a weight on an arm of a metre.
        let scale = mass_size * (dot(v, v) + dot(a, a).sqrt()) + size(&oracle[1]) + model.mass() * 9.81;
        let reach = 1.0 + model.joints().len() as f64;
        for w in &mut workspaces::<f64>(model) {
            let law = |name: &str| format!("{name} by {}", w.instruction_set());
            let names = ["M", "C v", "g", "C v + g", "τ", "K", "V", "R", "p", "J"].map(law);
            let mut mass = vec![0.0; nv * nv];
            robot_dynamics::algorithms::mass_matrix(model, w, q, &mut mass);
            robot.require(&names[0], max_difference(&mass, &oracle_mass), ROUNDING * mass_size);
            let mut forces = [(); 4].map(|()| vec![0.0; nv]);
            robot_dynamics::algorithms::velocity_product(model, w, q, v, &mut forces[0]);
            robot_dynamics::algorithms::gravity(model, w, q, &mut forces[1]);
            robot_dynamics::algorithms::bias(model, w, q, v, &mut forces[2]);
            robot_dynamics::algorithms::inverse_dynamics(model, w, q, v, a, &mut forces[3]);
            for k in 0..4 {
                robot.require(&names[k + 1], max_difference(&forces[k], &oracle[k]), ROUNDING * scale);
            }
            let defect = (robot_dynamics::algorithms::kinetic_energy(model, w, q, v) - kinetic).abs();
            robot.require(&names[5], defect, ROUNDING * mass_size * dot(v, v));
            let defect = (robot_dynamics::algorithms::potential_energy(model, w, q) - potential).abs();
            robot.require(&names[6], defect, ROUNDING * (potential.abs() + model.mass() * 9.81));
            for (link, oracle) in model.description().links.iter().zip(lagrange::link_kinematics(model, q)) {
                let frame = model.frame(&link.name).unwrap();
                let pose = robot_dynamics::algorithms::frame_pose(model, w, q, frame);
                let (found, expected) = (pose.rotation.as_flattened(), oracle.rotation());
                robot.require(&names[7], max_difference(found, expected.as_flattened()), ROUNDING);
                let defect = max_difference(&pose.translation, &oracle.origin());
                robot.require(&names[8], defect, ROUNDING * reach);
                let mut jacobian = vec![0.0; 6 * nv];
                robot_dynamics::algorithms::frame_jacobian(
                    model,
                    w,
                    q,
                    frame,
                    ReferenceFrame::LocalWorldAligned,
                    &mut jacobian,
                );
                let (linear, angular) = (oracle.point_jacobian([0.0; 3]), oracle.angular_jacobian());
                let expected: Vec<f64> = (0..6 * nv)
                    .map(|n| if n / nv < 3 { linear[n % nv][n / nv] } else { angular[n % nv][n / nv - 3] })
                    .collect();
                robot.require(&names[9], max_difference(&jacobian, &expected), ROUNDING * reach);
            }
        }
    }
}

/// Where M is inverted: 64 ε κ(M) of the sizes of M⁻¹f and a. A tree is at most a few tens of joints deep.
fn solved(robot: &Robot, force_size: f64, a: &[f64]) -> f64 {
    64.0 * f64::EPSILON * robot.condition() * (force_size / size(&robot.mass()) + dot(a, a).sqrt())
}

/// a by articulated bodies and by Cholesky, and M⁻¹, by every route.
#[test]
fn accelerations_of_one_state_match_lagrange() {
    for robot in robots(14) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau, nv) = (&state.q[..], &state.v[..], &state.tau[..], model.nv());
        let oracle = lagrange::forward_dynamics(model, q, v, tau);
        let gravity = size(&lagrange::gravity(model, q)) + model.mass() * 9.81;
        let force_size = dot(tau, tau).sqrt() + gravity + size(&robot.mass()) * dot(v, v);
        let allowed = solved(&robot, force_size, &oracle);
        let mass = lagrange::mass_matrix(model, q);
        for w in &mut workspaces::<f64>(model) {
            let set = w.instruction_set();
            let mut a = vec![0.0; nv];
            robot_dynamics::algorithms::forward_dynamics(model, w, q, v, tau, &mut a);
            robot.require(&format!("articulated bodies by {set}"), max_difference(&a, &oracle), allowed);
            robot_dynamics::algorithms::forward_dynamics_by_cholesky(model, w, q, v, tau, &mut a);
            robot.require(&format!("Cholesky by {set}"), max_difference(&a, &oracle), allowed);
            let mut inverse = vec![0.0; nv * nv];
            robot_dynamics::algorithms::inverse_mass_matrix(model, w, q, &mut inverse);
            for i in 0..nv {
                let mut row = times(&mass, &inverse[i * nv..(i + 1) * nv]);
                row[i] -= 1.0;
                // |M| |M⁻¹| ε is κ(M) ε, times the number of terms of a sum.
                let allowed = 64.0 * f64::EPSILON * robot.condition() * nv as f64;
                robot.require(&format!("M M⁻¹ = 1 by {set}"), size(&row), allowed);
            }
        }
    }
}

/// ∂τ/∂q v + ∂τ/∂v a is dτ/dt of the recipe over dual numbers that move with (q̇, a), and M ∂a/∂q = −∂τ/∂q,
/// by every route.
#[test]
fn derivatives_of_one_state_match_lagrange() {
    type D = Dual<f64, 1>;
    for robot in robots(12) {
        let Robot { model, state, .. } = &robot;
        let (q, v, tau, nv) = (&state.q[..], &state.v[..], &state.tau[..], model.nv());
        let a = &lagrange::forward_dynamics(model, q, v, tau)[..];
        let moving = |at: &[f64], rate: &[f64]| -> Vec<D> {
            at.iter().zip(rate).map(|(&value, &rate)| Dual { value, gradient: [rate] }).collect()
        };
        let (q_moving, v_moving) = (moving(q, &lagrange::position_rate(model, q, v)), moving(v, a));
        let a_constant: Vec<D> = a.iter().map(|&a| D::constant(a)).collect();
        let oracle: Vec<f64> = lagrange::inverse_dynamics(model, &q_moving, &v_moving, &a_constant)
            .iter()
            .map(|tau| tau.gradient[0])
            .collect();
        let (mass, speed, push) = (robot.mass(), dot(v, v).sqrt(), dot(a, a).sqrt());
        let force_size = size(&mass) * (speed * speed + push) + model.mass() * 9.81;
        let scale = size(&oracle) + (1.0 + speed) * force_size;
        for w in &mut workspaces::<f64>(model) {
            let set = w.instruction_set();
            let [mut by_q, mut by_v, mut a_by_q, mut a_by_v, mut a_by_tau] =
                [(); 5].map(|()| vec![0.0; nv * nv]);
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives(model, w, q, v, a, out);
            let (from_q, from_v) = (times(&by_q, v), times(&by_v, a));
            let found: Vec<f64> = from_q.iter().zip(&from_v).map(|(x, y)| x + y).collect();
            robot.require(&format!("dτ/dt by {set}"), max_difference(&found, &oracle), ROUNDING * scale);
            let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
                by_position: &mut a_by_q,
                by_velocity: &mut a_by_v,
                by_force: &mut a_by_tau,
            };
            robot_dynamics::derivatives::forward_dynamics_derivatives(model, w, q, v, tau, out);
            // Each derivative of a is M⁻¹ times a derivative of τ, and a is accurate to κ(M) ε: twice κ(M).
            let condition = robot.condition();
            let allowed = 64.0 * f64::EPSILON * condition * condition * (scale + size(&by_q) + size(&by_v));
            let product = |x: &[f64]| -> Vec<f64> {
                let column = |j: usize| (0..nv).map(|i| x[i * nv + j]).collect::<Vec<_>>();
                (0..nv).flat_map(|j| times(&mass, &column(j))).collect()
            };
            let turned = |x: &[f64]| -> Vec<f64> { (0..nv * nv).map(|k| -x[k % nv * nv + k / nv]).collect() };
            let defect = max_difference(&product(&a_by_q), &turned(&by_q));
            robot.require(&format!("M ∂a/∂q = −∂τ/∂q by {set}"), defect, allowed);
            let defect = max_difference(&product(&a_by_v), &turned(&by_v));
            robot.require(&format!("M ∂a/∂v = −∂τ/∂v by {set}"), defect, allowed);
            let mut identity = product(&a_by_tau);
            (0..nv).for_each(|i| identity[i * nv + i] -= 1.0);
            let allowed = 64.0 * f64::EPSILON * condition * nv as f64;
            robot.require(&format!("M ∂a/∂τ = 1 by {set}"), size(&identity), allowed);
        }
    }
}

/// Single precision by every route: 256 roundings of 2⁻²³, times κ(M) where M is inverted.
#[test]
fn one_state_in_single_precision_matches_lagrange() {
    const EPSILON: f64 = f32::EPSILON as f64;
    for robot in robots(14).iter().filter(|robot| robot.condition() < 1e5) {
        let model = &robot.model;
        // The state as f32 represents it, so that only the computation differs.
        let [q, v, a, tau] =
            [&robot.state.q, &robot.state.v, &robot.state.a, &robot.state.tau].map(|x| narrow(x));
        let wide = [&q, &v, &a, &tau].map(|x| widen(x));
        let expected = Expected::compute(model, &wide);
        let nv = model.nv();
        for w in &mut workspaces::<f32>(model) {
            let set = w.instruction_set();
            let (mut mass, mut force, mut motion) = (vec![0.0; nv * nv], vec![0.0; nv], vec![0.0; nv]);
            robot_dynamics::algorithms::mass_matrix(model, w, &q, &mut mass);
            robot_dynamics::algorithms::inverse_dynamics(model, w, &q, &v, &a, &mut force);
            robot_dynamics::algorithms::forward_dynamics(model, w, &q, &v, &tau, &mut motion);
            expected.require(
                robot,
                &format!("f32 by {set}"),
                EPSILON,
                &[&mass, &force, &motion].map(|x| widen(x)),
            );
        }
    }
}

#[allow(clippy::cast_possible_truncation)]
fn narrow(x: &[f64]) -> Vec<f32> {
    x.iter().map(|&x| x as f32).collect()
}

fn widen<T: Copy + Into<f64>>(x: &[T]) -> Vec<f64> {
    x.iter().map(|&x| x.into()).collect()
}

/// The results of the recipe for a state: M, τ and the acceleration, with the sizes for their tolerances.
struct Expected {
    numbers: [Vec<f64>; 3],
    force_size: f64,
    condition: f64,
}

impl Expected {
    fn compute(model: &Model, [q, v, a, tau]: &[Vec<f64>; 4]) -> Self {
        let mass = lagrange::mass_matrix(model, q);
        let eigenvalues =
            nalgebra::DMatrix::from_row_slice(model.nv(), model.nv(), &mass).symmetric_eigenvalues();
        let gravity = size(&lagrange::gravity(model, q)) + model.mass() * 9.81;
        let force_size = size(&mass) * (dot(v, v) + dot(a, a).sqrt()) + gravity + dot(tau, tau).sqrt();
        Self {
            force_size,
            condition: eigenvalues.max() / eigenvalues.min().max(f64::EPSILON * eigenvalues.max()),
            numbers: [
                mass,
                lagrange::inverse_dynamics(model, q, v, a),
                lagrange::forward_dynamics(model, q, v, tau),
            ],
        }
    }

    /// Requires agreement to 256 roundings of `epsilon`, times κ(M) where M is inverted.
    fn require(&self, robot: &Robot, route: &str, epsilon: f64, found: &[Vec<f64>; 3]) {
        let [mass, force, motion] = &self.numbers;
        let mass_size = size(mass);
        robot.require(&format!("M, {route}"), max_difference(&found[0], mass), 256.0 * epsilon * mass_size);
        let allowed = 256.0 * epsilon * self.force_size;
        robot.require(&format!("τ, {route}"), max_difference(&found[1], force), allowed);
        let allowed = 256.0 * epsilon * self.condition * (self.force_size / mass_size + size(motion));
        robot.require(&format!("a, {route}"), max_difference(&found[2], motion), allowed);
    }
}

/// A batch of f64 and one of f32 on each set: 19 states fill every lane of every width, and leave a partial
/// block.
#[test]
fn batches_match_lagrange() {
    const STATES: usize = 19;
    for robot in robots(4).iter().filter(|robot| robot.family != "large") {
        let model = &robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        let mut random = SplitMix64::new(robot.seed ^ 0xba7c);
        let mut tables = [(); 4].map(|()| Vec::new());
        for _ in 0..STATES {
            let state = random_state(model, &mut random);
            // Rounded to f32, so that both batches compute the same states.
            for (table, part) in tables.iter_mut().zip([state.q, state.v, state.a, state.tau]) {
                table.extend(narrow(&part));
            }
        }
        let singles = &tables;
        let doubles = &singles.each_ref().map(|x| widen(x));
        let row = |k: usize, i: usize| {
            let n = if k == 0 { nq } else { nv };
            doubles[k][i * n..(i + 1) * n].to_vec()
        };
        let expected: Vec<Expected> =
            (0..STATES).map(|i| Expected::compute(model, &[0, 1, 2, 3].map(|k| row(k, i)))).collect();
        for set in available() {
            let found = batch_results::<f64>(model, set, doubles);
            for (i, expected) in expected.iter().enumerate() {
                let route = format!("f64, state {i} of a batch by {set}");
                expected.require(robot, &route, f64::EPSILON, &found.each_ref().map(|x| part(x, STATES, i)));
            }
            let found = batch_results::<f32>(model, set, singles);
            for (i, expected) in expected.iter().enumerate().filter(|(_, expected)| expected.condition < 1e5)
            {
                let route = format!("f32, state {i} of a batch by {set}");
                let found = found.each_ref().map(|x| part(x, STATES, i));
                expected.require(robot, &route, f64::from(f32::EPSILON), &found);
            }
        }
    }
}

/// The numbers of state `i` of `states`.
fn part(table: &[f64], states: usize, i: usize) -> Vec<f64> {
    let width = table.len() / states;
    table[i * width..(i + 1) * width].to_vec()
}

/// M, τ and a of a batch.
fn batch_results<T: BatchFloat + Into<f64>>(
    model: &Model,
    set: InstructionSet,
    [q, v, a, tau]: &[Vec<T>; 4],
) -> [Vec<f64>; 3] {
    let w = &mut batch_workspace::<T>(model, set, 1);
    let count = v.len() / model.nv();
    let mut out = [(); 3].map(|()| vec![T::zero(); v.len()]);
    out[0] = vec![T::zero(); count * model.nv() * model.nv()];
    batch::mass_matrix(model, w, q, &mut out[0]).unwrap();
    batch::inverse_dynamics(model, w, q, v, a, &mut out[1]).unwrap();
    // In f32 a badly conditioned M may be singular; those results are not compared.
    let solved = batch::forward_dynamics(model, w, q, v, tau, &mut out[2]);
    assert!(solved.is_ok() || size_of::<T>() < 8, "{solved:?}");
    out.each_ref().map(|x| widen(x))
}

/// Rollouts on each set match single steps, to 1e-12 of the largest number of the state at κ(M) below 1e4.
#[test]
fn rollouts_match_single_steps() {
    const STATES: usize = 11;
    for robot in robots(3).iter().filter(|robot| robot.condition() < 1e4) {
        let model = &robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        let mut random = SplitMix64::new(robot.seed ^ 0x7011);
        let (mut q, mut v, mut tau) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..STATES {
            let state = random_state(model, &mut random);
            q.extend(state.q);
            v.extend(state.v);
            tau.extend(state.tau);
        }
        for integrator in Integrator::ALL.into_iter().filter(|row| row.is_explicit()) {
            let (mut q_expected, mut v_expected) = (q.clone(), v.clone());
            let single = &mut StepWorkspace::new(model);
            for i in 0..STATES {
                let (q, v) = (&mut q_expected[i * nq..(i + 1) * nq], &mut v_expected[i * nv..(i + 1) * nv]);
                let forces = StepForces::new(&tau[i * nv..(i + 1) * nv], true);
                (0..20).for_each(|_| step(model, integrator, single, &forces, 1e-4, q, v).unwrap());
            }
            let how = Rollout::new(integrator, 1e-4, 20);
            for set in available() {
                let w = &mut batch_workspace::<f64>(model, set, 1);
                let (mut q_found, mut v_found) = (q.clone(), v.clone());
                batch::rollout(
                    model,
                    w,
                    &how,
                    Torques::Held(&tau),
                    batch::RolloutStates::ends(&mut q_found, &mut v_found),
                    None,
                )
                .unwrap();
                let law = format!("{integrator} by {set}");
                let defect = max_difference(&q_found, &q_expected);
                robot.require(&format!("q of {law}"), defect, 1e-12 * size(&q_expected).max(1.0));
                let defect = max_difference(&v_found, &v_expected);
                robot.require(&format!("v of {law}"), defect, 1e-12 * size(&v_expected).max(1.0));
            }
        }
    }
}

/// On each set the results are equal bit for bit for any threads and any place in the batch. Those of AVX2
/// and AVX-512 are equal.
#[test]
fn results_on_a_set_are_equal_bit_for_bit() {
    const STATES: usize = 100;
    let options = RandomRobotOptions {
        base: robot_dynamics::description::Base::Floating,
        joints: 6,
        ..Default::default()
    };
    let model = &Model::new(random_robot(8, &options)).unwrap();
    let (nq, nv) = (model.nq(), model.nv());
    let mut random = SplitMix64::new(8);
    let (mut q, mut v, mut tau) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..STATES {
        let state = random_state(model, &mut random);
        q.extend(state.q);
        v.extend(state.v);
        tau.extend(state.tau);
    }
    let compute = |set, threads, first: usize| -> Vec<u64> {
        let w = &mut batch_workspace::<f64>(model, set, threads);
        let (q, v, tau) = (&q[first * nq..], &v[first * nv..], &tau[first * nv..]);
        let mut a = vec![0.0; v.len()];
        batch::forward_dynamics(model, w, q, v, tau, &mut a).unwrap();
        a.into_iter().map(f64::to_bits).collect()
    };
    let mut fused: Option<Vec<u64>> = None;
    for set in available() {
        let whole = compute(set, 1, 0);
        for (threads, first) in [(1, 3), (2, 0), (3, 7)] {
            let part = compute(set, threads, first);
            assert!(part == whole[first * nv..], "{set}: {threads} threads, from state {first}");
        }
        if set != InstructionSet::Portable {
            assert!(fused.get_or_insert_with(|| whole.clone()) == &whole, "{set} differs from AVX2");
        }
    }
}

/// Derivatives of a single state are equal bit for bit with and without AVX-512.
#[test]
fn derivatives_are_equal_bit_for_bit_without_avx512() {
    if !InstructionSet::Avx512.is_available() {
        return;
    }
    for robot in robots(6) {
        let Robot { model, state, .. } = &robot;
        let (q, v, a, tau, nv) = (&state.q[..], &state.v[..], &state.a[..], &state.tau[..], model.nv());
        let compute = |mut w: Workspace| -> Vec<u64> {
            let [mut by_q, mut by_v, mut a_by_q, mut a_by_v, mut a_by_tau] =
                [(); 5].map(|()| vec![0.0; nv * nv]);
            let out = robot_dynamics::derivatives::InverseDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
            };
            robot_dynamics::derivatives::inverse_dynamics_derivatives(model, &mut w, q, v, a, out);
            let (x, y, z) = (&mut a_by_q, &mut a_by_v, &mut a_by_tau);
            let out = robot_dynamics::derivatives::ForwardDynamicsDerivativesMut {
                by_position: x,
                by_velocity: y,
                by_force: z,
            };
            robot_dynamics::derivatives::forward_dynamics_derivatives(model, &mut w, q, v, tau, out);
            [by_q, by_v, a_by_q, a_by_v, a_by_tau].concat().into_iter().map(f64::to_bits).collect()
        };
        let same = compute(Workspace::new(model)) == compute(Workspace::limited(model, InstructionSet::Avx2));
        assert!(same, "family \"{}\", seed {}", robot.family, robot.seed);
    }
}
