//! Machine code in place of the recursions: the same numbers to rounding, the same refusals, and which route computed.
#![cfg(all(feature = "native", feature = "batch"))]
#![allow(missing_docs)]

use std::path::PathBuf;

use robot_dynamics::dynamics::SplitMix64;
use robot_dynamics::{
    Base, JointKinds, Model, RandomRobotOptions, RandomState, Workspace, load, random_robot, random_state,
    with_native_code,
};
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
        let joints = 1 + (7 * seed as usize) % 40;
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
        if report.reason.is_none() {
            compiled += report.functions.iter().filter(|used| used.route.is_ok()).count();
        }
    }
    // Where the processor has an encoder, most functions are compiled.
    if robot_dynamics::with_native_code(Model::new(robot_dynamics::pendulum(1.0, 1.0)).unwrap())
        .native()
        .reason
        .is_none()
    {
        assert!(compiled > 500, "{compiled}");
    }
}
