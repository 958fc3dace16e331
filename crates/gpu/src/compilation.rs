//! Functions of one robot, generated and compiled for a device.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use robot_dynamics::model::Model;
use robot_dynamics_generate::{Arithmetic, Function, Precision, Request, Table, generate};

use crate::DeviceError;
use crate::backend::{Backend, TableCounts};

/// The stack of a thread that compiles: expressions of large robots recurse deeply.
const STACK: usize = 16 << 20;

/// A compiled function, and the tables that it reads and writes.
pub(crate) struct CompiledFunction<K> {
    pub(crate) function: Function,
    pub(crate) reads: Vec<Table>,
    pub(crate) writes: Vec<Table>,
    pub(crate) kernel: K,
}

/// Generates and compiles one function. Each function is a text of its own, so that a cache finds it
/// whichever functions are compiled with it.
pub(crate) fn compile<B: Backend>(
    backend: &B,
    model: &Model,
    precision: Precision,
    function: &Function,
) -> Result<CompiledFunction<B::Kernel>, DeviceError> {
    let mut request = Request::new(B::TARGET, vec![function.clone()])
        .with_arithmetic(Arithmetic::new(precision))
        .with_name("robot");
    // The expected values of generated tests are not used here.
    request.states = 1;
    let generated = generate(model, &request)?;
    let (reads, writes) = (function.reads(model), function.writes(model));
    let tables = TableCounts { reads: reads.len(), writes: writes.len() };
    let kernel = backend.compile(&generated, &function.symbol(), tables).map_err(|cause| {
        let device = backend.name().into();
        DeviceError::Refused { device, function: function.to_string(), robot: model.name().into(), cause }
    })?;
    Ok(CompiledFunction { function: function.clone(), reads, writes, kernel })
}

/// The results of `work` for all items in their order, computed by the threads of the processor; the error of
/// the first item that fails.
pub(crate) fn in_parallel<I: Sync, R: Send>(
    items: &[I],
    work: impl Fn(&I) -> Result<R, DeviceError> + Sync,
) -> Result<Vec<R>, DeviceError> {
    let threads = thread::available_parallelism().map_or(1, usize::from).min(items.len());
    if threads <= 1 {
        return items.iter().map(work).collect();
    }
    let next = AtomicUsize::new(0);
    let run = || {
        let mut done = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(k) else { return done };
            done.push((k, work(item)));
        }
    };
    let mut all = thread::scope(|scope| {
        let spawn = |_| thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run);
        // Without another thread this one does the work.
        let handles: Vec<_> = (0..threads).map_while(|k| spawn(k).ok()).collect();
        if handles.is_empty() {
            return run();
        }
        let results = handles.into_iter().map(|handle| match handle.join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        results.flatten().collect::<Vec<_>>()
    });
    all.sort_by_key(|(k, _)| *k);
    all.into_iter().map(|(_, result)| result).collect()
}
