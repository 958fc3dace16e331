//! Errors of pullbacks, and the checks of their input.

use core::fmt;

use robot_dynamics_core::{Model, SingularMass, Workspace, check_rank};
use robot_dynamics_integrators::{DynamicsError, Integrator, IntegratorError};
use robot_dynamics_number::{AsFloat, Classified, ErrorKind, Float, Form, Scalar};

use crate::motion::integrate::explicit::explicit_names;

/// An error of the pullback of a step or a rollout.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PullbackError {
    /// A given or computed number is not finite, or the step is not positive.
    Step(IntegratorError),
    /// M is singular at the start.
    SingularMass(SingularMass),
    /// The row solves an equation in each step; only explicit rows have a pullback.
    Implicit {
        /// The requested row.
        integrator: Integrator,
    },
}

impl Classified for PullbackError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Step(error) => error.kind(),
            Self::SingularMass(error) => error.kind(),
            Self::Implicit { .. } => ErrorKind::Unsupported,
        }
    }
}

impl fmt::Display for PullbackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(error) => write!(f, "{error}"),
            Self::SingularMass(error) => write!(f, "{error}"),
            Self::Implicit { integrator } => write!(
                f,
                "{integrator} solves an equation at each step and is not pulled back; use an explicit row: {}",
                explicit_names()
            ),
        }
    }
}

impl core::error::Error for PullbackError {}

impl From<SingularMass> for PullbackError {
    fn from(error: SingularMass) -> Self {
        Self::SingularMass(error)
    }
}

impl From<IntegratorError> for PullbackError {
    fn from(error: IntegratorError) -> Self {
        Self::Step(error)
    }
}

/// A slice of numbers of any type.
struct Numbers<'a>(core::marker::PhantomData<&'a ()>);

impl<'a> Form for Numbers<'a> {
    type Over<S: Scalar> = &'a [S];
}

/// A workspace and a configuration.
struct At<'a>(core::marker::PhantomData<&'a ()>);

impl<'a> Form for At<'a> {
    type Over<S: Scalar> = (&'a mut Workspace<S>, &'a [S]);
}

fn not_finite<T: Float>(numbers: &[T]) -> Option<usize> {
    numbers.iter().position(|x| !x.is_finite())
}

/// Checks that floats are finite; numbers of other types are not checked.
pub(super) fn check_floats<S: Scalar>(quantity: &'static str, numbers: &[S]) -> Result<(), PullbackError> {
    let index = match S::as_float::<Numbers<'_>>(numbers) {
        AsFloat::F64(numbers) => not_finite(numbers),
        AsFloat::F32(numbers) => not_finite(numbers),
        AsFloat::Other(_) => None,
    };
    match index {
        Some(index) => Err(IntegratorError::Dynamics(DynamicsError::NonFinite { quantity, index }).into()),
        None => Ok(()),
    }
}

/// Checks that M is regular, for `f64`; for other types a singular M gives numbers that are not finite.
pub(super) fn check_mass<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
) -> Result<(), PullbackError> {
    match S::as_float::<At<'_>>((workspace, q)) {
        AsFloat::F64((workspace, q)) => Ok(check_rank(model, workspace, q)?),
        AsFloat::F32(_) | AsFloat::Other(_) => Ok(()),
    }
}
