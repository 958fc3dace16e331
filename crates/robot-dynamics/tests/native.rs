//! Machine code gives the numbers of the recursions to rounding and refuses the same inputs. The report names
//! the route.
#![cfg(all(feature = "native", feature = "batch"))]
#![allow(missing_docs)]

use std::path::PathBuf;

use robot_dynamics::algorithms::{
    ReferenceFrame, bias, center_of_mass, center_of_mass_jacobian, centroidal_momentum_matrix,
    coriolis_matrix, forward_dynamics, frame_jacobian, frame_pose, frame_poses, gravity, inverse_dynamics,
    inverse_mass_matrix, kinetic_energy, mass_matrix, mass_matrix_factor, momentum, potential_energy,
    velocity_product,
};
use robot_dynamics::batch::{self, BatchFloat, BatchOptions, BatchWorkspace, Rollout, Torques};
use robot_dynamics::derivatives::{
    ForwardPullbackInputs, ForwardPullbackMut, InversePullbackInputs, InversePullbackMut,
    LinearizeStepWorkspace, LinearizedStep, MotionCotangents, RobotState, StepPullbackWorkspace,
    forward_dynamics_pullback, forward_dynamics_pullback_with_parameters, gravity_derivative,
    inverse_dynamics_pullback, inverse_dynamics_pullback_with_parameters, linearize_step, parameter_count,
    step_pullback,
};
use robot_dynamics::description::{
    Base, FrameDescription, JointKinds, Pose, RandomRobotOptions, random_robot,
};
use robot_dynamics::model::{FrameId, InstructionSet, Model, RandomState, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Integrator, StepForces};
use robot_dynamics::{load, with_native_code};

/// All results of a state, and, if M is regular, those that need its inverse.
struct Results {
    plain: Vec<Vec<f64>>,
    inverting: Vec<Vec<f64>>,
}

fn compute(model: &Model, RandomState { q, v, a, tau }: &RandomState) -> Results {
    let (w, nv) = (&mut Workspace::new(model), model.nv());
    let (vector, matrix) = (vec![0.0; nv], vec![0.0; nv * nv]);
    let mut plain: Vec<Vec<f64>> = vec![vector.clone(); 5];
    inverse_dynamics(model, w, q, v, a, &mut plain[0]);
    bias(model, w, q, v, &mut plain[1]);
    gravity(model, w, q, &mut plain[2]);
    velocity_product(model, w, q, v, &mut plain[3]);
    momentum(model, w, q, v, &mut plain[4]);
    plain.extend([matrix.clone(), matrix.clone()]);
    mass_matrix(model, w, q, &mut plain[5]);
    coriolis_matrix(model, w, q, v, &mut plain[6]);
    plain.push(vec![kinetic_energy(model, w, q, v)]);
    plain.push(vec![potential_energy(model, w, q)]);
    let [mut x, mut y, mut z] = [(); 3].map(|()| vector.clone());
    let out = InversePullbackMut {
        by_position: &mut x,
        by_velocity: &mut y,
        by_acceleration: &mut z,
        parameters: &mut [],
    };
    inverse_dynamics_pullback(model, w, q, v, a, tau, out);
    plain.extend([x, y, z, vec![0.0; 6 * nv], matrix.clone()]);
    centroidal_momentum_matrix(model, w, q, &mut plain[12]);
    gravity_derivative(model, w, q, &mut plain[13]);
    let mut inverting = vec![vector, matrix.clone(), matrix];
    forward_dynamics(model, w, q, v, tau, &mut inverting[0]);
    inverse_mass_matrix(model, w, q, &mut inverting[1]);
    mass_matrix_factor(model, w, q, &mut inverting[2]);
    Results { plain, inverting }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(f64::MIN_POSITIVE, |largest, x| largest.max(x.abs()))
}

/// The largest difference, relative to the largest number or to this scale.
fn difference(one: &[f64], other: &[f64], scale: f64) -> f64 {
    let scale = largest(one).max(largest(other)).max(scale);
    one.iter().zip(other).fold(0.0, |most: f64, (x, y)| most.max((x - y).abs())) / scale
}

/// The ratio of the largest to the smallest eigenvalue of M.
fn condition_number(model: &Model, q: &[f64]) -> f64 {
    let eigenvalues = model.mass_matrix(q).expect("a valid state").symmetric_eigenvalues();
    eigenvalues.max() / eigenvalues.min().abs()
}

fn robots() -> Vec<(String, Model)> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots"));
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the robots' folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|kind| kind == "urdf" || kind == "xml"))
        .collect();
    files.sort();
    files
        .into_iter()
        .filter_map(|file| Some((file.display().to_string(), load(file).ok()?.model)))
        .filter(|(_, model)| model.nv() > 0)
        .collect()
}

fn random_robots() -> Vec<(String, Model)> {
    let of_seed = |seed| {
        let base = if seed % 3 == 0 { Base::Floating } else { Base::Fixed };
        let kinds = if seed % 4 == 1 { JointKinds::VectorSpace } else { JointKinds::All };
        let joints = 1 + usize::try_from(7 * seed % 40).expect("a few joints");
        let options = RandomRobotOptions { joints, base, kinds, ..Default::default() };
        let model = Model::new(random_robot(seed, &options)).expect("a random robot");
        (format!("random robot {seed}"), with_native_code(model))
    };
    (0..60).map(of_seed).collect()
}

/// An operation rounds by ε/2 of its result. Sums of about a hundred terms along the tree cancel to a
/// hundredth of them.
const PLAIN: f64 = 2e-12;

/// M⁻¹ has κ(M) times the relative error of M.
const INVERTING: f64 = 1e-13;

#[test]
fn machine_code_has_the_numbers_of_the_recursions() {
    let mut compiled = 0;
    for (name, model) in robots().into_iter().chain(random_robots()) {
        let plain = model.clone().with_native(false);
        let mut random = SplitMix64::new(7);
        for _ in 0..3 {
            let state = random_state(&model, &mut random);
            let (found, expected) = (compute(&model, &state), compute(&plain, &state));
            // C v can be a difference of forces that cancel, and C a difference of rates of M.
            let (force, rate) =
                (largest(&expected.plain[0]), largest(&expected.plain[5]) * largest(&state.v));
            // The same holds for sums of such forces, weighted by a cotangent.
            let weight = largest(&state.tau);
            let (by_q, by_v) = (weight * force, weight * rate);
            for (index, (found, expected)) in found.plain.iter().zip(&expected.plain).enumerate() {
                let scale =
                    [0.0, 0.0, 0.0, force, 0.0, 0.0, rate, 0.0, force, by_q, by_v, 0.0, 0.0, force][index];
                let off = difference(found, expected, scale);
                assert!(off < PLAIN, "{name}, function {index}: {off:e}");
            }
            let condition = condition_number(&plain, &state.q);
            // Singular to rounding: no digit is significant.
            if condition > 1e12 {
                continue;
            }
            for (index, (found, expected)) in found.inverting.iter().zip(&expected.inverting).enumerate() {
                let off = difference(found, expected, 0.0);
                assert!(
                    off < INVERTING * condition.max(1e2),
                    "{name}, inverting {index}: {off:e} of {condition:e}"
                );
            }
        }
        let report = model.native();
        assert!(plain.native().reason.is_some());
        compiled += report.functions.iter().filter(|used| used.route.is_ok()).count();
    }
    assert!(compiled > 500 || !has_encoder(), "{compiled}");
}

/// Whether there is machine code for this processor.
fn has_encoder() -> bool {
    pendulum().native().reason.is_none()
}

fn pendulum() -> Model {
    with_native_code(Model::new(robot_dynamics::description::pendulum(2.0, 0.5)).expect("a pendulum"))
}

/// States of a robot, one after the other: q, v, a, τ.
fn states(model: &Model, count: usize) -> [Vec<f64>; 4] {
    let mut random = SplitMix64::new(11);
    let mut tables = [const { Vec::new() }; 4];
    for _ in 0..count {
        let RandomState { q, v, a, tau } = random_state(model, &mut random);
        tables.iter_mut().zip([q, v, a, tau]).for_each(|(table, row)| table.extend(row));
    }
    tables
}

/// The tables of [`compute_batches`] that need M⁻¹; their rounding is proportional to its condition number.
const INVERTING_TABLES: [usize; 5] = [2, 10, 11, 12, 13];

/// Forces, accelerations, M and its structurally nonzero entries, ∂τ, λᵀ∂τ, a and λᵀ∂a of each state.
fn compute_batches<T: BatchFloat>(model: &Model, tables: &[Vec<T>; 4], options: BatchOptions) -> Vec<Vec<T>> {
    let [q, v, a, tau] = tables;
    let (nv, count) = (model.nv(), q.len() / model.nq());
    let w = &mut BatchWorkspace::<T>::with_options(model, options).expect("threads");
    let zeros = |width: usize| vec![T::zero(); count * width];
    let related = batch::mass_matrix_related_entries(model).len();
    let mut results = vec![zeros(nv), zeros(nv), zeros(nv), zeros(nv * nv), zeros(related)];
    let [forces, weights, accelerations, mass, entries] = &mut results[..] else { unreachable!("five") };
    batch::inverse_dynamics(model, w, q, v, a, forces).expect("good states");
    batch::gravity(model, w, q, weights).expect("good states");
    batch::forward_dynamics(model, w, q, v, tau, accelerations).expect("good states");
    batch::mass_matrix(model, w, q, mass).expect("good states");
    batch::mass_matrix_related(model, w, q, entries).expect("good states");
    let (mut by_q, mut by_v) = (zeros(nv * nv), zeros(nv * nv));
    let out = batch::InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
    batch::inverse_dynamics_derivatives(model, w, q, v, a, out).expect("good states");
    results.extend([by_q, by_v]);
    let [mut x, mut y, mut z] = [(); 3].map(|()| zeros(nv));
    let out = batch::InversePullbackMut {
        by_position: &mut x,
        by_velocity: &mut y,
        by_acceleration: &mut z,
        parameters: &mut [],
    };
    let done = batch::inverse_dynamics_pullback(model, w, q, v, a, tau, out);
    done.expect("good states");
    results.extend([x, y, z]);
    let [mut r, mut x, mut y, mut z] = [(); 4].map(|()| zeros(nv));
    let out = batch::ForwardPullbackMut {
        acceleration: &mut r,
        by_position: &mut x,
        by_velocity: &mut y,
        by_force: &mut z,
        parameters: &mut [],
    };
    let done = batch::forward_dynamics_pullback(model, w, q, v, tau, a, out);
    done.expect("good states");
    results.extend([r, x, y, z]);
    results
}

#[test]
fn batches_have_the_bits_of_single_calls_whatever_the_threads() {
    for (name, model) in robots().into_iter().chain(random_robots().into_iter().step_by(7)) {
        // Not a multiple of any register width.
        let count = 301;
        let tables = states(&model, count);
        let (mut one, mut two) = (BatchOptions::default(), BatchOptions::default());
        (one.threads, two.threads) = (1, 2);
        let found = compute_batches(&model, &tables, one);
        assert_eq!(found, compute_batches(&model, &tables, two), "{name}");
        let plain = compute_batches(&model.clone().with_native(false), &tables, one);
        let tables_of_forces = found.iter().zip(&plain).enumerate();
        for (index, (found, plain)) in tables_of_forces.filter(|(k, _)| !INVERTING_TABLES.contains(k)) {
            let off = difference(found, plain, 0.0);
            assert!(off < PLAIN, "{name}, table {index}: {off:e}");
        }
        let (w, nv) = (&mut Workspace::new(&model), model.nv());
        let (mut tau, mut mass) = (vec![0.0; nv], vec![0.0; nv * nv]);
        let first = (&tables[0][..model.nq()], &tables[1][..nv], &tables[2][..nv]);
        inverse_dynamics(&model, w, first.0, first.1, first.2, &mut tau);
        mass_matrix(&model, w, first.0, &mut mass);
        // Whether machine code computes both one state and batches.
        let report = model.native();
        let is_compiled = |function: &str| {
            let is_it = |used: &&robot_dynamics::model::NativeUse| {
                used.function.name() == function && used.number == "f64" && used.route.is_ok()
            };
            report.functions.iter().filter(is_it).count() == 2
        };
        for state in 0..count {
            let row = |table: &[f64], width: usize| table[state * width..(state + 1) * width].to_vec();
            let (q, v, a) = (row(&tables[0], model.nq()), row(&tables[1], nv), row(&tables[2], nv));
            inverse_dynamics(&model, w, &q, &v, &a, &mut tau);
            mass_matrix(&model, w, &q, &mut mass);
            assert!(!is_compiled("inverse_dynamics") || row(&found[0], nv) == tau, "{name}, state {state}");
            assert!(!is_compiled("mass_matrix") || row(&found[3], nv * nv) == mass, "{name}, state {state}");
            let torque = row(&tables[3], nv);
            let [mut r, mut x, mut y, mut z] = [(); 4].map(|()| vec![0.0; nv]);
            if is_compiled("inverse_dynamics_pullback") || state == 0 {
                let out = InversePullbackMut {
                    by_position: &mut x,
                    by_velocity: &mut y,
                    by_acceleration: &mut z,
                    parameters: &mut [],
                };
                inverse_dynamics_pullback(&model, w, &q, &v, &a, &torque, out);
            }
            let rows = [7, 8, 9].map(|table| row(&found[table], nv));
            let is_same = [&x, &y, &z].into_iter().eq(&rows);
            assert!(!is_compiled("inverse_dynamics_pullback") || is_same, "{name}, state {state}");
            if is_compiled("forward_dynamics_pullback") || state == 0 {
                let out = ForwardPullbackMut {
                    acceleration: &mut r,
                    by_position: &mut x,
                    by_velocity: &mut y,
                    by_force: &mut z,
                    parameters: &mut [],
                };
                forward_dynamics_pullback(&model, w, &q, &v, &torque, &a, out);
            }
            let rows = [10, 11, 12, 13].map(|table| row(&found[table], nv));
            let is_same = [&r, &x, &y, &z].into_iter().eq(&rows);
            assert!(!is_compiled("forward_dynamics_pullback") || is_same, "{name}, state {state}");
        }
    }
}

/// f32 has 24 bits; the sums are the same as above.
#[test]
fn single_precision_has_the_numbers_of_double_precision_to_its_rounding() {
    for (name, model) in robots() {
        let tables = states(&model, 40);
        #[allow(clippy::cast_possible_truncation)]
        let short = tables.clone().map(|table| table.into_iter().map(|x| x as f32).collect::<Vec<_>>());
        // The states after rounding to f32.
        let tables = short.clone().map(|table| table.into_iter().map(f64::from).collect::<Vec<_>>());
        let (found, expected) = (
            compute_batches(&model, &short, BatchOptions::default()),
            compute_batches(&model.clone().with_native(false), &tables, BatchOptions::default()),
        );
        let tables_of_forces = found.iter().zip(&expected).enumerate();
        for (index, (found, expected)) in tables_of_forces.filter(|(k, _)| !INVERTING_TABLES.contains(k)) {
            let found: Vec<f64> = found.iter().copied().map(f64::from).collect();
            let off = difference(&found, expected, 0.0);
            assert!(off < 2e-4, "{name}, table {index}: {off:e}");
        }
    }
}

#[test]
fn bad_states_and_far_angles_are_told_and_computed_as_by_the_recursions() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let model = load(folder).expect("a robot").model;
    let plain = model.clone().with_native(false);
    let (nv, count) = (model.nv(), 200);
    let [mut q, v, a, _] = states(&model, count);
    // The angle of the first joint does not affect the torques, but NaN is refused.
    q[17 * nv] = f64::NAN;
    q[40 * nv + 3] = f64::INFINITY;
    // Beyond the range of the sine of the machine code.
    q[101 * nv + 2] = 3e5;
    let compute = |model: &Model| {
        let (mut tau, w) = (vec![0.0; count * nv], &mut BatchWorkspace::new(model));
        let bad = batch::inverse_dynamics(model, w, &q, &v, &a, &mut tau).expect_err("bad states");
        (tau, bad)
    };
    let ((found, bad), (expected, as_before)) = (compute(&model), compute(&plain));
    assert_eq!(bad, as_before);
    assert_eq!(bad.states, [17, 40]);
    assert!(found[17 * nv..18 * nv].iter().chain(&found[40 * nv..41 * nv]).all(|x| x.is_nan()));
    let far = 101 * nv..102 * nv;
    assert_eq!(found[far.clone()], expected[far.clone()]);
    let mut tau = vec![0.0; nv];
    inverse_dynamics(
        &model,
        &mut Workspace::new(&model),
        &q[far.clone()],
        &v[far.clone()],
        &a[far.clone()],
        &mut tau,
    );
    assert!(difference(&tau, &expected[far], 0.0) < PLAIN);
}

#[test]
fn pullbacks_of_bad_states_and_far_angles_are_those_of_the_recursions() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let model = load(folder).expect("a robot").model;
    let plain = model.clone().with_native(false);
    let (nv, count) = (model.nv(), 200);
    let [mut q, v, a, mut cotangent] = states(&model, count);
    q[17 * nv] = f64::NAN;
    cotangent[40 * nv + 3] = f64::INFINITY;
    // Beyond the range of the sine of the machine code.
    q[101 * nv + 2] = 3e5;
    let far = 101 * nv..102 * nv;
    let of_batches = |model: &Model, is_forward: bool| {
        let w = &mut BatchWorkspace::new(model);
        let [mut r, mut x, mut y, mut z] = [(); 4].map(|()| vec![0.0; count * nv]);
        let l = &cotangent;
        let bad = if is_forward {
            let out = batch::ForwardPullbackMut {
                acceleration: &mut r,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: &mut [],
            };
            batch::forward_dynamics_pullback(model, w, &q, &v, &a, l, out)
        } else {
            let out = batch::InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: &mut [],
            };
            batch::inverse_dynamics_pullback(model, w, &q, &v, &a, l, out)
        };
        (bad.expect_err("bad states"), [x, y, z, r])
    };
    let of_one = |model: &Model, is_forward: bool| {
        let w = &mut Workspace::new(model);
        let [mut r, mut x, mut y, mut z] = [(); 4].map(|()| vec![0.0; nv]);
        let (q, v, a, l) = (&q[far.clone()], &v[far.clone()], &a[far.clone()], &cotangent[far.clone()]);
        if is_forward {
            let out = ForwardPullbackMut {
                acceleration: &mut r,
                by_position: &mut x,
                by_velocity: &mut y,
                by_force: &mut z,
                parameters: &mut [],
            };
            forward_dynamics_pullback(model, w, q, v, a, l, out);
        } else {
            let out = InversePullbackMut {
                by_position: &mut x,
                by_velocity: &mut y,
                by_acceleration: &mut z,
                parameters: &mut [],
            };
            inverse_dynamics_pullback(model, w, q, v, a, l, out);
        }
        [x, y, z, r]
    };
    for is_forward in [false, true] {
        let ((bad, found), (as_before, expected)) =
            (of_batches(&model, is_forward), of_batches(&plain, is_forward));
        assert_eq!(bad, as_before);
        assert_eq!(bad.states, [17, 40]);
        for (found, expected) in found.iter().zip(&expected).take(if is_forward { 4 } else { 3 }) {
            assert!(found[17 * nv..18 * nv].iter().chain(&found[40 * nv..41 * nv]).all(|x| x.is_nan()));
            assert_eq!(found[far.clone()], expected[far.clone()]);
        }
        assert_eq!(of_one(&model, is_forward), of_one(&plain, is_forward));
    }
}

/// The cotangents of parameters, and all other results, are those of the recursions.
#[test]
fn pullbacks_with_parameters_have_the_bits_of_the_recursions() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let model = load(folder).expect("a robot").model;
    let plain = model.clone().with_native(false);
    let (nv, RandomState { q, v, a, tau }) = (model.nv(), random_state(&model, &mut SplitMix64::new(5)));
    let compute = |model: &Model| {
        let [mut r, mut x, mut y, mut z] = [(); 4].map(|()| vec![0.0; nv]);
        let [mut of_inverse, mut of_forward] = [(); 2].map(|()| vec![0.0; parameter_count(model)]);
        let w = &mut Workspace::new(model);
        let out = InversePullbackMut {
            by_position: &mut x,
            by_velocity: &mut y,
            by_acceleration: &mut z,
            parameters: &mut of_inverse,
        };
        inverse_dynamics_pullback_with_parameters(
            model,
            w,
            InversePullbackInputs { q: &q, v: &v, a: &a, wrenches: &[], cotangent: &tau },
            out,
        );
        let mut results = vec![x.clone(), y.clone(), z.clone(), of_inverse];
        let out = ForwardPullbackMut {
            acceleration: &mut r,
            by_position: &mut x,
            by_velocity: &mut y,
            by_force: &mut z,
            parameters: &mut of_forward,
        };
        forward_dynamics_pullback_with_parameters(
            model,
            w,
            ForwardPullbackInputs { q: &q, v: &v, tau: &tau, wrenches: &[], cotangent: &a },
            out,
        );
        results.extend([r, x, y, z, of_forward]);
        results
    };
    assert_eq!(compute(&model), compute(&plain));
}

#[test]
fn rollouts_by_one_kernel_a_step_are_those_of_the_recursions() {
    let mut compared = 0;
    for (name, model) in robots().into_iter().chain(random_robots().into_iter().step_by(9)) {
        let count = 45;
        let [q, v, _, tau] = states(&model, count);
        for (integrator, dissipation) in [
            (Integrator::SemiImplicitEuler, true),
            (Integrator::SemiImplicitEuler, false),
            (Integrator::RungeKutta4, true),
            (Integrator::RungeKutta4, false),
            (Integrator::ExplicitEuler, true),
        ] {
            let how = Rollout::new(integrator, 1e-5, 20).with_dissipation(dissipation).with_stride(10);
            let run = |model: &Model| {
                let (mut q, mut v) = (q.clone(), v.clone());
                let mut samples = (vec![0.0; 2 * q.len()], vec![0.0; 2 * v.len()]);
                let (w, torques) = (&mut BatchWorkspace::new(model), Torques::Held(&tau));
                let trajectory = (&mut samples.0[..], &mut samples.1[..]);
                let states = batch::RolloutStates {
                    q: &mut q,
                    v: &mut v,
                    q_trajectory: trajectory.0,
                    v_trajectory: trajectory.1,
                };
                let ended = batch::rollout(model, w, &how, torques, states, None);
                ended.map(|()| [q, v, samples.0, samples.1])
            };
            let (Ok(found), Ok(expected)) = (run(&model), run(&model.clone().with_native(false))) else {
                continue;
            };
            compared += 1;
            // M⁻¹ has κ(M) times the error of M. Over this short time the error does not grow.
            let condition = condition_number(&model, &q[..model.nq()]).max(1e4);
            for (found, expected) in found.iter().zip(&expected) {
                let off = difference(found, expected, 0.0);
                assert!(off < 1e-14 * condition, "{name}, {integrator}: {off:e} of {condition:e}");
            }
        }
    }
    assert!(compared > 60, "{compared}");
}

/// Algorithms that call forward and inverse dynamics do not depend on values that the recursions leave in the
/// workspace.
#[test]
fn derivatives_and_pullbacks_are_those_of_the_recursions() {
    for (name, model) in robots().into_iter().chain(random_robots()) {
        let plain = model.clone().with_native(false);
        let (nv, state) = (model.nv(), random_state(&model, &mut SplitMix64::new(3)));
        let RandomState { q, v, a, tau } = &state;
        let condition = condition_number(&plain, q);
        if condition > 1e8 {
            continue;
        }
        let compute = |model: &Model| {
            let (w, zeros) = (&mut Workspace::new(model), || vec![0.0; nv]);
            let (mut one, mut two, mut three, mut four) = (zeros(), zeros(), zeros(), zeros());
            let out = ForwardPullbackMut {
                acceleration: &mut one,
                by_position: &mut two,
                by_velocity: &mut three,
                by_force: &mut four,
                parameters: &mut [],
            };
            forward_dynamics_pullback(model, w, q, v, tau, a, out);
            let mut results = vec![one, two, three, four];
            let step = &mut LinearizeStepWorkspace::new(model);
            let (mut by_state, mut by_force) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
            let (row, forces) = (Integrator::RungeKutta4, StepForces::new(tau, true));
            let out = LinearizedStep { by_state: &mut by_state, by_force: &mut by_force };
            linearize_step(model, row, step, &forces, 1e-4, RobotState { q, v }, out).expect("M is regular");
            results.extend([by_state, by_force]);
            let (mut by_q, mut by_v, mut by_tau) = (a.clone(), v.clone(), zeros());
            let step = &mut StepPullbackWorkspace::new(model);
            let cotangents = MotionCotangents {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
                parameters: &mut [],
            };
            step_pullback(model, row, step, &forces, 1e-4, RobotState { q, v }, cotangents)
                .expect("M is regular");
            results.extend([by_q, by_v, by_tau]);
            results
        };
        let expected = compute(&plain);
        // λᵀ∂a/∂q and λᵀ∂a/∂v can be differences of forces and rates that cancel.
        let (w, mut mass) = (&mut Workspace::new(&plain), vec![0.0; nv * nv]);
        mass_matrix(&plain, w, q, &mut mass);
        let weight = largest(&expected[3]);
        let by_position = weight * largest(tau);
        let by_velocity = weight * largest(&mass) * largest(v);
        for (index, (found, expected)) in compute(&model).iter().zip(&expected).enumerate() {
            let scale = [0.0, by_position, by_velocity].get(index).copied().unwrap_or_default();
            let off = difference(found, expected, scale);
            // M⁻¹ is applied twice.
            assert!(
                off < INVERTING * (condition * condition).max(1e3),
                "{name}, result {index}: {off:e} of {condition:e}"
            );
        }
    }
}

/// Gradients of rollouts: cotangents of the ends give those of the starts and forces.
fn pull_rollouts_back(
    model: &Model,
    how: &Rollout,
    torques: Torques<'_, f64>,
    [q, v, by_q, by_v]: [&[f64]; 4],
    forces: usize,
) -> (Result<(), batch::RolloutError>, [Vec<f64>; 3]) {
    let w = &mut BatchWorkspace::new(model);
    let (mut by_q, mut by_v, mut by_force) = (by_q.to_vec(), by_v.to_vec(), vec![0.0; forces]);
    let ends = (&mut by_q[..], &mut by_v[..]);
    // The same cotangent for each intermediate state.
    let row: Vec<f64> = (0..model.nv()).map(|k| 0.3 - 0.1 * k as f64).collect();
    let trajectory = row.repeat(v.len() / model.nv() * how.samples());
    let trajectory = (&trajectory[..], &trajectory[..]);
    let inputs = batch::RolloutPullbackInputs {
        spacing: 3,
        torques,
        q,
        v,
        trajectory: batch::TrajectoryCotangents { by_position: trajectory.0, by_velocity: trajectory.1 },
    };
    let cotangents = batch::MotionCotangents {
        by_position: ends.0,
        by_velocity: ends.1,
        by_force: &mut by_force,
        parameters: &mut [],
    };
    let done = batch::rollout_pullback(model, w, how, &inputs, cotangents, None);
    (done, [by_q, by_v, by_force])
}

#[test]
fn pullbacks_of_rollouts_by_a_kernel_a_step_are_those_of_the_recursions() {
    let mut compiled = 0;
    for (name, model) in robots().into_iter().chain(random_robots().into_iter().step_by(9)) {
        let (count, nv, plain) = (37, model.nv(), model.clone().with_native(false));
        let [q, v, a, tau] = states(&model, count);
        let condition = condition_number(&plain, &q[..model.nq()]).max(1e4);
        if condition > 1e8 {
            continue;
        }
        for (integrator, dissipation) in [
            (Integrator::SemiImplicitEuler, true),
            (Integrator::SemiImplicitEuler, false),
            (Integrator::RungeKutta4, true),
            (Integrator::RungeKutta4, false),
            (Integrator::ExplicitEuler, true),
        ] {
            let how = Rollout::new(integrator, 1e-5, 8).with_dissipation(dissipation).with_stride(2);
            let each = tau.repeat(8);
            let (held, each) = (Torques::Held(&tau), Torques::EachStep(&each));
            for (torques, forces) in [(held, count * nv), (each, 8 * count * nv), (Torques::Zero, 0)] {
                let ends = [&q[..], &v, &a, &tau];
                let (done, found) = pull_rollouts_back(&model, &how, torques, ends, forces);
                let (as_before, expected) = pull_rollouts_back(&plain, &how, torques, ends, forces);
                assert_eq!(done, as_before, "{name}, {integrator}");
                if done.is_err() {
                    continue;
                }
                for (found, expected) in found.iter().zip(&expected) {
                    let off = difference(found, expected, 0.0);
                    assert!(off < 1e-14 * condition, "{name}, {integrator}: {off:e} of {condition:e}");
                }
                // The bits of a state do not depend on the other states of the batch.
                let first = [&q[..model.nq()], &v[..nv], &a[..nv], &tau[..nv]];
                if let Torques::Held(_) = torques {
                    let alone = Torques::Held(&tau[..nv]);
                    let (_, alone) = pull_rollouts_back(&model, &how, alone, first, nv);
                    assert!(alone.iter().zip(&found).all(|(alone, all)| *alone == all[..nv]), "{name}");
                }
            }
        }
        let report = model.native();
        compiled +=
            report.functions.iter().filter(|used| used.function.name().contains("step_pullback")).count();
    }
    assert!(compiled > 30 || !has_encoder(), "{compiled}");
}

/// A rollout of one step, of a batch and of one state, if machine code computes both.
#[test]
fn the_pullback_of_a_step_has_the_bits_of_a_rollout_of_one() {
    for file in ["panda.urdf", "humanoid.urdf", "gripper.urdf"] {
        let model =
            load(format!("{}/../../robots/{file}", env!("CARGO_MANIFEST_DIR"))).expect("a robot").model;
        let (nq, nv) = (model.nq(), model.nv());
        let [q, v, a, tau] = states(&model, 20);
        for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            let how = Rollout::new(integrator, 1e-3, 1);
            let ends = [&q[..], &v, &a, &v];
            let (done, found) = pull_rollouts_back(&model, &how, Torques::Held(&tau), ends, 20 * nv);
            done.expect("good states");
            let w = &mut StepPullbackWorkspace::new(&model);
            for state in 0..20 {
                let rows = state * nv..(state + 1) * nv;
                let forces = StepForces::new(&tau[rows.clone()], true);
                let (q, own_v) = (&q[state * nq..(state + 1) * nq], &v[rows.clone()]);
                let (mut by_q, mut by_v, mut by_tau) =
                    (a[rows.clone()].to_vec(), own_v.to_vec(), vec![0.0; nv]);
                let cotangents = MotionCotangents {
                    by_position: &mut by_q,
                    by_velocity: &mut by_v,
                    by_force: &mut by_tau,
                    parameters: &mut [],
                };
                step_pullback(&model, integrator, w, &forces, 1e-3, RobotState { q, v: own_v }, cotangents)
                    .expect("a good state");
                let report = model.native();
                let is_step = |used: &&robot_dynamics::model::NativeUse| {
                    used.function.name() == format!("{}_step_pullback", name_of(integrator))
                        && used.route.is_ok()
                };
                if report.functions.iter().filter(is_step).count() == 2 {
                    let of_one = [by_q, by_v, by_tau];
                    assert!(of_one.iter().zip(&found).all(|(one, all)| *one == all[rows.clone()]), "{file}");
                }
            }
        }
    }
}

/// At rest in the neutral configuration a step rotates no joint, so the angle of its rotation is zero.
#[test]
fn pullbacks_from_rest_are_those_of_the_recursions() {
    for (name, model) in random_robots() {
        let (nv, plain) = (model.nv(), model.clone().with_native(false));
        let (q, rest) = (robot_dynamics::model::neutral(&model), vec![0.0; nv]);
        let condition = condition_number(&plain, &q).max(1e4);
        if condition > 1e8 {
            continue;
        }
        let RandomState { a, tau, .. } = random_state(&model, &mut SplitMix64::new(9));
        for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            for force in [&rest, &tau] {
                // Friction would depend on the sign of velocities that are rounding errors.
                let how = Rollout::new(integrator, 1e-3, 2).with_dissipation(false);
                let (ends, held) = ([&q[..], &rest, &a, &tau], Torques::Held(force));
                let (done, found) = pull_rollouts_back(&model, &how, held, ends, nv);
                let (as_before, expected) = pull_rollouts_back(&plain, &how, held, ends, nv);
                assert_eq!(done, as_before, "{name}, {integrator}");
                for (found, expected) in found.iter().zip(&expected) {
                    let off = difference(found, expected, 0.0);
                    assert!(off < 1e-14 * condition, "{name}, {integrator}: {off:e} of {condition:e}");
                }
            }
        }
    }
}

fn name_of(integrator: Integrator) -> &'static str {
    if integrator == Integrator::RungeKutta4 { "rk4" } else { "semi_implicit_euler" }
}

#[test]
fn pullbacks_of_rollouts_name_bad_states_and_pass_far_angles_to_the_recursions() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let model = load(file).expect("a robot").model;
    let (count, nv, plain) = (70, model.nv(), model.clone().with_native(false));
    let [mut q, v, mut a, tau] = states(&model, count);
    q[17 * nv] = f64::NAN;
    a[40 * nv + 3] = f64::INFINITY;
    // Beyond the range of the sine of the machine code.
    q[51 * nv + 2] = 3e5;
    let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-4, 7);
    let ends = [&q[..], &v, &a, &tau];
    let (done, found) = pull_rollouts_back(&model, &how, Torques::Held(&tau), ends, count * nv);
    let (as_before, expected) = pull_rollouts_back(&plain, &how, Torques::Held(&tau), ends, count * nv);
    assert_eq!(done, as_before);
    let batch::RolloutError::BadStates(bad) = done.expect_err("bad states") else { panic!("bad states") };
    assert_eq!(bad.states, [17, 40]);
    for (found, expected) in found.iter().zip(&expected) {
        assert!(found[17 * nv..18 * nv].iter().chain(&found[40 * nv..41 * nv]).all(|x| x.is_nan()));
        assert_eq!(found[51 * nv..52 * nv], expected[51 * nv..52 * nv]);
    }
}

#[test]
fn machine_code_can_be_switched_off() {
    let model = pendulum();
    let (w, mut mass) = (&mut Workspace::limited(&model, InstructionSet::Portable), [0.0]);
    mass_matrix(&model, w, &[0.3], &mut mass);
    assert_eq!((mass, model.native().functions.len()), ([0.5], 0));
    let off = model.clone().with_native(false);
    mass_matrix(&off, &mut Workspace::new(&off), &[0.3], &mut mass);
    assert!(off.native().to_string().contains("switched off") && off.native().functions.is_empty());
    mass_matrix(&model, &mut Workspace::new(&model), &[0.3], &mut mass);
    assert_eq!(model.native().functions.len(), usize::from(has_encoder()));
    // A changed model has its own machine code.
    let mut heavier = model.description().clone();
    heavier.scale_gravity(2.0).expect("a factor");
    let heavier = with_native_code(Model::new(heavier).expect("a pendulum"));
    let weight = |model: &Model| -> f64 {
        let mut weight = [0.0];
        gravity(model, &mut Workspace::new(model), &[0.3], &mut weight);
        weight[0]
    };
    assert!((weight(&heavier) - 2.0 * weight(&model)).abs() < 1e-14);
}

/// A robot whose expression would be too long is not traced.
#[test]
fn very_large_robots_keep_the_recursion() {
    let options = RandomRobotOptions { joints: 3000, ..Default::default() };
    let model = with_native_code(Model::new(random_robot(5, &options)).expect("a robot"));
    let state = random_state(&model, &mut SplitMix64::new(1));
    let mut tau = vec![0.0; model.nv()];
    inverse_dynamics(&model, &mut Workspace::new(&model), &state.q, &state.v, &state.a, &mut tau);
    let report = model.native().to_string();
    assert!(!has_encoder() || report.contains("recursion, which needs some"), "{report}");
}

/// Each thread starts with another function.
#[test]
fn threads_may_call_while_others_compile() {
    const THREADS: usize = 32;
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/humanoid.urdf");
    let model = load(file).expect("a robot").model;
    let (nv, state) = (model.nv(), random_state(&model, &mut SplitMix64::new(1)));
    let RandomState { q, v, a, tau } = &state;
    let barrier = std::sync::Barrier::new(THREADS);
    let call = |first: usize| {
        let (w, zeros) = (&mut Workspace::new(&model), || vec![0.0; nv]);
        let mut options = BatchOptions::default();
        options.threads = 1;
        let of_batches = &mut BatchWorkspace::with_options(&model, options).expect("this thread");
        let mut results = vec![Vec::new(); 5];
        barrier.wait();
        for function in (first..first + 5).map(|k| k % 5) {
            let [mut r, mut x, mut y, mut z] = [(); 4].map(|()| zeros());
            match function {
                0 => inverse_dynamics(&model, w, q, v, a, &mut r),
                1 => forward_dynamics(&model, w, q, v, tau, &mut r),
                2 => forward_dynamics_pullback(
                    &model,
                    w,
                    q,
                    v,
                    tau,
                    a,
                    ForwardPullbackMut {
                        acceleration: &mut r,
                        by_position: &mut x,
                        by_velocity: &mut y,
                        by_force: &mut z,
                        parameters: &mut [],
                    },
                ),
                3 => {
                    r = vec![0.0; nv * nv];
                    mass_matrix(&model, w, q, &mut r);
                }
                _ => batch::inverse_dynamics(&model, of_batches, q, v, a, &mut r).expect("a good state"),
            }
            results[function] = [r, x, y, z].concat();
        }
        results
    };
    let call = &call;
    let results: Vec<Vec<Vec<f64>>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS).map(|first| scope.spawn(move || call(first))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert!(results.iter().all(|result| *result == results[0]));
    assert!(results[0].iter().flatten().all(|x| x.is_finite()) && results[0][0][0] != 0.0);
}

/// A change of a description.
type Spoil = fn(&mut robot_dynamics::description::RobotDescription);

/// A constant that is not a number is refused by name, before anything is traced.
#[test]
fn constants_that_are_no_numbers_are_refused() {
    let description = load(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf"))
        .expect("a robot")
        .model
        .description()
        .clone();
    let spoils: [(Spoil, &str); 4] = [
        (|robot| robot.joints[0].parent_from_joint.translation[1] = f64::NAN, "panda_joint1"),
        (|robot| robot.joints[1].passive.armature = f64::NAN, "panda_joint2"),
        (|robot| robot.joints[2].passive.damping = f64::NAN, "panda_joint3"),
        (|robot| robot.gravity[2] = f64::NAN, "gravity"),
    ];
    for (spoil, named) in spoils {
        let mut spoiled = description.clone();
        spoil(&mut spoiled);
        let error = Model::new(spoiled).expect_err("a constant that is not finite").to_string();
        assert!(error.contains(named) && error.contains("NaN"), "{error}");
    }
}

/// All frames of a robot.
fn frames_of(model: &Model) -> Vec<FrameId> {
    model.frames().iter().map(|frame| model.frame_named(&frame.name).expect("its name")).collect()
}

fn numbers_of<T: BatchFloat>(Pose { rotation, translation }: &Pose<T>) -> Vec<T> {
    rotation.as_flattened().iter().chain(translation).copied().collect()
}

/// The poses of all frames; the pose and Jacobians of one frame; for a robot with mass its centre of mass and
/// the Jacobian of that.
fn compute_frames<T: BatchFloat>(model: &Model, q: &[T], frame: FrameId) -> Vec<Vec<T>> {
    let (w, zero, nv) = (&mut Workspace::<T>::new(model), T::zero(), model.nv());
    let mut poses = vec![Pose { rotation: [[zero; 3]; 3], translation: [zero; 3] }; model.frames().len()];
    frame_poses(model, w, q, &mut poses);
    let mut results =
        vec![poses.iter().flat_map(numbers_of).collect(), numbers_of(&frame_pose(model, w, q, frame))];
    results.extend(core::iter::repeat_n(vec![zero; 6 * nv], 3));
    frame_jacobian(model, w, q, frame, ReferenceFrame::LocalWorldAligned, &mut results[2]);
    frame_jacobian(model, w, q, frame, ReferenceFrame::Local, &mut results[3]);
    frame_jacobian(model, w, q, frame, ReferenceFrame::World, &mut results[4]);
    if model.total_mass() > 0.0 {
        let mut jacobian = vec![zero; 3 * nv];
        center_of_mass_jacobian(model, w, q, &mut jacobian);
        results.extend([center_of_mass(model, w, q).to_vec(), jacobian]);
    }
    results
}

/// For each state the poses of all frames, of one, and of two, and Jacobians.
fn compute_frames_of_batch<T: BatchFloat>(model: &Model, q: &[T], frame: FrameId) -> Vec<Vec<T>> {
    let (frames, count) = (frames_of(model), q.len() / model.nq());
    let w = &mut BatchWorkspace::<T>::new(model);
    let zeros = |width: usize| vec![T::zero(); count * width];
    let mut results = vec![zeros(12 * frames.len()), zeros(12)];
    results.extend(core::iter::repeat_n(zeros(6 * model.nv()), 3));
    results.push(zeros(24));
    let [all, one, aligned, own, world, two] = &mut results[..] else { unreachable!("six") };
    batch::frame_poses(model, w, q, &frames, all).expect("good states");
    batch::frame_poses(model, w, q, &[frame], one).expect("good states");
    batch::frame_jacobian(model, w, q, frame, ReferenceFrame::LocalWorldAligned, aligned)
        .expect("good states");
    batch::frame_jacobian(model, w, q, frame, ReferenceFrame::Local, own).expect("good states");
    batch::frame_jacobian(model, w, q, frame, ReferenceFrame::World, world).expect("good states");
    batch::frame_poses(model, w, q, &[frame, frames[0]], two).expect("good states");
    results
}

/// Columns of Jacobians are cross products with distances up to the size of the robot, which follows from its
/// poses.
#[test]
fn frames_and_the_centre_of_mass_have_the_numbers_of_the_recursions() {
    for (name, model) in robots().into_iter().chain(random_robots()) {
        let plain = model.clone().with_native(false);
        let frames = frames_of(&model);
        let [q, ..] = states(&model, 3);
        for (q, frame) in q.chunks(model.nq()).zip([frames.len() - 1, frames.len() / 2, 0]) {
            let (found, expected) =
                (compute_frames(&model, q, frames[frame]), compute_frames(&plain, q, frames[frame]));
            assert_eq!(found.len(), expected.len());
            let size = largest(&expected[0]);
            for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let off = difference(found, expected, size);
                assert!(off < PLAIN, "{name}, function {index}: {off:e}");
            }
            #[allow(clippy::cast_possible_truncation)]
            let short: Vec<f32> = q.iter().map(|&x| x as f32).collect();
            let rounded: Vec<f64> = short.iter().copied().map(f64::from).collect();
            let (found, expected) = (
                compute_frames(&model, &short, frames[frame]),
                compute_frames(&plain, &rounded, frames[frame]),
            );
            for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let found: Vec<f64> = found.iter().copied().map(f64::from).collect();
                let off = difference(&found, expected, size);
                assert!(off < 2e-4, "{name}, function {index}: {off:e} in single precision");
            }
        }
    }
}

#[test]
fn frames_of_batches_have_the_bits_of_single_calls() {
    for (name, model) in robots().into_iter().chain(random_robots().into_iter().step_by(5)) {
        let (count, nq) = (75, model.nq());
        let [q, ..] = states(&model, count);
        let frame = *frames_of(&model).last().expect("a frame");
        let found = compute_frames_of_batch(&model, &q, frame);
        let plain = compute_frames_of_batch(&model.clone().with_native(false), &q, frame);
        let size = largest(&plain[0]);
        for (index, (found, plain)) in found.iter().zip(&plain).enumerate() {
            let off = difference(found, plain, size);
            assert!(off < PLAIN, "{name}, table {index}: {off:e}");
        }
        for state in 0..count {
            let one = compute_frames(&model, &q[state * nq..(state + 1) * nq], frame);
            // The poses of all frames for one state have no machine code.
            for (index, (found, one)) in found.iter().zip(&one).enumerate().take(5).skip(1) {
                let row = &found[state * one.len()..(state + 1) * one.len()];
                assert!(!has_encoder() || row == one, "{name}, function {index}, state {state}");
            }
        }
    }
}

#[test]
fn bad_states_and_far_angles_of_frames_are_those_of_the_recursions() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let model = load(folder).expect("a robot").model;
    let (plain, nq, frame) = (model.clone().with_native(false), model.nq(), frames_of(&model)[5]);
    let [mut q, ..] = states(&model, 60);
    // The frame does not depend on the last joint, but NaN is refused.
    q[17 * nq + nq - 1] = f64::NAN;
    q[40 * nq] = f64::INFINITY;
    // Beyond the range of the sine of the machine code.
    q[51 * nq + 2] = 3e5;
    let compute = |model: &Model| {
        let (mut jacobian, mut pose) = (vec![0.0; 60 * 6 * nq], vec![0.0; 60 * 12]);
        let w = &mut BatchWorkspace::new(model);
        let bad = batch::frame_jacobian(model, w, &q, frame, ReferenceFrame::Local, &mut jacobian)
            .expect_err("bad states");
        assert_eq!(batch::frame_poses(model, w, &q, &[frame], &mut pose), Err(bad.clone()));
        (jacobian, pose, bad)
    };
    let ((found, pose, bad), (expected, expected_pose, as_before)) = (compute(&model), compute(&plain));
    assert_eq!(bad, as_before);
    assert_eq!(bad.states, [17, 40]);
    let far = 51 * 6 * nq..52 * 6 * nq;
    assert_eq!(
        (&found[far.clone()], &pose[51 * 12..52 * 12]),
        (&expected[far], &expected_pose[51 * 12..52 * 12])
    );
    let far = &q[51 * nq..52 * nq];
    let (found, expected) = (compute_frames(&model, far, frame), compute_frames(&plain, far, frame));
    assert!(found.iter().zip(&expected).all(|(found, expected)| difference(found, expected, 1.0) < PLAIN));
}

#[test]
fn reports_name_frames() {
    let model = pendulum();
    let (w, q, tip) = (&mut Workspace::new(&model), [0.3], model.frame_named("tip").expect("a frame"));
    frame_pose(&model, &mut Workspace::limited(&model, InstructionSet::Portable), &q, tip);
    assert_eq!(model.native().functions.len(), 0);
    frame_pose(&model, w, &q, tip);
    frame_jacobian(&model, w, &q, tip, ReferenceFrame::World, &mut [0.0; 6]);
    let report = model.native();
    assert!(!has_encoder() || report.functions.iter().all(|used| used.frame.as_deref() == Some("tip")));
    assert!(
        !has_encoder()
            || report.to_string().contains("frame_jacobian_world of `tip`, f64, one state: machine code")
    );
    assert_eq!(report.functions.len(), if has_encoder() { 2 } else { 0 });
}

/// A program that asks for each of many frames does not wait for the machine code of all.
#[test]
fn many_frames_keep_the_recursion() {
    let mut description = robot_dynamics::description::pendulum(2.0, 0.5);
    let link = description.links[1].name.clone();
    for number in 0..300 {
        let at = Pose::from_translation([f64::from(number), 0.0, 0.0]);
        description.frames.push(FrameDescription::new(format!("mark {number}"), &link, at));
    }
    let model = with_native_code(Model::new(description).expect("a pendulum"));
    let plain = model.clone().with_native(false);
    let (w, other) = (&mut Workspace::new(&model), &mut Workspace::new(&plain));
    for frame in frames_of(&model) {
        let (found, expected) =
            (frame_pose(&model, w, &[0.3], frame), frame_pose(&plain, other, &[0.3], frame));
        assert!(difference(&numbers_of(&found), &numbers_of(&expected), 300.0) < PLAIN);
    }
    let report = model.native();
    let compiled = report.functions.iter().filter(|used| used.route.is_ok()).count();
    assert!(!has_encoder() || compiled == 256 && report.functions.len() == model.frames().len());
}
