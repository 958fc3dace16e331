//! The derivatives of contact forces and of contact velocities by q.
//!
//! With the contact's axes a, its point x, the force F and moment N, and the columns (u, w) of the degrees of
//! freedom at x:
//!
//! ```text
//! Gₖ = uₖ·F + wₖ·N,  c = a·(v_rel at x),  ∂(uₖ, wₖ)/∂qⱼ = (wⱼ × uₖ + uⱼ × wₖ, wⱼ × wₖ) if j carries k.
//! ```
//!
//! x and a follow the geometry ([`FrameVariation`]).

use nalgebra::Vector3;
use robot_dynamics_core::Model;
use robot_dynamics_core::model::WORLD;

use super::axes::in_world;
use super::corrected_row::CorrectedRow;
use super::frame_variation::FrameVariation;
use super::{CarriedForce, ContactImpulses, MOST_ROWS};
use crate::contact::ContactSet;
use crate::contact::shape_point::{ContactPartner, ShapePoint};
use crate::placement::Placement;

/// A degree of freedom that moves one side of a contact.
#[derive(Clone, Copy, Debug)]
struct SideDof {
    coordinate: usize,
    ratio: f64,
    /// 1 for the first body, −1 for the second.
    side: f64,
    /// One past the last degree of freedom that this one carries: of its own body or of bodies that it moves.
    end: usize,
    /// The velocity of the contact point and ω per unit rate.
    u: Vector3<f64>,
    w: Vector3<f64>,
    /// The motion of the side's body relative to the parent of this degree of freedom's body.
    dv: Vector3<f64>,
    dw: Vector3<f64>,
}

/// The outputs for one contact.
struct Outputs<'a> {
    nv: usize,
    /// nv×nv: ∂G/∂q is added.
    force: &'a mut [f64],
    /// rows×nv: ∂c/∂q is written, each row multiplied by its factor.
    velocity: Option<(&'a mut [f64], [f64; MOST_ROWS])>,
}

/// A row of a position correction that had to push.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PushingRow {
    pub multiplier: f64,
    /// The number of its contact, if it is the normal row of one.
    pub contact: Option<usize>,
    pub corrected: CorrectedRow,
}

/// The data of a contact of the recorded step, as the linearization needs them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordedContact {
    pub gap: f64,
    /// Whether its normal velocity contains a rebound, which depends on the state at the start.
    pub rebounds: bool,
    /// Whether the bodies met in this step: they did not touch at its start.
    pub is_new: bool,
}

impl ContactImpulses {
    /// Keeps the forces of the last step for the linearization of this one.
    pub(crate) fn record_start(&mut self) {
        let Self { recorded, begun_forces, memory, .. } = self;
        recorded.clear();
        begun_forces.clone_from(&memory.carried);
    }

    /// Keeps the contacts of this step for its linearization, before the position correction finds others.
    pub(crate) fn record_active(&mut self) {
        let Self { recorded, active, .. } = self;
        recorded.clone_from(active);
    }

    /// Calls `visit` with each row of the last position correction that had to push: its coordinates and
    /// entries.
    pub(crate) fn each_pushing_row(&self, mut visit: impl FnMut(&[usize], &[f64], PushingRow)) {
        let mut contacts = self.active.iter();
        self.lifts.each_block(|_, rows, support, entries| {
            let contact = contacts.next().map(|active| active.point.number);
            let multiplier = self.lifts.multiplier[rows.start];
            let corrected = self.lifted[rows.start];
            if multiplier != 0.0 || corrected.is_equality {
                visit(support, entries, PushingRow { multiplier, contact, corrected });
            }
        });
    }

    /// The same as [`vary_rows`](Self::vary_rows) for the normal rows of a position correction along `way`.
    pub(crate) fn vary_correction(
        &self,
        model: &Model,
        placement: &mut Placement,
        rows: &[PushingRow],
        way: &[f64],
        force: &mut [f64],
        velocity: &mut [f64],
    ) {
        let nv = model.nv;
        for (row, to) in rows.iter().zip(velocity.chunks_exact_mut(nv)) {
            let Some(number) = row.contact else { continue };
            let point = self.set.point(placement, number);
            let variation =
                self.frame_variation(placement, &point, |placement| self.set.point(placement, number));
            let mut along = [0.0; MOST_ROWS];
            along[0] = row.multiplier;
            let outputs = Outputs { nv, force: &mut *force, velocity: Some((to, [1.0; MOST_ROWS])) };
            vary_contact(&self.set, model, placement, &point, &variation, (&along, way), outputs);
        }
    }

    /// Adds the normal row of this contact, in a placement, to nv numbers.
    pub(crate) fn add_normal_row(
        &self,
        model: &Model,
        placement: &Placement,
        number: usize,
        row: &mut [f64],
    ) {
        let point = self.set.point(placement, number);
        self.set.each_relative_motion(model, placement, &point, |dof, velocity, _| {
            row[dof.coordinate] += dof.ratio * point.axes[0].dot(&velocity);
        });
    }

    /// The contacts of the step, and whether forces of the last step ended in it.
    pub(crate) fn recorded(&self) -> impl Iterator<Item = RecordedContact> + '_ {
        self.recorded.iter().map(|active| {
            let closing = active.point.gap.max(0.0) / super::RETURN_TIME;
            let rebounds = (active.bias - closing).abs() > 0.0;
            RecordedContact { gap: active.point.gap, rebounds, is_new: active.known.is_none() }
        })
    }

    /// The problem of the step's velocities.
    pub(crate) fn velocity_problem(&self) -> &super::ConeProblem {
        &self.problem
    }

    /// Adds ∂f/∂q of the forces f that the last step passed on, in this placement, to an nv×nv matrix.
    pub(crate) fn vary_carried(&self, model: &Model, placement: &mut Placement, by_position: &mut [f64]) {
        for carried in self.begun_forces.iter().filter(|carried| carried.acts) {
            self.vary_carried_force(model, placement, carried, 1.0, by_position);
        }
    }

    /// ∂(Aᵀp)/∂q for the impulses p of the step of h beyond those of the smooth part is added to
    /// `force`, nv×nv. ∂(A v)/∂q is written to `velocity`, rows×nv. The placement is that of the rows.
    pub(crate) fn vary_rows(
        &self,
        model: &Model,
        placement: &mut Placement,
        h: f64,
        v: &[f64],
        force: &mut [f64],
        velocity: &mut [f64],
    ) {
        let nv = model.nv;
        for active in &self.recorded {
            let point = active.point;
            let mut impulse = [0.0; MOST_ROWS];
            for (r, impulse) in impulse.iter_mut().enumerate().take(active.rows) {
                *impulse = active.scale[r] * self.problem.missing_multiplier(active.row + r);
            }
            let carried = active.known.map(|known| &self.begun_forces[known]);
            let variation =
                self.frame_variation(placement, &point, |placement| self.set.point(placement, point.number));
            let own = &mut velocity[active.row * nv..(active.row + active.rows) * nv];
            let outputs = Outputs { nv, force: &mut *force, velocity: Some((own, active.scale)) };
            vary_contact(&self.set, model, placement, &point, &variation, (&impulse, v), outputs);
            // The force of a face's moved point acted at its old place.
            if let Some(carried) = carried.filter(|carried| carried.acts && carried.seen.is_some()) {
                self.vary_carried_force(model, placement, carried, -h, force);
                let acted = carried.force.map(|force| h * force);
                let outputs = Outputs { nv, force: &mut *force, velocity: None };
                vary_contact(&self.set, model, placement, &point, &variation, (&acted, v), outputs);
            }
        }
        for gone in self.gone.iter().filter(|gone| gone.acts) {
            self.vary_carried_force(model, placement, gone, -h, force);
        }
    }

    /// Adds `times` ∂f/∂q of one force.
    fn vary_carried_force(
        &self,
        model: &Model,
        placement: &mut Placement,
        carried: &CarriedForce,
        times: f64,
        by_position: &mut [f64],
    ) {
        let point = carried.point(&self.set, placement);
        let variation =
            self.frame_variation(placement, &point, |placement| carried.point(&self.set, placement));
        let force = carried.force.map(|force| times * force);
        let outputs = Outputs { nv: model.nv, force: by_position, velocity: None };
        vary_contact(&self.set, model, placement, &point, &variation, (&force, &[]), outputs);
    }

    fn frame_variation(
        &self,
        placement: &mut Placement,
        point: &ShapePoint,
        find: impl Fn(&Placement) -> ShapePoint,
    ) -> FrameVariation {
        let [first, second, _] = bodies_of(&self.set, point);
        FrameVariation::new(placement, [first, second], point.at, find)
    }
}

/// The bodies of the first and the second shape, and the body that carries both.
fn bodies_of(set: &ContactSet, point: &ShapePoint) -> [usize; 3] {
    let first = set.shapes[point.shape].body;
    match point.against {
        ContactPartner::Ground(_) | ContactPartner::Field(_) => [first, WORLD, WORLD],
        ContactPartner::Pair(pair) => {
            let pair = &set.pairs[pair];
            [first, set.shapes[pair.shapes[1]].body, pair.common]
        }
    }
}

/// The degrees of freedom of one side, from the body to its carrier, and the motion of the body relative to
/// the carrier at v (zero for an empty v).
fn side_dofs(
    model: &Model,
    placement: &Placement,
    (body, carrier): (usize, usize),
    (side, at, v): (f64, Vector3<f64>, &[f64]),
    dofs: &mut Vec<SideDof>,
) -> [Vector3<f64>; 2] {
    let [mut dv, mut dw] = [Vector3::zeros(); 2];
    let mut moving = body;
    while moving != carrier {
        let (first, parent) = (dofs.len(), model.bodies[moving].parent);
        placement.each_motion_on(model, [moving, parent], at, |dof, u, w| {
            let rate = dof.ratio * v.get(dof.coordinate).copied().unwrap_or(0.0);
            dv += u * rate;
            dw += w * rate;
            let (coordinate, ratio) = (dof.coordinate, dof.ratio);
            dofs.push(SideDof { coordinate, ratio, side, end: 0, u, w, dv, dw });
        });
        let end = dofs.len();
        dofs[first..].iter_mut().for_each(|dof| (dof.end, dof.dv, dof.dw) = (end, dv, dw));
        moving = parent;
    }
    [dv, dw]
}

/// Computes the derivatives of one contact with this force along its axes, at v.
fn vary_contact(
    set: &ContactSet,
    model: &Model,
    placement: &Placement,
    point: &ShapePoint,
    variation: &FrameVariation,
    (along, v): (&[f64; MOST_ROWS], &[f64]),
    Outputs { nv, force: by_position, mut velocity }: Outputs<'_>,
) {
    let [first, second, common] = bodies_of(set, point);
    let mut dofs = Vec::with_capacity(32);
    let [velocity_first, spin_first] =
        side_dofs(model, placement, (first, common), (1.0, point.at, v), &mut dofs);
    let first_count = dofs.len();
    let mut relative = [velocity_first, spin_first];
    if second != WORLD {
        let [of_second, spin] = side_dofs(model, placement, (second, common), (-1.0, point.at, v), &mut dofs);
        relative = [velocity_first - of_second, spin_first - spin];
    }
    let (force, moment) = in_world(point, along);
    if let Some((rows, _)) = &mut velocity {
        rows.fill(0.0);
    }
    for j in &dofs {
        let own = [j.u, j.w];
        let of_second = if j.side < 0.0 { own } else { [Vector3::zeros(); 2] };
        let moved = own.map(|x| x * j.side);
        let (at, axes) = variation.of_motion(&point.axes, moved, of_second);
        // ∂G/∂qⱼ.
        let turned = ShapePoint { axes, ..*point };
        let (force_change, moment_change) = in_world(&turned, along);
        let begin = if j.side > 0.0 { 0 } else { first_count };
        for (index, k) in dofs.iter().enumerate() {
            let mut change = k.u.dot(&force_change) + k.w.dot(&moment_change) + k.w.cross(&at).dot(&force);
            if index >= begin && index < j.end {
                change += (j.w.cross(&k.u) + j.u.cross(&k.w)).dot(&force) + j.w.cross(&k.w).dot(&moment);
            }
            by_position[k.coordinate * nv + j.coordinate] += k.side * k.ratio * j.ratio * change;
        }
        // ∂c/∂qⱼ.
        let Some((rows, scale)) = &mut velocity else { continue };
        let bent = (j.w.cross(&j.dv) + j.u.cross(&j.dw)) * j.side + relative[1].cross(&at);
        let spun = j.w.cross(&j.dw) * j.side;
        for (r, row) in rows.chunks_exact_mut(nv).enumerate() {
            let change = if r < 3 {
                axes[r].dot(&relative[0]) + point.axes[r].dot(&bent)
            } else {
                axes[r - 3].dot(&relative[1]) + point.axes[r - 3].dot(&spun)
            };
            row[j.coordinate] += scale[r] * j.ratio * change;
        }
    }
}
