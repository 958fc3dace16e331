//! One step: the smooth part, then the impulses of what does not yield, then the positions.

use core::ops::Range;

use dynamics::{DynamicsError, IntegratorError, check_finite};

use super::impulses::land_on_stops;
use super::kept::{copy_active, copy_positions};
use super::{Implicit, Memory};
use crate::contact::{Bound, Components, ContactImpulses, DEEP, ImpulsiveStep, Mark, ROUNDING, returns};
use crate::motion::simulate::Losses;
use crate::{Model, Workspace, difference, energy_ledger, integrate};

/// How often what is below the ground or beyond a stop is looked for again, as moving it may move others there.
const MOST_LIFTS: usize = 4;

/// Components that meet a stop or the ground in a step take it again in so many parts, as what acts before the impact and after it
/// differs.
pub(super) const PARTS: u32 = 16;

/// Being moved back onto a stop from further beyond it than this can make energy \[rad or m\].
const BEYOND: f64 = 1e-6;

/// Whether a step that ends beyond a stop may be taken as it is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Whole {
    OrNothing,
    AsItIs,
}

impl Implicit {
    /// A step of h of the components that move; or, if some meet something in it and that is asked for, false. Then these have the mark, and the step was
    /// that of the others, which alone move now; where there are no others, all move and no step was taken.
    pub(super) fn advance(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
        whole: Whole,
    ) -> Result<bool, IntegratorError> {
        self.check_interrupt()?;
        self.translations.begin(model, workspace, h, (q, v));
        self.smooth(model, workspace, tau, h, (q, v))?;
        let Self {
            joints,
            factor,
            impulses,
            contacts,
            equalities,
            translations,
            memory,
            interrupt,
            drive,
            components,
            kept,
            lost,
            last_of,
            ..
        } = self;
        let Memory {
            force: change,
            stage_v: v1,
            stage_q: q1,
            displacement,
            matrix,
            before,
            uncorrected,
            applied: external,
            ..
        } = memory;
        lost.fill(Losses::default());
        components.clear_found();
        let mut is_taken_by_all = true;
        let has_stops = self.has_stops && joints.has_stops();
        let may_act = joints.has_friction()
            || has_stops
            || impulses.acts()
            || contacts.is_some()
            || equalities.is_some();
        let stops = if self.has_stops { &joints.stops[..] } else { &[] };
        // Whether `matrix` is M̂.
        let mut is_written = false;
        if may_act {
            integrate(model, q, displacement, q1);
            if let Some(contacts) = contacts {
                contacts.find(model, workspace, (h, f64::from(PARTS)), q1, components);
            }
            if whole == Whole::OrNothing {
                for stop in stops.iter().filter(|stop| impulses.meets(stop, q, q1)) {
                    components.set(Mark::Meets, impulses.tree_of(stop.row, components));
                }
                if components.has_any(Mark::Meets) {
                    is_taken_by_all = false;
                    if let Some(contacts) = contacts.as_mut().filter(|_| !components.is_one()) {
                        contacts.join_near(model, components);
                    }
                    if !components.activate_marked(Mark::Meets, false) {
                        components.activate_all();
                        return Ok(false);
                    }
                    if let Some(contacts) = contacts {
                        contacts.leave_inactive(components);
                    }
                }
            }
            translations.restore(model, workspace, joints, q1, v1);
            let touches = contacts.as_ref().is_some_and(ContactImpulses::touches);
            impulses.turn(stops, q1, v1);
            impulses.choose(joints, stops, h, (q, q1), components);
            // For impulses g = ½h: their positions are ½h of their velocities, so that damping takes from them what it books. Contacts have a
            // problem with a factor of its own.
            if equalities.is_some() || !touches || impulses.has_rows_apart(components) {
                factor.stiffen(joints, 0.5 * h)?;
            }
            if let Some(equalities) = equalities {
                equalities.place(model, workspace, q1);
                equalities.choose(factor, interrupt, components)?;
                impulses.hold(equalities);
                impulses.choose_held();
            }
            let mut met = false;
            if let Some(contacts) = contacts.as_mut().filter(|_| touches) {
                factor.write(joints, 0.5 * h, matrix);
                is_written = true;
                let step = ImpulsiveStep { h, paths: factor.paths(), matrix };
                let (rows, multipliers) = impulses.rows_beside(components);
                if !contacts.solve(model, step, (v, v1), rows, multipliers, change) {
                    let quantity = "the impulse of the contacts";
                    return Err(DynamicsError::NonFinite { quantity, index: 0 }.into());
                }
                impulses.take_multipliers(components);
                if !translations.is_empty() {
                    contacts.coordinate_impulses(external);
                }
                met = true;
            }
            if impulses.has_rows_apart(components) {
                impulses.solve_apart(factor, v1, components, change)?;
                if !translations.is_empty() {
                    let product = impulses.multiply_mass_apart(factor, change);
                    for k in 0..v.len() {
                        if !components.has(Mark::Touched, components.tree_of(k)) {
                            external[k] = product[k];
                        }
                    }
                }
                met = true;
            }
            if met {
                if !translations.is_empty() {
                    translations.add(model, q1, |k| external[k]);
                }
                for k in 0..v.len() {
                    v1[k] += change[k];
                    displacement[k] += 0.5 * h * change[k];
                }
                impulses.rest(v, v1, displacement);
                impulses.mark_hits(v, components);
            }
            if let Some(contacts) = contacts {
                contacts.account(h, components, |leader, loss| {
                    lost[leader].sliding += loss.friction;
                    lost[leader].impacts += loss.impacts;
                });
            }
            impulses.account(joints, h, (v, v1), components, lost);
            if let Some(equalities) = equalities.as_mut().filter(|_| met) {
                equalities.settle(h, impulses.of_held(), components);
            }
        }
        // ∫Dv·v dt as the impulse D∫v dt times the mean velocity: what the step's momentum lost of energy.
        for k in (0..v.len()).filter(|k| components.moves(*k)) {
            let damping = joints.damping[k] * displacement[k] * 0.5 * (v[k] + v1[k]);
            lost[components.leader(components.tree_of(k))].damping += damping;
        }
        for (last, lost) in last_of.iter_mut().zip(&*lost) {
            add_lost(last, lost, joints.adds_energy);
        }
        check_finite("v after the step", v1)?;
        kept.see(components, v1);
        integrate(model, q, displacement, q1);
        // The return from a deep start moves weight without a force.
        for stop in stops.iter().filter(|stop| stop.gap(q) < -DEEP) {
            components.set(Mark::Deep, impulses.tree_of(stop.row, components));
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
                let own = stops.iter().filter(|stop| impulses.is_active(stop.row, components));
                let bounds = own.map(|stop| {
                    let gap = stop.gap(q1) - stop.gap(q).min(0.0) * left;
                    // Where that leaves something below, it may move.
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
            for stop in stops.iter().filter(|stop| stop.gap(q1) < -BEYOND) {
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
            // τ along that way counts as work of the motors.
            difference(model, uncorrected, corrected, change);
            let work: f64 = tau.iter().zip(&*change).map(|(tau, way)| tau * way).sum();
            last_of[leader].corrections += work + energy_before - energy(workspace, corrected, v1);
        }
        check_finite("q after the step", q1)?;
        translations.restore(model, workspace, joints, q1, v1);
        // A solver that was interrupted left no result.
        if self.interrupt.is_set() {
            return Err(IntegratorError::Interrupted);
        }
        copy_active(model, components, (q1, v1), (q, v));
        Ok(is_taken_by_all)
    }
}

/// Moves a configuration along a displacement; where there are several trees, joints that are not moved stay to the last digit.
fn move_positions(model: &Model, components: &Components, way: &[f64], from: &[f64], to: &mut [f64]) {
    integrate(model, from, way, to);
    if components.count() > 1 {
        copy_positions(model, |own| own.map(|k| way[k]).all(|way| way == 0.0), from, to);
    }
}

/// Adds the losses of one pass of a component.
fn add_lost(last: &mut Losses, lost: &Losses, adds_energy: bool) {
    // Where stiff damping overshot, friction has the wrong sign over the step: that is taken from damping.
    let overshot = lost.friction.min(0.0) + lost.stops.min(0.0);
    let damping = lost.damping + overshot;
    last.damping += if adds_energy { damping } else { damping.max(0.0) };
    last.friction += lost.friction.max(0.0);
    last.stops += lost.stops.max(0.0);
    // In an impact friction may give what the normal impulses take, and the other way round: together they take. Where contacts
    // stick or roll, what then is below zero is the scheme's own error, and no energy that comes back.
    let (sliding, impacts) = (lost.sliding, lost.impacts);
    last.sliding += (sliding + impacts.min(0.0)).max(0.0);
    last.impacts += (impacts + sliding.min(0.0)).max(0.0);
}
