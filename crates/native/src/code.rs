//! Machine code of a graph, as bytes.

use robot_dynamics_expression::{Graph, Operand, Operation as Node, Sine, as_traced};
use robot_dynamics_number::InstructionSet;

use crate::allocation::allocate;
use crate::error::CompileError;
use crate::instruction::Instruction;
use crate::list::{Address, Base, List, LoadExtent};
use crate::lowering::{Lowering, PreludeValues, Source};
use crate::machine::{Machine, SpillCounts};
use crate::pool::Pool;
use crate::prelude::Prelude;
use crate::rows::{Finiteness, Inputs, Outputs, Rows};
use crate::target::{Target, Width, has_encoder};
use crate::{arm, x86};

/// The largest number of arguments and results together.
pub(crate) const MAX_TABLES: usize = 16;

/// The largest number of operations and numbers: more need addresses that an instruction cannot hold.
const MAX_OPERATIONS: usize = 1 << 22;

/// Counts of a kernel's code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Statistics {
    /// Operations of the graph that the results depend on.
    pub operations: usize,
    /// Instructions, without those that load pointers at the beginning.
    pub instructions: usize,
    /// Bytes of instructions.
    pub code_bytes: usize,
    /// Bytes of constants.
    pub constant_bytes: usize,
    /// Values that were spilled because no register was free.
    pub spills: usize,
    /// Instructions that only load a value into a register.
    pub loads: usize,
    /// Instructions that only copy a register.
    pub copies: usize,
}

/// Machine code of a graph, for any supported processor.
#[derive(Clone, Debug)]
pub struct Code {
    pub(crate) target: Target,
    pub(crate) bytes: Vec<u8>,
    pub(crate) parts: Vec<(Target, Vec<Instruction>)>,
    pub(crate) lengths: Lengths,
    /// Bytes of scratch memory for values.
    scratch_end: i32,
    statistics: Statistics,
}

/// Lengths of the tables and the scratch memory of a kernel, in numbers.
#[derive(Clone, Debug)]
pub(crate) struct Lengths {
    pub(crate) inputs: Vec<usize>,
    pub(crate) outputs: Vec<usize>,
    pub(crate) scratch: usize,
    /// The count of numbers at the beginning of the scratch memory that hold the largest angles.
    pub(crate) angles: usize,
    /// The location of the lanes' sums in scratch memory, which are zero if all results are finite.
    pub(crate) finite: core::ops::Range<usize>,
    /// Whether all constants among the results are finite.
    pub(crate) has_finite_constants: bool,
}

impl Lengths {
    /// `scratch` and `angles` are in bytes.
    fn new(target: Target, lengths: &[usize], results: &[Vec<Operand>], scratch: i32, angles: i32) -> Self {
        let numbers = |bytes: i32| usize::try_from(bytes / target.size()).expect("bytes are counted upwards");
        Self {
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
        }
    }
}

/// The result of instruction selection: the lists of a program.
struct Selection {
    /// The vector prelude of a program for one state.
    prelude: Option<Prelude>,
    list: List,
    /// Bytes of scratch memory for the largest angles.
    angles: i32,
}

/// Selects the operations of a program.
fn select(target: Target, source: Source<'_>, lengths: &[usize], pool: &mut Pool) -> Selection {
    let prelude = match target.width {
        Width::One => Prelude::new(target, source, lengths, pool),
        Width::Lanes => None,
    };
    let nothing = PreludeValues::default();
    let given = prelude.as_ref().map_or(&nothing, |prelude| &prelude.given);
    let with_sines = prelude.as_ref().filter(|prelude| prelude.has_sines);
    let angles_before = with_sines.map_or(0, |prelude| prelude.target.value_bytes());
    let (list, has_sines) = select_operations(target, source, lengths, given, angles_before, pool);
    let angles = angles_before + if has_sines { target.value_bytes() } else { 0 };
    Selection { prelude, list, angles }
}

/// The instructions of each part of a program, with the target of the part.
type Parts = Vec<(Target, Vec<Instruction>)>;

/// Allocates registers for the prelude and the rest of a program. Returns the instructions, the counts, and
/// the end of the scratch memory in bytes.
fn allocate_registers(target: Target, selection: &Selection) -> (Parts, SpillCounts, i32) {
    let Selection { prelude, list, .. } = selection;
    let mut scratch = prelude.as_ref().map_or(2 * target.value_bytes(), |prelude| prelude.scratch_end);
    let (mut parts, mut counts) = (Vec::new(), SpillCounts::default());
    let lists = prelude.iter().map(|prelude| (prelude.target, &prelude.list)).chain([(target, list)]);
    for (target, list) in lists {
        let allocation = allocate(list, Machine::of(target), scratch);
        scratch = allocation.scratch_end;
        counts = counts.plus(allocation.counts);
        parts.push((target, allocation.instructions));
    }
    (parts, counts, scratch)
}

impl Code {
    /// Compiles the results of a graph whose arguments have these lengths.
    ///
    /// # Errors
    /// [`CompileError`], except those that depend on this processor.
    ///
    /// ```
    /// use robot_dynamics_expression::{Arithmetic, trace};
    /// use robot_dynamics_native::{Code, Target, Width};
    /// let arithmetic = Arithmetic::default();
    /// let (graph, results) = trace(arithmetic, &[1], |x| vec![vec![x[0][0] * x[0][0]]]);
    /// let target = Target { instructions: robot_dynamics_number::InstructionSet::Avx2, width: Width::One, arithmetic };
    /// let code = Code::new(&graph, &results, &[1], target)?;
    /// assert!(code.assembly().contains("vmulsd xmm0, xmm0, xmm0"));
    /// # Ok::<(), robot_dynamics_native::CompileError>(())
    /// ```
    #[allow(clippy::missing_panics_doc)] // counts are checked first
    pub fn new(
        graph: &Graph,
        results: &[Vec<Operand>],
        lengths: &[usize],
        target: Target,
    ) -> Result<Self, CompileError> {
        check(graph, results, lengths, target)?;
        // The order of the trace is used: that of `Plan` is the same for all functions of robots except one,
        // where it spills more values.
        let order = as_traced(graph, results);
        let source = Source { graph, results, order: &order };
        let mut pool = Pool::default();
        let selection = select(target, source, lengths, &mut pool);
        let (parts, counts, mut scratch) = allocate_registers(target, &selection);
        let tables = lengths.len() + results.len();
        let scratch_end = scratch;
        let (bytes, code_bytes) = if target.instructions == InstructionSet::Neon {
            scratch += arm::PRESERVED_BYTES;
            arm::encode(target, &parts, tables, scratch_end, &pool.bytes)
        } else {
            x86::encode(target, &parts, tables, &pool.bytes)
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
        let lengths = Lengths::new(target, lengths, results, scratch, selection.angles);
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

/// Selects the operations of a program, and returns whether it computes sines. The largest angle is stored in
/// scratch memory at byte `largest_angle_at`.
fn select_operations(
    target: Target,
    source: Source<'_>,
    lengths: &[usize],
    given: &PreludeValues,
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
            LoadExtent::Number
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
            lowering.list.store(sum, Address::new(Base::Scratch, at, LoadExtent::Register));
            LoadExtent::Register
        }
    };
    let largest = lowering.largest_angle;
    if let Some(largest) = largest {
        lowering.list.store(largest, Address::new(Base::Scratch, largest_angle_at, extent));
    }
    (lowering.list.remove_dead_code(), largest.is_some())
}

/// Rejects graphs that cannot be compiled.
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
    if count > MAX_TABLES {
        return Err(CompileError::TooManyTables { count, most: MAX_TABLES });
    }
    let numbers = lengths.iter().copied().chain(results.iter().map(Vec::len)).fold(0, usize::saturating_add);
    let operations = graph.nodes.len();
    if numbers.saturating_add(operations) > MAX_OPERATIONS {
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
