//! The rows of joints and tendons at a configuration.

use nalgebra::Vector3;
use robot_dynamics_description::{Quaternion, SolverImpedance};

use super::active_set::ActiveLimits;
use super::impedance::Response;
use super::point_rows::Bodies;
use super::reference::{RowOrigin, RowReference, StepState};
use super::rows::JointRows;
use crate::contact::ConeProblem;
use crate::contact::cone_problem::Set;

/// The force of a row that can only push, and of a row that pushes and pulls.
const HALF_LINE: Set = Set::Interval(0.0, f64::INFINITY);
const LINE: Set = Set::Interval(f64::NEG_INFINITY, f64::INFINITY);

/// The problem that rows are added to, with their references.
struct RowBuilder<'a> {
    problem: &'a mut ConeProblem,
    asked: &'a mut Vec<RowReference>,
}

impl RowBuilder<'_> {
    /// Dry friction of at most `most` along these derivatives.
    fn push_friction(
        &mut self,
        h: f64,
        most: f64,
        derivatives: &[(usize, f64)],
        (softness, weight): (&SolverImpedance, f64),
    ) {
        let response = Response::new(softness, h, 0.0);
        let row = self.problem.push_row(Set::Interval(-most, most), 1.0, derivatives);
        self.problem.soften(response.softness(weight));
        self.asked.push(RowReference::new(RowOrigin::Friction, row, response.damping, 0.0));
    }

    /// A limit of a tendon by its number, at a distance that the margin is subtracted from.
    fn push_tendon_limit(
        &mut self,
        (h, distance): (f64, f64),
        (number, sign): (usize, f64),
        derivatives: &[(usize, f64)],
        (softness, weight): (&SolverImpedance, f64),
    ) {
        let response = Response::new(softness, h, distance);
        let row = self.problem.push_row(HALF_LINE, sign, derivatives);
        self.problem.soften(response.softness(weight));
        let origin = RowOrigin::TendonLimit(number, sign);
        self.asked.push(RowReference::new(origin, row, response.damping, response.spring));
    }
}

impl JointRows {
    /// Adds the rows at q. Returns whether the coordinates of each lie on one path to the root.
    pub(super) fn add(
        &mut self,
        bodies: &Bodies,
        state: &mut StepState<'_>,
        mut active: ActiveLimits<'_>,
        (problem, asked): (&mut ConeProblem, &mut Vec<RowReference>),
    ) -> bool {
        let StepState { h, q, .. } = *state;
        let mut rows = RowBuilder { problem, asked };
        if state.dissipates {
            self.add_friction_rows(h, &mut rows);
        }
        self.add_limit_rows((q, h), &mut active, &mut rows);
        self.add_turn_rows((q, h), &mut active, &mut rows);
        self.add_tendon_rows((q, h), &mut active, &mut rows);
        self.add_equality_rows(bodies, state, &mut rows);
        self.add_path_rows(bodies, state, &mut active, &mut rows);
        let RowBuilder { problem, asked } = rows;
        for connection in &self.connections {
            connection.add(bodies, state, problem, asked);
        }
        self.keeps_tree
    }

    fn add_friction_rows(&self, h: f64, rows: &mut RowBuilder<'_>) {
        for friction in &self.frictions {
            let response = (&friction.softness, friction.weight);
            rows.push_friction(h, friction.most, &friction.derivatives, response);
        }
    }

    fn add_limit_rows(
        &self,
        (q, h): (&[f64], f64),
        active: &mut ActiveLimits<'_>,
        rows: &mut RowBuilder<'_>,
    ) {
        for (number, limit) in self.limits.iter().enumerate() {
            let distance = limit.sign * (limit.ratio * q[limit.q] + limit.offset - limit.bound);
            if !active.admits(number, distance < limit.margin) {
                continue;
            }
            let response = Response::new(&limit.softness, h, distance - limit.margin);
            let row = rows.problem.push(HALF_LINE, 1, core::iter::once(limit.coordinate));
            rows.problem.last().1[0] = limit.sign * limit.ratio;
            rows.problem.soften(response.softness(limit.weight));
            rows.asked.push(RowReference::new(
                RowOrigin::Limit(limit.coordinate, limit.sign * limit.ratio),
                row,
                response.damping,
                response.spring,
            ));
        }
    }

    fn add_turn_rows(&self, (q, h): (&[f64], f64), active: &mut ActiveLimits<'_>, rows: &mut RowBuilder<'_>) {
        let first = self.limits.len();
        for (number, turn) in self.turns.iter().enumerate() {
            // The angle changes with the component of the angular velocity along the axis, which is the same
            // in both frames.
            let [x, y, z, w] = [0, 1, 2, 3].map(|k| q[turn.q + k]);
            let turned = Vector3::from(Quaternion::from_xyzw([x, y, z, w]).log());
            let angle = turned.norm();
            let distance = turn.most - angle;
            if !active.admits(first + number, distance < turn.margin && angle != 0.0) || angle == 0.0 {
                continue;
            }
            let response = Response::new(&turn.softness, h, distance - turn.margin);
            let row = rows.problem.push(HALF_LINE, 1, turn.coordinate..turn.coordinate + 3);
            rows.problem.last().1.copy_from_slice((turned / -angle).as_slice());
            rows.problem.soften(response.softness(turn.weight));
            rows.asked.push(RowReference::new(RowOrigin::Stop, row, response.damping, response.spring));
        }
    }

    fn add_tendon_rows(
        &self,
        (q, h): (&[f64], f64),
        active: &mut ActiveLimits<'_>,
        rows: &mut RowBuilder<'_>,
    ) {
        let first = self.limits.len() + self.turns.len();
        for (number, limit) in self.tendons.iter().enumerate() {
            let distance = limit.sign * (limit.length.at(q) - limit.bound) - limit.softness.margin;
            if active.admits(first + number, distance < 0.0) {
                let response = (&limit.softness.limit, limit.weight);
                rows.push_tendon_limit(
                    (h, distance),
                    (limit.number, limit.sign),
                    &limit.derivatives,
                    response,
                );
            }
        }
    }

    /// Adds dry friction and limits of spatial tendons.
    fn add_path_rows(
        &self,
        bodies: &Bodies,
        state: &StepState<'_>,
        active: &mut ActiveLimits<'_>,
        rows: &mut RowBuilder<'_>,
    ) {
        let (h, nv) = (state.h, state.v.len());
        let mut number = self.limits.len() + self.turns.len() + self.tendons.len();
        for path in &self.paths {
            let mut row = vec![0.0; nv];
            let length = path.path.length_and_row(state.model, &bodies.placement, &mut row);
            let derivatives: Vec<(usize, f64)> = path.support.iter().map(|&k| (k, row[k])).collect();
            if path.most > 0.0 && state.dissipates {
                rows.push_friction(h, path.most, &derivatives, (&path.softness.friction, path.weight));
            }
            for &(bound, sign) in &path.bounds {
                let distance = sign * (length - bound) - path.softness.margin;
                if active.admits(number, distance < 0.0) {
                    let response = (&path.softness.limit, path.weight);
                    rows.push_tendon_limit((h, distance), (path.number, sign), &derivatives, response);
                }
                number += 1;
            }
        }
    }

    /// Adds polynomial relations of joints and of tendons.
    fn add_equality_rows(&mut self, bodies: &Bodies, state: &StepState<'_>, rows: &mut RowBuilder<'_>) {
        let StepState { h, q, model, .. } = *state;
        for equal in &self.equalities {
            let row = rows.problem.push(LINE, 1, equal.support.iter().copied());
            let (support, entries) = rows.problem.last();
            let place = (&bodies.placement, q);
            let error = equal.relation.place(model, place, &mut self.memory, |k, entry| {
                if let Ok(at) = support.binary_search(&k) {
                    entries[at] += entry;
                }
            });
            let response = Response::new(&equal.softness, h, error);
            rows.problem.soften(response.softness(equal.weight));
            rows.asked.push(RowReference::new(RowOrigin::Stop, row, response.damping, response.spring));
        }
    }
}
