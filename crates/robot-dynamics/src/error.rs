//! The error that every error of the library converts to.

use std::error;
use std::fmt;

use robot_dynamics_number::{Classified, ErrorKind};

/// Any error of the library.
///
/// Every function returns an error of its own type, with the numbers and names at fault. All of these types
/// implement [`Classified`] and convert to this one, so that `?` works in a function that calls several parts
/// of the library. The text is that of the original error.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::{Error, ErrorKind};
/// fn torque(step: f64) -> Result<f64, Error> {
///     let model = Model::new(pendulum(2.0, 0.5))?; // ModelError
///     let mut simulation = robot_dynamics::simulation(&model).dt(step).build()?; // SimulationError
///     simulation.step()?; // RunError
///     Ok(model.gravity_forces(simulation.q())?[0]) // MotionError
/// }
/// assert!(torque(1e-3).is_ok());
/// let error = torque(-1.0).expect_err("a negative step");
/// assert_eq!(error.kind(), ErrorKind::InvalidInput);
/// assert_eq!(error.to_string(), "the step must be positive and finite, got -1 s");
/// ```
pub struct Error {
    kind: ErrorKind,
    leaf: Box<dyn error::Error + Send + Sync>,
}

impl Error {
    /// The kind: bad input, a singular robot, an iteration that did not converge, and so on.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// The original error, if it is an `E`.
    ///
    /// ```
    /// use robot_dynamics::description::ModelError;
    /// let error = robot_dynamics::Error::from(ModelError::NoLinks);
    /// assert_eq!(error.downcast_ref(), Some(&ModelError::NoLinks));
    /// ```
    pub fn downcast_ref<E: error::Error + 'static>(&self) -> Option<&E> {
        self.leaf.downcast_ref()
    }

    /// The original error, or this one if it is not an `E`.
    ///
    /// # Errors
    /// This error, unchanged.
    pub fn downcast<E: error::Error + 'static>(self) -> Result<E, Self> {
        let kind = self.kind;
        self.leaf.downcast().map(|leaf| *leaf).map_err(|leaf| Self { kind, leaf })
    }
}

impl<E: Classified> From<E> for Error {
    fn from(error: E) -> Self {
        Self { kind: error.kind(), leaf: Box::new(error) }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.leaf, f)
    }
}

/// The same text as `Display`, because a `main` that returns an error prints its `Debug` form.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl error::Error for Error {
    fn source(&self) -> Option<&(dyn error::Error + 'static)> {
        self.leaf.source()
    }
}
