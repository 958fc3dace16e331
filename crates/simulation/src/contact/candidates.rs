//! The shapes that may touch each other, and those near each other.

use std::collections::{BTreeSet, HashMap};

use nalgebra::Vector3;
use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::model::WORLD;

use super::contact_shape::ContactShape;

clone_in_place! {
    /// The shapes that may touch each other by their file, without named pairs.
    #[derive(Debug)]
    pub(super) struct Candidates {
        /// One entry for each shape: the number of its link, the body that carries it, and whether a joint
        /// connects it to that.
        pub(super) links: Vec<usize>,
        pub(super) carriers: Vec<usize>,
        pub(super) hangs: Vec<bool>,
        /// Whether it is fixed to the world itself, on a massless root link, and not to a link that a robot
        /// is mounted on.
        pub(super) is_scenery: Vec<bool>,
        /// The numbers of links that do not touch, in both orders.
        pub(super) excluded: BTreeSet<[usize; 2]>,
        /// The numbers of links that alone may touch, in both orders; `None`: all.
        pub(super) only: Option<BTreeSet<[usize; 2]>>,
        /// Pairs of shapes that do not touch, in increasing order.
        pub(super) left_out: BTreeSet<[usize; 2]>,
    }
}

impl Candidates {
    pub(super) fn new(model: &Model, shapes: &[ContactShape], carriers: Vec<usize>) -> Self {
        let mut numbers = HashMap::new();
        let mut number = |link: &str| {
            let next = numbers.len();
            *numbers.entry(link.to_owned()).or_insert(next)
        };
        let links = shapes.iter().map(|shape| number(&shape.link)).collect();
        let excluded = model.description().contact_exclusions.iter();
        let excluded = excluded.flat_map(|(a, b)| {
            let [a, b] = [number(a), number(b)];
            [[a, b], [b, a]]
        });
        let excluded = excluded.collect();
        // No body carries a floating body.
        let hangs = |body: usize| body != WORLD && model.bodies[body].motion.nv() < 6;
        let hangs = shapes.iter().map(|shape| hangs(shape.body)).collect();
        let is_scenery = shapes.iter().map(|shape| is_scenery(model, shape)).collect();
        Self { links, carriers, hangs, is_scenery, excluded, only: None, left_out: BTreeSet::new() }
    }

    /// Removes a pair of shapes, in increasing order.
    pub(super) fn leave_out(&mut self, shapes: [usize; 2]) {
        self.left_out.insert(shapes);
    }

    /// The number of a shape's link.
    pub(super) fn link(&self, shape: usize) -> usize {
        self.links[shape]
    }

    /// Removes pairs of links, given in both orders.
    pub(super) fn exclude(&mut self, links: Vec<[usize; 2]>) {
        self.excluded.extend(links);
    }

    /// Keeps only these pairs of links, given in both orders.
    pub(super) fn keep_only(&mut self, links: Vec<[usize; 2]>) {
        self.only = Some(links.into_iter().collect());
    }

    /// Removes the pairs of two shapes' links.
    pub(super) fn exclude_links(&mut self, [one, two]: [usize; 2]) {
        let [a, b] = [self.links[one], self.links[two]];
        self.excluded.extend([[a, b], [b, a]]);
    }
}

clone_in_place! {
    /// The shapes and pairs near each other at the last search.
    #[derive(Debug, Default)]
    pub(super) struct Sweep {
        /// The pairs made so far, by their numbers.
        pub(super) slots: HashMap<usize, usize>,
        /// The number of named pairs so far.
        pub(super) named: usize,
        /// The shapes by the lower ends of their ranges along an axis.
        pub(super) order: Vec<usize>,
        pub(super) centers: Vec<Vector3<f64>>,
        /// The numbers of the near pairs in increasing order, and their indices among the set's pairs.
        pub(super) found: Vec<(usize, [usize; 2])>,
        pub(super) near: Vec<usize>,
    }
}

impl Sweep {
    /// The index of the pair with this number.
    pub(super) fn slot_of(&self, number: usize) -> Option<usize> {
        self.slots.get(&number).copied()
    }

    /// The pairs that are near each other, in the order of their numbers.
    pub(super) fn near(&self) -> &[usize] {
        &self.near
    }
}

/// Whether a shape is fixed to the world itself: as in MJCF, such shapes touch links that joints connect to
/// the world.
fn is_scenery(model: &Model, shape: &ContactShape) -> bool {
    let description = model.description();
    let is_child = description.joints.iter().any(|joint| joint.child == shape.link);
    let link = description.links.iter().find(|link| link.name == shape.link);
    shape.body == WORLD && !is_child && link.is_some_and(|link| link.mass_properties.is_none())
}
