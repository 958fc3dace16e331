//! Vector-Jacobian products on batches, by machine code or by the recursions.

use robot_dynamics_core::derivatives::{
    ArticulatedBodiesPullback, NewtonEulerPullback, negate, solve_negative,
};
use robot_dynamics_core::{Model, NativeFunction, Workspace, parameter_count};
use robot_dynamics_number::dispatch::{Hardware, LaneKernel};
use robot_dynamics_number::{Float, StateLanes};

use super::recursions::accelerate;
use crate::bad_states::BadStateSet;
use crate::block::{
    self, Block, BlockStorage, add_poison, bad_lanes, gather, make_room, poison_lanes, scatter_all,
};
use crate::distribution::for_each_block;
use crate::kernel_call::call;
use crate::machine_code::{Number, natively};
use crate::tables::{InputTables, check_table};
use crate::workspace::BlockMemory;
use crate::{BadStates, BatchWorkspace};

/// The most blocks in a chunk: about ten microseconds of work.
const BLOCKS_PER_CHUNK: usize = 16;

/// The results: the acceleration (forward dynamics only), the cotangents of q, v and the third input, and
/// those of the parameters.
#[track_caller]
pub(crate) fn compute<T: Float + Number, const FORWARD: bool>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    tables: &InputTables<'_, T, 4>,
    results: [&mut [T]; 5],
) -> Result<(), BadStates> {
    workspace.check(model);
    let (batch, nv) = (tables.count(model), model.nv());
    check_table("the acceleration", results[0].len(), batch, if FORWARD { nv } else { 0 });
    let names = ["the cotangent of q", "the cotangent of v", "the cotangent of a or tau"];
    for (name, rows) in names.into_iter().zip(&results[1..4]) {
        check_table(name, rows.len(), batch, nv);
    }
    let parameters = if results[4].is_empty() { 0 } else { parameter_count(model) };
    check_table("the parameters", results[4].len(), batch, parameters);
    if batch == 0 || nv == 0 {
        return Ok(());
    }
    let results = if parameters == 0 {
        match pull_natively::<T, FORWARD>(model, workspace, tables, results) {
            Ok(result) => return result,
            Err(results) => results,
        }
    } else {
        results
    };
    let bad = BadStateSet::default();
    for_each_block(workspace, batch, BLOCKS_PER_CHUNK, results, &|block, first, states, results| {
        let (rows, mut bits) = (tables.rows(first, states), 0);
        block::run(block, BlockPullback::<T, FORWARD> { model, states, rows, results, bad: &mut bits });
        bad.add(bits, first);
    });
    bad.into_result(batch)
}

/// Computes the pullbacks by machine code, without cotangents of parameters. Returns the result tables if
/// the model has no code for them.
fn pull_natively<'a, T: Float + Number, const FORWARD: bool>(
    model: &Model,
    workspace: &BatchWorkspace<T>,
    tables: &InputTables<'_, T, 4>,
    [acceleration, by_position, by_velocity, by_third, parameters]: [&'a mut [T]; 5],
) -> Result<Result<(), BadStates>, [&'a mut [T]; 5]> {
    let again = |block: &mut BlockMemory, rows: [&[T]; 4], results: [&mut [T]; 5]| {
        let mut bits = 0;
        block::run(block, BlockPullback::<T, FORWARD> { model, states: 1, rows, results, bad: &mut bits });
        bits == 0
    };
    if FORWARD {
        let results = [acceleration, by_position, by_velocity, by_third, parameters];
        return natively(model, workspace, NativeFunction::ForwardDynamicsPullback, tables, results, &again);
    }
    // Machine code writes the first results; the pullback of inverse dynamics has no acceleration.
    let results = [by_position, by_velocity, by_third, acceleration, parameters];
    let again =
        |block: &mut BlockMemory, rows: [&[T]; 4], [x, y, z, acceleration, parameters]: [&mut [T]; 5]| {
            again(block, rows, [acceleration, x, y, z, parameters])
        };
    natively(model, workspace, NativeFunction::InverseDynamicsPullback, tables, results, &again)
        .map_err(|[x, y, z, acceleration, parameters]| [acceleration, x, y, z, parameters])
}

/// The pullbacks of one block of states.
struct BlockPullback<'a, T, const FORWARD: bool> {
    model: &'a Model,
    states: usize,
    rows: [&'a [T]; 4],
    results: [&'a mut [T]; 5],
    bad: &'a mut u32,
}

impl<T: Float, const FORWARD: bool> LaneKernel<BlockStorage, T> for BlockPullback<'_, T, FORWARD> {
    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, block: &mut Block<N>) {
        let Self { model, states, rows, results, bad } = self;
        let Block { workspace, input, output, .. } = block;
        let (nq, nv) = (model.nq, model.nv);
        let widths = [0, 1, 2, 3, 4].map(|i| results[i].len() / states);
        make_room(input, nq + 3 * nv);
        make_room(output, 4 * nv + widths[4]);
        let (q, rest) = input.split_at_mut(nq);
        let (v, rest) = rest.split_at_mut(nv);
        let (third, cotangent) = rest.split_at_mut(nv);
        let mut poison = N::zero();
        for (rows, to) in rows.into_iter().zip([&mut *q, &mut *v, &mut *third, &mut *cotangent]) {
            gather::<N, H>(rows, rows.len() / states, states, to);
            add_poison(&mut poison, to, 1);
        }
        let (acceleration, rest) = output.split_at_mut(nv);
        let (by_position, rest) = rest.split_at_mut(nv);
        let (by_velocity, rest) = rest.split_at_mut(nv);
        let (by_third, parameters) = rest.split_at_mut(nv);
        parameters.fill(N::zero());
        if FORWARD {
            let to =
                ForwardPullback { acceleration, by_position, by_velocity, by_force: by_third, parameters };
            pull_forward::<N, H>(model, workspace, [q, v, third, cotangent], to);
        } else {
            acceleration.fill(N::zero());
            let newton_euler = NewtonEulerPullback {
                model,
                q,
                v,
                a: third,
                wrenches: &[],
                cotangent,
                by_position,
                by_velocity,
                by_acceleration: by_third,
                parameters,
            };
            call::<H, _, _>(&mut workspace.tree, newton_euler);
        }
        add_poison(&mut poison, output, 1);
        *bad = bad_lanes(poison, states);
        if *bad != 0 {
            poison_lanes(*bad, output);
        }
        let mut first = 0;
        for (i, rows) in results.into_iter().enumerate() {
            let width = if i == 4 { widths[4] } else { nv };
            if !rows.is_empty() {
                scatter_all::<N, H>(&output[first..first + width], rows, width, states);
            }
            first += width;
        }
    }
}

/// The results of the pullback of forward dynamics; those of the parameters are accumulated.
pub(crate) struct ForwardPullback<'a, N> {
    pub acceleration: &'a mut [N],
    pub by_position: &'a mut [N],
    pub by_velocity: &'a mut [N],
    pub by_force: &'a mut [N],
    pub parameters: &'a mut [N],
}

/// The pullback of forward dynamics of a block at q, v, τ, for a cotangent of a.
#[inline(always)]
pub(crate) fn pull_forward<N: StateLanes, H: Hardware>(
    model: &Model,
    workspace: &mut Workspace<N>,
    [q, v, tau, cotangent]: [&[N]; 4],
    to: ForwardPullback<'_, N>,
) {
    let ForwardPullback { acceleration, by_position, by_velocity, by_force, parameters } = to;
    let wrenches = &[][..];
    if model.needs_dense_factor {
        // If branches are coupled, the articulated-body recursion does not apply; one factor of M serves both
        // results.
        accelerate::<N, H>(model, workspace, q, v, tau, acceleration);
        solve_negative(&workspace.dense, cotangent, by_force);
        let newton_euler = NewtonEulerPullback {
            model,
            q,
            v,
            a: acceleration,
            wrenches,
            cotangent: by_force,
            by_position,
            by_velocity,
            by_acceleration: &mut [],
            parameters,
        };
        call::<H, _, _>(&mut workspace.tree, newton_euler);
        negate(by_force);
        return;
    }
    let bodies = ArticulatedBodiesPullback {
        model,
        q,
        v,
        tau,
        wrenches,
        cotangent,
        acceleration,
        by_position,
        by_velocity,
        by_force,
        parameters,
    };
    call::<H, _, _>(&mut workspace.tree, bodies);
}
