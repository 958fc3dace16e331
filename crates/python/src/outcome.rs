//! Results as objects: new arrays, or those of `out=`.

use numpy::{IxDyn, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PySequence, PyTuple};
use robot_dynamics::model::Model;

use crate::errors::Class;
use crate::ffi::{Array, ArrayNumber, Kind};
use crate::operand::{dtype, numpy, shown};
use crate::row::Row;

/// A new array of zeros.
pub(crate) fn new<'py, T: ArrayNumber>(py: Python<'py>, shape: &[usize]) -> Bound<'py, PyAny> {
    PyArrayDyn::<T>::zeros(py, IxDyn(shape), false).into_any()
}

/// A new array of these numbers.
pub(crate) fn filled<'py, T: ArrayNumber>(
    py: Python<'py>,
    shape: &[usize],
    numbers: &[T],
) -> PyResult<Bound<'py, PyAny>> {
    PyArray1::<T>::from_slice(py, numbers).reshape(IxDyn(shape)).map(Bound::into_any)
}

/// The exception that has the indices of bad states and the result of all others.
#[cold]
pub(crate) fn bad_states<'py>(
    py: Python<'py>,
    bad: &[usize],
    message: String,
    result: Bound<'py, PyAny>,
) -> PyResult<PyErr> {
    let indices = numpy(py)?.call_method1("array", (bad.to_vec(), "intp"))?;
    Ok(Class::BadStates.error_with(py, message, &[("indices", indices), ("result", result)]))
}

/// The arrays that a call writes into, and the arrays of `out=`.
pub(crate) struct OutputArrays<'py> {
    /// An array for each result, which the algorithm writes.
    pub(crate) arrays: Vec<Bound<'py, PyAny>>,
    /// The object given as `out=`, and its arrays.
    wanted: Option<(Bound<'py, PyAny>, Vec<Bound<'py, PyAny>>)>,
    /// Whether the call writes into other arrays, whose numbers are then copied to those of `out=`.
    is_apart: bool,
}

impl<'py> OutputArrays<'py> {
    /// Arrays for the results of a batch of these dimensions: those of `out=` if they can be written
    /// directly.
    pub(crate) fn of<T: ArrayNumber>(
        py: Python<'py>,
        model: &Model,
        row: &Row,
        frames: usize,
        lead: &[usize],
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let shapes: Vec<Vec<usize>> = row
            .results
            .iter()
            .map(|shape| lead.iter().chain(shape.dims(model, frames).as_slice()).copied().collect())
            .collect();
        let fresh = || shapes.iter().map(|shape| new::<T>(py, shape)).collect();
        let Some(out) = out else {
            return Ok(Self { arrays: fresh(), wanted: None, is_apart: false });
        };
        let parts = parts(out, row.results.len())?;
        for (part, shape) in parts.iter().zip(&shapes) {
            check(py, part, shape, T::KIND)?;
        }
        for (k, part) in parts.iter().enumerate() {
            for other in &parts[..k] {
                if numpy(py)?.call_method1("may_share_memory", (part, other))?.is_truthy()? {
                    return Err(PyValueError::new_err(
                        "two results cannot be written to one memory: out overlaps itself",
                    ));
                }
            }
        }
        let are_plain = parts.iter().all(|part| Array::of(part).is_some_and(|array| array.is_plain));
        let arrays = if are_plain { parts.clone() } else { fresh() };
        Ok(Self { arrays, wanted: Some((out.clone(), parts)), is_apart: !are_plain })
    }

    /// Writes into new arrays instead, because those of `out=` overlap an argument.
    pub(crate) fn set_apart<T: ArrayNumber>(&mut self, py: Python<'py>) {
        let apart =
            |array: &Bound<'py, PyAny>| new::<T>(py, Array::of(array).map_or(&[][..], |header| header.shape));
        self.arrays = self.arrays.iter().map(apart).collect();
        self.is_apart = true;
    }

    /// The results as Python sees them.
    pub(crate) fn finish(self, py: Python<'py>, row: &Row) -> PyResult<Bound<'py, PyAny>> {
        let Some((out, parts)) = self.wanted else { return collected(py, row, self.arrays) };
        if self.is_apart {
            let numpy = numpy(py)?;
            for (to, from) in parts.iter().zip(&self.arrays) {
                numpy.call_method1("copyto", (to, from))?;
            }
        }
        Ok(out)
    }
}

/// `out=` of one result, or of several as a tuple or list.
fn parts<'py>(out: &Bound<'py, PyAny>, results: usize) -> PyResult<Vec<Bound<'py, PyAny>>> {
    if results == 1 {
        return Ok(vec![out.clone()]);
    }
    let wrong =
        || PyTypeError::new_err(format!("out must be a tuple of {results} arrays, one for each result"));
    let sequence = out.cast::<PySequence>().map_err(|_| wrong())?;
    if sequence.len()? != results {
        return Err(wrong());
    }
    (0..results).map(|k| sequence.get_item(k)).collect()
}

fn check(py: Python<'_>, out: &Bound<'_, PyAny>, shape: &[usize], kind: Kind) -> PyResult<()> {
    let Some(array) = Array::of(out) else {
        return Err(PyTypeError::new_err(
            "out must be a numpy array: what is written to must be seen by its owner",
        ));
    };
    if array.shape != shape {
        let (found, expected) = (shown(array.shape), shown(shape));
        return Err(Class::Shape.error(py, format!("out has shape {found}, the result {expected}")));
    }
    if array.kind != kind {
        let (found, expected) = (out.getattr("dtype")?, dtype(kind));
        return Err(Class::DType
            .error(py, format!("out has dtype {found}, the result is {expected}, as what is given")));
    }
    if !array.is_writeable {
        return Err(PyValueError::new_err("out is read-only"));
    }
    Ok(())
}

/// One result, or the named tuple of several; a result without axes is a number.
pub(crate) fn collected<'py>(
    py: Python<'py>,
    row: &Row,
    mut arrays: Vec<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    if arrays.len() > 1 {
        return named(py, row.name, arrays);
    }
    let Some(array) = arrays.pop() else { return Ok(py.None().into_bound(py)) };
    match Array::of(&array) {
        Some(Array { shape: [], .. }) => array.get_item(PyTuple::empty(py)),
        _ => Ok(array),
    }
}

/// The named tuple of an algorithm with several results.
pub(crate) fn named<'py>(
    py: Python<'py>,
    algorithm: &str,
    values: Vec<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    static CLASSES: PyOnceLock<Py<PyDict>> = PyOnceLock::new();
    let classes = CLASSES.get_or_try_init(py, || {
        let classes = py.import("robot_dynamics.results")?.getattr("BY_ALGORITHM")?;
        PyResult::Ok(classes.cast_into::<PyDict>()?.unbind())
    })?;
    match classes.bind(py).get_item(algorithm)? {
        Some(class) => class.call1(PyTuple::new(py, values)?),
        None => Ok(PyTuple::new(py, values)?.into_any()),
    }
}
