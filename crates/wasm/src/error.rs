//! Errors of calls from the page.

use core::fmt;

use wasm_bindgen::{JsError, JsValue};

/// A message for the user of the page: the problem, its place, and a remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabError {
    message: String,
}

impl LabError {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into() }
    }
}

impl fmt::Display for LabError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Keeps the messages of the library's errors.
impl<E: core::error::Error> From<E> for LabError {
    fn from(error: E) -> Self {
        Self::new(error.to_string())
    }
}

impl From<LabError> for JsValue {
    fn from(error: LabError) -> Self {
        JsError::new(&escape_message(&error.message)).into()
    }
}

/// A message in which names from files are escaped.
#[cfg(feature = "robots")]
fn escape_message(message: &str) -> std::borrow::Cow<'_, str> {
    robot_dynamics::text::lines(message)
}

/// The other modules read no files.
#[cfg(not(feature = "robots"))]
fn escape_message(message: &str) -> &str {
    message
}
