//! Energy over 10⁶ steps: drift and bounded errors.

use std::f64::consts::PI;

use dynamics::{Dynamics, EnergyRun, Reach2R, energy_run};
use nalgebra::{Matrix1, Vector1, Vector2, vector};
use robot_dynamics_integrators::Integrator;

const STEPS: usize = 1_000_000;

/// 10⁶ steps of 1 ms of the worked example: 1000 s from rest at (π/4, π/2).
fn arm(integrator: Integrator) -> EnergyRun<2> {
    let (q0, zero) = (vector![PI / 4.0, PI / 2.0], Vector2::zeros());
    report(
        integrator,
        energy_run(&Reach2R::worked_example(), &q0, &zero, &zero, 1e-3, STEPS, integrator).unwrap(),
    )
}

/// A simple pendulum of ω₀ = 3 rad/s, q from the bottom: constant M.
struct Pendulum;

impl Dynamics<1> for Pendulum {
    fn mass(&self, _: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::identity()
    }
    fn velocity_product(&self, _: &Vector1<f64>, _: &Vector1<f64>) -> Vector1<f64> {
        Vector1::zeros()
    }
    fn gravity(&self, q: &Vector1<f64>) -> Vector1<f64> {
        vector![9.0 * q[0].sin()]
    }
    fn potential_energy(&self, q: &Vector1<f64>) -> f64 {
        -9.0 * q[0].cos()
    }
}

/// 10⁶ steps of 10 ms, 10⁴ s, from rest at 2 rad: about 3500 swings.
fn pendulum(integrator: Integrator) -> EnergyRun<1> {
    let zero = Vector1::zeros();
    report(integrator, energy_run(&Pendulum, &vector![2.0], &zero, &zero, 1e-2, STEPS, integrator).unwrap())
}

fn report<const N: usize>(integrator: Integrator, run: EnergyRun<N>) -> EnergyRun<N> {
    println!(
        "{integrator:>22}: drift {:.2e}, first tenth {:.2e} J, last tenth {:.2e} J, at the end {:+.2e} J",
        run.energy_account.drift(),
        run.first_tenth,
        run.last_tenth,
        run.energy_account.imbalance()
    );
    run
}

/// The ratio of the energy error in the last tenth of a run to that in the first.
fn growth<const N: usize>(run: &EnergyRun<N>) -> f64 {
    run.last_tenth / run.first_tenth
}

/// Runge–Kutta loses a little energy every second, and the loss accumulates. The motion is chaotic, so its
/// size is asserted within a factor of 3 about the measured 3.6e-7. The growth is ten for a steady loss,
/// measured 12.7, and is asserted within a factor of 2.
#[test]
fn rk4_energy_of_arm_drifts_steadily() {
    let run = arm(Integrator::RungeKutta4);
    assert!((1.2e-7..1.1e-6).contains(&run.energy_account.drift()), "{run:?}");
    assert!((5.0..25.0).contains(&growth(&run)), "{run:?}");
    // The loss has one sign: the error is largest at the end of the run.
    assert!(run.energy_account.imbalance() < -0.9 * run.last_tenth, "{run:?}");
}

/// The error of the variational steps is O(hᵖ) and stays bounded. The last tenth has the error of the first,
/// up to the states that a chaotic motion happens to visit (measured ratios 1.01 and 1.13).
#[test]
fn variational_energy_of_arm_stays_bounded() {
    for (row, bound) in [(Integrator::VariationalMidpoint, 5e-4), (Integrator::VariationalYoshida4, 5e-7)] {
        let run = arm(row);
        assert!(run.energy_account.drift() < bound, "{row}: {run:?}");
        assert!((0.5..2.0).contains(&growth(&run)), "{row}: {run:?}");
    }
}

/// The energy of semi-implicit Euler is bounded if M is constant and not bounded otherwise, as its row of the
/// table states.
#[test]
fn semi_implicit_energy_is_bounded_only_for_constant_mass() {
    let constant = pendulum(Integrator::SemiImplicitEuler);
    assert!(constant.energy_account.drift() < 0.1 && (0.9..1.1).contains(&growth(&constant)), "{constant:?}");
    let varying = arm(Integrator::SemiImplicitEuler);
    assert!(varying.energy_account.drift() > 1.0 && growth(&varying) > 2.0, "{varying:?}");
}

/// The pendulum is periodic, so chance plays no part. RK4's loss in ten times the time is ten times as large,
/// and the variational error repeats in each swing.
#[test]
fn pendulum_separates_drift_from_oscillation() {
    let rk4 = pendulum(Integrator::RungeKutta4);
    assert!((8.0..12.0).contains(&growth(&rk4)), "{rk4:?}");
    for row in [Integrator::VariationalMidpoint, Integrator::VariationalYoshida4] {
        let run = pendulum(row);
        assert!((0.999..1.001).contains(&growth(&run)), "{row}: {run:?}");
    }
}
