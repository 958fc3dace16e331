//! Where operations repeat with a fixed period.
//!
//! Each operation gets a symbol for what can be written once for many: its kind, and of what it reads the kind and the sign. A stretch of the order in
//! which each symbol is that of `period` operations before can become a loop, if what its operations read moves evenly from turn to turn, too.

use std::collections::hash_map::Entry;
use std::collections::{BinaryHeap, HashMap};

use expression::{Graph, Operand, Operation};

use crate::layout::{Index, Store, difference};

/// Turns of a loop at least: robots with four legs or five fingers are left as they are.
const LEAST_TURNS: usize = functions::LEAST_EQUAL_LINKS;

/// Operations that a loop must save.
const LEAST_SAVED: usize = 32;

/// How often the symbols of a stretch that starts a search are doubled: it has 2⁴.
const DOUBLINGS: usize = 4;

/// Earlier places of the same stretch that are looked at.
const PLACES: usize = 4;

/// Operations in order, and what is known of each.
pub(crate) struct Sequence<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) order: Vec<usize>,
    /// By operation: where it is in the order.
    pub(crate) position: Vec<Option<usize>>,
    /// By place in the order: the results its value is stored in.
    pub(crate) stores: Vec<Vec<Store>>,
}

/// A stretch of turns, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Repeat {
    pub(crate) start: usize,
    pub(crate) period: usize,
    pub(crate) turns: usize,
}

impl Repeat {
    pub(crate) fn end(&self) -> usize {
        self.start + self.period * self.turns
    }
}

/// Places `start..end` with a period; ordered by what a loop can save.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Run {
    saved: usize,
    /// Of equal ones the earlier first.
    start: core::cmp::Reverse<usize>,
    end: usize,
    period: usize,
}

impl Run {
    /// If it is long enough.
    fn new(start: usize, end: usize, period: usize) -> Option<Self> {
        let length = end.saturating_sub(start);
        let saved = length.saturating_sub(period);
        let is_long = length >= LEAST_TURNS * period && saved >= LEAST_SAVED;
        is_long.then_some(Self { saved, start: core::cmp::Reverse(start), end, period })
    }
}

/// What an operand is, in a symbol.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
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
                    stores[at].push(Store { result, is_minus, index: Index::at(place) });
                }
            }
        }
        Self { graph, order, position, stores }
    }

    pub(crate) fn operation(&self, at: usize) -> &'a Operation {
        &self.graph.nodes[self.order[at]]
    }

    /// Where the operation is that an operand is the value of.
    pub(crate) fn source(&self, operand: Operand) -> Option<usize> {
        operand.node().and_then(|node| self.position[node])
    }

    /// Loops that save most, none over another, in order.
    pub(crate) fn repeats(&self) -> Vec<Repeat> {
        let symbols = self.symbols();
        let mut runs = self.runs(&symbols);
        if 3 * covered(&runs, symbols.len()) < symbols.len() {
            return Vec::new(); // as most robots: what follows would be in vain
        }
        let mut taken = vec![false; self.order.len()];
        let mut repeats = Vec::new();
        while let Some(run) = runs.pop() {
            let (start, end) = (run.start.0, run.end);
            if let Some(first) = (start..end).find(|&at| taken[at]) {
                // What is left on both sides.
                let last = (start..end).rfind(|&at| taken[at]).expect("there is the first");
                let free = (first..last).filter(|&at| taken[at] && !taken[at + 1]).map(|at| {
                    let next = (at + 1..=last).find(|&at| taken[at]).expect("there is the last");
                    (at + 1, next)
                });
                let pieces = [(start, first), (last + 1, end)].into_iter().chain(free);
                runs.extend(pieces.filter_map(|(start, end)| Run::new(start, end, run.period)));
                continue;
            }
            if let Some(repeat) = self.best_in(&run) {
                taken[repeat.start..repeat.end()].fill(true);
                runs.extend(Run::new(start, repeat.start, run.period));
                runs.extend(Run::new(repeat.end(), end, run.period));
                repeats.push(repeat);
            }
        }
        repeats.sort_by_key(|repeat| repeat.start);
        repeats
    }

    /// A number for each operation, the same for operations that can be one of a loop.
    fn symbols(&self) -> Vec<u32> {
        let kind = |operand: Operand| match operand {
            Operand::Constant(_) => Kind::Constant,
            Operand::Plus(node) | Operand::Minus(node) => {
                let is_minus = matches!(operand, Operand::Minus(_));
                match self.graph.nodes[node as usize] {
                    Operation::Input { argument, .. } => Kind::Input { argument, is_minus },
                    _ => Kind::Value { is_minus },
                }
            }
        };
        named((0..self.order.len()).map(|at| {
            let operation = self.operation(at);
            let kinds = of_three(operation.operands().map(kind));
            let stores: Vec<_> = self.stores[at].iter().map(|store| (store.result, store.is_minus)).collect();
            (core::mem::discriminant(operation), kinds, stores)
        }))
    }

    /// Stretches with a period, those first that save most.
    fn runs(&self, symbols: &[u32]) -> BinaryHeap<Run> {
        let count = symbols.len();
        let grams = self.grams(symbols);
        let mut last: HashMap<u64, usize> = HashMap::new();
        let mut earlier = vec![None; grams.len()];
        let mut seen_until: HashMap<usize, usize> = HashMap::new();
        let mut runs = BinaryHeap::new();
        for (at, &gram) in grams.iter().enumerate() {
            earlier[at] = last.insert(gram, at);
            let mut before = earlier[at];
            for _ in 0..PLACES {
                let Some(place) = before else { break };
                before = earlier[place];
                let period = at - place;
                if LEAST_TURNS * period > count || seen_until.get(&period).is_some_and(|&end| end > at) {
                    continue;
                }
                let mut start = place;
                while start > 0 && symbols[start - 1] == symbols[start - 1 + period] {
                    start -= 1;
                }
                let mut end = at;
                while end < count && symbols[end] == symbols[end - period] {
                    end += 1;
                }
                seen_until.insert(period, end);
                runs.extend(Run::new(start, end, period));
            }
        }
        runs
    }

    /// A name for what stands at each place and after it, with the distances of what is read from near by: equal names are likely turns
    /// of the same loop.
    fn grams(&self, symbols: &[u32]) -> Vec<u64> {
        const NEAR: usize = 64;
        // Any odd number that mixes bits well: two different stretches of one name only cost a look.
        const MIXED: u64 = 0x9e37_79b9_7f4a_7c15;
        let mixed = |x: u64, y: u64| (x.rotate_left(29) ^ y).wrapping_mul(MIXED);
        let of_one = |(at, &symbol): (usize, &u32)| {
            let distance = |operand| {
                let near =
                    self.source(operand).map(|source| at - source).filter(|&distance| distance <= NEAR);
                near.map_or(0, |distance| distance as u64)
            };
            self.operation(at).operands().map(distance).fold(u64::from(symbol), mixed)
        };
        let mut grams: Vec<u64> = symbols.iter().enumerate().map(of_one).collect();
        for doubling in 0..DOUBLINGS {
            let next = grams.iter().skip(1 << doubling);
            grams = grams.iter().zip(next).map(|(&one, &other)| mixed(one, other)).collect();
        }
        grams
    }

    /// The longest loop in a stretch, from where least is handed from turn to turn.
    fn best_in(&self, run: &Run) -> Option<Repeat> {
        let (start, period) = (run.start.0, run.period);
        let crossing = self.crossing(start, run.end, period);
        let worth = |shift: usize| {
            let covered = (run.end - start - shift) / period * period;
            covered.cast_signed() - 2 * crossing[shift].cast_signed()
        };
        // The halves of a pair stay with it.
        let shifts = (0..period).filter(|&shift| !self.operation(start + shift).is_half());
        let shift = shifts.max_by_key(|&shift| (worth(shift), core::cmp::Reverse(shift)))?;
        let turns = (run.end - start - shift) / period;
        // The first turns may read what is no value of the turn before.
        let mut best: Option<Repeat> = None;
        for first in 0..(turns + 1).saturating_sub(LEAST_TURNS).min(2 * LEAST_TURNS) {
            let start = start + shift + first * period;
            if best.is_some_and(|best| best.turns >= turns - first) {
                break;
            }
            let found = self.even_turns(&Repeat { start, period, turns: turns - first });
            if best.is_none_or(|best| best.turns < found) {
                best = Some(Repeat { start, period, turns: found });
            }
        }
        best.filter(|best| best.turns >= LEAST_TURNS && (best.turns - 1) * period >= LEAST_SAVED)
    }

    /// For each place where turns may begin: values that are computed before it and read after it, in the turns after one another. A value that
    /// would be read two turns later counts as much as the whole stretch.
    fn crossing(&self, start: usize, end: usize, period: usize) -> Vec<usize> {
        let first = start + period;
        let sources = |at: usize| self.operation(at).operands().map(|operand| self.source(operand));
        let mut reach = vec![0; period];
        for at in first..(first + 3 * period).min(end - period) {
            for (source, next) in sources(at).zip(sources(at + period)) {
                let Some(source) = source else { continue };
                let moves = next == Some(source + period);
                if moves && (first..first + period).contains(&source) {
                    let reach: &mut usize = &mut reach[source - first];
                    *reach = (*reach).max(at - source);
                }
            }
        }
        let mut crossing = vec![0; period];
        for (offset, &reach) in reach.iter().enumerate() {
            for distance in 1..=reach.min(period) {
                let is_far = distance + period <= reach;
                crossing[(offset + distance) % period] += if is_far { end - start } else { 1 };
            }
        }
        crossing
    }

    /// How many turns, from the first, read what moves evenly and store evenly.
    fn even_turns(&self, repeat: &Repeat) -> usize {
        let Repeat { start, period, mut turns } = *repeat;
        for offset in 0..period {
            let of_turn = |turn: usize| self.operation(start + turn * period + offset);
            let is_half = of_turn(0).is_half();
            for number in 0..of_turn(0).operands().count() {
                let read =
                    |turn: usize| of_turn(turn).operands().nth(number).expect("as many as the first has");
                turns = self.even_reads(&Repeat { start, period, turns }, &read, is_half);
                if turns < LEAST_TURNS {
                    return 0;
                }
            }
            let stores = |turn: usize| &self.stores[start + turn * period + offset];
            for number in 0..stores(0).len() {
                let index = |turn: usize| stores(turn)[number].index.first;
                turns = even(turns, &index);
            }
        }
        turns
    }

    /// How many turns, from the first, read numbers that move evenly, of one operand.
    fn even_reads(&self, repeat: &Repeat, read: &dyn Fn(usize) -> Operand, is_half: bool) -> usize {
        let Repeat { start, period, turns } = *repeat;
        let input = |turn: usize| match read(turn).node().map(|node| &self.graph.nodes[node]) {
            Some(Operation::Input { index, .. }) => Some(*index as usize),
            _ => None,
        };
        if read(0).known().is_some() {
            return turns;
        }
        if input(0).is_some() {
            return even(turns, &|turn| input(turn).expect("the kind of the first"));
        }
        let source = |turn: usize| self.source(read(turn)).expect("a value that is computed");
        let second = source(1);
        let follows = |turn: usize| source(turn) + period == second + turn * period;
        let count = |holds: &dyn Fn(usize) -> bool| (0..turns).take_while(|&turn| holds(turn)).count();
        if second >= start + period {
            // Of the same turn.
            count(&follows)
        } else if is_half {
            0
        } else if second >= start {
            // Of the turn before.
            count(&|turn| if turn == 0 { source(0) < start } else { follows(turn) })
        } else {
            count(&|turn| source(turn) < start)
        }
    }
}

/// Places that are in some run.
fn covered(runs: &BinaryHeap<Run>, count: usize) -> usize {
    let mut changes = vec![0_isize; count + 1];
    for run in runs {
        changes[run.start.0] += 1;
        changes[run.end] -= 1;
    }
    let runs_at = changes.iter().scan(0, |runs, change| {
        *runs += change;
        Some(*runs)
    });
    runs_at.filter(|&runs| runs > 0).count()
}

/// Something of each operand: there are three at most.
fn of_three<T: Copy>(each: impl Iterator<Item = T>) -> [Option<T>; 3] {
    let mut three = [None; 3];
    three.iter_mut().zip(each).for_each(|(place, one)| *place = Some(one));
    three
}

/// How many indices, from the first, are evenly spaced.
fn even(turns: usize, index: &dyn Fn(usize) -> usize) -> usize {
    let step = |turn: usize| difference(index(turn), index(turn - 1));
    let first = step(1);
    1 + (1..turns).take_while(|&turn| step(turn) == first).count()
}

/// Equal numbers for equal things, in the order of their first places.
fn named<T: Eq + core::hash::Hash>(things: impl Iterator<Item = T>) -> Vec<u32> {
    let mut names = HashMap::new();
    let mut next = 0;
    let name = |thing| match names.entry(thing) {
        Entry::Occupied(there) => *there.get(),
        Entry::Vacant(free) => {
            next += 1;
            *free.insert(next)
        }
    };
    things.map(name).collect()
}
