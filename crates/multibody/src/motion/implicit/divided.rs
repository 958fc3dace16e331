//! Steps taken again in shorter parts where their books do not close.
//!
//! Where axes of joints become parallel, as the outer two of three hinges that stand for a ball do at 90°, M(q) loses its rank, and a
//! thousandth of a radian on it is another matrix; with a stop there the joints turn back at it. A step of fixed length does not see
//! that, and ends with energy from nowhere. Such a step is halved, and its halves again, until their books close; next to the place
//! the parts are long again.

use dynamics::{EnergyLedger, IntegratorError};

use super::Implicit;
use super::advance::{PARTS, Whole};
use super::kept::copy_positions;
use crate::contact::{Components, ContactImpulses};
use crate::model::Body;
use crate::motion::drive::record;
use crate::motion::simulate::Losses;
use crate::{Model, StepForces, StepWorkspace, energy_ledger};

/// A step in which no coordinate goes further looks harmless \[rad or m\].
pub(super) const FAR: f64 = 0.1;

/// So does one in which no pivot of M̂ is below this part of M's diagonal.
pub(super) const SMALL: f64 = 1e-3;

/// The most that a step's books may be off, in parts of the kinetic energy, or of what the joints would have at a speed of `SLOW`.
const OFF: f64 = 1e-3;

/// \[rad/s or m/s\]
const SLOW: f64 = 0.01;

/// Roundings of the potential energy, in parts of it.
const ROUNDING: f64 = 1e-12;

/// The most parts of a step that are tried, the least, and how much they cost together: each as much as it has coordinates and rows of contacts. A step that starts
/// in the ground in an odd pose, or whose M is singular all along, would else be divided without end.
const MOST_PARTS: usize = 4096;
const LEAST_PARTS: usize = 64;
const MOST_WORK: usize = 2_000_000;

/// The shortest part of a step.
const SHORTEST: f64 = 1.0 / (1 << 24) as f64;

impl Implicit {
    /// Whether a step of h, in parts of this length, that led from the kept state to this one has an energy balance that does not close, for the component
    /// with this first tree.
    pub(super) fn books_are_off(
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

    /// The energy that the balance of such a step misses, and the most that it may: that of a motion in which all other components stand still.
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
        let start = energy_ledger(model, &mut workspace.dynamics, from.0, from.1);
        let stored = drive.as_mut().map_or(0.0, |drive| drive.stored_energy(from.0));
        let mut ledger = EnergyLedger::new(start.kinetic(), start.potential() + stored);
        let books = (&mut last, &mut Losses::default());
        record(model, workspace, &mut ledger, [from, to], (forces, h), drive, books);
        let slow = 0.5 * SLOW * SLOW * factor.mass_trace(moves);
        // What sank into the ground in an impact is lifted out of it.
        let weight = if contacts.is_some() { moving_mass(model, components, leader) * *gravity } else { 0.0 };
        let lift = weight * fastest * part;
        let most =
            OFF * (start.kinetic() + ledger.kinetic() + slow) + ROUNDING * start.potential().abs() + lift;
        (ledger.imbalance(), most)
    }

    /// The step of h from this state, in parts, for the one component that moves.
    pub(super) fn divide(
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
                self.take_rest(model, workspace, forces, (1.0 - done) * h, leader, (q, v))?;
                self.add_losses(&mut total);
                break;
            }
            self.keep(q, v);
            let taken =
                self.advance(model, &mut workspace.dynamics, forces.tau, part * h, (q, v), Whole::AsItIs);
            let is_shortest = part <= SHORTEST;
            let is_good = match taken {
                Ok(_) => {
                    let lengths = (part * h, part * h);
                    is_shortest || !self.books_are_off(model, workspace, forces, lengths, leader, (q, v))
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
            // Twice as long, where a part of that length begins.
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

    /// Adds the losses of the trees that move since the state was kept.
    fn add_losses(&self, total: &mut Losses) {
        for (_, last) in self.last_of.iter().enumerate().filter(|(tree, _)| self.components.is_active(*tree))
        {
            total.add(last);
        }
    }

    /// The rest of a step as it is, in a few parts, and what its books miss.
    fn take_rest(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        leader: usize,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        self.keep(q, v);
        let part = h / f64::from(PARTS);
        for _ in 0..PARTS {
            self.advance(model, &mut workspace.dynamics, forces.tau, part, (q, v), Whole::AsItIs)?;
        }
        let (imbalance, _) = self.imbalance(model, workspace, forces, (h, part), leader, (q, v));
        self.unsettled = (self.unsettled.0 + 1, self.unsettled.1.max(imbalance.abs()));
        Ok(())
    }
}

/// The mass of the bodies of the component with this first tree.
fn moving_mass(model: &Model, components: &Components, leader: usize) -> f64 {
    let is_own = |body: &&Body| {
        let first = model.dofs[body.dof].coordinate;
        components.leader(components.tree_of(first)) == leader
    };
    // A sum of nothing is −0.
    model.bodies.iter().filter(is_own).map(|body| body.mass).sum::<f64>() + 0.0
}
