//! Errors of forward dynamics, of steps and of runs.

use core::fmt;

use robot_dynamics_number::{Classified, ErrorKind, InvalidInput};

use crate::Integrator;

/// The reason why forward dynamics, a step or a run of an integrator has no result: the error of the steps of
/// this crate and of the chapter. Simulations wrap it in their own errors.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "DynamicsError")]
pub enum IntegratorError {
    /// The step is not positive and finite, or an argument has a number that is not finite.
    #[doc(alias = "BadStep")]
    Input(Box<InvalidInput>),
    /// A computed quantity is NaN or infinite: the motion diverged, or a parameter is too large.
    #[doc(alias = "NonFinite")]
    NotFinite {
        /// The quantity: `M`, `C q̇`, `the acceleration`, `v after the step`, ...
        quantity: &'static str,
        /// The first invalid entry (row, for a matrix).
        index: usize,
    },
    /// M(q) is not positive definite: some motion has no kinetic energy, so q̈ is undetermined.
    SingularMass {
        /// The coordinate at which the Cholesky factorization failed.
        coordinate: usize,
        /// The pivot there, in the units of M's diagonal; it must be positive.
        pivot: f64,
    },
    /// The implicit equation of a variational step did not converge to rounding.
    NotConverged {
        /// The last change of the velocity over the step, relative to the velocity.
        residual: f64,
        /// The number of iterations.
        iterations: usize,
        /// The implicit step \[s\]: a fraction of the whole step, possibly negative, for a composed method. A
        /// smaller step converges faster.
        step: f64,
    },
    /// The energy of a run became NaN or infinite: the motion diverged.
    EnergyNotFinite {
        /// The number of steps before it was detected.
        steps_done: usize,
    },
    /// The initial state violates the robot's constraints.
    OffConstraint {
        /// The violated quantity: position or velocity.
        quantity: &'static str,
        /// The row, `constraint.row`.
        name: String,
        /// The violation \[m or rad, or that per second\].
        error: f64,
    },
    /// The flag passed to the method interrupted the step. The state is that of the step's start.
    Interrupted,
    /// No integrator has this name.
    UnknownName {
        /// The name as given.
        name: String,
    },
}

impl Classified for IntegratorError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::NotFinite { .. } | Self::EnergyNotFinite { .. } => ErrorKind::Diverged,
            Self::SingularMass { .. } => ErrorKind::Singular,
            Self::NotConverged { .. } => ErrorKind::NotConverged,
            Self::OffConstraint { .. } => ErrorKind::Constraint,
            Self::Interrupted => ErrorKind::Interrupted,
            Self::UnknownName { .. } => ErrorKind::UnknownName,
        }
    }
}

impl fmt::Display for IntegratorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => error.fmt(f),
            Self::NotFinite { quantity, index } => {
                write!(f, "{quantity}[{index}] is not finite; check the state and the parameters")
            }
            Self::SingularMass { coordinate, pivot } => write!(
                f,
                "the mass matrix is singular: pivot {pivot:e} at coordinate {coordinate} is not positive; \
                 some body moved by that coordinate has no inertia"
            ),
            Self::NotConverged { residual, iterations, step } => write!(
                f,
                "the implicit step of {step:e} s did not converge: relative change {residual:e} after \
                 {iterations} iterations; take a smaller step"
            ),
            Self::EnergyNotFinite { steps_done } => {
                write!(f, "the energy is not finite after {steps_done} steps; take a smaller step")
            }
            Self::OffConstraint { quantity, name, error } => write!(
                f,
                "the {quantity} at the start is off the constraint `{name}` by {error:e}; project it there first"
            ),
            Self::Interrupted => f.write_str(
                "the step was interrupted; the state is that of its start, and the step can be taken again",
            ),
            Self::UnknownName { name } => {
                write!(f, "no integrator is named \"{name}\"; the names are")?;
                Integrator::ALL.iter().try_for_each(|row| write!(f, " {}", row.name()))
            }
        }
    }
}

impl core::error::Error for IntegratorError {}

impl From<InvalidInput> for IntegratorError {
    fn from(error: InvalidInput) -> Self {
        Self::Input(Box::new(error))
    }
}

/// Checks that computed numbers are finite. For arguments, see
/// [`check_finite`](robot_dynamics_number::check_finite).
///
/// ```
/// use robot_dynamics_integrators::{IntegratorError, check_computed};
/// assert_eq!(check_computed("M", &[0.0, 1.0]), Ok(()));
/// let error = check_computed("M", &[0.0, f64::NAN]);
/// assert!(matches!(error, Err(IntegratorError::NotFinite { quantity: "M", index: 1 })));
/// ```
///
/// # Errors
/// [`IntegratorError::NotFinite`] with the first entry that is NaN or infinite.
pub fn check_computed(quantity: &'static str, values: &[f64]) -> Result<(), IntegratorError> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(IntegratorError::NotFinite { quantity, index }),
        None => Ok(()),
    }
}
