//! The contacts of a step: the search, the trees that they join, and their rows.

use robot_dynamics_core::{Model, Workspace};

use super::contact_state::ActiveContact;
use super::contact_state::NearbyPair;
use super::memory::CarriedForce;
use super::position_correction::NEAR;
use super::{ContactImpulses, position_correction};
use crate::contact::ContactSet;
use crate::contact::components::{Components, Mark};
use crate::contact::contact_shape::ContactShape;
use crate::contact::shape_point::{ContactPartner, ShapePoint};

/// A touchdown slower than this is not an impact that divides the step \[m/s\].
pub const SLOW_TOUCHDOWN: f64 = 0.05;

/// Points of one pair closer than this are one point \[m\].
const SAME: f64 = 1e-9;

/// The correction of a penetration or violated stop deeper than this changes the energy by more than the
/// scheme's error \[rad or m\].
pub const DEEP: f64 = 1e-4;

impl ContactImpulses {
    /// Finds the contacts of the step of h that leads to q₁. Each contact joins its trees and marks their
    /// component. An impact that is not in the first of so many parts of the step marks the component as one
    /// whose step is divided.
    pub fn find(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        (h, parts): (f64, f64),
        q1: &[f64],
        components: &mut Components,
    ) {
        let Self { set, problem, start, placement, active, gone, seen, begun, memory, .. } = self;
        let carried = &memory.carried;
        for (begun, carried) in begun.iter().zip(carried) {
            components.join(carried.trees[0], carried.trees[1]);
            if begun.gap < -DEEP {
                components.set(Mark::Deep, carried.tree());
            }
        }
        seen.clear();
        seen.resize(carried.len(), false);
        placement.set(model, workspace, q1);
        active.clear();
        gone.clear();
        problem.clear();
        set.find_near(model, placement, 0.0);
        set.for_each_contact(placement, 0.0, |point| {
            let [tree, other] = set.trees(components, &point);
            components.join(tree, other);
            let known = carried.binary_search_by_key(&point.number, |carried| carried.number).ok();
            if let Some(known) = known {
                seen[known] = true;
            } else {
                let before = set.point(start, point.number).gap;
                let way = before - point.gap;
                if before < -DEEP {
                    components.set(Mark::Deep, tree.min(other));
                }
                if way > SLOW_TOUCHDOWN * h && before * parts > way {
                    components.set(Mark::Meets, tree.min(other));
                }
            }
            active.push(ActiveContact::new(point, tree.min(other), known));
        });
        // A contact of the last step stays, even if rounding opens it, so that gaps near 0 do not decide
        // which points are searched.
        for (index, (carried, _)) in carried.iter().zip(seen).enumerate().filter(|(_, (_, seen))| !**seen) {
            let point = set.point(placement, carried.number);
            let same = active.iter_mut().find(|other| is_same(&other.point, &point));
            if let Some(same) = same {
                // The point has a new number.
                if same.known.is_none() {
                    same.known = Some(index);
                } else {
                    gone.push(*carried);
                }
            } else if point.gap.is_finite() {
                active.push(ActiveContact::new(point, carried.tree(), Some(index)));
            } else if !matches!(point.against, ContactPartner::Ground(_)) {
                gone.push(*carried);
            }
        }
        for tree in active.iter().map(|active| active.tree).chain(gone.iter().map(CarriedForce::tree)) {
            components.set(Mark::Touched, tree);
        }
    }

    /// Joins components that may collide with components whose step is divided, because an impact may stop
    /// these anywhere in their step.
    pub(crate) fn join_near(&mut self, model: &Model, components: &mut Components) {
        let Self { set, start, placement, near, .. } = self;
        let way = |set: &ContactSet, shape: usize| {
            let shape = &set.shapes[shape];
            let [(turn, from), (turned, to)] =
                [&*start, &*placement].map(|placement| placement.body(shape.body));
            let way = to + turned * shape.translation - from - turn * shape.translation;
            way.norm() + (turned - turn).norm() * shape.reach + NEAR
        };
        let farthest = (0..set.shapes.len()).map(|shape| way(set, shape)).fold(0.0, f64::max);
        set.find_near(model, placement, farthest);
        near.clear();
        set.for_each_pair_contact(placement, farthest, |point| {
            if let ContactPartner::Pair(pair) = point.against {
                let shapes = set.pairs[pair].shapes;
                let trees = shapes.map(|shape| set.shapes[shape].tree(components));
                near.push(NearbyPair { trees, gap: point.gap, ways: shapes.map(|shape| way(set, shape)) });
            }
        });
        let mut is_done = false;
        while !is_done {
            is_done = true;
            for NearbyPair { trees: [one, other], gap, ways } in &*near {
                let meets = [one, other].map(|tree| components.has(Mark::Meets, *tree));
                if meets[0] != meets[1] && *gap <= if meets[0] { ways[0] } else { ways[1] } {
                    is_done &= !components.join(*one, *other);
                }
            }
        }
    }

    /// Keeps only the contacts of the active components. Those of the others stay with them.
    pub(crate) fn leave_inactive(&mut self, components: &Components) {
        self.active.retain(|active| components.is_active(active.tree));
        self.gone.retain(|gone| components.is_active(gone.tree()));
        self.look_at_active(components);
    }

    /// Activates these components, with their contacts of the last step. The search ignores the others.
    pub(crate) fn restrict(&mut self, components: &Components) {
        let Self { memory, parked, .. } = self;
        parked.append(&mut memory.carried);
        memory.carried.extend(parked.iter().filter(|carried| components.is_active(carried.tree())));
        parked.retain(|carried| !components.is_active(carried.tree()));
        memory.carried.sort_unstable_by_key(|carried| carried.number);
        self.look_at_active(components);
    }

    /// Restores the memory at the start of the step, for the active components only.
    pub(crate) fn restore_active(&mut self, begun: &super::ContactMemory, components: &Components) {
        self.memory.carried.clear();
        let own = begun.carried.iter().filter(|carried| components.is_active(carried.tree()));
        self.memory.carried.extend(own);
        self.memory.totals.retain(|total| !components.is_active(total.tree));
        for shape in &self.set.shapes {
            let tree = shape.tree(components);
            if let Some(link) = shape.on_ground.filter(|_| components.is_active(tree)) {
                self.memory.impulses[link] = begun.impulses[link];
            }
        }
    }

    /// Activates all shapes, and discards the memory of inactive components.
    pub(crate) fn begin_whole(&mut self) {
        self.parked.clear();
        self.set.set_active_shapes((0..self.set.shapes.len()).map(|_| true));
    }

    /// Searches at the end of a step whose components moved one after the other, and joins those that
    /// penetrate each other. Returns whether there are any.
    pub(crate) fn join_what_crosses(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        components: &mut Components,
    ) -> bool {
        let Self { set, placement, active, depth, .. } = self;
        placement.set(model, workspace, q);
        set.find_near(model, placement, NEAR);
        active.clear();
        *depth = 0.0;
        let mut crosses = false;
        set.for_each_contact(placement, NEAR, |point| {
            let [tree, other] = set.trees(components, &point);
            *depth = depth.max(-point.gap);
            if point.gap < -position_correction::ROUNDING[1] {
                crosses |= components.join(tree, other);
            }
            active.push(ActiveContact::new(point, tree.min(other), None));
        });
        crosses
    }

    fn look_at_active(&mut self, components: &Components) {
        let mut active = core::mem::take(&mut self.set.active);
        active.clear();
        let is_active = |shape: &ContactShape| components.is_active(shape.tree(components));
        active.extend(self.set.shapes.iter().map(is_active));
        self.set.active = active;
    }
}

/// Whether both are the same point of the same pair.
fn is_same(one: &ShapePoint, other: &ShapePoint) -> bool {
    one.against == other.against
        && matches!(one.against, ContactPartner::Pair(_))
        && (one.at - other.at).norm_squared() < SAME * SAME
}
