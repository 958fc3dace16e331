//! Why a quantity of motion could not be computed.

use thiserror::Error;

use crate::{ConfigurationError, Model, SingularMass};

/// What is wrong with a state, or with the robot in that state.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MotionError {
    /// q is not a configuration.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// A vector over the freedoms has too many or too few numbers.
    #[error(
        "{quantity} has {found} numbers, robot `{robot}` needs {expected}, one for each degree of freedom"
    )]
    WrongLength {
        /// `v`, `a` or `tau`.
        quantity: &'static str,
        /// The robot's name.
        robot: String,
        /// Numbers given.
        found: usize,
        /// Numbers needed.
        expected: usize,
    },
    /// A number given is NaN or infinite.
    #[error("{quantity}[{index}] (coordinate `{coordinate}`) is {value}; every number must be finite")]
    NotFinite {
        /// `v`, `a` or `tau`.
        quantity: &'static str,
        /// Which number.
        index: usize,
        /// The coordinate's name, as in [`Model::coordinate_names`].
        coordinate: String,
        /// Its value.
        value: f64,
    },
    /// The numbers given are finite, what follows from them is not.
    #[error("{quantity} is {value}: the numbers given are too large to compute it; check their units")]
    Overflow {
        /// Which result.
        quantity: &'static str,
        /// What came out.
        value: f64,
    },
    /// No link has mass, so there is no centre of mass.
    #[error("robot `{robot}` has no mass, and so no centre of mass; give its links masses")]
    NoMass {
        /// The robot's name.
        robot: String,
    },
    /// The mass matrix is not positive definite in this configuration, and its inverse was asked for.
    #[error(transparent)]
    SingularMass(#[from] SingularMass),
}

/// Refuses a vector over the freedoms that has the wrong length or a number that is not finite.
pub(crate) fn check_vector(model: &Model, quantity: &'static str, x: &[f64]) -> Result<(), MotionError> {
    if x.len() != model.nv() {
        let robot = model.name().to_owned();
        return Err(MotionError::WrongLength { quantity, robot, found: x.len(), expected: model.nv() });
    }
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => {
            let coordinate = model.coordinate_names().swap_remove(index);
            Err(MotionError::NotFinite { quantity, index, coordinate, value: x[index] })
        }
        None => Ok(()),
    }
}

/// Refuses a result that overflowed.
pub(crate) fn check_result(quantity: &'static str, results: &[f64]) -> Result<(), MotionError> {
    match results.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(MotionError::Overflow { quantity, value }),
        None => Ok(()),
    }
}
