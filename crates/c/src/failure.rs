//! The error of a call: its status and its text.

use std::any::Any;
use std::fmt;

use robot_dynamics::{Classified, ErrorKind};
use robot_dynamics_number::are_finite;

use crate::Status;

/// The status and the text of a failed call.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) status: Status,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    /// An invalid argument.
    pub(crate) fn invalid(message: impl Into<String>) -> Self {
        Self::new(Status::InvalidInput, message)
    }

    /// A panic of a call.
    pub(crate) fn panic(payload: &(dyn Any + Send)) -> Self {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
        Self::new(Status::Panic, text.unwrap_or_else(|| "the library panicked without a message".into()))
    }
}

/// Checks that results of finite arguments are finite.
pub(crate) fn check_result(quantity: &str, results: &[f64]) -> Result<(), Failure> {
    if are_finite(results) { Ok(()) } else { Ok(robot_dynamics_number::check_result(quantity, results)?) }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl<E: Classified> From<E> for Failure {
    fn from(error: E) -> Self {
        let status = match error.kind() {
            ErrorKind::File => Status::File,
            ErrorKind::Description => Status::Description,
            ErrorKind::UnknownName => Status::UnknownName,
            ErrorKind::InvalidInput => Status::InvalidInput,
            ErrorKind::Singular => Status::Singular,
            ErrorKind::Constraint => Status::Constraint,
            ErrorKind::Diverged => Status::Diverged,
            ErrorKind::NotConverged => Status::NotConverged,
            ErrorKind::Infeasible => Status::Infeasible,
            ErrorKind::Unsupported => Status::Unsupported,
            ErrorKind::Callback => Status::Callback,
            ErrorKind::Interrupted => Status::Interrupted,
            _ => Status::System,
        };
        Self::new(status, error.to_string())
    }
}
