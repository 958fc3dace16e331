//! Storing and restoring the state at the start of a step.

use core::ops::Range;

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::manifold::{CoordinateRange, coordinate_ranges};
use robot_dynamics_core::joint::Chart;

use super::ImplicitIntegrator;
use crate::contact::Components;
use crate::motion::simulate::Losses;

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
    pub(super) fn store_state(&mut self, q: &[f64], v: &[f64]) {
        let Self { components, last_of, kept, record, .. } = self;
        for (tree, last) in last_of.iter_mut().enumerate() {
            if components.is_active(tree) {
                *last = Losses::default();
            }
        }
        kept.q.copy_from_slice(q);
        kept.v.copy_from_slice(v);
        kept.fastest.fill(0.0);
        kept.is_rough.fill(false);
        kept.passes = record.parts.len();
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
        self.record.parts.truncate(self.kept.passes);
        self.impulses.memory().copy_from(&self.kept.impulses);
        if let (Some(kept), Some(equalities)) = (&self.kept.equalities, &mut self.equalities) {
            equalities.memory().copy_from(kept);
        }
        if let (Some(kept), Some(contacts)) = (&self.kept.contacts, &mut self.contacts) {
            contacts.memory().copy_from(kept);
        }
    }

    /// Restores the start of the whole step for the active trees.
    pub(super) fn restore_active(&mut self, model: &Model, q: &mut [f64], v: &mut [f64]) {
        let Self { components, start, impulses, equalities, contacts, .. } = self;
        copy_active(model, components, (&start.q, &start.v), (q, v));
        impulses.restore_active(&start.impulses, components);
        if let (Some(start), Some(equalities)) = (&start.equalities, equalities) {
            equalities.restore_active(start, components);
        }
        if let (Some(start), Some(contacts)) = (&start.contacts, contacts) {
            contacts.restore_active(start, components);
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
