//! The quantities of a step that its derivative needs.

use robot_dynamics_core::clone_in_place::clone_in_place;

use super::systems::push_row;
use crate::contact::{Components, ContactImpulses, PushingRow};

clone_in_place! {
    /// The quantities of a step that its derivative needs. They are recorded only for that purpose.
    #[derive(Debug, Default)]
    pub(in super::super) struct StepRecord {
        pub(in super::super) is_on: bool,
        /// The lengths of the passes that make up the step, and whether some components moved separately in
        /// one of them.
        pub(in super::super) parts: Vec<f64>,
        pub(super) is_apart: bool,
        /// Whether the pass is one of several parts of the step.
        pub(super) is_part: bool,
        /// The given forces.
        pub(super) tau: Vec<f64>,
        /// k₁ and k₂ of the velocities.
        pub(super) first: Vec<f64>,
        pub(super) second: Vec<f64>,
        /// The sum of the forces of both stages without C v, gravity and damping, and the impulses of the
        /// contacts.
        pub(super) applied: Vec<f64>,
        pub(super) impulse: Vec<f64>,
        /// v before the impulses, if the step looked for them, and M̂⁻¹Eᵀλ; empty without impulses.
        pub(super) before: Vec<f64>,
        pub(super) change: Vec<f64>,
        /// The rows of joints, tendons and equalities in the problem of the impulses.
        pub(super) rows: Vec<SolvedRow>,
        /// v at the end before the momentum correction.
        pub(super) after: Vec<f64>,
        /// The position corrections, in their order.
        pub(super) corrections: Vec<Correction>,
    }
}

impl StepRecord {
    pub(super) fn begin(&mut self) {
        self.is_on = true;
        self.is_apart = false;
        self.parts.clear();
    }

    /// Begins a pass.
    pub(in super::super) fn begin_pass(&mut self, tau: &[f64]) {
        if self.is_on {
            self.tau.clear();
            self.tau.extend_from_slice(tau);
            for vector in
                [&mut self.applied, &mut self.impulse, &mut self.before, &mut self.change, &mut self.after]
            {
                vector.clear();
            }
            self.corrections.clear();
            self.rows.clear();
        }
    }

    /// Copies the stages of the smooth part: k₁ + k₂, k₂ and the applied forces.
    pub(in super::super) fn record_stages(&mut self, sum: &[f64], second: &[f64], applied: &[f64]) {
        if self.is_on {
            self.first.clear();
            self.first.extend(sum.iter().zip(second).map(|(sum, second)| sum - second));
            self.second.clear();
            self.second.extend_from_slice(second);
            self.applied.extend_from_slice(applied);
        }
    }

    /// Copies v before the impulses.
    pub(in super::super) fn record_before(&mut self, v: &[f64]) {
        if self.is_on {
            self.before.extend_from_slice(v);
        }
    }

    /// Copies the change of v, the generalized impulses and the rows of the problem.
    pub(in super::super) fn record_change(
        &mut self,
        change: &[f64],
        impulse: &[f64],
        rows: impl Iterator<Item = SolvedRow>,
    ) {
        if self.is_on {
            self.rows.extend(rows);
            self.change.extend_from_slice(change);
            self.impulse.extend_from_slice(impulse);
        }
    }

    /// Copies v before the last momentum correction at the end of a pass of length h.
    pub(in super::super) fn record_after(&mut self, h: f64, v: &[f64], components: &Components) {
        if self.is_on {
            self.after.extend_from_slice(v);
            self.parts.push(h);
            self.is_apart |= !components.is_whole();
        }
    }

    /// Records the last position correction of contacts, from q along `way`.
    pub(in super::super) fn record_lift(&mut self, q: &[f64], way: &[f64], contacts: &ContactImpulses) {
        if self.is_on {
            let mut correction = Correction::new(q, way);
            contacts.each_pushing_row(|support, entries, row| {
                correction.add(support.iter().copied().zip(entries.iter().copied()), row);
            });
            self.corrections.push(correction);
        }
    }

    /// Records a position correction of stops, from q along `way`.
    pub(in super::super) fn record_return<'a>(
        &mut self,
        (q, way): (&[f64], &[f64]),
        rows: impl Iterator<Item = (&'a [(usize, f64)], PushingRow)>,
    ) {
        if self.is_on {
            let mut correction = Correction::new(q, way);
            rows.for_each(|(terms, row)| correction.add(terms.iter().copied(), row));
            self.corrections.push(correction);
        }
    }
}

/// A row of a joint, tendon or equality after the solution of the step's problem.
#[derive(Clone, Debug)]
pub(in super::super) struct SolvedRow {
    pub(in super::super) number: usize,
    /// Its coordinates with their factors.
    pub(in super::super) terms: Vec<(usize, f64)>,
    pub(in super::super) multiplier: f64,
    /// Whether its multiplier is between its bounds, so that its velocity is the target velocity.
    pub(in super::super) is_free: bool,
    /// Whether it returns to a stop.
    pub(in super::super) returns: bool,
    /// Whether its factors depend on q.
    pub(in super::super) moves: bool,
}

/// One position correction: q ← q ⊕ M̂⁻¹Aᵀp.
#[derive(Clone, Debug)]
pub(in super::super) struct Correction {
    /// q before it, and M̂⁻¹Aᵀp.
    pub(super) q: Vec<f64>,
    pub(super) way: Vec<f64>,
    /// The rows of A that pushed, nv numbers each.
    pub(super) entries: Vec<f64>,
    pub(super) rows: Vec<PushingRow>,
}

impl Correction {
    fn new(q: &[f64], way: &[f64]) -> Self {
        Self { q: q.to_vec(), way: way.to_vec(), entries: Vec::new(), rows: Vec::new() }
    }

    fn add(&mut self, terms: impl Iterator<Item = (usize, f64)>, row: PushingRow) {
        push_row(&mut self.entries, self.way.len(), terms);
        self.rows.push(row);
    }
}
