//! Enclosures of robots' quantities contain the values in twice the digits, and those of states in the box.

mod double;

use double::Double;
use robot_dynamics::algorithms::{
    bias, coriolis_matrix, forward_dynamics, gravity, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy,
};
use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::{Scalar, SplitMix64};
use robot_dynamics_certified::{Interval, is_positive_definite};

fn robots() -> impl Iterator<Item = Model> {
    (0..15).map(|seed| {
        let joints = 2 + usize::try_from(seed % 7).expect("small");
        let kinds = JointKinds::Turning;
        let options = RandomRobotOptions { joints, kinds, chain: 0.7, ..Default::default() };
        Model::new(random_robot(seed, &options)).expect("a robot")
    })
}

/// M, C, g, C v + g and τ, and both energies.
fn quantities<S: Scalar>(model: &Model, [q, v, a]: [&[S]; 3]) -> Vec<S> {
    let (n, w) = (model.nv(), &mut Workspace::<S>::new(model));
    let mut out = vec![S::zero(); 2 * n * n + 3 * n];
    let (matrices, vectors) = out.split_at_mut(2 * n * n);
    mass_matrix(model, w, q, &mut matrices[..n * n]);
    coriolis_matrix(model, w, q, v, &mut matrices[n * n..]);
    gravity(model, w, q, &mut vectors[..n]);
    bias(model, w, q, v, &mut vectors[n..2 * n]);
    inverse_dynamics(model, w, q, v, a, &mut vectors[2 * n..]);
    out.push(kinetic_energy(model, w, q, v));
    out.push(potential_energy(model, w, q));
    out
}

fn over<S: Scalar>(x: &[f64]) -> Vec<S> {
    x.iter().map(|x| S::from_f64(*x)).collect()
}

#[test]
fn enclosures_of_states_contain_values_in_twice_the_digits() {
    let mut random = SplitMix64::new(1);
    let (mut count, mut widest) = (0, 0.0_f64);
    for model in robots() {
        for _ in 0..20 {
            let state =
                [(); 3].map(|()| (0..model.nv()).map(|_| random.uniform(-3.0, 3.0)).collect::<Vec<f64>>());
            let intervals: [Vec<Interval>; 3] = state.each_ref().map(|x| over(x));
            let doubles: [Vec<Double>; 3] = state.each_ref().map(|x| over(x));
            let found = quantities(&model, intervals.each_ref().map(|x| &x[..]));
            let exact = quantities(&model, doubles.each_ref().map(|x| &x[..]));
            let scale = exact.iter().fold(1.0, |most: f64, x| most.max(x.value().abs()));
            for (found, exact) in found.iter().zip(&exact) {
                // The other route has 106 bits: its error is far below the width of an interval.
                assert!(exact.is_within(found.lower(), found.upper(), 1e-28 * scale), "{found:?}, {exact:?}");
                widest = widest.max(found.width() / scale);
                count += 1;
            }
        }
    }
    assert!(count > 10_000 && widest < 1e-11, "{count} values, the widest is {widest:e} of the largest");
}

#[test]
fn enclosures_of_boxes_contain_the_values_of_their_states() {
    let mut random = SplitMix64::new(2);
    for model in robots() {
        let n = model.nv();
        let mut around = |radius: f64| -> Vec<Interval> {
            (0..n).map(|_| Interval::around(random.uniform(-3.0, 3.0), radius)).collect()
        };
        let boxed = [around(0.02), around(0.1), around(0.1)];
        let found = quantities(&model, boxed.each_ref().map(|x| &x[..]));
        let n = n * n;
        let is_definite = is_positive_definite(&found[..n], model.nv());
        for _ in 0..50 {
            let inside = boxed.each_ref().map(|x| {
                x.iter()
                    .map(|x| x.lower() + random.uniform(0.0, 1.0) * (x.upper() - x.lower()))
                    .collect::<Vec<f64>>()
            });
            let values = quantities(&model, inside.each_ref().map(|x| &x[..]));
            let scale = values.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (found, value) in found.iter().zip(&values) {
                // The value has the rounding of floats.
                let slack = 1e-12 * scale;
                assert!(
                    found.lower() - slack <= *value && *value <= found.upper() + slack,
                    "{found}: {value}"
                );
            }
        }
        let tight: Vec<Interval> = boxed[0].iter().map(|q| Interval::from(q.middle())).collect();
        let mut mass = vec![Interval::from(0.0); n];
        mass_matrix(&model, &mut Workspace::new(&model), &tight, &mut mass);
        assert!(is_positive_definite(&mass, model.nv()) || !is_definite);
    }
}

#[test]
fn enclosures_of_accelerations_contain_the_values_of_their_states() {
    let mut random = SplitMix64::new(4);
    let mut proven = 0;
    for model in robots() {
        let n = model.nv();
        let state = [(); 3].map(|()| (0..n).map(|_| random.uniform(-2.0, 2.0)).collect::<Vec<f64>>());
        let [q, v, tau] = state
            .each_ref()
            .map(|x| -> Vec<Interval> { x.iter().map(|x| Interval::around(*x, 1e-6)).collect() });
        let Ok(found) = robot_dynamics_certified::forward_dynamics(&model, &q, &v, &tau) else { continue };
        proven += 1;
        let [q, v, tau] = &state;
        let mut a = vec![0.0; n];
        forward_dynamics(&model, &mut Workspace::new(&model), q, v, tau, &mut a);
        for (found, value) in found.iter().zip(&a) {
            assert!(found.contains(*value), "{found}: {value}");
        }
    }
    assert!(proven >= 12, "{proven} of 15 robots: narrow boxes of regular robots have enclosures");
}
