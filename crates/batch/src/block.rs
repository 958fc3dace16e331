//! One block of states: gather into lanes, computation, and scatter.

use robot_dynamics_core::model::native::NativeTask;
use robot_dynamics_core::{Model, NativeFunction, Workspace};
use robot_dynamics_number::dispatch::{Call, Hardware, LaneKernel, LaneMemory, Storage};
use robot_dynamics_number::{Float, Scalar, StateLanes};

/// The computation for each state.
pub(super) trait Operation<T>: Copy + Sync {
    /// The number of entries in one state's result.
    fn width(self, model: &Model) -> usize;

    /// The function that machine code may compute.
    fn native(self) -> Option<NativeFunction> {
        None
    }

    /// The same function for a frame, if it has one.
    fn native_task(self, model: &Model) -> Option<NativeTask> {
        let _ = model;
        self.native().map(Into::into)
    }

    /// The stride of the entries that show whether the whole result is finite.
    fn watched_step(self, model: &Model) -> usize {
        let _ = model;
        1
    }

    /// Accumulates in `poison` the entries that show whether the whole result is finite.
    #[inline(always)]
    fn watch<N: StateLanes<Float = T>>(self, model: &Model, result: &[N], poison: &mut N) {
        add_poison(poison, result, self.watched_step(model));
    }

    /// The result of a block. It must be `#[inline(always)]`; otherwise it is compiled for the baseline
    /// instruction set.
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        input: [&[N]; 3],
        output: &mut [N],
    );
}

/// [`Block`] over any scalar type.
pub(super) struct BlockStorage;

impl Storage for BlockStorage {
    type Over<S: Scalar> = Block<S>;
    type Input<'a> = &'a Model;
    fn new<S: Scalar>(model: &Model) -> Block<S> {
        Block { workspace: Workspace::scratch(model), input: Vec::new(), output: Vec::new() }
    }
}

/// A thread's memory for one block.
#[derive(Clone)]
pub(super) struct Block<S: Scalar> {
    pub(super) workspace: Workspace<S>,
    pub(super) input: Vec<S>,
    pub(super) output: Vec<S>,
}

/// Resizes to `count` numbers with unspecified values; they are written before they are read.
#[inline(never)]
pub(super) fn make_room<S: Scalar>(numbers: &mut Vec<S>, count: usize) {
    numbers.resize(count, S::zero());
}

/// Runs a kernel. It is one function for all kinds of threads, because it contains the code of the kernel for
/// every instruction set.
#[inline(never)]
pub(super) fn run<T: Float>(block: &mut LaneMemory<BlockStorage>, kernel: impl LaneKernel<BlockStorage, T>) {
    block.run(kernel);
}

/// Computes up to one block of states, given their `rows`; returns a bit for each bad state.
pub(super) fn compute<T: Float, O: Operation<T>>(
    block: &mut LaneMemory<BlockStorage>,
    model: &Model,
    operation: O,
    states: usize,
    rows: [&[T]; 3],
    output: &mut [T],
) -> u32 {
    let mut bad = 0;
    run(block, BlockKernel { model, operation, states, rows, output, bad: &mut bad });
    bad
}

/// An operation on one block.
struct BlockKernel<'a, T, O> {
    model: &'a Model,
    operation: O,
    states: usize,
    rows: [&'a [T]; 3],
    output: &'a mut [T],
    bad: &'a mut u32,
}

impl<T: Float, O: Operation<T>> LaneKernel<BlockStorage, T> for BlockKernel<'_, T, O> {
    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(self, block: &mut Block<N>) {
        let Self { model, operation, states, rows, output, bad } = self;
        let Block { workspace, input, output: result } = block;
        make_room(result, output.len() / states);
        let (input, mut poison) = read::<N, H>(rows, states, input);
        operation.run::<N, H>(model, workspace, input, result);
        operation.watch(model, result, &mut poison);
        *bad = bad_lanes(poison, states);
        if *bad != 0 {
            poison_lanes(*bad, result);
        }
        let width = result.len();
        scatter_all::<N, H>(result, output, width, states);
    }
}

/// Gathers the states of three tables, and accumulates [`add_poison`] of them.
#[inline(always)]
pub(super) fn read<'a, N: StateLanes, H: Hardware>(
    rows: [&[N::Float]; 3],
    states: usize,
    input: &'a mut Vec<N>,
) -> ([&'a [N]; 3], N) {
    let widths = rows.map(|rows| rows.len() / states);
    make_room(input, widths.iter().sum());
    let (first, rest) = input.split_at_mut(widths[0]);
    let (second, third) = rest.split_at_mut(widths[1]);
    let mut poison = N::zero();
    for (k, table) in [&mut *first, &mut *second, &mut *third].into_iter().enumerate() {
        gather::<N, H>(rows[k], widths[k], states, table);
        add_poison(&mut poison, table, 1);
    }
    ([first, second, third], poison)
}

/// Gathers the first `states` lanes from rows at a distance of `stride` numbers. The other lanes repeat the
/// last state, so that results do not depend on the number of states in a block.
#[inline(always)]
pub(super) fn gather<N: StateLanes, H: Hardware>(
    rows: &[N::Float],
    stride: usize,
    states: usize,
    to: &mut [N],
) {
    H::call(Gather { rows, stride, states, to });
}

struct Gather<'a, N: StateLanes> {
    rows: &'a [N::Float],
    stride: usize,
    states: usize,
    to: &'a mut [N],
}

impl<N: StateLanes> Call for Gather<'_, N> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let Self { rows, stride, states, to } = self;
        N::gather_first(states, rows, stride, to);
    }
}

/// The inverse of [`gather`].
#[inline(always)]
pub(super) fn scatter_all<N: StateLanes, H: Hardware>(
    from: &[N],
    rows: &mut [N::Float],
    stride: usize,
    states: usize,
) {
    H::call(Scatter { from, rows, stride, states });
}

struct Scatter<'a, N: StateLanes> {
    from: &'a [N],
    rows: &'a mut [N::Float],
    stride: usize,
    states: usize,
}

impl<N: StateLanes> Call for Scatter<'_, N> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let Self { from, rows, stride, states } = self;
        N::scatter_first(states, from.len(), |k| &from[k], rows, stride);
    }
}

/// poison + Σ 0·x, which is NaN in the lanes where some x is not finite.
#[inline(always)]
pub(super) fn add_poison<N: StateLanes>(poison: &mut N, numbers: &[N], step: usize) {
    let zero = N::zero();
    let mut k = 0;
    while k < numbers.len() {
        *poison = numbers[k].mul_add(zero, *poison);
        k += step;
    }
}

/// A bit for each state whose lane is NaN.
#[inline(always)]
pub(super) fn bad_lanes<N: StateLanes>(poison: N, states: usize) -> u32 {
    !poison.finite() & (!0 >> (u32::BITS as usize - states))
}

/// Writes NaN to the lanes of the set bits.
#[cold]
#[inline(never)]
pub(super) fn poison_lanes<N: StateLanes>(bad: u32, numbers: &mut [N]) {
    let nan = <N::Float as Scalar>::from_f64(f64::NAN);
    for number in numbers {
        let own = *number;
        *number = N::from_lanes(|lane| if bad >> lane & 1 == 1 { nan } else { own.lane(lane) });
    }
}
