//! The search for operations that repeat with a fixed period.
//!
//! 1. Each operation gets a symbol: its kind, the kinds and signs of its operands, and the results that it is
//!    stored in. Equal symbols can become one statement of a loop.
//! 2. The hash of 16 successive symbols and of the distances of near operands starts a search where it occurs
//!    again. The distance of the two places is a candidate period. The run is extended in both directions as
//!    long as the symbols repeat.
//! 3. The runs are taken from a heap, those first that save most operations. Operations that an earlier run
//!    covers are cut out.
//! 4. In a run, the phase is chosen at which the fewest values are live across the boundary of iterations.
//!    The longest stretch of iterations whose operands all have constant strides becomes a loop.

use std::collections::hash_map::Entry;
use std::collections::{BinaryHeap, HashMap};

use robot_dynamics_expression::{Graph, Operand, Operation};

use super::periodic_run::{LEAST_ITERATIONS, LEAST_SAVED, PeriodicRun, covered, extend};
use crate::affine_index::{AffineIndex, difference};
use crate::layout::ResultStore;

/// The position of an operation in a loop: the number of the loop, the place in its body, and the iteration.
#[derive(Clone, Copy)]
pub(super) struct LoopPosition {
    pub(super) number: usize,
    pub(super) offset: usize,
    pub(super) iteration: usize,
}

/// Doublings of the hashed stretch of symbols: it has 2⁴ symbols.
const DOUBLINGS: usize = 4;

/// Earlier occurrences of a hash that are tried.
const OCCURRENCES: usize = 4;

/// Operations in order, with their positions and stores.
pub(crate) struct Sequence<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) order: Vec<usize>,
    /// By operation: its position in the order.
    pub(crate) position: Vec<Option<usize>>,
    /// By position: the results that the value is stored in.
    pub(crate) stores: Vec<Vec<ResultStore>>,
}

/// Successive iterations: positions `start..start + period * iterations`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Repetition {
    pub(crate) start: usize,
    pub(crate) period: usize,
    pub(crate) iterations: usize,
}

impl Repetition {
    pub(crate) fn end(&self) -> usize {
        self.start + self.period * self.iterations
    }
}

/// The kind of an operand in a symbol.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum OperandKind {
    Constant,
    Input { argument: u32, is_minus: bool },
    Value { is_minus: bool },
}

impl<'a> Sequence<'a> {
    pub(crate) fn new(
        graph: &'a Graph,
        order: Vec<usize>,
        results: &[Vec<Operand>],
        place: &dyn Fn(usize, usize) -> Option<usize>,
    ) -> Self {
        let mut position = vec![None; graph.nodes.len()];
        order.iter().enumerate().for_each(|(at, &node)| position[node] = Some(at));
        let mut stores = vec![Vec::new(); order.len()];
        for (result, entries) in results.iter().enumerate() {
            for (index, &operand) in entries.iter().enumerate() {
                if let (Some(at), Some(place)) =
                    (operand.node().and_then(|node| position[node]), place(result, index))
                {
                    let is_minus = matches!(operand, Operand::Minus(_));
                    stores[at].push(ResultStore { result, is_minus, index: AffineIndex::at(place) });
                }
            }
        }
        Self { graph, order, position, stores }
    }

    pub(crate) fn operation(&self, at: usize) -> &'a Operation {
        &self.graph.nodes[self.order[at]]
    }

    /// The position of the operation whose value an operand is.
    pub(crate) fn source(&self, operand: Operand) -> Option<usize> {
        operand.node().and_then(|node| self.position[node])
    }

    /// Disjoint loops, in order, chosen greedily by the operations that they save.
    pub(crate) fn repetitions(&self) -> Vec<Repetition> {
        let symbols = self.symbols();
        let mut runs = self.runs(&symbols);
        if 3 * covered(&runs, symbols.len()) < symbols.len() {
            return Vec::new(); // the case of most robots: loops could not save enough
        }
        let mut taken = vec![false; self.order.len()];
        let mut repetitions = Vec::new();
        while let Some(run) = runs.pop() {
            let (start, end) = (run.start.0, run.end);
            if taken[start..end].contains(&true) {
                runs.extend(run.free_parts(&taken));
                continue;
            }
            if let Some(repetition) = self.best_repetition(&run) {
                taken[repetition.start..repetition.end()].fill(true);
                runs.extend(PeriodicRun::new(start, repetition.start, run.period));
                runs.extend(PeriodicRun::new(repetition.end(), end, run.period));
                repetitions.push(repetition);
            }
        }
        repetitions.sort_by_key(|repetition| repetition.start);
        repetitions
    }

    /// A symbol for each operation, equal for operations that one statement of a loop can represent.
    fn symbols(&self) -> Vec<u32> {
        let kind = |operand: Operand| match operand {
            Operand::Constant(_) => OperandKind::Constant,
            Operand::Plus(node) | Operand::Minus(node) => {
                let is_minus = matches!(operand, Operand::Minus(_));
                match self.graph.nodes[node as usize] {
                    Operation::Input { argument, .. } => OperandKind::Input { argument, is_minus },
                    _ => OperandKind::Value { is_minus },
                }
            }
        };
        intern((0..self.order.len()).map(|at| {
            let operation = self.operation(at);
            let kinds = up_to_three(operation.operands().map(kind));
            let stores: Vec<_> = self.stores[at].iter().map(|store| (store.result, store.is_minus)).collect();
            (core::mem::discriminant(operation), kinds, stores)
        }))
    }

    /// The runs, in a heap.
    fn runs(&self, symbols: &[u32]) -> BinaryHeap<PeriodicRun> {
        let hashes = self.hashes(symbols);
        let mut last: HashMap<u64, usize> = HashMap::new();
        let mut earlier = vec![None; hashes.len()];
        let mut extended_to: HashMap<usize, usize> = HashMap::new();
        let mut runs = BinaryHeap::new();
        for (at, &hash) in hashes.iter().enumerate() {
            earlier[at] = last.insert(hash, at);
            let mut before = earlier[at];
            for _ in 0..OCCURRENCES {
                let Some(place) = before else { break };
                before = earlier[place];
                let period = at - place;
                let is_known = extended_to.get(&period).is_some_and(|&end| end > at);
                if LEAST_ITERATIONS * period > symbols.len() || is_known {
                    continue;
                }
                let (start, end) = extend(symbols, place, at);
                extended_to.insert(period, end);
                runs.extend(PeriodicRun::new(start, end, period));
            }
        }
        runs
    }

    /// For each position, a hash of the symbols from there on and of the distances of near operands. Equal
    /// hashes are likely iterations of the same loop.
    fn hashes(&self, symbols: &[u32]) -> Vec<u64> {
        const NEAR: usize = 64;
        // Any odd number that mixes bits well: a collision only costs time.
        const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;
        let mix = |x: u64, y: u64| (x.rotate_left(29) ^ y).wrapping_mul(MULTIPLIER);
        let of_one = |(at, &symbol): (usize, &u32)| {
            let distance = |operand| {
                let near =
                    self.source(operand).map(|source| at - source).filter(|&distance| distance <= NEAR);
                near.map_or(0, |distance| distance as u64)
            };
            self.operation(at).operands().map(distance).fold(u64::from(symbol), mix)
        };
        let mut hashes: Vec<u64> = symbols.iter().enumerate().map(of_one).collect();
        for doubling in 0..DOUBLINGS {
            let next = hashes.iter().skip(1 << doubling);
            hashes = hashes.iter().zip(next).map(|(&one, &other)| mix(one, other)).collect();
        }
        hashes
    }

    /// The longest loop in a run, at the best phase.
    fn best_repetition(&self, run: &PeriodicRun) -> Option<Repetition> {
        let period = run.period;
        let start = run.start.0 + self.best_phase(run)?;
        let iterations = (run.end - start) / period;
        // The operands of the first iterations may have other strides.
        let mut best: Option<Repetition> = None;
        for first in 0..(iterations + 1).saturating_sub(LEAST_ITERATIONS).min(2 * LEAST_ITERATIONS) {
            let start = start + first * period;
            if best.is_some_and(|best| best.iterations >= iterations - first) {
                break;
            }
            let found =
                self.strided_iterations(&Repetition { start, period, iterations: iterations - first });
            if best.is_none_or(|best| best.iterations < found) {
                best = Some(Repetition { start, period, iterations: found });
            }
        }
        best.filter(|best| {
            best.iterations >= LEAST_ITERATIONS && (best.iterations - 1) * period >= LEAST_SAVED
        })
    }

    /// The offset at which iterations begin: the one that covers most operations, less two for each value
    /// that is live across the boundary. A pair of sine and cosine is not separated from its halves.
    fn best_phase(&self, run: &PeriodicRun) -> Option<usize> {
        let (start, period) = (run.start.0, run.period);
        let live = self.live_across(start, run.end, period);
        let worth = |phase: usize| {
            let covered = (run.end - start - phase) / period * period;
            covered.cast_signed() - 2 * live[phase].cast_signed()
        };
        let phases = (0..period).filter(|&phase| !self.operation(start + phase).is_half());
        phases.max_by_key(|&phase| (worth(phase), core::cmp::Reverse(phase)))
    }

    /// For each phase, the values that are live across a boundary between iterations there. They are computed
    /// before it and read after it by an operation of the next iteration. A value that would be read two
    /// iterations later counts as much as the whole run.
    fn live_across(&self, start: usize, end: usize, period: usize) -> Vec<usize> {
        let mut live = vec![0; period];
        for (offset, &range) in self.live_ranges(start, end, period).iter().enumerate() {
            for distance in 1..=range.min(period) {
                let is_far = distance + period <= range;
                live[(offset + distance) % period] += if is_far { end - start } else { 1 };
            }
        }
        live
    }

    /// For each operation of the second period, the distance to the last read of its value. Reads count whose
    /// operation reads the corresponding value one period later, too.
    fn live_ranges(&self, start: usize, end: usize, period: usize) -> Vec<usize> {
        let first = start + period;
        let sources = |at: usize| self.operation(at).operands().map(|operand| self.source(operand));
        let mut ranges = vec![0; period];
        for at in first..(first + 3 * period).min(end - period) {
            for (source, next) in sources(at).zip(sources(at + period)) {
                let Some(source) = source else { continue };
                let moves = next == Some(source + period);
                if moves && (first..first + period).contains(&source) {
                    let range: &mut usize = &mut ranges[source - first];
                    *range = (*range).max(at - source);
                }
            }
        }
        ranges
    }

    /// The number of iterations, from the first, whose operands and stores all have constant strides.
    fn strided_iterations(&self, repetition: &Repetition) -> usize {
        let Repetition { start, period, mut iterations } = *repetition;
        for offset in 0..period {
            let of = |iteration: usize| self.operation(start + iteration * period + offset);
            let is_half = of(0).is_half();
            for number in 0..of(0).operands().count() {
                let read = |iteration: usize| {
                    of(iteration).operands().nth(number).expect("as many operands as in the first")
                };
                iterations = self.strided_reads(&Repetition { start, period, iterations }, &read, is_half);
                if iterations < LEAST_ITERATIONS {
                    return 0;
                }
            }
            let stores = |iteration: usize| &self.stores[start + iteration * period + offset];
            for number in 0..stores(0).len() {
                let index = |iteration: usize| stores(iteration)[number].index.first;
                iterations = strided(iterations, &index);
            }
        }
        iterations
    }

    /// The number of iterations, from the first, in which one operand has a constant stride.
    fn strided_reads(
        &self,
        repetition: &Repetition,
        read: &dyn Fn(usize) -> Operand,
        is_half: bool,
    ) -> usize {
        let Repetition { start, period, iterations } = *repetition;
        let input = |iteration: usize| match read(iteration).node().map(|node| &self.graph.nodes[node]) {
            Some(Operation::Input { index, .. }) => Some(*index as usize),
            _ => None,
        };
        if read(0).known().is_some() {
            return iterations;
        }
        if input(0).is_some() {
            return strided(iterations, &|iteration| input(iteration).expect("the kind of the first"));
        }
        let source = |iteration: usize| self.source(read(iteration)).expect("a value that is computed");
        let second = source(1);
        let follows = |iteration: usize| source(iteration) + period == second + iteration * period;
        let count = |holds: &dyn Fn(usize) -> bool| (0..iterations).take_while(|&k| holds(k)).count();
        if second >= start + period {
            // A value of the same iteration.
            count(&follows)
        } else if is_half {
            0
        } else if second >= start {
            // A value of the iteration before.
            count(&|iteration| if iteration == 0 { source(0) < start } else { follows(iteration) })
        } else {
            count(&|iteration| source(iteration) < start)
        }
    }
}

/// The items of an iterator, three at most.
fn up_to_three<T: Copy>(items: impl Iterator<Item = T>) -> [Option<T>; 3] {
    let mut three = [None; 3];
    three.iter_mut().zip(items).for_each(|(place, item)| *place = Some(item));
    three
}

/// The number of indices, from the first, with a constant stride.
fn strided(iterations: usize, index: &dyn Fn(usize) -> usize) -> usize {
    let step = |iteration: usize| difference(index(iteration), index(iteration - 1));
    let first = step(1);
    1 + (1..iterations).take_while(|&iteration| step(iteration) == first).count()
}

/// Equal numbers for equal items, in the order of their first occurrences.
fn intern<T: Eq + core::hash::Hash>(items: impl Iterator<Item = T>) -> Vec<u32> {
    let mut numbers = HashMap::new();
    let mut next = 0;
    let number = |item| match numbers.entry(item) {
        Entry::Occupied(entry) => *entry.get(),
        Entry::Vacant(entry) => {
            next += 1;
            *entry.insert(next)
        }
    };
    items.map(number).collect()
}

#[cfg(test)]
mod tests {
    use robot_dynamics_expression::{Precision, as_traced};

    use super::*;

    #[test]
    fn strides_end_at_the_first_change() {
        let count = |indices: &[usize]| strided(indices.len(), &|k| indices[k]);
        assert_eq!(count(&[7, 5, 3, 1, 0]), 4);
        assert_eq!(count(&[2, 2, 2, 2]), 4);
        assert_eq!(count(&[0, 1, 3]), 2);
    }

    /// Each body adds its input to the sum before and squares it. The loop covers all bodies but the first,
    /// as that one reads no sum.
    #[test]
    fn a_recursion_is_one_repetition() {
        let mut graph = Graph::new(Precision::Double);
        let mut sum = graph.input(0, 0);
        let mut results = Vec::new();
        for body in 1..40 {
            let input = graph.input(0, body);
            sum = graph.sum(sum, input);
            let square = graph.product(sum, sum);
            results.push(square);
        }
        let results = vec![results];
        let place = |_: usize, index: usize| Some(index);
        let sequence = Sequence::new(&graph, as_traced(&graph, &results), &results, &place);
        let repetitions = sequence.repetitions();
        assert_eq!(repetitions.len(), 1);
        let Repetition { period, iterations, .. } = repetitions[0];
        assert!(period == 2 && iterations >= 37, "{repetitions:?}");
    }
}
