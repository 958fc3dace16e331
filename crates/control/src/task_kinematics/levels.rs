//! The quadratic programs of the levels, one after the other.
//!
//! A level minimizes ½ Σ |√w (J δ + α e)|² + ½ λ |δ|² over the displacement δ within the bounds and rows.
//! Then its J δ is fixed for the levels after it, by rows that hold as equalities. The damping makes each
//! program strictly convex.

use super::error::TaskKinematicsError;
use super::rows::TaskRows;
use crate::optimal::dense::{add_symmetric_product, add_transposed_vector};
use crate::quadratic_program::{DualActiveSet, QuadraticProgramError, RowBounds, Side, dot};

/// The added curvature, relative to the mean of H: it makes the solution unique.
const REGULARIZATION: f64 = 1e-10;

/// The factor by which small steps sharpen the tolerances of the bounds, at most.
const SHARPEST: f64 = 1e9;

/// Rows aᵀδ ≥ bound, row-major.
#[derive(Clone, Debug, Default)]
pub(super) struct Inequalities {
    pub(super) rows: Vec<f64>,
    pub(super) lower: Vec<f64>,
}

impl Inequalities {
    pub(super) fn clear(&mut self) {
        self.rows.clear();
        self.lower.clear();
    }
}

/// The law of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepLaw {
    /// λ beside that of the tasks.
    damping: f64,
    /// Whether α and μ of the tasks apply; otherwise they are 1 and 0.
    uses_gains: bool,
}

impl StepLaw {
    /// The law of differential steps.
    pub(super) fn differential(damping: f64) -> Self {
        Self { damping, uses_gains: true }
    }

    /// The law of steps towards a solution.
    pub(super) fn global(damping: f64) -> Self {
        Self { damping, uses_gains: false }
    }
}

/// The memory of the levels.
#[derive(Clone, Debug, Default)]
pub(super) struct Levels {
    solver: DualActiveSet,
    /// δ.
    pub(super) x: Vec<f64>,
    last: Vec<f64>,
    hessian: Vec<f64>,
    gradient: Vec<f64>,
    scaled: Vec<f64>,
    /// Identity rows, then those of the levels before, then inequalities.
    rows: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    scales: Vec<f64>,
    guesses: Vec<Vec<(usize, Side)>>,
    pub(super) steps: usize,
}

/// A failure, with the row that contradicts the others.
#[derive(Clone, Copy, Debug)]
pub(super) enum LevelError {
    Bound { dof: usize, is_upper: bool },
    Inequality { row: usize },
    NotConverged { steps: usize },
    Indefinite,
}

/// The bounds of a solution.
#[derive(Clone, Copy)]
pub(super) struct Bounded<'a> {
    pub(super) lower: &'a [f64],
    pub(super) upper: &'a [f64],
    pub(super) inequalities: &'a Inequalities,
}

impl Levels {
    /// Memory for n variables, these rows of tasks, inequalities and levels.
    pub(super) fn new(n: usize, tasks: usize, inequalities: usize, levels: usize) -> Self {
        let rows = n + tasks + inequalities;
        let vector = || Vec::with_capacity(n);
        Self {
            solver: DualActiveSet::new(n),
            x: vec![0.0; n],
            last: vector(),
            hessian: Vec::with_capacity(n * n),
            gradient: vector(),
            scaled: Vec::with_capacity(tasks),
            rows: Vec::with_capacity(rows * n),
            lower: Vec::with_capacity(rows),
            upper: Vec::with_capacity(rows),
            scales: Vec::with_capacity(rows),
            guesses: (0..levels.max(1)).map(|_| Vec::with_capacity(n)).collect(),
            steps: 0,
        }
    }

    /// Forgets the working sets.
    pub(super) fn clear_guesses(&mut self) {
        self.guesses.iter_mut().for_each(Vec::clear);
    }

    /// Solves the levels with these numbers, ascending.
    pub(super) fn solve(
        &mut self,
        tasks: &[TaskRows],
        levels: &[usize],
        bounded: Bounded<'_>,
        law: StepLaw,
    ) -> Result<(), LevelError> {
        let n = self.x.len();
        self.steps = 0;
        let squared: f64 = tasks.iter().map(TaskRows::squared).sum();
        let sharpness = (1.0 / squared.sqrt()).clamp(1.0, SHARPEST);
        self.start(bounded, sharpness);
        let mut fixed = n;
        let count = levels.len().max(1);
        for index in 0..count {
            let level = levels.get(index).copied();
            self.assemble(tasks, level, law);
            self.truncate(fixed);
            self.rows.extend_from_slice(&bounded.inequalities.rows);
            for (row, lower) in
                bounded.inequalities.rows.chunks_exact(n.max(1)).zip(&bounded.inequalities.lower)
            {
                self.lower.push(*lower);
                self.upper.push(f64::INFINITY);
                self.scales.push(scale_of(row, sharpness));
            }
            self.minimize(index, fixed)?;
            self.truncate(fixed);
            if index + 1 < count {
                self.fix(tasks, level, sharpness);
                fixed = self.lower.len();
            }
        }
        for ((x, lower), upper) in self.x.iter_mut().zip(bounded.lower).zip(bounded.upper) {
            *x = x.clamp(*lower, *upper);
        }
        Ok(())
    }

    /// The rows of the bounds.
    fn start(&mut self, bounded: Bounded<'_>, sharpness: f64) {
        let n = self.x.len();
        self.rows.clear();
        self.rows.resize(n * n, 0.0);
        for i in 0..n {
            self.rows[i * n + i] = 1.0;
        }
        self.lower.clear();
        self.lower.extend_from_slice(bounded.lower);
        self.upper.clear();
        self.upper.extend_from_slice(bounded.upper);
        self.scales.clear();
        self.scales.resize(n, sharpness);
    }

    fn truncate(&mut self, count: usize) {
        self.rows.truncate(count * self.x.len());
        self.lower.truncate(count);
        self.upper.truncate(count);
        self.scales.truncate(count);
    }

    /// H and g of a level.
    fn assemble(&mut self, tasks: &[TaskRows], level: Option<usize>, law: StepLaw) {
        let n = self.x.len();
        let Self { hessian, gradient, scaled, .. } = self;
        hessian.clear();
        hessian.resize(n * n, 0.0);
        gradient.clear();
        gradient.resize(n, 0.0);
        let mut added = law.damping;
        for rows in tasks.iter().filter(|rows| Some(rows.task.level) == level) {
            add_symmetric_product(n, &rows.jacobian, &rows.jacobian, hessian);
            scaled.clear();
            let (gain, own) = if law.uses_gains { (rows.task.gain, rows.task.damping) } else { (1.0, 0.0) };
            scaled.extend(rows.residual.iter().map(|e| gain * e));
            add_transposed_vector(&rows.jacobian, scaled, gradient);
            added += own * rows.squared();
        }
        let trace: f64 = (0..n).map(|i| hessian[i * n + i]).sum();
        let mean = if trace > 0.0 { trace / n as f64 } else { 1.0 };
        added += REGULARIZATION * mean;
        (0..n).for_each(|i| hessian[i * n + i] += added);
    }

    /// Keeps J δ of a level.
    fn fix(&mut self, tasks: &[TaskRows], level: Option<usize>, sharpness: f64) {
        let n = self.x.len();
        for rows in tasks.iter().filter(|rows| Some(rows.task.level) == level) {
            for row in rows.jacobian.chunks_exact(n.max(1)) {
                let value = dot(row, &self.x);
                self.rows.extend_from_slice(row);
                self.lower.push(value);
                self.upper.push(value);
                self.scales.push(scale_of(row, sharpness));
            }
        }
    }

    /// The minimizer of a level.
    fn minimize(&mut self, index: usize, fixed: usize) -> Result<(), LevelError> {
        let n = self.x.len();
        let Self { solver, hessian, gradient, rows, lower, upper, scales, x, last, .. } = self;
        let bounds = RowBounds { matrix: rows, lower, upper, scales };
        solver.set_hessian(n, hessian).map_err(|_| LevelError::Indefinite)?;
        solver.guess(bounds, self.guesses[index].iter().copied());
        last.clone_from(x);
        match solver.solve(gradient, bounds, x) {
            Ok(steps) => self.steps += steps,
            // The solution of the level before satisfies all rows, so this is rounding.
            Err(QuadraticProgramError::Infeasible { .. }) if index > 0 => x.clone_from(last),
            Err(QuadraticProgramError::Infeasible { row }) if row < n => {
                return Err(LevelError::Bound { dof: row, is_upper: upper[row] < x[row] });
            }
            Err(QuadraticProgramError::Infeasible { row }) => {
                return Err(LevelError::Inequality { row: row.saturating_sub(fixed) });
            }
            Err(QuadraticProgramError::NotConverged { steps }) => {
                return Err(LevelError::NotConverged { steps });
            }
            Err(QuadraticProgramError::Indefinite) => return Err(LevelError::Indefinite),
        }
        let guess = &mut self.guesses[index];
        guess.clear();
        guess.extend(self.solver.working_rows().iter().map(|row| (row.row, row.side)));
        Ok(())
    }
}

impl From<LevelError> for TaskKinematicsError {
    fn from(error: LevelError) -> Self {
        match error {
            LevelError::NotConverged { steps } => Self::NotConverged { steps },
            _ => overflow().into(),
        }
    }
}

/// The error of a Hessian that is not positive definite.
fn overflow() -> robot_dynamics_number::InvalidInput {
    let problem = robot_dynamics_number::InputProblem::Overflow { value: f64::INFINITY };
    robot_dynamics_number::InvalidInput::new("the Hessian of the tasks", problem)
}

/// The scale of a row: violations count for a row of length one.
fn scale_of(row: &[f64], sharpness: f64) -> f64 {
    let norm = dot(row, row).sqrt();
    if norm > 0.0 { sharpness / norm } else { 0.0 }
}
