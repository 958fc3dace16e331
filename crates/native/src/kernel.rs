//! A function in machine code.

use core::marker::PhantomData;

use robot_dynamics_expression::{Arithmetic, Graph, Operand, Precision};
use robot_dynamics_number::InstructionSet;
use robot_dynamics_number::sine::{RANGE, SHORT_RANGE};

use crate::check::check;
use crate::code::{Code, Statistics};
use crate::error::CompileError;
use crate::float::Float;
use crate::page::{AccessBounds, Page, Table};
use crate::rows::padding;
use crate::target::{Target, Width};

/// An angle is too large for the sine of machine code: at least 1e5 rad in double precision, 8192 rad in
/// single precision. The results differ from those of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "an angle exceeds the range of the machine code's sine; compute this state by the library's recursions"
)]
pub struct AngleOutOfRange;

/// A graph as machine code, for one state or for several at once.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, trace};
/// use robot_dynamics_native::{Kernel, Width, best_instructions};
/// let arithmetic = Arithmetic::default();
/// let (graph, results) = trace(arithmetic, &[2], |x| vec![vec![x[0][0] * x[0][0] + x[0][1]]]);
/// let instructions = best_instructions();
/// let kernel = match Kernel::<f64>::compile(&graph, &results, &[2], arithmetic, instructions, Width::One) {
///     Ok(kernel) => kernel,
///     Err(reason) => return Ok(println!("{reason}")), // no encoder for this processor
/// };
/// let (mut y, mut scratch) = ([0.0], vec![0.0; kernel.scratch_len()]);
/// kernel.call(&[&[3.0, 0.5]], &mut [&mut y], &mut scratch)?;
/// assert_eq!(y, [9.5]);
/// # Ok::<(), robot_dynamics_native::AngleOutOfRange>(())
/// ```
#[derive(Debug)]
pub struct Kernel<T> {
    page: Page,
    reach: AccessBounds,
    target: Target,
    angles: usize,
    finite: core::ops::Range<usize>,
    has_finite_constants: bool,
    /// Numbers of scratch memory that the code itself uses.
    own_scratch: usize,
    statistics: Statistics,
    code: usize,
    number: PhantomData<fn(T) -> T>,
}

impl<T: Float> Kernel<T> {
    /// Compiles the results of a graph whose arguments have these lengths, and checks the code in two random
    /// states.
    ///
    /// # Errors
    /// [`CompileError`].
    pub fn compile(
        graph: &Graph,
        results: &[Vec<Operand>],
        lengths: &[usize],
        arithmetic: Arithmetic,
        instructions: InstructionSet,
        width: Width,
    ) -> Result<Self, CompileError> {
        let target = Target { instructions, width, arithmetic };
        let code = Code::new(graph, results, lengths, target)?;
        let kernel = Self::load(&code)?;
        let mut scratch = vec![T::nearest(0.0); kernel.scratch_len()];
        check(graph, results, lengths, arithmetic, |states, inputs, outputs| {
            kernel.call_rows(states, inputs, outputs, &mut scratch, |_| {});
        })?;
        Ok(kernel)
    }

    /// Makes code executable, without the check of [`compile`](Self::compile).
    ///
    /// # Errors
    /// [`CompileError::Precision`], [`CompileError::NotOnThisProcessor`], [`CompileError::Refused`].
    ///
    /// ```
    /// use robot_dynamics_expression::{Arithmetic, trace};
    /// use robot_dynamics_native::{Code, Kernel, Target, Width, best_instructions};
    /// let arithmetic = Arithmetic::default();
    /// let (graph, results) = trace(arithmetic, &[2], |x| vec![vec![x[0][0] + x[0][1]]]);
    /// let target = Target { instructions: best_instructions(), width: Width::One, arithmetic };
    /// if let Ok(code) = Code::new(&graph, &results, &[2], target) {
    ///     let kernel = Kernel::<f64>::load(&code)?;
    ///     assert_eq!(kernel.statistics().operations, 1);
    /// }
    /// # Ok::<(), robot_dynamics_native::CompileError>(())
    /// ```
    pub fn load(code: &Code) -> Result<Self, CompileError> {
        let target = code.target;
        let Target { instructions, arithmetic, .. } = target;
        if arithmetic.precision != T::PRECISION {
            return Err(CompileError::Precision { found: arithmetic.precision, expected: T::PRECISION });
        }
        if !instructions.is_available() {
            return Err(CompileError::NotOnThisProcessor { instructions });
        }
        let page = Page::new(&code.bytes).map_err(|cause| CompileError::Refused { cause })?;
        let lanes = target.lanes();
        let table = |&width: &usize| match target.width {
            Width::One => Table { width, reach: width },
            Width::Lanes => Table { width, reach: lanes * width + padding(width, lanes) },
        };
        let lengths = &code.lengths;
        let tables = |lengths: &[usize]| lengths.iter().map(table).collect::<Vec<Table>>();
        let reach = AccessBounds::new(&tables(&lengths.inputs), &tables(&lengths.outputs), lengths.scratch);
        Ok(Self {
            page,
            reach,
            target,
            angles: lengths.angles,
            finite: lengths.finite.clone(),
            has_finite_constants: lengths.has_finite_constants,
            own_scratch: lengths.scratch,
            statistics: code.statistics(),
            code: code.bytes.len(),
            number: PhantomData,
        })
    }

    /// The number of states that one run computes: 1, or the lanes of a register.
    pub fn lanes(&self) -> usize {
        self.target.lanes()
    }

    /// Counts of the code.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Instructions, width and arithmetic of the code.
    pub fn target(&self) -> Target {
        self.target
    }

    /// Bytes of instructions and constants.
    pub fn code_len(&self) -> usize {
        self.code
    }

    /// Numbers of scratch memory that a call needs. They need no initial values.
    pub fn scratch_len(&self) -> usize {
        match self.target.width {
            Width::One => self.own_scratch,
            Width::Lanes => {
                self.own_scratch + self.reach.tables().iter().map(|table| table.reach).sum::<usize>()
            }
        }
    }

    /// Computes one state.
    ///
    /// # Errors
    /// [`AngleOutOfRange`]: the results differ from those of the graph.
    ///
    /// # Panics
    /// If an argument or a result has the wrong length, if the scratch memory is too short, or if the kernel
    /// is one for lanes.
    #[inline]
    pub fn call(
        &self,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
        scratch: &mut [T],
    ) -> Result<(), AngleOutOfRange> {
        assert!(self.target.width == Width::One, "this kernel is compiled for lanes: use `call_rows`");
        if !self.page.run(&self.reach, inputs, outputs, scratch) {
            self.panic_for_lengths(inputs, outputs, scratch);
        }
        let is_within = scratch[..self.angles].iter().all(|&largest| Self::is_within(largest));
        if is_within { Ok(()) } else { Err(AngleOutOfRange) }
    }

    /// Computes states whose arguments and results are rows of tables, and returns whether all results are
    /// finite. Calls `out_of_range` with each row that has an angle out of range, whose results differ from
    /// those of the graph.
    ///
    /// # Panics
    /// If a table has the wrong number of rows, or the scratch memory is too short.
    ///
    /// ```
    /// use robot_dynamics_expression::{Arithmetic, trace};
    /// use robot_dynamics_native::{Code, Kernel, Target, Width, best_instructions};
    /// let arithmetic = Arithmetic::default();
    /// let (graph, results) = trace(arithmetic, &[2], |x| vec![vec![x[0][0] + x[0][1]]]);
    /// let instructions = best_instructions();
    /// if let Ok(kernel) = Kernel::<f64>::compile(&graph, &results, &[2], arithmetic, instructions, Width::Lanes) {
    ///     let (mut sums, mut scratch) = ([0.0; 3], vec![0.0; kernel.scratch_len()]);
    ///     let rows = [1.0, 10.0, 2.0, 20.0, 3.0, 30.0]; // three states of two numbers
    ///     let is_finite = kernel.call_rows(3, &[&rows], &mut [&mut sums], &mut scratch, |row| println!("{row}"));
    ///     assert!(is_finite && sums == [11.0, 22.0, 33.0]);
    /// }
    /// ```
    pub fn call_rows(
        &self,
        rows: usize,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
        scratch: &mut [T],
        mut out_of_range: impl FnMut(usize),
    ) -> bool {
        self.check_lengths(rows, inputs, outputs, scratch);
        let lanes = self.lanes();
        let whole = self
            .reach
            .tables()
            .iter()
            .zip(inputs.iter().map(|x| x.len()).chain(outputs.iter().map(|x| x.len())));
        // Blocks of rows are computed in place, as far as each table extends.
        let of_table = |(table, length): (&Table, usize)| match length.checked_sub(table.reach) {
            None => 0,
            Some(_) if table.width == 0 => usize::MAX,
            Some(rest) => rest / (lanes * table.width) + 1,
        };
        let blocks = whole.map(of_table).min().unwrap_or(rows / lanes).min(rows / lanes);
        let (own, copies) = scratch.split_at_mut(self.own_scratch);
        let mut is_finite = self.has_finite_constants;
        self.page.run_blocks(&self.reach, (blocks, lanes), inputs, outputs, own, |scratch, block| {
            self.report(scratch, |lane| out_of_range(block * lanes + lane), lanes);
            is_finite &= self.is_finite(scratch);
        });
        let mut row = blocks * lanes;
        while row < rows {
            let here = lanes.min(rows - row);
            self.run_on_copy(row, here, inputs, outputs, own, copies);
            self.report(own, |lane| out_of_range(row + lane), here);
            is_finite &= self.is_finite(own);
            row += here;
        }
        let of_one_state = || outputs.iter().flat_map(|output| output.iter()).all(|&x| x.into().is_finite());
        is_finite && (self.target.width == Width::Lanes || of_one_state())
    }

    /// Whether the results of all lanes, constants excepted, are finite.
    fn is_finite(&self, scratch: &[T]) -> bool {
        scratch[self.finite.clone()].iter().all(|&sum| sum.into() == 0.0)
    }

    /// Computes some rows in a copy that extends beyond its last row.
    fn run_on_copy(
        &self,
        row: usize,
        count: usize,
        inputs: &[&[T]],
        outputs: &mut [&mut [T]],
        own: &mut [T],
        mut copies: &mut [T],
    ) {
        const MOST: usize = crate::code::MAX_TABLES;
        let mut tables: [&mut [T]; MOST] = core::array::from_fn(|_| Default::default());
        for (copy, table) in tables.iter_mut().zip(self.reach.tables()) {
            (*copy, copies) = core::mem::take(&mut copies).split_at_mut(table.reach);
        }
        let (of_inputs, of_outputs) = tables.split_at_mut(inputs.len());
        for ((copy, input), table) in of_inputs.iter_mut().zip(inputs).zip(self.reach.inputs()) {
            let width = table.width;
            for lane in 0..self.lanes() {
                // Unused lanes repeat the last state.
                let from = (row + lane.min(count - 1)) * width;
                copy[lane * width..][..width].copy_from_slice(&input[from..from + width]);
            }
        }
        let shared: [&[T]; MOST] = core::array::from_fn(|k| of_inputs.get(k).map_or(&[][..], |copy| copy));
        let of_outputs = &mut of_outputs[..outputs.len()];
        let ran = self.page.run(&self.reach, &shared[..inputs.len()], of_outputs, own);
        assert!(ran, "copies are as long as the code reaches");
        for ((copy, output), table) in of_outputs.iter().zip(outputs).zip(self.reach.outputs()) {
            let width = table.width;
            output[row * width..][..count * width].copy_from_slice(&copy[..count * width]);
        }
    }

    /// Reports the lanes, among the first ones, whose angles are out of range.
    fn report(&self, scratch: &[T], mut out_of_range: impl FnMut(usize), lanes: usize) {
        let largest = &scratch[..self.angles];
        if largest.iter().all(|&largest| Self::is_within(largest)) {
            return;
        }
        match self.target.width {
            Width::One => out_of_range(0),
            Width::Lanes => {
                (0..lanes).filter(|&lane| !Self::is_within(largest[lane])).for_each(&mut out_of_range);
            }
        }
    }

    /// Whether the sine is valid for angles up to this magnitude.
    #[inline]
    fn is_within(largest: T) -> bool {
        let range = match T::PRECISION {
            Precision::Double => RANGE,
            Precision::Single => SHORT_RANGE,
        };
        largest.into() < range
    }

    /// Panics with the slice that has the wrong length.
    #[cold]
    fn panic_for_lengths(&self, inputs: &[&[T]], outputs: &[&mut [T]], scratch: &[T]) -> ! {
        self.check_lengths(1, inputs, outputs, scratch);
        unreachable!("one of the lengths is another")
    }

    fn check_lengths(&self, rows: usize, inputs: &[&[T]], outputs: &[&mut [T]], scratch: &[T]) {
        let (of_inputs, of_outputs) = (self.reach.inputs(), self.reach.outputs());
        assert!(
            inputs.len() == of_inputs.len() && outputs.len() == of_outputs.len(),
            "the kernel has {} arguments and {} results, got {} and {}",
            of_inputs.len(),
            of_outputs.len(),
            inputs.len(),
            outputs.len()
        );
        let expected = |table: &Table| rows.checked_mul(table.width).expect("so many rows fit into memory");
        for (number, (input, table)) in inputs.iter().zip(of_inputs).enumerate() {
            let (found, expected) = (input.len(), expected(table));
            assert!(found == expected, "argument {number} has {found} numbers, expected {expected}");
        }
        for (number, (output, table)) in outputs.iter().zip(of_outputs).enumerate() {
            let (found, expected) = (output.len(), expected(table));
            assert!(found == expected, "result {number} has {found} numbers, expected {expected}");
        }
        let needed = self.scratch_len();
        assert!(
            scratch.len() >= needed,
            "the scratch memory has {} numbers, but a call needs {needed}",
            scratch.len()
        );
    }
}
