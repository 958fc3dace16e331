//! A row of the table.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::model::FrameId;

use super::calls::{NOT_FLOATS, length, parameters_of, robot_of};
use super::groups::by_groups;
use crate::batch::run_at_once;
use crate::call::FEW_STATES;
use crate::ffi::Kind;
use crate::ffi::xla::XlaCall;
use crate::number::Number;
use crate::results::{MOST_OPERANDS, MOST_RESULTS};
use crate::robot::Robot;
use crate::row::Row;
use crate::rows::row_named;
use crate::single_state::attempt;
use crate::threads;

#[pymethods]
impl Robot {
    /// The shapes of the results of a row of the table, for one state and one frame.
    fn _result_shapes(&self, name: &str) -> PyResult<Vec<Vec<usize>>> {
        let row = row_named(name).ok_or_else(|| PyValueError::new_err(no_such_row(name)))?;
        Ok(row.results.iter().map(|shape| shape.dims(&self.model, 1).as_slice().to_vec()).collect())
    }
}

fn no_such_row(name: &str) -> String {
    format!("there is no algorithm `{name}`")
}

/// A row of the table.
pub(crate) fn row(call: XlaCall<'_>) -> Result<(), String> {
    let name = call.text("row")?;
    let row = row_named(name).ok_or_else(|| no_such_row(name))?;
    let robot = robot_of(&call)?;
    let frame = call.whole("frame").ok().and_then(|index| usize::try_from(index).ok());
    let frames: Vec<FrameId> = frame.and_then(|index| robot.frames.get(index)).copied().into_iter().collect();
    match call.arguments().first().map(|array| array.kind) {
        Some(Kind::F32) => row_over::<f32>(robot, row, &frames, call),
        _ => row_over::<f64>(robot, row, &frames, call),
    }
}

fn row_over<T: Number>(
    robot: &Robot,
    row: &Row,
    frames: &[FrameId],
    mut call: XlaCall<'_>,
) -> Result<(), String> {
    let model = &robot.model;
    let own =
        row.operands.first().map_or(0, |operand| operand.width.dims(model, frames.len()).as_slice().len());
    let dims = call.arguments().first().map_or(&[][..], |array| array.dims);
    let lead: Vec<usize> = dims[..dims.len().saturating_sub(own)].iter().copied().map(length).collect();
    let has_parameters = call.has_parameters();
    let operands = row.operands.iter().map(|operand| operand.width.dims(model, frames.len()));
    let results = row.results.iter().map(|shape| shape.dims(model, frames.len()));
    let given = call.arguments().len() - usize::from(has_parameters);
    let arrays = call.arguments()[..given].iter().chain(call.results());
    let expected = operands.chain(results);
    let fits = arrays.clone().count() == row.operands.len() + row.results.len()
        && arrays.zip(expected).all(|(array, own)| {
            array
                .dims
                .iter()
                .copied()
                .map(length)
                .eq(lead.iter().copied().chain(own.as_slice().iter().copied()))
        });
    if !fits {
        return Err(format!("{}: the arrays do not have the shapes of robot `{}`", row.name, model.name()));
    }
    let states: usize = lead.iter().product();
    let (mut read, written) = call.take::<T>().ok_or(NOT_FLOATS)?;
    let parameters = parameters_of(robot, has_parameters, states, &mut read)?;
    if states == 0 {
        return Ok(());
    }
    let threads = if states <= FEW_STATES { 1 } else { threads::default_count() };
    by_groups(
        robot,
        parameters,
        states,
        (read.clone(), written),
        threads,
        |robot, tables, states, threads| {
            if let Some(text) = robot.massless.as_ref().filter(|_| row.inverts_mass()) {
                return Err(text.clone());
            }
            let (read, written) = tables;
            let mut x = [&[][..]; MOST_OPERANDS];
            x.iter_mut().zip(read).for_each(|(x, read)| *x = read);
            let mut results: [&mut [T]; MOST_RESULTS] = [&mut [], &mut [], &mut [], &mut []];
            results.iter_mut().zip(written).for_each(|(result, written)| *result = written);
            if lead.is_empty() {
                one(robot, row, frames, x, results);
                return Ok(());
            }
            // The rows of bad states are NaN.
            let bad = run_at_once(robot, row, frames, states, x, results, threads);
            bad.map(drop).map_err(|error| error.to_string())
        },
    )
}

/// Computes one state, in float64; its results are NaN if it is bad.
fn one<T: Number>(
    robot: &Robot,
    row: &Row,
    frames: &[FrameId],
    x: [&[T]; MOST_OPERANDS],
    results: [&mut [T]; MOST_RESULTS],
) {
    let doubles = x.map(|x| x.iter().map(|x| x.double()).collect::<Vec<f64>>());
    let mut computed = results.each_ref().map(|result| vec![0.0; result.len()]);
    let written = computed.each_mut().map(Vec::as_mut_slice);
    let is_bad = attempt(robot, row, &doubles.each_ref().map(Vec::as_slice), frames, written).is_err();
    for (result, computed) in results.into_iter().zip(&computed) {
        for (number, computed) in result.iter_mut().zip(computed) {
            *number = T::of(if is_bad { f64::NAN } else { *computed });
        }
    }
}
