//! Every fixed-step integrator: its order, symmetry, structure and energy.

use std::f64::consts::PI;

use dynamics::{
    Dynamics, FromLagrangian, Lagrangian, PlanarArm, Reach2R, State, SystemStep, energy_drift, energy_run,
    rk4_step, solve_mass, variational_midpoint_step,
};
use nalgebra::{Matrix2, Matrix4, SVector, Vector2, Vector4, vector};
use robot_dynamics_integrators::{Integrator, IntegratorError, Symplectic};
use robot_dynamics_number::{Dual, Scalar};

/// Two pendulums of different mass joined by a torsion spring: constant M, nonlinear, in two coordinates.
struct CoupledPendulums;

impl Dynamics<2> for CoupledPendulums {
    fn mass(&self, _: &Vector2<f64>) -> Matrix2<f64> {
        Matrix2::new(2.0, 0.3, 0.3, 1.0)
    }
    fn velocity_product(&self, _: &Vector2<f64>, _: &Vector2<f64>) -> Vector2<f64> {
        Vector2::zeros()
    }
    fn gravity(&self, q: &Vector2<f64>) -> Vector2<f64> {
        let spring = 3.0 * (q[0] - q[1]);
        vector![9.0 * q[0].sin() + spring, 4.0 * q[1].sin() - spring]
    }
    fn potential_energy(&self, q: &Vector2<f64>) -> f64 {
        -9.0 * q[0].cos() - 4.0 * q[1].cos() + 1.5 * (q[0] - q[1]).powi(2)
    }
}

/// The 2R arm with viscous friction b = diag(0.4, 0.2) q̇ \[N·m·s\].
struct DampedArm(Reach2R);

impl Dynamics<2> for DampedArm {
    fn mass(&self, q: &Vector2<f64>) -> Matrix2<f64> {
        self.0.mass(q)
    }
    fn velocity_product(&self, q: &Vector2<f64>, qd: &Vector2<f64>) -> Vector2<f64> {
        self.0.velocity_product(q, qd)
    }
    fn gravity(&self, q: &Vector2<f64>) -> Vector2<f64> {
        self.0.gravity(q)
    }
    fn potential_energy(&self, q: &Vector2<f64>) -> f64 {
        self.0.potential_energy(q)
    }
    fn dissipation(&self, _: &Vector2<f64>, qd: &Vector2<f64>) -> Vector2<f64> {
        vector![0.4 * qd[0], 0.2 * qd[1]]
    }
}

fn run<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    (mut q, mut qd): State<N>,
    u: &SVector<f64, N>,
    h: f64,
    steps: usize,
    integrator: Integrator,
) -> State<N> {
    for _ in 0..steps {
        (q, qd) = integrator.step(system, &q, &qd, u, h).unwrap();
    }
    (q, qd)
}

/// The slope of log error over log h by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<_> = points.iter().map(|(h, e)| (h.ln(), e.ln())).collect();
    let (x, y) = logs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
        / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// The worked example: τ = 0, h = 1 ms, 10 s from rest at (π/4, π/2).
#[test]
fn energy_drift_rk4() {
    let arm = Reach2R::worked_example();
    let drift = |integrator| {
        let (q0, zero) = (vector![PI / 4.0, PI / 2.0], Vector2::zeros());
        energy_drift(&arm, &q0, &zero, &zero, 1e-3, 10_000, integrator).unwrap()
    };
    let (rk4, semi, explicit) = (
        drift(Integrator::RungeKutta4),
        drift(Integrator::SemiImplicitEuler),
        drift(Integrator::ExplicitEuler),
    );
    println!("rk4 {rk4:.2e}   semi-implicit Euler {semi:.2e}   explicit Euler {explicit:.2e}");
    assert!(rk4 < 1e-6, "{rk4:e}");
    assert!(explicit > 1e-3, "{explicit:e}");
    // 1.22e-8, by two independent computations of the same definition.
    assert!((rk4 - 1.22e-8).abs() < 0.01e-8, "{rk4:e}");
}

/// The measured order of every method, over 1 s of the 2R arm swinging below the horizontal. The motion is
/// too short and too low in energy for chaos to matter. Steps are short enough for the leading error term to
/// dominate and long enough for errors far above round-off. They are 2⁻⁷…2⁻¹¹ s at order 1, 2⁻⁵…2⁻⁹ at 2,
/// 2⁻⁵…2⁻⁸ at 4. Friction and a held force do not reduce the order of a method.
#[test]
fn measured_order_is_stated_order() {
    let arm = Reach2R::worked_example();
    let damped = DampedArm(arm);
    let start = (vector![-1.2, 0.5], vector![0.4, -0.3]);
    let cases: [(&str, &dyn Dynamics<2>, Vector2<f64>); 2] =
        [("free", &arm, Vector2::zeros()), ("forced and damped", &damped, vector![2.0, -0.5])];
    for (name, system, u) in cases {
        // RK4's error at h = 1/8192 s is (1/32)⁴ of its error at the shortest step tested.
        let exact = run(system, start, &u, 1.0 / 8192.0, 8192, Integrator::RungeKutta4);
        for row in Integrator::ALL {
            let halvings = match row.order() {
                1 => 7..=11,
                2 => 5..=9,
                _ => 5..=8,
            };
            let errors: Vec<(f64, f64)> = halvings
                .map(|k| {
                    let steps = 1_usize << k;
                    let h = 1.0 / steps as f64;
                    let end = run(system, start, &u, h, steps, row);
                    (h, ((end.0 - exact.0).norm_squared() + (end.1 - exact.1).norm_squared()).sqrt())
                })
                .collect();
            let measured = slope(&errors);
            println!("{name:>18} {row:>22}: order {measured:.3}");
            let stated = f64::from(row.order());
            assert!((measured - stated).abs() < 0.1 * stated, "{name}, {row}: {measured} from {errors:?}");
        }
    }
}

/// Step, flip, step, flip: the reversible methods return to the start to round-off; the others do not.
#[test]
fn reversible_methods_return_to_start() {
    let arm = Reach2R::worked_example();
    // A step of 50 ms, so that a defect of order h⁶ is clearly above round-off.
    let (q0, qd0, u, h) = (vector![0.4, 1.1], vector![1.5, -2.0], vector![3.0, -1.0], 0.05);
    for row in Integrator::ALL {
        let (q1, qd1) = row.step(&arm, &q0, &qd0, &u, h).unwrap();
        let (q2, qd2) = row.step(&arm, &q1, &-qd1, &u, h).unwrap();
        let defect = (q2 - q0).amax().max((-qd2 - qd0).amax());
        println!("{row:>22}: comes back to {defect:.1e}");
        if row.reversible() {
            // Four solves of the mass matrix, κ(M) ≈ 10, on numbers of size 2.
            assert!(defect < 1e-13, "{row}: {defect:e}");
        } else {
            assert!(defect > 1e-8, "{row} is reversible after all? {defect:e}");
        }
    }
}

/// max |JᵀΩJ − Ω| of one step's map (q, p) → (q, p).
fn symplectic_defect(
    system: &dyn Dynamics<2>,
    row: Integrator,
    q: Vector2<f64>,
    p: Vector2<f64>,
    h: f64,
) -> f64 {
    let map = |x: Vector4<f64>| {
        let (q, p) = (vector![x[0], x[1]], vector![x[2], x[3]]);
        let qd = solve_mass(&system.mass(&q), &p).unwrap();
        let (q, qd) = row.step(system, &q, &qd, &Vector2::zeros(), h).unwrap();
        let p = system.mass(&q) * qd;
        vector![q[0], q[1], p[0], p[1]]
    };
    let x = vector![q[0], q[1], p[0], p[1]];
    let mut jacobian = Matrix4::zeros();
    for k in 0..4 {
        // Five-point differences of step 1e-4: error about 1e-11 from the fifth derivative, 1e-13 rounding.
        let at = |t: f64| {
            let mut y = x;
            y[k] += 1e-4 * t;
            map(y)
        };
        let column = ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * 1e-4);
        jacobian.set_column(k, &column);
    }
    let mut omega = Matrix4::zeros();
    for i in 0..2 {
        omega[(i, i + 2)] = 1.0;
        omega[(i + 2, i)] = -1.0;
    }
    (jacobian.transpose() * omega * jacobian - omega).amax()
}

/// The Jacobian of the step in (q, p) is a symplectic matrix exactly for the systems that the method states.
#[test]
fn symplectic_methods_preserve_form() {
    let arm = Reach2R::worked_example();
    let (q, p, h) = (vector![0.4, 1.1], vector![2.0, -1.0], 0.1);
    for row in Integrator::ALL {
        let constant = symplectic_defect(&CoupledPendulums, row, q, p, h);
        let varying = symplectic_defect(&arm, row, q, p, h);
        println!("{row:>22}: defect {constant:.1e} for constant M, {varying:.1e} for M(q)");
        let (keeps_constant, keeps_varying) = match row.symplectic() {
            Symplectic::Never => (false, false),
            Symplectic::WhereMassIsConstant => (true, false),
            Symplectic::Always => (true, true),
        };
        for (keeps, defect) in [(keeps_constant, constant), (keeps_varying, varying)] {
            // Either the error of the differences or a real defect, O(h²) for the Euler methods, O(h⁶) for
            // RK4.
            assert!(if keeps { defect < 1e-9 } else { defect > 1e-7 }, "{row}: {defect:e}");
        }
    }
}

/// h L((q₀+q₁)/2, (q₁−q₀)/h), from the two energies only.
fn discrete_lagrangian<S: Scalar>(system: &impl Lagrangian<2>, q0: [S; 2], q1: [S; 2], h: f64) -> S {
    let middle = [0, 1].map(|i| (q0[i] + q1[i]).scale(0.5));
    let v = [0, 1].map(|i| (q1[i] - q0[i]).scale(1.0 / h));
    let mass = system.mass_over(&middle);
    let mut twice_kinetic = S::zero();
    for i in 0..2 {
        for j in 0..2 {
            twice_kinetic += v[i] * mass[i][j] * v[j];
        }
    }
    (twice_kinetic.scale(0.5) - system.potential_over(&middle)).scale(h)
}

/// The step is variational: p₀ = −D₁L_d and p₁ = D₂L_d, with the derivatives of L_d by dual numbers. L_d
/// shares neither the Coriolis matrix nor the solver with the step.
#[test]
fn variational_step_solves_discrete_euler_lagrange_equations() {
    let arm = Reach2R::worked_example();
    for (k, h) in [(1.0_f64, 1e-3), (2.0, 0.01), (3.0, 0.05), (4.0, 0.05), (5.0, 0.1)] {
        let (q0, qd0) = (vector![1.3 * k, -0.7 * k], vector![(2.0 * k).sin(), (3.0 * k).cos() * 2.0]);
        let (q1, qd1) = variational_midpoint_step(&arm, &q0, &qd0, &Vector2::zeros(), h).unwrap();
        let ends: [Dual<f64, 4>; 4] = Dual::variables(&[q0[0], q0[1], q1[0], q1[1]]);
        let d = discrete_lagrangian(&arm, [ends[0], ends[1]], [ends[2], ends[3]], h).gradient;
        let (p0, p1) = (arm.mass(&q0) * qd0, arm.mass(&q1) * qd1);
        // (q₁−q₀)/h carries the rounding of q over h: 1e-15/1e-3 at the shortest step.
        let tolerance = 1e-15 * 10.0 * (1.0 + q0.amax()) / h;
        assert!((p0 + vector![d[0], d[1]]).amax() < tolerance, "state {k}: p0 {p0:?}, D1 {d:?}");
        assert!((p1 - vector![d[2], d[3]]).amax() < tolerance, "state {k}: p1 {p1:?}, D2 {d:?}");
    }
}

/// Steps use a system only through its methods. A closed form and the same arm by the Lagrange recipe move
/// alike, three joints are reversible as two are, and a `dyn` system works.
#[test]
fn steps_are_independent_of_formulation() {
    let arm = Reach2R::worked_example();
    let recipe = FromLagrangian(arm);
    let (start, zero) = ((vector![0.4, 1.1], vector![1.5, -2.0]), Vector2::zeros());
    let arm3: Box<dyn Dynamics<3>> = Box::new(PlanarArm::reach_3r());
    let start3 = (vector![0.4, 1.1, -0.6], vector![1.5, -2.0, 1.0]);
    for row in Integrator::ALL {
        let (a, b) = (run(&arm, start, &zero, 0.01, 50, row), run(&recipe, start, &zero, 0.01, 50, row));
        // Half a second: rounding grows with the sensitivity of the motion, well below a factor of 100.
        assert!((a.0 - b.0).amax() < 1e-12 && (a.1 - b.1).amax() < 1e-12, "{row}: {a:?} {b:?}");
        let end = run(&*arm3, start3, &vector![1.0, 0.5, 0.1], 0.01, 50, row);
        let back = run(&*arm3, (end.0, -end.1), &vector![1.0, 0.5, 0.1], 0.01, 50, row);
        let defect = (back.0 - start3.0).amax();
        assert_eq!(defect < 1e-11, row.reversible(), "{row}: 3R comes back to {defect:e}");
    }
}

/// On a horizontal table q1 is cyclic: the variational steps conserve its momentum, Runge–Kutta only
/// approximately.
#[test]
fn cyclic_momentum_is_conserved() {
    let table = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 0.0);
    let start = (vector![0.3, 1.2], vector![2.0, -5.0]);
    let momentum = |(q, qd): State<2>| (table.mass(&q) * qd)[0];
    let change = |row| {
        let end = run(&table, start, &Vector2::zeros(), 0.01, 100_000, row);
        ((momentum(end) - momentum(start)) / momentum(start)).abs()
    };
    let (midpoint, yoshida, rk4) = (
        change(Integrator::VariationalMidpoint),
        change(Integrator::VariationalYoshida4),
        change(Integrator::RungeKutta4),
    );
    println!(
        "cyclic momentum after 1e5 steps: midpoint {midpoint:.1e}, Yoshida {yoshida:.1e}, RK4 {rk4:.1e}"
    );
    // 1e5 roundings of a few ε would be 1e-10 in the worst case, with one sign; at random, 1e-13.
    assert!(midpoint < 1e-11 && yoshida < 1e-11, "{midpoint:e} {yoshida:e}");
    assert!(rk4 > 1e-9, "{rk4:e}");
}

/// With motors and friction the account closes: E = E₀ + work − dissipated to the order of the method.
#[test]
fn energy_account_closes_with_work_and_dissipation() {
    let damped = DampedArm(Reach2R::worked_example());
    let (q0, zero, u) = (vector![-1.0, 0.4], Vector2::zeros(), vector![4.0, -1.0]);
    let imbalance = |h: f64, steps| {
        let run = energy_run(&damped, &q0, &zero, &u, h, steps, Integrator::RungeKutta4).unwrap();
        assert!(run.energy_account.dissipated() > 0.5 && run.energy_account.work().abs() > 0.5, "{run:?}");
        // The energy is not constant: without the two entries the imbalance would be this large.
        assert!(run.energy_account.drift() * run.energy_account.scale() > 0.5, "{run:?}");
        run.energy_account.max_imbalance()
    };
    let (coarse, fine) = (imbalance(0.02, 150), imbalance(0.01, 300));
    println!("imbalance {coarse:.2e} J at 20 ms, {fine:.2e} J at 10 ms");
    assert!(fine < 1e-5, "{fine:e}");
    // Order 4: a factor of about 16, up to the next term.
    assert!((12.0..24.0).contains(&(coarse / fine)), "{}", coarse / fine);
}

/// E₀ = 0 does not divide by zero: the scale is then the largest kinetic energy.
#[test]
fn drift_is_defined_at_zero_energy() {
    let arm = Reach2R::worked_example();
    // Released from rest, horizontal: V = 0, K = 0.
    let (q0, zero) = (vector![0.0, 0.0], Vector2::zeros());
    assert_eq!(arm.energy(&q0, &zero), 0.0);
    let run = energy_run(&arm, &q0, &zero, &zero, 1e-3, 2000, Integrator::RungeKutta4).unwrap();
    assert!(run.energy_account.scale() > 10.0, "{run:?}");
    assert!(run.energy_account.drift() < 1e-7 && run.energy_account.drift() > 0.0, "{run:?}");
    // At rest in equilibrium nothing moves, with any integrator.
    let hang = vector![-PI / 2.0, 0.0];
    for row in Integrator::ALL {
        assert!(energy_drift(&arm, &hang, &zero, &zero, 1e-3, 100, row).unwrap() < 1e-15, "{row}");
    }
}

/// Failures are errors, never numbers.
#[test]
fn failures_name_quantity_and_entry() {
    let arm = Reach2R::worked_example();
    let (q0, qd0, zero) = (vector![0.0, 0.5], vector![3.0, -4.0], Vector2::zeros());
    let error = Integrator::VariationalMidpoint.step(&arm, &q0, &qd0, &zero, 2.0).unwrap_err();
    assert!(matches!(error, IntegratorError::NotConverged { step: 2.0, .. }), "{error}");
    assert!(error.to_string().contains("smaller step"), "{error}");
    for row in Integrator::ALL {
        let error = row.step(&arm, &vector![0.0, f64::NAN], &qd0, &zero, 1e-3).unwrap_err();
        assert!(error.to_string().contains("q[1] is NaN; every number must be finite"), "{row}: {error}");
    }
    let blown = energy_run(&arm, &q0, &qd0, &zero, 1e3, 100, Integrator::ExplicitEuler).unwrap_err();
    assert!(
        matches!(blown, IntegratorError::EnergyNotFinite { .. } | IntegratorError::NotFinite { .. }),
        "{blown}"
    );
    let unknown = Integrator::from_name("rk5").unwrap_err();
    assert!(unknown.to_string().contains("\"rk5\"") && unknown.to_string().contains("rk4"), "{unknown}");
    for row in Integrator::ALL {
        assert_eq!(row.name().parse::<Integrator>(), Ok(row));
    }
}

/// A step of zero length is a mistake in the program; the panic states its value.
#[test]
#[should_panic(expected = "must be positive and finite, got -0.001 s")]
fn negative_step_panics() {
    let (arm, zero) = (Reach2R::worked_example(), Vector2::zeros());
    let _ = rk4_step(&arm, &zero, &zero, &zero, -1e-3);
}
