//! Errors of steps and runs.

use core::fmt;
use robot_dynamics_number::{Classified, ErrorKind};

use crate::Integrator;

/// The reason why forward dynamics has no result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DynamicsError {
    /// An input or an intermediate quantity is NaN or infinite.
    NonFinite {
        /// The quantity: `q`, `qd`, `u`, `M`, `C q̇`, `g`, `b`, their sum, or the result `qdd`.
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
}

impl Classified for DynamicsError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NonFinite { quantity, .. } => kind_of_not_finite(quantity),
            Self::SingularMass { .. } => ErrorKind::Singular,
        }
    }
}

impl fmt::Display for DynamicsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite { quantity, index } => {
                write!(f, "{quantity}[{index}] is not finite; check the state and the parameters")
            }
            Self::SingularMass { coordinate, pivot } => write!(
                f,
                "the mass matrix is singular: pivot {pivot:e} at coordinate {coordinate} is not positive; \
                 some body moved by that coordinate has no inertia"
            ),
        }
    }
}

impl core::error::Error for DynamicsError {}

/// The reason why a step or a run of an integrator failed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum IntegratorError {
    /// The acceleration, or the velocity of a momentum, is undefined at a state within the step.
    Dynamics(DynamicsError),
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
    /// A step that is not positive and finite.
    BadStep {
        /// The given step \[s\].
        step: f64,
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
            Self::Dynamics(error) => error.kind(),
            Self::NotConverged { .. } => ErrorKind::NotConverged,
            Self::EnergyNotFinite { .. } => ErrorKind::Diverged,
            Self::BadStep { .. } => ErrorKind::InvalidInput,
            Self::OffConstraint { .. } => ErrorKind::Constraint,
            Self::Interrupted => ErrorKind::Interrupted,
            Self::UnknownName { .. } => ErrorKind::UnknownName,
        }
    }
}

impl fmt::Display for IntegratorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dynamics(error) => write!(f, "no acceleration at a state of the step: {error}"),
            Self::NotConverged { residual, iterations, step } => write!(
                f,
                "the implicit step of {step:e} s did not converge: relative change {residual:e} after \
                 {iterations} iterations; take a smaller step"
            ),
            Self::EnergyNotFinite { steps_done } => {
                write!(f, "the energy is not finite after {steps_done} steps; take a smaller step")
            }
            Self::BadStep { step } => write!(f, "the step must be positive and finite, got {step} s"),
            Self::OffConstraint { quantity, name, error } => write!(
                f,
                "the {quantity} at the start is off the constraint `{name}` by {error:e}; project it there first"
            ),
            Self::Interrupted => {
                write!(
                    f,
                    "the step was interrupted; the state is that of its start, and the step can be taken again"
                )
            }
            Self::UnknownName { name } => {
                write!(f, "no integrator is named \"{name}\"; the names are")?;
                Integrator::ALL.iter().try_for_each(|row| write!(f, " {}", row.name()))
            }
        }
    }
}

impl core::error::Error for IntegratorError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Dynamics(error) => Some(error),
            _ => None,
        }
    }
}

impl From<DynamicsError> for IntegratorError {
    fn from(error: DynamicsError) -> Self {
        Self::Dynamics(error)
    }
}

/// Rejects a slice with a NaN or an infinity, naming the quantity and the entry.
///
/// ```
/// use robot_dynamics_integrators::{DynamicsError, check_finite};
/// assert_eq!(check_finite("q", &[0.0, 1.0]), Ok(()));
/// let refused = check_finite("q", &[0.0, f64::NAN]);
/// assert!(matches!(refused, Err(DynamicsError::NonFinite { quantity: "q", index: 1 })));
/// ```
///
/// # Errors
/// [`DynamicsError::NonFinite`] if a value is NaN or infinite.
pub fn check_finite(quantity: &'static str, values: &[f64]) -> Result<(), DynamicsError> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(DynamicsError::NonFinite { quantity, index }),
        None => Ok(()),
    }
}

/// The kind of a number that is not finite: bad input if the quantity is an argument, else a divergence.
#[doc(hidden)]
pub fn kind_of_not_finite(quantity: &str) -> ErrorKind {
    let is_argument = matches!(quantity, "q" | "v" | "a" | "qd" | "u" | "tau");
    if is_argument { ErrorKind::InvalidInput } else { ErrorKind::Diverged }
}
