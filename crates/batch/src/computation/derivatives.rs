//! Derivatives of dynamics on batches: several tables of results.

use robot_dynamics_core::derivatives::{ForwardDynamicsDerivativesKernel, InverseDynamicsDerivativesKernel};
use robot_dynamics_core::{Model, NativeFunction};
use robot_dynamics_number::dispatch::{Hardware, LaneKernel};
use robot_dynamics_number::{Float, StateLanes};

use crate::bad_states::BadStateSet;
use crate::block::{
    self, Block, BlockStorage, add_poison, bad_lanes, make_room, poison_lanes, read, scatter_all,
};
use crate::distribution::for_each_block;
use crate::kernel_call::call;
use crate::machine_code::{Number, natively};
use crate::tables::{InputTables, check_table};
use crate::workspace::BlockMemory;
use crate::{BadStates, BatchWorkspace};

/// The most blocks in a chunk: about ten microseconds of work.
const BLOCKS_PER_CHUNK: usize = 8;

/// The derivatives of forward dynamics, or of inverse dynamics with two results.
#[track_caller]
pub(crate) fn compute<T: Float + Number, const FORWARD: bool>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    tables: &InputTables<'_, T>,
    results: [&mut [T]; 3],
) -> Result<(), BadStates> {
    workspace.check(model);
    let batch = tables.count(model);
    let size = model.nv * model.nv;
    check_table("the derivative by q", results[0].len(), batch, size);
    check_table("the derivative by v", results[1].len(), batch, size);
    check_table("the derivative by tau", results[2].len(), batch, if FORWARD { size } else { 0 });
    if results[0].is_empty() {
        return Ok(());
    }
    let again = |block: &mut BlockMemory, rows: [&[T]; 3], results: [&mut [T]; 3]| {
        let mut bits = 0;
        block::run(block, BlockDerivatives::<T, FORWARD> { model, states: 1, rows, results, bad: &mut bits });
        bits == 0
    };
    let function = if FORWARD {
        NativeFunction::ForwardDynamicsDerivatives
    } else {
        NativeFunction::InverseDynamicsDerivatives
    };
    let results = match natively(model, workspace, function, tables, results, &again) {
        Ok(result) => return result,
        Err(results) => results,
    };
    let bad = BadStateSet::default();
    for_each_block(workspace, batch, BLOCKS_PER_CHUNK, results, &|block, first, states, results| {
        let rows = tables.rows(first, states);
        let mut bits = 0;
        block::run(block, BlockDerivatives::<T, FORWARD> { model, states, rows, results, bad: &mut bits });
        bad.add(bits, first);
    });
    bad.into_result(batch)
}

/// The derivatives of one block of states.
struct BlockDerivatives<'a, T, const FORWARD: bool> {
    model: &'a Model,
    states: usize,
    rows: [&'a [T]; 3],
    results: [&'a mut [T]; 3],
    bad: &'a mut u32,
}

impl<T: Float, const FORWARD: bool> LaneKernel<BlockStorage, T> for BlockDerivatives<'_, T, FORWARD> {
    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, block: &mut Block<N>) {
        let Self { model, states, rows, results, bad } = self;
        let Block { workspace, input, output, .. } = block;
        let size = model.nv * model.nv;
        make_room(output, 3 * size);
        let ([q, v, third], mut poison) = read::<N, H>(rows, states, input);
        let (by_position, rest) = output.split_at_mut(size);
        let (by_velocity, by_force) = rest.split_at_mut(size);
        let wrenches = &[][..];
        if FORWARD {
            let tau = third;
            call::<H, _, _>(
                &mut workspace.tree,
                ForwardDynamicsDerivativesKernel {
                    model,
                    q,
                    v,
                    tau,
                    wrenches,
                    by_position,
                    by_velocity,
                    by_force,
                },
            );
        } else {
            let a = third;
            call::<H, _, _>(
                &mut workspace.tree,
                InverseDynamicsDerivativesKernel { model, q, v, a, wrenches, by_position, by_velocity },
            );
        }
        let output = &mut output[..if FORWARD { 3 } else { 2 } * size];
        add_poison(&mut poison, output, 1);
        *bad = bad_lanes(poison, states);
        if *bad != 0 {
            poison_lanes(*bad, output);
        }
        for (result, output) in results.into_iter().zip(output.chunks_exact(size)) {
            scatter_all::<N, H>(output, result, size, states);
        }
    }
}
