//! Runs an algorithm on many states in chunks, without the interpreter's lock. Python may interrupt it
//! between two chunks.

use std::time::Instant;

use pyo3::prelude::*;
use rayon::prelude::*;
use robot_dynamics::batch::{BadStates, BatchQuantity, BatchWorkspace};
use robot_dynamics::model::FrameId;
use robot_dynamics::quantity::{Inputs, Quantity};

use crate::number::Number;
use crate::results::{MOST_OPERANDS, MOST_RESULTS};
use crate::robot::Robot;
use crate::row::{Row, Width, Work};
use crate::single_state::{self, homogeneous};
use crate::threads;

/// The first chunk has about `FIRST_NUMBERS` numbers of results, with its states limited to `FIRST_STATES`.
/// The next chunks are sized to take about `CHUNK_SECONDS`.
const FIRST_NUMBERS: usize = 1 << 18;
const FIRST_STATES: core::ops::RangeInclusive<usize> = 64..=8192;
const CHUNK_SECONDS: f64 = 0.1;

/// States that one thread takes at once where the algorithm has no lanes.
const STATES_PER_PIECE: usize = 32;

/// The states' rows of one operand.
pub(crate) enum OperandRows<'a, T> {
    /// A row a state.
    Own(&'a [T]),
    /// One row for all states, repeated for each state of the largest chunk so far.
    One { row: &'a [T], repeated: Vec<T> },
}

impl<'a, T: Number> OperandRows<'a, T> {
    /// The rows of an operand: of each state, or one for all.
    pub(crate) fn of(numbers: &'a [T], are_own: bool) -> Self {
        if are_own { Self::Own(numbers) } else { Self::One { row: numbers, repeated: Vec::new() } }
    }

    fn rows(&mut self, first: usize, states: usize, width: usize) -> &[T] {
        match self {
            Self::Own(rows) => &rows[first * width..(first + states) * width],
            Self::One { row, repeated } => {
                if repeated.is_empty() {
                    repeated.extend_from_slice(row);
                }
                // Twice as many at a time.
                while repeated.len() < states * width {
                    repeated.extend_from_within(..repeated.len().min(states * width - repeated.len()));
                }
                &repeated[..states * width]
            }
        }
    }
}

/// Computes all states. Returns the bad ones, ascending; their results are NaN.
pub(crate) fn run<T: Number>(
    py: Python<'_>,
    robot: &Robot,
    row: &Row,
    frames: &[FrameId],
    states: usize,
    mut operands: [OperandRows<'_, T>; MOST_OPERANDS],
    mut results: [&mut [T]; MOST_RESULTS],
    threads: usize,
) -> PyResult<Vec<usize>> {
    let (model, job) = (&robot.model, Job::of(robot, row, frames, threads));
    let Job { widths, sizes, .. } = job;
    let mut memory = T::batches(robot).take(model, threads)?;
    let chunk = FIRST_NUMBERS / sizes.iter().sum::<usize>().max(1);
    let mut chunk = chunk.clamp(*FIRST_STATES.start(), *FIRST_STATES.end());
    let (mut bad, mut first) = (Vec::new(), 0);
    while first < states {
        let count = chunk.min(states - first);
        let mut at = [&[][..]; MOST_OPERANDS];
        for ((at, rows), width) in at.iter_mut().zip(&mut operands).zip(widths) {
            *at = rows.rows(first, count, width);
        }
        let begun = Instant::now();
        let workspace = &mut memory.workspace;
        let mut part = split_off(&mut results, count, &sizes);
        let own = py.detach(|| job.chunk(workspace, count, at, &mut part));
        bad.extend(own.into_iter().map(|state| first + state));
        py.check_signals()?;
        let seconds = begun.elapsed().as_secs_f64().max(1e-6);
        let growth = (CHUNK_SECONDS / seconds).clamp(0.25, 4.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let next = (count as f64 * growth) as usize;
        chunk = next.next_multiple_of(*FIRST_STATES.start());
        first += count;
    }
    T::batches(robot).give(memory);
    Ok(bad)
}

/// Computes all states at once, without Python. Returns the bad ones, ascending; their results are NaN.
pub(crate) fn run_at_once<T: Number>(
    robot: &Robot,
    row: &Row,
    frames: &[FrameId],
    states: usize,
    x: [&[T]; MOST_OPERANDS],
    mut results: [&mut [T]; MOST_RESULTS],
    threads: usize,
) -> PyResult<Vec<usize>> {
    let mut memory = T::batches(robot).take(&robot.model, threads)?;
    let bad = Job::of(robot, row, frames, threads).chunk(&mut memory.workspace, states, x, &mut results);
    T::batches(robot).give(memory);
    Ok(bad)
}

/// Splits the rows of this many states off the front of each result.
fn split_off<'a, T>(
    results: &mut [&'a mut [T]; MOST_RESULTS],
    states: usize,
    sizes: &[usize; MOST_RESULTS],
) -> [&'a mut [T]; MOST_RESULTS] {
    core::array::from_fn(|k| results[k].split_off_mut(..states * sizes[k]).unwrap_or_default())
}

/// The data that all chunks share.
struct Job<'a> {
    robot: &'a Robot,
    row: &'a Row,
    frames: &'a [FrameId],
    widths: [usize; MOST_OPERANDS],
    sizes: [usize; MOST_RESULTS],
    threads: usize,
}

impl<'a> Job<'a> {
    fn of(robot: &'a Robot, row: &'a Row, frames: &'a [FrameId], threads: usize) -> Self {
        let mut widths = [0; MOST_OPERANDS];
        for (width, operand) in widths.iter_mut().zip(row.operands) {
            *width = operand.width.len(&robot.model, frames.len());
        }
        let mut sizes = [0; MOST_RESULTS];
        for (size, shape) in sizes.iter_mut().zip(row.results) {
            *size = shape.dims(&robot.model, frames.len()).len();
        }
        Self { robot, row, frames, widths, sizes, threads }
    }

    /// Computes one chunk. Returns its bad states, ascending.
    fn chunk<T: Number>(
        &self,
        workspace: &mut BatchWorkspace<T>,
        states: usize,
        x: [&[T]; MOST_OPERANDS],
        results: &mut [&mut [T]; MOST_RESULTS],
    ) -> Vec<usize> {
        let model = &self.robot.model;
        let computed = match self.row.work {
            Work::Quantity(quantity) if quantity.has_batch() && model.nq() > 0 => {
                let inputs = single_state::inputs(quantity, &x, self.frames);
                let [first, second, third, ..] = results;
                quantity.compute_batch(model, workspace, &inputs, [first, second, third])
            }
            Work::Poses if model.nq() > 0 => Some(self.poses(workspace, states, x[0], results[0])),
            Work::Pullback(pullback) if model.nq() > 0 => {
                let results = results.each_mut().map(|result| &mut **result);
                Some(pullback.of_many(model, workspace, x, results))
            }
            _ => None,
        };
        let mut bad = match computed {
            None => self.each(states, x, results),
            Some(Ok(())) => Vec::new(),
            Some(Err(bad)) => bad.states,
        };
        let mut strange = self.without_unit_quaternions(&x);
        if !strange.is_empty() {
            for (result, size) in results.iter_mut().zip(self.sizes) {
                for &state in &strange {
                    result[state * size..(state + 1) * size].fill(T::of(f64::NAN));
                }
            }
            bad.append(&mut strange);
            bad.sort_unstable();
            bad.dedup();
        }
        bad
    }

    /// States with an invalid quaternion, which a batch would normalise.
    fn without_unit_quaternions<T: Number>(&self, x: &[&[T]; MOST_OPERANDS]) -> Vec<usize> {
        if self.robot.quaternions.is_empty() {
            return Vec::new();
        }
        let of_configurations = x
            .iter()
            .zip(self.row.operands)
            .zip(self.widths)
            .filter(|((_, operand), _)| operand.width == Width::Nq);
        let mut bad = Vec::new();
        for ((q, _), width) in of_configurations {
            let rows = q.chunks_exact(width).enumerate();
            bad.extend(rows.filter(|(_, q)| !self.robot.has_unit_quaternions(q)).map(|(state, _)| state));
        }
        bad
    }

    /// Converts the library's twelve numbers of each pose to a homogeneous matrix.
    fn poses<T: Number>(
        &self,
        workspace: &mut BatchWorkspace<T>,
        states: usize,
        q: &[T],
        matrices: &mut [T],
    ) -> Result<(), BadStates> {
        let frames = self.frames.len();
        let mut poses = vec![T::of(0.0); states * frames * 12];
        let inputs = Inputs { q, v: &[], a: &[], tau: &[], frames: self.frames };
        let outcome = Quantity::FramePoses.compute_batch(
            &self.robot.model,
            workspace,
            &inputs,
            [&mut poses, &mut [], &mut []],
        );
        for (matrix, pose) in matrices.chunks_exact_mut(16).zip(poses.chunks_exact(12)) {
            homogeneous(pose, matrix);
        }
        outcome.unwrap_or(Ok(()))
    }

    /// Computes the states one by one, on all threads.
    fn each<T: Number>(
        &self,
        states: usize,
        x: [&[T]; MOST_OPERANDS],
        results: &mut [&mut [T]; MOST_RESULTS],
    ) -> Vec<usize> {
        let mut pieces = Vec::with_capacity(states.div_ceil(STATES_PER_PIECE));
        let mut rest = results.each_mut().map(|result| &mut **result);
        for start in (0..states).step_by(STATES_PER_PIECE) {
            let count = STATES_PER_PIECE.min(states - start);
            pieces.push((start, count, split_off(&mut rest, count, &self.sizes)));
        }
        let run = |(start, count, own)| self.piece(start, count, x, own);
        if self.threads == 1 || pieces.len() == 1 {
            return pieces.into_iter().flat_map(run).collect();
        }
        match threads::pool(self.threads) {
            Ok(pool) => pool.install(|| pieces.into_par_iter().flat_map_iter(run).collect()),
            Err(_) => pieces.into_iter().flat_map(run).collect(),
        }
    }

    /// Computes some states in float64, whatever the type of the arrays.
    fn piece<T: Number>(
        &self,
        start: usize,
        count: usize,
        x: [&[T]; MOST_OPERANDS],
        mut results: [&mut [T]; MOST_RESULTS],
    ) -> Vec<usize> {
        let model = &self.robot.model;
        let mut given: [Vec<f64>; MOST_OPERANDS] = self.widths.map(|width| vec![0.0; width]);
        let mut computed = self.sizes.map(|size| vec![0.0; size]);
        let mut bad = Vec::new();
        self.robot.scratch.with(model, |scratch| {
            for state in 0..count {
                for ((given, x), width) in given.iter_mut().zip(x).zip(self.widths) {
                    let row = &x[(start + state) * width..(start + state + 1) * width];
                    for (given, x) in given.iter_mut().zip(row) {
                        *given = x.double();
                    }
                }
                let read = given.each_ref().map(Vec::as_slice);
                let is_given = read.iter().all(|x| single_state::is_finite(x));
                if is_given {
                    let written = computed.each_mut().map(Vec::as_mut_slice);
                    single_state::compute(self.robot, self.row, scratch, &read, self.frames, written);
                }
                let is_valid = is_given && computed.iter().all(|x| single_state::is_finite(x));
                if !is_valid {
                    bad.push(start + state);
                }
                for ((result, computed), size) in results.iter_mut().zip(&computed).zip(self.sizes) {
                    let row = &mut result[state * size..(state + 1) * size];
                    for (number, computed) in row.iter_mut().zip(computed) {
                        *number = T::of(if is_valid { *computed } else { f64::NAN });
                    }
                }
            }
        });
        bad
    }
}
