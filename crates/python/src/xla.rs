//! What programs compiled by XLA call: the rows of the table and rollouts, on robots that stay.
//!
//! A call comes from a thread of XLA's, without Python: nothing here asks for the interpreter.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::{PoisonError, RwLock};

use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};
use rayon::prelude::*;
use robot_dynamics::batch::{self, Rollout, RolloutError, Torques};
use robot_dynamics::dynamics::Integrator;
use robot_dynamics::{FrameId, LinearizeStepWorkspace, StepForces, StepWorkspace, linearize_step, step};

use crate::batch::run_at_once;
use crate::call::FEW_STATES;
use crate::ffi::xla::{HANDLERS, XlaCall, capsule};
use crate::ffi::{Kind, Number};
use crate::robot::Robot;
use crate::rollout::{describe_bad, threads_for};
use crate::row::Row;
use crate::rows::row_named;
use crate::single::{attempt, flaw, is_finite};
use crate::threads;

/// The robots that programs call, by their fingerprints. Nobody knows when the last program is gone: they stay.
static ROBOTS: RwLock<Option<HashMap<u64, &'static Robot>>> = RwLock::new(None);

#[pymethods]
impl Robot {
    /// The number by which programs of XLA call this robot. It stays in memory from now on.
    fn _xla_handle(slf: &Bound<'_, Self>) -> u64 {
        let fingerprint = slf.get().model.fingerprint();
        let mut robots = ROBOTS.write().unwrap_or_else(PoisonError::into_inner);
        let robots = robots.get_or_insert_default();
        robots.entry(fingerprint).or_insert_with(|| Box::leak(Box::new(slf.clone().unbind())).get());
        fingerprint
    }
}

/// The functions that programs of XLA call, by the names of their targets.
#[pyfunction]
pub(crate) fn _xla_handlers(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let handlers = PyDict::new(py);
    for (name, handler) in HANDLERS {
        let capsule: Bound<'_, PyCapsule> = capsule(py, *handler)?;
        handlers.set_item(name, capsule)?;
    }
    Ok(handlers)
}

fn robot_of(call: &XlaCall<'_>) -> Result<&'static Robot, String> {
    let handle = call.whole("robot")?;
    let robots = ROBOTS.read().unwrap_or_else(PoisonError::into_inner);
    let robot = robots.as_ref().and_then(|robots| robots.get(&handle)).copied();
    robot.ok_or_else(|| "this program was compiled for a robot that is not loaded in this process".to_owned())
}

fn not_floats(call: &XlaCall<'_>) -> String {
    format!("all arrays must be float64, or all float32; found {:?}", call.arguments())
}

/// A length that is not negative.
fn length(dim: i64) -> usize {
    usize::try_from(dim).unwrap_or(0)
}

/// A row of the table.
pub(crate) fn row(call: XlaCall<'_>) -> Result<(), String> {
    let name = call.text("row")?;
    let row = row_named(name).ok_or_else(|| format!("there is no algorithm `{name}`"))?;
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
    let operands = row.operands.iter().map(|operand| operand.width.dims(model, frames.len()));
    let results = row.results.iter().map(|shape| shape.dims(model, frames.len()));
    let arrays = call.arguments().iter().chain(call.results());
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
    let words = not_floats(&call);
    let (read, written) = call.take::<T>().ok_or(words)?;
    let mut x = [&[][..]; 4];
    for (x, read) in x.iter_mut().zip(read) {
        *x = read;
    }
    let mut results: [&mut [T]; 3] = [&mut [], &mut [], &mut []];
    for (result, written) in results.iter_mut().zip(written) {
        *result = written;
    }
    if let Some(text) = robot.massless.as_ref().filter(|_| row.inverts_mass()) {
        return Err(text.clone());
    }
    if lead.is_empty() {
        return one(robot, row, frames, x, results);
    }
    let states: usize = lead.iter().product();
    if states == 0 {
        return Ok(());
    }
    let threads = if states <= FEW_STATES { 1 } else { threads::default_count() };
    let bad =
        run_at_once(robot, row, frames, states, x, results, threads).map_err(|error| error.to_string())?;
    let Some(&first) = bad.first() else { return Ok(()) };
    let mut cause = "the numbers given are too large, or M is singular".to_owned();
    for (operand, x) in row.operands.iter().zip(x) {
        let width = operand.width.len(model, frames.len());
        let numbers: Vec<f64> = x[first * width..(first + 1) * width].iter().map(|x| x.double()).collect();
        if !is_finite(&numbers)
            || (operand.width == crate::row::Width::Nq && !robot.has_unit_quaternions(&numbers))
        {
            cause = flaw(robot, operand.name, operand.width, &numbers);
            break;
        }
    }
    let (count, verb) = (bad.len(), if bad.len() == 1 { "is" } else { "are" });
    Err(format!("{}: {count} of {states} states {verb} bad, the first is state {first}: {cause}", row.name))
}

/// One state, in float64.
fn one<T: Number>(
    robot: &Robot,
    row: &Row,
    frames: &[FrameId],
    x: [&[T]; 4],
    results: [&mut [T]; 3],
) -> Result<(), String> {
    let doubles = x.map(|x| x.iter().map(|x| x.double()).collect::<Vec<f64>>());
    let mut computed = [0, 1, 2].map(|k| vec![0.0; results[k].len()]);
    let [first, second, third] = &mut computed;
    attempt(robot, row, &doubles.each_ref().map(Vec::as_slice), frames, [first, second, third])
        .map_err(|(_, text)| text)?;
    for (result, computed) in results.into_iter().zip(&computed) {
        for (number, computed) in result.iter_mut().zip(computed) {
            *number = T::of(*computed);
        }
    }
    Ok(())
}

/// What calls about rollouts say of them.
struct Course {
    robot: &'static Robot,
    how: Rollout,
    /// `none`, `held` or `each`.
    torques: String,
    lead: Vec<usize>,
    states: usize,
    threads: usize,
}

impl Course {
    fn of(call: &XlaCall<'_>) -> Result<Self, String> {
        let whole = |name| call.whole(name).map(|x| usize::try_from(x).unwrap_or(usize::MAX));
        let integrator =
            Integrator::from_name(call.text("integrator")?).map_err(|error| error.to_string())?;
        let how = Rollout::new(integrator, call.number("step")?, whole("steps")?)
            .with_dissipation(call.truth("dissipation")?)
            .with_stride(whole("stride")?);
        let dims = call.arguments().first().map_or(&[][..], |array| array.dims);
        let lead: Vec<usize> = dims[..dims.len().saturating_sub(1)].iter().copied().map(length).collect();
        let states = lead.iter().product::<usize>();
        let threads = threads_for(states * how.steps);
        Ok(Self {
            robot: robot_of(call)?,
            how,
            torques: call.text("torques")?.to_owned(),
            lead,
            states,
            threads,
        })
    }

    fn has_torques(&self) -> bool {
        self.torques != "none"
    }

    fn torques<'a, T>(&self, tau: &'a [T]) -> Torques<'a, T> {
        match &*self.torques {
            "none" => Torques::Zero,
            "held" => Torques::Held(tau),
            _ => Torques::EachStep(tau),
        }
    }

    fn outcome(&self, outcome: Result<(), RolloutError>) -> Result<(), String> {
        match outcome {
            Ok(()) => Ok(()),
            Err(RolloutError::BadStates(bad)) => Err(format!(
                "rollout: {}",
                describe_bad(&bad.states, &self.lead).replace("; `.result` has the others", "")
            )),
            Err(error) => Err(format!("rollout: {error}")),
        }
    }
}

/// A list's entries, one after the other; none left is a mistake of the caller's.
fn next<T>(list: &mut impl Iterator<Item = T>) -> Result<T, String> {
    list.next().ok_or_else(|| "the call has too few arrays".to_owned())
}

macro_rules! over_floats {
    ($call:ident, $function:ident) => {
        match $call.arguments().first().map(|array| array.kind) {
            Some(Kind::F32) => $function::<f32>($call),
            _ => $function::<f64>($call),
        }
    };
}

/// A rollout: q, v and the torques to the end's q and v, and the trajectory's.
pub(crate) fn rollout(call: XlaCall<'_>) -> Result<(), String> {
    over_floats!(call, rollout_over)
}

fn rollout_over<T: Number>(mut call: XlaCall<'_>) -> Result<(), String> {
    let course = Course::of(&call)?;
    let words = not_floats(&call);
    let (read, written) = call.take::<T>().ok_or(words)?;
    let (mut read, mut written) = (read.into_iter(), written.into_iter());
    let (q0, v0) = (next(&mut read)?, next(&mut read)?);
    let tau = if course.has_torques() { next(&mut read)? } else { &[] };
    let (q, v) = (next(&mut written)?, next(&mut written)?);
    let trajectory = match course.how.stride {
        0 => (&mut [][..], &mut [][..]),
        _ => (next(&mut written)?, next(&mut written)?),
    };
    q.copy_from_slice(q0);
    v.copy_from_slice(v0);
    let Course { robot, how, threads, .. } = &course;
    let mut memory = T::batches(robot).take(&robot.model, *threads).map_err(|error| error.to_string())?;
    let go_on = |_| ControlFlow::Continue(());
    let torques = course.torques(tau);
    let outcome = batch::rollout(&robot.model, &mut memory.workspace, how, torques, q, v, trajectory, &go_on);
    T::batches(robot).give(memory);
    course.outcome(outcome)
}

/// Its pullback: q, v and the torques, the cotangents of the end and of the trajectory, to those of the start and of the
/// torques; all by displacements.
pub(crate) fn rollout_pullback(call: XlaCall<'_>) -> Result<(), String> {
    over_floats!(call, rollout_pullback_over)
}

fn rollout_pullback_over<T: Number>(mut call: XlaCall<'_>) -> Result<(), String> {
    let course = Course::of(&call)?;
    let words = not_floats(&call);
    let (read, written) = call.take::<T>().ok_or(words)?;
    let (mut read, mut written) = (read.into_iter(), written.into_iter());
    let (q, v) = (next(&mut read)?, next(&mut read)?);
    let tau = if course.has_torques() { next(&mut read)? } else { &[] };
    let (given_q, given_v) = (next(&mut read)?, next(&mut read)?);
    let trajectory = match course.how.stride {
        0 => (&[][..], &[][..]),
        _ => (next(&mut read)?, next(&mut read)?),
    };
    let (by_q, by_v) = (next(&mut written)?, next(&mut written)?);
    let by_tau = if course.has_torques() { next(&mut written)? } else { &mut [] };
    by_q.copy_from_slice(given_q);
    by_v.copy_from_slice(given_v);
    let Course { robot, how, threads, .. } = &course;
    let mut memory = T::batches(robot).take(&robot.model, *threads).map_err(|error| error.to_string())?;
    let outcome = batch::rollout_pullback(
        &robot.model,
        &mut memory.workspace,
        how,
        0,
        course.torques(tau),
        q,
        v,
        trajectory,
        (by_q, by_v),
        by_tau,
        &mut [],
        &|_| ControlFlow::Continue(()),
    );
    T::batches(robot).give(memory);
    course.outcome(outcome)
}

/// Its tangent: q, v and the torques, with the changes of each by displacements, to the changes of the end and of the
/// trajectory. Step by step (δq, δv) ← A (δq, δv) + B δτ, in float64.
pub(crate) fn rollout_tangent(call: XlaCall<'_>) -> Result<(), String> {
    over_floats!(call, rollout_tangent_over)
}

fn rollout_tangent_over<T: Number>(mut call: XlaCall<'_>) -> Result<(), String> {
    let course = Course::of(&call)?;
    let words = not_floats(&call);
    let (read, written) = call.take::<T>().ok_or(words)?;
    let Course { robot, how, states, threads, .. } = &course;
    // The rows of each state.
    let mut rows: Vec<(Vec<&[T]>, Vec<&mut [T]>)> = (0..*states).map(|_| (Vec::new(), Vec::new())).collect();
    if *states == 0 {
        return Ok(());
    }
    for table in read {
        for (row, part) in rows.iter_mut().zip(table.chunks_exact((table.len() / states).max(1))) {
            row.0.push(part);
        }
    }
    for table in written {
        for (row, part) in rows.iter_mut().zip(table.chunks_exact_mut((table.len() / states).max(1))) {
            row.1.push(part);
        }
    }
    let run = |(state, (read, written)): (usize, (Vec<&[T]>, Vec<&mut [T]>))| {
        tangent_of_one(robot, how, &course.torques, &read, written)
            .map_err(|error| format!("rollout: state {state}: {error}"))
    };
    if *threads == 1 {
        return rows.into_iter().enumerate().try_for_each(run);
    }
    let pool = threads::pool(*threads).map_err(|error| error.to_string())?;
    pool.install(|| rows.into_par_iter().enumerate().try_for_each(run))
}

fn tangent_of_one<T: Number>(
    robot: &Robot,
    how: &Rollout,
    torques: &str,
    read: &[&[T]],
    mut written: Vec<&mut [T]>,
) -> Result<(), String> {
    let (model, nv) = (&robot.model, robot.model.nv());
    let double = |x: &[T]| x.iter().map(|x| x.double()).collect::<Vec<f64>>();
    let tables: Vec<Vec<f64>> = read.iter().map(|x| double(x)).collect();
    let none = Vec::new();
    let (q, v, tau, by_q, by_v, by_tau) = match (&tables[..], torques) {
        ([q, v, dq, dv], "none") => (q, v, &none, dq, dv, &none),
        ([q, v, tau, dq, dv, dtau], _) => (q, v, tau, dq, dv, dtau),
        _ => return Err("the call has too few arrays".into()),
    };
    let (mut q, mut v) = (q.clone(), v.clone());
    // (δq, δv, δτ)
    let mut change = [&by_q[..], by_v, &vec![0.0; nv]].concat();
    let mut next = vec![0.0; 2 * nv];
    let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
    let (mut slopes, mut mover) = (LinearizeStepWorkspace::new(model), StepWorkspace::new(model));
    let mut force = vec![0.0; nv];
    let mut sample = 0;
    for k in 0..how.steps {
        let rows = match torques {
            "none" => None,
            "held" => Some(0..nv),
            _ => Some(k * nv..(k + 1) * nv),
        };
        if let Some(rows) = rows {
            force.copy_from_slice(&tau[rows.clone()]);
            change[2 * nv..].copy_from_slice(&by_tau[rows]);
        }
        let forces = StepForces::new(&force, how.dissipation);
        linearize_step(model, how.integrator, &mut slopes, &forces, how.step, &q, &v, &mut a, &mut b)
            .map_err(|error| error.to_string())?;
        step(model, how.integrator, &mut mover, &forces, how.step, &mut q, &mut v)
            .map_err(|error| error.to_string())?;
        for (i, next) in next.iter_mut().enumerate() {
            let of_state = a[2 * nv * i..2 * nv * (i + 1)].iter().zip(&change[..2 * nv]);
            let of_force = b[nv * i..nv * (i + 1)].iter().zip(&change[2 * nv..]);
            *next = of_state.chain(of_force).map(|(slope, change)| slope * change).sum();
        }
        change[..2 * nv].copy_from_slice(&next);
        if how.stride != 0 && (k + 1).is_multiple_of(how.stride) {
            for (table, part) in written[2..].iter_mut().zip(next.chunks_exact(nv.max(1))) {
                for (number, change) in table[sample * nv..].iter_mut().zip(part) {
                    *number = T::of(*change);
                }
            }
            sample += 1;
        }
    }
    for (table, part) in written.iter_mut().zip(change[..2 * nv].chunks_exact(nv.max(1))) {
        for (number, change) in table.iter_mut().zip(part) {
            *number = T::of(*change);
        }
    }
    Ok(())
}
