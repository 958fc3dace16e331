//! The discrete regulator against closed forms, published numbers, value iteration and its own definition.

use nalgebra::{DMatrix, dmatrix};
use robot_dynamics_control::{DlqrError, dlqr};
use robot_dynamics_number::SplitMix64;

/// A, B, Q, R.
type Problem = (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>, DMatrix<f64>);

fn random_matrix(random: &mut SplitMix64, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| random.uniform(-1.0, 1.0))
}

/// A with some growing modes, two forces, and a cost on every state, as for a robot about a pose.
fn random_problem(seed: u64) -> Problem {
    let mut random = SplitMix64::new(seed);
    let n = 1 + (seed % 14) as usize;
    let m = 1 + (seed % 3) as usize;
    let a = random_matrix(&mut random, n, n) * (1.5 / (n as f64).sqrt());
    let b = random_matrix(&mut random, n, m);
    let c = random_matrix(&mut random, n, n);
    let d = random_matrix(&mut random, m, m);
    let q = c.transpose() * &c + DMatrix::identity(n, n) * 0.1;
    let r = d.transpose() * &d + DMatrix::identity(m, m) * 0.1;
    (a, b, q, r)
}

/// Q + AᵀP(A − B K) with K of P: one step of value iteration.
fn one_more_step((a, b, q, r): &Problem, p: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let weighed = b.transpose() * p;
    let gain = (r + &weighed * b).cholesky().expect("positive definite").solve(&(weighed * a));
    (q + a.transpose() * p * (a - b * &gain), gain)
}

fn radius(m: &DMatrix<f64>) -> f64 {
    m.complex_eigenvalues().iter().map(|x| x.norm()).fold(0.0, f64::max)
}

/// b²P² + (r − a²r − b²q) P − q r = 0, its positive root.
#[test]
fn one_state_and_one_force_have_a_closed_form() {
    for (a, b, q, r) in
        [(1.3, 0.7, 2.0, 0.4), (0.2, -1.0, 1.0, 1.0), (-2.5, 0.01, 1e-3, 1e3), (0.9, 1.0, 0.0, 2.0)]
    {
        let one = |x: f64| dmatrix![x];
        let found =
            dlqr(&one(a), &one(b), &one(q), &one(r)).unwrap_or_else(|error| panic!("{a} {b}: {error}"));
        let linear: f64 = r * (a * a - 1.0) + b * b * q;
        let p = (linear + (linear * linear + 4.0 * b * b * q * r).sqrt()) / (2.0 * b * b);
        let k = b * p * a / (r + b * b * p);
        // A few roundings each; for a stable a with q = 0 the terms of the formula cancel.
        assert!((found.cost[0] - p).abs() <= 1e-14 * p.max(linear.abs() / (b * b)), "{} {p}", found.cost[0]);
        assert!((found.gain[0] - k).abs() <= 1e-14 * k.abs(), "{} {k}", found.gain[0]);
        assert!((found.spectral_radius - (a - b * k).abs()).abs() <= 1e-14);
    }
}

/// The example of MATLAB's documentation of `dare`, to its four decimals.
#[test]
fn gain_matches_published_example() {
    let (a, b) = (dmatrix![-0.9, -0.3; 0.7, 0.1], dmatrix![1.0; 1.0]);
    let found = dlqr(&a, &b, &dmatrix![1.0, 0.0; 0.0, 3.0], &dmatrix![0.1]).unwrap();
    let expected = dmatrix![4.7687, 0.9438; 0.9438, 3.2369];
    assert!((&found.cost - expected).amax() < 0.5e-4, "{}", found.cost);
    assert!((found.spectral_radius - 0.4460).abs() < 0.5e-4, "{}", found.spectral_radius);
}

/// P against 3000 steps of value iteration from P = Q, which shares no step with doubling. K, the residual of
/// the equation and the closed loop are checked as well. One step of value iteration forms AᵀPA, whose
/// rounding is n ε |A|²|P|. The remaining error shrinks by the square of the closed loop's radius in each
/// step.
#[test]
fn random_problems_match_value_iteration() {
    let mut worst: f64 = 0.0;
    for seed in 0..100 {
        let problem = random_problem(seed);
        let (a, b, q, r) = &problem;
        let found = dlqr(a, b, q, r).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let (again, gain) = one_more_step(&problem, &found.cost);
        let mut value = q.clone();
        for _ in 0..3000 {
            value = one_more_step(&problem, &value).0;
        }
        let n = a.nrows() as f64;
        let rounding = n * f64::EPSILON * a.norm_squared().max(1.0) * found.cost.norm();
        let kept = 1.0 - found.spectral_radius.powi(2);
        assert!((&again - &found.cost).norm() <= 10.0 * rounding, "seed {seed}");
        let off = (&value - &found.cost).norm();
        worst = worst.max(off * kept / rounding);
        assert!(off <= 10.0 * rounding / kept, "seed {seed}: {off:e} {rounding:e} {kept}");
        assert!((&gain - &found.gain).norm() <= 1e-12 * gain.norm(), "seed {seed}");
        let closed = radius(&(a - b * &found.gain));
        assert!(closed < 1.0 && (closed - found.spectral_radius).abs() < 1e-10, "seed {seed}: {closed}");
        assert!(found.cost == found.cost.transpose() && found.cost.symmetric_eigenvalues().min() > 0.0);
    }
    println!("worst {worst:.2e} of the allowed rounding");
}

/// x₀ᵀP x₀ is the cost of the run from x₀, and any other gain costs more.
#[test]
fn cost_is_minimal() {
    for seed in 0..30 {
        let (a, b, q, r) = random_problem(seed);
        let found = dlqr(&a, &b, &q, &r).unwrap();
        let mut random = SplitMix64::new(seed ^ 0xc057);
        let start = random_matrix(&mut random, a.nrows(), 1);
        let cost_of = |gain: &DMatrix<f64>| {
            let (mut x, mut sum) = (start.clone(), 0.0);
            for _ in 0..20_000 {
                let u = -(gain * &x);
                sum += x.dot(&(&q * &x)) + u.dot(&(&r * &u));
                x = &a * x + &b * u;
            }
            sum
        };
        let least = start.dot(&(&found.cost * &start));
        // The closed loops decay to 1e-12 within the run; the sum has as many roundings as steps.
        assert!((cost_of(&found.gain) - least).abs() <= 1e-10 * least, "seed {seed}");
        // A change of K by δ costs its square: for 1e-3 about 1e-6 of the cost.
        let other = &found.gain + random_matrix(&mut random, b.ncols(), a.nrows()) * 1e-3;
        assert!(cost_of(&other) > least * (1.0 + 1e-10), "seed {seed}");
    }
}

/// Steps of a thousandth and a millionth of a second: a closed loop close to 1 needs more doublings, and
/// keeps its accuracy. With h → 0 the gain of a double integrator converges to that in continuous time,
/// (√(q/r), √(2 √(q/r))).
#[test]
fn short_steps_converge_to_continuous_gain() {
    for h in [1e-3, 1e-6] {
        let (a, b) = (dmatrix![1.0, h; 0.0, 1.0], dmatrix![0.5 * h * h; h]);
        let (q, r) = (dmatrix![4.0 * h, 0.0; 0.0, 0.0], dmatrix![0.25 * h]);
        let found = dlqr(&a, &b, &q, &r).unwrap();
        let expected = dmatrix![4.0, 8f64.sqrt()];
        // Off by O(h) terms; the rounding of 1 + h is ε/h.
        let allowed = 10.0 * h + 10.0 * f64::EPSILON / h;
        assert!((&found.gain - expected).amax() <= allowed, "h {h}: {}", found.gain);
        assert!(found.spectral_radius < 1.0 - h);
    }
}

/// States and forces in other units, x = T y and u = S w, have the gain S⁻¹K T.
#[test]
fn gain_scales_with_units() {
    for seed in 0..40 {
        let (a, b, q, r) = random_problem(seed);
        // Powers of two cause no rounding.
        let power = |i: usize| ((7 * i % 41) as f64 - 20.0).exp2();
        let t = DMatrix::from_diagonal(&nalgebra::DVector::from_fn(a.nrows(), |i, _| power(i)));
        let s = DMatrix::from_diagonal(&nalgebra::DVector::from_fn(b.ncols(), |i, _| power(i + 3)));
        let inverse = t.map_diagonal(|x| 1.0 / x);
        let inverse = DMatrix::from_diagonal(&inverse);
        let found = dlqr(&a, &b, &q, &r).unwrap();
        let scaled = dlqr(&(&inverse * &a * &t), &(&inverse * &b * &s), &(&t * &q * &t), &(&s * &r * &s))
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let back = &s * &scaled.gain * &inverse;
        // Pivots are chosen by size, so other units change the order of elimination: κ(W) roundings.
        let off = (&back - &found.gain).amax();
        assert!(off <= 1e-9 * found.gain.amax(), "seed {seed}: {off:e}");
    }
}

fn message(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> String {
    dlqr(a, b, q, r).expect_err("no regulator").to_string()
}

#[test]
fn invalid_problems_are_errors() {
    let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.0; 0.1]);
    let (q, r) = (DMatrix::identity(2, 2), dmatrix![1.0]);
    assert!(dlqr(&a, &b, &q, &r).is_ok());
    let wide = DMatrix::zeros(2, 3);
    let none = DMatrix::zeros(0, 0);
    assert!(message(&wide, &b, &q, &r).starts_with("A is 2×3, it must be 2×2"));
    assert!(message(&a, &dmatrix![1.0], &q, &r).starts_with("B is 1×1, it must be 2×1"));
    assert!(message(&a, &b, &wide, &r).starts_with("Q is 2×3, it must be 2×2"));
    assert!(message(&a, &b, &q, &q).starts_with("R is 2×2, it must be 1×1"));
    assert!(message(&a, &DMatrix::zeros(2, 0), &q, &r).starts_with("B has no entries"));
    assert!(message(&none, &b, &q, &r).starts_with("A has no entries"));
    let refused = dlqr(&none, &b, &q, &r).unwrap_err();
    assert!(matches!(&refused, DlqrError::Input(input) if input.quantity == "A"), "{refused}");

    for (k, name) in ["A", "B", "Q", "R"].into_iter().enumerate() {
        let mut all = [a.clone(), b.clone(), q.clone(), r.clone()];
        let row = all[k].nrows() - 1;
        all[k][(row, 0)] = if k % 2 == 0 { f64::NAN } else { f64::INFINITY };
        let text = message(&all[0], &all[1], &all[2], &all[3]);
        assert_eq!(text, format!("{name}[{row}, 0] is not finite; every number must be"));
    }

    let skew = dmatrix![1.0, 0.5; 0.25, 1.0];
    let text = message(&a, &b, &skew, &r);
    assert_eq!(text, "Q[0, 1] and Q[1, 0] differ by 2.5e-1; Q must be symmetric");
    assert!(message(&a, &b, &dmatrix![1.0, 0.0; 0.0, -2.0], &r).contains("its smallest eigenvalue is -2e0"));
    for bad in [0.0, -1.0] {
        let text = message(&a, &b, &q, &dmatrix![bad]);
        assert!(
            text.starts_with(&format!("R is not positive definite, its smallest eigenvalue is {bad:e}")),
            "{text}"
        );
    }
    // Rank one, with a last pivot of rounding size: (0.1)² + (0.2)² and similar sums are not binary
    // fractions.
    let two = DMatrix::identity(2, 2);
    let rank_one = dmatrix![0.01, 0.03; 0.03, 0.09];
    assert!(message(&a, &two, &q, &rank_one).starts_with("R is not positive definite"));
    // Costs of different orders of magnitude are valid.
    assert!(dlqr(&a, &two, &q, &dmatrix![1e-12, 0.0; 0.0, 1e9]).is_ok());
}

/// If no gain exists, the error states the eigenvalue of the mode.
#[test]
fn error_names_unstabilisable_mode() {
    let r = dmatrix![1.0];
    let q = DMatrix::identity(2, 2);
    let check = |a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>| dlqr(a, b, q, &r).unwrap_err();
    // A mode of 1.5 that no force moves, with or without cost, and one of 1.
    let b = dmatrix![0.0; 1.0];
    for (mode, q) in [(1.5, &q), (1.0, &q), (-1.2, &q), (1.5, &dmatrix![0.0, 0.0; 0.0, 1.0])] {
        match check(&dmatrix![mode, 0.0; 0.3, 0.5], &b, q) {
            DlqrError::NotStabilizable { modulus, angle } => {
                assert!((modulus - f64::abs(mode)).abs() < 1e-12, "{modulus} {mode}");
                assert!((angle - if mode < 0.0 { std::f64::consts::PI } else { 0.0 }).abs() < 1e-12);
            }
            other => panic!("{mode}: {other}"),
        }
    }
    // An oscillating pair that no force moves.
    let (sine, cosine) = 0.4f64.sin_cos();
    let turning = dmatrix![cosine, -sine, 0.0; sine, cosine, 0.0; 0.0, 0.0, 2.0];
    match check(&turning, &dmatrix![0.0; 0.0; 1.0], &DMatrix::identity(3, 3)) {
        DlqrError::NotStabilizable { modulus, angle } => {
            assert!((modulus - 1.0).abs() < 1e-12 && (angle - 0.4).abs() < 1e-12, "{modulus} {angle}");
        }
        other => panic!("{other}"),
    }
    // Controllable, but without cost: the cheapest control lets it grow.
    for mode in [1.5, 1.0] {
        let error = check(&dmatrix![mode, 0.0; 0.3, 0.5], &dmatrix![1.0; 1.0], &DMatrix::zeros(2, 2));
        assert!(
            matches!(error, DlqrError::NotDetectable { modulus, .. } if (modulus - mode).abs() < 1e-12),
            "{error}"
        );
        assert!(error.to_string().contains("give its states a cost in Q"));
    }
    // A double integrator without a force: two equal eigenvalues, accurate to 1e-8.
    let error = check(&dmatrix![1.0, 0.1; 0.0, 1.0], &dmatrix![0.0; 0.0], &q);
    assert!(matches!(error, DlqrError::NotStabilizable { .. }), "{error}");
    // A decaying mode needs no force and no cost.
    let found = dlqr(&dmatrix![0.9, 1.0; 0.0, 0.5], &dmatrix![0.0; 0.0], &q, &r).unwrap();
    assert!(found.gain.amax() == 0.0 && (found.spectral_radius - 0.9).abs() < 1e-14);
}
