//! Errors of the regulator.

use core::fmt;

use nalgebra::{Cholesky, DMatrix, Dyn};
use robot_dynamics_number::{Classified, ErrorKind};

/// An error of [`dlqr`](crate::dlqr).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DlqrError {
    /// There is no state or no force: A or B has no entries.
    Empty {
        /// `A` or `B`.
        matrix: &'static str,
    },
    /// The shape of a matrix does not match A's rows and B's columns.
    WrongShape {
        /// `A`, `B`, `Q` or `R`.
        matrix: &'static str,
        /// The given rows and columns.
        found: (usize, usize),
        /// The required rows and columns.
        expected: (usize, usize),
    },
    /// An entry is NaN or infinite.
    NonFinite {
        /// `A`, `B`, `Q` or `R`.
        matrix: &'static str,
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// Q or R differs from its transpose by more than rounding.
    NotSymmetric {
        /// `Q` or `R`.
        matrix: &'static str,
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// The difference from the entry across the diagonal.
        difference: f64,
    },
    /// R is not positive definite: some force has no cost.
    EffortNotPositiveDefinite {
        /// R's smallest eigenvalue.
        eigenvalue: f64,
    },
    /// Q is not positive semidefinite: some state has a negative cost.
    CostNotSemidefinite {
        /// Q's smallest eigenvalue.
        eigenvalue: f64,
    },
    /// A mode of A does not decay and no force acts on it: (A, B) is not stabilizable.
    NotStabilizable {
        /// The modulus of its eigenvalue, 1 or more.
        modulus: f64,
        /// The angle of its eigenvalue \[rad per step\], 0 ≤ angle ≤ π.
        angle: f64,
    },
    /// A mode of A does not decay and has no cost: (A, Q) is not detectable, and the optimum does not
    /// stabilize it.
    NotDetectable {
        /// The modulus of its eigenvalue, 1 or more.
        modulus: f64,
        /// The angle of its eigenvalue \[rad per step\], 0 ≤ angle ≤ π.
        angle: f64,
    },
    /// The Riccati equation was not solved to rounding, or its gain leaves a mode that does not decay.
    NotConverged,
}

impl Classified for DlqrError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NotStabilizable { .. } | Self::NotDetectable { .. } => ErrorKind::Infeasible,
            Self::NotConverged => ErrorKind::NotConverged,
            _ => ErrorKind::InvalidInput,
        }
    }
}

impl fmt::Display for DlqrError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty { matrix } => {
                write!(f, "{matrix} has no entries; give at least one state and one force")
            }
            Self::WrongShape { matrix, found: (rows, columns), expected: (n, m) } => {
                write!(f, "{matrix} is {rows}×{columns}, it must be {n}×{m}: A is n×n, B n×m, Q n×n, R m×m")
            }
            Self::NonFinite { matrix, row, column } => {
                write!(f, "{matrix}[{row}, {column}] is not finite; every number must be")
            }
            Self::NotSymmetric { matrix, row, column, difference } => write!(
                f,
                "{matrix}[{row}, {column}] and {matrix}[{column}, {row}] differ by {difference:e}; \
                 {matrix} must be symmetric"
            ),
            Self::EffortNotPositiveDefinite { eigenvalue } => write!(
                f,
                "R is not positive definite, its smallest eigenvalue is {eigenvalue:e}; \
                 give every force a cost above 0"
            ),
            Self::CostNotSemidefinite { eigenvalue } => write!(
                f,
                "Q is not positive semidefinite, its smallest eigenvalue is {eigenvalue:e}; \
                 give no state a cost below 0"
            ),
            Self::NotStabilizable { modulus, angle } => write!(
                f,
                "no force moves the mode of A with eigenvalue {modulus:.6} ∠ {angle:.6} rad, which does not decay: \
                 there is no stabilising gain; add a force that moves it, or leave its states out"
            ),
            Self::NotDetectable { modulus, angle } => write!(
                f,
                "the mode of A with eigenvalue {modulus:.6} ∠ {angle:.6} rad does not decay and costs nothing: \
                 give its states a cost in Q"
            ),
            Self::NotConverged => write!(
                f,
                "the Riccati equation was not solved: some mode is hardly moved by B or hardly costs by Q; \
                 bring the units of states and forces to one size, or raise Q or lower R"
            ),
        }
    }
}

impl core::error::Error for DlqrError {}

/// Checks the matrices of a linear-quadratic problem; returns R's factor.
pub(super) fn check_matrices(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Cholesky<f64, Dyn>, DlqrError> {
    let (n, m) = (a.nrows(), b.ncols());
    for (matrix, x) in [("A", a), ("B", b)] {
        if x.is_empty() {
            return Err(DlqrError::Empty { matrix });
        }
    }
    for (matrix, x, expected) in [("A", a, (n, n)), ("B", b, (n, m)), ("Q", q, (n, n)), ("R", r, (m, m))] {
        if x.shape() != expected {
            return Err(DlqrError::WrongShape { matrix, found: x.shape(), expected });
        }
        if let Some(index) = x.iter().position(|x| !x.is_finite()) {
            let (row, column) = (index % x.nrows(), index / x.nrows());
            return Err(DlqrError::NonFinite { matrix, row, column });
        }
    }
    check_symmetric("Q", q)?;
    check_symmetric("R", r)?;
    let eigenvalue = q.symmetric_eigenvalues().min();
    // A product CᵀC has negative eigenvalues by rounding.
    if eigenvalue < -10.0 * n as f64 * f64::EPSILON * q.amax() {
        return Err(DlqrError::CostNotSemidefinite { eigenvalue });
    }
    let indefinite = || DlqrError::EffortNotPositiveDefinite { eigenvalue: r.symmetric_eigenvalues().min() };
    let factor = r.clone().cholesky().ok_or_else(indefinite)?;
    // Compares each pivot with its diagonal entry, so that the units of the forces do not matter.
    let rounding = 10.0 * m as f64 * f64::EPSILON;
    let is_lost = |k: usize| factor.l_dirty()[(k, k)].powi(2) <= rounding * r[(k, k)];
    if (0..m).any(is_lost) { Err(indefinite()) } else { Ok(factor) }
}

/// Checks that a matrix is symmetric to the rounding of a product.
fn check_symmetric(matrix: &'static str, x: &DMatrix<f64>) -> Result<(), DlqrError> {
    let allowed = 1e-12 * x.amax();
    for column in 0..x.ncols() {
        for row in 0..column {
            let difference = (x[(row, column)] - x[(column, row)]).abs();
            if difference > allowed {
                return Err(DlqrError::NotSymmetric { matrix, row, column, difference });
            }
        }
    }
    Ok(())
}
