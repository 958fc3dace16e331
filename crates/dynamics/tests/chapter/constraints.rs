//! Pfaffian constraints against hand-derived formulas, a second solver, and long runs.

use dynamics::{
    ConstraintError, ConstraintProjections, Dynamics, FromRows, KnifeEdge, Pfaffian, PfaffianOver,
    PlanarBody, Reach2R, Reach3R, RowFactor, StabilizedConstraint, constrained_forward_dynamics,
    constrained_forward_dynamics_by_lu, constrained_rk4_step, reduced_acceleration,
};
use nalgebra::{SMatrix, SVector, Vector1, Vector2, Vector3, matrix, vector};
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{Scalar, SplitMix64};

fn random_vector<const N: usize>(random: &mut SplitMix64, size: f64) -> SVector<f64, N> {
    SVector::from_fn(|_, _| random.uniform(-size, size))
}

/// A random state of the knife edge: (model, q, q̇, u), with a q̇ that need not satisfy the constraint.
fn random_chassis(random: &mut SplitMix64) -> (KnifeEdge, Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let mut knife = KnifeEdge::new(random.uniform(0.5, 5.0), random.uniform(0.1, 2.0));
    knife.body.a_g = random.uniform(0.0, 9.81);
    (knife, random_vector(random, 3.0), random_vector(random, 3.0), random_vector(random, 10.0))
}

/// A random symmetric positive definite M with condition number up to about 1e4, through M = B Bᵀ + δ.
fn random_mass<const N: usize>(random: &mut SplitMix64) -> SMatrix<f64, N, N> {
    let b = SMatrix::<f64, N, N>::from_fn(|_, _| random.uniform(-1.0, 1.0));
    b * b.transpose() + SMatrix::identity() * 1e-3
}

/// A system with a constant mass matrix and a given bias force.
struct Constant<const N: usize> {
    mass: SMatrix<f64, N, N>,
    bias: SVector<f64, N>,
}

impl<const N: usize> Dynamics<N> for Constant<N> {
    fn mass(&self, _: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        self.mass
    }
    fn velocity_product(&self, _: &SVector<f64, N>, _: &SVector<f64, N>) -> SVector<f64, N> {
        SVector::zeros()
    }
    fn gravity(&self, _: &SVector<f64, N>) -> SVector<f64, N> {
        self.bias
    }
    fn potential_energy(&self, q: &SVector<f64, N>) -> f64 {
        self.bias.dot(q)
    }
}

#[test]
fn knife_edge_matches_its_closed_forms() {
    let mut random = SplitMix64::new(30);
    for sample in 0..30 {
        let (knife, q, qd, u) = random_chassis(&mut random);
        let (rows, rate) = (knife.rows(&q), knife.rows_rate(&q, &qd));
        let (qdd, lambda) = constrained_forward_dynamics(&knife.body, &q, &qd, &u, &rows, &rate).unwrap();
        let p = ConstraintProjections::new(&knife.body.mass(&q), &rows).unwrap();
        let at = format!("seed 30 sample {sample}: {knife:?} q {q:?} qd {qd:?} u {u:?}");
        // The allowed 1e-9 is far above rounding (1e-13 here).
        assert!((lambda[0] - knife.side_force(&q, &qd, &u)).abs() < 1e-9, "{at}");
        assert!((qdd - knife.acceleration(&q, &qd, &u)).norm() < 1e-9, "{at}");
        assert!((p.velocity - KnifeEdge::projection(&q)).norm() < 1e-9, "{at}");
        let reduced = vector![qdd[0] * q[2].cos() + qdd[1] * q[2].sin(), qdd[2]];
        assert!((reduced - knife.reduced_acceleration(&q, &u)).norm() < 1e-9, "{at}");
    }
}

/// The hand-written Ȧ, the dual-number Ȧ and a central difference of A along q̇ agree.
#[test]
fn row_rates_agree_three_ways() {
    let mut random = SplitMix64::new(31);
    for sample in 0..30 {
        let (knife, q, qd, _) = random_chassis(&mut random);
        let by_hand = knife.rows_rate(&q, &qd);
        assert!((by_hand - FromRows(knife).rows_rate(&q, &qd)).norm() < 1e-14, "sample {sample}");
        let step = 1e-6;
        let difference = (knife.rows(&(q + qd * step)) - knife.rows(&(q - qd * step))) / (2.0 * step);
        // Truncation step²|q̇|³/6 and rounding ε/step are both below 1e-9.
        assert!((by_hand - difference).norm() < 1e-9, "sample {sample}");
    }
}

#[test]
fn pure_torque_turns_in_place() {
    let knife = KnifeEdge::new(3.0, 0.4);
    let (mut q, mut qd) = (vector![1.0, -2.0, 0.7], Vector3::zeros());
    let u = vector![0.0, 0.0, 0.2];
    for _ in 0..2000 {
        let step = constrained_rk4_step(&knife.body, &knife, &q, &qd, &u, 1e-3).unwrap();
        (q, qd) = (step.q, step.qd);
    }
    // Constant torque: θ = θ0 + ½ (u3/I) t², which RK4 integrates exactly; 2000 roundings remain.
    assert!((q - vector![1.0, -2.0, 0.7 + 0.5 * 0.5 * 4.0]).norm() < 1e-12, "{q:?}");
    assert!((qd - vector![0.0, 0.0, 1.0]).norm() < 1e-12, "{qd:?}");
}

#[test]
fn floor_exerts_centripetal_force() {
    let knife = KnifeEdge::new(2.0, 0.5);
    let (v, turn) = (3.0, 1.5);
    for heading in [0.0, 0.4, 2.0, -1.3] {
        let q = vector![0.0, 0.0, heading];
        let qd = KnifeEdge::velocity(&q, v, turn);
        let (rows, rate) = (knife.rows(&q), knife.rows_rate(&q, &qd));
        let (qdd, lambda) =
            constrained_forward_dynamics(&knife.body, &q, &qd, &Vector3::zeros(), &rows, &rate).unwrap();
        let floor = rows.transpose() * lambda;
        let left = vector![-heading.sin(), heading.cos(), 0.0];
        assert!((floor - left * (2.0 * v * turn)).norm() < 1e-12, "heading {heading}: {floor:?}");
        assert!((qdd - left * (v * turn)).norm() < 1e-12, "heading {heading}: {qdd:?}");
        assert!(floor.dot(&qd).abs() < 1e-12, "the floor does no work");
    }
}

/// 60 s at 1 ms under a force that turns with time: A q̇ stays at rounding level, and E − E0 equals the work.
#[test]
fn sixty_seconds_keep_constraint_and_energy_balance() {
    let knife = KnifeEdge::new(2.0, 0.5);
    let h = 1e-3;
    let force = |t: f64| vector![1.5 * (0.8 * t).cos(), -1.1 * (0.5 * t).sin(), 0.6 * (1.3 * t).cos()];
    let (mut q, start) = (vector![0.0, 0.0, 0.3], KnifeEdge::velocity(&vector![0.0, 0.0, 0.3], 1.0, 0.8));
    let mut qd = start;
    let (mut work, mut worst, mut drift, mut removed) = (0.0, 0.0_f64, 0.0_f64, 0.0_f64);
    for i in 0..60_000 {
        let u = force(f64::from(i) * h);
        let step = constrained_rk4_step(&knife.body, &knife, &q, &qd, &u, h).unwrap();
        // u is constant over the step, so its work is u·Δq exactly.
        work += u.dot(&(step.q - q));
        (q, qd) = (step.q, step.qd);
        worst = worst.max((knife.rows(&q) * qd)[0].abs());
        drift = drift.max(step.drift[0].abs());
        removed += step.energy_removed;
    }
    let imbalance = knife.body.energy(&q, &qd) - knife.body.energy(&vector![0.0, 0.0, 0.3], &start) - work;
    println!(
        "A qd {worst:e}, before projection {drift:e}, removed {removed:e} J, imbalance {imbalance:e} J, work {work}"
    );
    assert!(worst < 1e-12, "A qd reached {worst:e}");
    // The error of a step is of order h⁵ = 1e-15 times rates of order 10.
    assert!(drift < 1e-12, "one step drifted {drift:e}");
    // h⁴ = 1e-12 times 60 s times rates to the fifth; 1e-9 leaves two digits of margin.
    assert!(imbalance.abs() < 1e-9, "the energy account is off by {imbalance:e} J");
    assert!(removed < 1e-20, "the projection took {removed:e} J");
    assert!(work.abs() > 0.1, "the run must do work for the check to be meaningful: {work}");
}

/// A spinning blade on a slope, exactly: θ = ωt, v̇ = −a sin θ, so v = (a/ω)(cos ωt − 1). Then
/// x = (a/ω)(t/2 + sin 2ωt/(4ω) − sin ωt/ω), y = (a/ω²)(½ sin² ωt + cos ωt − 1). It never descends below
/// 2a/ω², but drifts across the slope at a/(2ω).
#[test]
fn spinning_blade_on_slope_does_not_descend() {
    let (a, w) = (3.0, 2.0);
    let knife = KnifeEdge { body: PlanarBody { m: 1.3, i_zz: 0.2, a_g: a } };
    let (mut q, mut qd) = (Vector3::zeros(), vector![0.0, 0.0, w]);
    let (h, mut worst, mut lowest, mut drift) = (1e-3, 0.0_f64, 0.0_f64, 0.0_f64);
    for i in 1..=60_000 {
        let step = constrained_rk4_step(&knife.body, &knife, &q, &qd, &Vector3::zeros(), h).unwrap();
        (q, qd) = (step.q, step.qd);
        let t = f64::from(i) * h;
        let (s, c) = (w * t).sin_cos();
        let x = a / w * (t / 2.0 + (2.0 * w * t).sin() / (4.0 * w) - s / w);
        let y = a / (w * w) * (0.5 * s * s + c - 1.0);
        worst = worst.max((q - vector![x, y, w * t]).norm());
        lowest = lowest.min(q[1]);
        drift = drift.max((knife.rows(&q) * qd)[0].abs());
    }
    println!("60 s on a slope: off the exact path by {worst:e} m, lowest {lowest} m, A qd {drift:e}");
    // (ωh)⁴/120 = 1e-13 relative per unit of a t/ω ~ 90 m; 1e-9 m has two digits of margin for factors ω⁵.
    assert!(worst < 1e-9, "{worst:e}");
    assert!((lowest + 2.0 * a / (w * w)).abs() < 1e-5, "the turning point is met within a step: {lowest}");
    assert!(drift < 1e-12, "{drift:e}");
}

/// Two driven wheels: their power is u·q̇, and they cause no side force of the floor.
#[test]
fn wheel_forces_cause_no_side_force() {
    let mut random = SplitMix64::new(32);
    for sample in 0..30 {
        let (knife, q, qd, _) = random_chassis(&mut random);
        let map = KnifeEdge::wheel_map(&q, 0.3);
        let f: Vector2<f64> = random_vector(&mut random, 10.0);
        let at = format!("seed 32 sample {sample}");
        assert!(((map * f).dot(&qd) - f.dot(&(map.transpose() * qd))).abs() < 1e-12, "{at}");
        let allowed = KnifeEdge::velocity(&q, 1.2, 0.7);
        let hubs = map.transpose() * allowed;
        assert!((hubs - vector![1.2 - 0.7 * 0.3, 1.2 + 0.7 * 0.3]).norm() < 1e-14, "{at}");
        let (rows, rate) = (knife.rows(&q), knife.rows_rate(&q, &qd));
        let lambda = |u: Vector3<f64>| {
            constrained_forward_dynamics(&knife.body, &q, &qd, &u, &rows, &rate).unwrap().1[0]
        };
        assert!((lambda(map * f) - lambda(Vector3::zeros())).abs() < 1e-11, "{at}");
    }
}

/// With 0.5 m/s of side slip at the start, the stabilised constraint reduces it as 0.5 e^(−γt).
#[test]
fn stabilised_constraint_reduces_side_slip() {
    let knife = KnifeEdge::new(2.0, 0.5);
    let (rate, h) = (5.0, 1e-3);
    let constraint = StabilizedConstraint { constraint: knife, rate };
    let (mut q, mut qd) = (vector![0.0, 0.0, 0.3], Vector3::zeros());
    qd += knife.rows(&q).transpose() * 0.5 + KnifeEdge::velocity(&q, 1.0, 0.9);
    // A fourth-order step written for this test: the derivatives of (q, q̇) at four stages.
    let slope = |q: Vector3<f64>, qd: Vector3<f64>| {
        let (rows, rate) = (constraint.rows(&q), constraint.rows_rate(&q, &qd));
        (qd, constrained_forward_dynamics(&knife.body, &q, &qd, &Vector3::zeros(), &rows, &rate).unwrap().0)
    };
    for i in 1..=2000 {
        let (v1, a1) = slope(q, qd);
        let (v2, a2) = slope(q + v1 * (h / 2.0), qd + a1 * (h / 2.0));
        let (v3, a3) = slope(q + v2 * (h / 2.0), qd + a2 * (h / 2.0));
        let (v4, a4) = slope(q + v3 * h, qd + a3 * h);
        q += (v1 + (v2 + v3) * 2.0 + v4) * (h / 6.0);
        qd += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
        let slip = (knife.rows(&q) * qd)[0];
        let expected = 0.5 * (-rate * f64::from(i) * h).exp();
        // RK4: (γh)⁴ = 6e-10 relative per unit of γt = 10, /120.
        assert!((slip - expected).abs() < 1e-9, "step {i}: {slip} {expected}");
    }
}

/// A system without rows is the free system.
#[test]
fn zero_rows_do_not_constrain_motion() {
    let arm = Reach2R::worked_example();
    let (q, qd, u) = (vector![0.3, -0.4], vector![1.0, 2.0], vector![0.5, -0.5]);
    let none = SMatrix::<f64, 0, 2>::zeros();
    let (qdd, lambda) = constrained_forward_dynamics(&arm, &q, &qd, &u, &none, &none).unwrap();
    assert!((qdd - arm.forward(&q, &qd, &u)).norm() < 1e-13 && lambda.is_empty());
}

/// Without the projection a run with a coarse step leaves the constraint; with it, it does not.
#[test]
fn projection_holds_constraint() {
    let knife = KnifeEdge::new(2.0, 0.5);
    let start = vector![0.0, 0.0, 0.0];
    let run = |project: bool| {
        let (mut q, mut qd) = (start, KnifeEdge::velocity(&start, 2.0, 3.0));
        for _ in 0..6000 {
            let step = constrained_rk4_step(&knife.body, &knife, &q, &qd, &Vector3::zeros(), 0.01).unwrap();
            // Undo the projection: q̇ plus M⁻¹Aᵀ(AM⁻¹Aᵀ)⁻¹ times the drift, with A of unit length and M = m
            // here.
            let back = knife.rows(&step.q).transpose() * step.drift;
            (q, qd) = (step.q, if project { step.qd } else { step.qd + back });
        }
        (knife.rows(&q) * qd)[0].abs()
    };
    let (with, without) = (run(true), run(false));
    println!("A qd after 60 s at 10 ms: projected {with:e}, plain RK4 {without:e}");
    assert!(with < 1e-12, "projected run: {with:e}");
    assert!(without > 1e-9, "plain run: {without:e}");
}

/// The drift of one step is of order h⁵: halving h divides it by 32.
#[test]
fn drift_of_one_step_is_of_fifth_order() {
    let knife = KnifeEdge::new(2.0, 0.5);
    let q = vector![0.0, 0.0, 0.3];
    let qd = KnifeEdge::velocity(&q, 2.0, 3.0);
    let u = vector![1.0, -0.7, 0.9];
    let drift = |h: f64| constrained_rk4_step(&knife.body, &knife, &q, &qd, &u, h).unwrap().drift[0].abs();
    let order = (drift(0.04) / drift(0.02)).log2();
    println!("order of the drift {order}");
    // The next term is h⁶, a relative change of order h between the two steps: 0.3 is sufficient.
    assert!((order - 5.0).abs() < 0.3, "order {order}");
}

/// The step reports the energy that the projection removes from K. It is never negative, and of order h¹⁰.
#[test]
fn removed_energy_is_reported_and_of_tenth_order() {
    let knife = KnifeEdge::new(2.0, 0.5);
    let q = vector![0.0, 0.0, 0.3];
    let qd = KnifeEdge::velocity(&q, 2.0, 3.0);
    let u = vector![1.0, -0.7, 0.9];
    let removed = |h: f64| {
        let step = constrained_rk4_step(&knife.body, &knife, &q, &qd, &u, h).unwrap();
        // A is of unit length and M = m on x and y, so the velocity before was q̇ + Aᵀ(drift).
        let before = step.qd + knife.rows(&step.q).transpose() * step.drift;
        let lost = knife.body.energy(&step.q, &before) - knife.body.energy(&step.q, &step.qd);
        // The loss is a difference of energies of about 6 J: rounding leaves 1e-14 J.
        assert!((lost - step.energy_removed).abs() < 1e-14, "h {h}: {lost:e} {:e}", step.energy_removed);
        step.energy_removed
    };
    let (coarse, fine) = (removed(0.2), removed(0.1));
    println!("removed {coarse:e} J at 0.2 s, {fine:e} J at 0.1 s");
    assert!(coarse > 1e-9, "the coarse step must lose more than rounding: {coarse:e}");
    // Twice the exponent of the drift; the h⁶ term of the drift changes it by a few times h.
    assert!(((coarse / fine).log2() - 10.0).abs() < 1.0, "order {}", (coarse / fine).log2());
}

/// One projection satisfies the rows to rounding even if κ(M) = 1e8 and the velocity violates them strongly.
#[test]
fn one_projection_is_sufficient() {
    let mut random = SplitMix64::new(15);
    for sample in 0..100 {
        let b =
            SMatrix::<f64, 4, 4>::from_fn(|_, c| random.uniform(-1.0, 1.0) * if c == 0 { 1e-4 } else { 1.0 });
        let mass = b * b.transpose();
        let rows = SMatrix::<f64, 2, 4>::from_fn(|_, _| random.uniform(-1.0, 1.0));
        let qd: SVector<f64, 4> = random_vector(&mut random, 2.0);
        let allowed = RowFactor::new(&mass, &rows).unwrap().project_velocity(&qd);
        // A product of rows of length ≤ 2 with P q̇ rounds at 2 ε |P q̇| per row; the bound is ten times
        // that.
        let bound = 40.0 * f64::EPSILON * (allowed.norm() + 1.0);
        let slip = (rows * allowed).norm();
        assert!(slip < bound, "seed 15 sample {sample}: {slip:e} over {bound:e}");
    }
}

/// Two rows 1e-7 apart: P stays a projection to rounding of its size; a single Gram–Schmidt pass fails this.
#[test]
fn nearly_parallel_rows_give_a_projection() {
    let mut random = SplitMix64::new(16);
    for sample in 0..100 {
        let mass = random_mass::<4>(&mut random) + SMatrix::identity();
        let (a, b) = (
            SMatrix::<f64, 1, 4>::from_fn(|_, _| random.uniform(-1.0, 1.0)),
            SMatrix::<f64, 1, 4>::from_fn(|_, _| random.uniform(-1.0, 1.0)),
        );
        let p =
            ConstraintProjections::new(&mass, &SMatrix::<f64, 2, 4>::from_rows(&[a, a + b * 1e-7])).unwrap();
        // κ(M) is below 10: a few dozen roundings of numbers of order 1.
        let defect = (p.velocity * p.velocity - p.velocity).norm();
        assert!(defect < 1e-13, "seed 16 sample {sample}: {defect:e}");
    }
}

/// Gram–Schmidt in M⁻¹ against LU of the whole KKT matrix, and against the equation.
fn solvers_agree<const K: usize, const N: usize>(seed: u64) {
    let mut random = SplitMix64::new(seed);
    for sample in 0..100 {
        let system = Constant { mass: random_mass(&mut random), bias: random_vector(&mut random, 10.0) };
        let mut rows = SMatrix::<f64, K, N>::from_fn(|_, _| random.uniform(-1.0, 1.0));
        if K > 1 && sample % 4 == 0 {
            // Nearly dependent: the last row differs from the first by 1e-4 to 1e-7.
            let gap = 10f64.powf(random.uniform(-7.0, -4.0));
            let near = rows.row(0) + rows.row(K - 1) * gap;
            rows.set_row(K - 1, &near);
        }
        let rate = SMatrix::<f64, K, N>::from_fn(|_, _| random.uniform(-1.0, 1.0));
        let (q, qd, u) = (
            random_vector(&mut random, 1.0),
            random_vector(&mut random, 2.0),
            random_vector(&mut random, 10.0),
        );
        let at = format!("seed {seed} sample {sample} K {K} N {N}");
        let (qdd, lambda) = constrained_forward_dynamics(&system, &q, &qd, &u, &rows, &rate).unwrap();
        let (qdd_lu, lambda_lu) =
            constrained_forward_dynamics_by_lu(&system, &q, &qd, &u, &rows, &rate).unwrap();
        // Forward error: κ ε with κ the condition of the KKT matrix, from its singular values.
        let mut kkt = nalgebra::DMatrix::<f64>::zeros(N + K, N + K);
        kkt.view_mut((0, 0), (N, N)).copy_from(&system.mass);
        kkt.view_mut((0, N), (N, K)).copy_from(&-rows.transpose());
        kkt.view_mut((N, 0), (K, N)).copy_from(&rows);
        let singular = kkt.singular_values();
        let tolerance = 10.0 * (N + K) as f64 * f64::EPSILON * singular.max() / singular.min();
        let size = qdd_lu.norm() + lambda_lu.norm();
        assert!((qdd - qdd_lu).norm() <= tolerance * size, "{at}: {:e}", (qdd - qdd_lu).norm() / size);
        assert!((lambda - lambda_lu).norm() <= tolerance * size, "{at}");
        // The reduced form is P q̈, by another route to the free acceleration.
        let p = ConstraintProjections::new(&system.mass, &rows).unwrap();
        let reduced = reduced_acceleration(&system, &q, &qd, &u, &rows).unwrap();
        let free = system.forward(&q, &qd, &u);
        let condition = tolerance * (size + free.norm());
        assert!((p.velocity * qdd - reduced).norm() <= condition, "{at}: reduced form");
    }
}

#[test]
fn two_solvers_agree() {
    solvers_agree::<1, 2>(1);
    solvers_agree::<1, 3>(2);
    solvers_agree::<2, 3>(3);
    solvers_agree::<3, 6>(4);
    solvers_agree::<4, 4>(5);
}

/// The properties of P and P_u, with P_u recomputed from its definition by an explicit inverse.
fn projection_properties<const K: usize, const N: usize>(seed: u64) {
    let mut random = SplitMix64::new(seed);
    for sample in 0..100 {
        let mass = random_mass::<N>(&mut random);
        let rows = SMatrix::<f64, K, N>::from_fn(|_, _| random.uniform(-1.0, 1.0));
        let qd: SVector<f64, N> = random_vector(&mut random, 2.0);
        let p = ConstraintProjections::new(&mass, &rows).unwrap();
        let eigen = nalgebra::DMatrix::from_column_slice(N, N, mass.as_slice()).symmetric_eigenvalues();
        let at = format!("seed {seed} sample {sample} K {K} N {N}");
        // P is oblique: its entries, and so its rounding, grow with √κ(M); M⁻¹ brings κ(M) ε.
        let tolerance = 100.0 * f64::EPSILON * eigen.max() / eigen.min();

        let dense = |m: &[f64], r: usize, c: usize| nalgebra::DMatrix::from_column_slice(r, c, m);
        let (a, m) = (dense(rows.as_slice(), K, N), dense(mass.as_slice(), N, N));
        let inverse = m.clone().try_inverse().unwrap();
        let schur = (&a * &inverse * a.transpose()).try_inverse().unwrap();
        let identity = nalgebra::DMatrix::<f64>::identity(N, N);
        let p_u = &identity - a.transpose() * &schur * &a * &inverse;
        let found = dense(p.force.as_slice(), N, N);
        // (AM⁻¹Aᵀ)⁻¹ has its own condition number, up to κ(M) κ(A)², which scales the tolerance.
        let schur_condition = schur.norm() * (&a * &inverse * a.transpose()).norm();
        assert!((&found - &p_u).norm() <= tolerance * schur_condition * p_u.norm(), "{at}: (10.18)");
        let p_by_10_19 = &inverse * &found * &m;
        let velocity = dense(p.velocity.as_slice(), N, N);
        assert!((&velocity - p_by_10_19).norm() <= tolerance * p_u.norm() * 10.0, "{at}: (10.19)");

        assert_eq!(p.velocity, p.force.transpose(), "{at}");
        assert!((rows * p.velocity).norm() <= tolerance, "{at}: A P {:e}", (rows * p.velocity).norm());
        assert!((p.velocity * p.velocity - p.velocity).norm() <= tolerance * p_u.norm(), "{at}: P² = P");
        // The trace of a projection is its rank, and so is the number of non-zero singular values.
        assert!((p.velocity.trace() - (N - K) as f64).abs() <= tolerance, "{at}");
        let rank = velocity.singular_values().iter().filter(|&&s| s > 0.5).count();
        assert_eq!(rank, N - K, "{at}: nonzero singular values of a projection are at least 1");
        let allowed = p.velocity * qd;
        assert!(allowed.dot(&(mass * (qd - allowed))).abs() <= tolerance, "{at}: M-orthogonal");
    }
}

#[test]
fn projections_have_their_properties() {
    projection_properties::<1, 3>(11);
    projection_properties::<2, 3>(12);
    projection_properties::<2, 6>(13);
    projection_properties::<5, 6>(14);
}

/// A point mass on a rod from the origin: row \[x, y\].
#[derive(Clone, Copy)]
struct Rod;

impl PfaffianOver<1, 3> for Rod {
    fn rows_over<S: Scalar>(&self, q: &[S; 3]) -> [[S; 3]; 1] {
        [[q[0], q[1], S::zero()]]
    }
}

/// The tension by hand: m l φ̇² + m g cos φ with φ from the downward vertical, pulling inwards, so λ = −T/l.
#[test]
fn pendulum_rod_tension() {
    let (m, a_g) = (1.7, 9.81);
    let bob = PlanarBody { m, i_zz: 1.0, a_g };
    let mut random = SplitMix64::new(41);
    for sample in 0..30 {
        let (l, phi, rate) = (random.uniform(0.3, 2.0), random.uniform(-3.0, 3.0), random.uniform(-4.0, 4.0));
        let q = vector![l * phi.sin(), -l * phi.cos(), 0.0];
        let qd = vector![l * rate * phi.cos(), l * rate * phi.sin(), 0.0];
        let (rows, rows_rate) = (FromRows(Rod).rows(&q), FromRows(Rod).rows_rate(&q, &qd));
        let (qdd, lambda) =
            constrained_forward_dynamics(&bob, &q, &qd, &Vector3::zeros(), &rows, &rows_rate).unwrap();
        let tension = m * l * rate * rate + m * a_g * phi.cos();
        assert!((lambda[0] + tension / l).abs() < 1e-11 * (1.0 + tension.abs() / l), "sample {sample}");
        // φ̈ = −(g/l) sin φ.
        let angular = (qdd[0] * phi.cos() + qdd[1] * phi.sin()) / l;
        assert!((angular + a_g / l * phi.sin()).abs() < 1e-11 * (1.0 + a_g / l), "sample {sample}");
    }
}

/// A swinging pendulum in x, y against the same pendulum in its angle.
#[test]
fn planar_pendulum_matches_pendulum_in_its_angle() {
    let bob = PlanarBody { m: 1.0, i_zz: 1.0, a_g: 9.81 };
    let (mut q, mut qd) = (vector![1.0, 0.0, 0.0], Vector3::zeros());
    // φ from the downward vertical, l = 1: M = 1, V = −g cos φ.
    let angle = AnglePendulum;
    let (mut phi, mut phi_rate) = (vector![core::f64::consts::FRAC_PI_2], Vector1::zeros());
    let h = 1e-3;
    for _ in 0..10_000 {
        let step = constrained_rk4_step(&bob, &FromRows(Rod), &q, &qd, &Vector3::zeros(), h).unwrap();
        (q, qd) = (step.q, step.qd);
        (phi, phi_rate) = dynamics::rk4_step(&angle, &phi, &phi_rate, &Vector1::zeros(), h).unwrap();
    }
    let gap = (q.xy() - vector![phi[0].sin(), -phi[0].cos()]).norm();
    let length = (q.xy().norm() - 1.0).abs();
    println!("after 10 s: gap {gap:e} m, rod length off by {length:e} m");
    // h⁴ = 1e-12 times (g/l)^(5/2) ≈ 300 times 10 s gives 3e-9 for each run.
    assert!(gap < 1e-8, "{gap:e}");
    assert!(length < 1e-8, "{length:e}");
}

struct AnglePendulum;

impl Dynamics<1> for AnglePendulum {
    fn mass(&self, _: &Vector1<f64>) -> SMatrix<f64, 1, 1> {
        matrix![1.0]
    }
    fn velocity_product(&self, _: &Vector1<f64>, _: &Vector1<f64>) -> Vector1<f64> {
        Vector1::zeros()
    }
    fn gravity(&self, q: &Vector1<f64>) -> Vector1<f64> {
        vector![9.81 * q[0].sin()]
    }
    fn potential_energy(&self, q: &Vector1<f64>) -> f64 {
        -9.81 * q[0].cos()
    }
}

fn dependent<const K: usize, const N: usize>(
    mass: &SMatrix<f64, N, N>,
    rows: &SMatrix<f64, K, N>,
) -> (usize, Vec<(usize, Vec<usize>)>, String) {
    match RowFactor::new(mass, rows) {
        Err(error @ ConstraintError::DependentRows { .. }) => {
            let text = error.to_string();
            let ConstraintError::DependentRows { rank, rows } = error else { unreachable!() };
            (rank, rows.into_iter().map(|row| (row.row, row.combination_of)).collect(), text)
        }
        other => panic!("expected dependent rows, got {other:?}"),
    }
}

#[test]
fn dependent_rows_are_named() {
    let mass = matrix![2.0, 0.3, 0.1; 0.3, 1.0, 0.2; 0.1, 0.2, 0.5];
    let (a, b) = (matrix![1.0, 2.0, -1.0], matrix![0.5, 0.0, 3.0]);
    let stack = |rows: [SMatrix<f64, 1, 3>; 3]| SMatrix::<f64, 3, 3>::from_rows(&rows);

    let (rank, rows, text) = dependent(&mass, &stack([a, b, a * 2.0 - b * 0.7]));
    assert_eq!((rank, rows), (2, vec![(2, vec![0, 1])]));
    assert!(text.contains("rank 2 only: row 2 is a combination of rows [0, 1]"), "{text}");

    let (rank, rows, text) = dependent(&mass, &stack([a, a * -3.0, b]));
    assert_eq!((rank, rows), (2, vec![(1, vec![0])]));
    assert!(text.contains("row 1 is a multiple of row 0"), "{text}");

    let (rank, rows, text) = dependent(&mass, &stack([a, b * 0.0, b * 0.0]));
    assert_eq!((rank, rows), (1, vec![(1, vec![]), (2, vec![])]));
    assert!(text.contains("row 1 is zero, row 2 is zero"), "{text}");

    // Two coordinates do not allow a third independent row.
    let (rank, rows, _) = dependent(&matrix![1.0, 0.0; 0.0, 1.0], &matrix![1.0, 0.0; 1.0, 1.0; 0.0, 2.0]);
    assert_eq!((rank, rows), (2, vec![(2, vec![0, 1])]));
}

/// Neither the scale of a row nor the unit of a coordinate affects dependence.
#[test]
fn dependence_is_independent_of_scale() {
    let mut random = SplitMix64::new(51);
    for sample in 0..100 {
        // Coordinates in units from nm to km: M and A change together as q = D q′.
        let unit = Vector3::from_fn(|_, _| 10f64.powf(random.uniform(-6.0, 6.0)));
        let scale = SMatrix::<f64, 3, 3>::from_diagonal(&unit);
        let mass = scale * random_mass::<3>(&mut random) * scale;
        let a = SMatrix::<f64, 1, 3>::from_fn(|_, _| random.uniform(-1.0, 1.0)) * scale;
        let b = SMatrix::<f64, 1, 3>::from_fn(|_, _| random.uniform(-1.0, 1.0)) * scale;
        let size = 10f64.powf(random.uniform(-8.0, 8.0));
        let independent = SMatrix::<f64, 2, 3>::from_rows(&[a, b * size]);
        assert!(RowFactor::new(&mass, &independent).is_ok(), "seed 51 sample {sample}");
        let c = (a * 0.4 + b * 1.3) * size;
        let (rank, rows, _) = dependent(&mass, &SMatrix::<f64, 3, 3>::from_rows(&[a, b, c]));
        assert_eq!((rank, rows), (2, vec![(2, vec![0, 1])]), "seed 51 sample {sample}");
    }
}

/// Rows of 1e±200, whose squares exceed the range of f64, are factored and named like any other row.
#[test]
fn extreme_rows_neither_overflow_nor_vanish() {
    let arm = Reach3R::reach_3r();
    let (q, qd, u) = (vector![0.3, -0.7, 1.1], vector![1.0, -0.5, 0.2], vector![1.0, 2.0, 3.0]);
    let (a, b) = (matrix![1.0, 2.0, -1.0], matrix![0.5, 0.0, 3.0]);
    let stack = |x: f64, y: f64| SMatrix::<f64, 2, 3>::from_rows(&[a * x, b * y]);
    let solve = |x: f64, y: f64| {
        let rows = stack(x, y);
        constrained_forward_dynamics(&arm, &q, &qd, &u, &rows, &(rows * 0.1)).unwrap()
    };
    let ((plain, lambda), (scaled, scaled_lambda)) = (solve(1.0, 1.0), solve(1e200, 1e-200));
    // The same constraint gives the same motion, and the same constraint force with λ in inverse proportion.
    assert!((plain - scaled).norm() < 1e-12 * plain.norm(), "{plain} {scaled}");
    assert!((scaled_lambda[0] * 1e200 - lambda[0]).abs() < 1e-12 * lambda.norm());
    assert!((scaled_lambda[1] * 1e-200 - lambda[1]).abs() < 1e-12 * lambda.norm());
    let rows = SMatrix::<f64, 3, 3>::from_rows(&[a * 1e200, b * 1e-200, a - b]);
    let (rank, rows, _) = dependent(&arm.mass(&q), &rows);
    assert_eq!((rank, rows), (2, vec![(2, vec![0, 1])]));
}

#[test]
fn invalid_input_is_an_error() {
    let arm = Reach2R::worked_example();
    let (q, zero) = (vector![0.3, 0.4], Vector2::zeros());
    let rows = matrix![0.0, 1.0];
    let nan = vector![0.0, f64::NAN];
    let call = |q, rows, rate| constrained_forward_dynamics(&arm, &q, &zero, &zero, &rows, &rate);
    let error = call(nan, rows, rows * 0.0).unwrap_err();
    assert!(
        matches!(&error, ConstraintError::Dynamics(IntegratorError::Input(input)) if input.to_string().starts_with("q[1] is NaN")),
        "{error}"
    );
    let error = call(q, matrix![f64::INFINITY, 0.0], rows * 0.0).unwrap_err();
    assert_eq!(error, ConstraintError::NonFiniteRow { matrix: "A", row: 0, column: 0 });
    let error = call(q, rows, matrix![0.0, f64::NAN]).unwrap_err();
    assert_eq!(error, ConstraintError::NonFiniteRow { matrix: "Ȧ", row: 0, column: 1 });
    let massless = Reach2R { m2: 0.0, i2: 0.0, ..arm };
    let error = constrained_forward_dynamics(&massless, &q, &zero, &zero, &rows, &(rows * 0.0)).unwrap_err();
    assert!(
        matches!(error, ConstraintError::Dynamics(IntegratorError::SingularMass { coordinate: 1, .. })),
        "{error}"
    );
}
