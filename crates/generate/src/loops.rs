//! Loop rerolling: operations that repeat from body to body are written once, as a loop.
//!
//! The recursions go from body to body. Where successive bodies are alike, their operations differ only in
//! the numbers that they read. These are numbers of the previous body, arguments, constants, and values that
//! an earlier recursion computed for the same body. If the position of each of these changes by a constant
//! stride, the operations become the body of a loop. They are the same operations, each after its operands,
//! so that no bit changes.
//!
//! 1. `repetition` finds stretches of the trace in which operations repeat with a fixed period, and in them
//!    the iterations whose operands have constant strides.
//! 2. [`divide`] cuts the trace into segments, loops and straight code, in parts of about equal length.
//! 3. [`Arrangement::classify`] determines where each operand of a loop comes from. It is loop-invariant, or
//!    it comes from a table of constants, an argument, the same iteration, the iteration before, or other
//!    code.
//! 4. `memory` places the values that one segment computes and another one reads in one array. Each operand
//!    of a loop has a constant stride. The places of dead values are reused.
//! 5. [`Arrangement::layout`] assembles the segments.
//!
//! A loop has at least six iterations and saves at least 32 operations. All loops together must save a third
//! of the operations; otherwise the code has none.

mod memory;
mod periodic_run;
mod repetition;
#[cfg(test)]
mod tests;

use robot_dynamics_expression::{Graph, Operand, Operation, Plan, as_traced, most_live};

use self::memory::{ProgramMemory, StridedRow};
use self::repetition::{LoopPosition, Repetition, Sequence};
use crate::affine_index::AffineIndex;
use crate::layout::{CarriedVariable, Layout, Loop, LoopOperand, LoopStep, MAX_STEPS, Region, ResultStore};

/// Layout with loops where these make the text shorter by a third or more, else straight code. `place`
/// returns the place in a result at which a number is stored, if it is.
pub(crate) fn shortest_layout(
    graph: &Graph,
    plan: &Plan,
    results: &[Vec<Operand>],
    place: &dyn Fn(usize, usize) -> Option<usize>,
) -> Layout {
    let straight = Layout::straight(graph, plan);
    match reroll(graph, results, place) {
        Some(layout) if 3 * layout.lines() <= 2 * straight.lines() => layout,
        _ => straight,
    }
}

/// The layout with loops, or `None` if these would save less than a third of the operations.
fn reroll(
    graph: &Graph,
    results: &[Vec<Operand>],
    place: &dyn Fn(usize, usize) -> Option<usize>,
) -> Option<Layout> {
    let sequence = Sequence::new(graph, as_traced(graph, results), results, place);
    let repetitions = sequence.repetitions();
    let saved = saved_operations(&repetitions);
    (saved > 0 && 3 * saved >= sequence.order.len())
        .then(|| Arrangement::new(&sequence, repetitions).layout())
}

/// Operations that need not be written because of loops.
fn saved_operations(repetitions: &[Repetition]) -> usize {
    repetitions.iter().map(|repetition| repetition.period * (repetition.iterations - 1)).sum()
}

/// A range of the order that is written as one region: straight code, or all iterations of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Segment {
    start: usize,
    end: usize,
    /// The number of the loop.
    repetition: Option<usize>,
    /// The part of the function.
    part: usize,
}

/// The source of an operand of a loop, before array places are assigned.
enum OperandSource {
    Known(LoopOperand),
    /// A loop-carried variable: the operation whose value the first iteration reads, and the operation of the
    /// first iteration whose value the next one reads.
    Carried(usize, usize),
    /// For each iteration, an operation outside the loop.
    Row(Vec<usize>),
}

/// The operands of a loop: by operation and operand, and the array rows of all operands in that order.
struct LoopOperands {
    sources: Vec<Vec<OperandSource>>,
    rows: Vec<Option<StridedRow>>,
}

/// The trace, divided into segments.
struct Arrangement<'a> {
    sequence: &'a Sequence<'a>,
    repetitions: Vec<Repetition>,
    segments: Vec<Segment>,
    /// By operation: its segment.
    segment_of: Vec<usize>,
    /// By operation: its position in a loop.
    loop_positions: Vec<Option<LoopPosition>>,
}

impl<'a> Arrangement<'a> {
    fn new(sequence: &'a Sequence<'a>, repetitions: Vec<Repetition>) -> Self {
        let nodes = sequence.graph.nodes.len();
        let (mut segment_of, mut loop_positions) = (vec![usize::MAX; nodes], vec![None; nodes]);
        let segments = divide(sequence, &repetitions);
        for (number, segment) in segments.iter().enumerate() {
            for at in segment.start..segment.end {
                segment_of[sequence.order[at]] = number;
            }
        }
        for (number, repetition) in repetitions.iter().enumerate() {
            let Repetition { start, period, .. } = *repetition;
            for at in start..repetition.end() {
                let (iteration, offset) = ((at - start) / period, (at - start) % period);
                loop_positions[sequence.order[at]] = Some(LoopPosition { number, offset, iteration });
            }
        }
        Self { sequence, repetitions, segments, segment_of, loop_positions }
    }

    fn layout(&self) -> Layout {
        let memory = &mut ProgramMemory::new(
            &self.sequence.order,
            &self.repetitions,
            &self.loop_positions,
            &self.segment_of,
        );
        let (operands, outside) = self.collect_operands(memory);
        memory.store_values(&outside, &|segment| self.segments[segment].part);
        let length = memory.allocate();
        let parts = self.parts(operands, memory);
        let array_length = if parts.len() > 1 { length.max(1) } else { length };
        let part_of =
            |&segment: &usize| self.segments.get(segment).map_or(usize::MAX, |segment| segment.part);
        Layout {
            parts,
            stored_at: (0..self.loop_positions.len()).map(|node| memory.place(node)).collect(),
            part_of: self.segment_of.iter().map(part_of).collect(),
            step_of: self.sequence.position.iter().map(|at| at.unwrap_or(usize::MAX)).collect(),
            in_loop: self.loop_positions.iter().map(Option::is_some).collect(),
            array_length,
            live: most_live(self.sequence.graph, &self.sequence.order),
        }
    }

    /// The operands of each loop, with their array rows. The second result lists all values that a segment
    /// reads from outside its loop, as pairs of segment and operation.
    fn collect_operands(&self, memory: &mut ProgramMemory<'_>) -> (Vec<LoopOperands>, Vec<(usize, usize)>) {
        let (mut operands, mut outside) = (Vec::new(), Vec::new());
        for (number, segment) in self.segments.iter().enumerate() {
            let Some(repetition) = segment.repetition else {
                let reads = (segment.start..segment.end).flat_map(|at| self.sequence.operation(at).reads());
                outside.extend(reads.map(|node| (number, node)));
                continue;
            };
            let sources = self.sources(&self.repetitions[repetition]);
            let mut rows = Vec::new();
            for source in sources.iter().flatten() {
                let row = match source {
                    OperandSource::Row(nodes) => Some(memory.row(nodes, number, &mut outside)),
                    OperandSource::Known(LoopOperand::Invariant(Operand::Plus(node))) => {
                        outside.push((number, *node as usize));
                        None
                    }
                    OperandSource::Carried(first, _) => {
                        outside.push((number, *first));
                        None
                    }
                    OperandSource::Known(_) => None,
                };
                rows.push(row);
            }
            operands.push(LoopOperands { sources, rows });
        }
        outside.retain(|&(_, node)| !self.sequence.graph.nodes[node].is_input());
        (operands, outside)
    }

    /// The regions of each part.
    fn parts(&self, operands: Vec<LoopOperands>, memory: &ProgramMemory<'_>) -> Vec<Vec<Region>> {
        let (mut operands, mut carried) = (operands.into_iter(), 0);
        let mut parts: Vec<Vec<Region>> = Vec::new();
        for segment in &self.segments {
            parts.resize_with(segment.part + 1, Vec::new);
            let region = match segment.repetition {
                None => Region::Straight(self.sequence.order[segment.start..segment.end].to_vec()),
                Some(repetition) => {
                    let operands = operands.next().expect("each loop has its operands");
                    Region::Loop(self.build_loop(repetition, &operands, memory, &mut carried))
                }
            };
            parts[segment.part].push(region);
        }
        parts
    }

    /// For each operation of a loop, the sources of its operands.
    fn sources(&self, repetition: &Repetition) -> Vec<Vec<OperandSource>> {
        let Repetition { start, period, iterations } = *repetition;
        let of = |offset: usize| {
            let first = self.sequence.operation(start + offset);
            let read = move |iteration: usize, number: usize| {
                let operation = self.sequence.operation(start + iteration * period + offset);
                operation.operands().nth(number).expect("as many operands as in the first").unsigned()
            };
            let source = move |number| {
                let all: Vec<Operand> = (0..iterations).map(|iteration| read(iteration, number)).collect();
                self.classify(repetition, &all)
            };
            (0..first.operands().count()).map(source).collect()
        };
        (0..period).map(of).collect()
    }

    /// The source of an operand, from what it is in each iteration, without signs.
    fn classify(&self, repetition: &Repetition, all: &[Operand]) -> OperandSource {
        if all.iter().all(|operand| *operand == all[0]) {
            return OperandSource::Known(LoopOperand::Invariant(all[0]));
        }
        if let Operand::Constant(_) = all[0] {
            let bits = |operand: &Operand| match operand {
                Operand::Constant(bits) => *bits,
                Operand::Plus(_) | Operand::Minus(_) => unreachable!("all are constants"),
            };
            return OperandSource::Known(LoopOperand::ConstantTable(all.iter().map(bits).collect()));
        }
        let node = |operand: &Operand| operand.node().expect("all are values");
        if let Operation::Input { argument, .. } = self.sequence.graph.nodes[node(&all[0])] {
            let index = |operand: &Operand| match self.sequence.graph.nodes[node(operand)] {
                Operation::Input { index, .. } => index as usize,
                _ => unreachable!("all are inputs"),
            };
            let index = AffineIndex::through(all.iter().map(index)).expect("strides were checked");
            return OperandSource::Known(LoopOperand::Input { argument: argument as usize, index });
        }
        let second = self.sequence.source(all[1]).expect("all are values");
        match second.checked_sub(repetition.start) {
            None => OperandSource::Row(all.iter().map(node).collect()),
            Some(offset) if offset >= repetition.period => {
                OperandSource::Known(LoopOperand::SameIteration(node(&all[0])))
            }
            Some(offset) => {
                OperandSource::Carried(node(&all[0]), self.sequence.order[repetition.start + offset])
            }
        }
    }

    /// Builds a loop; `count` is the number of carried variables so far.
    fn build_loop(
        &self,
        number: usize,
        operands: &LoopOperands,
        memory: &ProgramMemory<'_>,
        count: &mut usize,
    ) -> Loop {
        let repetition = &self.repetitions[number];
        let mut carried: Vec<CarriedVariable> = Vec::new();
        let mut rows = operands.rows.iter();
        let mut steps = Vec::new();
        for (offset, sources) in operands.sources.iter().enumerate() {
            let mut read = |source: &OperandSource| {
                let row = rows.next().expect("one for each source");
                match source {
                    OperandSource::Known(operand) => operand.clone(),
                    OperandSource::Row(_) => {
                        LoopOperand::Array(memory.index(row.as_ref().expect("the operand has a row")))
                    }
                    &OperandSource::Carried(first, next) => {
                        LoopOperand::Carried(carried_variable(&mut carried, (first, next), count))
                    }
                }
            };
            let reads = sources.iter().map(&mut read).collect();
            let node = self.sequence.order[repetition.start + offset];
            let stores = self.result_stores(repetition, offset);
            steps.push(LoopStep { node, reads, stored_at: memory.stored_at(number, offset), stores });
        }
        let copies = memory.copies(self.segment_of[steps[0].node]);
        Loop { iterations: repetition.iterations, copies, carried, steps }
    }

    /// The results that an operation of a loop is stored in, with an index for all iterations.
    fn result_stores(&self, repetition: &Repetition, offset: usize) -> Vec<ResultStore> {
        let at = repetition.start + offset;
        let store = |store: usize| {
            let of = |iteration: usize| self.sequence.stores[at + iteration * repetition.period][store];
            let index = AffineIndex::through((0..repetition.iterations).map(|k| of(k).index.first));
            ResultStore { index: index.expect("strides were checked"), ..of(0) }
        };
        (0..self.sequence.stores[at].len()).map(store).collect()
    }
}

/// The place in the list of the carried variable with these operations, which is added if it is new.
fn carried_variable(
    carried: &mut Vec<CarriedVariable>,
    (first, next): (usize, usize),
    count: &mut usize,
) -> usize {
    let existing = carried.iter().position(|variable| (variable.first, variable.next) == (first, next));
    existing.unwrap_or_else(|| {
        carried.push(CarriedVariable { number: *count, first, next });
        *count += 1;
        carried.len() - 1
    })
}

/// Divides the order into segments, in parts of about equal length, none with many more operations than a
/// function may have. A pair of sine and cosine stays with its halves.
fn divide(sequence: &Sequence<'_>, repetitions: &[Repetition]) -> Vec<Segment> {
    let written = sequence.order.len() - saved_operations(repetitions);
    let length = written.div_ceil(written.div_ceil(MAX_STEPS).max(1));
    let mut segments: Vec<Segment> = Vec::new();
    let (mut at, mut part, mut filled) = (0, 0, 0);
    let mut coming = repetitions.iter().enumerate().peekable();
    while at < sequence.order.len() {
        let next = coming.next_if(|(_, repetition)| repetition.start == at);
        let is_long = next.is_some_and(|(_, repetition)| filled + repetition.period > MAX_STEPS);
        if filled > 0 && (filled >= length || is_long) && !sequence.operation(at).is_half() {
            (part, filled) = (part + 1, 0);
        }
        if let Some((number, repetition)) = next {
            segments.push(Segment { start: at, end: repetition.end(), repetition: Some(number), part });
            (at, filled) = (repetition.end(), filled + repetition.period);
            continue;
        }
        let end = coming.peek().map_or(sequence.order.len(), |(_, repetition)| repetition.start);
        let mut until = end.min(at + (length - filled.min(length)).max(1));
        while until < end && sequence.operation(until).is_half() {
            until += 1;
        }
        segments.push(Segment { start: at, end: until, repetition: None, part });
        (at, filled) = (until, filled + until - at);
    }
    segments
}
