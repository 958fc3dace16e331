//! How a function is written: its operations one after the other or in loops, in how many parts, and what is kept in memory
//! between these.

use core::fmt;

use expression::{Graph, Operand, Plan};

use crate::loops;

/// Operations of one function at most: compilers take longer than in proportion for long ones.
pub(crate) const MOST_STEPS: usize = 2000;

/// A function's pieces, in parts.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// The pieces of each part, in order.
    pub(crate) parts: Vec<Vec<Piece>>,
    /// By operation: where its value is kept, if another part or a loop reads it there.
    pub(crate) kept: Vec<Option<usize>>,
    /// By operation: the part that does it.
    pub(crate) part_of: Vec<usize>,
    /// By operation: when it is done.
    pub(crate) step_of: Vec<usize>,
    /// By operation: whether it is done in a loop.
    pub(crate) in_loop: Vec<bool>,
    /// Places for kept values.
    pub(crate) places: usize,
    /// The most values that are computed and still to be read, at any time.
    pub(crate) live: usize,
}

/// Operations that are written together.
#[derive(Clone, Debug)]
pub(crate) enum Piece {
    /// One after the other.
    Straight(Vec<usize>),
    /// Once for all turns.
    Loop(Loop),
}

/// Operations that are done in each of some turns, on other numbers each time.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    pub(crate) turns: usize,
    /// Values that must lie side by side, copied before the first turn: to which place, which operation's.
    pub(crate) copies: Vec<(usize, usize)>,
    /// Values that each turn hands to the next.
    pub(crate) carried: Vec<Carried>,
    pub(crate) steps: Vec<Step>,
}

/// A variable that each turn hands to the next.
#[derive(Clone, Debug)]
pub(crate) struct Carried {
    /// Its number among all of the function.
    pub(crate) number: usize,
    /// The operation whose value the first turn finds in it.
    pub(crate) first: usize,
    /// The operation, of the first turn, whose value the next turn finds in it.
    pub(crate) next: usize,
}

/// An operation of a loop.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// The operation of the first turn: what is done, the signs of what it reads, and its name.
    pub(crate) node: usize,
    pub(crate) reads: Vec<Read>,
    /// Where each turn keeps its value.
    pub(crate) kept: Option<Index>,
    /// Results that its value is stored in.
    pub(crate) stores: Vec<Store>,
}

impl Step {
    /// Whether it reads or writes other numbers in each turn by the turn's number.
    pub(crate) fn reads_turn(&self) -> bool {
        let moves = |read: &Read| match read {
            Read::Constants(_) => true,
            Read::Input { index, .. } | Read::Kept(index) => index.step != 0,
            Read::Same(_) | Read::Here(_) | Read::Carried(_) => false,
        };
        let stored = self.stores.iter().map(|store| store.index).chain(self.kept);
        self.reads.iter().any(moves) || stored.into_iter().any(|index| index.step != 0)
    }
}

/// Where an operation of a loop finds a number that it reads, but for its sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Read {
    /// The same in each turn, from outside the loop.
    Same(Operand),
    /// A constant of each turn, by its bits.
    Constants(Vec<u64>),
    /// Numbers of an argument.
    Input { argument: usize, index: Index },
    /// The value of an operation of the same turn, by that of the first turn.
    Here(usize),
    /// A variable that the turn before left, by its place in the list.
    Carried(usize),
    /// A kept value.
    Kept(Index),
}

/// Where the number of a result is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Store {
    pub(crate) result: usize,
    pub(crate) is_minus: bool,
    pub(crate) index: Index,
}

/// An index that moves by the same step with each turn of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Index {
    pub(crate) first: usize,
    pub(crate) step: isize,
}

impl Index {
    /// One that stays.
    pub(crate) fn at(first: usize) -> Self {
        Self { first, step: 0 }
    }

    /// Through these, if it moves evenly.
    pub(crate) fn through(mut indices: impl Iterator<Item = usize>) -> Option<Self> {
        let first = indices.next()?;
        let mut before = first;
        let mut step = None;
        for index in indices {
            let here = difference(index, before);
            if *step.get_or_insert(here) != here {
                return None;
            }
            before = index;
        }
        Some(Self { first, step: step.unwrap_or(0) })
    }

    /// In a turn, from zero.
    #[cfg(test)]
    pub(crate) fn of_turn(self, turn: usize) -> usize {
        self.first.checked_add_signed(self.step * turn.cast_signed()).expect("an index is not negative")
    }
}

/// a − b.
pub(crate) fn difference(a: usize, b: usize) -> isize {
    a.cast_signed() - b.cast_signed()
}

/// Of the turn `k`.
impl fmt::Display for Index {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, step } = *self;
        match (first, step) {
            (_, 0) => write!(f, "{first}"),
            (0, 1) => f.write_str("k"),
            (0, _) => write!(f, "{step} * k"),
            (_, 1) => write!(f, "{first} + k"),
            (_, -1) => write!(f, "{first} - k"),
            _ if step < 0 => write!(f, "{first} - {} * k", step.unsigned_abs()),
            _ => write!(f, "{first} + {step} * k"),
        }
    }
}

impl Layout {
    /// In loops where these make the text shorter by a third or more, else one operation after the other. `place` says where a
    /// number of a result is stored, if it is.
    pub(crate) fn new(
        graph: &Graph,
        plan: &Plan,
        results: &[Vec<Operand>],
        place: &dyn Fn(usize, usize) -> Option<usize>,
    ) -> Self {
        let straight = Self::straight(graph, plan);
        match loops::in_loops(graph, results, place) {
            Some(layout) if 3 * layout.lines() <= 2 * straight.lines() => layout,
            _ => straight,
        }
    }

    /// One operation after the other, in parts of about equal length.
    pub(crate) fn straight(graph: &Graph, plan: &Plan) -> Self {
        let Plan { order, live } = plan;
        let count = order.len().div_ceil(MOST_STEPS).max(1);
        let length = order.len().div_ceil(count);
        let mut parts: Vec<Vec<usize>> = vec![Vec::new()];
        for &node in order {
            // A pair is nothing that can be kept: its halves stay with it.
            if parts.last().is_some_and(|part| part.len() >= length) && !graph.nodes[node].is_half() {
                parts.push(Vec::new());
            }
            parts.last_mut().expect("there is a first").push(node);
        }
        let mut part_of = vec![usize::MAX; graph.nodes.len()];
        let mut step_of = part_of.clone();
        order.iter().enumerate().for_each(|(step, &node)| step_of[node] = step);
        let mut last_read = vec![0; graph.nodes.len()];
        for (number, part) in parts.iter().enumerate() {
            for &node in part {
                part_of[node] = number;
                for read in graph.nodes[node].reads() {
                    last_read[read] = number;
                }
            }
        }
        let (kept, places) = keep(&parts, &last_read);
        // No array is empty.
        let places = if parts.len() > 1 { places.max(1) } else { 0 };
        let in_loop = vec![false; graph.nodes.len()];
        let parts = parts.into_iter().map(|part| vec![Piece::Straight(part)]).collect();
        Self { parts, kept, part_of, step_of, in_loop, places, live: *live }
    }

    /// The loops.
    pub(crate) fn loops(&self) -> impl Iterator<Item = &Loop> {
        self.parts.iter().flatten().filter_map(|piece| match piece {
            Piece::Straight(_) => None,
            Piece::Loop(repeated) => Some(repeated),
        })
    }

    pub(crate) fn has_loops(&self) -> bool {
        self.loops().next().is_some()
    }

    /// Operations that are written.
    pub(crate) fn written(&self) -> usize {
        let of = |piece: &Piece| match piece {
            Piece::Straight(nodes) => nodes.len(),
            Piece::Loop(repeated) => repeated.steps.len(),
        };
        self.parts.iter().flatten().map(of).sum()
    }

    /// Lines that are written: operations, values that are kept, copied and handed on, and the loops' own two.
    pub(crate) fn lines(&self) -> usize {
        let of = |piece: &Piece| match piece {
            Piece::Straight(nodes) => {
                nodes.len() + nodes.iter().filter(|&&node| self.kept[node].is_some()).count()
            }
            Piece::Loop(repeated) => {
                let kept = repeated.steps.iter().filter(|step| step.kept.is_some()).count();
                2 + repeated.copies.len() + 2 * repeated.carried.len() + repeated.steps.len() + kept
            }
        };
        self.parts.iter().flatten().map(of).sum()
    }
}

/// A place for each value that a later part reads, free again after the last of these.
fn keep(parts: &[Vec<usize>], last_read: &[usize]) -> (Vec<Option<usize>>, usize) {
    let (mut kept, mut places) = (vec![None; last_read.len()], 0);
    let mut free = Vec::new();
    let mut freed_after: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
    for (number, part) in parts.iter().enumerate() {
        for &node in part.iter().filter(|&&node| last_read[node] > number) {
            let place = free.pop().unwrap_or_else(|| {
                places += 1;
                places - 1
            });
            kept[node] = Some(place);
            freed_after[last_read[node]].push(place);
        }
        free.append(&mut freed_after[number]);
    }
    (kept, places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use expression::{Operation, Precision};

    #[test]
    fn indices_are_written_as_a_person_would() {
        let through = |indices: &[usize]| Index::through(indices.iter().copied());
        for (indices, text) in [
            (&[7, 7, 7][..], "7"),
            (&[0, 1, 2], "k"),
            (&[0, 3, 6], "3 * k"),
            (&[4, 5, 6], "4 + k"),
            (&[4, 3, 2], "4 - k"),
            (&[9, 11, 13], "9 + 2 * k"),
            (&[9, 7, 5], "9 - 2 * k"),
        ] {
            let index = through(indices).unwrap();
            assert_eq!(index.to_string(), text);
            assert!((0..3).all(|turn| index.of_turn(turn) == indices[turn]), "{text}");
        }
        assert_eq!(through(&[1, 2, 4]), None);
    }

    /// x², x³, … x⁹ summed from the last: as traced all powers wait; the order found reads each result as it needs it.
    #[test]
    fn an_order_holds_each_operation_once_and_after_what_it_reads() {
        let mut graph = Graph::new(Precision::Double);
        let x = graph.push(Operation::Input { argument: 0, index: 0 });
        let (sine, cosine) = graph.sine_cosine(x);
        let mut power = graph.product(sine, cosine);
        let mut powers = vec![power];
        for _ in 0..3 * MOST_STEPS {
            power = graph.product(power, sine);
            powers.push(power);
        }
        let result = powers.iter().rev().fold(Operand::ZERO, |sum, &power| graph.sum(sum, power));
        let layout = Layout::straight(&graph, &Plan::new(&graph, &[vec![result]]));
        let mut done = vec![false; graph.nodes.len()];
        done[0] = true;
        for (number, part) in layout.parts.iter().enumerate() {
            let [Piece::Straight(part)] = &part[..] else { panic!("one stretch a part") };
            assert!(part.len() <= MOST_STEPS + 2);
            for &node in part {
                for read in graph.nodes[node].reads() {
                    assert!(done[read], "{read} before {node}");
                    let is_here = layout.part_of[read] == number || graph.nodes[read].is_input();
                    assert!(is_here || layout.kept[read].is_some(), "{read} is read in part {number}");
                }
                assert!(!core::mem::replace(&mut done[node], true), "{node} twice");
            }
        }
        assert_eq!(layout.parts.len(), 7); // of 12 000 operations and a sine
        assert!(done.iter().all(|&done| done) && layout.live >= 3 * MOST_STEPS);
    }

    /// No two values that are read after each other's computation share a place.
    #[test]
    fn a_place_holds_one_value_at_a_time() {
        let parts = [vec![0, 1, 2], vec![3, 4], vec![5], vec![6]];
        let last_read = [1, 2, 0, 2, 3, 3, 3];
        let (kept, places) = keep(&parts, &last_read);
        // No array is empty.
        let places = if parts.len() > 1 { places.max(1) } else { 0 };
        assert_eq!(kept[2], None);
        let interval =
            |node: usize| (parts.iter().position(|part| part.contains(&node)).unwrap(), last_read[node]);
        for a in 0..6 {
            for b in a + 1..6 {
                if kept[a].is_some() && kept[a] == kept[b] {
                    assert!(interval(a).1 < interval(b).0, "{a} {b}");
                }
            }
        }
        assert_eq!(places, 4);
    }
}
