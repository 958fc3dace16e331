//! The arm of `robots/panda.urdf`, from its file to its equation of motion.

use dynamics::{Dynamics, Integrator, SplitMix64, energy_drift, skew_symmetry_defect};
use multibody::{FixedSize, Model};
use nalgebra::SVector;

fn panda() -> FixedSize<7> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
    let robot = urdf::load(path, &urdf::Options::default()).expect("the robot loads");
    FixedSize::new(Model::new(robot.description).expect("the robot compiles"))
        .expect("seven joints")
        .without_dissipation()
}

fn random(random: &mut SplitMix64, size: f64) -> SVector<f64, 7> {
    SVector::from_fn(|_, _| random.uniform(-size, size))
}

/// κ(M) reaches some 1e3 and torques 1e2: 1e-9 is far above 1e5 roundings, and the figure asked of any arm.
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

/// Ṁ by the exact derivative of the Lagrange recipe's M, C by the recursion: no shared path.
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

#[test]
fn unforced_fall_keeps_its_energy() {
    let arm = panda();
    let q = SVector::from([0.0, 0.0, 0.0, -1.5, 0.0, 1.8, 0.0]);
    let rest = SVector::zeros();
    let drift =
        energy_drift(&arm, &q, &rest, &rest, 1e-3, 10_000, Integrator::RungeKutta4).expect("a plain fall");
    println!("energy drift, rk4, 1 ms, 10 s: {drift:e}");
    assert!(drift < 1e-6, "{drift:e}");
}
