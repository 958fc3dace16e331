//! Repetition of steps in shorter parts if their energy balance fails.
//!
//! M(q) loses rank where axes of joints become parallel, such as the outer two of three hinges in place of a
//! ball joint at 90°. Near such a configuration M changes over a thousandth of a radian, and a joint can
//! reverse at a stop there. A step of fixed length does not resolve this and gains energy. Such a step is
//! halved recursively until the energy balance of each part holds. Away from the singularity the parts become
//! longer again.

use robot_dynamics_core::Model;
use robot_dynamics_core::model::Body;
use robot_dynamics_integrators::{EnergyAccount, IntegratorError};

use super::ImplicitIntegrator;
use super::advance::{ImpactPolicy, PARTS};
use super::restoration::copy_positions;
use crate::contact::{Components, ContactImpulses};
use crate::motion::simulate::Losses;
use crate::motion::step_actuation::{record, stored_energy};
use crate::{StateTransition, StepForces, StepWorkspace, energy_account};

/// A step in which no coordinate moves further than this needs no check \[rad or m\].
pub(super) const FAR: f64 = 0.1;

/// A step in which every pivot of M̂ exceeds this fraction of M's diagonal needs no check.
pub(super) const SMALL: f64 = 1e-3;

/// The allowed error of a step's energy balance, relative to the kinetic energy plus that of all joints at
/// the speed `SLOW`.
const OFF: f64 = 1e-3;

/// The reference speed \[rad/s or m/s\].
const SLOW: f64 = 0.01;

/// The rounding error of the potential energy, relative to it.
const ROUNDING: f64 = 1e-12;

/// The largest number of parts of a step, the number up to which the limit of work does not apply, and that
/// limit. The work of a part is its number of coordinates and rows of contacts. Without limits, a step that
/// starts in a deep penetration, or whose M is singular throughout, would be divided endlessly.
const MOST_PARTS: usize = 4096;
const LEAST_PARTS: usize = 64;
const MOST_WORK: usize = 2_000_000;

/// The shortest part of a step.
const SHORTEST: f64 = 1.0 / (1 << 24) as f64;

impl ImplicitIntegrator {
    /// Whether the energy balance of the component with this first tree fails. The step of h, in parts of
    /// this length, leads from the kept state to this one.
    pub(super) fn is_energy_unbalanced(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        (h, part): (f64, f64),
        leader: usize,
        to: (&[f64], &[f64]),
    ) -> bool {
        let (imbalance, most) = self.imbalance(model, workspace, forces, (h, part), leader, to);
        imbalance.abs() > most || !imbalance.is_finite()
    }

    /// The error of the energy balance of such a step, and its tolerance, for the motion of this component
    /// while all others are at rest.
    fn imbalance(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        (h, part): (f64, f64),
        leader: usize,
        to: (&[f64], &[f64]),
    ) -> (f64, f64) {
        let Self { components, factor, kept, drive, contacts, last_of, alone, gravity, .. } = self;
        let is_own = |tree: usize| components.leader(tree) == leader;
        let moves = |k: usize| is_own(components.tree_of(k));
        let mut last = Losses::default();
        let mut fastest = 0.0_f64;
        for tree in (0..components.count()).filter(|tree| is_own(*tree)) {
            last.add(&last_of[tree]);
            fastest = fastest.max(kept.fastest[tree]);
        }
        let (mut from, mut to) = ((&kept.q[..], &kept.v[..]), to);
        if !components.is_one() {
            let [q1, v0, v1] = alone;
            q1.copy_from_slice(from.0);
            copy_positions(model, |mut own| own.any(moves), to.0, q1);
            for k in 0..v0.len() {
                (v0[k], v1[k]) = if moves(k) { (from.1[k], to.1[k]) } else { (0.0, 0.0) };
            }
            (from, to) = ((from.0, &v0[..]), (&q1[..], &v1[..]));
        }
        let start = energy_account(model, &mut workspace.dynamics, from.0, from.1);
        let stored = stored_energy(drive, from.0);
        let mut energy_account = EnergyAccount::new(start.kinetic(), start.potential() + stored);
        let losses = (&mut last, &mut Losses::default());
        record(model, workspace, &mut energy_account, StateTransition { from, to, forces, h }, drive, losses);
        let slow = 0.5 * SLOW * SLOW * factor.mass_trace(moves);
        // The correction of the penetration in an impact lifts the weight.
        let weight = if contacts.is_some() { moving_mass(model, components, leader) * *gravity } else { 0.0 };
        let lift = weight * fastest * part;
        let most = OFF * (start.kinetic() + energy_account.kinetic() + slow)
            + ROUNDING * start.potential().abs()
            + lift;
        (energy_account.imbalance(), most)
    }

    /// Takes a step of h from this state in parts, for the one active component.
    pub(super) fn step_in_parts(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        let mut total = Losses::default();
        let (mut done, mut part, mut work, mut tried) = (0.0, 0.5, 0, 0);
        let components = &self.components;
        let leader = (0..components.count()).find(|tree| components.is_active(*tree)).unwrap_or(0);
        let coordinates = (0..v.len()).filter(|k| components.moves(*k)).count();
        while done < 1.0 {
            self.check_interrupt()?;
            tried += 1;
            work += coordinates + 3 * self.contacts.as_ref().map_or(0, ContactImpulses::count);
            if tried > MOST_PARTS || (tried > LEAST_PARTS && work > MOST_WORK) {
                self.finish_step(model, workspace, forces, (1.0 - done) * h, leader, (q, v))?;
                self.add_losses(&mut total);
                break;
            }
            self.store_state(q, v);
            let taken = self.advance(
                model,
                &mut workspace.dynamics,
                forces.tau,
                part * h,
                (q, v),
                ImpactPolicy::AcceptStep,
            );
            let is_shortest = part <= SHORTEST;
            let is_good = match taken {
                Ok(_) => {
                    let lengths = (part * h, part * h);
                    is_shortest
                        || !self.is_energy_unbalanced(model, workspace, forces, lengths, leader, (q, v))
                }
                Err(error) if is_shortest => return Err(error),
                Err(_) => false,
            };
            if !is_good {
                self.take_back(q, v);
                part *= 0.5;
                continue;
            }
            self.add_losses(&mut total);
            done += part;
            // Double the part if a longer part can start here.
            if part < 0.5 && (done / (2.0 * part)).fract() == 0.0 {
                part *= 2.0;
            }
        }
        let components = &self.components;
        for (tree, last) in
            self.last_of.iter_mut().enumerate().filter(|(tree, _)| components.is_active(*tree))
        {
            *last = if tree == leader { total } else { Losses::default() };
        }
        Ok(())
    }

    /// Adds the losses of the active trees since the kept state.
    fn add_losses(&self, total: &mut Losses) {
        for (_, last) in self.last_of.iter().enumerate().filter(|(tree, _)| self.components.is_active(*tree))
        {
            total.add(last);
        }
    }

    /// Takes the rest of a step in a few parts, and records the error of its energy balance.
    fn finish_step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        leader: usize,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        self.store_state(q, v);
        let part = h / f64::from(PARTS);
        for _ in 0..PARTS {
            self.advance(model, &mut workspace.dynamics, forces.tau, part, (q, v), ImpactPolicy::AcceptStep)?;
        }
        let (imbalance, _) = self.imbalance(model, workspace, forces, (h, part), leader, (q, v));
        self.unsettled = (self.unsettled.0 + 1, self.unsettled.1.max(imbalance.abs()));
        Ok(())
    }
}

/// The total mass of the component with this first tree.
fn moving_mass(model: &Model, components: &Components, leader: usize) -> f64 {
    let is_own = |body: &&Body| {
        let first = model.dofs[body.dof].coordinate;
        components.leader(components.tree_of(first)) == leader
    };
    // An empty sum is −0.
    model.bodies.iter().filter(is_own).map(|body| body.mass).sum::<f64>() + 0.0
}
