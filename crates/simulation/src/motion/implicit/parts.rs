//! A step of all components: whole if possible, and in parts after an impact or if the energy balance fails.
//!
//! Only the components with an impact move in parts; the others keep their whole step. Contacts between the
//! two groups are not detected during the parts. If bodies of both groups penetrate at the end, their
//! components are joined and the step is repeated.

use robot_dynamics_core::Model;
use robot_dynamics_integrators::IntegratorError;

use super::ImplicitIntegrator;
use super::advance::{ImpactPolicy, PARTS};
use super::equalities::Equalities;
use super::step_division::{FAR, SMALL};
use crate::contact::Mark;
use crate::motion::simulate::Losses;
use crate::{StepForces, StepWorkspace};

/// The number of trials; each one reduces the error of the initial forces by a factor of order h.
const TRIALS: usize = 3;

/// The number of repetitions of a step with joined components; then all are joined.
const MOST_JOINS: usize = 4;

impl ImplicitIntegrator {
    /// Takes a step of h, in parts if necessary.
    pub(super) fn step_whole(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        self.begin_whole(model, workspace, forces, h, (q, v));
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
            self.restore_start(q, v);
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

    /// Begins a step of h of all components: stores its start, and finds the first forces of equalities.
    pub(super) fn begin_whole(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) {
        self.components.begin();
        if let Some(contacts) = &mut self.contacts {
            contacts.begin_whole();
            contacts.memory().clear_impulses();
        }
        if let Some(equalities) = &mut self.equalities {
            equalities.clear_impulses();
        }
        self.store_state(q, v);
        self.initialize_equalities(model, workspace, forces, h, (q, v));
    }

    /// Restores the start of the whole step.
    fn restore_start(&mut self, q: &mut [f64], v: &mut [f64]) {
        self.components.activate_all();
        if let Some(contacts) = &mut self.contacts {
            contacts.begin_whole();
        }
        if self.components.count() > 1 {
            self.kept.copy_from(&self.start);
        }
        self.take_back(q, v);
        self.store_state(q, v);
    }

    /// Takes a step of h of each component; returns whether some moved separately.
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
            // The component with the invalid number is unknown.
            self.components.join_all();
            self.restore_start(q, v);
            self.step_in_parts(model, workspace, forces, h, (q, v))?;
            return Ok(false);
        };
        // Check all components before restoring any of them.
        self.mark_for_check(h);
        for leader in 0..self.components.count() {
            self.is_off[leader] = self.components.leader(leader) == leader
                && self.components.has(Mark::Suspect, leader)
                && self.is_energy_unbalanced(
                    model,
                    workspace,
                    forces,
                    (h, h / f64::from(PARTS)),
                    leader,
                    (q, v),
                );
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
                self.restore_active(model, q, v);
            }
            self.step_in_parts(model, workspace, forces, h, (q, v))?;
        }
        Ok(is_apart)
    }

    /// Takes a step of h, with the components that have an impact in parts; returns whether these moved
    /// separately.
    fn advance_components(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        tau: &[f64],
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<bool, IntegratorError> {
        let dynamics = &mut workspace.dynamics;
        if self.advance(model, dynamics, tau, h, (q, v), ImpactPolicy::RejectStep)? {
            self.record_pivots();
            return Ok(false);
        }
        let is_apart = !self.components.is_whole();
        if is_apart {
            self.record_pivots();
            self.components.activate_marked(Mark::Meets, true);
            self.restrict_contacts();
        }
        for (tree, is_rough) in self.kept.is_rough.iter_mut().enumerate() {
            *is_rough |= self.components.is_active(tree);
        }
        for _ in 0..PARTS {
            self.advance(model, dynamics, tau, h / f64::from(PARTS), (q, v), ImpactPolicy::AcceptStep)?;
        }
        self.record_pivots();
        Ok(is_apart)
    }

    /// Marks the components whose energy balance should be checked after a step of h.
    fn mark_for_check(&mut self, h: f64) {
        let Self { components, kept, pivots, .. } = self;
        components.clear(Mark::Suspect);
        for tree in 0..components.count() {
            if kept.is_rough[tree] || h * kept.fastest[tree] > FAR || pivots[tree] < SMALL {
                components.set(Mark::Suspect, tree);
            }
        }
    }

    /// Records the least pivots of the active trees.
    fn record_pivots(&mut self) {
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

    /// Selects the contacts of the active components.
    fn restrict_contacts(&mut self) {
        if let Some(contacts) = &mut self.contacts {
            contacts.restrict(&self.components);
        }
    }

    /// Finds the forces of the equalities before the first step. Without them the first step would accelerate
    /// light links wrongly.
    fn initialize_equalities(
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
            let taken =
                self.advance(model, &mut workspace.dynamics, forces.tau, h, (q, v), ImpactPolicy::AcceptStep);
            if let (true, Some(equalities)) = (taken.is_ok(), &mut self.equalities) {
                equalities.record_trial();
            }
            self.take_back(q, v);
            if let Some(equalities) = &mut self.equalities {
                equalities.begin_with_trial();
            }
        }
        self.store_state(q, v);
    }
}
