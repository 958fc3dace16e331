//! Loops for bodies that are alike: operations that repeat from body to body, written once.
//!
//! The recursions go from body to body. Where some bodies are alike, one after the other, their operations are the same but for
//! which numbers they read: those of the body before, numbers of the arguments, constants, values that an earlier recursion found
//! for the same body. If each of these moves evenly from body to body the operations become those of a loop: the same ones, and each
//! after what it reads, so that no bit changes. What one loop, or the code between loops, leaves for another lies in one array, in
//! the order in which it is read.

mod memory;
mod repeats;
#[cfg(test)]
mod tests;

use expression::{Graph, Operand, Operation, as_traced, most_live};

use crate::layout::{Carried, Index, Layout, Loop, MOST_STEPS, Piece, Read, Step, Store};

use self::memory::{Memory, Row};
use self::repeats::{Repeat, Sequence};

/// The operations in loops, as far as they go; none where these would save less than a third of the operations.
pub(crate) fn in_loops(
    graph: &Graph,
    results: &[Vec<Operand>],
    place: &dyn Fn(usize, usize) -> Option<usize>,
) -> Option<Layout> {
    let sequence = Sequence::new(graph, as_traced(graph, results), results, place);
    let repeats = sequence.repeats();
    let saved: usize = repeats.iter().map(|repeat| repeat.period * (repeat.turns - 1)).sum();
    (saved > 0 && 3 * saved >= sequence.order.len()).then(|| Arrangement::new(&sequence, repeats).layout())
}

/// An operation in a loop.
#[derive(Clone, Copy)]
struct InLoop {
    number: usize,
    offset: usize,
    turn: usize,
}

/// Places in the order that are written together: of one turn after the other, if it is a loop.
struct Stretch {
    start: usize,
    end: usize,
    repeat: Option<usize>,
    part: usize,
}

/// Where an operation of a loop finds a number, before places are known.
enum Source {
    Known(Read),
    /// What the first turn finds, and what, of the first turn, the next finds.
    Carried(usize, usize),
    /// An operation's value for each turn.
    Row(Vec<usize>),
}

struct Arrangement<'a> {
    sequence: &'a Sequence<'a>,
    repeats: Vec<Repeat>,
    stretches: Vec<Stretch>,
    /// By operation: its stretch.
    stretch_of: Vec<usize>,
    /// By operation.
    in_loop: Vec<Option<InLoop>>,
}

impl<'a> Arrangement<'a> {
    fn new(sequence: &'a Sequence<'a>, repeats: Vec<Repeat>) -> Self {
        let nodes = sequence.graph.nodes.len();
        let (mut stretch_of, mut in_loop) = (vec![usize::MAX; nodes], vec![None; nodes]);
        let stretches = divided(sequence, &repeats);
        for (number, stretch) in stretches.iter().enumerate() {
            for at in stretch.start..stretch.end {
                stretch_of[sequence.order[at]] = number;
            }
        }
        for (number, repeat) in repeats.iter().enumerate() {
            for at in repeat.start..repeat.end() {
                let (turn, offset) =
                    ((at - repeat.start) / repeat.period, (at - repeat.start) % repeat.period);
                in_loop[sequence.order[at]] = Some(InLoop { number, offset, turn });
            }
        }
        Self { sequence, repeats, stretches, stretch_of, in_loop }
    }

    fn layout(&self) -> Layout {
        let memory = &mut Memory::new(&self.sequence.order, &self.repeats, &self.in_loop, &self.stretch_of);
        // What each loop reads, and where that lies.
        let (mut sources, mut outside) = (Vec::new(), Vec::new());
        for (number, stretch) in self.stretches.iter().enumerate() {
            let Some(repeat) = stretch.repeat else {
                let reads = (stretch.start..stretch.end).flat_map(|at| self.sequence.operation(at).reads());
                outside.extend(reads.map(|node| (number, node)));
                continue;
            };
            let of_loop = self.sources(&self.repeats[repeat]);
            let mut rows = Vec::new();
            for source in of_loop.iter().flatten() {
                rows.push(match source {
                    Source::Row(nodes) => Some(memory.row(nodes, number, &mut outside)),
                    Source::Known(Read::Same(Operand::Plus(node))) => {
                        outside.push((number, *node as usize));
                        None
                    }
                    Source::Carried(first, _) => {
                        outside.push((number, *first));
                        None
                    }
                    Source::Known(_) => None,
                });
            }
            sources.push((of_loop, rows));
        }
        outside.retain(|&(_, node)| !self.sequence.graph.nodes[node].is_input());
        memory.keep(&outside, &|stretch| self.stretches[stretch].part);
        let places = memory.allocate();
        let mut sources = sources.into_iter();
        let mut carried = 0;
        let mut parts: Vec<Vec<Piece>> = Vec::new();
        for stretch in &self.stretches {
            parts.resize_with(stretch.part + 1, Vec::new);
            let piece = match stretch.repeat {
                None => Piece::Straight(self.sequence.order[stretch.start..stretch.end].to_vec()),
                Some(repeat) => {
                    let (sources, rows) = sources.next().expect("those of each loop");
                    Piece::Loop(self.loop_of(repeat, &sources, &rows, memory, &mut carried))
                }
            };
            parts[stretch.part].push(piece);
        }
        let places = if parts.len() > 1 { places.max(1) } else { places };
        let part_of =
            |&stretch: &usize| self.stretches.get(stretch).map_or(usize::MAX, |stretch| stretch.part);
        Layout {
            parts,
            kept: (0..self.in_loop.len()).map(|node| memory.place(node)).collect(),
            part_of: self.stretch_of.iter().map(part_of).collect(),
            step_of: self.sequence.position.iter().map(|at| at.unwrap_or(usize::MAX)).collect(),
            in_loop: self.in_loop.iter().map(Option::is_some).collect(),
            places,
            live: most_live(self.sequence.graph, &self.sequence.order),
        }
    }

    /// For each operation of a loop, where it finds what it reads.
    fn sources(&self, repeat: &Repeat) -> Vec<Vec<Source>> {
        let Repeat { start, period, turns } = *repeat;
        let of = |offset: usize| {
            let first = self.sequence.operation(start + offset);
            let read = move |turn: usize, number: usize| {
                let operation = self.sequence.operation(start + turn * period + offset);
                operation.operands().nth(number).expect("as many as the first has").unsigned()
            };
            let source = move |number| {
                let all: Vec<Operand> = (0..turns).map(|turn| read(turn, number)).collect();
                self.source(repeat, &all)
            };
            (0..first.operands().count()).map(source).collect()
        };
        (0..period).map(of).collect()
    }

    /// Of what is read in each turn, without signs.
    fn source(&self, repeat: &Repeat, all: &[Operand]) -> Source {
        if all.iter().all(|operand| *operand == all[0]) {
            return Source::Known(Read::Same(all[0]));
        }
        let node = |operand: &Operand| operand.node().expect("all are values");
        let input = |operand: &Operand| match self.sequence.graph.nodes[node(operand)] {
            Operation::Input { argument, index } => Some((argument as usize, index as usize)),
            _ => None,
        };
        match all[0] {
            Operand::Constant(_) => {
                let bits = |operand: &Operand| match operand {
                    Operand::Constant(bits) => *bits,
                    Operand::Plus(_) | Operand::Minus(_) => unreachable!("all are constants"),
                };
                Source::Known(Read::Constants(all.iter().map(bits).collect()))
            }
            _ if input(&all[0]).is_some() => {
                let of = |operand| input(operand).expect("all are inputs");
                let index = Index::through(all.iter().map(|operand| of(operand).1));
                let index = index.expect("what moves evenly was looked for");
                Source::Known(Read::Input { argument: of(&all[0]).0, index })
            }
            _ => {
                let at = |operand: &Operand| self.sequence.source(*operand).expect("a value");
                match at(&all[1]).checked_sub(repeat.start) {
                    None => Source::Row(all.iter().map(node).collect()),
                    Some(offset) if offset >= repeat.period => Source::Known(Read::Here(node(&all[0]))),
                    Some(offset) => {
                        Source::Carried(node(&all[0]), self.sequence.order[repeat.start + offset])
                    }
                }
            }
        }
    }

    fn loop_of(
        &self,
        number: usize,
        sources: &[Vec<Source>],
        rows: &[Option<Row>],
        memory: &Memory<'_>,
        count: &mut usize,
    ) -> Loop {
        let repeat = &self.repeats[number];
        let mut carried: Vec<Carried> = Vec::new();
        let mut rows = rows.iter();
        let mut steps = Vec::new();
        for (offset, sources) in sources.iter().enumerate() {
            let mut read = |source: &Source| {
                let row = rows.next().expect("one for each source");
                match source {
                    Source::Known(read) => read.clone(),
                    Source::Row(_) => Read::Kept(memory.index(row.as_ref().expect("it has a row"))),
                    &Source::Carried(first, next) => {
                        let same = |one: &Carried| (one.first, one.next) == (first, next);
                        let there = carried.iter().position(same);
                        Read::Carried(there.unwrap_or_else(|| {
                            carried.push(Carried { number: *count, first, next });
                            *count += 1;
                            carried.len() - 1
                        }))
                    }
                }
            };
            let reads = sources.iter().map(&mut read).collect();
            let at = repeat.start + offset;
            let stores = (0..self.sequence.stores[at].len()).map(|store| {
                let of_turn = |turn: usize| self.sequence.stores[at + turn * repeat.period][store];
                let index = Index::through((0..repeat.turns).map(|turn| of_turn(turn).index.first));
                Store { index: index.expect("what moves evenly was looked for"), ..of_turn(0) }
            });
            let node = self.sequence.order[at];
            steps.push(Step { node, reads, kept: memory.kept(number, offset), stores: stores.collect() });
        }
        Loop { turns: repeat.turns, copies: memory.copies(self.stretch_of[steps[0].node]), carried, steps }
    }
}

/// Stretches in parts of about equal length, none of many more operations than a function may have.
fn divided(sequence: &Sequence<'_>, repeats: &[Repeat]) -> Vec<Stretch> {
    let saved: usize = repeats.iter().map(|repeat| repeat.period * (repeat.turns - 1)).sum();
    let written = sequence.order.len() - saved;
    let length = written.div_ceil(written.div_ceil(MOST_STEPS).max(1));
    let mut stretches: Vec<Stretch> = Vec::new();
    let (mut at, mut part, mut filled) = (0, 0, 0);
    let mut coming = repeats.iter().enumerate().peekable();
    while at < sequence.order.len() {
        let next = coming.next_if(|(_, repeat)| repeat.start == at);
        let is_long = next.is_some_and(|(_, repeat)| filled + repeat.period > MOST_STEPS);
        if filled > 0 && (filled >= length || is_long) && !sequence.operation(at).is_half() {
            (part, filled) = (part + 1, 0);
        }
        if let Some((number, repeat)) = next {
            stretches.push(Stretch { start: at, end: repeat.end(), repeat: Some(number), part });
            (at, filled) = (repeat.end(), filled + repeat.period);
            continue;
        }
        let end = coming.peek().map_or(sequence.order.len(), |(_, repeat)| repeat.start);
        let mut until = end.min(at + (length - filled.min(length)).max(1));
        while until < end && sequence.operation(until).is_half() {
            until += 1;
        }
        stretches.push(Stretch { start: at, end: until, repeat: None, part });
        (at, filled) = (until, filled + until - at);
    }
    stretches
}
