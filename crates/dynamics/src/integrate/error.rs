//! Why a step or a run could not be completed.

use core::fmt;

use crate::DynamicsError;

/// Why a step or a run of an integrator could not be completed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum IntegratorError {
    /// The acceleration, or a momentum's velocity, does not exist at a state the step visits.
    Dynamics(DynamicsError),
    /// The implicit equation of a variational step was not solved to round-off.
    NotConverged {
        /// The last change of the velocity over the step, as a fraction of the velocity's size.
        residual: f64,
        /// Iterations spent.
        iterations: usize,
        /// The implicit step \[s\], a fraction of the whole step (maybe negative) for a composed method; a
        /// smaller one converges faster.
        step: f64,
    },
    /// The energy of a run became NaN or infinite: the motion blew up.
    EnergyNotFinite {
        /// The number of steps after which it was seen.
        steps_done: usize,
    },
    /// A step that is not positive and finite.
    BadStep {
        /// The step given \[s\].
        step: f64,
    },
    /// A start that is not on the robot's constraints.
    OffConstraint {
        /// What is off: its position or its velocity.
        quantity: &'static str,
        /// The row, `constraint.row`.
        name: String,
        /// By how much \[m or rad, or that per second\].
        error: f64,
    },
    /// The step was interrupted by a flag that its method was given. The state is that of the step's start.
    Interrupted,
    /// No integrator has this name.
    UnknownName {
        /// The name as given.
        name: String,
    },
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
                super::Integrator::ALL.iter().try_for_each(|row| write!(f, " {}", row.name()))
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
