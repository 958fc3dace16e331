//! The state at the start of a step.

use robot_dynamics_core::Model;
use robot_dynamics_core::clone_in_place::clone_in_place;

use super::{equalities, impulses};
use crate::contact::{Components, ContactMemory};

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
        /// The number of recorded passes of the step before this state.
        pub(super) passes: usize,
        pub(super) impulses: impulses::ImpulseMemory,
        pub(super) contacts: Option<ContactMemory>,
        pub(super) equalities: Option<equalities::EqualityMemory>,
    }
}

impl StepSnapshot {
    pub(super) fn new(model: &Model, trees: usize, impulses: impulses::ImpulseMemory) -> Self {
        Self {
            q: vec![0.0; model.nq],
            v: vec![0.0; model.nv],
            fastest: vec![0.0; trees],
            is_rough: vec![false; trees],
            passes: 0,
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
        self.passes = other.passes;
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
