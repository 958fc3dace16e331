//! The state at the start of a step, and its restoration.

use core::ops::Range;

use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::configuration::manifold::{CoordinateRange, coordinate_ranges};
use robot_dynamics_core::joint::Chart;

use super::{ImplicitIntegrator, equalities, impulses};
use crate::contact::{Components, ContactMemory};
use crate::motion::simulate::Losses;

clone_in_place! {
    /// The state at the start of a step.
    #[derive(Debug)]
    pub(super) struct StepSnapshot {
        pub(super) q: Vec<f64>,
        pub(super) v: Vec<f64>,
        /// The highest speed of a coordinate since then, for each tree.
        pub(super) fastest: Vec<f64>,
        /// Whether a stop or contact was met or corrected since then, for each tree.
        pub(super) is_rough: Vec<bool>,
        pub(super) impulses: impulses::Remembered,
        pub(super) contacts: Option<ContactMemory>,
        pub(super) equalities: Option<equalities::Remembered>,
    }
}

impl StepSnapshot {
    pub(super) fn new(model: &Model, trees: usize, impulses: impulses::Remembered) -> Self {
        Self {
            q: vec![0.0; model.nq],
            v: vec![0.0; model.nv],
            fastest: vec![0.0; trees],
            is_rough: vec![false; trees],
            impulses,
            contacts: None,
            equalities: None,
        }
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.q.copy_from_slice(&other.q);
        self.v.copy_from_slice(&other.v);
        self.fastest.copy_from_slice(&other.fastest);
        self.is_rough.copy_from_slice(&other.is_rough);
        self.impulses.copy_from(&other.impulses);
        if let (Some(own), Some(other)) = (&mut self.equalities, &other.equalities) {
            own.copy_from(other);
        }
        if let (Some(own), Some(other)) = (&mut self.contacts, &other.contacts) {
            own.copy_from(other);
        }
    }

    /// Records the speeds of a state after a part of the step, for the active trees.
    pub(super) fn record_speeds(&mut self, components: &Components, v: &[f64]) {
        for (k, v) in v.iter().enumerate().filter(|(k, _)| components.moves(*k)) {
            let fastest = &mut self.fastest[components.tree_of(k)];
            *fastest = fastest.max(v.abs());
        }
    }
}

impl ImplicitIntegrator {
    /// Resizes the memory for trees after some were joined.
    pub(super) fn resize_trees(&mut self) {
        let Self { components, kept, start, pivots, is_off, lost, last_of, .. } = self;
        let trees = components.count().max(1);
        for kept in [kept, start] {
            kept.fastest.truncate(trees);
            kept.is_rough.truncate(trees);
        }
        pivots.truncate(trees);
        is_off.truncate(trees);
        lost.truncate(trees);
        last_of.truncate(trees);
    }

    /// Stores a state with its forces, and restarts the energy account of the active trees.
    pub(super) fn keep(&mut self, q: &[f64], v: &[f64]) {
        let Self { components, last_of, kept, .. } = self;
        for (tree, last) in last_of.iter_mut().enumerate() {
            if components.is_active(tree) {
                *last = Losses::default();
            }
        }
        kept.q.copy_from_slice(q);
        kept.v.copy_from_slice(v);
        kept.fastest.fill(0.0);
        kept.is_rough.fill(false);
        kept.record_speeds(components, v);
        kept.impulses.copy_from(self.impulses.memory());
        if let (Some(kept), Some(equalities)) = (&mut kept.equalities, &mut self.equalities) {
            kept.copy_from(equalities.memory());
        }
        if let (Some(kept), Some(contacts)) = (&mut kept.contacts, &mut self.contacts) {
            kept.copy_from(contacts.memory());
        }
    }

    /// Restores the stored state.
    pub(super) fn take_back(&mut self, q: &mut [f64], v: &mut [f64]) {
        q.copy_from_slice(&self.kept.q);
        v.copy_from_slice(&self.kept.v);
        self.impulses.memory().copy_from(&self.kept.impulses);
        if let (Some(kept), Some(equalities)) = (&self.kept.equalities, &mut self.equalities) {
            equalities.memory().copy_from(kept);
        }
        if let (Some(kept), Some(contacts)) = (&self.kept.contacts, &mut self.contacts) {
            contacts.memory().copy_from(kept);
        }
    }

    /// Restores the start of the whole step for the active trees.
    pub(super) fn take_back_active(&mut self, model: &Model, q: &mut [f64], v: &mut [f64]) {
        let Self { components, start, impulses, equalities, contacts, .. } = self;
        copy_active(model, components, (&start.q, &start.v), (q, v));
        impulses.take_back_active(&start.impulses, components);
        if let (Some(start), Some(equalities)) = (&start.equalities, equalities) {
            equalities.take_back_active(start, components);
        }
        if let (Some(start), Some(contacts)) = (&start.contacts, contacts) {
            contacts.take_back_active(start, components);
        }
    }
}

/// Copies a state for the active trees.
pub(super) fn copy_active(
    model: &Model,
    components: &Components,
    (q0, v0): (&[f64], &[f64]),
    (q, v): (&mut [f64], &mut [f64]),
) {
    if components.is_whole() {
        q.copy_from_slice(q0);
        v.copy_from_slice(v0);
        return;
    }
    copy_positions(model, |mut own| own.any(|k| components.moves(k)), q0, q);
    for k in (0..v.len()).filter(|k| components.moves(*k)) {
        v[k] = v0[k];
    }
}

/// Copies the positions of the joints whose coordinates in v satisfy `are_such`.
pub(super) fn copy_positions(
    model: &Model,
    are_such: impl Fn(Range<usize>) -> bool,
    from: &[f64],
    to: &mut [f64],
) {
    for CoordinateRange { chart, q, v } in coordinate_ranges(model) {
        let (positions, rates) = match chart {
            Chart::Line => (1, 1),
            Chart::Rotation => (4, 3),
            Chart::Placement => (7, 6),
        };
        if are_such(v..v + rates) {
            to[q..q + positions].copy_from_slice(&from[q..q + positions]);
        }
    }
}
