//! Equalities in a step: closed loops, coupled joints, rolling wheels.
//!
//! Their rows A v⁺ = 0 belong to the step's convex problem, with multipliers of either sign. The smooth part
//! applies the multipliers of the last step along A at its middle, and the problem determines the correction.
//! The step therefore keeps its order 2. Positions take half of the correction, as for all impulses. The
//! remaining φ is removed along M̂⁻¹Aᵀ, together with stops and contacts, without a change of v.

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_integrators::IntegratorError;

use super::impulses::along;
use super::pivots::Pivots;
use super::stiff_factor::StiffFactor;
use crate::contact::{Components, Equal, Interrupt, Mark, returns};
use crate::equality::rows::{EqualityRow, EqualityRows};

/// A row is dependent, and excluded, if its part independent of the earlier rows is below this fraction of
/// its length (both in M̂⁻¹). So is a row below this fraction of the longest row of the same constraint in
/// the same unit. Rows of planar loops are dependent or vanish to the digits of a file.
const DEPENDENCE: f64 = 1e-5;

/// A row shorter than this fraction of the longest row is rounding, and is excluded.
const ROUNDING: f64 = 1e-13;

/// The allowed error of a start, equal to that of excluded rows \[m or rad, and m/s or rad/s\].
const NEAR: f64 = DEPENDENCE;

/// An error of the start below this is removed in one step \[m or rad\]. Gradual removal would let it grow
/// over steps that each leave less than the checked precision.
const AT_ONCE: f64 = 1e-9;

clone_in_place! {
    /// The equalities of a robot and their state between steps.
    #[derive(Debug)]
    pub(super) struct Equalities {
        rows: EqualityRows,
        names: Vec<String>,
        /// The rows that are enforced in this step, without dependent rows.
        active: Vec<usize>,
        /// φ of each row at the start of the step, or 0 if it is negligible.
        start: Vec<f64>,
        memory: EqualityMemory,
        /// λ of a trial.
        found: Vec<f64>,
        /// E and E M̂⁻¹ with E M̂⁻¹Eᵀ = 1, row by row of the enforced rows.
        forces: Vec<f64>,
        responses: Vec<f64>,
        rest: Vec<f64>,
        pivots: Pivots,
    }
}

clone_in_place! {
    /// The state that one step passes to the next.
    #[derive(Debug)]
    pub struct EqualityMemory {
        /// λ of the last step without impacts \[N or N·m\].
        carried: Vec<f64>,
        /// The impulses of the whole step so far \[N·s or N·m·s\].
        impulses: Vec<f64>,
        /// Whether `carried` comes from a step, or from a trial before the first one.
        is_begun: bool,
    }
}

impl EqualityMemory {
    /// λ of the last step without impacts.
    pub(super) fn carried(&self) -> &[f64] {
        &self.carried
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.carried.copy_from_slice(&other.carried);
        self.impulses.copy_from_slice(&other.impulses);
        self.is_begun = other.is_begun;
    }
}

impl Equalities {
    /// The names of the rows.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// The impulses of the rows, where dependent rows share theirs.
    pub(super) fn shared_impulses(&self) -> Vec<f64> {
        self.pivots.share(self.rows.rows(), &self.memory.impulses, DEPENDENCE)
    }

    pub(super) fn new(model: &Model, rows: EqualityRows, names: Vec<String>) -> Self {
        let (count, nv) = (rows.rows().len(), model.nv);
        Self {
            rows,
            names,
            active: Vec::with_capacity(count),
            start: vec![0.0; count],
            memory: EqualityMemory { carried: vec![0.0; count], impulses: vec![0.0; count], is_begun: false },
            found: vec![0.0; count],
            forces: Vec::with_capacity(count * nv),
            responses: Vec::with_capacity(count * nv),
            rest: vec![0.0; nv],
            pivots: Pivots::new(count, nv),
        }
    }

    pub(super) fn memory(&mut self) -> &mut EqualityMemory {
        &mut self.memory
    }

    /// Whether λ of an earlier step is known.
    pub(super) fn is_begun(&self) -> bool {
        self.memory.is_begun
    }

    /// Stores the λ of a trial step that is then undone.
    pub(super) fn record_trial(&mut self) {
        self.found.copy_from_slice(&self.memory.carried);
    }

    /// Starts the first step with the λ of a trial.
    pub(super) fn begin_with_trial(&mut self) {
        self.memory.carried.copy_from_slice(&self.found);
        self.memory.is_begun = true;
    }

    /// All rows at the last evaluated configuration.
    pub(super) fn rows(&self) -> &[EqualityRow] {
        self.rows.rows()
    }

    /// The rows that are enforced in this step.
    pub(super) fn active(&self) -> &[usize] {
        &self.active
    }

    /// Starts a step at q.
    pub(super) fn begin(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        self.rows.place(model, workspace, q);
        for (start, row) in self.start.iter_mut().zip(self.rows.rows()) {
            *start = row.error.filter(|error| error.abs() > AT_ONCE).unwrap_or(0.0);
        }
    }

    /// Writes the forces of the last step's λ at the configuration q to `forces`.
    pub(super) fn carry(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64], forces: &mut [f64]) {
        self.rows.place(model, workspace, q);
        self.rows.add_forces(&self.memory.carried, forces);
    }

    /// Evaluates the rows at q.
    pub(super) fn place(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64]) {
        self.rows.place(model, workspace, q);
    }

    /// Selects the enforced rows by Gram–Schmidt orthogonalization in M̂⁻¹, applied twice to every row, in
    /// the order of [`Pivots`], tree by tree. Finally, removes the rows of inactive trees.
    ///
    /// # Errors
    /// A row is not finite.
    pub(super) fn choose(
        &mut self,
        factor: &StiffFactor,
        interrupt: &Interrupt,
        components: &Components,
    ) -> Result<(), IntegratorError> {
        let Self { rows, active, pivots, forces, responses, rest, .. } = self;
        let tree_of = |row: usize| components.tree_of_row(&rows.rows()[row].terms);
        let n = rest.len();
        active.clear();
        forces.clear();
        responses.clear();
        pivots.begin(rows.rows(), factor);
        if let Some(index) = pivots.lengths.iter().position(|length| !length.is_finite()) {
            return Err(IntegratorError::NotFinite { quantity: "a row of the equalities", index });
        }
        for first in 0..rows.rows().len() {
            // Handle each tree at its first row.
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

    /// The part of φ to remove for each enforced row; 0 for rows without φ. It is φ minus the part of the
    /// start's error that may remain after a step of h.
    pub(super) fn gaps(&self, h: f64) -> impl Iterator<Item = f64> + Clone + '_ {
        let kept = returns(h);
        self.active
            .iter()
            .map(move |&i| self.rows.rows()[i].error.map_or(0.0, |error| error - kept * self.start[i]))
    }

    /// The rows with φ, each with its coordinates and its gap. Their numbers start at `first`.
    pub(super) fn held(&self, h: f64, first: usize) -> impl Iterator<Item = Equal<'_>> + Clone {
        let rows = self.rows.rows();
        let held = self.active.iter().zip(self.gaps(h));
        held.filter(|(i, _)| rows[**i].error.is_some()).map(move |(&i, gap)| Equal {
            terms: &rows[i].terms,
            gap,
            was_violated: self.was_violated(i),
            row: first + i,
        })
    }

    /// Whether a row has an error at the start of the step that is removed gradually.
    pub(super) fn was_violated(&self, row: usize) -> bool {
        self.start[row] != 0.0
    }

    /// Stores the multipliers of the problem of a step of h, in the order of the enforced rows. Multipliers
    /// of an impact are not passed to the next step.
    pub(super) fn record_multipliers(
        &mut self,
        h: f64,
        found: impl Iterator<Item = f64>,
        components: &Components,
    ) {
        let Self { rows, active, memory, .. } = self;
        let tree_of = |row: usize| components.tree_of_row(&rows.rows()[row].terms);
        let EqualityMemory { carried, impulses, .. } = memory;
        let mut next = 0;
        for (i, (impulse, carried)) in impulses.iter_mut().zip(carried.iter_mut()).enumerate() {
            if !components.is_active(tree_of(i)) {
                continue;
            }
            *impulse += h * *carried;
            // A row that has become dependent passes its force to the others.
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

    /// Restores the stored state at the start of a step, for the active trees.
    pub(super) fn restore_active(&mut self, begun: &EqualityMemory, components: &Components) {
        let Self { rows, memory, .. } = self;
        for (i, row) in rows.rows().iter().enumerate() {
            if components.is_active(components.tree_of_row(&row.terms)) {
                memory.carried[i] = begun.carried[i];
                memory.impulses[i] = begun.impulses[i];
            }
        }
    }

    /// Resets the sums of a step's impulses, at its start and end.
    pub(super) fn clear_impulses(&mut self) {
        self.memory.impulses.fill(0.0);
    }

    pub(super) fn average_impulses(&mut self, h: f64) {
        self.memory.impulses.iter_mut().for_each(|impulse| *impulse /= h);
    }

    /// Checks that a start satisfies the equalities.
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
