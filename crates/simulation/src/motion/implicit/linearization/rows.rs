//! The change of the impulses of contacts, stops and friction.

use core::ops::Range;

use robot_dynamics_core::{
    InverseDynamicsDerivativesMut, Model, Workspace, gravity_derivative, inverse_dynamics_derivatives,
};

use super::super::ImplicitIntegrator;
use super::columns::Columns;
use super::parameters::inertia_regressor;
use super::systems::{push_row, solve_dependent, transpose};
use crate::contact::{RETURN_TIME, Set};
use crate::motion::linearize_step::product::multiply_changes;
use crate::placement::Placement;

/// A contact is at a transition if a velocity and the distance of an impulse from its bound, as a velocity,
/// are both below this fraction of the speeds.
const TRANSITION: f64 = 1e-8;

/// The change by the impulses.
pub(super) struct ImpulseChange {
    /// The change of the velocity.
    pub(super) velocity: Vec<f64>,
    /// The change of the generalized impulses of the contacts.
    pub(super) impulse: Vec<f64>,
    pub(super) is_at_transition: bool,
}

/// A contact that slides.
struct Sliding {
    /// The positions of its normal row, and of its tangential rows, among the rows that act.
    normal: usize,
    tangential: Range<usize>,
    friction: f64,
    /// pₙ.
    pressure: f64,
    /// û = c_t/|c_t|, and μ pₙ/|c_t|.
    direction: Vec<f64>,
    ratio: f64,
}

/// The rows that act.
#[derive(Default)]
struct ActingRows {
    /// nv numbers each.
    entries: Vec<f64>,
    sources: Vec<RowSource>,
    sliding: Vec<Sliding>,
    /// Whether the step has no solution of Coulomb's law: its sliding contacts have cₙ = μ|c_t| − s with the
    /// shift s of the solver.
    is_shifted: bool,
    is_at_transition: bool,
}

/// The origin of a row.
enum RowSource {
    /// A row of the contact problem, and whether it closes a gap.
    Contact { row: usize, closing: bool },
    /// A row of a joint, tendon or equality: whether it returns to a stop by the distance at q₀, its number,
    /// and its place among the moving rows.
    Joint { returns: bool, number: usize, moving: Option<usize> },
}

impl ActingRows {
    fn push(&mut self, nv: usize, terms: impl Iterator<Item = (usize, f64)>, source: RowSource) {
        push_row(&mut self.entries, nv, terms);
        self.sources.push(source);
    }

    fn count(&self) -> usize {
        self.sources.len()
    }
}

impl ImplicitIntegrator {
    /// The change of the velocity by the impulses, for changes of q at the rows, of qₘ, and of v before.
    pub(super) fn impulse_change(
        &mut self,
        (model, workspace, placement): (&Model, &mut Workspace, &mut Placement),
        (h, columns): (f64, &Columns),
        (start, free, middle): (&[f64], &[f64], &[f64]),
        inverse: &[f64],
        (q_change, middle_change, v_change): (&[f64], &[f64], &[f64]),
    ) -> ImpulseChange {
        let (nv, width) = (model.nv, columns.width());
        let zeros = || vec![0.0; nv * width];
        let after: Vec<f64> =
            self.record.before.iter().zip(&self.record.change).map(|(v, change)| v + change).collect();
        let rows = self.acting_rows(inverse, &after);
        let start_rows = self.start_entries((model, workspace), start, &rows);

        // δ(Aᵀp) by q at fixed p, ∂c/∂q of all rows of contacts, and ∂(M̂Δ)/∂qₘ.
        let mut bend = vec![0.0; nv * nv];
        let mut velocity_by = Vec::new();
        if let Some(contacts) = &self.contacts {
            velocity_by.resize(contacts.velocity_problem().start.len() * nv, 0.0);
            contacts.vary_rows(model, placement, h, &after, &mut bend, &mut velocity_by);
        }
        let moving: Vec<_> = self.record.rows.iter().filter(|row| row.moves).collect();
        let moving: Vec<_> = moving.into_iter().map(|row| (row.number, row.multiplier)).collect();
        let moving_by = self.vary_moving_rows((model, workspace), free, &moving, &after, &mut bend);
        let inertia = inertia_derivative(model, workspace, middle, &self.record.change);
        let mut impulse = zeros();
        multiply_changes(&[(&bend, q_change)], width, &mut impulse);
        let mut right = zeros();
        multiply_changes(&[(&inertia, middle_change)], width, &mut right);
        right.iter_mut().zip(&impulse).for_each(|(sum, change)| *sum += change);
        let by_inertial = inertia_regressor(model, workspace, columns, (middle, &self.record.change));
        columns.add(&mut right, columns.first_inertial(), -1.0, &by_inertial);
        let mut velocity = zeros();
        multiply_changes(&[(inverse, &right)], width, &mut velocity);

        if rows.count() > 0 {
            // The multipliers, and their effect.
            let count = rows.count();
            let by_position = rows.position_entries([&velocity_by, &moving_by], nv);
            let change = rows.velocity_change(
                (&by_position, &start_rows),
                [v_change, &velocity],
                q_change,
                (nv, width),
            );
            let transposed = transpose(&rows.entries, count, nv);
            let mut response = vec![0.0; nv * count];
            multiply_changes(&[(inverse, &transposed)], count, &mut response);
            let mut delassus = vec![0.0; count * count];
            multiply_changes(&[(&rows.entries, &response)], count, &mut delassus);
            let (mut system, mut multipliers) = rows.system(&delassus, &change, columns);
            solve_dependent(&mut system, count, &mut multipliers, width);
            let mut more = zeros();
            multiply_changes(&[(&response, &multipliers)], width, &mut more);
            velocity.iter_mut().zip(&more).for_each(|(sum, change)| *sum += change);
            multiply_changes(&[(&transposed, &multipliers)], width, &mut more);
            impulse.iter_mut().zip(&more).for_each(|(sum, change)| *sum += change);
        }
        ImpulseChange { velocity, impulse, is_at_transition: rows.is_at_transition }
    }

    /// The rows that act, and their state, at the velocity after the impulses.
    fn acting_rows(&self, inverse: &[f64], after: &[f64]) -> ActingRows {
        let nv = after.len();
        let mut rows = ActingRows::default();
        let fastest = after.iter().fold(0.0_f64, |most, v| most.max(v.abs())).max(1.0);
        if let Some(contacts) = &self.contacts {
            let problem = contacts.velocity_problem();
            // The shift counts as constant.
            rows.is_shifted = !problem.is_coulomb;
            rows.is_at_transition = rows.is_shifted;
            let mut recorded = contacts.recorded();
            problem.each_block(|set, range, support, entries| {
                let Some(contact) = recorded.next() else { return };
                let p = &problem.multiplier[range.clone()];
                let c = &problem.c[range.clone()];
                // The normal velocity that a normal impulse of 1 N·s causes.
                let normal = support.iter().zip(entries);
                let mobility: f64 = normal
                    .clone()
                    .map(|(i, a)| {
                        let row = &inverse[i * nv..(i + 1) * nv];
                        a * normal.clone().map(|(j, b)| row[*j] * b).sum::<f64>()
                    })
                    .sum();
                let small = TRANSITION * fastest;
                rows.is_at_transition |= p[0] * mobility < small && c[0] < small;
                if p[0] * mobility <= c[0] {
                    return;
                }
                let count = support.len();
                let terms = |r: usize| {
                    support.iter().copied().zip(entries[r * count..(r + 1) * count].iter().copied())
                };
                let normal = rows.count();
                let closing = contact.gap > 0.0;
                let source = RowSource::Contact { row: range.start, closing };
                rows.push(nv, terms(0), source);
                let Set::Cone(friction) = set else { return };
                let along = |x: &[f64]| x[1..].iter().map(|x| x * x).sum::<f64>().sqrt();
                let (slip, left) = (along(c), (friction * p[0] - along(p)) * mobility);
                rows.is_at_transition |= slip < small && left.abs() < small;
                let slides = slip > left && slip > 0.0;
                let begin = rows.count();
                for r in 1..range.len() {
                    // A row without friction moments has no entries.
                    let source = RowSource::Contact { row: range.start + r, closing: false };
                    rows.push(nv, terms(r), source);
                }
                if slides {
                    let direction = c[1..].iter().map(|c| c / slip).collect();
                    let (tangential, ratio) = (begin..rows.count(), friction * p[0] / slip);
                    rows.sliding.push(Sliding {
                        normal,
                        tangential,
                        friction,
                        pressure: p[0],
                        direction,
                        ratio,
                    });
                }
            });
        }
        let mut moving = 0..;
        for joint in &self.record.rows {
            let small = TRANSITION * fastest;
            let place = if joint.moves { moving.next() } else { None };
            let speed: f64 = joint.terms.iter().map(|(k, factor)| factor * after[*k]).sum();
            if joint.is_free {
                let source = RowSource::Joint { returns: joint.returns, number: joint.number, moving: place };
                rows.push(nv, joint.terms.iter().copied(), source);
            } else {
                rows.is_at_transition |= speed.abs() < small;
            }
        }
        rows
    }

    /// The rows at q₀ of those that return to a stop, and zeros for all others.
    fn start_entries(
        &mut self,
        (model, workspace): (&Model, &mut Workspace),
        start: &[f64],
        rows: &ActingRows,
    ) -> Vec<f64> {
        let nv = model.nv;
        let mut entries = vec![0.0; rows.entries.len()];
        for (i, source) in rows.sources.iter().enumerate() {
            let RowSource::Joint { returns: true, number, moving } = *source else { continue };
            let to = &mut entries[i * nv..(i + 1) * nv];
            to.copy_from_slice(&rows.entries[i * nv..(i + 1) * nv]);
            if moving.is_some() {
                self.turn_rows(model, workspace, start, &self.kept.v.clone());
                to.fill(0.0);
                self.impulses.terms()[number].iter().for_each(|&(k, factor)| to[k] += factor);
            }
        }
        entries
    }
}

/// −∂(M(qₘ) x)/∂qₘ.
pub(super) fn inertia_derivative(
    model: &Model,
    workspace: &mut Workspace,
    middle: &[f64],
    x: &[f64],
) -> Vec<f64> {
    let nv = model.nv;
    let [mut gravity, mut inertia, mut unused] = [(); 3].map(|()| vec![0.0; nv * nv]);
    gravity_derivative(model, workspace, middle, &mut gravity);
    let still = vec![0.0; nv];
    let out = InverseDynamicsDerivativesMut { by_position: &mut inertia, by_velocity: &mut unused };
    inverse_dynamics_derivatives(model, workspace, middle, &still, x, out);
    gravity.iter_mut().zip(&inertia).for_each(|(gravity, inertia)| *gravity -= inertia);
    gravity
}

impl ActingRows {
    /// ∂c/∂q of all rows at a fixed velocity, from those of the rows of the contact problem and of the moving
    /// rows.
    fn position_entries(&self, [contacts_by, moving_by]: [&[f64]; 2], nv: usize) -> Vec<f64> {
        let mut by_position = vec![0.0; self.count() * nv];
        for (i, source) in self.sources.iter().enumerate() {
            let (to, entries) = (&mut by_position[i * nv..(i + 1) * nv], &self.entries[i * nv..(i + 1) * nv]);
            match *source {
                RowSource::Contact { row, closing } => {
                    to.copy_from_slice(&contacts_by[row * nv..(row + 1) * nv]);
                    if closing {
                        to.iter_mut().zip(entries).for_each(|(to, entry)| *to += entry / RETURN_TIME);
                    }
                }
                RowSource::Joint { moving: Some(place), .. } => {
                    to.copy_from_slice(&moving_by[place * nv..(place + 1) * nv]);
                }
                RowSource::Joint { .. } => {}
            }
        }
        by_position
    }

    /// The change of the rows' velocities at fixed multipliers, from ∂c/∂q and the rows at q₀ of returns to
    /// stops. The change of v is a sum.
    fn velocity_change(
        &self,
        (by_position, start_rows): (&[f64], &[f64]),
        v_changes: [&[f64]; 2],
        q_change: &[f64],
        (nv, width): (usize, usize),
    ) -> Vec<f64> {
        let count = self.count();
        let mut back = vec![0.0; count * width];
        for (back, entries) in back.chunks_exact_mut(width).zip(start_rows.chunks_exact(nv)) {
            back.iter_mut().zip(entries).for_each(|(to, entry)| *to = entry / RETURN_TIME);
        }
        let mut change = vec![0.0; count * width];
        let a = &self.entries[..];
        multiply_changes(
            &[(a, v_changes[0]), (a, v_changes[1]), (by_position, q_change)],
            width,
            &mut change,
        );
        change.iter_mut().zip(&back).for_each(|(sum, back)| *sum += back);
        change
    }

    /// The equations of the multipliers' changes, and their right-hand sides.
    fn system(&self, delassus: &[f64], change: &[f64], columns: &Columns) -> (Vec<f64>, Vec<f64>) {
        let (count, width) = (self.count(), columns.width());
        let mut system = delassus.to_vec();
        let mut right: Vec<f64> = change.iter().map(|x| -x).collect();
        for sliding in &self.sliding {
            let Sliding { normal, tangential, friction, pressure, direction, ratio } = sliding;
            // The pivots of these equations are comparable with those of the others.
            let scale = delassus[normal * count + normal];
            if self.is_shifted {
                for (row, along) in tangential.clone().zip(direction) {
                    let factor = friction * along;
                    for k in 0..count {
                        system[normal * count + k] -= factor * delassus[row * count + k];
                    }
                    for k in 0..width {
                        right[normal * width + k] += factor * change[row * width + k];
                    }
                }
            }
            for (r, row) in tangential.clone().enumerate() {
                let mut own = vec![0.0; count];
                let to = &mut right[row * width..(row + 1) * width];
                to.fill(0.0);
                for (s, other) in tangential.clone().enumerate() {
                    let same = if r == s { 1.0 } else { 0.0 };
                    let factor = ratio * (same - direction[r] * direction[s]);
                    for (own, entry) in own.iter_mut().zip(&delassus[other * count..(other + 1) * count]) {
                        *own += factor * entry;
                    }
                    for (to, change) in to.iter_mut().zip(&change[other * width..(other + 1) * width]) {
                        *to -= factor * change;
                    }
                }
                if columns.friction > 0 {
                    to[columns.first_friction()] -= pressure * direction[r];
                }
                own[row] += 1.0;
                own[*normal] += friction * direction[r];
                for x in own.iter_mut().chain(to.iter_mut()) {
                    *x *= scale;
                }
                system[row * count..(row + 1) * count].copy_from_slice(&own);
            }
        }
        (system, right)
    }
}
