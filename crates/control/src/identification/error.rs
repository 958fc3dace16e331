//! Errors of parameter identification.

use robot_dynamics_number::{Classified, ErrorKind, InputProblem, InvalidInput, check_finite};
use thiserror::Error;

/// The error of [`BaseParameters::identify`](crate::BaseParameters::identify).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentificationError {
    /// There are fewer equations than unknown parameters.
    #[error(
        "{equations} equations for {unknowns} base parameters; record at least {} more states",
        .unknowns.saturating_sub(*.equations).div_ceil((*.coordinates).max(1))
    )]
    TooFewData {
        /// The number of rows of W.
        equations: usize,
        /// The number of base parameters.
        unknowns: usize,
        /// nv.
        coordinates: usize,
    },
    /// The data do not excite all of the base parameters.
    #[error(
        "the data determine {rank} of the {unknowns} base parameters; not `{missing}`, for one: move more of the robot"
    )]
    NotExcited {
        /// The rank of W on the base columns.
        rank: usize,
        /// The number of base parameters.
        unknowns: usize,
        /// The base parameter that is determined worst.
        missing: String,
    },
    /// The nominal parameters of a link are those of a point, a rod or a plate without thickness, or of no
    /// body.
    #[error(
        "the nominal inertia of `{link}` is flat or impossible: state a least radius of gyration, better nominal parameters, or hold the link"
    )]
    SingularNominal {
        /// The link.
        link: String,
    },
    /// The iteration did not converge.
    #[error("the estimate did not converge in {steps} steps; the data and the noise may be badly scaled")]
    NotConverged {
        /// The number of steps taken.
        steps: usize,
    },
    /// A sample or a list of parameters is invalid, or a result overflows.
    #[error(transparent)]
    Input(#[from] InvalidInput),
}

impl Classified for IdentificationError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Input(error) => error.kind(),
            Self::TooFewData { .. } | Self::NotExcited { .. } | Self::SingularNominal { .. } => {
                ErrorKind::Infeasible
            }
            Self::NotConverged { .. } => ErrorKind::NotConverged,
        }
    }
}

/// Checks that a list has ten finite inertial parameters for each moving link.
pub(super) fn check_inertial_parameters(parameters: &[f64], expected: usize) -> Result<(), InvalidInput> {
    let (found, hint) = (parameters.len(), ", ten for each moving link");
    if found != expected {
        let problem = InputProblem::WrongLength { found, expected, owner: "the robot".into(), hint };
        return Err(InvalidInput::new("the list of inertial parameters", problem));
    }
    check_finite("the inertial parameters", parameters)
}
