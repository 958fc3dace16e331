//! The array of a function. It has places for values that loops read one after the other, and for values that
//! are read outside the loop or part that computes them.
//!
//! An operand of a loop that other code computes is a row: one value for each iteration, at places with a
//! constant stride. The places are grouped in blocks. A block with a slot for each iteration of an earlier
//! loop serves every row with a constant stride in it. A value of straight code that such a row also needs
//! gets the adjacent slot. Every other row gets a block of its own. Values that already have a slot are
//! copied there before the loop.
//!
//! Blocks are placed in the order of their first use, each at the first gap that is large enough. A block
//! occupies its places from the segment that first writes it to the one that last reads it. This is
//! linear-scan allocation (M. Poletto, V. Sarkar, *Linear scan register allocation*, ACM TOPLAS 21, 1999).

use std::collections::{BTreeMap, HashMap};

use super::repetition::{LoopPosition, Repetition};
use crate::affine_index::{AffineIndex, difference};

/// One value for each iteration of a loop: the slot of the first, and the stride.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StridedRow {
    block: usize,
    first: isize,
    step: isize,
}

/// Adjacent places.
#[derive(Default)]
struct Block {
    /// The operation whose value each slot holds.
    slots: BTreeMap<isize, usize>,
    /// The segments in which it is first written and last read.
    first: usize,
    last: usize,
    /// Its first place.
    base: usize,
}

impl Block {
    /// The number of places, those between its slots included.
    fn length(&self) -> usize {
        let ends = self.slots.keys().next_back().zip(self.slots.keys().next());
        ends.map_or(0, |(high, low)| high.abs_diff(*low) + 1)
    }
}

/// Places in use by a block: `start..end` until a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Interval {
    start: usize,
    end: usize,
    until: usize,
}

/// All blocks, and the slots of operations in them.
pub(crate) struct ProgramMemory<'a> {
    order: &'a [usize],
    repetitions: &'a [Repetition],
    loop_positions: &'a [Option<LoopPosition>],
    segment_of: &'a [usize],
    blocks: Vec<Block>,
    /// By operation: its block, and the slot there.
    slot_of: Vec<Option<(usize, isize)>>,
    /// By loop and offset: the block, and whether each iteration has its own slot there.
    loop_blocks: HashMap<(usize, usize), (usize, bool)>,
    /// Rows by their operations.
    rows: HashMap<Vec<usize>, StridedRow>,
    /// By segment: the copies before its first iteration, each with block, slot and operation.
    copies: HashMap<usize, Vec<(usize, isize, usize)>>,
}

impl<'a> ProgramMemory<'a> {
    pub(crate) fn new(
        order: &'a [usize],
        repetitions: &'a [Repetition],
        loop_positions: &'a [Option<LoopPosition>],
        segment_of: &'a [usize],
    ) -> Self {
        Self {
            order,
            repetitions,
            loop_positions,
            segment_of,
            blocks: Vec::new(),
            slot_of: vec![None; loop_positions.len()],
            loop_blocks: HashMap::new(),
            rows: HashMap::new(),
            copies: HashMap::new(),
        }
    }

    /// A row of the values of these operations, for the loop in a segment. Values that must be copied are
    /// added to `outside` as reads of the segment.
    pub(crate) fn row(
        &mut self,
        nodes: &[usize],
        segment: usize,
        outside: &mut Vec<(usize, usize)>,
    ) -> StridedRow {
        let row = if let Some(row) = self.rows.get(nodes) {
            *row
        } else {
            let row = self.row_in_loop_block(nodes).unwrap_or_else(|| self.new_row(nodes, segment, outside));
            self.rows.insert(nodes.to_vec(), row);
            row
        };
        let last = &mut self.blocks[row.block].last;
        *last = (*last).max(segment);
        row
    }

    /// A row in the block of an earlier loop, if the row has a constant stride there. Values of straight
    /// code, before or after those of the loop, get slots in the same block.
    fn row_in_loop_block(&mut self, nodes: &[usize]) -> Option<StridedRow> {
        let middle = nodes.len() / 2;
        let LoopPosition { number, offset, iteration } = self.loop_positions[nodes[middle]]?;
        let step = self.stride_in_loop(nodes, middle)?;
        let slot = |k: usize| iteration.cast_signed() + step * difference(k, middle);
        let is_strided =
            nodes.iter().enumerate().all(|(k, &node)| match self.position_in_loop(node, (number, offset)) {
                Some(other) => other.iteration.cast_signed() == slot(k),
                None => self.loop_positions[node].is_none(),
            });
        if !is_strided {
            return None;
        }
        let block = self.block_per_iteration(number, offset);
        let straight: Vec<(isize, usize)> =
            (nodes.iter().enumerate().filter(|&(_, &node)| self.loop_positions[node].is_none()))
                .map(|(k, &node)| (slot(k), node))
                .collect();
        if !self.are_free(block, &straight) {
            return None;
        }
        for (slot, node) in straight {
            self.claim(block, slot, node);
        }
        Some(StridedRow { block, first: slot(0), step })
    }

    /// An operation's position, if it is this operation of this loop.
    fn position_in_loop(&self, node: usize, which: (usize, usize)) -> Option<LoopPosition> {
        self.loop_positions[node].filter(|position| (position.number, position.offset) == which)
    }

    /// The stride of a row in iterations, from the middle value and another value of the same loop. `None` if
    /// there is no other value or the stride is zero.
    fn stride_in_loop(&self, nodes: &[usize], middle: usize) -> Option<isize> {
        let LoopPosition { number, offset, iteration } = self.loop_positions[nodes[middle]]?;
        let (other, there) = (0..nodes.len()).filter(|&other| other != middle).find_map(|other| {
            Some((other, self.position_in_loop(nodes[other], (number, offset))?.iteration))
        })?;
        let step = difference(iteration, there) / difference(middle, other);
        (step != 0).then_some(step)
    }

    /// Whether these slots of a block are free for these operations, or hold them already.
    fn are_free(&self, block: usize, wanted: &[(isize, usize)]) -> bool {
        wanted.iter().all(|&(slot, node)| {
            self.slot_of[node].is_none_or(|at| at == (block, slot))
                && self.blocks[block].slots.get(&slot).is_none_or(|&there| there == node)
                && wanted.iter().all(|&(other, same)| (other == slot) == (same == node))
        })
    }

    /// A row in a block of its own. Values of loops, and those that have a slot already, are copied.
    fn new_row(&mut self, nodes: &[usize], segment: usize, outside: &mut Vec<(usize, usize)>) -> StridedRow {
        let block = self.new_block();
        self.blocks[block].first = segment;
        for (slot, &node) in (0..).zip(nodes) {
            if self.loop_positions[node].is_none() && self.slot_of[node].is_none() {
                self.claim(block, slot, node);
            } else {
                self.blocks[block].slots.insert(slot, node);
                self.copies.entry(segment).or_default().push((block, slot, node));
                outside.push((segment, node));
            }
        }
        StridedRow { block, first: 0, step: 1 }
    }

    fn new_block(&mut self) -> usize {
        self.blocks.push(Block { first: usize::MAX, ..Block::default() });
        self.blocks.len() - 1
    }

    /// Assigns a slot to an operation.
    fn claim(&mut self, block: usize, slot: isize, node: usize) {
        self.blocks[block].slots.insert(slot, node);
        self.slot_of[node] = Some((block, slot));
        let written = self.segment_of[node];
        let Block { first, last, .. } = &mut self.blocks[block];
        (*first, *last) = ((*first).min(written), (*last).max(written));
    }

    /// The block with a slot for each iteration of an operation of a loop.
    fn block_per_iteration(&mut self, number: usize, offset: usize) -> usize {
        if let Some(&(block, _)) = self.loop_blocks.get(&(number, offset)) {
            return block;
        }
        let block = self.new_block();
        self.loop_blocks.insert((number, offset), (block, true));
        let Repetition { start, period, iterations } = self.repetitions[number];
        for (iteration, slot) in (0..iterations).zip(0..) {
            self.claim(block, slot, self.order[start + iteration * period + offset]);
        }
        block
    }

    /// Assigns slots to all values that are read outside their loop or their part; `outside` has pairs of the
    /// reading segment and the operation.
    pub(crate) fn store_values(&mut self, outside: &[(usize, usize)], part: &dyn Fn(usize) -> usize) {
        self.store_loop_values(outside);
        for &(segment, node) in outside {
            let is_elsewhere =
                self.loop_positions[node].is_some() || part(self.segment_of[node]) != part(segment);
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
            *last = (*last).max(segment);
        }
    }

    /// Assigns slots to values of loops: one for each iteration, or a common one if only the last iteration's
    /// value is read.
    fn store_loop_values(&mut self, outside: &[(usize, usize)]) {
        let mut last_iterations = Vec::new();
        for &(_, node) in outside {
            let Some(LoopPosition { number, offset, iteration }) = self.loop_positions[node] else {
                continue;
            };
            if iteration + 1 == self.repetitions[number].iterations {
                last_iterations.push((number, offset, node));
            } else {
                self.block_per_iteration(number, offset);
            }
        }
        for (number, offset, node) in last_iterations {
            if !self.loop_blocks.contains_key(&(number, offset)) {
                let block = self.new_block();
                self.loop_blocks.insert((number, offset), (block, false));
                self.claim(block, 0, node);
            }
        }
    }

    /// Places all blocks, and returns the length of the array.
    pub(crate) fn allocate(&mut self) -> usize {
        let mut order: Vec<usize> = (0..self.blocks.len()).collect();
        order.sort_by_key(|&block| (self.blocks[block].first, block));
        let mut length = 0;
        let mut used: Vec<Interval> = Vec::new();
        for block in order {
            let block = &mut self.blocks[block];
            used.retain(|interval| interval.until >= block.first);
            block.base = place_first_fit(&mut used, block.length(), block.last);
            length = length.max(block.base + block.length());
        }
        length
    }

    fn place_of(&self, block: usize, slot: isize) -> usize {
        let Block { slots, base, .. } = &self.blocks[block];
        let low = *slots.keys().next().expect("every block has a slot");
        *base + slot.abs_diff(low)
    }

    /// The place of an operation's value.
    pub(crate) fn place(&self, node: usize) -> Option<usize> {
        self.slot_of[node].map(|(block, slot)| self.place_of(block, slot))
    }

    /// The index at which each iteration stores an operation's value.
    pub(crate) fn stored_at(&self, number: usize, offset: usize) -> Option<AffineIndex> {
        let &(block, is_per_iteration) = self.loop_blocks.get(&(number, offset))?;
        Some(AffineIndex { first: self.place_of(block, 0), step: isize::from(is_per_iteration) })
    }

    pub(crate) fn index(&self, row: &StridedRow) -> AffineIndex {
        AffineIndex { first: self.place_of(row.block, row.first), step: row.step }
    }

    /// The copies before the first iteration: to which place, which operation's value.
    pub(crate) fn copies(&self, segment: usize) -> Vec<(usize, usize)> {
        let copies = self.copies.get(&segment).map_or(&[][..], Vec::as_slice);
        copies.iter().map(|&(block, slot, node)| (self.place_of(block, slot), node)).collect()
    }
}

/// Inserts an interval of this length at the first gap between the used ones, which are sorted, and returns
/// its start.
fn place_first_fit(used: &mut Vec<Interval>, length: usize, until: usize) -> usize {
    let mut start = 0;
    let mut at = used.len();
    for (number, interval) in used.iter().enumerate() {
        if interval.start >= start + length {
            at = number;
            break;
        }
        start = interval.end;
    }
    used.insert(at, Interval { start, end: start + length, until });
    start
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gaps are filled from the front, a block that fits nowhere goes to the end, and intervals stay sorted.
    #[test]
    fn blocks_are_placed_at_the_first_gap() {
        let interval = |start, end| Interval { start, end, until: 9 };
        let mut used = vec![interval(2, 4), interval(5, 6)];
        assert_eq!(place_first_fit(&mut used, 2, 9), 0);
        assert_eq!(place_first_fit(&mut used, 2, 9), 6);
        assert_eq!(place_first_fit(&mut used, 1, 9), 4);
        assert_eq!(used, [(0, 2), (2, 4), (4, 5), (5, 6), (6, 8)].map(|(start, end)| interval(start, end)));
    }

    /// A loop of three operations and four iterations, operations 0 to 11; operations 12 to 14 are straight.
    fn with_memory(check: impl FnOnce(&mut ProgramMemory<'_>)) {
        let order: Vec<usize> = (0..15).collect();
        let repetitions = [Repetition { start: 0, period: 3, iterations: 4 }];
        let position = |node: usize| LoopPosition { number: 0, offset: node % 3, iteration: node / 3 };
        let positions: Vec<_> = order.iter().map(|&node| (node < 12).then(|| position(node))).collect();
        let segments: Vec<usize> = order.iter().map(|&node| usize::from(node >= 12)).collect();
        check(&mut ProgramMemory::new(&order, &repetitions, &positions, &segments));
    }

    /// Values of one operation of a loop, forward or backward, are a row of the loop's block.
    #[test]
    fn a_row_of_a_loop_needs_no_copies() {
        with_memory(|memory| {
            let mut outside = Vec::new();
            let forward = memory.row(&[1, 4, 7, 10], 2, &mut outside);
            let backward = memory.row(&[10, 7, 4, 1], 2, &mut outside);
            assert!(outside.is_empty() && forward.block == backward.block);
            assert_eq!((forward.first, forward.step, backward.first, backward.step), (0, 1, 3, -1));
            assert_eq!(memory.allocate(), 4);
            assert!([1, 4, 7, 10].iter().enumerate().all(|(k, &node)| memory.place(node) == Some(k)));
        });
    }

    /// A value of straight code that precedes those of a loop gets the slot before them.
    #[test]
    fn a_row_extends_the_block_of_a_loop() {
        with_memory(|memory| {
            let mut outside = Vec::new();
            let row = memory.row(&[12, 0, 3, 6, 9], 2, &mut outside);
            assert!(outside.is_empty());
            assert_eq!((row.first, row.step, memory.allocate()), (-1, 1, 5));
            assert_eq!((memory.place(12), memory.place(0)), (Some(0), Some(1)));
        });
    }

    /// A row without a constant stride in a loop's block is copied.
    #[test]
    fn a_row_without_a_stride_is_copied() {
        with_memory(|memory| {
            let mut outside = Vec::new();
            memory.row(&[0, 6, 3, 9], 2, &mut outside);
            assert_eq!(outside, [(2, 0), (2, 6), (2, 3), (2, 9)]);
            memory.store_values(&outside, &|segment| segment);
            memory.allocate();
            let copied: Vec<usize> = memory.copies(2).iter().map(|&(_, node)| node).collect();
            assert_eq!(copied, [0, 6, 3, 9]);
        });
    }

    /// A value that is read only in the last iteration needs one slot.
    #[test]
    fn a_value_of_the_last_iteration_has_one_slot() {
        with_memory(|memory| {
            memory.store_values(&[(1, 11)], &|segment| segment);
            assert_eq!(memory.allocate(), 1);
            assert_eq!(memory.stored_at(0, 2), Some(AffineIndex { first: 0, step: 0 }));
        });
    }
}
