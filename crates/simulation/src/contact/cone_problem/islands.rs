//! Independent parts of a problem, each solved separately.
//!
//! Two coordinates are in the same part if M couples them, as in one tree, or if a block acts on both. The
//! matrix of a part has the part's size, and its tolerances are relative to the part's speeds. A part that
//! converges slowly does not slow the others down. The trees of a large part are ordered for little fill-in
//! ([`Dissection`]).

use core::ops::Range;

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::factorization::sparse::NONE;

use super::ConeProblem;
use super::dissection::Dissection;

/// The fewest trees for which a problem of a single part is solved as a part, with its trees ordered.
const LEAST_TREES_TO_ORDER_ONE_PART: usize = 8;

/// The number of coordinates of a part for which memory is allocated at the start.
const USUAL_PART: usize = 128;

/// The fewest trees of a part that are ordered; smaller parts keep their order.
const LEAST_TREES_TO_ORDER: usize = 4;

clone_in_place! {
    /// The parts of a problem, and the memory for their solution.
    #[derive(Debug, Default)]
    pub(super) struct Islands {
        /// The number of each coordinate's tree; the first entry of each tree in `members`, and the end of
        /// the last.
        trees: Vec<usize>,
        begins: Vec<usize>,
        /// The coordinates tree by tree, in increasing order.
        members: Vec<usize>,
        /// Union-find: another tree of the same part for each tree; a root points to itself.
        leaders: Vec<usize>,
        /// The number of each tree's part, stored at its root.
        numbers: Vec<usize>,
        /// The trees and the blocks of each part.
        part_trees: Grouped,
        part_blocks: Grouped,
        dissection: Dissection,
        /// The present part: its coordinates, the local number of each coordinate, and λ.
        coordinates: Vec<usize>,
        /// The range of each tree's coordinates among them.
        ranges: Vec<Range<usize>>,
        local: Vec<usize>,
        carrier: Vec<usize>,
        support: Vec<usize>,
        part: Option<Box<ConeProblem>>,
    }
}

clone_in_place! {
    /// Items in groups.
    #[derive(Debug, Default)]
    struct Grouped {
        begins: Vec<usize>,
        items: Vec<usize>,
    }
}

impl Grouped {
    /// Groups the items by these group numbers; [`NONE`] belongs to no group.
    fn set(&mut self, groups: usize, numbers: impl Iterator<Item = usize> + Clone) {
        self.begins.clear();
        self.begins.resize(groups + 1, 0);
        for number in numbers.clone().filter(|number| *number != NONE) {
            self.begins[number + 1] += 1;
        }
        for group in 0..groups {
            self.begins[group + 1] += self.begins[group];
        }
        self.items.clear();
        self.items.resize(self.begins[groups], 0);
        for (item, number) in numbers.enumerate().filter(|(_, number)| *number != NONE) {
            self.items[self.begins[number]] = item;
            self.begins[number] += 1;
        }
        self.begins.rotate_right(1);
        self.begins[0] = 0;
    }

    fn group(&self, group: usize) -> &[usize] {
        &self.items[self.begins[group]..self.begins[group + 1]]
    }
}

impl Islands {
    /// Allocates memory for n coordinates in parts of usual size.
    pub(super) fn new(n: usize) -> Self {
        let room = || Vec::with_capacity(n + 1);
        let blocks = || Vec::with_capacity(2 * n + 32);
        Self {
            trees: room(),
            begins: room(),
            members: room(),
            leaders: room(),
            numbers: room(),
            part_trees: Grouped { begins: room(), items: room() },
            part_blocks: Grouped { begins: room(), items: blocks() },
            dissection: Dissection::new(n),
            coordinates: room(),
            ranges: Vec::with_capacity(n + 1),
            local: room(),
            carrier: room(),
            support: room(),
            part: Some(Box::new(ConeProblem::new(n.min(USUAL_PART)))),
        }
    }

    /// The root of a tree's part.
    fn leader(&mut self, mut tree: usize) -> usize {
        while self.leaders[tree] != tree {
            self.leaders[tree] = self.leaders[self.leaders[tree]];
            tree = self.leaders[tree];
        }
        tree
    }

    /// Finds the trees of these λ. Returns their number.
    fn find_trees(&mut self, carrier: &[usize]) -> usize {
        let mut count = 0;
        self.trees.clear();
        for &carrier in carrier {
            let tree = if carrier == NONE { count } else { self.trees[carrier] };
            count += usize::from(carrier == NONE);
            self.trees.push(tree);
        }
        count
    }
}

impl ConeProblem {
    /// Finds the parts of the problem, given λ of M. Returns whether it should be solved part by part.
    pub(in crate::contact) fn find_islands(&mut self, carrier: &[usize]) -> bool {
        let Self { islands, blocks, support, force, .. } = self;
        let count = islands.find_trees(carrier);
        if count < 2 || blocks.iter().any(|block| block.support.is_empty()) {
            return false;
        }
        islands.leaders.clear();
        islands.leaders.extend(0..count);
        let mut parts = count;
        for block in &*blocks {
            let support = &support[block.support.clone()];
            let mut one = islands.leader(islands.trees[support[0]]);
            for k in &support[1..] {
                let other = islands.leader(islands.trees[*k]);
                if one != other {
                    islands.leaders[one.max(other)] = one.min(other);
                    one = one.min(other);
                    parts -= 1;
                }
            }
        }
        if parts == 1 && count < LEAST_TREES_TO_ORDER_ONE_PART {
            return false;
        }
        // Number the parts that have a force or a block that requires a solution, in the order of their first
        // trees.
        islands.numbers.clear();
        islands.numbers.resize(count, NONE);
        for block in blocks.iter().filter(|block| block.is_due) {
            let leader = islands.leader(islands.trees[support[block.support.start]]);
            islands.numbers[leader] = 0;
        }
        for (k, _) in force.iter().enumerate().filter(|(_, force)| **force != 0.0) {
            let leader = islands.leader(islands.trees[k]);
            islands.numbers[leader] = 0;
        }
        let mut groups = 0;
        for number in islands.numbers.iter_mut().filter(|number| **number == 0) {
            *number = groups;
            groups += 1;
        }
        // From here on, every tree points directly to its root.
        for tree in 0..count {
            let leader = islands.leader(tree);
            islands.leaders[tree] = leader;
        }
        let Islands { trees, leaders, numbers, part_trees, part_blocks, begins, members, .. } = islands;
        part_trees.set(groups, leaders.iter().map(|leader| numbers[*leader]));
        let of_block = |block: &super::Block| numbers[leaders[trees[support[block.support.start]]]];
        part_blocks.set(groups, blocks.iter().map(of_block));
        let mut of_trees = Grouped { begins: core::mem::take(begins), items: core::mem::take(members) };
        of_trees.set(count, trees.iter().copied());
        (*begins, *members) = (of_trees.begins, of_trees.items);
        true
    }

    /// Runs [`solve_rigid`](Self::solve_rigid) for each [part](Self::find_islands), with the M that was set.
    pub(in crate::contact) fn solve_islands(&mut self) -> bool {
        let mut islands = core::mem::take(&mut self.islands);
        let mut part = islands.part.take().unwrap_or_else(|| Box::new(Self::new(0)));
        part.interrupt = self.interrupt.clone();
        self.choose_softness();
        self.x.fill(0.0);
        self.c.resize(self.start.len(), 0.0);
        (self.rounds, self.is_coulomb) = (0, true);
        let parts = islands.part_trees.begins.len() - 1;
        let is_solved = (0..parts).all(|number| {
            islands.place(number, self);
            part.take_part(self, &islands, number);
            if islands.part_trees.group(number).len() >= LEAST_TREES_TO_ORDER {
                part.begin_by_sweeps();
            }
            let is_solved = part.solve_rigid();
            self.enter_part(&part, &islands, number);
            is_solved
        });
        islands.part = Some(part);
        self.islands = islands;
        is_solved
    }

    /// Copies a part of another problem.
    fn take_part(&mut self, whole: &Self, islands: &Islands, number: usize) {
        let Islands { coordinates, local, carrier, part_blocks, .. } = islands;
        let n = coordinates.len();
        self.resize(n);
        self.clear();
        for (to, k) in self.force.iter_mut().zip(coordinates) {
            *to = whole.force[*k];
        }
        self.counted.clear();
        for &index in part_blocks.group(number) {
            let block = &whole.blocks[index];
            let support = &whole.support[block.support.clone()];
            let count = support.len();
            let row = self.push(block.set, block.rows.len(), support.iter().map(|k| local[*k]));
            let rows = row..row + block.rows.len();
            self.start[rows.clone()].copy_from_slice(&whole.start[block.rows.clone()]);
            self.multiplier[rows].copy_from_slice(&whole.multiplier[block.rows.clone()]);
            // Before anything acts, `counted` is empty.
            self.counted.extend_from_slice(whole.counted.get(block.rows.clone()).unwrap_or(&[]));
            self.begin_with_shift(block.shift);
            let (own, entries) = self.last();
            let from = &whole.entries[block.entries..][..count * block.rows.len()];
            entries[..from.len()].copy_from_slice(from);
            // All supports are in increasing order.
            if !own.is_sorted() {
                self.sort_last(count);
            }
        }
        self.paths.choose(carrier);
        self.sweeps.trees.clone_from(&islands.ranges);
        let Self { paths, mass, .. } = self;
        mass.clear();
        mass.resize(paths.size(), 0.0);
        for (k, &from) in coordinates.iter().enumerate() {
            let (columns, entries) = whole.paths.entries_of(from, &whole.mass);
            for (&column, entry) in columns.iter().zip(entries) {
                *paths.entry_of(k, local[column], mass) = *entry;
            }
        }
    }

    /// Sorts the coordinates of the last block, `count` of them, and the columns of its entries.
    fn sort_last(&mut self, count: usize) {
        let Some(block) = self.blocks.last() else { return };
        let support = &mut self.support[block.support.clone()];
        let entries = &mut self.entries[block.entries..];
        // Insertion sort: the coordinates are few, and mostly two sorted runs.
        for i in 1..count {
            let mut at = i;
            while at > 0 && support[at - 1] > support[at] {
                support.swap(at - 1, at);
                for row in entries.chunks_exact_mut(count) {
                    row.swap(at - 1, at);
                }
                at -= 1;
            }
        }
    }

    /// Copies the solution of a part.
    fn enter_part(&mut self, part: &Self, islands: &Islands, number: usize) {
        for (&k, x) in islands.coordinates.iter().zip(&part.x) {
            self.x[k] = *x;
        }
        for (&index, from) in islands.part_blocks.group(number).iter().zip(&part.blocks) {
            let block = &mut self.blocks[index];
            block.shift = from.shift;
            self.multiplier[block.rows.clone()].copy_from_slice(&part.multiplier[from.rows.clone()]);
            self.c[block.rows.clone()].copy_from_slice(&part.c[from.rows.clone()]);
        }
        self.rounds += part.rounds;
        self.is_coulomb &= part.is_coulomb;
    }

    /// Allocates memory for n coordinates.
    fn resize(&mut self, n: usize) {
        self.n = n;
        for vector in [&mut self.force, &mut self.x, &mut self.step, &mut self.residual, &mut self.slope] {
            vector.clear();
            vector.resize(n, 0.0);
        }
        self.rows.make_room(n);
    }
}

impl Islands {
    /// Orders the coordinates of a part, and finds their λ.
    fn place(&mut self, number: usize, problem: &ConeProblem) {
        let Self { trees, begins, members, part_trees, part_blocks, .. } = self;
        let Self { dissection, coordinates, ranges, local, carrier, support: own, .. } = self;
        let of_part = part_trees.group(number);
        let blocks = || part_blocks.group(number).iter().map(|index| &problem.blocks[*index]);
        let support_of = |block: &super::Block| &problem.support[block.support.clone()];
        coordinates.clear();
        ranges.clear();
        let order = if of_part.len() < LEAST_TREES_TO_ORDER {
            of_part
        } else {
            dissection.begin(of_part);
            for block in blocks() {
                let support = support_of(block);
                let first = trees[support[0]];
                for k in &support[1..] {
                    dissection.join(first, trees[*k]);
                }
            }
            dissection.order()
        };
        for &tree in order {
            let begin = coordinates.len();
            coordinates.extend_from_slice(&members[begins[tree]..begins[tree + 1]]);
            ranges.push(begin..coordinates.len());
        }
        local.resize(trees.len(), NONE);
        carrier.clear();
        for (at, &k) in coordinates.iter().enumerate() {
            local[k] = at;
            let carried = problem.paths.carrier()[k];
            carrier.push(if carried == NONE { NONE } else { local[carried] });
        }
        for block in blocks() {
            own.clear();
            own.extend(support_of(block).iter().map(|k| local[*k]));
            own.sort_unstable();
            for pair in own.windows(2) {
                let mut at = pair[1];
                while at != NONE && at > pair[0] {
                    at = carrier[at];
                }
                if at != pair[0] {
                    sparse::couple(carrier, [pair[0], pair[1]]);
                }
            }
        }
    }
}
