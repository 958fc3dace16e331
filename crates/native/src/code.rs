//! Machine code of a graph, as bytes.

use expression::{Graph, Operand, Operation as Node, Sine, as_traced};
use number::InstructionSet;

use crate::allocate::allocate;
use crate::arm;
use crate::error::CompileError;
use crate::instruction::Instruction;
use crate::list::{Address, Base, Extent, List};
use crate::lower::{Given, Lowering, Source};
use crate::machine::{Counts, Machine};
use crate::pool::Pool;
use crate::prelude::Prelude;
use crate::rows::{Finiteness, Inputs, Outputs, Rows};
use crate::target::{Target, Width, has_encoder};
use crate::x86;

/// The most arguments and results together.
pub(crate) const MOST_TABLES: usize = 16;

/// More operations and numbers than this need addresses that an instruction cannot hold.
const MOST_OPERATIONS: usize = 1 << 22;

/// Counts of a kernel's code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Statistics {
    /// Operations of the graph that the results need.
    pub operations: usize,
    /// Instructions, without those that fetch pointers at the beginning.
    pub instructions: usize,
    /// Bytes of instructions.
    pub code_bytes: usize,
    /// Bytes of constants.
    pub constant_bytes: usize,
    /// Values that were stored as no register was free.
    pub spills: usize,
    /// Instructions that only load a value into a register.
    pub loads: usize,
    /// Instructions that only copy a register.
    pub copies: usize,
}

/// Machine code of a graph for some processor, not necessarily this one.
#[derive(Clone, Debug)]
pub struct Code {
    pub(crate) target: Target,
    pub(crate) bytes: Vec<u8>,
    pub(crate) parts: Vec<(Target, Vec<Instruction>)>,
    pub(crate) lengths: Lengths,
    /// Bytes of scratch memory that values have.
    scratch_end: i32,
    statistics: Statistics,
}

/// Lengths of what a kernel reads and writes, in numbers.
#[derive(Clone, Debug)]
pub(crate) struct Lengths {
    pub(crate) inputs: Vec<usize>,
    pub(crate) outputs: Vec<usize>,
    pub(crate) scratch: usize,
    /// The first numbers of the scratch memory, where the largest angles are.
    pub(crate) angles: usize,
    /// The place of the lanes' sums, which are zeros if all results are finite.
    pub(crate) finite: core::ops::Range<usize>,
    /// Whether all constants among the results are finite.
    pub(crate) has_finite_constants: bool,
}

impl Code {
    /// Compiles the results of a graph whose arguments have these lengths.
    ///
    /// # Errors
    /// [`CompileError`], but for those that depend on the processor at hand.
    ///
    /// ```
    /// use expression::{Arithmetic, trace};
    /// use native::{Code, Target, Width};
    /// let arithmetic = Arithmetic::default();
    /// let (graph, results) = trace(arithmetic, &[1], |x| vec![vec![x[0][0] * x[0][0]]]);
    /// let target = Target { instructions: number::InstructionSet::Avx2, width: Width::One, arithmetic };
    /// let code = Code::new(&graph, &results, &[1], target)?;
    /// assert!(code.assembly().contains("vmulsd xmm0, xmm0, xmm0"));
    /// # Ok::<(), native::CompileError>(())
    /// ```
    #[allow(clippy::missing_panics_doc)] // counts are checked first
    pub fn new(
        graph: &Graph,
        results: &[Vec<Operand>],
        lengths: &[usize],
        target: Target,
    ) -> Result<Self, CompileError> {
        check(graph, results, lengths, target)?;
        // The order of `Plan` was the trace's for all functions of robots but one, where it led to more stored values.
        let order = as_traced(graph, results);
        let source = Source { graph, results, order: &order };
        let mut pool = Pool::default();
        let prelude = match target.width {
            Width::One => Prelude::new(target, source, lengths, &mut pool),
            Width::Lanes => None,
        };
        let nothing = Given::default();
        let given = prelude.as_ref().map_or(&nothing, |prelude| &prelude.given);
        let with_sines = prelude.as_ref().filter(|prelude| prelude.has_sines);
        let angles_before = with_sines.map_or(0, |prelude| prelude.target.value_bytes());
        let (list, has_sines) = lowered(target, source, lengths, given, angles_before, &mut pool);
        let size = target.size();
        let angles = angles_before + if has_sines { target.value_bytes() } else { 0 };
        let mut scratch = prelude.as_ref().map_or(2 * target.value_bytes(), |prelude| prelude.scratch_end);
        let mut parts = Vec::new();
        let mut counts = Counts::default();
        let lists = prelude.iter().map(|prelude| (prelude.target, &prelude.list)).chain([(target, &list)]);
        for (target, list) in lists {
            let allocation = allocate(list, Machine::of(target), scratch);
            scratch = allocation.scratch_end;
            counts = counts.plus(allocation.counts);
            parts.push((target, allocation.instructions));
        }
        let tables = lengths.len() + results.len();
        let scratch_end = scratch;
        let (bytes, code_bytes) = if target.instructions == InstructionSet::Neon {
            scratch += arm::PRESERVED_BYTES;
            arm::encoded(target, &parts, tables, scratch_end, &pool.bytes)
        } else {
            x86::encoded(target, &parts, tables, &pool.bytes)
        };
        let statistics = Statistics {
            operations: order.len(),
            instructions: parts.iter().map(|part| part.1.len()).sum(),
            code_bytes,
            constant_bytes: pool.bytes.len(),
            spills: counts.spills,
            loads: counts.loads,
            copies: counts.copies,
        };
        let numbers = |bytes: i32| usize::try_from(bytes / size).expect("bytes are counted upwards");
        let lengths = Lengths {
            inputs: lengths.to_vec(),
            outputs: results.iter().map(Vec::len).collect(),
            scratch: numbers(scratch),
            angles: numbers(angles),
            finite: match target.width {
                Width::One => 0..0,
                Width::Lanes => target.lanes()..2 * target.lanes(),
            },
            has_finite_constants: (results.iter().flatten())
                .all(|result| result.known().is_none_or(f64::is_finite)),
        };
        Ok(Self { target, bytes, parts, lengths, scratch_end, statistics })
    }

    /// The instructions, followed by the constants that they read.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The instructions as text, one a line: of x86-64 in Intel's syntax.
    pub fn assembly(&self) -> String {
        let tables = self.lengths.inputs.len() + self.lengths.outputs.len();
        if self.target.instructions == InstructionSet::Neon {
            let distance = self.bytes.len() - self.statistics.constant_bytes;
            return arm::assembly(self.target, &self.parts, tables, self.scratch_end, distance);
        }
        x86::assembly(&self.parts, tables)
    }

    /// Counts of the code.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Instructions, width and arithmetic of the code.
    pub fn target(&self) -> Target {
        self.target
    }
}

/// The list of a program, and whether it takes sines; the largest angle is stored in the scratch memory at that byte.
fn lowered(
    target: Target,
    source: Source<'_>,
    lengths: &[usize],
    given: &Given,
    largest_angle_at: i32,
    pool: &mut Pool,
) -> (List, bool) {
    let mut lowering = Lowering::new(target, pool);
    let size = target.size();
    let extent = match target.width {
        Width::One => {
            let mut input = |list: &mut List, argument, index| {
                list.value(Some(Lowering::number_at(argument, index, size)))
            };
            let mut finished = |list: &mut List, (result, index): (usize, usize), value| {
                list.store(value, Lowering::number_at(lengths.len() + result, index, size));
            };
            lowering.graph(source, &mut input, given, &mut finished);
            Extent::Number
        }
        Width::Lanes => {
            let rows = Rows::new(target);
            let mut inputs = Inputs::new(rows, lengths);
            let mut outputs = Outputs::new(rows, lengths.len(), source.results.iter().map(Vec::len));
            let mut input = |list: &mut List, argument, index| inputs.column(list, argument, index);
            let zero = lowering.constant(0.0);
            let mut finiteness = Finiteness::new(zero);
            let mut finished = |list: &mut List, (result, index): (usize, usize), value| {
                finiteness.take(list, value);
                outputs.finish(list, result, index, value);
            };
            lowering.graph(source, &mut input, given, &mut finished);
            outputs.end(&mut lowering.list);
            let sum = finiteness.sum(&mut lowering.list);
            let at = largest_angle_at + target.value_bytes();
            lowering.list.store(sum, Address::new(Base::Scratch, at, Extent::Register));
            Extent::Register
        }
    };
    let largest = lowering.largest_angle;
    if let Some(largest) = largest {
        lowering.list.store(largest, Address::new(Base::Scratch, largest_angle_at, extent));
    }
    (lowering.list.swept(), largest.is_some())
}

/// Refuses what has no code.
fn check(
    graph: &Graph,
    results: &[Vec<Operand>],
    lengths: &[usize],
    target: Target,
) -> Result<(), CompileError> {
    let Target { instructions, arithmetic, .. } = target;
    if !has_encoder(instructions) {
        return Err(CompileError::NoEncoder { instructions });
    }
    if arithmetic.sine == Sine::Platform {
        return Err(CompileError::PlatformSine);
    }
    if graph.precision != arithmetic.precision {
        return Err(CompileError::Precision { found: graph.precision, expected: arithmetic.precision });
    }
    let count = lengths.len() + results.len();
    if count > MOST_TABLES {
        return Err(CompileError::TooManyTables { count, most: MOST_TABLES });
    }
    let numbers = lengths.iter().copied().chain(results.iter().map(Vec::len)).fold(0, usize::saturating_add);
    let operations = graph.nodes.len();
    if numbers.saturating_add(operations) > MOST_OPERATIONS {
        return Err(CompileError::TooLarge { operations });
    }
    for node in &graph.nodes {
        if let Node::Input { argument, index } = *node {
            let (argument, index) = (argument as usize, index as usize);
            let length = lengths.get(argument).copied().unwrap_or(0);
            if index >= length {
                return Err(CompileError::Argument { argument, index, length });
            }
        }
    }
    Ok(())
}
