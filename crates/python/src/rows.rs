//! The methods of a robot that compute a quantity of its states: a line each, with the text of Python's help.
//!
//! A row of the library's table of algorithms is named with its `Quantity`; any other algorithm on one state
//! is a closure.

mod dynamics;
mod kinematics;
mod pullbacks;
mod second_order;
mod sections;
mod space;
mod table;
mod wrenches;

use pyo3::prelude::*;
use robot_dynamics::quantity::{Input, Quantity};

use crate::row::Row;

/// A row by its method's name, in the default reference frame if it has one.
pub(crate) fn row_named(name: &str) -> Option<&'static Row> {
    let all = [
        dynamics::ALL,
        pullbacks::ALL,
        second_order::ALL,
        kinematics::ALL,
        kinematics::FRAMES,
        second_order::FRAMES,
        space::ALL,
    ];
    let all = all.into_iter().flatten();
    all.copied().find(|row| row.name == name)
}

/// The library's table of algorithms: the name and the inputs of each. The tests check that each has a
/// method.
#[pyfunction]
pub(crate) fn quantities() -> Vec<(&'static str, Vec<&'static str>, usize)> {
    let name = |input: &Input| match input {
        Input::Velocity => "v",
        Input::Acceleration => "a",
        Input::Force => "tau",
        Input::Frame => "frame",
        _ => "unknown",
    };
    let row = |quantity: Quantity| {
        let read = core::iter::once("q").chain(quantity.inputs().iter().map(name)).collect();
        (quantity.name(), read, quantity.results().len())
    };
    Quantity::ALL.into_iter().map(row).collect()
}
