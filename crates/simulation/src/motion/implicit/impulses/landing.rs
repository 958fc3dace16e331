//! Correction of positions beyond stops after a step.

use robot_dynamics_integrators::IntegratorError;

use super::super::joints::{Length, Stop};
use super::super::linearization::StepRecord;
use super::super::stiff_factor::StiffFactor;
use super::{Impulses, ROUNDING};
use crate::contact::{Components, CorrectedRow, PushingRow, returns};

impl Impulses {
    /// Moves `q1` along M̂⁻¹Eᵀ back to the stops that it is beyond; a violation at the start is removed
    /// gradually. Joints that other stops hold do not move, as in
    /// [`ContactImpulses::lift`](crate::contact::ContactImpulses::lift).
    pub(in super::super) fn put_on_stops(
        &mut self,
        factor: &StiffFactor,
        (stops, components): (&[Stop], &Components),
        h: f64,
        (q0, q1): (&[f64], &mut [f64]),
        (change, record): (&mut [f64], &mut StepRecord),
        mut go: impl FnMut(&[f64], &[f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        let kept = returns(h);
        let gap = |stop: &Stop, q: &[f64]| stop.gap_to_correct(q0, kept, q);
        for i in 0..stops.len() {
            // Handle each tree at its first stop.
            let tree = self.tree_of(stops[i].row, components);
            if components.is_active(tree) && gap(&stops[i], q1) < 0.0 {
                self.put_tree_on_stops(factor, (stops, components, tree), gap, q1, change, &mut go)?;
                let pushing = self.pushing_stops(self.rows.len(), stops, |stop| stop.gap(q0) < 0.0);
                record.record_return((&self.before, change), pushing);
            }
        }
        land_on_stops(stops, q0, q1);
        Ok(())
    }

    /// The first `count` rows of the last correction that push, which are those of stops. The function states
    /// whether a stop was violated at the start of the step.
    pub(super) fn pushing_stops<'a>(
        &'a self,
        count: usize,
        stops: &'a [Stop],
        was_violated: impl Fn(&Stop) -> bool + 'a,
    ) -> impl Iterator<Item = (&'a [(usize, f64)], PushingRow)> + 'a {
        let rows = self.rows[..count].iter().zip(&self.problem.x);
        rows.filter(|(_, x)| **x != 0.0).map(move |(&row, &multiplier)| {
            let is_pushing = |stop: &&Stop| stop.row == row && stop.sign * multiplier > 0.0;
            let is_from_start = stops.iter().find(is_pushing).is_some_and(&was_violated);
            let moving = self.moving(row).map(|row| (row, 1.0));
            let corrected = CorrectedRow { is_from_start, is_equality: false, moving };
            (&self.terms[row][..], PushingRow { multiplier, contact: None, corrected })
        })
    }

    /// Corrects the stops of one tree.
    fn put_tree_on_stops(
        &mut self,
        factor: &StiffFactor,
        (stops, components, tree): (&[Stop], &Components, usize),
        gap: impl Fn(&Stop, &[f64]) -> f64,
        q1: &mut [f64],
        change: &mut [f64],
        mut go: impl FnMut(&[f64], &[f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        self.rows.clear();
        self.before.copy_from_slice(q1);
        // A correction of one joint may push another beyond its stop, which then joins the problem.
        loop {
            let known = self.rows.len();
            for stop in stops {
                let is_own = self.tree_of(stop.row, components) == tree;
                if is_own && gap(stop, &*q1) < 0.0 && !self.rows.contains(&stop.row) {
                    self.rows.push(stop.row);
                }
            }
            if self.rows.len() == known {
                break;
            }
            // Together with the rows of tendons, these rows might have no feasible correction.
            if known == 0 && self.rows.iter().all(|row| *row < change.len()) {
                for stop in stops {
                    let is_own = self.tree_of(stop.row, components) == tree;
                    let is_held = stop.row < change.len() && self.holds(stop, gap(stop, q1));
                    if is_own && is_held && !self.rows.contains(&stop.row) {
                        self.rows.push(stop.row);
                    }
                }
            }
            self.problem.begin(self.rows.len());
            self.fill(factor);
            for (i, row) in self.rows.iter().enumerate() {
                let Some(stop) = nearer_stop(stops, *row, |stop| gap(stop, &self.before)) else { continue };
                let way = gap(stop, &self.before);
                if self.holds(stop, way) {
                    self.problem.release(i, stop.sign * way.min(0.0));
                } else {
                    self.problem.release_towards(stop.sign, i, stop.sign * way);
                }
            }
            self.apply(factor, change)?;
            go(change, &self.before, q1);
        }
        Ok(())
    }
}

/// The nearer one of a row's two stops.
pub(super) fn nearer_stop(stops: &[Stop], row: usize, gap: impl Fn(&Stop) -> f64) -> Option<&Stop> {
    stops.iter().filter(|stop| stop.row == row).min_by(|a, b| gap(a).total_cmp(&gap(b)))
}

/// Moves joints that are next to a stop by rounding exactly onto it.
pub(in super::super) fn land_on_stops(stops: &[Stop], q0: &[f64], q1: &mut [f64]) {
    for stop in stops {
        let Length::Coordinate(at) = stop.length else { continue };
        let gap = stop.gap(&*q1);
        if gap < ROUNDING && gap > -1e-9 && stop.gap(q0) >= 0.0 {
            q1[at] = stop.bound;
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::{Workspace, integrate};

    use super::super::super::joints::Joints;
    use super::super::super::linearization::StepRecord;
    use super::super::super::stiff_factor::StiffFactor;
    use super::super::super::test_robot::arm;
    use super::Impulses;
    use crate::contact::{Bound, Components, ContactImpulses, ImpulsiveStep};
    use crate::{ContactSet, Ground};

    /// The shoulder returns to its stop. Its inertia alone would move the elbow by −M₁₂/M₂₂ = −3 times as
    /// much, but its stop holds it.
    #[test]
    fn what_a_stop_holds_stays_as_others_go_back() {
        const BEYOND: f64 = 1e-5;
        let model = arm();
        let joints = Joints::new(&model);
        let (mut workspace, mut factor) = (Workspace::new(&model), StiffFactor::new(&model));
        factor.factor(&model, &mut workspace, &[0.0; 2], &joints, 0.0).unwrap();
        let set = ContactSet::new(&model, &[Ground::level(-9.0)]).unwrap();
        for (is_held, expected) in [(false, 3.0 * BEYOND), (true, 0.0)] {
            let mut impulses = Impulses::new(&model, &joints);
            let elbow = joints.stops.iter().find(|stop| stop.row == 1 && stop.sign > 0.0).unwrap();
            impulses.memory.held[1] = if is_held { elbow.sign } else { 0.0 };
            let (mut q, mut change) = ([BEYOND, 0.0], [0.0; 2]);
            impulses
                .put_on_stops(
                    &factor,
                    (&joints.stops, &Components::new(factor.paths().dof_parent())),
                    1e-3,
                    (&[0.0; 2], &mut q),
                    (&mut change, &mut StepRecord::default()),
                    |way, from, to| {
                        integrate(&model, from, way, to);
                    },
                )
                .unwrap();
            assert!(q[0] == 0.0 && (q[1] - expected).abs() < 1e-15, "{is_held}: {q:?}");

            let mut contacts = ContactImpulses::new(&model, set.clone());
            let bounds = joints.stops.iter().map(|stop| {
                let gap = stop.gap(&[BEYOND, 0.0][..]);
                let holds = impulses.holds(stop, gap);
                let was_violated = false;
                let terms = &impulses.terms()[stop.row][..];
                Bound { terms, sign: stop.sign, gap, holds, was_violated, moving: None }
            });
            let mut matrix = Vec::new();
            factor.write(&joints, 0.0, &mut matrix);
            let step = ImpulsiveStep { h: 1e-3, paths: factor.paths(), matrix: &matrix };
            let state = (&[BEYOND, 0.0][..], 1e-12);
            let rest = (bounds, core::iter::empty());
            assert!(contacts.lift(&model, &mut workspace, step, state, rest, &mut change));
            assert!((change[0] + BEYOND).abs() < 1e-15, "{is_held}: {change:?}");
            assert!((change[1] - expected).abs() < 1e-15, "{is_held}: {change:?}");
        }
    }
}
