//! Rows of equalities in the problem of friction and stops.

use robot_dynamics_core::{Model, Workspace, integrate};
use robot_dynamics_integrators::IntegratorError;

use super::super::equalities::Equalities;
use super::super::joints::Stop;
use super::super::stiff_factor::StiffFactor;
use super::landing::land_on_stops;
use super::{Impulses, ROUNDING};
use crate::contact::{Components, returns};
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
    pub(in super::super) fn hold(&mut self, equalities: &Equalities) {
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
        (equalities, stops, components): (&mut Equalities, &[Stop], &Components),
        h: f64,
        (q0, q1): (&[f64], &mut [f64]),
        change: &mut [f64],
    ) -> Result<(), IntegratorError> {
        let kept = returns(h);
        let gap = |stop: &Stop, q: &[f64]| stop.gap(q) - stop.gap(q0).min(0.0) * kept;
        for _ in 0..MOST_ROUNDS {
            equalities.place(model, workspace, q1);
            let is_off = equalities.gaps(h).any(|gap| gap.abs() > ROUNDING);
            let own = || {
                stops
                    .iter()
                    .filter(|stop| components.is_active(components.tree_of_row(&self.terms[stop.row])))
            };
            if !is_off && own().all(|stop| gap(stop, q1) >= -ROUNDING) {
                break;
            }
            self.hold(equalities);
            self.rows.clear();
            for stop in stops.iter().filter(|stop| gap(stop, q1) < FAR) {
                if self.is_active(stop.row, components) && !self.rows.contains(&stop.row) {
                    self.rows.push(stop.row);
                }
            }
            self.rows.extend_from_slice(&self.held);
            self.problem.begin(self.rows.len());
            self.fill(factor);
            for (i, row) in self.rows.iter().enumerate().filter(|(_, row)| **row < self.own) {
                // The nearer one of a row's two stops.
                let own = stops.iter().filter(|stop| stop.row == *row);
                let Some(stop) = own.min_by(|a, b| gap(a, q1).total_cmp(&gap(b, q1))) else { continue };
                self.problem.gradient[i] = stop.sign * gap(stop, q1);
                let side =
                    if stop.sign > 0.0 { &mut self.problem.upper[i] } else { &mut self.problem.lower[i] };
                *side = stop.sign * f64::INFINITY;
            }
            let first = self.rows.len() - self.held.len();
            for (i, gap) in equalities.gaps(h).enumerate() {
                self.problem.gradient[first + i] = gap;
                (self.problem.lower[first + i], self.problem.upper[first + i]) =
                    (f64::NEG_INFINITY, f64::INFINITY);
            }
            self.apply(factor, change)?;
            self.before.copy_from_slice(q1);
            integrate(model, &self.before, change, q1);
        }
        land_on_stops(stops, q0, q1);
        Ok(())
    }
}
