//! The start of a step: the contacts of the last one, and the forces that continue.

use nalgebra::Vector3;
use robot_dynamics_core::{Model, Workspace};

use super::ContactImpulses;
use super::axes::along_axes;
use super::contact_state::ActiveContact;
use super::contact_state::InitialContact;
use super::memory::CarriedForce;
use crate::contact::shape_point::{ContactPartner, ShapePoint};

/// The fewest points of two links that form a face.
const FACE: usize = 3;

impl ContactImpulses {
    /// Starts a step at (q, v).
    pub fn begin(&mut self, model: &Model, workspace: &mut Workspace, (q, v): (&[f64], &[f64])) {
        // Usually the last search of the last step was there, and found the points that still touch.
        let was_looked_at = self.placement.is_at(q);
        if was_looked_at {
            core::mem::swap(&mut self.start, &mut self.placement);
        } else if !self.start.is_at(q) {
            self.start.set(model, workspace, q);
        }
        let Self { set, start, active, begun, velocities, memory, .. } = self;
        begun.clear();
        if memory.carried.is_empty() {
            return;
        }
        for carried in &memory.carried {
            set.make_touched(model, carried.number);
        }
        start.velocities(model, v, velocities);
        let mut met = None;
        // Usually both lists have the same order.
        let mut next = 0;
        for carried in &memory.carried {
            let is_it = |seen: &ActiveContact| seen.point.number == carried.number;
            let found = was_looked_at.then(|| {
                let after = active[next..].iter().position(is_it).map(|at| next + at);
                after.or_else(|| active[..next].iter().position(is_it))
            });
            let seen = found.flatten().map(|at| &active[at]);
            next = found.flatten().map_or(next, |at| at + 1);
            let point = match seen {
                Some(ActiveContact { point, .. }) if matches!(point.against, ContactPartner::Ground(_)) => {
                    *point
                }
                _ => set.point_after(start, carried.number, &mut met),
            };
            let [mut velocity, mut spin] = [Vector3::zeros(); 2];
            for (body, sign) in set.sides(&point) {
                let [u, w] = velocities[body];
                velocity += (u + w.cross(&(point.at - start.origin(body)))) * sign;
                spin += w * sign;
            }
            let (number, velocity) = (carried.number, along_axes(&point, &velocity, &spin));
            begun.push(InitialContact { number, gap: point.gap, velocity });
        }
    }

    /// Computes the forces of the last step, in the configuration q, into `forces`.
    pub fn carry(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64], forces: &mut [f64]) {
        if !self.acts() {
            return;
        }
        let Self { set, placement, wrenches, memory, .. } = self;
        placement.set(model, workspace, q);
        wrenches.fill(Default::default());
        for carried in memory.carried.iter().filter(|carried| carried.acts) {
            set.add_wrench(&carried.point(set, placement), &carried.force, wrenches);
        }
        placement.add_forces(model, wrenches, forces);
    }

    /// Adds the impulses of the smooth part at points that are not in the problem: of contacts that ended,
    /// and of faces whose points moved.
    pub(super) fn count_what_acted(&mut self, model: &Model, h: f64) {
        if !self.acts() {
            return;
        }
        let Self { set, problem, placement, wrenches, active, gone, memory, .. } = self;
        wrenches.fill(Default::default());
        let mut is_elsewhere = false;
        let mut add = |point: &ShapePoint, carried: &CarriedForce, h: f64| {
            set.add_wrench(point, &carried.force.map(|force| h * force), wrenches);
            is_elsewhere = true;
        };
        for gone in gone.iter().filter(|gone| gone.acts) {
            add(&gone.point(set, placement), gone, h);
        }
        for active in &*active {
            let Some(carried) = active.known.map(|known| &memory.carried[known]) else { continue };
            if carried.acts && carried.seen.is_some() {
                add(&carried.point(set, placement), carried, h);
                add(&active.point, carried, -h);
            }
        }
        if is_elsewhere {
            placement.add_forces(model, wrenches, &mut problem.force);
        }
    }

    /// The point fixed to the first link, if it is one of a face of two links. (The point on which a ball
    /// rolls moves with the ball.)
    pub(super) fn seen_on_face(&self, point: &ShapePoint) -> Option<ShapePoint> {
        let ContactPartner::Pair(pair) = point.against else { return None };
        let first = self.touching_pairs.partition_point(|other| *other < pair);
        let alike = self.touching_pairs[first..].iter().take_while(|other| **other == pair);
        (alike.take(FACE).count() == FACE).then(|| CarriedForce::seen(&self.set, &self.placement, point))
    }

    /// Lists the pair of each contact, for [`seen_on_face`](Self::seen_on_face).
    pub(super) fn list_touching_pairs(&mut self) {
        let Self { active, touching_pairs, .. } = self;
        touching_pairs.clear();
        touching_pairs.extend(active.iter().filter_map(|active| match active.point.against {
            ContactPartner::Pair(pair) => Some(pair),
            ContactPartner::Ground(_) | ContactPartner::Field(_) => None,
        }));
        touching_pairs.sort_unstable();
    }
}
