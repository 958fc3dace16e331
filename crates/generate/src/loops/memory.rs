//! Where values lie that loops read one after the other, and those that are read outside the loop that computes them.

use std::collections::{BTreeMap, HashMap};

use super::InLoop;
use super::repeats::Repeat;
use crate::layout::{Index, difference};

/// A value for each turn of a loop: where the first turn's lies, and how far apart they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    block: usize,
    first: isize,
    step: isize,
}

/// Places side by side.
#[derive(Default)]
struct Block {
    /// Whose value each holds.
    slots: BTreeMap<isize, usize>,
    /// The stretches in which it is first written and last read.
    first: usize,
    last: usize,
    /// Where it begins.
    base: usize,
}

/// All places.
pub(crate) struct Memory<'a> {
    order: &'a [usize],
    repeats: &'a [Repeat],
    in_loop: &'a [Option<InLoop>],
    stretch_of: &'a [usize],
    blocks: Vec<Block>,
    /// By operation: its block, and the slot there.
    slot_of: Vec<Option<(usize, isize)>>,
    /// By loop and offset: the block in which each turn has its slot, or all have the same.
    of_loop: HashMap<(usize, usize), (usize, bool)>,
    /// Rows by their operations.
    rows: HashMap<Vec<usize>, Row>,
    /// By stretch: what is copied before its first turn.
    copies: HashMap<usize, Vec<(usize, isize, usize)>>,
}

impl<'a> Memory<'a> {
    pub(crate) fn new(
        order: &'a [usize],
        repeats: &'a [Repeat],
        in_loop: &'a [Option<InLoop>],
        stretch_of: &'a [usize],
    ) -> Self {
        Self {
            order,
            repeats,
            in_loop,
            stretch_of,
            blocks: Vec::new(),
            slot_of: vec![None; in_loop.len()],
            of_loop: HashMap::new(),
            rows: HashMap::new(),
            copies: HashMap::new(),
        }
    }

    /// Side by side, these operations' values, for the loop in a stretch; what must be copied is read there.
    pub(crate) fn row(&mut self, nodes: &[usize], stretch: usize, outside: &mut Vec<(usize, usize)>) -> Row {
        let row = if let Some(row) = self.rows.get(nodes) {
            *row
        } else {
            let row = self.beside_a_loops(nodes).unwrap_or_else(|| self.new_row(nodes, stretch, outside));
            self.rows.insert(nodes.to_vec(), row);
            row
        };
        let last = &mut self.blocks[row.block].last;
        *last = (*last).max(stretch);
        row
    }

    /// A row in the block of an earlier loop, before or after whose turns' slots straight code's values fit.
    fn beside_a_loops(&mut self, nodes: &[usize]) -> Option<Row> {
        let middle = nodes.len() / 2;
        let InLoop { number, offset, turn } = self.in_loop[nodes[middle]]?;
        let of_same =
            |node: usize| self.in_loop[node].filter(|other| (other.number, other.offset) == (number, offset));
        let (other, there) = (0..nodes.len())
            .filter(|&other| other != middle)
            .find_map(|other| Some((other, of_same(nodes[other])?.turn)))?;
        let (turns, distance) = (difference(turn, there), difference(middle, other));
        let step = turns / distance;
        let slot = |k: usize| turn.cast_signed() + step * difference(k, middle);
        let is_even = step != 0
            && nodes.iter().enumerate().all(|(k, &node)| match of_same(node) {
                Some(other) => other.turn.cast_signed() == slot(k),
                None => self.in_loop[node].is_none(),
            });
        if !is_even {
            return None;
        }
        let block = self.of_each_turn(number, offset);
        let straight: Vec<(isize, usize)> =
            (nodes.iter().enumerate().filter(|&(_, &node)| self.in_loop[node].is_none()))
                .map(|(k, &node)| (slot(k), node))
                .collect();
        let is_free = |&(slot, node): &(isize, usize)| {
            let is_mine = |at: &(usize, isize)| *at == (block, slot);
            self.slot_of[node].as_ref().is_none_or(is_mine)
                && self.blocks[block].slots.get(&slot).is_none_or(|&there| there == node)
                && straight.iter().all(|&(other, same)| (other == slot) == (same == node))
        };
        if !straight.iter().all(is_free) {
            return None;
        }
        for (slot, node) in straight {
            self.claim(block, slot, node);
        }
        Some(Row { block, first: slot(0), step })
    }

    /// A row of its own. What has a place already is copied.
    fn new_row(&mut self, nodes: &[usize], stretch: usize, outside: &mut Vec<(usize, usize)>) -> Row {
        let block = self.new_block();
        self.blocks[block].first = stretch;
        for (slot, &node) in (0..).zip(nodes) {
            if self.in_loop[node].is_none() && self.slot_of[node].is_none() {
                self.claim(block, slot, node);
            } else {
                self.blocks[block].slots.insert(slot, node);
                self.copies.entry(stretch).or_default().push((block, slot, node));
                outside.push((stretch, node));
            }
        }
        Row { block, first: 0, step: 1 }
    }

    fn new_block(&mut self) -> usize {
        self.blocks.push(Block { first: usize::MAX, ..Block::default() });
        self.blocks.len() - 1
    }

    fn claim(&mut self, block: usize, slot: isize, node: usize) {
        self.blocks[block].slots.insert(slot, node);
        self.slot_of[node] = Some((block, slot));
        let written = self.stretch_of[node];
        let Block { first, last, .. } = &mut self.blocks[block];
        (*first, *last) = ((*first).min(written), (*last).max(written));
    }

    /// The block with a slot for each turn's value.
    fn of_each_turn(&mut self, number: usize, offset: usize) -> usize {
        if let Some(&(block, _)) = self.of_loop.get(&(number, offset)) {
            return block;
        }
        let block = self.new_block();
        self.of_loop.insert((number, offset), (block, true));
        let Repeat { start, period, turns } = self.repeats[number];
        for (turn, slot) in (0..turns).zip(0..) {
            self.claim(block, slot, self.order[start + turn * period + offset]);
        }
        block
    }

    /// Gives a place to all that is read outside its loop or its part.
    pub(crate) fn keep(&mut self, outside: &[(usize, usize)], part: &dyn Fn(usize) -> usize) {
        let mut last_turns = Vec::new();
        for &(_, node) in outside {
            let Some(InLoop { number, offset, turn }) = self.in_loop[node] else { continue };
            if turn + 1 == self.repeats[number].turns {
                last_turns.push((number, offset, node));
            } else {
                self.of_each_turn(number, offset);
            }
        }
        // The last turn's alone: each overwrites the one before.
        for (number, offset, node) in last_turns {
            if !self.of_loop.contains_key(&(number, offset)) {
                let block = self.new_block();
                self.of_loop.insert((number, offset), (block, false));
                self.claim(block, 0, node);
            }
        }
        for &(stretch, node) in outside {
            let is_elsewhere = self.in_loop[node].is_some() || part(self.stretch_of[node]) != part(stretch);
            if !is_elsewhere {
                continue;
            }
            let block = if let Some((block, _)) = self.slot_of[node] {
                block
            } else {
                let block = self.new_block();
                self.claim(block, 0, node);
                block
            };
            let last = &mut self.blocks[block].last;
            *last = (*last).max(stretch);
        }
    }

    /// Puts each block where none is that is read after it is first written; how many places that takes.
    pub(crate) fn allocate(&mut self) -> usize {
        let mut order: Vec<usize> = (0..self.blocks.len()).collect();
        order.sort_by_key(|&block| (self.blocks[block].first, block));
        let mut places = 0;
        // Those in use: where they begin and end, and their last stretch.
        let mut used: Vec<(usize, usize, usize)> = Vec::new();
        for block in order {
            let Block { slots, first, last, base } = &mut self.blocks[block];
            let length = slots
                .keys()
                .next_back()
                .zip(slots.keys().next())
                .map_or(0, |(high, low)| high.abs_diff(*low) + 1);
            used.retain(|&(.., until)| until >= *first);
            let mut free = 0;
            let mut at = used.len();
            for (number, &(begin, end, _)) in used.iter().enumerate() {
                if begin >= free + length {
                    at = number;
                    break;
                }
                free = end;
            }
            *base = free;
            used.insert(at, (free, free + length, *last));
            places = places.max(free + length);
        }
        places
    }

    fn place_of(&self, block: usize, slot: isize) -> usize {
        let Block { slots, base, .. } = &self.blocks[block];
        let low = *slots.keys().next().expect("no block is empty");
        *base + slot.abs_diff(low)
    }

    /// Where an operation's value is kept.
    pub(crate) fn place(&self, node: usize) -> Option<usize> {
        self.slot_of[node].map(|(block, slot)| self.place_of(block, slot))
    }

    /// Where each turn keeps an operation's value.
    pub(crate) fn kept(&self, number: usize, offset: usize) -> Option<Index> {
        let &(block, of_each) = self.of_loop.get(&(number, offset))?;
        Some(Index { first: self.place_of(block, 0), step: isize::from(of_each) })
    }

    pub(crate) fn index(&self, row: &Row) -> Index {
        Index { first: self.place_of(row.block, row.first), step: row.step }
    }

    /// What is copied before the first turn: to which place, which operation's value.
    pub(crate) fn copies(&self, stretch: usize) -> Vec<(usize, usize)> {
        let copies = self.copies.get(&stretch).map_or(&[][..], Vec::as_slice);
        copies.iter().map(|&(block, slot, node)| (self.place_of(block, slot), node)).collect()
    }
}
