//! Equalities in a step: closed loops, coupled joints, wheels that roll.
//!
//! Their rows A v⁺ = 0 are rows of the step's convex problem, with multipliers of either sign. The multipliers of the step before act in the smooth part,
//! along A of its middle, and what the problem finds is what is missing: so the step keeps its order 2. Positions take half of it, as those
//! of all impulses do; what φ has then is removed along M̂⁻¹Aᵀ, beside stops and contacts, without a change of v.

use dynamics::{DynamicsError, IntegratorError};

use super::Implicit;
use super::impulses::along;
use super::pivots::Pivots;
use super::stiff_factor::StiffFactor;
use crate::clone_in_place::clone_in_place;
use crate::contact::{Components, EqualityRow, EqualityRows, Interrupt, Mark, returns};
use crate::{Model, Workspace};

/// A row whose part independent of the earlier ones is below this part of its length (both in M̂⁻¹) is left out, and one below this part of the longest of the
/// same constraint in the same unit: planar loops have rows that say the same, or nothing, to the digits that files have.
const DEPENDENCE: f64 = 1e-5;

/// So is a row shorter than this part of the longest of all, which is rounding.
const ROUNDING: f64 = 1e-13;

/// How far off a start may be, as rows that are left out may \[m or rad, and m/s or rad/s\].
const NEAR: f64 = DEPENDENCE;

/// A start less far off is removed at once: by steps that each leave less than is looked at it would grow \[m or rad\].
const AT_ONCE: f64 = 1e-9;

clone_in_place! {
    /// The equalities of a robot, step after step.
    #[derive(Debug)]
    pub(super) struct Equalities {
        rows: EqualityRows,
        names: Vec<String>,
        /// The rows that hold in this step, those that depend on others left out.
        active: Vec<usize>,
        /// Of each row φ where the step starts, 0 where it is next to none.
        start: Vec<f64>,
        memory: Remembered,
        /// λ of a trial.
        found: Vec<f64>,
        /// E and E M̂⁻¹ with E M̂⁻¹Eᵀ = 1, row by row of those that hold.
        forces: Vec<f64>,
        responses: Vec<f64>,
        rest: Vec<f64>,
        pivots: Pivots,
    }
}

clone_in_place! {
    /// What goes on from step to step.
    #[derive(Debug)]
    pub(super) struct Remembered {
        /// λ of the last step, but for impacts \[N or N·m\].
        carried: Vec<f64>,
        /// Of the whole step so far \[N·s or N·m·s\].
        impulses: Vec<f64>,
        /// Whether `carried` is of a step, or of a trial before the first one.
        is_begun: bool,
    }
}

impl Remembered {
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.carried.copy_from_slice(&other.carried);
        self.impulses.copy_from_slice(&other.impulses);
        self.is_begun = other.is_begun;
    }
}

impl Equalities {
    fn new(model: &Model, rows: EqualityRows, names: Vec<String>) -> Self {
        let (count, nv) = (rows.rows().len(), model.nv);
        Self {
            rows,
            names,
            active: Vec::with_capacity(count),
            start: vec![0.0; count],
            memory: Remembered { carried: vec![0.0; count], impulses: vec![0.0; count], is_begun: false },
            found: vec![0.0; count],
            forces: Vec::with_capacity(count * nv),
            responses: Vec::with_capacity(count * nv),
            rest: vec![0.0; nv],
            pivots: Pivots::new(count, nv),
        }
    }

    pub(super) fn memory(&mut self) -> &mut Remembered {
        &mut self.memory
    }

    /// Whether λ of a step before is known.
    pub(super) fn is_begun(&self) -> bool {
        self.memory.is_begun
    }

    /// Keeps the λ of a step that is taken back next.
    pub(super) fn note_trial(&mut self) {
        self.found.copy_from_slice(&self.memory.carried);
    }

    /// Begins the first step with the λ of a trial.
    pub(super) fn begin_with_trial(&mut self) {
        self.memory.carried.copy_from_slice(&self.found);
        self.memory.is_begun = true;
    }

    /// All rows where they were placed last.
    pub(super) fn rows(&self) -> &[EqualityRow] {
        self.rows.rows()
    }

    /// Those that hold in this step.
    pub(super) fn active(&self) -> &[usize] {
        &self.active
    }

    /// Begins a step at q.
    pub(super) fn begin(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        self.rows.place(model, workspace, q);
        for (start, row) in self.start.iter_mut().zip(self.rows.rows()) {
            *start = row.error.filter(|error| error.abs() > AT_ONCE).unwrap_or(0.0);
        }
    }

    /// λ of the last step, in the configuration q, to `forces`.
    pub(super) fn carry(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64], forces: &mut [f64]) {
        self.rows.place(model, workspace, q);
        self.rows.add_forces(&self.memory.carried, forces);
    }

    /// Moves the rows to q.
    pub(super) fn place(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        self.rows.place(model, workspace, q);
    }

    /// Chooses the rows that hold, by Gram and Schmidt's method in M̂⁻¹, twice on every row, in the order of [`Pivots`], tree by tree. Those of trees that do not move
    /// are left out at last.
    ///
    /// # Errors
    /// A row is not finite.
    pub(super) fn choose(
        &mut self,
        factor: &StiffFactor,
        interrupt: &Interrupt,
        components: &Components,
    ) -> Result<(), DynamicsError> {
        let Self { rows, active, pivots, forces, responses, rest, .. } = self;
        let tree_of = |row: usize| components.tree_of_row(&rows.rows()[row].terms);
        let n = rest.len();
        active.clear();
        forces.clear();
        responses.clear();
        pivots.begin(rows.rows(), factor);
        if let Some(index) = pivots.lengths.iter().position(|length| !length.is_finite()) {
            return Err(DynamicsError::NonFinite { quantity: "a row of the equalities", index });
        }
        for first in 0..rows.rows().len() {
            // Each tree where its first row is.
            let tree = tree_of(first);
            if (0..first).any(|row| tree_of(row) == tree) {
                continue;
            }
            let is_own = |row: usize| tree_of(row) == tree;
            let own = pivots.lengths.iter().enumerate().filter(|(row, _)| is_own(*row));
            let least = ROUNDING * own.fold(0.0_f64, |most, (_, length)| most.max(*length));
            let begin = forces.len();
            while let Some(i) = pivots.next(is_own) {
                if interrupt.is_set() {
                    break;
                }
                rest.fill(0.0);
                rows.rows()[i].terms.iter().for_each(|&(k, factor)| rest[k] = factor);
                for _pass in 0..2 {
                    let earlier = forces[begin..].chunks_exact(n).zip(responses[begin..].chunks_exact(n));
                    for (force, response) in earlier {
                        let component: f64 = response.iter().zip(&*rest).map(|(e, x)| e * x).sum();
                        rest.iter_mut().zip(force).for_each(|(x, e)| *x -= component * e);
                    }
                }
                let at = responses.len();
                responses.extend_from_slice(rest);
                factor.solve(&mut responses[at..]);
                let square: f64 = responses[at..].iter().zip(&*rest).map(|(x, e)| x * e).sum();
                let remainder = square.max(0.0).sqrt();
                if remainder > (DEPENDENCE * pivots.scales[i]).max(least) {
                    responses[at..].iter_mut().for_each(|x| *x /= remainder);
                    forces.extend(rest.iter().map(|e| e / remainder));
                    active.push(i);
                    pivots.take(rows.rows(), i);
                } else {
                    responses.truncate(at);
                }
            }
        }
        active.retain(|row| components.is_active(tree_of(*row)));
        active.sort_unstable();
        Ok(())
    }

    /// φ of each row that holds, with what of the start's is to be left after a step of h taken off; 0 of one without φ.
    pub(super) fn gaps(&self, h: f64) -> impl Iterator<Item = f64> + Clone + '_ {
        let kept = returns(h);
        self.active
            .iter()
            .map(move |&i| self.rows.rows()[i].error.map_or(0.0, |error| error - kept * self.start[i]))
    }

    /// Those with φ, each its coordinates and its gap.
    pub(super) fn held(&self, h: f64) -> impl Iterator<Item = (&[(usize, f64)], f64)> + Clone {
        let rows = self.rows.rows();
        let held = self.active.iter().zip(self.gaps(h));
        held.filter(|(i, _)| rows[**i].error.is_some()).map(|(i, gap)| (&rows[*i].terms[..], gap))
    }

    /// Enters the multipliers that the problem of a step of h found, in the order of the rows that hold. Those of an impact do not go on.
    pub(super) fn settle(&mut self, h: f64, found: impl Iterator<Item = f64>, components: &Components) {
        let Self { rows, active, memory, .. } = self;
        let tree_of = |row: usize| components.tree_of_row(&rows.rows()[row].terms);
        let Remembered { carried, impulses, .. } = memory;
        let mut next = 0;
        for (i, (impulse, carried)) in impulses.iter_mut().zip(carried.iter_mut()).enumerate() {
            if !components.is_active(tree_of(i)) {
                continue;
            }
            *impulse += h * *carried;
            // A row that depends on others now leaves its part to them.
            if active.get(next) == Some(&i) {
                next += 1;
            } else {
                *carried = 0.0;
            }
        }
        for (&i, multiplier) in active.iter().zip(found) {
            impulses[i] += multiplier;
            if !components.has(Mark::Hit, tree_of(i)) {
                carried[i] += multiplier / h;
            }
        }
    }

    /// Goes back to what was remembered where a step began, of the trees that move.
    pub(super) fn take_back_active(&mut self, begun: &Remembered, components: &Components) {
        let Self { rows, memory, .. } = self;
        for (i, row) in rows.rows().iter().enumerate() {
            if components.is_active(components.tree_of_row(&row.terms)) {
                memory.carried[i] = begun.carried[i];
                memory.impulses[i] = begun.impulses[i];
            }
        }
    }

    /// Begins and ends the sum of a step's impulses.
    pub(super) fn clear_impulses(&mut self) {
        self.memory.impulses.fill(0.0);
    }

    pub(super) fn average_impulses(&mut self, h: f64) {
        self.memory.impulses.iter_mut().for_each(|impulse| *impulse /= h);
    }

    /// Refuses a start that is not on the equalities.
    pub(super) fn check(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
    ) -> Result<(), IntegratorError> {
        self.rows.place(model, workspace, q);
        for (row, name) in self.rows.rows().iter().zip(&self.names) {
            let speed = along(&row.terms, v);
            for (quantity, value) in [("position", row.error.unwrap_or(0.0)), ("velocity", speed)] {
                if value.is_nan() || value.abs() > NEAR {
                    return Err(IntegratorError::OffConstraint {
                        quantity,
                        name: name.clone(),
                        error: value.abs(),
                    });
                }
            }
        }
        Ok(())
    }
}

impl Implicit {
    /// With these rows, each with its name.
    pub(crate) fn with_equalities(mut self, model: &Model, rows: EqualityRows, names: Vec<String>) -> Self {
        self.impulses.make_room(rows.rows());
        self.components.unite(rows.rows().iter().map(|row| &row.terms[..]));
        self.resize_trees();
        let mut equalities = Equalities::new(model, rows, names);
        for kept in [&mut self.kept, &mut self.start] {
            kept.equalities = Some(equalities.memory().clone());
        }
        self.equalities = Some(equalities);
        self
    }

    /// The multiplier of each constraint's row by its name, the mean over the last step \[N, or N·m of a turn\]: the force of row k is Aₖᵀλₖ. Rows that depend on each
    /// other share their forces: λ has the least norm ([`Pivots::share`]). Empty without [`with_constraints`](Self::with_constraints).
    pub(crate) fn constraint_forces(&self) -> impl Iterator<Item = (&str, f64)> {
        let (names, impulses) = match &self.equalities {
            Some(Equalities { names, memory, rows, pivots, .. }) => {
                (&names[..], pivots.share(rows.rows(), &memory.impulses, DEPENDENCE))
            }
            None => (&[][..], Vec::new()),
        };
        names.iter().map(String::as_str).zip(impulses)
    }
}
