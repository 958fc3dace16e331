//! Control, timing of paths, linearisation and the inertia ellipse against independent computations.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use dynamics::{
    Dynamics, HoldRun, InertiaEllipse, Lagrangian, Path, PathDynamics, PdHold, REACH_REPLAY_SPEED,
    REACH_TORQUE_LIMITS, Reach2R, Reach3R, fastest_constant_speed, hold, linearize, linearize_by_differences,
    peak_torque, reach_replay, symmetric_eigen,
};
use nalgebra::{DMatrix, SMatrix, SVector, Vector1, Vector2, matrix, vector};
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::SplitMix64;

fn random_vector<const N: usize>(random: &mut SplitMix64, size: f64) -> SVector<f64, N> {
    SVector::from_fn(|_, _| random.uniform(-size, size))
}

/// Joint 1 of a flat arm whose joint 2 is locked at `q2`: one coordinate with the constant inertia M11(q2).
struct Locked {
    arm: Reach2R,
    q2: f64,
}

impl Dynamics<1> for Locked {
    fn mass(&self, q: &Vector1<f64>) -> SMatrix<f64, 1, 1> {
        matrix![self.arm.mass(&vector![q[0], self.q2])[(0, 0)]]
    }
    fn velocity_product(&self, _: &Vector1<f64>, _: &Vector1<f64>) -> Vector1<f64> {
        Vector1::zeros()
    }
    fn gravity(&self, _: &Vector1<f64>) -> Vector1<f64> {
        Vector1::zeros()
    }
    fn potential_energy(&self, _: &Vector1<f64>) -> f64 {
        0.0
    }
}

/// Kp = 40, Kd = 2·0.7·√(40·1): ζ = 0.7 folded (M11 = 1), 0.7/√3 = 0.40 stretched (M11 = 3).
#[test]
fn gain_is_critical_if_folded_and_oscillates_if_stretched() {
    let arm = Reach2R { a_g: 0.0, ..Reach2R::worked_example() };
    let gain = PdHold {
        target: vector![0.3],
        stiffness: vector![40.0],
        damping: vector![1.4 * 40f64.sqrt()],
        limits: vector![REACH_TORQUE_LIMITS[0]],
    };
    let run = HoldRun { step: 1e-4, steps: 60_000, band: 0.3 * 0.02 };
    let observe = |q2: f64, zeta: f64| {
        let system = Locked { arm, q2 };
        assert!((gain.damping_ratio(&system, &vector![0.0])[0] - zeta).abs() < 1e-12, "ζ at q2 = {q2}");
        let report = hold(&system, &gain, &vector![0.0], &vector![0.0], &run).unwrap();
        // A linear oscillator of one coordinate overshoots a step by exp(−πζ/√(1−ζ²)).
        let expected = 0.3 * (-PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        // Holding τ over 1e-4 s delays it by 5e-5 s: a relative change ω·5e-5 ≈ 3e-4 of the damping.
        assert!((report.overshoot[0] - expected).abs() < 1e-3 * 0.3, "{} {expected}", report.overshoot[0]);
        assert!((report.peak_torque[0] - 12.0).abs() < 1e-12, "the first torque, Kp·0.3, is the largest");
        (report.overshoot[0] / 0.3, report.settling_time.unwrap())
    };
    let (crisp, crisp_time) = observe(PI, 0.7);
    let (rings, rings_time) = observe(0.0, 0.7 / 3f64.sqrt());
    println!(
        "overshoot {crisp:.4} settled {crisp_time:.3} s; stretched {rings:.4} settled {rings_time:.3} s"
    );
    assert!(crisp < 0.05 && rings > 0.2);
    assert!(rings_time > 2.0 * crisp_time);
}

/// The same two poses with both joints free: the stretched arm overshoots more and settles later.
#[test]
fn free_arm_oscillates_more_if_stretched() {
    let arm = Reach2R { a_g: 0.0, ..Reach2R::worked_example() };
    let run = HoldRun { step: 1e-3, steps: 8000, band: 0.006 };
    let observe = |q2: f64| {
        let control = PdHold {
            target: vector![0.3, q2],
            stiffness: vector![40.0, 40.0],
            damping: vector![1.4 * 40f64.sqrt(), 1.4 * 40f64.sqrt()],
            limits: REACH_TORQUE_LIMITS,
        };
        let report = hold(&arm, &control, &vector![0.0, q2], &Vector2::zeros(), &run).unwrap();
        (report.overshoot[0] / 0.3, report.settling_time.unwrap())
    };
    let (folded, stretched) = (observe(PI), observe(0.0));
    println!("folded {folded:?}, stretched {stretched:?}");
    assert!(stretched.0 > 2.0 * folded.0, "{stretched:?} {folded:?}");
    assert!(stretched.1 > 1.5 * folded.1, "{stretched:?} {folded:?}");
}

/// The law by hand at one state, and the cut-off on both sides.
#[test]
fn law_matches_hand_calculation() {
    let arm = Reach2R::worked_example();
    let control = PdHold {
        target: vector![FRAC_PI_4, FRAC_PI_2],
        stiffness: vector![10.0, 5.0],
        damping: vector![2.0, 1.0],
        limits: REACH_TORQUE_LIMITS,
    };
    let q = control.target - vector![0.1, -0.2];
    // g(q*) = 9.81 (2 cos 45° + ½ cos 135°, ½ cos 135°), then Kp·(0.1, −0.2) − Kd·(0.5, −1).
    let root = 0.5f64.sqrt();
    let expected = vector![9.81 * 1.5 * root + 1.0 - 1.0, -9.81 * 0.5 * root - 1.0 + 1.0];
    assert!((control.demand(&arm, &q, &vector![0.5, -1.0]) - expected).norm() < 1e-13);
    let far = |error: f64| control.torque(&arm, &(control.target - vector![error, error]), &Vector2::zeros());
    assert_eq!((far(100.0), far(-100.0)), (vector![20.0, 12.0], vector![-20.0, -12.0]));
}

#[test]
#[should_panic(expected = "the torque limit of joint 1 must not be negative, got -1")]
fn negative_limit_panics() {
    let one = vector![1.0, 1.0];
    let control = PdHold { target: one, stiffness: one, damping: one, limits: vector![1.0, -1.0] };
    control.torque(&Reach2R::worked_example(), &one, &one);
}

#[test]
fn gravity_compensation_holds_without_error() {
    let arm = Reach2R::worked_example();
    let target = vector![1.2, -0.7];
    let control = PdHold {
        target,
        stiffness: vector![60.0, 30.0],
        damping: vector![20.0, 6.0],
        limits: REACH_TORQUE_LIMITS,
    };
    assert!(control.overloaded_joints(&arm).is_empty());
    let run = HoldRun { step: 1e-3, steps: 20_000, band: 0.01 };
    let report = hold(&arm, &control, &vector![1.5, -0.2], &Vector2::zeros(), &run).unwrap();
    // The slowest closed-loop mode decays at about Kp/Kd = 3/s or faster: e⁻⁶⁰ is below rounding.
    assert!((report.q - target).norm() < 1e-10 && report.qd.norm() < 1e-10, "{report:?}");
    assert!((0..2).all(|i| report.peak_torque[i] <= REACH_TORQUE_LIMITS[i]));
    assert!(report.settling_time.unwrap() < 2.0, "{report:?}");
}

/// With the arm held level, its weight is 24.5 N·m on joint 1. That exceeds 20, so the arm sinks, and the
/// check reports it in advance.
#[test]
fn overloaded_joint_is_named_and_sinks() {
    let arm = Reach2R::worked_example();
    let control = PdHold {
        target: vector![0.0, 0.0],
        stiffness: vector![100.0, 50.0],
        damping: vector![20.0, 10.0],
        limits: REACH_TORQUE_LIMITS,
    };
    assert_eq!(control.overloaded_joints(&arm), vec![0]);
    // It falls at about (24.5 − 20)/3 = 1.5 rad/s² initially: 0.19 rad in 0.5 s.
    let run = HoldRun { step: 1e-3, steps: 500, band: 0.01 };
    let report = hold(&arm, &control, &vector![0.0, 0.0], &Vector2::zeros(), &run).unwrap();
    assert_eq!(report.peak_torque[0], 20.0);
    assert!(
        report.peak_demand[0] > 20.0 && report.settling_time.is_none() && report.q[0] < -0.1,
        "{report:?}"
    );
}

/// a s̈ + b ṡ² + c against inverse dynamics of q̇ = q′ṡ, q̈ = q″ṡ² + q′s̈, derivatives by differences.
#[test]
fn path_dynamics_is_inverse_dynamics_along_path() {
    let (arm, path) = (Reach2R::worked_example(), reach_replay());
    let mut random = SplitMix64::new(61);
    for sample in 0..50 {
        let (s, v, a) = (random.uniform(0.0, TAU), random.uniform(-4.0, 4.0), random.uniform(-5.0, 5.0));
        let point = path.at(s);
        let torque = PathDynamics::new(&arm, &point).torque(v, a);
        let direct = arm.inverse(&point.q, &(point.dq * v), &(point.ddq * (v * v) + point.dq * a));
        assert!((torque - direct).norm() < 1e-12 * (1.0 + direct.norm()), "seed 61 sample {sample}");
        // q(t), differenced in t with s(t) = s + v t + ½ a t²; h = 1e-4: truncation 1e-8·|q⁗| ≈ 1e-4.
        let h = 1e-4;
        let at = |t: f64| path.at(s + v * t + 0.5 * a * t * t).q;
        let (q0, q1, q2) = (at(-h), at(0.0), at(h));
        let timed = arm.inverse(&q1, &((q2 - q0) / (2.0 * h)), &((q2 - q1 * 2.0 + q0) / (h * h)));
        assert!((torque - timed).norm() < 1e-4, "seed 61 sample {sample}: {:e}", (torque - timed).norm());
    }
}

#[test]
fn velocity_part_grows_with_square_of_speed() {
    let (arm, path) = (Reach2R::worked_example(), reach_replay());
    for i in 0..40 {
        let dynamics = PathDynamics::new(&arm, &path.at(TAU * f64::from(i) / 40.0));
        for k in [0.5, 2.0, 3.0] {
            // The same timing k times faster: ṡ by k, s̈ by k². The torque less gravity must follow.
            let (slow, fast) = (dynamics.torque(1.3, 0.7), dynamics.torque(1.3 * k, 0.7 * k * k));
            let difference = (fast - dynamics.c) - (slow - dynamics.c) * (k * k);
            assert!(difference.norm() < 1e-12 * (1.0 + fast.norm()), "sample {i}, k {k}");
        }
    }
}

#[test]
fn replay_curve_is_within_limits_at_1x_and_not_at_2x() {
    let (arm, path) = (Reach2R::worked_example(), reach_replay());
    let (once, twice) = (
        peak_torque(&arm, &path, REACH_REPLAY_SPEED, 2000),
        peak_torque(&arm, &path, 2.0 * REACH_REPLAY_SPEED, 2000),
    );
    println!("peaks at 1x {once:?}, at 2x {twice:?}");
    for i in 0..2 {
        // A margin of a tenth of the limit on either side, so that sampling and rounding do not matter.
        assert!(once[i] < 0.9 * REACH_TORQUE_LIMITS[i], "joint {i} at 1x: {}", once[i]);
        assert!(twice[i] > 1.1 * REACH_TORQUE_LIMITS[i], "joint {i} at 2x: {}", twice[i]);
    }
    // The numbers in the documentation of the curve.
    assert!(
        (once - vector![8.5, 4.9]).abs().max() < 0.05 && (twice - vector![49.7, 18.9]).abs().max() < 0.05
    );
    // The curve is closed with both derivatives.
    let (start, end) = (path.at(0.0), path.at(TAU));
    assert!((start.q - end.q).norm() + (start.dq - end.dq).norm() + (start.ddq - end.ddq).norm() < 1e-14);
    // The fastest speed lies between; it reaches a limit there and exceeds it just above.
    let fastest = fastest_constant_speed(&arm, &path, &REACH_TORQUE_LIMITS, 2000).unwrap();
    println!("fastest {fastest} = {} x", fastest / REACH_REPLAY_SPEED);
    let load = |speed: f64| peak_torque(&arm, &path, speed, 2000).component_div(&REACH_TORQUE_LIMITS).max();
    assert!((1.0..2.0).contains(&(fastest / REACH_REPLAY_SPEED)));
    assert!((load(fastest) - 1.0).abs() < 1e-12);
    assert!(fastest_constant_speed(&arm, &path, &vector![1.0, 12.0], 100).is_none());
}

fn exact_matches_differences<L: Lagrangian<N> + Dynamics<N>, const N: usize>(system: &L, seed: u64) {
    let mut random = SplitMix64::new(seed);
    let mut worst = 0.0_f64;
    for sample in 0..50 {
        let (q, qd, u): (SVector<f64, N>, SVector<f64, N>, SVector<f64, N>) = (
            random_vector(&mut random, 3.0),
            random_vector(&mut random, 2.0),
            random_vector(&mut random, 5.0),
        );
        let exact = linearize(system, &q, &qd, &u).unwrap();
        // Richardson's combination of steps h and 2h cancels the h² error of each.
        let h = 1e-4;
        let (fine, coarse) = (
            linearize_by_differences(system, &q, &qd, &u, h).unwrap(),
            linearize_by_differences(system, &q, &qd, &u, 2.0 * h).unwrap(),
        );
        let at = format!("seed {seed} sample {sample}: q {q:?} qd {qd:?} u {u:?}");
        let mut compare = |exact: &SMatrix<f64, N, N>,
                           fine: &SMatrix<f64, N, N>,
                           coarse: &SMatrix<f64, N, N>| {
            // Rounding: κ(M) ε/h relative, with κ up to 1e3 (3 joints) 2e-9; truncation h⁴ = 1e-16 times
            // fifth derivatives, at most about 1e5.
            let extrapolated = (fine * 4.0 - coarse) / 3.0;
            let error = (exact - extrapolated).norm() / (1.0 + exact.norm());
            assert!(error < 2e-9, "{at}: {error:e}");
            worst = worst.max(error);
            // The error of the plain difference is its h² term, which the coarse one shows:
            // |coarse − fine| = 3 h² term.
            assert!((exact - fine).norm() <= (coarse - fine).norm() + 2e-9 * (1.0 + exact.norm()), "{at}");
        };
        compare(&exact.by_position, &fine.by_position, &coarse.by_position);
        compare(&exact.by_velocity, &fine.by_velocity, &coarse.by_velocity);
        // ∂q̈/∂q̇ = −2 M⁻¹C with the model's own C and an explicit inverse: no differences, so κ(M) ε.
        let inverse = DMatrix::from_column_slice(N, N, system.mass(&q).as_slice()).try_inverse().unwrap();
        let coriolis = DMatrix::from_column_slice(N, N, system.coriolis_matrix(&q, &qd).as_slice());
        let found = DMatrix::from_column_slice(N, N, exact.by_velocity.as_slice());
        assert!((found + inverse * coriolis * 2.0).norm() < 1e-12 * (1.0 + exact.by_velocity.norm()), "{at}");
        // q̈ is affine in u: forward(u + e_k) − forward(u) is column k exactly, to rounding.
        for k in 0..N {
            let mut push = u;
            push[k] += 1.0;
            let column = system.forward(&q, &qd, &push) - system.forward(&q, &qd, &u);
            let scale = 1.0 + system.forward(&q, &qd, &u).norm() + exact.by_force.norm();
            assert!((column - exact.by_force.column(k)).norm() < 1e-11 * scale, "{at}");
        }
    }
    println!("N = {N}: exact and extrapolated differences differ by at most {worst:e} relative");
}

#[test]
fn linearisation_is_exact() {
    exact_matches_differences(&Reach2R::worked_example(), 71);
    exact_matches_differences(&Reach3R::reach_3r(), 72);
}

/// Hanging at rest, stretched: ∂q̈/∂q = −M⁻¹ ∂²V/∂q², with the Hessian of V by hand.
#[test]
fn linearisation_at_rest_is_the_pendulum_matrix() {
    let arm = Reach2R::worked_example();
    let q = vector![-FRAC_PI_2, 0.0];
    let at = linearize(&arm, &q, &Vector2::zeros(), &Vector2::zeros()).unwrap();
    // V = −19.62 cos x − 4.905 cos(x + y) about the vertical.
    let hessian = matrix![19.62 + 4.905, 4.905; 4.905, 4.905];
    let expected = -arm.mass(&q).try_inverse().unwrap() * hessian;
    assert!((at.by_position - expected).norm() < 1e-12, "{}", at.by_position);
    assert!(at.by_velocity.norm() < 1e-14);
    let error = linearize(&arm, &vector![f64::NAN, 0.0], &Vector2::zeros(), &Vector2::zeros()).unwrap_err();
    assert!(
        matches!(&error, IntegratorError::Input(input) if input.to_string().starts_with("q[0] is NaN")),
        "{error}"
    );
}

#[test]
fn inertia_ellipse_of_the_worked_example() {
    let arm = Reach2R::worked_example();
    let mass = arm.mass(&vector![FRAC_PI_4, FRAC_PI_2]);
    let ellipse = InertiaEllipse::new(&mass).unwrap();
    // By hand: M = [[2, 1/3], [1/3, 1/3]] has eigenvalues 7/6 ± √(25/36 + 1/9) = 7/6 ± √29/6.
    let (small, large) = ((7.0 - 29f64.sqrt()) / 6.0, (7.0 + 29f64.sqrt()) / 6.0);
    let expected = vector![small.sqrt().recip(), large.sqrt().recip()];
    assert!((ellipse.semi_axes - expected).norm() < 1e-14, "{:?}", ellipse.semi_axes);
    assert!((ellipse.semi_axes - vector![1.928, 0.696]).abs().max() < 5e-4);
    for i in 0..64 {
        let angle = TAU * f64::from(i) / 64.0;
        let qd = ellipse.point(&vector![angle.cos(), angle.sin()]);
        assert!((qd.dot(&(mass * qd)) - 1.0).abs() < 1e-14, "point {i}");
        let joule = InertiaEllipse::of_energy(&mass, 1.0).unwrap().point(&vector![angle.cos(), angle.sin()]);
        assert!(
            (arm.kinetic_energy(&vector![FRAC_PI_4, FRAC_PI_2], &joule) - 1.0).abs() < 1e-14,
            "point {i}"
        );
        // A rotation of the whole arm changes nothing.
        assert_eq!(InertiaEllipse::new(&arm.mass(&vector![angle, FRAC_PI_2])).unwrap(), ellipse);
    }
    let error = InertiaEllipse::new(&matrix![1.0, 1.0; 1.0, 1.0]).unwrap_err();
    assert!(matches!(error, IntegratorError::SingularMass { coordinate: 1, .. }), "{error}");
}

/// Jacobi's eigenvalues against the QR algorithm of nalgebra, and the decomposition against the matrix.
fn eigen_agrees<const N: usize>(seed: u64) {
    let mut random = SplitMix64::new(seed);
    for sample in 0..100 {
        let b = SMatrix::<f64, N, N>::from_fn(|_, _| random.uniform(-1.0, 1.0));
        let symmetric = if sample % 2 == 0 { b + b.transpose() } else { b * b.transpose() };
        let (values, vectors) = symmetric_eigen(&symmetric);
        let tolerance = 10.0 * N as f64 * f64::EPSILON * (1.0 + symmetric.norm());
        let rebuilt = vectors * SMatrix::from_diagonal(&values) * vectors.transpose();
        assert!((rebuilt - symmetric).norm() < tolerance, "seed {seed} sample {sample}");
        assert!((vectors.transpose() * vectors - SMatrix::identity()).norm() < tolerance, "sample {sample}");
        let mut found: Vec<f64> = values.iter().copied().collect();
        let dense = DMatrix::from_column_slice(N, N, symmetric.as_slice());
        let mut expected: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
        found.sort_by(f64::total_cmp);
        expected.sort_by(f64::total_cmp);
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < tolerance, "seed {seed} sample {sample}: {a} {b}");
        }
    }
}

#[test]
fn jacobi_eigenvalues_agree_with_qr() {
    eigen_agrees::<1>(81);
    eigen_agrees::<2>(82);
    eigen_agrees::<3>(83);
    eigen_agrees::<7>(84);
    // Graded, as with coordinates in m and μm: κ = 1e12, but both eigenvalues are accurate to a few ε of
    // themselves.
    let graded = matrix![1e12, 0.5e6; 0.5e6, 1.0];
    let large = f64::midpoint(1e12, 1.0) + ((1e12 - 1.0_f64) / 2.0).hypot(0.5e6);
    let small = 0.75e12 / large;
    let values = symmetric_eigen(&graded).0;
    assert!((values.max() / large - 1.0).abs() < 1e-15 && (values.min() / small - 1.0).abs() < 2e-15);
    let (values, vectors) = symmetric_eigen(&matrix![3.0, 0.0; 0.0, 5.0]);
    assert_eq!((values, vectors), (vector![3.0, 5.0], SMatrix::identity()));
}
