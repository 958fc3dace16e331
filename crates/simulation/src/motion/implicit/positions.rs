//! Correction of positions at the end of a step: ground, stops and equalities.

use core::ops::Range;

use robot_dynamics_core::{Model, Workspace, difference, integrate};
use robot_dynamics_integrators::IntegratorError;

use super::impulses::land_on_stops;
use super::joints::Stop;
use super::restoration::copy_positions;
use super::{ImplicitIntegrator, Memory};
use crate::contact::{Bound, Components, DEEP, ImpulsiveStep, Mark, ROUNDING, returns};
use crate::energy_ledger;

/// The number of repeated searches for penetrations and violated stops, because one correction may cause
/// others.
const MOST_LIFTS: usize = 4;

/// A correction of a stop by more than this can add energy \[rad or m\].
const BEYOND: f64 = 1e-6;

impl ImplicitIntegrator {
    /// Corrects the positions at the end of the step from q; `is_written` states whether `matrix` of the
    /// memory is M̂.
    pub(super) fn correct_positions(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        q: &[f64],
        mut is_written: bool,
    ) -> Result<(), IntegratorError> {
        let Self {
            joints,
            factor,
            impulses,
            contacts,
            equalities,
            memory,
            drive,
            components,
            kept,
            last_of,
            ..
        } = self;
        let Memory { force: change, stage_v: v1, stage_q: q1, matrix, before, uncorrected, .. } = memory;
        let has_stops = self.has_stops && joints.has_stops();
        let stops = if self.has_stops { &joints.stops[..] } else { &[] };
        let is_active = |components: &Components, stop: &&Stop| {
            components.is_active(components.tree_of_row(&joints.rows[stop.row]))
        };
        // The return from a deep penetration at the start moves the weight without a force.
        for stop in stops.iter().filter(|stop| stop.gap(q) < -DEEP) {
            if is_active(components, &stop) {
                components.set(Mark::Deep, impulses.tree_of(stop.row, components));
            }
        }
        let is_deep = components.has_any(Mark::Deep);
        let mut energy = |workspace: &mut Workspace, q: &[f64], v: &[f64]| {
            let of_motion = energy_ledger(model, workspace, q, v);
            let stored = drive.as_mut().map_or(0.0, |drive| drive.stored_energy(q));
            of_motion.kinetic() + of_motion.potential() + stored
        };
        let mut energy_before = 0.0;
        if is_deep {
            energy_before = energy(workspace, q1, v1);
            uncorrected.copy_from_slice(q1);
        }
        if let Some(contacts) = contacts {
            let left = returns(h);
            for lifted in 0..MOST_LIFTS {
                let own = stops.iter().filter(|stop| is_active(components, stop));
                let bounds = own.map(|stop| {
                    let gap = stop.gap(q1) - stop.gap(q).min(0.0) * left;
                    // A joint may leave its stop if the correction would otherwise leave a penetration.
                    let holds = lifted == 0 && impulses.holds(stop, gap);
                    Bound { terms: &impulses.terms()[stop.row], sign: stop.sign, gap, holds }
                });
                if !is_written {
                    factor.write(joints, 0.5 * h, matrix);
                    is_written = true;
                }
                let step = ImpulsiveStep { h, paths: factor.paths(), matrix };
                let rounding = ROUNDING[lifted.min(1)];
                if let Some(equalities) = equalities {
                    equalities.place(model, workspace, q1);
                }
                let equal = equalities.iter().flat_map(|equalities| equalities.held(h));
                if !contacts.lift(model, workspace, step, (q1, rounding), (bounds, equal), change) {
                    break;
                }
                before.copy_from_slice(q1);
                move_positions(model, components, change, before, q1);
            }
            contacts.note_depth();
            land_on_stops(stops, q, q1);
        } else if equalities.is_some() || has_stops {
            for stop in stops.iter().filter(|stop| is_active(components, stop) && stop.gap(q1) < -BEYOND) {
                kept.is_rough[impulses.tree_of(stop.row, components)] = true;
            }
            if let Some(equalities) = equalities {
                let robot = (model, &mut *workspace);
                let rest = (equalities, stops, &*components);
                impulses.put_on_equalities(robot, factor, rest, h, (q, q1), change)?;
            } else {
                let rest = (stops, &*components);
                impulses.put_on_stops(factor, rest, h, (q, q1), change, |way, from, to| {
                    move_positions(model, components, way, from, to);
                })?;
            }
        }
        for leader in
            (0..components.count()).filter(|leader| is_deep && components.leader(*leader) == *leader)
        {
            if !components.has(Mark::Deep, leader) || !components.is_active(leader) {
                continue;
            }
            let is_own =
                |mut own: Range<usize>| own.any(|k| components.leader(components.tree_of(k)) == leader);
            let corrected = if components.is_one() {
                &*q1
            } else {
                before.copy_from_slice(uncorrected);
                copy_positions(model, is_own, q1, before);
                &*before
            };
            // The work of τ along the correction counts as work of the motors.
            difference(model, uncorrected, corrected, change);
            let work: f64 = tau.iter().zip(&*change).map(|(tau, way)| tau * way).sum();
            last_of[leader].corrections += work + energy_before - energy(workspace, corrected, v1);
        }
        Ok(())
    }
}

/// Moves a configuration along a displacement. With several trees, joints with zero displacement keep their
/// exact value.
fn move_positions(model: &Model, components: &Components, way: &[f64], from: &[f64], to: &mut [f64]) {
    integrate(model, from, way, to);
    if components.count() > 1 {
        copy_positions(model, |own| own.map(|k| way[k]).all(|way| way == 0.0), from, to);
    }
}
