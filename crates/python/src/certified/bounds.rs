//! Intervals of arguments, and bounds as arrays.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pyo3::prelude::*;
use robot_dynamics_certified::{Interval, SearchOptions};

use crate::errors::Class;
use crate::interrupts::interruptible_by;
use crate::numbers::shaped;
use crate::outcome;
use crate::robot::Robot;
use crate::threads::{count_of, default_count};

/// The interval between two finite numbers.
pub(super) fn interval(py: Python<'_>, name: &str, [lower, upper]: [f64; 2]) -> PyResult<Interval> {
    if lower <= upper && lower.is_finite() && upper.is_finite() {
        return Ok(Interval::new(lower, upper));
    }
    let message = format!(
        "{name} is ({lower}, {upper}); both bounds must be finite, and the first must not exceed the second"
    );
    Err(Class::State.error(py, message))
}

/// A box of configurations, whose bounds may be infinite.
pub(super) fn region(
    py: Python<'_>,
    robot: &Robot,
    lower: &Bound<'_, PyAny>,
    upper: &Bound<'_, PyAny>,
) -> PyResult<Vec<Interval>> {
    let width = [robot.model.nq()];
    let (_, lower) = shaped(py, "lower", lower, &width)?;
    let (_, upper) = shaped(py, "upper", upper, &width)?;
    let of = |(k, (lower, upper)): (usize, (&f64, &f64))| {
        if lower <= upper {
            return Ok(Interval::new(*lower, *upper));
        }
        let message = format!(
            "lower[{k}] is {lower} and upper[{k}] is {upper}; a lower bound must not exceed the upper bound"
        );
        Err(Class::State.error(py, message))
    };
    lower.iter().zip(&upper).enumerate().map(of).collect()
}

/// Lower and upper bounds as arrays of a shape.
pub(super) fn ends<'py>(
    py: Python<'py>,
    shape: &[usize],
    intervals: &[Interval],
) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let of = |end: fn(Interval) -> f64| {
        let numbers: Vec<f64> = intervals.iter().copied().map(end).collect();
        outcome::filled(py, shape, &numbers)
    };
    Ok([of(Interval::lower)?, of(Interval::upper)?])
}

/// Searches without the interpreter's lock, until an interrupt.
pub(super) fn search<R: Send>(
    py: Python<'_>,
    (tolerance, boxes): (f64, usize),
    threads: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&SearchOptions) -> R + Send,
) -> PyResult<R> {
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        let message = format!("tolerance is {tolerance}; it must be finite, and zero or positive");
        return Err(Class::State.error(py, message));
    }
    let flag = Arc::new(AtomicBool::new(false));
    let threads = count_of(threads)?.unwrap_or_else(default_count);
    let options = SearchOptions { tolerance, boxes, threads, interrupt: Some(flag.clone()) };
    interruptible_by(py, &flag, || work(&options))
}
