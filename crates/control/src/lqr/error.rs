//! Errors of the regulator.

use core::fmt;

use nalgebra::{Cholesky, DMatrix, Dyn};
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};

/// The error of [`dlqr`](crate::dlqr): an invalid matrix, or a problem without a stabilizing gain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DlqrError {
    /// A matrix has no entries, the wrong shape, or an entry that is not finite; Q or R is not symmetric, R
    /// not positive definite, or Q not positive semidefinite.
    Input(InvalidInput),
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
            Self::Input(error) => error.kind(),
        }
    }
}

impl fmt::Display for DlqrError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => error.fmt(f),
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

impl From<InvalidInput> for DlqrError {
    fn from(error: InvalidInput) -> Self {
        Self::Input(error)
    }
}

/// Checks the matrices of a linear-quadratic problem; returns R's factor.
pub(super) fn check_matrices(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Cholesky<f64, Dyn>, InvalidInput> {
    let (n, m) = (a.nrows(), b.ncols());
    for (matrix, x) in [("A", a), ("B", b)] {
        if x.is_empty() {
            return Err(InvalidInput::unmet(matrix, "has no entries; give at least one state and one force"));
        }
    }
    for (matrix, x, expected) in [("A", a, (n, n)), ("B", b, (n, m)), ("Q", q, (n, n)), ("R", r, (m, m))] {
        if x.shape() != expected {
            let ((rows, columns), (n, m)) = (x.shape(), expected);
            let shapes = format!("is {rows}×{columns}, it must be {n}×{m}: A is n×n, B n×m, Q n×n, R m×m");
            return Err(InvalidInput::unmet(matrix, shapes));
        }
        if let Some(index) = x.iter().position(|x| !x.is_finite()) {
            let (row, column) = (index % x.nrows(), index / x.nrows());
            return Err(InvalidInput::unmet(
                format!("{matrix}[{row}, {column}]"),
                "is not finite; every number must be",
            ));
        }
    }
    check_symmetric("Q", q)?;
    check_symmetric("R", r)?;
    let eigenvalue = q.symmetric_eigenvalues().min();
    // A product CᵀC has negative eigenvalues by rounding.
    if eigenvalue < -10.0 * n as f64 * f64::EPSILON * q.amax() {
        let advice = "give no state a cost below 0";
        let definite =
            format!("is not positive semidefinite, its smallest eigenvalue is {eigenvalue:e}; {advice}");
        return Err(InvalidInput::unmet("Q", definite));
    }
    let indefinite = || {
        let (eigenvalue, advice) = (r.symmetric_eigenvalues().min(), "give every force a cost above 0");
        let definite =
            format!("is not positive definite, its smallest eigenvalue is {eigenvalue:e}; {advice}");
        InvalidInput::unmet("R", definite)
    };
    let factor = r.clone().cholesky().ok_or_else(indefinite)?;
    // Compares each pivot with its diagonal entry, so that the units of the forces do not matter.
    let rounding = 10.0 * m as f64 * f64::EPSILON;
    let is_lost = |k: usize| factor.l_dirty()[(k, k)].powi(2) <= rounding * r[(k, k)];
    if (0..m).any(is_lost) { Err(indefinite()) } else { Ok(factor) }
}

/// Checks that a matrix is symmetric to the rounding of a product.
fn check_symmetric(matrix: &'static str, x: &DMatrix<f64>) -> Result<(), InvalidInput> {
    let allowed = 1e-12 * x.amax();
    for column in 0..x.ncols() {
        for row in 0..column {
            let difference = (x[(row, column)] - x[(column, row)]).abs();
            if difference > allowed {
                let both = format!("{matrix}[{row}, {column}] and {matrix}[{column}, {row}]");
                let differ = format!("differ by {difference:e}; {matrix} must be symmetric");
                return Err(InvalidInput::unmet(both, differ));
            }
        }
    }
    Ok(())
}
