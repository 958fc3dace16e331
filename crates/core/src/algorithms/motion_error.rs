//! Errors of quantities of motion.

use thiserror::Error;

use crate::{ConfigurationError, Model, SingularMass};

/// An invalid state, or a robot that is singular in that state.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MotionError {
    /// Invalid configuration q.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// A vector over the DoFs has the wrong length.
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
    /// An input is NaN or infinite.
    #[error("{quantity}[{index}] (coordinate `{coordinate}`) is {value}; every number must be finite")]
    NotFinite {
        /// `v`, `a` or `tau`.
        quantity: &'static str,
        /// The index in the vector.
        index: usize,
        /// The coordinate's name, as in [`Model::coordinate_names`].
        coordinate: String,
        /// Its value.
        value: f64,
    },
    /// The inputs are finite, but the result is not.
    #[error("{quantity} is {value}: the numbers given are too large to compute it; check their units")]
    Overflow {
        /// The name of the result.
        quantity: &'static str,
        /// The value computed.
        value: f64,
    },
    /// No link has mass, so the centre of mass is undefined.
    #[error("robot `{robot}` has no mass, and so no centre of mass; give its links masses")]
    NoMass {
        /// The robot's name.
        robot: String,
    },
    /// The operation inverts the mass matrix, which is not positive definite in this configuration.
    #[error(transparent)]
    SingularMass(#[from] SingularMass),
}

/// Rejects a vector over the DoFs that has the wrong length or a number that is not finite.
pub fn check_vector(model: &Model, quantity: &'static str, x: &[f64]) -> Result<(), MotionError> {
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

/// Rejects a result that overflowed.
pub fn check_result(quantity: &'static str, results: &[f64]) -> Result<(), MotionError> {
    match results.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(MotionError::Overflow { quantity, value }),
        None => Ok(()),
    }
}
