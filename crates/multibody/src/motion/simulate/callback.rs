//! What a function handed to the library answers: a value, or a `Result` where it can fail.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

/// An error of a function handed to the library, kept as it was given.
///
/// Two are equal when their messages are.
#[derive(Clone, Debug)]
pub struct CallbackError(Arc<dyn Error + Send + Sync>);

impl CallbackError {
    /// From any error, or from a message.
    pub fn new(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self(Arc::from(error.into()))
    }

    /// The error in the type it was given in, if that is `E`.
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

impl PartialEq for CallbackError {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.to_string() == other.to_string()
    }
}

/// What a function that should answer a `T` may return: a `T`, or `Result<T, E>` with any error (a message, too).
pub trait Outcome<T> {
    /// The answer.
    ///
    /// # Errors
    /// What the function says.
    fn outcome(self) -> Result<T, CallbackError>;
}

impl<T> Outcome<T> for T {
    fn outcome(self) -> Result<T, CallbackError> {
        Ok(self)
    }
}

impl<T, E: Into<Box<dyn Error + Send + Sync>>> Outcome<T> for Result<T, E> {
    fn outcome(self) -> Result<T, CallbackError> {
        self.map_err(CallbackError::new)
    }
}
