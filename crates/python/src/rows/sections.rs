//! The sections Parameters, Returns and Raises of the docstring of a row.

/// The sections for these arguments, results and errors, and the heading of the examples that follow.
macro_rules! sections {
    (
        ($($argument:ident)*) -> $($class:ident)?[$($shape:ident$(($rows:literal))? $($field:ident)? $text:literal),*]
        raises ($($error:ident)*)
    ) => {
        concat!(
            "\nParameters\n----------\n",
            $($crate::rows::sections::argument!($argument),)*
            $crate::rows::sections::out!($($class)? [$($shape$(($rows))?),*]),
            "threads : int, optional\n    Threads for a batch; default: `num_threads()`.\n",
            "\nReturns\n-------\n",
            $(stringify!($class), "\n",)?
            $($crate::rows::sections::result!($shape$(($rows))? $($field)? $text),)*
            "\nRaises\n------\n",
            $($crate::rows::sections::error!($error),)*
            "StateError\n    The state is invalid; `BadStatesError` for a batch.\n",
            "ShapeError\n    An array has the wrong shape.\n",
            "DTypeError\n    An array is neither float64 nor float32, or both occur.\n",
            "\nExamples\n--------",
        )
    };
}

/// An argument by its name.
macro_rules! argument {
    (q) => {
        "q : array_like, shape (..., nq)\n    Configuration.\n"
    };
    (q0) => {
        "q0 : array_like, shape (..., nq)\n    Configuration at the start.\n"
    };
    (q1) => {
        "q1 : array_like, shape (..., nq)\n    Configuration at the end.\n"
    };
    (v) => {
        "v : array_like, shape (..., nv)\n    Velocity [rad/s or m/s].\n"
    };
    (a) => {
        "a : array_like, shape (..., nv)\n    Acceleration [rad/s² or m/s²].\n"
    };
    (tau) => {
        "tau : array_like, shape (..., nv)\n    Torques [N·m or N].\n"
    };
    (d) => {
        "d : array_like, shape (..., nv)\n    Displacement, a velocity times a time [rad or m].\n"
    };
    (s) => {
        "s : array_like, shape (...)\n    Fraction of the way: 0 at `q0`, 1 at `q1`.\n"
    };
    (cotangent) => {
        "cotangent : array_like, shape (..., nv)\n    Gradient, one number for each degree of freedom.\n"
    };
    (direction) => {
        concat!(
            "direction : array_like, shape (..., 3·nv)\n",
            "    Direction: a displacement of q, then changes of the next two arguments.\n",
        )
    };
    (weights) => {
        "weights : array_like, shape (..., 6)\n    Multipliers of the motion: linear, then angular.\n"
    };
    (coordinates) => {
        "coordinates : array_like, shape (..., nq)\n    Gradient by the numbers of q.\n"
    };
    (frame) => {
        "frame : str or int\n    Name of the frame, or its index in `frame_names`.\n"
    };
    (reference_frame) => {
        concat!(
            "reference_frame : {\"local\", \"world\", \"local_world_aligned\"}\n",
            "    ``local`` is the frame's axes and its origin, ``world`` the world's axes and the world's origin,\n",
            "    ``local_world_aligned`` the world's axes and the frame's origin.\n",
        )
    };
}

/// The argument `out`.
macro_rules! out {
    ([$shape:ident$(($rows:literal))?]) => {
        concat!(
            "out : ndarray, shape ",
            $crate::rows::sections::shape!($shape$(($rows))?),
            ", optional\n    Array that receives the result.\n",
        )
    };
    ($class:ident [$($shapes:tt)*]) => {
        "out : tuple of ndarray, optional\n    Arrays that receive the results.\n"
    };
}

/// The result, or a field of the class of several results.
macro_rules! result {
    (Scalar $text:literal) => {
        concat!("float or ndarray, shape (...)\n    ", $text, "\n")
    };
    ($shape:ident$(($rows:literal))? $text:literal) => {
        concat!("ndarray, shape ", $crate::rows::sections::shape!($shape$(($rows))?), "\n    ", $text, "\n")
    };
    ($shape:ident$(($rows:literal))? $field:ident $text:literal) => {
        concat!(
            "    `",
            stringify!($field),
            "` ",
            $crate::rows::sections::shape!($shape$(($rows))?),
            ": ",
            $text,
            ".\n",
        )
    };
}

/// A shape, with the dimensions of a batch.
macro_rules! shape {
    (Scalar) => {
        "(...)"
    };
    (Point) => {
        "(..., 3)"
    };
    (Six) => {
        "(..., 6)"
    };
    (Configuration) => {
        "(..., nq)"
    };
    (Vector) => {
        "(..., nv)"
    };
    (Square) => {
        "(..., nv, nv)"
    };
    (Cube) => {
        "(..., nv, nv, nv)"
    };
    (SixSquares) => {
        "(..., 6, nv, nv)"
    };
    (Direction) => {
        "(..., 3·nv)"
    };
    (Hessian) => {
        "(..., 3·nv, 3·nv)"
    };
    (StateHessian) => {
        "(..., 2·nv, 2·nv)"
    };
    (Rows($rows:literal)) => {
        concat!("(..., ", $rows, ", nv)")
    };
    (Parameters) => {
        "(..., 10·moving links)"
    };
    (AllParameters) => {
        "(..., parameters)"
    };
    (Regressor) => {
        "(..., nv, 10·moving links)"
    };
    (Pose) => {
        "(..., 4, 4)"
    };
}

/// An error by its class, or by the argument that causes it.
macro_rules! error {
    (SingularMassError) => {
        "SingularMassError\n    M(q) is singular.\n"
    };
    (frame) => {
        "FrameError\n    The frame does not exist.\n"
    };
    (reference_frame) => {
        "ValueError\n    `reference_frame` is unknown.\n"
    };
}

pub(super) use {argument, error, out, result, sections, shape};
