//! Arguments as arrays: the accepted types and shapes, and the errors for all others.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::model::Model;

use crate::errors::Class;
use crate::ffi::{Array, Kind};
use crate::row::{Operand, Width};

/// An argument as a plain array of float64 or float32, with the dimensions before its own.
#[derive(Debug)]
pub(crate) struct ArrayArgument<'py> {
    pub(crate) name: &'static str,
    pub(crate) array: Bound<'py, PyAny>,
    pub(crate) kind: Kind,
    /// The whole shape, as it was given.
    pub(crate) shape: Vec<usize>,
    /// How many axes are those of the batch.
    pub(crate) leading: usize,
}

impl ArrayArgument<'_> {
    pub(crate) fn lead(&self) -> &[usize] {
        &self.shape[..self.leading]
    }
}

/// The module numpy.
pub(crate) fn numpy(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("numpy")
}

/// A shape as Python writes it.
pub(crate) fn shown(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// The argument as an array; `first` is the type of the first argument.
pub(crate) fn given<'py>(
    py: Python<'py>,
    model: &Model,
    operand: &Operand,
    frames: usize,
    object: &Bound<'py, PyAny>,
    first: Option<Kind>,
) -> PyResult<ArrayArgument<'py>> {
    let name = operand.name;
    let mut array = as_array(py, name, object)?;
    if let (Width::One, Some(kind), None) = (operand.width, first, Array::of(object)) {
        // A number that is not an array has no type of its own. It takes the type of the others, as in numpy.
        array = array.call_method1("astype", (dtype(kind),))?;
    }
    let (array, kind) = as_floats(py, name, array)?;
    let header = Array::of(&array).ok_or_else(|| PyTypeError::new_err(format!("{name} is no array")))?;
    let (shape, own) = (header.shape.to_vec(), operand.width.dims(model, frames));
    let own = own.as_slice();
    let Some(leading) = shape.len().checked_sub(own.len()).filter(|leading| &shape[*leading..] == own) else {
        return Err(wrong_shape(py, model, operand, &shape, own));
    };
    Ok(ArrayArgument { name, array, kind, shape, leading })
}

#[cold]
fn wrong_shape(py: Python<'_>, model: &Model, operand: &Operand, found: &[usize], own: &[usize]) -> PyErr {
    let expected = own.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let hint = match (operand.width, found.last()) {
        (Width::Nq, Some(&last)) if last == model.nv() && model.nq() > model.nv() => {
            "; a quaternion (x y z w) takes four, a floating base seven"
        }
        _ => "",
    };
    Class::Shape.error(
        py,
        format!(
            "{} has shape {}, robot `{}` needs {} or (..., {expected}): {}{hint}",
            operand.name,
            shown(found),
            model.name(),
            shown(own),
            operand.width.meaning(model),
        ),
    )
}

/// numpy's view of anything that offers one; numbers and lists of them become float64.
pub(crate) fn as_array<'py>(
    py: Python<'py>,
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    if Array::of(object).is_some() {
        return Ok(object.clone());
    }
    let numpy = numpy(py)?;
    let made = if object.hasattr("__array__")? || !object.hasattr("__dlpack__")? {
        numpy.call_method1("asarray", (object,))
    } else {
        numpy.call_method1("from_dlpack", (object,))
    };
    made.map_err(|cause| {
        let error = Class::DType
            .error(py, format!("{name}, a {}, cannot be seen as an array: {cause}", type_name(object)));
        error.set_cause(py, Some(cause));
        error
    })
}

fn type_name(object: &Bound<'_, PyAny>) -> String {
    object.get_type().name().map_or_else(|_| "object".into(), |name| name.to_string())
}

/// The same numbers as float64 or float32, contiguous and aligned: the array itself, or a copy.
pub(crate) fn as_floats<'py>(
    py: Python<'py>,
    name: &str,
    array: Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, Kind)> {
    let Some(Array { kind, is_plain, .. }) = Array::of(&array) else {
        return Err(PyTypeError::new_err(format!("{name} is no array")));
    };
    if is_plain && kind != Kind::Other {
        return Ok((array, kind));
    }
    let (target, kind) = match kind {
        Kind::F64 => ("float64", Kind::F64),
        Kind::F32 => ("float32", Kind::F32),
        Kind::Other => {
            let dtype = array.getattr("dtype")?;
            let sort: String = dtype.getattr("kind")?.extract()?;
            if sort != "i" && sort != "u" {
                return Err(Class::DType.error(
                    py,
                    format!(
                        "{name} has dtype {dtype}; float64 and float32 are computed with: convert it yourself, \
                         for example {name}.astype(np.float64)"
                    ),
                ));
            }
            ("float64", Kind::F64)
        }
    };
    let options = PyDict::new(py);
    options.set_item("dtype", target)?;
    options.set_item("order", "C")?;
    // `asarray` keeps a shape of no axes, which `ascontiguousarray` does not.
    let array = numpy(py)?.call_method("asarray", (array,), Some(&options))?;
    let array = match Array::of(&array) {
        Some(header) if header.is_plain => array,
        _ => array.call_method1("copy", ("C",))?,
    };
    Ok((array, kind))
}

/// The one type of all arguments.
pub(crate) fn common_kind(py: Python<'_>, all: &[ArrayArgument<'_>]) -> PyResult<Kind> {
    let Some(first) = all.first() else { return Ok(Kind::F64) };
    match all.iter().find(|given| given.kind != first.kind) {
        None => Ok(first.kind),
        Some(other) => Err(Class::DType.error(
            py,
            format!(
                "{} is {} and {} is {}: nothing is converted silently; make them one (lists and integers are \
                 float64)",
                first.name,
                dtype(first.kind),
                other.name,
                dtype(other.kind),
            ),
        )),
    }
}

pub(crate) fn dtype(kind: Kind) -> &'static str {
    match kind {
        Kind::F32 => "float32",
        Kind::F64 | Kind::Other => "float64",
    }
}

/// The dimensions of the batch: each argument's, broadcast as numpy broadcasts.
pub(crate) fn common_lead(py: Python<'_>, all: &[ArrayArgument<'_>]) -> PyResult<Vec<usize>> {
    let axes = all.iter().map(|given| given.leading).max().unwrap_or(0);
    let mut lead = vec![1; axes];
    for given in all {
        for (common, &own) in lead[axes - given.leading..].iter_mut().zip(given.lead()) {
            if *common == 1 {
                *common = own;
            } else if own != 1 && own != *common {
                return Err(do_not_broadcast(py, all));
            }
        }
    }
    Ok(lead)
}

#[cold]
fn do_not_broadcast(py: Python<'_>, all: &[ArrayArgument<'_>]) -> PyErr {
    let shapes: Vec<_> =
        all.iter().map(|given| format!("{} has shape {}", given.name, shown(&given.shape))).collect();
    let leads: Vec<_> = all.iter().map(|given| shown(given.lead())).collect();
    Class::Shape.error(
        py,
        format!("{}: the leading dimensions {} do not broadcast", shapes.join(", "), leads.join(" and ")),
    )
}

/// An argument in the shape of the whole batch, where it is neither that already nor one state for all.
pub(crate) fn spread<'py>(py: Python<'py>, given: &mut ArrayArgument<'py>, lead: &[usize]) -> PyResult<()> {
    let states: usize = given.lead().iter().product();
    if given.lead() == lead || states == 1 || states == lead.iter().product::<usize>() {
        return Ok(());
    }
    let shape: Vec<usize> = lead.iter().chain(&given.shape[given.leading..]).copied().collect();
    let numpy = numpy(py)?;
    let wide = numpy.call_method1("broadcast_to", (&given.array, shape.clone()))?;
    given.array = numpy.call_method1("ascontiguousarray", (wide,))?;
    (given.leading, given.shape) = (lead.len(), shape);
    Ok(())
}
