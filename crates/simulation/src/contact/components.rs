//! Components of a scene: trees that interact. A step couples only coordinates of one component.
//!
//! Trees joined by M̂, tendons or equalities count as one tree permanently. Contacts join trees for one step.
//! If a component meets the ground, its step is divided; the other components are inactive meanwhile.

use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::factorization::sparse::NONE;
use robot_dynamics_core::model::WORLD;

clone_in_place! {
    /// The trees, their joins in this step, and which of them move.
    #[derive(Debug)]
    pub struct Components {
        /// The tree of each coordinate.
        trees: Vec<usize>,
        /// Union-find: another tree of the same component with a lower number; the first tree points to
        /// itself.
        leaders: Vec<usize>,
        active: Vec<bool>,
        is_whole: bool,
        /// The components with each [`Mark`], stored at their first trees.
        marks: [Vec<bool>; 5],
    }
}

/// A property of a component in a step.
#[derive(Clone, Copy, Debug)]
pub enum Mark {
    /// It meets a stop or the ground, so the step is divided.
    Meets,
    /// It has contacts.
    Touched,
    /// It starts deep in the ground or beyond a stop.
    Deep,
    /// An impact in it: the forces of the last step do not continue.
    Hit,
    /// Its energy balance in the step must be checked.
    Suspect,
}

impl Components {
    /// The trees of these λ.
    pub fn new(dof_parent: &[usize]) -> Self {
        let (trees, count) = sparse::trees(dof_parent);
        let marks = [(); 5].map(|()| vec![false; count]);
        Self { trees, leaders: (0..count).collect(), active: vec![true; count], is_whole: true, marks }
    }

    /// Joins the trees of these coordinates permanently.
    pub(crate) fn unite<'a>(&mut self, rows: impl IntoIterator<Item = &'a [(usize, f64)]>) {
        self.begin();
        for pair in rows.into_iter().flat_map(|row| row.windows(2)) {
            self.join(self.tree_of(pair[0].0), self.tree_of(pair[1].0));
        }
        let (mut numbers, mut count) = (vec![NONE; self.leaders.len()], 0);
        for tree in 0..numbers.len() {
            let leader = self.leader(tree);
            if leader == tree {
                numbers[tree] = count;
                count += 1;
            } else {
                numbers[tree] = numbers[leader];
            }
        }
        self.trees.iter_mut().for_each(|tree| *tree = numbers[*tree]);
        self.leaders.truncate(count);
        self.active.truncate(count);
        self.marks.iter_mut().for_each(|marks| marks.truncate(count));
        self.begin();
    }

    /// The number of trees.
    pub fn count(&self) -> usize {
        self.leaders.len()
    }

    /// The tree of a coordinate.
    #[inline]
    pub(crate) fn tree_of(&self, coordinate: usize) -> usize {
        self.trees[coordinate]
    }

    /// The tree of a row's coordinates; [`NONE`] without any.
    pub(crate) fn tree_of_row(&self, terms: &[(usize, f64)]) -> usize {
        terms.first().map_or(NONE, |(coordinate, _)| self.trees[*coordinate])
    }

    /// Starts a step: every tree is an unmarked component of its own, and moves.
    pub fn begin(&mut self) {
        self.leaders.iter_mut().enumerate().for_each(|(tree, leader)| *leader = tree);
        self.activate_all();
        self.marks.iter_mut().for_each(|marks| marks.fill(false));
    }

    /// The first tree of the component.
    #[inline]
    pub fn leader(&self, mut tree: usize) -> usize {
        while self.leaders[tree] != tree {
            tree = self.leaders[tree];
        }
        tree
    }

    /// The same, or the first of all for [`NONE`].
    pub(crate) fn leader_or_first(&self, tree: usize) -> usize {
        if tree == NONE { 0 } else { self.leader(tree) }
    }

    /// Joins the components of two trees. Returns false if they are the same. [`NONE`] is a fixed part.
    pub fn join(&mut self, one: usize, other: usize) -> bool {
        if one == NONE || other == NONE {
            return false;
        }
        let (a, b) = (self.leader(one), self.leader(other));
        let (first, second) = (a.min(b), a.max(b));
        // Shorten the chains.
        for tree in [second, one, other] {
            self.leaders[tree] = first;
        }
        for marks in &mut self.marks {
            marks[first] |= marks[second];
        }
        a != b
    }

    /// Joins all components.
    pub(crate) fn join_all(&mut self) {
        self.leaders.fill(0);
    }

    /// The first tree of each component.
    pub fn all(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.count()).filter(|tree| self.leaders[*tree] == *tree)
    }

    /// Whether there is only one component.
    pub(crate) fn is_one(&self) -> bool {
        self.all().count() <= 1
    }

    pub(crate) fn activate_all(&mut self) {
        self.active.fill(true);
        self.is_whole = true;
    }

    /// Lets only one component move, given by its first tree.
    pub(crate) fn activate_one(&mut self, leader: usize) {
        for tree in 0..self.count() {
            self.active[tree] = self.leader(tree) == leader;
        }
        self.is_whole = !self.active.contains(&false);
    }

    /// Lets only the components with this mark move, or only those without it. Returns whether there are any.
    pub(crate) fn activate_marked(&mut self, mark: Mark, is_marked: bool) -> bool {
        for tree in 0..self.count() {
            self.active[tree] = self.has(mark, tree) == is_marked;
        }
        self.is_whole = !self.active.contains(&false);
        self.active.contains(&true)
    }

    /// Whether all trees move.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Whether this tree moves. [`NONE`], a fixed part, counts as moving.
    #[inline]
    pub(crate) fn is_active(&self, tree: usize) -> bool {
        self.is_whole || tree == NONE || self.active[tree]
    }

    /// Whether this coordinate moves.
    #[inline]
    pub fn moves(&self, coordinate: usize) -> bool {
        self.is_whole || self.active[self.trees[coordinate]]
    }

    /// Removes the marks of the search for contacts from all trees, and those that follow from it.
    pub(crate) fn clear_found(&mut self) {
        for mark in [Mark::Meets, Mark::Touched, Mark::Deep, Mark::Hit] {
            self.clear(mark);
        }
    }

    /// Removes this mark from all trees.
    pub fn clear(&mut self, mark: Mark) {
        self.marks[mark as usize].fill(false);
    }

    /// Marks the component of this tree.
    pub fn set(&mut self, mark: Mark, tree: usize) {
        if tree != NONE {
            let leader = self.leader(tree);
            self.marks[mark as usize][leader] = true;
        }
    }

    /// Whether the component of this tree is marked.
    pub fn has(&self, mark: Mark, tree: usize) -> bool {
        tree != NONE && self.marks[mark as usize][self.leader(tree)]
    }

    /// Whether some component is marked.
    pub(crate) fn has_any(&self, mark: Mark) -> bool {
        self.marks[mark as usize].contains(&true)
    }
}

/// The floating body that carries this body, or [`WORLD`].
pub(super) fn floating_part(model: &Model, mut body: usize) -> usize {
    while body != WORLD && model.bodies[body].motion.nv() < 6 {
        body = model.bodies[body].parent;
    }
    body
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::factorization::sparse::NONE;

    use super::{Components, Mark};

    /// Two chains and two single degrees of freedom; a row joins one of these with the second chain.
    fn example() -> Components {
        let mut components = Components::new(&[NONE, 0, NONE, 2, NONE, NONE]);
        assert_eq!(components.count(), 4);
        components.unite([&[(3, 1.0), (5, -1.0)][..], &[]]);
        components
    }

    #[test]
    fn rows_join_trees_for_good() {
        let mut components = example();
        let trees = |components: &Components| [0, 1, 2, 3, 4, 5].map(|k| components.tree_of(k));
        assert_eq!(trees(&components), [0, 0, 1, 1, 2, 1]);
        components.begin();
        assert_eq!(components.all().collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn a_mark_is_that_of_a_whole_component() {
        let mut components = example();
        components.set(Mark::Meets, 2);
        assert!(components.join(1, 2) && !components.join(2, 1) && !components.join(NONE, 0));
        assert!([1, 2].iter().all(|tree| components.has(Mark::Meets, *tree)));
        assert!(!components.has(Mark::Meets, 0) && !components.has(Mark::Touched, 1));
        assert!(!components.has(Mark::Meets, NONE));
        components.clear(Mark::Meets);
        assert!(!components.has_any(Mark::Meets));
    }

    #[test]
    fn components_move_alone() {
        let mut components = example();
        components.join(0, 2);
        components.activate_one(0);
        assert!(!components.is_whole());
        assert_eq!([0, 2, 4].map(|k| components.moves(k)), [true, false, true]);
        assert!(components.is_active(NONE) && !components.is_active(1));
        assert!(
            !components.activate_marked(Mark::Meets, true) && components.activate_marked(Mark::Meets, false)
        );
        assert!(components.is_whole());
        components.set(Mark::Meets, 1);
        assert!(components.activate_marked(Mark::Meets, false) && !components.is_active(1));
        components.activate_all();
        assert!(components.is_whole() && components.moves(2) && !components.is_one());
        components.join_all();
        assert!(components.is_one());
    }
}
