//! Torques, accelerations and mass matrices of every robot.

use robot_dynamics::model::{Model, normalize_quaternions};
use robot_dynamics_gpu::Function;

use crate::bounds::Bounds;
use crate::robots::{self, States, row};

const FUNCTIONS: [Function; 3] = [Function::InverseDynamics, Function::ForwardDynamics, Function::MassMatrix];

/// Results are within the bounds that follow from the robot's conditioning, in a batch whose last workgroup
/// is partial.
#[test]
fn every_robot_agrees_with_the_library_to_the_rounding_of_singles() {
    let Some(device) = crate::device() else { return };
    let (mut judged, mut worst) = (0, [0.0_f64; 3]);
    for model in robots::all().into_iter().chain([robots::with_ball()]) {
        let mut batches = device.compile::<f32>(&model, &FUNCTIONS).unwrap();
        let (count, nv) = (70, model.nv());
        let states = States::random(&model, count, 3);
        let [mut tau, mut a] = [(); 2].map(|()| vec![f32::NAN; count * nv]);
        let mut mass = vec![f32::NAN; count * nv * nv];
        batches.inverse_dynamics(&states.q, &states.v, &states.a, &mut tau).unwrap();
        batches.forward_dynamics(&states.q, &states.v, &states.tau, &mut a).unwrap();
        batches.mass_matrix(&states.q, &mut mass).unwrap();
        for state in 0..count {
            let of = |rows: &[f32]| row(rows, count, state);
            let found = [of(&tau), of(&a), of(&mass)];
            let off = compare(&model, &states, state, &found);
            for (k, off) in off.into_iter().enumerate() {
                let Some(off) = off else { continue };
                // NaN fails, too.
                assert!(
                    off <= 1.0,
                    "{} of {}, state {state}: {off} of what is allowed",
                    FUNCTIONS[k],
                    model.name()
                );
                worst[k] = worst[k].max(off);
                judged += 1;
            }
        }
    }
    println!("{judged} results; the worst are {worst:?} of what is allowed");
    assert!(judged > 3000, "{judged}");
}

/// The ratio of the error to its bound; `None` if singles do not determine M.
fn compare(model: &Model, states: &States, state: usize, found: &[Vec<f64>; 3]) -> [Option<f64>; 3] {
    let of = |rows: &[f32]| row(rows, states.count, state);
    let (mut q, v, a, tau) = (of(&states.q), of(&states.v), of(&states.a), of(&states.tau));
    normalize_quaternions(model, &mut q); // the device uses their direction alone
    let bounds = Bounds::new(model, &q, &v, &a);
    let ratio = |found: &[f64], expected: &[f64], allowed: &dyn Fn(usize) -> f64| {
        let pairs = found.iter().zip(expected).enumerate();
        pairs.map(|(i, (x, y))| (x - y).abs() / allowed(i)).fold(0.0, worse)
    };
    let torque = model.inverse_dynamics(&q, &v, &a).unwrap();
    let acceleration = model.forward_dynamics(&q, &v, &tau).unwrap();
    // The bound uses the computed acceleration.
    let allowed = Bounds::new(model, &q, &v, acceleration.as_slice()).acceleration(&tau);
    let nv = model.nv();
    let entry = |i: usize| bounds.rounding * bounds.roots[i / nv] * bounds.roots[i % nv];
    let mass = model.mass_matrix(&q).unwrap(); // symmetric: rows are columns
    [
        Some(ratio(&found[0], torque.as_slice(), &|i| bounds.rounding * bounds.roots[i] * bounds.force)),
        bounds.is_known().then(|| ratio(&found[1], acceleration.as_slice(), &|i| allowed[i])),
        Some(ratio(&found[2], mass.as_slice(), &entry)),
    ]
}

/// The larger one, or NaN.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}
