//! Machine code in place of the recursions: the same numbers to rounding, the same refusals, and which route computed.
#![cfg(all(feature = "native", feature = "batch"))]
#![allow(missing_docs)]

use std::ops::ControlFlow;
use std::path::PathBuf;

use robot_dynamics::batch::{self, BatchFloat, BatchOptions, BatchWorkspace, Rollout, Torques};
use robot_dynamics::dynamics::{Integrator, SplitMix64};
use robot_dynamics::{
    Base, InstructionSet, JointKinds, Model, RandomRobotOptions, RandomState, Workspace, load, random_robot,
    random_state, with_native_code,
};
use robot_dynamics::{LinearizeStepWorkspace, StepForces, forward_dynamics_pullback, linearize_step};
use robot_dynamics::{bias, coriolis_matrix, forward_dynamics, gravity, inverse_dynamics, mass_matrix};
use robot_dynamics::{inverse_mass_matrix, kinetic_energy, momentum, potential_energy, velocity_product};

/// All results of a state, one after the other, and where M is inverted behind them.
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
    let mut inverting = vec![vector, matrix];
    forward_dynamics(model, w, q, v, tau, &mut inverting[0]);
    inverse_mass_matrix(model, w, q, &mut inverting[1]);
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

/// The ratio of the largest to the smallest of M's eigenvalues.
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

/// An operation rounds by ε/2 of its result; sums of some hundred terms along the tree cancel to a hundredth of them.
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
            // C v may be a difference of forces that vanishes, and C of rates of M.
            let (force, rate) =
                (largest(&expected.plain[0]), largest(&expected.plain[5]) * largest(&state.v));
            for (index, (found, expected)) in found.plain.iter().zip(&expected.plain).enumerate() {
                let scale = [0.0, 0.0, 0.0, force, 0.0, 0.0, rate, 0.0, force][index];
                let off = difference(found, expected, scale);
                assert!(off < PLAIN, "{name}, function {index}: {off:e}");
            }
            let condition = condition_number(&plain, &state.q);
            // Singular to rounding: no digit is left.
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
    with_native_code(Model::new(robot_dynamics::pendulum(2.0, 0.5)).expect("a pendulum"))
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

/// Forces, accelerations, M and the entries of it that are not always zero, ∂τ of each state.
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
    batch::inverse_dynamics_derivatives(model, w, q, v, a, &mut by_q, &mut by_v).expect("good states");
    results.extend([by_q, by_v]);
    results
}

#[test]
fn batches_have_the_bits_of_single_calls_whatever_the_threads() {
    for (name, model) in robots().into_iter().chain(random_robots().into_iter().step_by(7)) {
        // Not a multiple of any register.
        let count = 301;
        let tables = states(&model, count);
        let (mut one, mut two) = (BatchOptions::default(), BatchOptions::default());
        (one.threads, two.threads) = (1, 2);
        let found = compute_batches(&model, &tables, one);
        assert_eq!(found, compute_batches(&model, &tables, two), "{name}");
        let plain = compute_batches(&model.clone().with_native(false), &tables, one);
        for (index, (found, plain)) in found.iter().zip(&plain).enumerate().filter(|(index, _)| *index != 2) {
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
            let is_it = |used: &&robot_dynamics::NativeUse| {
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
        }
    }
}

/// f32 has 24 bits; the same sums as above.
#[test]
fn single_precision_has_the_numbers_of_double_precision_to_its_rounding() {
    for (name, model) in robots() {
        let tables = states(&model, 40);
        #[allow(clippy::cast_possible_truncation)]
        let short = tables.clone().map(|table| table.into_iter().map(|x| x as f32).collect::<Vec<_>>());
        // The states as they are after rounding.
        let tables = short.clone().map(|table| table.into_iter().map(f64::from).collect::<Vec<_>>());
        let (found, expected) = (
            compute_batches(&model, &short, BatchOptions::default()),
            compute_batches(&model.clone().with_native(false), &tables, BatchOptions::default()),
        );
        for (index, (found, expected)) in found.iter().zip(&expected).enumerate().filter(|(k, _)| *k != 2) {
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
    // The first joint's angle changes no torque; NaN there is bad all the same.
    q[17 * nv] = f64::NAN;
    q[40 * nv + 3] = f64::INFINITY;
    // Beyond the range of the code's sine.
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
                let go_on = |_| ControlFlow::Continue(());
                let trajectory = (&mut samples.0[..], &mut samples.1[..]);
                let ended = batch::rollout(model, w, &how, torques, &mut q, &mut v, trajectory, &go_on);
                ended.map(|()| [q, v, samples.0, samples.1])
            };
            let (Ok(found), Ok(expected)) = (run(&model), run(&model.clone().with_native(false))) else {
                continue;
            };
            compared += 1;
            // M⁻¹ has κ(M) times the error of M; over the short way nothing grows.
            let condition = condition_number(&model, &q[..model.nq()]).max(1e4);
            for (found, expected) in found.iter().zip(&expected) {
                let off = difference(found, expected, 0.0);
                assert!(off < 1e-14 * condition, "{name}, {integrator}: {off:e} of {condition:e}");
            }
        }
    }
    assert!(compared > 60, "{compared}");
}

/// What calls forward and inverse dynamics within does not lean on what their recursions leave in memory.
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
            forward_dynamics_pullback(model, w, q, v, tau, a, &mut one, &mut two, &mut three, &mut four);
            let mut results = vec![one, two, three, four];
            let step = &mut LinearizeStepWorkspace::new(model);
            let (mut by_state, mut by_force) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
            let (row, forces) = (Integrator::RungeKutta4, StepForces::new(tau, true));
            linearize_step(model, row, step, &forces, 1e-4, q, v, &mut by_state, &mut by_force)
                .expect("M is regular");
            results.extend([by_state, by_force]);
            results
        };
        for (index, (found, expected)) in compute(&model).iter().zip(&compute(&plain)).enumerate() {
            let off = difference(found, expected, 0.0);
            // M⁻¹ is applied twice.
            assert!(
                off < INVERTING * (condition * condition).max(1e3),
                "{name}, result {index}: {off:e} of {condition:e}"
            );
        }
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
    // A model that is changed has code of its own.
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

/// A robot whose expression would be too long is not traced at all.
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

#[test]
fn threads_may_call_while_others_compile() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/humanoid.urdf");
    let model = load(file).expect("a robot").model;
    let state = random_state(&model, &mut SplitMix64::new(1));
    let results: Vec<Vec<f64>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..32)
            .map(|_| {
                scope.spawn(|| {
                    let mut tau = vec![0.0; model.nv()];
                    let w = &mut Workspace::new(&model);
                    inverse_dynamics(&model, w, &state.q, &state.v, &state.a, &mut tau);
                    tau
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert!(results.iter().all(|tau| *tau == results[0]));
}
