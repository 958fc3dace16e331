//! The quadratic programs of the levels, one after the other.
//!
//! x = x₀ + N z satisfies the equations for every z. A level minimizes ½ Σ w (A x − b)² over z within the
//! limits; then its A x is fixed by a smaller N.

use robot_dynamics_number::InvalidInput;

use super::error::WholeBodyError;
use super::matrix::{Elimination, Matrix};
use super::problem::Problem;
use super::solution::ActiveLimit;
use crate::optimal::dense::add_symmetric_product;
use crate::quadratic_program::{DualActiveSet, QuadraticProgramError, RowBounds, Side, dot};

/// The added curvature, relative to the mean of H: it makes the solution unique. The proximal steps remove
/// its influence on directions that a task determines.
const REGULARIZATION: f64 = 1e-8;

/// The change of z between proximal steps, relative to z, that counts as none.
const STATIONARITY: f64 = 1e-11;

/// A limit of which N keeps less than this fraction is determined by the equations and the levels before.
const FREEDOM: f64 = 1e-8;

/// The most proximal steps.
const PROXIMAL_STEPS: usize = 6;

/// The memory of the levels.
#[derive(Clone, Debug, Default)]
pub(super) struct Levels {
    elimination: Elimination,
    solver: DualActiveSet,
    /// x.
    pub(super) x: Vec<f64>,
    basis: Matrix,
    rotation: Matrix,
    rotated: Matrix,
    /// The weighted rows of a level, over x and over z, and their residuals.
    rows: Matrix,
    reduced: Matrix,
    residual: Vec<f64>,
    bounded: Matrix,
    lower: Vec<f64>,
    upper: Vec<f64>,
    scales: Vec<f64>,
    hessian: Vec<f64>,
    gradient: Vec<f64>,
    shifted: Vec<f64>,
    z: Vec<f64>,
    last: Vec<f64>,
    /// The working rows of each level at the last solution.
    guesses: Vec<Vec<(usize, Side)>>,
    pub(super) steps: usize,
}

impl Levels {
    /// Memory for problems of these sizes.
    pub(super) fn new(columns: usize, equations: usize, limits: usize, tasks: usize, levels: usize) -> Self {
        let vector = || Vec::with_capacity(columns);
        Self {
            elimination: Elimination::with_capacity(equations.max(tasks), columns),
            solver: DualActiveSet::new(columns),
            x: vector(),
            basis: Matrix::with_capacity(columns, columns),
            rotation: Matrix::with_capacity(columns, columns),
            rotated: Matrix::with_capacity(columns, columns),
            rows: Matrix::with_capacity(tasks, columns),
            reduced: Matrix::with_capacity(tasks, columns),
            residual: Vec::with_capacity(tasks),
            bounded: Matrix::with_capacity(limits, columns),
            lower: Vec::with_capacity(limits),
            upper: Vec::with_capacity(limits),
            scales: Vec::with_capacity(limits),
            hessian: Vec::with_capacity(columns * columns),
            gradient: vector(),
            shifted: vector(),
            z: vector(),
            last: vector(),
            guesses: (0..levels.max(1)).map(|_| Vec::with_capacity(columns)).collect(),
            steps: 0,
        }
    }

    /// Forgets the working sets.
    pub(super) fn clear_guesses(&mut self) {
        self.guesses.iter_mut().for_each(Vec::clear);
    }

    /// Solves the levels; `levels` are their numbers, ascending.
    pub(super) fn solve(&mut self, problem: &Problem, levels: &[usize]) -> Result<(), WholeBodyError> {
        self.steps = 0;
        self.elimination.factor(&problem.equations);
        self.elimination.particular(&problem.equation_values, &mut self.x).map_err(|contradiction| {
            WholeBodyError::ContradictoryContacts { residual: contradiction.residual.abs() }
        })?;
        self.elimination.null_basis(&mut self.basis);
        // Without tasks one program still meets the limits.
        let count = levels.len().max(1);
        for index in 0..count {
            self.reduce_rows(problem, levels.get(index).copied());
            let is_last = index + 1 == count;
            if !is_last || self.reduced.rows < self.reduced.columns {
                self.separate();
            }
            self.reduce_limits(problem, index == 0);
            self.minimize(problem, index)?;
            let Self { x, basis, z, .. } = &mut *self;
            for (i, x) in x.iter_mut().enumerate() {
                *x += dot(basis.row(i), z);
            }
            if !is_last {
                self.basis.drop_columns(self.elimination.rank());
            }
        }
        Ok(())
    }

    /// √w A N and √w (b − A x) of a level.
    fn reduce_rows(&mut self, problem: &Problem, level: Option<usize>) {
        self.rows.reset(0, problem.variables());
        self.residual.clear();
        for task in problem.task_rows.iter().filter(|task| Some(task.level) == level) {
            let scale = task.weight.sqrt();
            for row in task.first..task.first + task.count {
                let from = problem.tasks.row(row);
                self.residual.push(scale * (problem.task_values[row] - dot(from, &self.x)));
                self.rows.push_row().iter_mut().zip(from).for_each(|(to, from)| *to = scale * from);
            }
        }
        self.reduced.set_product(&self.rows, &self.basis);
    }

    /// Rotates N so that its first columns span the rows of B, and B is exactly zero on the others. Without
    /// this, rounding of BᵀB would move z where B leaves it free.
    fn separate(&mut self) {
        let Self { elimination, rotation, rotated, basis, reduced, rows, .. } = self;
        elimination.factor(reduced);
        elimination.whole_basis(rotation);
        rotated.set_product(basis, rotation);
        core::mem::swap(basis, rotated);
        reduced.set_product(rows, basis);
        let (rank, columns) = (elimination.rank(), reduced.columns);
        for row in reduced.data.chunks_exact_mut(columns.max(1)) {
            row[rank..].fill(0.0);
        }
    }

    /// C N, and the bounds minus C x. After the first level x satisfies the limits up to rounding, and the
    /// bounds admit it exactly.
    fn reduce_limits(&mut self, problem: &Problem, is_first: bool) {
        self.bounded.set_product(&problem.bounded, &self.basis);
        self.lower.clear();
        self.upper.clear();
        self.scales.clear();
        for row in 0..problem.bounded.rows {
            let from = problem.bounded.row(row);
            let (value, norm) = (dot(from, &self.x), dot(from, from).sqrt());
            let [lower, upper] = [problem.lower[row] - value, problem.upper[row] - value];
            self.lower.push(if is_first { lower } else { lower.min(0.0) });
            self.upper.push(if is_first { upper } else { upper.max(0.0) });
            self.scales.push(1.0 / norm);
            let own = self.bounded.row_mut(row);
            if dot(own, own).sqrt() <= FREEDOM * norm {
                own.fill(0.0);
            }
        }
    }

    /// z = argmin ½ |B z − r|² within the limits, nearest to zero in directions that B leaves free.
    fn minimize(&mut self, problem: &Problem, index: usize) -> Result<(), WholeBodyError> {
        let n = self.basis.columns;
        let Self { hessian, gradient, reduced, residual, z, last, shifted, solver, .. } = self;
        hessian.clear();
        hessian.resize(n * n, 0.0);
        add_symmetric_product(n, &reduced.data, &reduced.data, hessian);
        let trace: f64 = (0..n).map(|i| hessian[i * n + i]).sum();
        let mean = if trace > 0.0 { trace / n as f64 } else { 1.0 };
        let added = REGULARIZATION * mean;
        (0..n).for_each(|i| hessian[i * n + i] += added);
        gradient.clear();
        gradient.resize(n, 0.0);
        for (row, r) in reduced.data.chunks_exact(n.max(1)).zip(&*residual) {
            gradient.iter_mut().zip(row).for_each(|(g, b)| *g -= r * b);
        }
        z.clear();
        z.resize(n, 0.0);
        let Self { bounded, lower, upper, scales, .. } = self;
        let bounds = RowBounds { matrix: &bounded.data, lower, upper, scales };
        if n == 0 {
            return check_limits(problem, &self.lower, &self.upper);
        }
        let failed = |error| match error {
            QuadraticProgramError::Infeasible { row } => {
                WholeBodyError::Infeasible { limit: problem.limits[row] }
            }
            QuadraticProgramError::NotConverged { steps } => WholeBodyError::NotConverged { steps },
            QuadraticProgramError::Indefinite => overflow(),
        };
        solver.set_hessian(n, hessian).map_err(failed)?;
        solver.guess(bounds, self.guesses[index].iter().copied());
        for _ in 0..PROXIMAL_STEPS {
            last.clone_from(z);
            shifted.clear();
            shifted.extend(gradient.iter().zip(&*last).map(|(g, z)| g - added * z));
            match solver.solve(shifted, bounds, z) {
                Ok(steps) => self.steps += steps,
                // z = 0 satisfies the limits after the first level, so this is rounding.
                Err(QuadraticProgramError::Infeasible { .. }) if index > 0 => {
                    z.fill(0.0);
                    break;
                }
                Err(error) => return Err(failed(error)),
            }
            let largest = z.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
            let change = z.iter().zip(&*last).fold(0.0, |most: f64, (z, last)| most.max((z - last).abs()));
            if change <= STATIONARITY * (1.0 + largest) {
                break;
            }
        }
        let guess = &mut self.guesses[index];
        guess.clear();
        guess.extend(solver.working_rows().iter().map(|row| (row.row, row.side)));
        Ok(())
    }

    /// The limits of the last level that hold as equalities.
    pub(super) fn active_limits<'a>(
        &'a self,
        problem: &'a Problem,
    ) -> impl Iterator<Item = ActiveLimit> + use<'a> {
        self.solver.working_rows().iter().map(|row| ActiveLimit {
            limit: problem.limits[row.row],
            is_upper: row.side == Side::Upper,
            multiplier: row.multiplier,
        })
    }
}

fn overflow() -> WholeBodyError {
    InvalidInput::new(
        "the Hessian of the tasks",
        robot_dynamics_number::InputProblem::Overflow { value: f64::INFINITY },
    )
    .into()
}

/// The violation of limits that no variable can change, and that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Checks the limits where the equations determine everything.
fn check_limits(problem: &Problem, lower: &[f64], upper: &[f64]) -> Result<(), WholeBodyError> {
    let is_met = |row: &usize| {
        let allowed = ROUNDING * (1.0 + problem.lower[*row].abs().min(problem.upper[*row].abs()));
        lower[*row] <= allowed && upper[*row] >= -allowed
    };
    match (0..lower.len()).find(|row| !is_met(row)) {
        Some(row) => Err(WholeBodyError::Infeasible { limit: problem.limits[row] }),
        None => Ok(()),
    }
}
