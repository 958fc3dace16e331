//! Distribution of a batch over threads in chunks of blocks.

use robot_dynamics_core::Model;

use super::bad_states::BadStateSet;
use super::block::{self, Operation};
use super::native::{Number, natively};
use super::share::for_each_block;
use super::workspace::BlockMemory;
use super::{BadStates, BatchFloat, BatchWorkspace};

/// The most blocks in a chunk: about ten microseconds of work.
const BLOCKS_PER_CHUNK: usize = 32;

/// The input tables of an operation with their names and widths; unused ones are empty.
pub struct Tables<'a, T, const A: usize = 3> {
    pub names: [&'static str; A],
    pub widths: [usize; A],
    pub rows: [&'a [T]; A],
}

impl<'a, T, const A: usize> Tables<'a, T, A> {
    /// The rows of some states.
    pub(super) fn rows(&self, first: usize, states: usize) -> [&'a [T]; A] {
        core::array::from_fn(|i| {
            let width = self.widths[i];
            &self.rows[i][first * width..(first + states) * width]
        })
    }

    /// The number of states.
    #[track_caller]
    pub(super) fn count(&self, model: &Model) -> usize {
        let (len, nq) = (self.rows[0].len(), model.nq());
        assert!(len.is_multiple_of(nq.max(1)), "q has {len} numbers, not a multiple of nq = {nq}");
        let batch = len / nq.max(1);
        for k in 1..A {
            check_table(self.names[k], self.rows[k].len(), batch, self.widths[k]);
        }
        batch
    }
}

/// Panics with both numbers if a table has the wrong length.
#[track_caller]
pub(super) fn check_table(name: &str, found: usize, batch: usize, width: usize) {
    let expected = batch * width;
    assert!(found == expected, "{name} has {found} numbers, {batch} states need {expected} ({width} each)");
}

/// Panics if a workspace belongs to another model.
#[track_caller]
pub(super) fn check_workspace<T: BatchFloat>(model: &Model, workspace: &BatchWorkspace<T>) {
    workspace.robot.check(model, "the batch's workspace");
}

/// Computes a batch.
#[track_caller]
pub(super) fn compute<T: BatchFloat + Number, O: Operation<T>>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    operation: O,
    tables: &Tables<'_, T>,
    result: &str,
    output: &mut [T],
) -> Result<(), BadStates> {
    check_workspace(model, workspace);
    let batch = tables.count(model);
    let width = operation.width(model);
    check_table(result, output.len(), batch, width);
    if output.is_empty() {
        return Ok(());
    }
    let output = match operation.native_task(model) {
        None => output,
        Some(task) => {
            let again = |block: &mut BlockMemory, rows: [&[T]; 3], [output]: [&mut [T]; 1]| {
                block::compute(block, model, operation, 1, rows, output) == 0
            };
            match natively(model, workspace, task, tables, [output], &again) {
                Ok(result) => return result,
                Err([output]) => output,
            }
        }
    };
    let bad = BadStateSet::default();
    for_each_block(workspace, batch, BLOCKS_PER_CHUNK, [output], &|memory, first, states, [output]| {
        let rows = tables.rows(first, states);
        bad.add(block::compute(memory, model, operation, states, rows, output), first);
    });
    bad.into_result(batch)
}
