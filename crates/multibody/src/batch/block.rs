//! One block of states: gathered into lanes, computed, scattered again.

use dynamics::{Scalar, StateLanes};

use crate::dispatch::{Route, Task, run};
use crate::{Model, Workspace};

/// What is computed of each state.
pub(super) trait Operation<T>: Copy + Sync {
    /// Numbers of one state's result.
    fn width(self, model: &Model) -> usize;

    /// Every how many-th number of the result tells whether all of it is finite.
    fn watched_step(self, model: &Model) -> usize {
        let _ = model;
        1
    }

    /// The result of a block. Must be `#[inline(always)]`, or it is compiled for the oldest machine.
    fn run<S: StateLanes<Float = T>, R: Route<S>>(
        self,
        model: &Model,
        workspace: &mut Workspace<R::Number>,
        input: [&[S]; 3],
        output: &mut [S],
    );

    /// From the result to the states' rows; `mirror` is of [`mirror`].
    #[inline(always)]
    fn scatter<S: StateLanes<Float = T>, R: Route<S>>(
        self,
        workspace: &mut Workspace<R::Number>,
        mirror: &[u32],
        result: &[S],
        rows: &mut [T],
        states: usize,
    ) {
        let _ = mirror;
        scatter_all::<S, R>(workspace, result, rows, result.len(), states);
    }
}

/// A thread's memory for one block.
#[derive(Debug)]
pub(super) struct Block<S: StateLanes> {
    pub(super) workspace: Workspace<S>,
    pub(super) input: Vec<S>,
    pub(super) output: Vec<S>,
    mirror: Vec<u32>,
}

impl<S: StateLanes> Block<S> {
    pub(super) fn new(model: &Model, workspace: Workspace<S>) -> Self {
        Self { workspace, input: Vec::new(), output: Vec::new(), mirror: mirror(model) }
    }

    /// Computes up to [`StateLanes::LANES`] states, whose `rows` these are; returns the bits of the bad ones.
    #[inline(never)]
    pub(super) fn compute<O: Operation<S::Float>>(
        &mut self,
        model: &Model,
        operation: O,
        states: usize,
        rows: [&[S::Float]; 3],
        output: &mut [S::Float],
    ) -> u32 {
        let widths = rows.map(|rows| rows.len() / states);
        self.input.resize(widths.iter().sum(), S::zero());
        self.output.resize(output.len() / states, S::zero());
        let mut bad = 0;
        let Self { workspace, input, output: result, mirror } = self;
        run(
            workspace,
            Lanewise { model, operation, states, widths, rows, output, input, result, mirror, bad: &mut bad },
        );
        bad
    }
}

/// An operation on one block, with its memory.
struct Lanewise<'a, S: StateLanes, O> {
    model: &'a Model,
    operation: O,
    states: usize,
    widths: [usize; 3],
    rows: [&'a [S::Float]; 3],
    output: &'a mut [S::Float],
    input: &'a mut [S],
    result: &'a mut [S],
    mirror: &'a [u32],
    bad: &'a mut u32,
}

impl<S: StateLanes, O: Operation<S::Float>> Task<S> for Lanewise<'_, S, O> {
    #[inline(always)]
    fn run<R: Route<S>>(self, workspace: &mut Workspace<R::Number>) {
        if const { never_runs::<S, R>() } {
            unreachable!("several lanes are chosen only where a register holds them");
        }
        let Self { model, operation, states, widths, rows, output, input, result, mirror, bad } = self;
        let (first, rest) = input.split_at_mut(widths[0]);
        let (second, third) = rest.split_at_mut(widths[1]);
        gather::<S, R>(workspace, rows[0], widths[0], states, first);
        gather::<S, R>(workspace, rows[1], widths[1], states, second);
        gather::<S, R>(workspace, rows[2], widths[2], states, third);
        operation.run::<S, R>(model, workspace, [&*first, &*second, &*third], result);
        let mut poison = R::Number::zero();
        add_poison::<S, R>(&mut poison, first, 1);
        add_poison::<S, R>(&mut poison, second, 1);
        add_poison::<S, R>(&mut poison, third, 1);
        add_poison::<S, R>(&mut poison, result, operation.watched_step(model));
        *bad = bad_lanes::<S, R>(poison, states);
        if *bad != 0 {
            poison_lanes(*bad, result);
        }
        operation.scatter::<S, R>(workspace, mirror, result, output, states);
    }
}

/// Where each entry of M stands when only the upper triangle is written, and of it only what is not always
/// zero: above the diagonal, or, where neither freedom carries the other, at [`zero_entry`].
fn mirror(model: &Model) -> Vec<u32> {
    let nv = model.nv;
    let entry = |i: usize, j: usize| {
        let (above, below) = (i.min(j), i.max(j));
        // With followers all entries are written.
        let place = if model.has_mimic {
            i * nv + j
        } else if below < model.dofs[above].end {
            above * nv + below
        } else {
            zero_entry(nv)
        };
        u32::try_from(place).expect("a matrix of fewer than 2³² entries")
    };
    (0..nv * nv).map(|k| entry(k / nv, k % nv)).collect()
}

/// An entry of M below the diagonal.
pub(super) fn zero_entry(nv: usize) -> usize {
    nv
}

/// A combination that never runs, and need not be compiled: lanes without registers for them, and lone numbers on a
/// machine with registers for more.
pub(super) const fn never_runs<S: StateLanes, R: Route<S>>() -> bool {
    (S::LANES == 1) == R::FUSED
}

/// The first `states` lanes from rows that start every `stride` numbers. In the others the last state stands
/// once more, so that nothing depends on how full a block is.
#[inline(always)]
pub(super) fn gather<S: StateLanes, R: Route<S>>(
    workspace: &mut Workspace<R::Number>,
    rows: &[S::Float],
    stride: usize,
    states: usize,
    to: &mut [S],
) {
    R::share(workspace, Gather { rows, stride, states, to });
}

struct Gather<'a, S: StateLanes> {
    rows: &'a [S::Float],
    stride: usize,
    states: usize,
    to: &'a mut [S],
}

impl<S: StateLanes> Task<S> for Gather<'_, S> {
    #[inline(always)]
    fn run<R: Route<S>>(self, _: &mut Workspace<R::Number>) {
        let Self { rows, stride, states, to } = self;
        if states < S::LANES {
            for lane in 0..S::LANES {
                let start = lane.min(states - 1) * stride;
                for k in 0..to.len() {
                    to[k].set_lane(lane, rows[start + k]);
                }
            }
        } else if R::FUSED {
            S::gather::<true>(rows, stride, to);
        } else {
            S::gather::<false>(rows, stride, to);
        }
    }
}

/// The reverse of [`gather`].
#[inline(always)]
pub(super) fn scatter_all<S: StateLanes, R: Route<S>>(
    workspace: &mut Workspace<R::Number>,
    from: &[S],
    rows: &mut [S::Float],
    stride: usize,
    states: usize,
) {
    R::share(workspace, Scatter { from, rows, stride, states });
}

struct Scatter<'a, S: StateLanes> {
    from: &'a [S],
    rows: &'a mut [S::Float],
    stride: usize,
    states: usize,
}

impl<S: StateLanes> Task<S> for Scatter<'_, S> {
    #[inline(always)]
    fn run<R: Route<S>>(self, _: &mut Workspace<R::Number>) {
        let Self { from, rows, stride, states } = self;
        scatter::<S, R>(from.len(), |k| &from[k], rows, stride, states);
    }
}

/// The reverse of [`gather`], of `width` columns anywhere.
#[inline(always)]
pub(super) fn scatter<'a, S: StateLanes, R: Route<S>>(
    width: usize,
    column: impl Fn(usize) -> &'a S,
    rows: &mut [S::Float],
    stride: usize,
    states: usize,
) {
    if states < S::LANES {
        for lane in 0..states {
            for k in 0..width {
                rows[lane * stride + k] = column(k).lane(lane);
            }
        }
    } else if R::FUSED {
        S::scatter_columns::<true>(width, column, rows, stride);
    } else {
        S::scatter_columns::<false>(width, column, rows, stride);
    }
}

/// poison + Σ 0·x: NaN in the lanes where some x is not finite.
#[inline(always)]
pub(super) fn add_poison<S: StateLanes, R: Route<S>>(poison: &mut R::Number, numbers: &[S], step: usize) {
    let zero = R::Number::zero();
    let mut k = 0;
    while k < numbers.len() {
        *poison = R::load(numbers[k]).mul_add(zero, *poison);
        k += step;
    }
}

/// The lanes of states that are poisoned, a bit each.
#[inline(always)]
pub(super) fn bad_lanes<S: StateLanes, R: Route<S>>(poison: R::Number, states: usize) -> u32 {
    !R::store(poison).finite() & (!0 >> (u32::BITS as usize - states))
}

/// NaN in the lanes of some bits.
#[cold]
#[inline(never)]
pub(super) fn poison_lanes<S: StateLanes>(bad: u32, numbers: &mut [S]) {
    let nan = <S::Float as Scalar>::from_f64(f64::NAN);
    for lane in (0..S::LANES).filter(|lane| bad >> lane & 1 == 1) {
        for number in &mut *numbers {
            number.set_lane(lane, nan);
        }
    }
}
