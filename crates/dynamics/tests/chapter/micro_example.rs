//! The worked example of the two-link arm: every number, and the effect of the velocity-product forces.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use dynamics::{
    Christoffel, Dynamics, Reach2R, WorkedExample, christoffel, christoffel_by_differences, energy_drift,
    laws,
};
use nalgebra::{SMatrix, SVector, Vector2, vector};
use robot_dynamics_integrators::Integrator;

const POSE: [f64; 2] = [FRAC_PI_4, FRAC_PI_2];

/// Every line of the worked example to 1e-4, the printed digits.
#[test]
fn numbers_match_worked_example() {
    let (arm, q, qd) = (Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 9.81), Vector2::from(POSE), vector![1.0, 0.0]);
    let near = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-4, "found {found}, expected {expected}");
    };
    let m = arm.mass(&q);
    m.iter().zip([2.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]).for_each(|(&m, expected)| near(m, expected));
    near(m.determinant(), 0.5556);
    let eigenvalues = m.symmetric_eigenvalues();
    near(eigenvalues.max(), 2.0642);
    near(eigenvalues.min(), 0.2691);
    near(arm.gravity(&q)[0], 10.4051);
    near(arm.gravity(&q)[1], -3.4684);
    near(arm.velocity_product(&q, &qd)[0], 0.0);
    near(arm.velocity_product(&q, &qd)[1], 0.5);
    near(arm.kinetic_energy(&q, &qd), 1.0);
    near(arm.potential_energy(&q), 17.3418);
    near(arm.energy(&q, &qd), 18.3418);
    for (q2, m11) in [(0.0, 3.0), (FRAC_PI_2, 2.0), (PI, 1.0)] {
        near(arm.mass(&vector![q[0], q2])[(0, 0)], m11);
    }
    let rest = Vector2::zeros();
    let drift = |row| energy_drift(&arm, &q, &rest, &rest, 1e-3, 10_000, row).unwrap();
    let rk4 = drift(Integrator::RungeKutta4);
    assert!((rk4 / 1.22e-8 - 1.0).abs() < 0.01, "RK4 drift {rk4:e}");
    assert!((drift(Integrator::SemiImplicitEuler) - 0.11).abs() < 0.005);
    assert!((drift(Integrator::ExplicitEuler) - 0.14).abs() < 0.005);
}

/// The example prints exactly the text of `WorkedExample`.
#[test]
fn example_prints_worked_numbers() {
    let expected = "\
M   = [[2.0000, 0.3333], [0.3333, 0.3333]]      det 0.5556   eig 2.0642 0.2691
g   = [10.4051, -3.4684]
Cq̇  = [0.0000, 0.5000]        for q̇ = (1, 0)
K   = 1.0000 J    V = 17.3418 J    E = 18.3418 J
M11 sweep over q2 ∈ {0, π/2, π}:  3.0000  2.0000  1.0000
energy drift, τ = 0, h = 1 ms, 10 s:  rk4 1.2e-8   semi-implicit Euler 1.1e-1   explicit Euler 1.4e-1
";
    assert_eq!(WorkedExample::compute().unwrap().to_string(), expected);
}

/// Γ in closed form, by central differences with step 1e-6 (to 1e-7), and by dual numbers (to rounding).
#[test]
fn christoffel_closed_form_matches_finite_differences() {
    let arm = Reach2R::worked_example();
    let mut worst: (f64, f64) = (0.0, 0.0);
    for state in laws::States::<2>::new(10).count(50).iter() {
        let closed: Christoffel<2> = arm.christoffel(&state.q);
        let differenced = christoffel_by_differences(|q| arm.mass(q), &state.q, 1e-6);
        worst.0 = worst.0.max(closed.max_difference(&differenced));
        worst.1 = worst.1.max(closed.max_difference(&christoffel(&arm, &state.q)));
        assert!(
            worst.0 < 1e-7 && worst.1 < 1e-15,
            "{worst:?} at state {} of seed 10: {}",
            state.index,
            state.q
        );
    }
    // Differences are not exact; if they were, the two computations would share code.
    assert!(worst.0 > 0.0);
}

/// The arm with C q̇ removed from its equation, M q̈ + g = u, as if M were constant.
struct WithoutCoriolis(Reach2R);

impl Dynamics<2> for WithoutCoriolis {
    fn mass(&self, q: &SVector<f64, 2>) -> SMatrix<f64, 2, 2> {
        self.0.mass(q)
    }
    fn velocity_product(&self, _: &SVector<f64, 2>, _: &SVector<f64, 2>) -> SVector<f64, 2> {
        SVector::zeros()
    }
    fn gravity(&self, q: &SVector<f64, 2>) -> SVector<f64, 2> {
        self.0.gravity(q)
    }
    fn potential_energy(&self, q: &SVector<f64, 2>) -> f64 {
        self.0.potential_energy(q)
    }
}

/// Without C q̇ the energy changes by more than 20 %. Halving the step does not help, so the equation is
/// wrong and not the integrator.
#[test]
fn energy_is_not_conserved_without_coriolis() {
    let (q, rest) = (Vector2::from(POSE), Vector2::zeros());
    let (arm, lie) = (Reach2R::worked_example(), WithoutCoriolis(Reach2R::worked_example()));
    let drift = |system: &dyn Dynamics<2>, h: f64, steps| {
        energy_drift(system, &q, &rest, &rest, h, steps, Integrator::RungeKutta4).unwrap()
    };
    let honest = drift(&arm, 1e-3, 10_000);
    let (lying, finer) = (drift(&lie, 1e-3, 10_000), drift(&lie, 5e-4, 20_000));
    assert!(honest < 1e-6, "with C q̇: {honest:e}");
    assert!(lying > 0.2, "without C q̇: {lying}");
    assert!((lying - finer).abs() < 1e-4, "step 1 ms: {lying}, step 0.5 ms: {finer}");
}
