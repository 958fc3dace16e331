//! An algorithm on one state.

use pyo3::prelude::*;
use robot_dynamics::algorithms::check_rank;
use robot_dynamics::model::{FrameId, check_configuration};
use robot_dynamics::quantity::{Input, Inputs, Quantity};

use crate::errors::Class;
use crate::ffi::{self, Array};
use crate::number::Number;
use crate::outcome;
use crate::results::{MOST_OPERANDS, MOST_RESULTS, Results};
use crate::robot::Robot;
use crate::row::{Row, Shape, Width, Work};
use crate::scratch::Scratch;
use robot_dynamics::description::Pose;

/// The fastest path, for arguments that are all suitable arrays of one state. `None` if one is not; the
/// general path then computes the result or finds the error.
#[inline]
pub(crate) fn at_once<'py>(
    py: Python<'py>,
    robot: &Robot,
    row: &Row,
    operands: &[&Bound<'py, PyAny>],
    frames: &[FrameId],
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let mut read = [Array::NONE; MOST_OPERANDS];
    for ((read, object), operand) in read.iter_mut().zip(operands).zip(row.operands) {
        match Array::of(object) {
            Some(array) if array.shape == operand.width.dims(&robot.model, frames.len()).as_slice() => {
                *read = array;
            }
            _ => return Ok(None),
        }
    }
    let Some(out) = out else {
        let mut arrays = Vec::with_capacity(row.results.len());
        for shape in row.results {
            arrays.push(outcome::new::<f64>(py, shape.dims(&robot.model, frames.len()).as_slice()));
        }
        let mut written = [Array::NONE; MOST_RESULTS];
        for (written, array) in written.iter_mut().zip(&arrays) {
            *written = Array::of(array).unwrap_or(Array::NONE);
        }
        let Some((x, results)) = ffi::slices::<f64>(&read, &written) else { return Ok(None) };
        checked(py, robot, row, &x, frames, results)?;
        return outcome::collected(py, row, arrays).map(Some);
    };
    let [shape] = row.results else { return Ok(None) };
    let mut written = [Array::NONE; MOST_RESULTS];
    match Array::of(out) {
        Some(array) if array.shape == shape.dims(&robot.model, frames.len()).as_slice() => written[0] = array,
        _ => return Ok(None),
    }
    let Some((x, results)) = ffi::slices::<f64>(&read, &written) else { return Ok(None) };
    checked(py, robot, row, &x, frames, results)?;
    Ok(Some(out.clone()))
}

/// Computes one state. Refuses arguments and results that are not finite.
#[inline]
pub(crate) fn checked(
    py: Python<'_>,
    robot: &Robot,
    row: &Row,
    x: &[&[f64]; MOST_OPERANDS],
    frames: &[FrameId],
    results: Results<'_>,
) -> PyResult<()> {
    attempt(robot, row, x, frames, results).map_err(|(class, text)| class.error(py, text))
}

/// The same without Python. The error has its class and its message.
#[inline]
pub(crate) fn attempt(
    robot: &Robot,
    row: &Row,
    x: &[&[f64]; MOST_OPERANDS],
    frames: &[FrameId],
    mut results: Results<'_>,
) -> Result<(), (Class, String)> {
    for (operand, x) in row.operands.iter().zip(x) {
        if !is_finite(x) || (operand.width == Width::Nq && !robot.has_unit_quaternions(x)) {
            return Err((Class::State, flaw(robot, operand.name, operand.width, x)));
        }
    }
    let model = &robot.model;
    robot.scratch.with(model, |scratch| {
        if row.inverts_mass() && robot.watches_rank {
            check_rank(model, &mut scratch.workspace, x[0])
                .map_err(|singular| (Class::SingularMass, singular.to_string()))?;
        }
        compute(robot, row, scratch, x, frames, results.each_mut().map(|result| &mut **result));
        Ok(())
    })?;
    if results.iter().all(|result| is_finite(result)) {
        return Ok(());
    }
    // Only the rows about the centre of mass divide by the mass.
    if model.mass() == 0.0 && is_about_mass(row.name) {
        let error = robot_dynamics::algorithms::MotionError::NoMass { robot: model.name().to_owned() };
        return Err((Class::State, error.to_string()));
    }
    let text = format!("{}: the numbers given are too large to compute it; check their units", row.name);
    Err((Class::State, text))
}

/// Whether a quantity is of the centre of mass, or about it.
fn is_about_mass(name: &str) -> bool {
    name.starts_with("center_of_mass") || name.starts_with("centroidal")
}

/// Whether all are finite: their differences from themselves are 0.
#[inline]
pub(crate) fn is_finite(x: &[f64]) -> bool {
    x.iter().all(|x| x.is_finite())
}

/// The error of an invalid argument, in the library's words.
#[cold]
pub(crate) fn flaw(robot: &Robot, name: &str, width: Width, x: &[f64]) -> String {
    if width == Width::Nq
        && let Err(error) = check_configuration(&robot.model, x)
    {
        let text = error.to_string();
        return if name == "q" { text } else { text.replacen("q[", &format!("{name}["), 1) };
    }
    let index = x.iter().position(|x| !x.is_finite()).unwrap_or(0);
    let value = x.get(index).copied().unwrap_or(f64::NAN);
    let coordinate = match width {
        Width::Nv => robot.model.coordinate_names().get(index).map(|name| format!(" (coordinate `{name}`)")),
        _ => None,
    };
    let coordinate = coordinate.unwrap_or_default();
    format!("{name}[{index}]{coordinate} is {value}; every number must be finite")
}

/// Computes one state.
#[inline]
pub(crate) fn compute(
    robot: &Robot,
    row: &Row,
    scratch: &mut Scratch,
    x: &[&[f64]; MOST_OPERANDS],
    frames: &[FrameId],
    results: Results<'_>,
) {
    match row.work {
        Work::Quantity(quantity) => of_table(robot, quantity, scratch, x, frames, results),
        Work::Each(each) => each(&robot.model, scratch, x, frames, results),
        Work::OfFrame(work, seen) => work(&robot.model, scratch, x, frames[0], seen, results),
        Work::Poses => poses(robot, row, scratch, x[0], frames, results),
        Work::Pullback(pullback) => pullback.of_one(&robot.model, &mut scratch.workspace, x, results),
    }
}

/// The inputs of a row of the library's table: q, then the others in their order.
pub(crate) fn inputs<'a, T>(
    quantity: Quantity,
    x: &[&'a [T]; MOST_OPERANDS],
    frames: &'a [FrameId],
) -> Inputs<'a, T> {
    let mut inputs = Inputs { q: x[0], v: &[], a: &[], tau: &[], frames };
    let mut next = 1;
    for input in quantity.inputs() {
        let place = match input {
            Input::Velocity => &mut inputs.v,
            Input::Acceleration => &mut inputs.a,
            Input::Force => &mut inputs.tau,
            _ => continue,
        };
        *place = x[next];
        next += 1;
    }
    inputs
}

fn of_table(
    robot: &Robot,
    quantity: Quantity,
    scratch: &mut Scratch,
    x: &[&[f64]; MOST_OPERANDS],
    frames: &[FrameId],
    [one, two, three, _]: Results<'_>,
) {
    let inputs = inputs(quantity, x, frames);
    quantity.compute_into(&robot.model, &mut scratch.workspace, &inputs, [one, two, three]);
}

fn poses(
    robot: &Robot,
    row: &Row,
    scratch: &mut Scratch,
    q: &[f64],
    frames: &[FrameId],
    [matrices, ..]: Results<'_>,
) {
    let model = &robot.model;
    if row.results == [Shape::Poses] && frames == robot.frames {
        let Scratch { workspace, poses, .. } = scratch;
        robot_dynamics::algorithms::frame_poses(model, workspace, q, poses);
        for (matrix, pose) in matrices.chunks_exact_mut(16).zip(poses) {
            homogeneous_of(pose, matrix);
        }
        return;
    }
    for (matrix, &frame) in matrices.chunks_exact_mut(16).zip(frames) {
        homogeneous_of(
            &robot_dynamics::algorithms::frame_pose(model, &mut scratch.workspace, q, frame),
            matrix,
        );
    }
}

/// \[R p; 0 1\] by rows.
fn homogeneous_of(Pose { rotation, translation }: &Pose, matrix: &mut [f64]) {
    for ((to, row), &p) in matrix.chunks_exact_mut(4).zip(rotation).zip(translation) {
        to.copy_from_slice(&[row[0], row[1], row[2], p]);
    }
    matrix[12..].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
}

/// \[R p; 0 1\] by rows, from R by rows and p.
pub(crate) fn homogeneous<T: Number>(pose: &[T], matrix: &mut [T]) {
    for row in 0..3 {
        matrix[4 * row..4 * row + 3].copy_from_slice(&pose[3 * row..3 * row + 3]);
        matrix[4 * row + 3] = pose[9 + row];
    }
    matrix[12..15].fill(T::of(0.0));
    matrix[15] = T::of(1.0);
}
