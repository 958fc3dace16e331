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
        JsError::new(&error.message).into()
    }
}
