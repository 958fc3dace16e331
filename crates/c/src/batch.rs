//! Quantities of many states: lanes inside, threads across.

use std::sync::Arc;

use robot_dynamics::batch::{BatchOptions, BatchQuantity, BatchWorkspace};
use robot_dynamics::model::{FrameId, check_configuration, check_vector};
use robot_dynamics::quantity::{Input, Inputs, Quantity, QuantityMemory};

use crate::Status;
use crate::arrays::{Arrays, options, result};
use crate::calls::call;
use crate::failure::Failure;
use crate::handle::{exclusive, insert, object, remove, shared};
use crate::model::{ModelHandle, RobotModel};
use crate::quantities::{InputsC, ResultsC, quantity_of, result_lengths};
use crate::workspace::RobotWorkspace;

/// A model with the memory and the threads for batches. It serves one call at a time.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchHandle {
    /// The handle; 0 names no object.
    pub id: u64,
}

pub(crate) struct Batch {
    single: RobotWorkspace,
    workspace: BatchWorkspace<f64>,
    memory: QuantityMemory,
    frames: Vec<FrameId>,
}

object!(Batch, 3, "the batch");

/// The most threads of a batch or a solver.
const MOST_THREADS: usize = 1024;

/// Refuses numbers of threads that no machine has.
pub(crate) fn check_threads(threads: usize) -> Result<(), Failure> {
    if threads <= MOST_THREADS {
        return Ok(());
    }
    Err(Failure::invalid(format!("there are {threads} threads; there must be at most {MOST_THREADS}")))
}

/// Makes a batch of a model. 0 threads select one for each core, 1 the calling thread alone; 1024 are the
/// most. Free it with `rd_batch_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_batch_new(model: ModelHandle, threads: usize, batch: *mut BatchHandle) -> Status {
    call(|| {
        let batch = result("the result `batch`", batch)?;
        check_threads(threads)?;
        let robot = shared::<RobotModel>(model.id)?;
        let mut options = BatchOptions::default();
        options.threads = threads;
        batch.id = insert(Batch {
            workspace: BatchWorkspace::with_options(&robot.model, options)?,
            memory: QuantityMemory::new(&robot.model),
            single: RobotWorkspace::new(&robot),
            frames: Vec::with_capacity(robot.frames.len()),
        })?;
        Ok(())
    })
}

/// Frees a batch. The null handle is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn rd_batch_free(batch: BatchHandle) -> Status {
    call(|| remove::<Batch>(batch.id))
}

/// Computes a quantity of `states` states. Each array has the rows of all states, one after another; all
/// states share the frames. If a state is invalid, an error names it, and the results of the others are
/// valid.
///
/// Quantities without a form for batches are computed one state after another. With one thread the call does
/// not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_batch_compute(
    batch: BatchHandle,
    quantity: u32,
    states: usize,
    inputs: *const InputsC,
    results: *const ResultsC,
) -> Status {
    call(|| {
        let (given, results) = (options("the inputs", inputs)?, options("the results", results)?);
        let quantity = quantity_of(quantity)?;
        let mut batch = exclusive::<Batch>(batch.id)?;
        let Batch { single, workspace, memory, frames } = &mut *batch;
        let model = Arc::clone(&single.model);
        let mut arrays = Arrays::default();
        let rows = |width: usize| {
            states.checked_mul(width).ok_or_else(|| Failure::invalid("there are more states than memory has"))
        };
        let width = |input| if quantity.reads(input) { model.nv() } else { 0 };
        let q = arrays.input("q", given.q, given.q_len, rows(model.nq())?)?;
        let v = arrays.input("v", given.v, given.v_len, rows(width(Input::Velocity))?)?;
        let a = arrays.input("a", given.a, given.a_len, rows(width(Input::Acceleration))?)?;
        let tau = arrays.input("tau", given.tau, given.tau_len, rows(width(Input::Force))?)?;
        frames.clear();
        for frame in arrays.any("the frames", given.frames, given.frames_len)? {
            frames.push(single.frame(*frame)?);
        }
        if quantity.reads(Input::Frame) && frames.len() != 1 {
            return Err(Failure::invalid(format!(
                "{} needs one frame, not {}",
                quantity.name(),
                frames.len()
            )));
        }
        if quantity == Quantity::FramePoses && frames.is_empty() {
            frames.extend_from_slice(&single.frames);
        }
        let [x, y, z] = result_lengths(quantity, single, frames.len());
        let mut out = [
            arrays.output("the first result", results.first, results.first_len, rows(x)?)?,
            arrays.output("the second result", results.second, results.second_len, rows(y)?)?,
            arrays.output("the third result", results.third, results.third_len, rows(z)?)?,
        ];
        let inputs = Inputs { q, v, a, tau, frames: &frames[..] };
        let whole = out.each_mut().map(|out| &mut **out);
        // Without coordinates, the length of q does not give the number of states.
        if model.nq() > 0
            && let Some(done) = quantity.compute_batch(&model, workspace, &inputs, whole)
        {
            return Ok(done?);
        }
        one_by_one(single, memory, (quantity, states), &inputs, out)
    })
}

/// Computes the states one after another.
fn one_by_one(
    single: &mut RobotWorkspace,
    memory: &mut QuantityMemory,
    (quantity, states): (Quantity, usize),
    inputs: &Inputs<'_>,
    mut out: [&mut [f64]; 3],
) -> Result<(), Failure> {
    let row = |x: &[f64], state: usize, width: usize| {
        let start = if x.is_empty() { 0 } else { state * width };
        start..start + if x.is_empty() { 0 } else { width }
    };
    let model = &*Arc::clone(&single.model);
    if out.iter().all(|out| out.is_empty()) {
        return Ok(());
    }
    let mut bad = None;
    for state in 0..states {
        let q = &inputs.q[row(inputs.q, state, model.nq())];
        let [v, a, tau] = [inputs.v, inputs.a, inputs.tau].map(|x| &x[row(x, state, model.nv())]);
        let mut check = || -> Result<(), Failure> {
            check_configuration(model, q)?;
            for (name, x) in [("v", v), ("a", a), ("tau", tau)] {
                if !x.is_empty() {
                    check_vector(model, name, x)?;
                }
            }
            if quantity.inverts_mass() { single.check_rank(q) } else { Ok(()) }
        };
        if let Err(failure) = check() {
            for out in &mut out {
                let width = out.len() / states;
                out[state * width..][..width].fill(f64::NAN);
            }
            bad.get_or_insert(Failure::new(failure.status, format!("state {state}: {failure}")));
            continue;
        }
        let one = Inputs { q, v, a, tau, frames: inputs.frames };
        quantity.compute(model, &mut single.memory, &one, memory);
        for (out, found) in out.iter_mut().zip(memory.results(quantity)) {
            let width = out.len() / states;
            out[state * width..][..width].copy_from_slice(&found[..width]);
        }
    }
    bad.map_or(Ok(()), Err)
}
