//! Steps taken again in shorter parts where their books do not close.
//!
//! Where axes of joints become parallel, as the outer two of three hinges that stand for a ball do at 90°, M(q) loses its rank, and a
//! thousandth of a radian on it is another matrix; with a stop there the joints turn back at it. A step of fixed length does not see
//! that, and ends with energy from nowhere. Such a step is halved, and its halves again, until their books close; next to the place
//! the parts are long again.

use dynamics::{EnergyLedger, IntegratorError};

use super::advance::{PARTS, Whole};
use super::{Implicit, Kept};
use crate::contact::ContactImpulses;
use crate::motion::drive::record;
use crate::motion::simulate::Losses;
use crate::{Model, StepForces, StepWorkspace, energy_ledger};

/// A step in which no coordinate goes further looks harmless \[rad or m\].
const FAR: f64 = 0.1;

/// So does one in which no pivot of M̂ is below this part of M's diagonal.
const SMALL: f64 = 1e-3;

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
    /// Whether the books of a step of h should be looked at.
    pub(super) fn is_suspect(&self, h: f64) -> bool {
        self.kept.is_rough || h * self.kept.fastest > FAR || self.factor.least_pivot() < SMALL
    }

    /// Whether a step of h, in parts of this length, that led from the kept state to this one has books that do not close.
    pub(super) fn books_are_off(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        (h, part): (f64, f64),
        to: (&[f64], &[f64]),
    ) -> bool {
        let (imbalance, most) = self.imbalance(model, workspace, forces, (h, part), to);
        imbalance.abs() > most || !imbalance.is_finite()
    }

    /// The energy that the books of such a step miss, and the most that they may.
    fn imbalance(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        (h, part): (f64, f64),
        to: (&[f64], &[f64]),
    ) -> (f64, f64) {
        let (q, v) = (&self.kept.q[..], &self.kept.v[..]);
        let start = energy_ledger(model, &mut workspace.dynamics, q, v);
        let stored = self.drive.as_mut().map_or(0.0, |drive| drive.stored_energy(q));
        let mut ledger = EnergyLedger::new(start.kinetic(), start.potential() + stored);
        let mut last = self.last;
        let books = (&mut last, &mut Losses::default());
        record(model, workspace, &mut ledger, [(q, v), to], (forces, h), &mut self.drive, books);
        let slow = 0.5 * SLOW * SLOW * self.factor.mass_trace();
        // What sank into the ground in an impact is lifted out of it.
        let lift = if self.contacts.is_some() { self.weight * self.kept.fastest * part } else { 0.0 };
        let most =
            OFF * (start.kinetic() + ledger.kinetic() + slow) + ROUNDING * start.potential().abs() + lift;
        (ledger.imbalance(), most)
    }

    /// The step of h from the kept state, in parts.
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
        self.take_back(q, v);
        while done < 1.0 {
            self.check_interrupt()?;
            tried += 1;
            work += v.len() + 3 * self.contacts.as_ref().map_or(0, ContactImpulses::count);
            if tried > MOST_PARTS || (tried > LEAST_PARTS && work > MOST_WORK) {
                self.take_rest(model, workspace, forces, (1.0 - done) * h, (q, v))?;
                total.add(&self.last);
                break;
            }
            self.keep(q, v);
            let taken =
                self.advance(model, &mut workspace.dynamics, forces.tau, part * h, (q, v), Whole::AsItIs);
            let is_shortest = part <= SHORTEST;
            let is_good = match taken {
                Ok(_) => {
                    is_shortest || !self.books_are_off(model, workspace, forces, (part * h, part * h), (q, v))
                }
                Err(error) if is_shortest => return Err(error),
                Err(_) => false,
            };
            if !is_good {
                self.take_back(q, v);
                part *= 0.5;
                continue;
            }
            total.add(&self.last);
            done += part;
            // Twice as long, where a part of that length begins.
            if part < 0.5 && (done / (2.0 * part)).fract() == 0.0 {
                part *= 2.0;
            }
        }
        self.last = total;
        Ok(())
    }

    /// The rest of a step as it is, in a few parts, and what its books miss.
    fn take_rest(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        self.keep(q, v);
        let part = h / f64::from(PARTS);
        for _ in 0..PARTS {
            self.advance(model, &mut workspace.dynamics, forces.tau, part, (q, v), Whole::AsItIs)?;
        }
        let (imbalance, _) = self.imbalance(model, workspace, forces, (h, part), (q, v));
        self.unsettled = (self.unsettled.0 + 1, self.unsettled.1.max(imbalance.abs()));
        Ok(())
    }

    /// Keeps a state, and what is remembered from step to step; opens the books of what goes from there.
    pub(super) fn keep(&mut self, q: &[f64], v: &[f64]) {
        self.last = Losses::default();
        let kept = &mut self.kept;
        kept.q.copy_from_slice(q);
        kept.v.copy_from_slice(v);
        (kept.fastest, kept.is_rough) = (0.0, false);
        kept.see(v);
        kept.impulses.copy_from(self.impulses.memory());
        if let (Some(kept), Some(equalities)) = (&mut kept.equalities, &mut self.equalities) {
            kept.copy_from(equalities.memory());
        }
        if let (Some(kept), Some(contacts)) = (&mut kept.contacts, &mut self.contacts) {
            kept.copy_from(contacts.memory());
        }
    }

    /// Goes back there.
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
}

impl Kept {
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.q.copy_from_slice(&other.q);
        self.v.copy_from_slice(&other.v);
        (self.fastest, self.is_rough) = (other.fastest, other.is_rough);
        self.impulses.copy_from(&other.impulses);
        if let (Some(own), Some(other)) = (&mut self.equalities, &other.equalities) {
            own.copy_from(other);
        }
        if let (Some(own), Some(other)) = (&mut self.contacts, &other.contacts) {
            own.copy_from(other);
        }
    }

    /// Notes the speeds of a state on the way.
    pub(super) fn see(&mut self, v: &[f64]) {
        self.fastest = v.iter().fold(self.fastest, |fastest, v| fastest.max(v.abs()));
    }
}
