//! A step of all components: as a whole where it can be, in parts where something is met or the energy balance does not close.
//!
//! Only the components that meet something move in parts, beside the others, which keep their one whole step. Contacts between the two
//! kinds are not looked at meanwhile; if some are in each other at the end, they are one component and the step is taken again.

use dynamics::IntegratorError;

use super::Implicit;
use super::advance::{PARTS, Whole};
use super::divided::{FAR, SMALL};
use super::equalities::Equalities;
use crate::contact::Mark;
use crate::motion::simulate::Losses;
use crate::{Model, StepForces, StepWorkspace};

/// Each trial leaves of the error of the first forces a part of order h.
const TRIALS: usize = 3;

/// A step is taken so often with components that are in each other at its end made one; then all are one.
const MOST_JOINS: usize = 4;

impl Implicit {
    /// A step of h, in parts where it has to be.
    pub(super) fn step_whole(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        self.components.begin();
        if let Some(contacts) = &mut self.contacts {
            contacts.begin_whole();
            contacts.memory().clear_impulses();
        }
        if let Some(equalities) = &mut self.equalities {
            equalities.clear_impulses();
        }
        self.keep(q, v);
        self.try_equalities(model, workspace, forces, h, (q, v));
        if self.components.count() > 1 {
            self.start.copy_from(&self.kept);
        }
        for joins in 0.. {
            if !self.step_components(model, workspace, forces, h, (q, v))? {
                break;
            }
            self.components.activate_all();
            let Some(contacts) = &mut self.contacts else { break };
            contacts.restrict(&self.components);
            if !contacts.join_what_crosses(model, &mut workspace.dynamics, q, &mut self.components) {
                break;
            }
            if joins == MOST_JOINS {
                self.components.join_all();
            }
            self.start_again(q, v);
        }
        if let Some(contacts) = &mut self.contacts {
            contacts.memory().average_impulses(h);
        }
        if let Some(equalities) = &mut self.equalities {
            equalities.average_impulses(h);
        }
        self.last = Losses::default();
        self.last_of.iter().for_each(|last| self.last.add(last));
        Ok(())
    }

    /// Goes back to where the whole step began.
    fn start_again(&mut self, q: &mut [f64], v: &mut [f64]) {
        self.components.activate_all();
        if let Some(contacts) = &mut self.contacts {
            contacts.begin_whole();
        }
        if self.components.count() > 1 {
            self.kept.copy_from(&self.start);
        }
        self.take_back(q, v);
        self.keep(q, v);
    }

    /// A step of h of each component; whether some moved without others.
    fn step_components(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<bool, IntegratorError> {
        let advanced = self.advance_components(model, workspace, forces.tau, h, (q, v));
        self.check_interrupt()?;
        let Ok(mut is_apart) = advanced else {
            // It is not known whose numbers were none.
            self.components.join_all();
            self.start_again(q, v);
            self.divide(model, workspace, forces, h, (q, v))?;
            return Ok(false);
        };
        // All are looked at before one of them goes back.
        self.mark_suspects(h);
        for leader in 0..self.components.count() {
            self.is_off[leader] = self.components.leader(leader) == leader
                && self.components.has(Mark::Suspect, leader)
                && self.books_are_off(model, workspace, forces, (h, h / f64::from(PARTS)), leader, (q, v));
        }
        for leader in 0..self.components.count() {
            if !self.is_off[leader] {
                continue;
            }
            self.components.activate_one(leader);
            if self.components.is_whole() {
                self.take_back(q, v);
            } else {
                is_apart = true;
                self.restrict_contacts();
                self.take_back_active(model, q, v);
            }
            self.divide(model, workspace, forces, h, (q, v))?;
        }
        Ok(is_apart)
    }

    /// A step of h, in so many parts for the components that meet something; whether these moved without others.
    fn advance_components(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        tau: &[f64],
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<bool, IntegratorError> {
        let dynamics = &mut workspace.dynamics;
        if self.advance(model, dynamics, tau, h, (q, v), Whole::OrNothing)? {
            self.note_pivots();
            return Ok(false);
        }
        let is_apart = !self.components.is_whole();
        if is_apart {
            self.note_pivots();
            self.components.activate_marked(Mark::Meets, true);
            self.restrict_contacts();
        }
        for (tree, is_rough) in self.kept.is_rough.iter_mut().enumerate() {
            *is_rough |= self.components.is_active(tree);
        }
        for _ in 0..PARTS {
            self.advance(model, dynamics, tau, h / f64::from(PARTS), (q, v), Whole::AsItIs)?;
        }
        self.note_pivots();
        Ok(is_apart)
    }

    /// Marks the components whose energy balance should be checked after a step of h.
    fn mark_suspects(&mut self, h: f64) {
        let Self { components, kept, pivots, .. } = self;
        components.clear(Mark::Suspect);
        for tree in 0..components.count() {
            if kept.is_rough[tree] || h * kept.fastest[tree] > FAR || pivots[tree] < SMALL {
                components.set(Mark::Suspect, tree);
            }
        }
    }

    /// Keeps the least pivots of the trees that move.
    fn note_pivots(&mut self) {
        let Self { components, factor, pivots, .. } = self;
        for (tree, pivot) in pivots.iter_mut().enumerate() {
            if components.is_active(tree) {
                *pivot = f64::INFINITY;
            }
        }
        for (k, pivot) in factor.pivots().enumerate().filter(|(k, _)| components.moves(*k)) {
            let least = &mut pivots[components.tree_of(k)];
            *least = pivot.min(*least);
        }
    }

    /// Gives the contacts of the components that move their turn.
    fn restrict_contacts(&mut self) {
        if let Some(contacts) = &mut self.contacts {
            contacts.restrict(&self.components);
        }
    }

    /// Before the first step of all, finds the forces of the equalities with which it begins: a step that begins without them is off by what they do to
    /// light links.
    fn try_equalities(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) {
        if self.equalities.as_ref().is_none_or(Equalities::is_begun) {
            return;
        }
        for _ in 0..TRIALS {
            let taken = self.advance(model, &mut workspace.dynamics, forces.tau, h, (q, v), Whole::AsItIs);
            if let (true, Some(equalities)) = (taken.is_ok(), &mut self.equalities) {
                equalities.note_trial();
            }
            self.take_back(q, v);
            if let Some(equalities) = &mut self.equalities {
                equalities.begin_with_trial();
            }
        }
        self.keep(q, v);
    }
}
