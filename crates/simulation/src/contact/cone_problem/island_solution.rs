//! Independent parts of a problem, each solved separately.
//!
//! Two coordinates are in the same part if M couples them, as in one tree, or if a block acts on both. The
//! matrix of a part has the part's size, and its tolerances are relative to the part's speeds. A part that
//! converges slowly does not slow the others down. The trees of a large part are ordered for little fill-in
//! ([`Dissection`](super::dissection::Dissection)).

use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::factorization::sparse::NONE;

use super::ConeProblem;
use super::block::Block;
use super::islands::{Groups, Islands};

/// The fewest trees for which a problem of a single part is solved as a part, with its trees ordered.
const LEAST_TREES_TO_ORDER_ONE_PART: usize = 8;

/// The number of coordinates of a part for which memory is allocated at the start.
const USUAL_PART: usize = 128;

/// The fewest trees of a part that are ordered; smaller parts keep their order.
const LEAST_TREES_TO_ORDER: usize = 4;

impl ConeProblem {
    /// Allocates memory for the solution part by part.
    pub(in crate::contact) fn with_islands(mut self) -> Self {
        self.islands = Islands::new(self.n);
        self.part = Some(Box::new(Self::new(self.n.min(USUAL_PART))));
        self
    }

    /// Finds the parts of the problem, given λ of M. Returns whether it should be solved part by part.
    pub(in crate::contact) fn find_islands(&mut self, dof_parent: &[usize]) -> bool {
        let Self { islands, blocks, support, force, .. } = self;
        let count = islands.find_trees(dof_parent);
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
        let of_block = |block: &Block| numbers[leaders[trees[support[block.support.start]]]];
        part_blocks.set(groups, blocks.iter().map(of_block));
        let mut of_trees = Groups { begins: core::mem::take(begins), items: core::mem::take(members) };
        of_trees.set(count, trees.iter().copied());
        (*begins, *members) = (of_trees.begins, of_trees.items);
        true
    }

    /// Runs [`solve_rigid`](Self::solve_rigid) for each [part](Self::find_islands), with the M that was set.
    pub(in crate::contact) fn solve_islands(&mut self) -> bool {
        let mut islands = core::mem::take(&mut self.islands);
        let mut part = self.part.take().unwrap_or_else(|| Box::new(Self::new(0)));
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
        self.part = Some(part);
        self.islands = islands;
        is_solved
    }

    /// Copies a part of another problem.
    fn take_part(&mut self, whole: &Self, islands: &Islands, number: usize) {
        let Islands { coordinates, local, dof_parent, part_blocks, .. } = islands;
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
        self.paths.choose(dof_parent);
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
        let Self { dissection, coordinates, ranges, local, dof_parent, support: own, .. } = self;
        let of_part = part_trees.group(number);
        let blocks = || part_blocks.group(number).iter().map(|index| &problem.blocks[*index]);
        let support_of = |block: &Block| &problem.support[block.support.clone()];
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
        dof_parent.clear();
        for (at, &k) in coordinates.iter().enumerate() {
            local[k] = at;
            let carried = problem.paths.dof_parent()[k];
            dof_parent.push(if carried == NONE { NONE } else { local[carried] });
        }
        for block in blocks() {
            own.clear();
            own.extend(support_of(block).iter().map(|k| local[*k]));
            own.sort_unstable();
            for pair in own.windows(2) {
                let mut at = pair[1];
                while at != NONE && at > pair[0] {
                    at = dof_parent[at];
                }
                if at != pair[0] {
                    sparse::couple(dof_parent, [pair[0], pair[1]]);
                }
            }
        }
    }
}
