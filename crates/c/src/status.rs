//! The status of a call.

/// The result of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The call succeeded.
    Ok = 0,
    /// A file cannot be read, or its text is refused.
    File = 1,
    /// The description of the robot is invalid.
    Description = 2,
    /// No frame, pose, quantity or method has the given name.
    UnknownName = 3,
    /// An argument is null, has the wrong length, is not finite, is out of its range, or overlaps another.
    InvalidInput = 4,
    /// The mass matrix is singular, or the robot is in a singular pose.
    Singular = 5,
    /// Constraints are invalid or contradict each other, or the state violates them.
    Constraint = 6,
    /// A motion grew without bound, or a computed number is not finite.
    Diverged = 7,
    /// An iteration ended before it met its tolerances.
    NotConverged = 8,
    /// The problem has no solution, or the data do not determine one.
    Infeasible = 9,
    /// The method does not support the request.
    Unsupported = 10,
    /// A callback failed.
    Callback = 11,
    /// The caller interrupted the computation.
    Interrupted = 12,
    /// The system failed: threads or memory.
    System = 13,
    /// A handle is null, of another kind of object, of a freed object, or of another robot.
    InvalidHandle = 14,
    /// Another call uses the object at the same time.
    InUse = 15,
    /// The library panicked, which is a fault of the library. Free the object of the call.
    Panic = 16,
}
