//! The fields of a contact.

use pyo3::prelude::*;

/// A row of contacts: both links and shapes, ground, point, normal, gap, force, moment.
pub(super) type ContactFields<'py> = (
    String,
    String,
    Option<String>,
    String,
    Option<usize>,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    f64,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
);
