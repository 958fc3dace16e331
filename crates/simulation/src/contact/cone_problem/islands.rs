//! Independent parts of a problem.

use core::ops::Range;

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::sparse::NONE;

use super::dissection::Dissection;

clone_in_place! {
    /// The parts of a problem, and the memory for their solution.
    #[derive(Debug, Default)]
    pub(super) struct Islands {
        /// The number of each coordinate's tree; the first entry of each tree in `members`, and the end of
        /// the last.
        pub(super) trees: Vec<usize>,
        pub(super) begins: Vec<usize>,
        /// The coordinates tree by tree, in increasing order.
        pub(super) members: Vec<usize>,
        /// Union-find: another tree of the same part for each tree; a root points to itself.
        pub(super) leaders: Vec<usize>,
        /// The number of each tree's part, stored at its root.
        pub(super) numbers: Vec<usize>,
        /// The trees and the blocks of each part.
        pub(super) part_trees: Groups,
        pub(super) part_blocks: Groups,
        pub(super) dissection: Dissection,
        /// The present part: its coordinates, the local number of each coordinate, and λ.
        pub(super) coordinates: Vec<usize>,
        /// The range of each tree's coordinates among them.
        pub(super) ranges: Vec<Range<usize>>,
        pub(super) local: Vec<usize>,
        pub(super) dof_parent: Vec<usize>,
        pub(super) support: Vec<usize>,
    }
}

clone_in_place! {
    /// Items in groups.
    #[derive(Debug, Default)]
    pub(super) struct Groups {
        pub(super) begins: Vec<usize>,
        pub(super) items: Vec<usize>,
    }
}

impl Groups {
    /// Groups the items by these group numbers; [`NONE`] belongs to no group.
    pub(super) fn set(&mut self, groups: usize, numbers: impl Iterator<Item = usize> + Clone) {
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

    pub(super) fn group(&self, group: usize) -> &[usize] {
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
            part_trees: Groups { begins: room(), items: room() },
            part_blocks: Groups { begins: room(), items: blocks() },
            dissection: Dissection::new(n),
            coordinates: room(),
            ranges: Vec::with_capacity(n + 1),
            local: room(),
            dof_parent: room(),
            support: room(),
        }
    }

    /// The root of a tree's part.
    pub(super) fn leader(&mut self, mut tree: usize) -> usize {
        while self.leaders[tree] != tree {
            self.leaders[tree] = self.leaders[self.leaders[tree]];
            tree = self.leaders[tree];
        }
        tree
    }

    /// Finds the trees of these λ. Returns their number.
    pub(super) fn find_trees(&mut self, dof_parent: &[usize]) -> usize {
        let mut count = 0;
        self.trees.clear();
        for &dof_parent in dof_parent {
            let tree = if dof_parent == NONE { count } else { self.trees[dof_parent] };
            count += usize::from(dof_parent == NONE);
            self.trees.push(tree);
        }
        count
    }
}
