//! The reasons why a constrained motion cannot be computed.

use core::fmt;

use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};

/// A constraint row that depends on the rows before it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct DependentRow {
    /// The index of the row.
    pub row: usize,
    /// The earlier rows whose combination it is; empty for a row of zeros.
    pub combination_of: Vec<usize>,
}

impl fmt::Display for DependentRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.combination_of.as_slice() {
            [] => write!(f, "row {} is zero", self.row),
            [one] => write!(f, "row {} is a multiple of row {one}", self.row),
            rows => write!(f, "row {} is a combination of rows {rows:?}", self.row),
        }
    }
}

/// The reason why a constrained motion cannot be computed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConstraintError {
    /// The unconstrained system fails: a state that is not finite, or a singular mass matrix.
    Dynamics(IntegratorError),
    /// An entry of A or Ȧ is NaN or infinite.
    NonFiniteRow {
        /// The matrix, `A` or `Ȧ`.
        matrix: &'static str,
        /// The constraint row.
        row: usize,
        /// The coordinate.
        column: usize,
    },
    /// A has dependent rows, so λ is not determined.
    DependentRows {
        /// The number of independent rows.
        rank: usize,
        /// The rows to drop, in order.
        rows: Vec<DependentRow>,
    },
    /// The LU factorisation of the KKT matrix met a zero pivot: its entries differ too much in scale.
    ZeroPivot,
}

impl fmt::Display for ConstraintError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dynamics(error) => error.fmt(f),
            Self::NonFiniteRow { matrix, row, column } => {
                write!(f, "{matrix}[{row}, {column}] is not finite; check the constraint at this state")
            }
            Self::ZeroPivot => {
                write!(f, "LU met a zero pivot in the KKT matrix; scale the rows of A to the size of M")
            }
            Self::DependentRows { rank, rows } => {
                write!(f, "the constraint rows have rank {rank} only: ")?;
                for (i, row) in rows.iter().enumerate() {
                    write!(f, "{}{row}", if i == 0 { "" } else { ", " })?;
                }
                write!(f, "; leave the named rows out")
            }
        }
    }
}

impl core::error::Error for ConstraintError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Dynamics(error) => Some(error),
            _ => None,
        }
    }
}

impl Classified for ConstraintError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Dynamics(error) => error.kind(),
            Self::NonFiniteRow { .. } | Self::DependentRows { .. } => ErrorKind::Constraint,
            Self::ZeroPivot => ErrorKind::Singular,
        }
    }
}

impl From<IntegratorError> for ConstraintError {
    fn from(error: IntegratorError) -> Self {
        Self::Dynamics(error)
    }
}

impl From<InvalidInput> for ConstraintError {
    fn from(error: InvalidInput) -> Self {
        Self::Dynamics(error.into())
    }
}
