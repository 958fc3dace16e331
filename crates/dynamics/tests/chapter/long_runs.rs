//! Energy over 10⁶ steps: what drifts and what stays.

use std::f64::consts::PI;

use dynamics::{Dynamics, EnergyRun, Integrator, Reach2R, energy_run};
use nalgebra::{Matrix1, Vector1, Vector2, vector};

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

/// 10⁶ steps of 10 ms, 10⁴ s, from rest at 2 rad: some 3500 swings.
fn pendulum(integrator: Integrator) -> EnergyRun<1> {
    let zero = Vector1::zeros();
    report(integrator, energy_run(&Pendulum, &vector![2.0], &zero, &zero, 1e-2, STEPS, integrator).unwrap())
}

fn report<const N: usize>(integrator: Integrator, run: EnergyRun<N>) -> EnergyRun<N> {
    println!(
        "{integrator:>22}: drift {:.2e}, first tenth {:.2e} J, last tenth {:.2e} J, at the end {:+.2e} J",
        run.ledger.drift(),
        run.first_tenth,
        run.last_tenth,
        run.ledger.imbalance()
    );
    run
}

/// How much larger the energy error is in the last tenth of a run than in the first.
fn growth<const N: usize>(run: &EnergyRun<N>) -> f64 {
    run.last_tenth / run.first_tenth
}

/// Runge–Kutta loses a little energy every second: small, but it adds up. The motion is chaotic, so its
/// size is asserted in a band of a factor of 3 about the measured 3.6e-7, its growth (ten for a steady
/// loss, measured 12.7) within a factor of 2.
#[test]
fn rk4_energy_of_the_arm_drifts_steadily() {
    let run = arm(Integrator::RungeKutta4);
    assert!((1.2e-7..1.1e-6).contains(&run.ledger.drift()), "{run:?}");
    assert!((5.0..25.0).contains(&growth(&run)), "{run:?}");
    // The loss is one-sided: the run ends where the error is largest.
    assert!(run.ledger.imbalance() < -0.9 * run.last_tenth, "{run:?}");
}

/// The variational steps err by O(hᵖ) and stay there: the last tenth is no worse than the first, up to
/// what a chaotic motion happens to visit (measured ratios 1.01 and 1.13).
#[test]
fn variational_energy_of_the_arm_stays() {
    for (row, bound) in [(Integrator::VariationalMidpoint, 5e-4), (Integrator::VariationalYoshida4, 5e-7)] {
        let run = arm(row);
        assert!(run.ledger.drift() < bound, "{row}: {run:?}");
        assert!((0.5..2.0).contains(&growth(&run)), "{row}: {run:?}");
    }
}

/// The semi-implicit Euler's energy is bounded where M is constant and wanders off where it is not: what
/// its row of the table says.
#[test]
fn semi_implicit_energy_stays_only_for_constant_mass() {
    let constant = pendulum(Integrator::SemiImplicitEuler);
    assert!(constant.ledger.drift() < 0.1 && (0.9..1.1).contains(&growth(&constant)), "{constant:?}");
    let varying = arm(Integrator::SemiImplicitEuler);
    assert!(varying.ledger.drift() > 1.0 && growth(&varying) > 2.0, "{varying:?}");
}

/// On the periodic pendulum nothing is left to chance: RK4's loss in ten times the time is ten times as
/// large, the variational error repeats itself swing by swing.
#[test]
fn pendulum_separates_drift_from_oscillation() {
    let rk4 = pendulum(Integrator::RungeKutta4);
    assert!((8.0..12.0).contains(&growth(&rk4)), "{rk4:?}");
    for row in [Integrator::VariationalMidpoint, Integrator::VariationalYoshida4] {
        let run = pendulum(row);
        assert!((0.999..1.001).contains(&growth(&run)), "{row}: {run:?}");
    }
}
