//! One call from Python. The shapes decide whether it computes one state or many.

use pyo3::prelude::*;
use robot_dynamics::model::FrameId;

use crate::batch::{self, OperandRows};
use crate::errors::Class;
use crate::ffi::{self, Array, Kind};
use crate::number::Number;
use crate::operand::{ArrayArgument, common_kind, common_lead, given, shown, spread};
use crate::outcome::{OutputArrays, bad_states};
use crate::results::{MOST_OPERANDS, MOST_RESULTS};
use crate::robot::Robot;
use crate::row::{Row, Width};
use crate::{single_state, threads};

/// Up to this many states, one thread is as fast as several.
pub(crate) const FEW_STATES: usize = 256;

/// Computes a row.
#[inline]
pub(crate) fn call<'py>(
    py: Python<'py>,
    robot: &Robot,
    row: &Row,
    operands: &[&Bound<'py, PyAny>],
    frames: &[FrameId],
    out: Option<&Bound<'py, PyAny>>,
    threads: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    match single_state::at_once(py, robot, row, operands, frames, out)? {
        Some(result) => Ok(result),
        None => with_care(py, robot, row, operands, frames, out, threads),
    }
}

/// Computes a row from arguments of any kind.
#[inline(never)]
fn with_care<'py>(
    py: Python<'py>,
    robot: &Robot,
    row: &Row,
    operands: &[&Bound<'py, PyAny>],
    frames: &[FrameId],
    out: Option<&Bound<'py, PyAny>>,
    threads: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let threads = threads::count_of(threads)?;
    let mut all = Vec::with_capacity(operands.len());
    for (object, operand) in operands.iter().zip(row.operands) {
        let first = all.first().map(|first: &ArrayArgument<'_>| first.kind);
        all.push(given(py, &robot.model, operand, frames.len(), object, first)?);
    }
    let lead = common_lead(py, &all)?;
    for given in &mut all {
        spread(py, given, &lead)?;
    }
    let call = MethodCall { py, robot, row, frames, all, lead, out, threads };
    match common_kind(py, &call.all)? {
        Kind::F32 => call.run::<f32>(),
        Kind::F64 | Kind::Other => call.run::<f64>(),
    }
}

struct MethodCall<'a, 'py> {
    py: Python<'py>,
    robot: &'a Robot,
    row: &'a Row,
    frames: &'a [FrameId],
    all: Vec<ArrayArgument<'py>>,
    lead: Vec<usize>,
    out: Option<&'a Bound<'py, PyAny>>,
    threads: Option<usize>,
}

impl<'py> MethodCall<'_, 'py> {
    fn run<T: Number>(self) -> PyResult<Bound<'py, PyAny>> {
        let Self { py, robot, row, frames, ref lead, out, .. } = self;
        let mut outcome = OutputArrays::of::<T>(py, &robot.model, row, frames.len(), lead, out)?;
        let mut computed = self.compute::<T>(&outcome.arrays)?;
        if computed.is_none() {
            outcome.set_apart::<T>(py);
            computed = self.compute::<T>(&outcome.arrays)?;
        }
        let bad =
            computed.ok_or_else(|| Class::Shape.error(py, "the arrays cannot be read where they lie"))?;
        let result = outcome.finish(py, row)?;
        if bad.is_empty() { Ok(result) } else { Err(self.bad_states::<T>(bad, result)?) }
    }

    /// Computes all states and returns the bad ones; `None` if an array to write overlaps another.
    fn compute<T: Number>(&self, arrays: &[Bound<'py, PyAny>]) -> PyResult<Option<Vec<usize>>> {
        let mut read = [Array::NONE; MOST_OPERANDS];
        for (read, given) in read.iter_mut().zip(&self.all) {
            *read = Array::of(&given.array).unwrap_or(Array::NONE);
        }
        let mut written = [Array::NONE; MOST_RESULTS];
        for (written, array) in written.iter_mut().zip(arrays) {
            *written = Array::of(array).unwrap_or(Array::NONE);
        }
        let Some((x, results)) = ffi::slices::<T>(&read, &written) else { return Ok(None) };
        if self.lead.is_empty() {
            self.single(x, results)?;
            Ok(Some(Vec::new()))
        } else {
            self.many(x, results).map(Some)
        }
    }

    /// Computes one state, in float64.
    fn single<T: Number>(&self, x: [&[T]; MOST_OPERANDS], results: [&mut [T]; MOST_RESULTS]) -> PyResult<()> {
        let doubles = x.map(|x| x.iter().map(|x| x.double()).collect::<Vec<f64>>());
        let mut computed = results.each_ref().map(|result| vec![0.0; result.len()]);
        let read = doubles.each_ref().map(Vec::as_slice);
        self.refuse_massless()?;
        let written = computed.each_mut().map(Vec::as_mut_slice);
        single_state::checked(self.py, self.robot, self.row, &read, self.frames, written)?;
        for (result, computed) in results.into_iter().zip(&computed) {
            for (number, computed) in result.iter_mut().zip(computed) {
                *number = T::of(*computed);
            }
        }
        Ok(())
    }

    fn many<T: Number>(
        &self,
        x: [&[T]; MOST_OPERANDS],
        results: [&mut [T]; MOST_RESULTS],
    ) -> PyResult<Vec<usize>> {
        self.refuse_massless()?;
        let states: usize = self.lead.iter().product();
        let threads = match self.threads {
            Some(threads) => threads,
            None if states <= FEW_STATES => 1,
            None => threads::default_count(),
        };
        let mut k = 0;
        let operands = x.map(|numbers| {
            let are_own =
                self.all.get(k).is_none_or(|given| given.lead().iter().product::<usize>() == states);
            k += 1;
            OperandRows::of(numbers, are_own)
        });
        batch::run(self.py, self.robot, self.row, self.frames, states, operands, results, threads)
    }

    /// Refuses joints that never move inertia, for all states: a batch does not check the rank of M in each
    /// state.
    fn refuse_massless(&self) -> PyResult<()> {
        match &self.robot.massless {
            Some(text) if self.row.inverts_mass() => Err(Class::SingularMass.error(self.py, text)),
            _ => Ok(()),
        }
    }

    /// The exception that names the bad states and carries the results of all others.
    #[cold]
    fn bad_states<T: Number>(&self, bad: Vec<usize>, result: Bound<'py, PyAny>) -> PyResult<PyErr> {
        let (py, states) = (self.py, self.lead.iter().product::<usize>());
        let first = bad[0];
        let mut cause = format!(
            "{} of it is not finite: the numbers given are too large, or M is singular",
            self.row.name
        );
        for (given, operand) in self.all.iter().zip(self.row.operands) {
            let width = operand.width.len(&self.robot.model, self.frames.len());
            let Some((x, _)) = Array::of(&given.array).and_then(|array| {
                let mut read = [Array::NONE; MOST_OPERANDS];
                read[0] = array;
                ffi::slices::<T>(&read, &[Array::NONE; MOST_RESULTS])
            }) else {
                continue;
            };
            let at = if x[0].len() == width { 0 } else { first * width };
            let numbers: Vec<f64> = x[0][at..at + width].iter().map(|x| x.double()).collect();
            let is_bad = !single_state::is_finite(&numbers)
                || (operand.width == Width::Nq && !self.robot.has_unit_quaternions(&numbers));
            if is_bad {
                cause = single_state::flaw(self.robot, operand.name, operand.width, &numbers);
                break;
            }
        }
        let count = bad.len();
        let place =
            if self.lead.len() == 1 { first.to_string() } else { shown(&unravelled(first, &self.lead)) };
        let verb = if count == 1 { "is" } else { "are" };
        let message = format!(
            "{count} of {states} states {verb} bad, the first is state {place}: {cause}; `.indices` has them all, `.result` \
             the results, NaN for these and valid for all others"
        );
        bad_states(py, &bad, message, result)
    }
}

/// The indices of the k-th state, slowest axis first.
fn unravelled(mut k: usize, lead: &[usize]) -> Vec<usize> {
    let mut indices = vec![0; lead.len()];
    for (index, &length) in indices.iter_mut().zip(lead).rev() {
        (*index, k) = (k % length, k / length);
    }
    indices
}
