//! Arguments and results in float64, for methods that are not rows of the table.

use pyo3::BoundObject;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::description::Pose;
use robot_dynamics::model::check_configuration;
use robot_dynamics::nalgebra::DMatrix;

use crate::errors::{Class, exception};
use crate::ffi::{self, Array, Kind};
use crate::operand::{as_array, as_floats, shown};
use crate::outcome;
use crate::results::MOST_RESULTS;
use crate::robot::Robot;

/// The numbers of an argument, and its shape.
pub(crate) fn numbers(
    py: Python<'_>,
    name: &str,
    object: &Bound<'_, PyAny>,
) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let (array, kind) = as_floats(py, name, as_array(py, name, object)?)?;
    if kind != Kind::F64 {
        return Err(Class::DType.error(py, format!("{name} is float32; this is computed in float64 alone")));
    }
    let Some(header) = Array::of(&array) else { return Ok((Vec::new(), Vec::new())) };
    let none = Array::NONE;
    let read = ffi::slices::<f64>(&[header, none, none, none, none], &[none; MOST_RESULTS]);
    Ok((header.shape.to_vec(), read.map_or_else(Vec::new, |([x, ..], _)| x.to_vec())))
}

/// An argument of that shape; `usize::MAX` stands for any length.
pub(crate) fn shaped(
    py: Python<'_>,
    name: &str,
    object: &Bound<'_, PyAny>,
    shape: &[usize],
) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let (found, numbers) = numbers(py, name, object)?;
    let fits = found.len() == shape.len()
        && found.iter().zip(shape).all(|(found, asked)| *asked == usize::MAX || found == asked);
    if fits {
        return Ok((found, numbers));
    }
    let asked = shown(shape).replace(&usize::MAX.to_string(), "n");
    Err(Class::Shape.error(py, format!("{name} has shape {}, it must have {asked}", shown(&found))))
}

/// N numbers.
pub(crate) fn several<const N: usize>(name: &str, object: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    let (_, x) = shaped(object.py(), name, object, &[N])?;
    let mut numbers = [0.0; N];
    numbers.copy_from_slice(&x);
    Ok(numbers)
}

/// The linear and the angular part of six numbers.
pub(crate) fn halves(x: [f64; 6]) -> [[f64; 3]; 2] {
    [[x[0], x[1], x[2]], [x[3], x[4], x[5]]]
}

/// nv finite numbers.
pub(crate) fn vector(
    py: Python<'_>,
    robot: &Robot,
    name: &str,
    object: &Bound<'_, PyAny>,
) -> PyResult<Vec<f64>> {
    let (_, x) = shaped(py, name, object, &[robot.model.nv()])?;
    match x.iter().position(|x| !x.is_finite()) {
        None => Ok(x),
        Some(index) => {
            Err(Class::State
                .error(py, format!("{name}[{index}] is {}; every number must be finite", x[index])))
        }
    }
}

/// nv finite numbers, zeros by default.
pub(crate) fn vector_or_zeros(
    py: Python<'_>,
    robot: &Robot,
    name: &str,
    object: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<f64>> {
    object.map_or_else(|| Ok(vec![0.0; robot.model.nv()]), |object| vector(py, robot, name, object))
}

/// A configuration.
pub(crate) fn configuration(py: Python<'_>, robot: &Robot, object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let (_, q) = shaped(py, "q", object, &[robot.model.nq()])?;
    check_configuration(&robot.model, &q).map_err(exception)?;
    Ok(q)
}

/// The pose of the sixteen numbers of a homogeneous matrix.
pub(crate) fn pose_of(m: &[f64]) -> Pose {
    let row = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
    Pose { rotation: [row(0), row(1), row(2)], translation: [m[3], m[7], m[11]] }
}

/// A matrix by its rows.
pub(crate) fn matrix(py: Python<'_>, name: &str, object: &Bound<'_, PyAny>) -> PyResult<DMatrix<f64>> {
    let (shape, numbers) = shaped(py, name, object, &[usize::MAX, usize::MAX])?;
    Ok(DMatrix::from_row_slice(shape[0], shape[1], &numbers))
}

/// A new array of a matrix.
pub(crate) fn array_of<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Bound<'py, PyAny>> {
    outcome::filled(py, &[matrix.nrows(), matrix.ncols()], matrix.transpose().as_slice())
}

/// A new array of one axis.
pub(crate) fn array<'py>(py: Python<'py>, numbers: &[f64]) -> PyResult<Bound<'py, PyAny>> {
    outcome::filled(py, &[numbers.len()], numbers)
}

/// Named results, which the Python half makes objects of.
pub(crate) fn record<'py, const N: usize>(
    py: Python<'py>,
    fields: [(&str, Bound<'py, PyAny>); N],
) -> PyResult<Bound<'py, PyDict>> {
    let record = PyDict::new(py);
    for (name, value) in fields {
        record.set_item(name, value)?;
    }
    Ok(record)
}

/// Any value as an object.
pub(crate) fn object<'py, T: IntoPyObject<'py>>(py: Python<'py>, value: T) -> PyResult<Bound<'py, PyAny>>
where
    PyErr: From<T::Error>,
{
    Ok(value.into_pyobject(py)?.into_bound().into_any())
}
