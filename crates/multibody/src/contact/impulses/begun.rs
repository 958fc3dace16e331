//! Where a step starts: what touched in the last one, with the forces that go on.

use nalgebra::Vector3;

use super::relative::along_axes;
use super::{ContactImpulses, MOST_ROWS, in_world};
use crate::contact::placement::Placement;
use crate::{Model, Workspace};

/// A contact of the last step where a step starts: how far away it is, and its velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begun {
    pub(super) number: usize,
    pub(super) gap: f64,
    pub(super) velocity: [f64; MOST_ROWS],
}

impl ContactImpulses {
    /// Begins a step at (q, v); the forces of the last one to `forces`.
    pub(crate) fn begin(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        (q, v): (&[f64], &[f64]),
        forces: &mut [f64],
    ) {
        // Mostly the last step looked there last.
        if self.placement.is_at(q) {
            core::mem::swap(&mut self.start, &mut self.placement);
        } else if !self.start.is_at(q) {
            self.start.set(model, workspace, q);
        }
        let acts = self.acts();
        let Self { set, start, begun, memory, .. } = self;
        begun.clear();
        for carried in &memory.carried {
            let point = set.point(start, carried.number);
            let (force, moment) = in_world(&point, &carried.force);
            let (mut velocity, mut spin) = (Vector3::zeros(), Vector3::zeros());
            set.each_relative_motion(model, start, &point, |dof, u, w| {
                let rate = dof.ratio * v[dof.coordinate];
                velocity += u * rate;
                spin += w * rate;
                if acts {
                    forces[dof.coordinate] += dof.ratio * (force.dot(&u) + moment.dot(&w));
                }
            });
            let (number, velocity) = (carried.number, along_axes(&point, &velocity, &spin));
            begun.push(Begun { number, gap: point.gap, velocity });
        }
    }

    /// The forces of the last step in the configuration q.
    pub(crate) fn carry(&mut self, model: &Model, workspace: &mut Workspace, q: &[f64], forces: &mut [f64]) {
        if self.acts() {
            self.placement.set(model, workspace, q);
            self.add_carried(model, &self.placement, forces);
        }
    }

    fn add_carried(&self, model: &Model, placement: &Placement, forces: &mut [f64]) {
        if !self.acts() {
            return;
        }
        for carried in &self.memory.carried {
            let point = self.set.point(placement, carried.number);
            let (force, moment) = in_world(&point, &carried.force);
            self.set.each_relative_motion(model, placement, &point, |dof, velocity, spin| {
                forces[dof.coordinate] += dof.ratio * (force.dot(&velocity) + moment.dot(&spin));
            });
        }
    }
}
