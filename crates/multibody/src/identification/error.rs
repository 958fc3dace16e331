//! Why data give no parameters.

use thiserror::Error;

/// Why data give no parameters.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentificationError {
    /// Fewer equations than parameters to find.
    #[error(
        "{equations} equations for {unknowns} base parameters; record at least {} more states",
        (.unknowns - .equations).div_ceil((*.coordinates).max(1))
    )]
    TooFewData {
        /// Rows of W.
        equations: usize,
        /// Base parameters.
        unknowns: usize,
        /// nv.
        coordinates: usize,
    },
    /// A sample that is not finite, or no configuration.
    #[error("sample {sample}: {reason}")]
    BadSample {
        /// Which sample.
        sample: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// The data do not excite what the base parameters were found from.
    #[error(
        "the data determine {rank} of the {unknowns} base parameters; not `{missing}`, for one: move more of the robot"
    )]
    NotExcited {
        /// The rank of W on the base columns.
        rank: usize,
        /// Base parameters.
        unknowns: usize,
        /// The worst-determined one.
        missing: String,
    },
    /// A list of parameters of the wrong length.
    #[error("{found} inertial parameters, the robot has {expected}")]
    WrongLength {
        /// Numbers given.
        found: usize,
        /// Numbers needed.
        expected: usize,
    },
}
