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
}

/// A thread's memory for one block.
#[derive(Debug)]
pub(super) struct Block<S: StateLanes> {
    workspace: Workspace<S>,
    input: Vec<S>,
    output: Vec<S>,
    /// The rows of the last block, filled up by repeating the last state.
    padded_input: Vec<S::Float>,
    padded_output: Vec<S::Float>,
}

impl<S: StateLanes> Block<S> {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            workspace: Workspace::new(model),
            input: Vec::new(),
            output: Vec::new(),
            padded_input: Vec::new(),
            padded_output: Vec::new(),
        }
    }

    /// Computes up to [`StateLanes::LANES`] states; `rows` are theirs, and the bits of the bad ones come back.
    pub(super) fn compute<O: Operation<S::Float>>(
        &mut self,
        model: &Model,
        operation: O,
        states: usize,
        rows: [&[S::Float]; 3],
        output: &mut [S::Float],
    ) -> u32 {
        let widths = rows.map(|rows| rows.len() / states);
        let width = output.len() / states;
        let nan = <S::Float as Scalar>::from_f64(f64::NAN);
        self.input.resize(widths.iter().sum(), S::splat(nan));
        self.output.resize(width, S::splat(nan));
        let mut bad = 0;
        if states == S::LANES {
            let lanes = LaneTask { model, operation, widths, rows, output, bad: &mut bad };
            run(
                &mut self.workspace,
                Gathered { task: lanes, input: &mut self.input, result: &mut self.output },
            );
            return bad;
        }
        // The last state stands in for those that are missing, so that nothing depends on a block's size.
        self.padded_input.clear();
        for (rows, width) in rows.into_iter().zip(widths) {
            self.padded_input.extend_from_slice(rows);
            for _ in states..S::LANES {
                self.padded_input.extend_from_slice(&rows[(states - 1) * width..]);
            }
        }
        self.padded_output.resize(S::LANES * width, nan);
        let (first, rest) = self.padded_input.split_at(S::LANES * widths[0]);
        let (second, third) = rest.split_at(S::LANES * widths[1]);
        let lanes = LaneTask {
            model,
            operation,
            widths,
            rows: [first, second, third],
            output: &mut self.padded_output,
            bad: &mut bad,
        };
        run(&mut self.workspace, Gathered { task: lanes, input: &mut self.input, result: &mut self.output });
        output.copy_from_slice(&self.padded_output[..states * width]);
        bad & !(!0 << states)
    }
}

struct LaneTask<'a, T, O> {
    model: &'a Model,
    operation: O,
    widths: [usize; 3],
    rows: [&'a [T]; 3],
    output: &'a mut [T],
    bad: &'a mut u32,
}

struct Gathered<'a, S: StateLanes, O> {
    task: LaneTask<'a, S::Float, O>,
    input: &'a mut [S],
    result: &'a mut [S],
}

impl<S: StateLanes, O: Operation<S::Float>> Task<S> for Gathered<'_, S, O> {
    #[inline(always)]
    fn run<R: Route<S>>(self, workspace: &mut Workspace<R::Number>) {
        let Self { task, input, result } = self;
        let LaneTask { model, operation, widths, rows, output, bad } = task;
        let (first, rest) = input.split_at_mut(widths[0]);
        let (second, third) = rest.split_at_mut(widths[1]);
        gather::<S, R>(rows[0], first);
        gather::<S, R>(rows[1], second);
        gather::<S, R>(rows[2], third);
        operation.run::<S, R>(model, workspace, [&*first, &*second, &*third], result);
        let mut poison = R::Number::zero();
        add_poison::<S, R>(&mut poison, first, 1);
        add_poison::<S, R>(&mut poison, second, 1);
        add_poison::<S, R>(&mut poison, third, 1);
        add_poison::<S, R>(&mut poison, result, operation.watched_step(model));
        *bad = !R::store(poison).finite() & (!0 >> (u32::BITS as usize - S::LANES));
        if *bad != 0 {
            poison_lanes(*bad, result);
        }
        if R::FUSED {
            S::scatter::<true>(result, output);
        } else {
            S::scatter::<false>(result, output);
        }
    }
}

#[inline(always)]
fn gather<S: StateLanes, R: Route<S>>(rows: &[S::Float], to: &mut [S]) {
    if R::FUSED {
        S::gather::<true>(rows, to);
    } else {
        S::gather::<false>(rows, to);
    }
}

/// poison + Σ 0·x: NaN in the lanes where some x is not finite.
#[inline(always)]
fn add_poison<S: StateLanes, R: Route<S>>(poison: &mut R::Number, numbers: &[S], step: usize) {
    let zero = R::Number::zero();
    let mut k = 0;
    while k < numbers.len() {
        *poison = R::load(numbers[k]).mul_add(zero, *poison);
        k += step;
    }
}

#[cold]
#[inline(never)]
fn poison_lanes<S: StateLanes>(bad: u32, result: &mut [S]) {
    let nan = <S::Float as Scalar>::from_f64(f64::NAN);
    for lane in (0..S::LANES).filter(|lane| bad >> lane & 1 == 1) {
        result.iter_mut().for_each(|number| number.set_lane(lane, nan));
    }
}
