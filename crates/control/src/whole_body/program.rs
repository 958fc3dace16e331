//! The quadratic program of a state, for other solvers.

use nalgebra::{DMatrix, DVector};

use super::matrix::Matrix;
use super::problem::Problem;

/// The quadratic program of one state: minimize ½ |A x − b|² with E x = e and l ≤ C x ≤ u.
///
/// x = (q̈, f): nv accelerations, and three forces along t₁, t₂ and n for each contact point.
#[derive(Clone, Debug, PartialEq)]
pub struct WholeBodyProgram {
    /// E, with a row for each degree of freedom without a motor and each direction of a contact.
    pub equations: DMatrix<f64>,
    /// e.
    pub equation_values: DVector<f64>,
    /// C.
    pub limits: DMatrix<f64>,
    /// l; entries may be −∞.
    pub lower: DVector<f64>,
    /// u; entries may be ∞.
    pub upper: DVector<f64>,
    /// √w A of the tasks, in the order of the tasks.
    pub tasks: DMatrix<f64>,
    /// √w b.
    pub task_values: DVector<f64>,
    /// The level of each row of A.
    pub levels: Vec<usize>,
}

fn dense(matrix: &Matrix) -> DMatrix<f64> {
    DMatrix::from_row_slice(matrix.rows, matrix.columns, &matrix.data)
}

impl WholeBodyProgram {
    pub(super) fn of(problem: &Problem) -> Self {
        let mut program = Self {
            equations: dense(&problem.equations),
            equation_values: DVector::from_column_slice(&problem.equation_values),
            limits: dense(&problem.bounded),
            lower: DVector::from_column_slice(&problem.lower),
            upper: DVector::from_column_slice(&problem.upper),
            tasks: dense(&problem.tasks),
            task_values: DVector::from_column_slice(&problem.task_values),
            levels: vec![0; problem.tasks.rows],
        };
        for task in &problem.task_rows {
            for row in task.first..task.first + task.count {
                let scale = task.weight.sqrt();
                program.tasks.row_mut(row).scale_mut(scale);
                program.task_values[row] *= scale;
                program.levels[row] = task.level;
            }
        }
        program
    }
}
