//! Correction of positions at the end of a step: ground, stops and equalities.

use core::ops::Range;

use robot_dynamics_core::{Model, Workspace, difference, integrate};
use robot_dynamics_integrators::IntegratorError;

use super::impulses::land_on_stops;
use super::restoration::copy_positions;
use super::{ImplicitIntegrator, ImplicitMemory};
use crate::contact::{Bound, Components, DEEP, ImpulsiveStep, Mark, ROUNDING, returns};
use crate::energy_account;
use crate::motion::step_actuation::{StepActuation, stored_energy};

/// The number of repeated searches for penetrations and violated stops, because one correction may cause
/// others.
const MOST_LIFTS: usize = 4;

/// A correction of a stop by more than this can add energy \[rad or m\].
const BEYOND: f64 = 1e-6;

impl ImplicitIntegrator {
    /// Corrects the positions at the end of the step from q. `is_written` states whether `matrix` of the
    /// memory is M̂.
    pub(super) fn correct_positions(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        q: &[f64],
        is_written: bool,
    ) -> Result<(), IntegratorError> {
        self.mark_deep_stops(q);
        let is_deep = self.components.has_any(Mark::Deep);
        let energy_before = is_deep.then(|| self.record_uncorrected(model, workspace));
        if self.contacts.is_some() {
            self.lift_from_penetrations(model, workspace, h, q, is_written);
        } else {
            self.return_to_constraints(model, workspace, h, q)?;
        }
        if let Some(energy_before) = energy_before {
            self.account_for_corrections(model, workspace, tau, energy_before);
        }
        Ok(())
    }

    /// Marks the components that start deep beyond a stop: their return moves the weight without a force.
    fn mark_deep_stops(&mut self, q: &[f64]) {
        let Self { joints, impulses, components, paths, .. } = self;
        let start = paths.at_start(q);
        for stop in joints.stops.iter().filter(|stop| stop.gap(start) < -DEEP) {
            if impulses.is_active(stop.row, components) {
                components.set(Mark::Deep, impulses.tree_of(stop.row, components));
            }
        }
    }

    /// Stores the positions before the correction, and returns their energy \[J\].
    fn record_uncorrected(&mut self, model: &Model, workspace: &mut Workspace) -> f64 {
        let Self { memory, drive, .. } = self;
        let ImplicitMemory { stage_v: v1, stage_q: q1, uncorrected, .. } = memory;
        uncorrected.copy_from_slice(q1);
        total_energy(model, workspace, drive, (q1, v1))
    }

    /// Removes penetrations, together with violated stops and equalities. One correction may cause other
    /// violations, so the search is repeated.
    fn lift_from_penetrations(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
        is_written: bool,
    ) {
        let Self {
            joints, factor, impulses, contacts, equalities, paths, memory, components, record, ..
        } = self;
        let Some(contacts) = contacts else { return };
        let ImplicitMemory { force: change, stage_q: q1, matrix, before, .. } = memory;
        if !is_written {
            factor.write(joints, 0.5 * h, matrix);
        }
        let kept = returns(h);
        for lifted in 0..MOST_LIFTS {
            paths.turn(model, workspace, q1, impulses);
            let own = joints.stops.iter().filter(|stop| impulses.is_active(stop.row, components));
            let bounds = own.map(|stop| {
                let gap = stop.gap_to_correct(paths.at_start(q), kept, paths.at_end(q1));
                // A joint may leave its stop if the correction would otherwise leave a penetration.
                let holds = lifted == 0 && impulses.holds(stop, gap);
                let was_violated = stop.gap(paths.at_start(q)) < 0.0;
                let (terms, moving) = (&impulses.terms()[stop.row][..], impulses.moving(stop.row));
                Bound { terms, sign: stop.sign, gap, holds, was_violated, moving }
            });
            let step = ImpulsiveStep { h, paths: factor.paths(), matrix };
            let rounding = ROUNDING[lifted.min(1)];
            if let Some(equalities) = equalities {
                equalities.place(model, workspace, q1);
            }
            let equal =
                equalities.iter().flat_map(|equalities| equalities.held(h, impulses.first_equality()));
            if !contacts.lift(model, workspace, step, (q1, rounding), (bounds, equal), change) {
                break;
            }
            before.copy_from_slice(q1);
            move_positions(model, components, change, before, q1);
            record.record_lift(before, change, contacts);
        }
        contacts.note_depth();
        if let Some(equalities) = equalities.as_mut().filter(|_| record.is_on) {
            equalities.place(model, workspace, q1);
            impulses.record_end(equalities, q1, change, record);
        }
        land_on_stops(&joints.stops, q, q1);
    }

    /// Returns the joints of a robot without contacts to the equality constraints. If the robot has none, it
    /// returns them to the stops.
    fn return_to_constraints(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
    ) -> Result<(), IntegratorError> {
        let Self { joints, factor, impulses, equalities, paths, memory, components, kept, record, .. } = self;
        let ImplicitMemory { force: change, stage_q: q1, .. } = memory;
        let stops = &joints.stops[..];
        paths.measure_end(model, workspace, q1);
        let end = paths.at_end(q1);
        for stop in stops.iter().filter(|stop| stop.gap(end) < -BEYOND) {
            if impulses.is_active(stop.row, components) {
                kept.is_rough[impulses.tree_of(stop.row, components)] = true;
            }
        }
        if let Some(equalities) = equalities {
            let rest = (equalities, (stops, paths), &*components);
            impulses.put_on_equalities((model, workspace), factor, rest, h, (q, q1), (change, record))
        } else {
            let state = (q, &mut q1[..]);
            impulses.put_on_stops(factor, (stops, components), h, state, (change, record), |way, from, to| {
                move_positions(model, components, way, from, to);
            })
        }
    }

    /// Adds the change of energy by the correction to the losses of each component that started deep beyond a
    /// constraint. The work of τ along the correction counts as work of the motors.
    fn account_for_corrections(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        energy_before: f64,
    ) {
        let Self { components, memory, drive, last_of, .. } = self;
        let ImplicitMemory { force: change, stage_v: v1, stage_q: q1, before, uncorrected, .. } = memory;
        for leader in components.all() {
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
            difference(model, uncorrected, corrected, change);
            let work: f64 = tau.iter().zip(&*change).map(|(tau, way)| tau * way).sum();
            let energy = total_energy(model, workspace, drive, (corrected, v1));
            last_of[leader].corrections += work + energy_before - energy;
        }
    }
}

/// The kinetic, potential and stored energy \[J\].
fn total_energy(
    model: &Model,
    workspace: &mut Workspace,
    drive: &mut Option<StepActuation>,
    (q, v): (&[f64], &[f64]),
) -> f64 {
    let of_motion = energy_account(model, workspace, q, v);
    of_motion.kinetic() + of_motion.potential() + stored_energy(drive, q)
}

/// Moves a configuration along a displacement. With several trees, joints with zero displacement keep their
/// exact value.
fn move_positions(model: &Model, components: &Components, way: &[f64], from: &[f64], to: &mut [f64]) {
    integrate(model, from, way, to);
    if components.count() > 1 {
        copy_positions(model, |own| own.map(|k| way[k]).all(|way| way == 0.0), from, to);
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::Workspace;

    use super::super::ImplicitIntegrator;
    use super::super::test_robot::arm;
    use crate::contact::returns;
    use crate::{ContactSet, Ground};

    const H: f64 = 1e-3;
    const TAU: [f64; 2] = [3.0, -1.0];

    /// Corrects `q1` after a step from `q0` of the arm, whose stops allow q₁ ≤ 0 and q₂ ≥ 0.
    fn corrected(has_contacts: bool, q0: [f64; 2], q1: [f64; 2]) -> (Vec<f64>, f64) {
        let model = arm();
        let (mut workspace, mut stepper) = (Workspace::new(&model), ImplicitIntegrator::new(&model));
        if has_contacts {
            let far_below = ContactSet::new(&model, &[Ground::level(-9.0)]).unwrap();
            stepper = stepper.with_contacts(&model, far_below);
        }
        stepper.components.begin();
        stepper.factor.factor(&model, &mut workspace, &q0, &stepper.joints, 0.5 * H).unwrap();
        stepper.memory.stage_q.copy_from_slice(&q1);
        stepper.correct_positions(&model, &mut workspace, &TAU, H, &q0, false).unwrap();
        (stepper.memory.stage_q, stepper.last_of[0].corrections)
    }

    #[test]
    fn admissible_positions_keep_their_bits() {
        for has_contacts in [false, true] {
            for q1 in [[-0.3, 0.7], [0.0, 0.0], [-1e-3, 1e-3]] {
                assert_eq!(corrected(has_contacts, [-0.1, 0.2], q1), (q1.to_vec(), 0.0));
            }
        }
    }

    /// A joint that passes its stop within a step returns to it. One that starts deep beyond it returns
    /// gradually, and the work of τ, which here changes no energy, is a loss.
    #[test]
    fn violated_stops_are_corrected() {
        const BEYOND: f64 = 1e-2;
        for has_contacts in [false, true] {
            let (q, loss) = corrected(has_contacts, [-0.1, 0.2], [BEYOND, 0.2]);
            assert!(q[0].abs() < 1e-12 && loss == 0.0, "{has_contacts}: {q:?}");
            let (q, loss) = corrected(has_contacts, [BEYOND, 0.2], [BEYOND, 0.2]);
            assert!((q[0] - BEYOND * returns(H)).abs() < 1e-12, "{has_contacts}: {q:?}");
            let work = TAU[0] * (q[0] - BEYOND) + TAU[1] * (q[1] - 0.2);
            assert!((loss - work).abs() < 1e-15, "{has_contacts}: {loss}, {work}");
        }
    }
}
