//! The kinds of errors, common to all crates.

use std::error::Error;

/// The kind of an error: bad input, a singular robot, an iteration that did not converge, and so on.
///
/// ```
/// use robot_dynamics_number::{Classified, ErrorKind, check_positive};
/// let error = check_positive("the step", -0.1, "s").expect_err("a negative step");
/// assert_eq!(error.kind(), ErrorKind::InvalidInput);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A file cannot be read or written, or its text is refused.
    File,
    /// The description of a robot is invalid, or does not allow the requested change.
    Description,
    /// No frame, link, joint, pose, function or method has the given name.
    UnknownName,
    /// An argument has the wrong length, a number that is not finite, or a value out of its range.
    InvalidInput,
    /// The mass matrix is singular, or the robot is in a singular pose.
    Singular,
    /// Constraints are invalid or contradict each other, or the state violates them.
    Constraint,
    /// A motion grew without bound, or a computed number is not finite.
    Diverged,
    /// An iteration or a search ended before it met its tolerances.
    NotConverged,
    /// The problem has no solution, or the data do not determine one.
    Infeasible,
    /// The method, the format or the device does not support the request.
    Unsupported,
    /// A callback of the caller failed.
    Callback,
    /// The caller interrupted or cancelled the computation.
    Interrupted,
    /// The system failed: threads, executable memory, a compiler, or a device.
    System,
}

/// An error that has a kind.
pub trait Classified: Error + Send + Sync + 'static {
    /// The kind of the error.
    fn kind(&self) -> ErrorKind;
}

impl Classified for std::io::Error {
    fn kind(&self) -> ErrorKind {
        ErrorKind::File
    }
}
