//! How a function is written: its operations one after the other or in loops, in how many parts, and what is kept in memory
//! between these.

use core::fmt;

use crate::graph::{Graph, Operand};
use crate::loops;
use crate::plan::Plan;

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
        let straight = Self::straight(plan);
        match loops::in_loops(graph, results, place) {
            Some(layout) if 3 * layout.lines() <= 2 * straight.lines() => layout,
            _ => straight,
        }
    }

    /// One operation after the other.
    pub(crate) fn straight(plan: &Plan) -> Self {
        Self {
            parts: plan.parts.iter().map(|part| vec![Piece::Straight(part.clone())]).collect(),
            kept: plan.kept.clone(),
            part_of: plan.part_of.clone(),
            step_of: plan.step_of.clone(),
            in_loop: vec![false; plan.kept.len()],
            places: plan.places,
            live: plan.live,
        }
    }

    /// The loops.
    pub(crate) fn loops(&self) -> impl Iterator<Item = &Loop> {
        self.parts.iter().flatten().filter_map(|piece| match piece {
            Piece::Straight(_) => None,
            Piece::Loop(repeated) => Some(repeated),
        })
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
