//! What the page is told when a call cannot be answered.

use core::fmt;

use wasm_bindgen::{JsError, JsValue};

/// A message for the person at the page: what is wrong, where, and what to do.
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

/// Every error of the library keeps its own words.
impl<E: core::error::Error> From<E> for LabError {
    fn from(error: E) -> Self {
        Self::new(error.to_string())
    }
}

impl From<LabError> for JsValue {
    fn from(error: LabError) -> Self {
        JsError::new(&seen(&error.message)).into()
    }
}

/// A message with names from files as text.
#[cfg(feature = "robots")]
fn seen(message: &str) -> std::borrow::Cow<'_, str> {
    multibody::text::lines(message)
}

/// The other modules read no files.
#[cfg(not(feature = "robots"))]
fn seen(message: &str) -> &str {
    message
}
