//! The forces and energy losses of a step.

use super::axes::in_world;
use super::contact_state::ActiveContact;
use super::memory::{CarriedForce, TotalImpulse};
use super::{ContactImpulses, MOST_ROWS, QUIET};
use crate::contact::components::{Components, Mark};
use crate::contact::shape_point::ContactPartner;

/// The energy that contacts took out of a step, by cause \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactLosses {
    pub friction: f64,
    pub(crate) impacts: f64,
}

impl ContactImpulses {
    /// Calls `lose` with the losses of each row and the first tree of its component: −p times the mean of the
    /// velocities before and after. The forces are kept for the next step. They continue in it unless their
    /// component had an impact, on a contact or a joint's stop.
    pub fn account(
        &mut self,
        h: f64,
        components: &mut Components,
        mut lose: impl FnMut(usize, ContactLosses),
    ) {
        for active in &self.active {
            if active.known.is_none() && -active.before[0] > QUIET {
                components.set(Mark::Hit, active.tree);
            }
        }
        let mut carried = core::mem::take(&mut self.memory.carried);
        // The contacts of components that are inactive.
        self.parked.extend(carried.iter().filter(|carried| !components.is_active(carried.tree())));
        carried.clear();
        self.list_touching_pairs();
        let summed = self.memory.totals.len();
        for active in &self.active {
            let ActiveContact { point, tree, .. } = *active;
            let leader = components.leader_or_first(tree);
            let before = &active.before;
            let mut force = [0.0; MOST_ROWS];
            for r in (0..active.rows).filter(|r| active.scale[*r] > 0.0) {
                let p = self.problem.multiplier[active.row + r];
                let bias = if r == 0 { active.bias } else { 0.0 };
                let relative = (self.problem.c[active.row + r] - bias) / active.scale[r];
                let after = relative - active.surface_motion[r];
                force[r] = p * active.scale[r] / h;
                let lost = -force[r] * h * 0.5 * (before[r] + after);
                let (friction, impacts) = if r == 0 { (0.0, lost) } else { (lost, 0.0) };
                lose(leader, ContactLosses { friction, impacts });
            }
            if force[0] > 0.0 {
                let (world, moment) = in_world(&point, &force);
                if let (ContactPartner::Ground(_) | ContactPartner::Field(_), Some(link)) =
                    (point.against, self.set.shapes[point.shape].on_ground)
                {
                    (0..3).for_each(|k| self.memory.impulses[link][k] += h * world[k]);
                }
                let shift = self.problem.shift_of(active.row);
                let seen = self.seen_on_face(&point);
                let (number, acts) = (point.number, !components.has(Mark::Hit, tree));
                let total =
                    TotalImpulse { number, tree, impulse: h * world, angular: h * moment, point, seen };
                self.memory.add_impulse(summed, &total);
                let trees = self.set.trees(components, &point);
                carried.push(CarriedForce { number, trees, acts, force, shift, seen });
            }
        }
        self.memory.totals.sort_unstable_by_key(|total| total.number);
        carried.sort_unstable_by_key(|carried| carried.number);
        self.memory.carried = carried;
    }
}
