//! Errors of constraints, and of motions with constraints.

use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};
use thiserror::Error;

/// The name of a constraint row that depends on the rows before it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NamedDependentRow {
    /// The row's index in A.
    pub row: usize,
    /// Its name, for example `pin.rx`.
    pub name: String,
    /// The earlier rows whose combination it is; empty for a row of zeros.
    pub combination_of: Vec<String>,
}

impl core::fmt::Display for NamedDependentRow {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.combination_of.as_slice() {
            [] => write!(f, "`{}` is zero", self.name),
            rows => write!(f, "`{}` depends on `{}`", self.name, rows.join("`, `")),
        }
    }
}

/// An invalid constraint, or the reason why a constrained motion was not computed: the error of
/// [`ConstraintSet`](crate::ConstraintSet) and of the functions that take one.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[doc(alias = "ConstraintSetError")]
#[doc(alias = "ConstrainedMotionError")]
pub enum ConstraintError {
    /// A vector has a number that is not finite, or an option, a tolerance, a radius, a coefficient, a
    /// support, the weight of the forces or the step is out of its range. The robot has no frame or
    /// coordinate of a name.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// A frame of another model.
    #[error(
        "constraint `{constraint}` names a frame of another robot than `{robot}`; look frames up in this model"
    )]
    ForeignFrame {
        /// The constraint.
        constraint: String,
        /// The model's name.
        robot: String,
    },
    /// Two constraints share a name.
    #[error("two constraints are named `{name}`; rename one")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// A constraint without rows, or with a row twice.
    #[error("constraint `{constraint}` {problem}")]
    BadRows {
        /// The constraint.
        constraint: String,
        /// `has no rows` or `has a row twice`.
        problem: &'static str,
    },
    /// A computed number is NaN or infinite, or an implicit step failed.
    #[error(transparent)]
    Step(#[from] IntegratorError),
    /// M is singular.
    #[error(transparent)]
    SingularMass(#[from] robot_dynamics_core::SingularMass),
    /// A row of A or Ȧv is not finite.
    #[error("constraint row `{name}` is not finite at this state; a rolling disc must not lie flat")]
    NonFiniteRow {
        /// The row.
        name: String,
    },
    /// Rows depend on each other, with [`RedundantRows::Refuse`](crate::RedundantRows::Refuse).
    #[error("the constraint rows have rank {rank} only: {}; leave the named rows out, or allow redundant rows",
        .rows.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))]
    DependentRows {
        /// The number of independent rows.
        rank: usize,
        /// The dependent rows.
        rows: Vec<NamedDependentRow>,
    },
    /// Redundant rows contradict each other, or the damped solve did not converge.
    #[error(
        "the constraint rows contradict each other: A a misses its target by {residual:e}, most at row `{name}`"
    )]
    Inconsistent {
        /// The worst row.
        name: String,
        /// max |A a + Ȧv| \[m/s² or rad/s²\].
        residual: f64,
    },
    /// Baumgarte's feedback with a method whose equations satisfy φ = 0 themselves.
    #[error("a variational step holds the constraint itself; leave the stabilization out")]
    StabilizedVariationalStep,
    /// The implicit equations of a variational step were not solved to round-off.
    #[error(
        "the implicit step of {step:e} s did not converge: relative change {residual:e} after {iterations} \
         iterations, farthest off in row `{name}`; take a smaller step, or start on the constraint"
    )]
    StepNotConverged {
        /// The last change of the velocity over the step, as a fraction of the velocity's size.
        residual: f64,
        /// Iterations spent.
        iterations: usize,
        /// The implicit step \[s\], a fraction of the whole step (possibly negative) for a composed method.
        step: f64,
        /// The row with the largest residual.
        name: String,
    },
    /// The rows at the two ends of a variational step have no common solution except by rounding.
    #[error(
        "the constraint rows, `{name}` last, are independent by little more than rounding here: a singular \
         position, or ConstraintOptions::dependence is too small to leave the redundant row out"
    )]
    NearlyDependentRow {
        /// The row with the smallest part that is independent of the others.
        name: String,
    },
    /// The projection onto the constraint did not converge.
    #[error(
        "no configuration on the constraint found after {iterations} steps: \
         row `{name}` is still off by {error:e}; start nearer to it"
    )]
    NotConverged {
        /// Gauss–Newton steps taken.
        iterations: usize,
        /// The worst row.
        name: String,
        /// Its |φ|.
        error: f64,
    },
    /// The initial state is off the constraint.
    #[error(
        "the start is off the constraint: {quantity} of row `{name}` is {error:e}; \
         project_position and project_velocity bring it there"
    )]
    OffConstraint {
        /// `the position error` or `the velocity`.
        quantity: &'static str,
        /// The row.
        name: String,
        /// The error.
        error: f64,
    },
}

impl Classified for ConstraintError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::Step(error) => error.kind(),
            Self::SingularMass(error) => error.kind(),
            Self::ForeignFrame { .. }
            | Self::DuplicateName { .. }
            | Self::BadRows { .. }
            | Self::NonFiniteRow { .. }
            | Self::DependentRows { .. }
            | Self::Inconsistent { .. }
            | Self::NearlyDependentRow { .. }
            | Self::OffConstraint { .. } => ErrorKind::Constraint,
            Self::StabilizedVariationalStep => ErrorKind::Unsupported,
            Self::StepNotConverged { .. } | Self::NotConverged { .. } => ErrorKind::NotConverged,
        }
    }
}
