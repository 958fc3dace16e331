//! A batch of an operation with one table of results.

use robot_dynamics_core::Model;
use robot_dynamics_number::Float;

use crate::bad_states::BadStateSet;
use crate::block::{self, Operation};
use crate::distribution::for_each_block;
use crate::machine_code::{Number, natively};
use crate::tables::{InputTables, check_table};
use crate::workspace::BlockMemory;
use crate::{BadStates, BatchWorkspace};

/// The most blocks in a chunk: about ten microseconds of work.
const BLOCKS_PER_CHUNK: usize = 32;

/// Computes a batch.
#[track_caller]
pub(crate) fn compute<T: Float + Number, O: Operation<T>>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    operation: O,
    tables: &InputTables<'_, T>,
    result: &str,
    output: &mut [T],
) -> Result<(), BadStates> {
    workspace.check(model);
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
