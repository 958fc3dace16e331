//! The rows of contacts, and their forces.

use nalgebra::Vector3;
use robot_dynamics_core::Model;
use robot_dynamics_description::SolverImpedance;

use super::active_set::ActiveLimits;
use super::impedance::Response;
use super::point_rows::{self, Side};
use super::reference::{RowOrigin, RowReference, StepState};
use super::{LEAST_FRICTION, SoftConstraints, SoftContact};
use crate::contact::cone_problem::{MOST_ROWS, Set};
use crate::contact::ground::axes;
use crate::contact::shape_checks::rows_of;

impl SoftConstraints {
    /// The contacts of the last state, each with force and moment in world axes.
    pub(in crate::contact) fn contact_wrenches(
        &self,
    ) -> impl Iterator<Item = (&SoftContact, Vector3<f64>, Vector3<f64>)> + Clone {
        self.contacts.iter().zip(&self.starts).map(|(contact, &row)| {
            let axes = axes(contact.normal.into());
            let (rows, scale, _) = self.scaled(contact);
            let along = |k: usize| axes[k % 3] * (self.problem.multiplier[row + k] * scale[k]);
            let force = (0..rows.min(3)).map(along).sum::<Vector3<f64>>();
            (contact, force, (3..rows).map(along).sum())
        })
    }

    /// The number of rows of a contact, their factors, and μ'.
    fn scaled(&self, contact: &SoftContact) -> (usize, [f64; MOST_ROWS], f64) {
        let friction = contact.friction.map(|friction| friction.max(LEAST_FRICTION));
        let rows = rows_of(contact.condim);
        if rows == 1 {
            return (1, [1.0; MOST_ROWS], 1.0);
        }
        let cone = friction[0] / self.impratio.sqrt();
        let [a, b, c, d, e] = friction;
        (rows, [cone, a, b, c, d, e], cone)
    }

    /// Adds all rows. Returns whether the coordinates of each constraint lie on one path to the root.
    pub(super) fn add_rows(&mut self, mut state: StepState<'_>) -> bool {
        let StepState { model, h, .. } = state;
        let active = ActiveLimits::new(&mut self.active, self.fixed.as_ref());
        let rows = (&mut self.problem, &mut self.asked);
        let mut is_tree = self.joints.add(&self.bodies, &mut state, active, rows);
        self.starts.clear();
        for index in 0..self.contacts.len() {
            let contact = self.contacts[index];
            is_tree &= self.add_contact(model, h, &contact);
        }
        is_tree
    }

    /// Adds the rows of a contact. Returns whether its coordinates lie on one path to the root.
    fn add_contact(&mut self, model: &Model, h: f64, contact: &SoftContact) -> bool {
        let mut is_tree = true;
        let (rows, scale, cone) = self.scaled(contact);
        let violation = contact.distance - contact.margin;
        let response = Response::new(&contact.softness, h, violation);
        let set = if rows == 1 { Set::Interval(0.0, f64::INFINITY) } else { Set::Cone(cone) };
        let mut weight = self.weights.frames[contact.link.index];
        let point = contact.point.into();
        let mut sides = [Some(Side::new(model, contact.link, 1.0, point)), None];
        if let Some(other) = contact.other {
            sides[1] = Some(Side::new(model, other, -1.0, point));
            weight[0] += self.weights.frames[other.index][0];
            is_tree = model.frame_of(other).body.is_none();
        }
        let axes = axes(contact.normal.into());
        let none = Vector3::zeros();
        let mut directions = [(none, none); MOST_ROWS];
        for (k, direction) in directions[..rows].iter_mut().enumerate() {
            let axis = axes[k % 3] * scale[k];
            *direction = if k < 3 { (axis, none) } else { (none, axis) };
        }
        let (bodies, problem) = (&self.bodies, &mut self.problem);
        let row = point_rows::push(problem, model, bodies, set, sides, &directions[..rows]);
        problem.soften(cone * cone * response.softness(weight[0]));
        let spring = scale[0] * response.spring;
        let of_sides =
            |solref| Response::new(&SolverImpedance { solref, ..contact.softness }, h, violation).damping;
        let side_damping = contact.solreffriction.map_or(response.damping, of_sides);
        let [velocity, spin] = contact.surface_motion.map(Vector3::from);
        for (k, axis) in axes.iter().enumerate().take(rows).skip(1) {
            self.surface_speeds.push((row + k, scale[k] * axis.dot(&velocity)));
        }
        if rows > 3 {
            self.surface_speeds.push((row + 3, scale[3] * axes[0].dot(&spin)));
        }
        let asked = RowReference::new(RowOrigin::Contact, row, response.damping, spring);
        self.asked.push(RowReference { rows, side_damping, ..asked });
        self.starts.push(row);
        is_tree
    }
}
