//! Rows of equalities in the problem of friction and stops.

use robot_dynamics_core::{Model, Workspace, integrate};
use robot_dynamics_integrators::IntegratorError;

use super::super::equalities::Equalities;
use super::super::joints::Stop;
use super::super::linearization::StepRecord;
use super::super::path_stops::PathStops;
use super::super::stiff_factor::StiffFactor;
use super::landing::{land_on_stops, nearer_stop};
use super::{Impulses, ROUNDING};
use crate::contact::{Components, CorrectedRow, PushingRow, returns};
use crate::equality::rows::EqualityRow;

/// The number of repeated corrections of φ, because φ is not linear.
const MOST_ROUNDS: usize = 8;

/// Stops further away than this are excluded: a correction is smaller, or the next iteration includes them
/// \[rad or m\].
const FAR: f64 = 0.1;

impl Impulses {
    /// Allocates memory for these rows in addition to those of joints and tendons.
    pub(in super::super) fn make_room(&mut self, rows: &[EqualityRow]) {
        self.terms.truncate(self.own);
        self.terms.extend(rows.iter().map(|row| row.terms.clone()));
        let most = self.terms.len();
        let interrupt = self.problem.interrupt.clone();
        for problem in [&mut self.problem, &mut self.part] {
            *problem = super::BoundedProblem::new(most);
            problem.interrupt = interrupt.clone();
        }
        self.part_rows = Vec::with_capacity(most);
        self.beside = Vec::with_capacity(most);
        self.rows = Vec::with_capacity(most);
        self.pressed = Vec::with_capacity(most);
        self.back = Vec::with_capacity(most);
        self.held = Vec::with_capacity(rows.len());
    }

    /// Copies the enforced rows at their current values.
    pub(in super::super) fn copy_equality_rows(&mut self, equalities: &Equalities) {
        self.held.clear();
        for &i in equalities.active() {
            self.terms[self.own + i].copy_from_slice(&equalities.rows()[i].terms);
            self.held.push(self.own + i);
        }
    }

    /// The multipliers of these rows in the last problem.
    pub(in super::super) fn of_held(&self) -> impl Iterator<Item = f64> + '_ {
        let rows = self.rows.iter().zip(&self.problem.x);
        rows.filter(|(row, _)| **row >= self.own).map(|(_, x)| *x)
    }

    /// Moves `q1` along M̂⁻¹Aᵀ to φ = 0 without passing a stop. An error at the start is removed gradually.
    pub(in super::super) fn put_on_equalities(
        &mut self,
        (model, workspace): (&Model, &mut Workspace),
        factor: &StiffFactor,
        (equalities, (stops, paths), components): (&mut Equalities, (&[Stop], &mut PathStops), &Components),
        h: f64,
        (q0, q1): (&[f64], &mut [f64]),
        (change, record): (&mut [f64], &mut StepRecord),
    ) -> Result<(), IntegratorError> {
        let kept = returns(h);
        for _ in 0..MOST_ROUNDS {
            equalities.place(model, workspace, q1);
            paths.turn(model, workspace, q1, self);
            let gap = |stop: &Stop| stop.gap_to_correct(paths.at_start(q0), kept, paths.at_end(q1));
            let is_off = equalities.gaps(h).any(|gap| gap.abs() > ROUNDING);
            let mut own = stops.iter().filter(|stop| self.is_active(stop.row, components));
            if !is_off && own.all(|stop| gap(stop) >= -ROUNDING) {
                break;
            }
            self.newton_step(factor, (equalities, stops, components), h, gap, change)?;
            self.before.copy_from_slice(q1);
            integrate(model, &self.before, change, q1);
            let stopped = self.rows.len() - self.held.len();
            let was_violated = |stop: &Stop| stop.gap(paths.at_start(q0)) < 0.0;
            let pushing = self.pushing_stops(stopped, stops, was_violated);
            record.record_return((&self.before, change), pushing.chain(self.held_rows(equalities, true)));
        }
        self.record_end(equalities, q1, change, record);
        land_on_stops(stops, q0, q1);
        Ok(())
    }

    /// Records the equalities at q₁. They determine how it depends on the start, also without a correction.
    pub(in super::super) fn record_end(
        &mut self,
        equalities: &Equalities,
        q1: &[f64],
        change: &mut [f64],
        record: &mut StepRecord,
    ) {
        if record.is_on {
            change.fill(0.0);
            self.copy_equality_rows(equalities);
            record.record_return((q1, change), self.held_rows(equalities, false));
        }
    }

    /// The enforced rows of equalities with φ. Their multipliers are those of the last correction if it has
    /// moved q.
    fn held_rows<'a>(
        &'a self,
        equalities: &'a Equalities,
        has_moved: bool,
    ) -> impl Iterator<Item = (&'a [(usize, f64)], PushingRow)> + 'a {
        let stopped = self.rows.len().saturating_sub(self.held.len());
        self.held.iter().zip(equalities.active()).enumerate().filter_map(move |(i, (&row, &equality))| {
            equalities.rows()[equality].error?;
            let multiplier = if has_moved { self.problem.x[stopped + i] } else { 0.0 };
            let is_from_start = equalities.was_violated(equality);
            let corrected = CorrectedRow { is_from_start, is_equality: true, moving: Some((row, 1.0)) };
            Some((&self.terms[row][..], PushingRow { multiplier, contact: None, corrected }))
        })
    }

    /// Copies all rows at their current values.
    pub(in super::super) fn copy_all_equality_rows(&mut self, equalities: &Equalities) {
        for (terms, row) in self.terms[self.own..].iter_mut().zip(equalities.rows()) {
            terms.copy_from_slice(&row.terms);
        }
    }

    /// The number of the first row of the equalities.
    pub(in super::super) fn first_equality(&self) -> usize {
        self.own
    }

    /// The number of this row, if its factors depend on q.
    pub(in super::super) fn moving(&self, row: usize) -> Option<usize> {
        (row >= self.turning).then_some(row)
    }

    /// Computes the displacement M̂⁻¹Aᵀλ that removes φ to first order and passes no stop, at the
    /// configuration of the equalities. `gap` is the distance from a stop there.
    fn newton_step(
        &mut self,
        factor: &StiffFactor,
        (equalities, stops, components): (&Equalities, &[Stop], &Components),
        h: f64,
        gap: impl Fn(&Stop) -> f64,
        change: &mut [f64],
    ) -> Result<(), IntegratorError> {
        self.copy_equality_rows(equalities);
        self.rows.clear();
        for stop in stops.iter().filter(|stop| gap(stop) < FAR) {
            if self.is_active(stop.row, components) && !self.rows.contains(&stop.row) {
                self.rows.push(stop.row);
            }
        }
        let stopped = self.rows.len();
        self.rows.extend_from_slice(&self.held);
        self.problem.begin(self.rows.len());
        self.fill(factor);
        for (i, row) in self.rows[..stopped].iter().enumerate() {
            let Some(stop) = nearer_stop(stops, *row, &gap) else { continue };
            self.problem.release_towards(stop.sign, i, stop.sign * gap(stop));
        }
        for (i, gap) in equalities.gaps(h).enumerate() {
            self.problem.release(stopped + i, gap);
        }
        self.apply(factor, change)
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::configuration::joint_sum::JointSum;
    use robot_dynamics_core::{Workspace, integrate};

    use super::super::super::equalities::Equalities;
    use super::super::super::joints::Joints;
    use super::super::super::stiff_factor::StiffFactor;
    use super::super::super::test_robot::arm;
    use super::super::SOFTER;
    use super::Impulses;
    use crate::contact::{Components, Interrupt};
    use crate::equality::polynomial::PolynomialRelation;
    use crate::equality::position::CoupledPosition;
    use crate::equality::relation::Relation;
    use crate::equality::rows::EqualityRows;

    /// For q₁ = q₂² a step removes the terms of first order of φ: −Δq₂² remains, and the fraction of φ that
    /// the softening leaves.
    #[test]
    fn newton_step_leaves_terms_of_second_order() {
        const H: f64 = 1e-3;
        let model = arm();
        let (joints, mut workspace) = (Joints::new(&model), Workspace::new(&model));
        let [position, leader] = ["shoulder", "elbow"]
            .map(|name| CoupledPosition::Joints(JointSum::new(&model, 0.0, [(name, 1.0)])));
        let polynomial = [0.0, 0.0, 1.0, 0.0, 0.0];
        let rows = EqualityRows::new(
            &model,
            [Relation::Polynomial(PolynomialRelation { position, leader, polynomial })],
        );
        let mut impulses = Impulses::new(&model, &joints);
        impulses.make_room(rows.rows());
        let mut equalities = Equalities::new(&model, rows, vec!["parabola".to_owned()]);
        equalities.begin(&model, &mut workspace, &[0.0, 0.0]);
        let mut q = [0.3, 0.7];
        let mut factor = StiffFactor::new(&model);
        factor.factor(&model, &mut workspace, &q, &joints, 0.0).unwrap();
        let components = Components::new(factor.paths().dof_parent());
        for _ in 0..3 {
            equalities.place(&model, &mut workspace, &q);
            equalities.choose(&factor, &Interrupt::default(), &components).unwrap();
            let (mut change, before) = ([0.0; 2], equalities.gaps(H).next().unwrap());
            let rest = (&equalities, &[][..], &components);
            impulses.newton_step(&factor, rest, H, |_| unreachable!(), &mut change).unwrap();
            integrate(&model, &q.clone(), &change, &mut q);
            equalities.place(&model, &mut workspace, &q);
            let remaining = equalities.gaps(H).next().unwrap();
            let error = (remaining + change[1] * change[1]).abs();
            assert!(error < 1.01 * SOFTER * before.abs() + 1e-15, "{remaining} after {change:?}");
        }
    }
}
