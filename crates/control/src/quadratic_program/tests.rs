//! Random programs against the optimality conditions.

use robot_dynamics_number::SplitMix64;

use super::*;

struct Program {
    n: usize,
    hessian: Vec<f64>,
    gradient: Vec<f64>,
    matrix: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    scales: Vec<f64>,
}

impl Program {
    /// A feasible program with rows on both sides of a random point; some rows are equalities, some repeat
    /// others, and some have one bound.
    fn random(seed: u64, n: usize, rows: usize) -> Self {
        let mut random = SplitMix64::new(seed);
        let mut numbers = |count: usize| (0..count).map(|_| random.uniform(-1.0, 1.0)).collect::<Vec<f64>>();
        let half = numbers(n * n);
        let mut hessian = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                hessian[i * n + j] = (0..n).map(|k| half[i * n + k] * half[j * n + k]).sum();
            }
            hessian[i * n + i] += 0.1;
        }
        let gradient = numbers(n).iter().map(|g| 20.0 * g).collect();
        let (mut matrix, point, widths) = (numbers(n * rows), numbers(n), numbers(2 * rows));
        if rows > 3 {
            matrix.copy_within(0..n, 2 * n);
        }
        let (mut lower, mut upper) = (vec![0.0; rows], vec![0.0; rows]);
        for row in 0..rows {
            let value = dot(&matrix[row * n..(row + 1) * n], &point);
            lower[row] = value - widths[2 * row].abs();
            upper[row] = value + widths[2 * row + 1].abs();
            match row % 7 {
                3 => lower[row] = f64::NEG_INFINITY,
                4 => upper[row] = f64::INFINITY,
                5 if row < n => (lower[row], upper[row]) = (value, value),
                _ => {}
            }
        }
        Self { n, hessian, gradient, matrix, lower, upper, scales: vec![1.0; rows] }
    }

    fn bounds(&self) -> RowBounds<'_> {
        RowBounds { matrix: &self.matrix, lower: &self.lower, upper: &self.upper, scales: &self.scales }
    }

    /// The largest residual of H x + g = Cᵀλ, of the bounds, and of the sign and complementarity of λ.
    fn residual(&self, x: &[f64], rows: &[WorkingRow]) -> f64 {
        let n = self.n;
        let mut stationarity: Vec<f64> =
            (0..n).map(|i| dot(&self.hessian[i * n..(i + 1) * n], x) + self.gradient[i]).collect();
        let mut worst: f64 = 0.0;
        for WorkingRow { row, side, multiplier } in rows {
            worst = worst.max(-multiplier);
            let normal = &self.matrix[row * n..(row + 1) * n];
            let bound = if *side == Side::Lower { self.lower[*row] } else { self.upper[*row] };
            worst = worst.max((dot(normal, x) - bound).abs());
            let force = if *side == Side::Lower { *multiplier } else { -multiplier };
            stationarity.iter_mut().zip(normal).for_each(|(s, c)| *s -= force * c);
        }
        for row in 0..self.lower.len() {
            let value = dot(&self.matrix[row * n..(row + 1) * n], x);
            worst = worst.max(self.lower[row] - value).max(value - self.upper[row]);
        }
        stationarity.iter().fold(worst, |worst, s| worst.max(s.abs()))
    }
}

/// Condition numbers of H up to 1e4 and gradients of 20 leave eleven digits.
const TOLERANCE: f64 = 1e-9;

#[test]
fn solutions_satisfy_the_optimality_conditions() {
    let mut active = 0;
    for (seed, index) in (0..200).zip(0_usize..) {
        let (n, rows) = (1 + index % 12, index % 31);
        let program = Program::random(seed, n, rows);
        let (mut solver, mut x) = (DualActiveSet::new(n), vec![0.0; n]);
        solver.set_hessian(n, &program.hessian).expect("a positive definite H");
        solver.solve(&program.gradient, program.bounds(), &mut x).expect("a feasible program");
        assert!(program.residual(&x, solver.working_rows()) < TOLERANCE, "{seed}");
        active += solver.working_rows().len();
    }
    assert!(active > 200, "most programs have active rows");
}

#[test]
fn a_guess_changes_the_steps_only() {
    for seed in 0..100 {
        let program = Program::random(seed, 10, 25);
        let (mut solver, mut x) = (DualActiveSet::new(10), vec![0.0; 10]);
        solver.set_hessian(10, &program.hessian).expect("a positive definite H");
        solver.solve(&program.gradient, program.bounds(), &mut x).expect("a solution");
        let right: Vec<(usize, Side)> = solver.working_rows().iter().map(|row| (row.row, row.side)).collect();
        let wrong = (0..25).step_by(2).map(|row| (row, Side::Upper)).collect();
        for (guess, is_right) in [(right, true), (wrong, false)] {
            let mut again = vec![0.0; 10];
            solver.set_hessian(10, &program.hessian).expect("a positive definite H");
            solver.guess(program.bounds(), guess.into_iter());
            let steps = solver.solve(&program.gradient, program.bounds(), &mut again).expect("a solution");
            assert!(steps == 0 || !is_right, "{seed}");
            assert!(x.iter().zip(&again).all(|(x, again)| (x - again).abs() < TOLERANCE), "{seed}");
        }
    }
}

#[test]
fn contradictions_are_found() {
    let (mut solver, mut x) = (DualActiveSet::new(2), [0.0; 2]);
    solver.set_hessian(2, &[1.0, 0.0, 0.0, 1.0]).expect("the identity");
    // x + y ≥ 1 and 2x + 2y ≤ 1.
    let bounds = RowBounds {
        matrix: &[1.0, 1.0, 2.0, 2.0],
        lower: &[1.0, f64::NEG_INFINITY],
        upper: &[f64::INFINITY, 1.0],
        scales: &[1.0, 0.5],
    };
    let refused = solver.solve(&[0.0, 0.0], bounds, &mut x);
    assert!(matches!(refused, Err(QuadraticProgramError::Infeasible { .. })));
    assert_eq!(solver.set_hessian(1, &[-1.0]), Err(QuadraticProgramError::Indefinite));
}
