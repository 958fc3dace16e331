//! The arm of `robots/panda.urdf`, from its file to its equation of motion.

use std::thread;

use dynamics::{Dynamics, FixedSize, energy_drift, skew_symmetry_defect};
use nalgebra::SVector;
use robot_dynamics::model::Model;
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::Integrator;

fn panda() -> FixedSize<7> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let robot = robot_dynamics::urdf::load(path, &robot_dynamics::urdf::LoadOptions::default())
        .expect("the robot loads");
    FixedSize::new(Model::new(robot.description).expect("the robot compiles"))
        .expect("seven joints")
        .without_dissipation()
}

fn random(random: &mut SplitMix64, size: f64) -> SVector<f64, 7> {
    SVector::from_fn(|_, _| random.uniform(-size, size))
}

/// κ(M) reaches about 1e3 and torques 1e2: 1e-9 is far above 1e5 roundings, and it is the accuracy required
/// of any arm.
#[test]
fn inverse_of_forward_is_the_torque() {
    let arm = panda();
    let mut source = SplitMix64::new(1);
    for k in 0..100 {
        let (q, qd, u) = (random(&mut source, 2.5), random(&mut source, 2.0), random(&mut source, 50.0));
        let back = arm.inverse(&q, &qd, &arm.forward(&q, &qd, &u));
        assert!((back - u).amax() < 1e-9, "state {k}: {:e}", (back - u).amax());
    }
}

/// Ṁ by the exact derivative of the Lagrange recipe's M, C by the recursion: the two share no code.
#[test]
fn rate_of_mass_less_twice_coriolis_is_skew() {
    let arm = panda();
    let mut source = SplitMix64::new(2);
    for k in 0..100 {
        let (q, qd) = (random(&mut source, 2.5), random(&mut source, 2.0));
        let defect = skew_symmetry_defect(&dynamics::mass_rate(&arm, &q, &qd), &arm.coriolis_matrix(&q, &qd));
        assert!(defect < 1e-10, "state {k}: {defect:e}");
    }
}

/// The median energy drift of nine falls of ten seconds that start 1e-11 rad apart.
///
/// The falls are chaotic: a rounding grows to radians before they end. The last digits of the arithmetic
/// determine the drift of a single fall (1e-7 to 3e-6 at 1 ms). The median is stable.
fn middle_drift(step: f64, steps: usize) -> f64 {
    let (arm, rest) = (panda(), SVector::zeros());
    let fall = |k: i8| {
        let q = SVector::from([0.0, 0.0, 0.0, -1.5 + 1e-11 * f64::from(k), 0.0, 1.8, 0.0]);
        let drift = energy_drift(&arm, &q, &rest, &rest, step, steps, Integrator::RungeKutta4);
        drift.expect("a plain fall")
    };
    let mut drifts: Vec<f64> = thread::scope(|scope| {
        let fall = &fall;
        let falls: Vec<_> = (-4..=4).map(|k| scope.spawn(move || fall(k))).collect();
        falls.into_iter().map(|fall| fall.join().expect("a drift")).collect()
    });
    drifts.sort_by(f64::total_cmp);
    println!("energy drifts, rk4, {step} s, 10 s: {drifts:?}");
    drifts[4]
}

/// The drift is below 1e-6 at 1 ms. A method of order 4 loses energy at order 5: half the step leaves a
/// thirty-second. The test asserts an eighth, as the two sets of falls diverge from each other.
#[test]
fn unforced_fall_keeps_its_energy() {
    let drift = middle_drift(1e-3, 10_000);
    assert!(drift < 1e-6, "{drift:e}");
    let halved = middle_drift(5e-4, 20_000);
    assert!(halved < drift / 8.0, "{halved:e} at half the step, {drift:e}");
}
