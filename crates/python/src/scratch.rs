//! Working memory for the algorithms, kept with each robot. A call takes memory that is free, or makes new
//! memory.

use std::sync::{Mutex, MutexGuard, TryLockError};

use pyo3::prelude::*;
use robot_dynamics::batch::{BatchOptions, BatchWorkspace};
use robot_dynamics::derivatives::{LinearizeStepWorkspace, SecondOrderWorkspace};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::Dual;
use robot_dynamics::simulation::{SensorMemory, SensorSet};

use crate::ffi::ArrayNumber;
use crate::threads;
use robot_dynamics::description::Pose;

/// Memory for one state.
#[derive(Debug)]
pub(crate) struct Scratch {
    pub(crate) workspace: Workspace,
    pub(crate) poses: Vec<Pose>,
    /// The workspace over dual numbers, for results computed by differentiation.
    dual: Option<Box<Workspace<Dual<f64, 1>>>>,
    sensors: Option<Box<SensorMemory>>,
    linearized: Option<Box<LinearizeStepWorkspace>>,
    second_order: Option<Box<SecondOrderWorkspace>>,
}

impl Scratch {
    pub(crate) fn new(model: &Model) -> Self {
        let still = Pose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        Self {
            workspace: Workspace::new(model),
            poses: vec![still; model.frames().len()],
            dual: None,
            sensors: None,
            linearized: None,
            second_order: None,
        }
    }

    pub(crate) fn sensors(&mut self, model: &Model, set: &SensorSet) -> &mut SensorMemory {
        self.sensors.get_or_insert_with(|| Box::new(set.memory(model)))
    }

    pub(crate) fn linearized(&mut self, model: &Model) -> &mut LinearizeStepWorkspace {
        self.linearized.get_or_insert_with(|| Box::new(LinearizeStepWorkspace::new(model)))
    }

    pub(crate) fn second_order(&mut self, model: &Model) -> &mut SecondOrderWorkspace {
        self.second_order.get_or_insert_with(|| Box::new(SecondOrderWorkspace::new(model)))
    }

    pub(crate) fn dual(&mut self, model: &Model) -> &mut Workspace<Dual<f64, 1>> {
        self.dual.get_or_insert_with(|| Box::new(Workspace::new(model)))
    }
}

/// Memory for batches, with a number of threads of one process.
#[derive(Debug)]
pub(crate) struct Batch<T: ArrayNumber> {
    process: u32,
    threads: usize,
    pub(crate) workspace: BatchWorkspace<T>,
}

impl<T: ArrayNumber> Batch<T> {
    fn start(model: &Model, threads: usize) -> PyResult<Self> {
        let workspace = if threads == 1 {
            let mut options = BatchOptions::default();
            options.threads = 1;
            let started = BatchWorkspace::with_options(model, options);
            started.map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))?
        } else {
            BatchWorkspace::on_threads(model, &threads::pool(threads)?)
        };
        Ok(Self { process: std::process::id(), threads, workspace })
    }
}

/// Some slots for memory. No call waits for a slot: if all are taken, or a fork has left them locked, memory
/// is made for that call alone.
#[derive(Debug)]
pub(crate) struct Slots<T>([Mutex<Option<Box<T>>>; 8]);

impl<T> Slots<T> {
    pub(crate) fn new() -> Self {
        Self([const { Mutex::new(None) }; 8])
    }

    /// A free slot that `wanted` accepts.
    fn free(&self, wanted: impl Fn(&Option<Box<T>>) -> bool) -> Option<MutexGuard<'_, Option<Box<T>>>> {
        self.0.iter().find_map(|slot| {
            let slot = match slot.try_lock() {
                Ok(slot) => slot,
                // All of the memory is scratch: the next call overwrites the values that a panic left in it.
                Err(TryLockError::Poisoned(slot)) => slot.into_inner(),
                Err(TryLockError::WouldBlock) => return None,
            };
            wanted(&slot).then_some(slot)
        })
    }
}

impl Slots<Scratch> {
    /// Computes with memory for one state.
    #[inline]
    pub(crate) fn with<R>(&self, model: &Model, compute: impl FnOnce(&mut Scratch) -> R) -> R {
        if let Some(mut slot) = self.free(|_| true) {
            return compute(slot.get_or_insert_with(|| Box::new(Scratch::new(model))));
        }
        compute(&mut Scratch::new(model))
    }
}

impl<T: ArrayNumber> Slots<Batch<T>> {
    /// Takes memory for batches with this many threads.
    pub(crate) fn take(&self, model: &Model, threads: usize) -> PyResult<Box<Batch<T>>> {
        let process = std::process::id();
        let fits = |slot: &Option<Box<Batch<T>>>| {
            slot.as_ref().is_some_and(|batch| batch.threads == threads && batch.process == process)
        };
        if let Some(batch) = self.free(fits).and_then(|mut slot| slot.take()) {
            return Ok(batch);
        }
        Batch::start(model, threads).map(Box::new)
    }

    /// Returns it to an empty slot, or to one whose memory belongs to another process.
    pub(crate) fn give(&self, batch: Box<Batch<T>>) {
        let process = batch.process;
        let open = |slot: &Option<Box<Batch<T>>>| slot.as_ref().is_none_or(|other| other.process != process);
        if let Some(mut slot) = self.free(open) {
            // The pools of another process are not dropped with it: `threads` keeps them.
            *slot = Some(batch);
        }
    }
}
