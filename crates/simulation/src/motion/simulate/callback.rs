//! Results of callbacks: a value, or a `Result` if the callback can fail.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use robot_dynamics_number::{Classified, ErrorKind};

/// An error of a callback, stored without change.
///
/// Two errors are equal if their messages are equal.
#[derive(Clone, Debug)]
pub struct CallbackError(Arc<dyn Error + Send + Sync>);

impl CallbackError {
    /// Wraps any error, or a message.
    pub fn new(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self(Arc::from(error.into()))
    }

    /// The error in its original type, if that is `E`.
    pub fn downcast_ref<E: Error + 'static>(&self) -> Option<&E> {
        self.0.downcast_ref()
    }
}

impl fmt::Display for CallbackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for CallbackError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.0.source()
    }
}

impl Classified for CallbackError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Callback
    }
}

impl PartialEq for CallbackError {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.to_string() == other.to_string()
    }
}

/// The return type of a callback that computes a `T`: either `T`, or `Result<T, E>` with any error or
/// message.
#[doc(alias = "Outcome")]
pub trait IntoCallbackResult<T> {
    /// Converts to a result.
    ///
    /// # Errors
    /// The error of the callback.
    fn outcome(self) -> Result<T, CallbackError>;
}

impl<T> IntoCallbackResult<T> for T {
    fn outcome(self) -> Result<T, CallbackError> {
        Ok(self)
    }
}

impl<T, E: Into<Box<dyn Error + Send + Sync>>> IntoCallbackResult<T> for Result<T, E> {
    fn outcome(self) -> Result<T, CallbackError> {
        self.map_err(CallbackError::new)
    }
}
