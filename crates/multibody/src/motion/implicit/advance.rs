//! One step: the smooth part, then the impulses of what does not yield, then the positions.

use dynamics::{DynamicsError, IntegratorError, check_finite};

use super::impulses::land_on_stops;
use super::{Implicit, Memory, joints};
use crate::contact::{Bound, ContactImpulses, ImpulsiveStep, ROUNDING, returns};
use crate::motion::simulate::Losses;
use crate::{Model, Workspace, difference, energy_ledger, integrate};

/// How often what is below the ground or beyond a stop is looked for again, as moving it may move others there.
const MOST_LIFTS: usize = 4;

/// A step in which something meets a stop or the ground is taken again in so many parts, as what acts before the impact and after it
/// differs.
pub(super) const PARTS: u32 = 16;

/// Being moved back onto a stop from further beyond it than this can make energy \[rad or m\].
const BEYOND: f64 = 1e-6;

/// The return from deeper than this below the ground or beyond a stop changes the energy by more than the scheme's error \[rad or m\].
const DEEP: f64 = 1e-4;

/// Whether a step that ends beyond a stop may be taken as it is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Whole {
    OrNothing,
    AsItIs,
}

impl Implicit {
    /// A step of h, in so many parts where something is met.
    pub(super) fn advance_whole(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), IntegratorError> {
        if !self.advance(model, workspace, tau, h, (q, v), Whole::OrNothing)? {
            self.kept.is_rough = true;
            for _ in 0..PARTS {
                self.advance(model, workspace, tau, h / f64::from(PARTS), (q, v), Whole::AsItIs)?;
            }
        }
        Ok(())
    }

    /// A step of h; or, where a stop is met in it and that is asked for, none: false then.
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
        let mut by_impulses = Losses::default();
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
            let is_new = |stop: &joints::Stop| impulses.meets(stop, q, q1);
            let meets = contacts
                .as_mut()
                .is_some_and(|contacts| contacts.find(model, workspace, (h, f64::from(PARTS)), q1));
            if whole == Whole::OrNothing && (meets || stops.iter().any(is_new)) {
                return Ok(false);
            }
            translations.restore(model, workspace, joints, q1, v1);
            // For impulses g = ½h: their positions are ½h of their velocities, so that damping takes from them what it books. Contacts have a
            // problem with a factor of its own.
            if equalities.is_some() || !contacts.as_ref().is_some_and(ContactImpulses::touches) {
                factor.stiffen(joints, 0.5 * h)?;
            }
            impulses.turn(stops, q1, v1);
            if let Some(equalities) = equalities {
                equalities.place(model, workspace, q1);
                equalities.choose(factor, interrupt)?;
                impulses.hold(equalities);
            }
            impulses.choose(joints, stops, h, (q, q1));
            let met = match contacts.as_mut().filter(|contacts| contacts.touches()) {
                Some(contacts) => {
                    factor.write(joints, 0.5 * h, matrix);
                    is_written = true;
                    let (rows, multipliers) = impulses.rows_beside();
                    let step = ImpulsiveStep { h, paths: factor.paths(), matrix };
                    if !contacts.solve(model, step, (v, v1), rows, multipliers, change) {
                        let quantity = "the impulse of the contacts";
                        return Err(DynamicsError::NonFinite { quantity, index: 0 }.into());
                    }
                    true
                }
                None => impulses.solve(factor, v1, change)?,
            };
            if met {
                if !translations.is_empty() {
                    match contacts.as_mut().filter(|contacts| contacts.touches()) {
                        Some(contacts) => contacts.coordinate_impulses(external),
                        None => factor.multiply_mass(change, external),
                    }
                    translations.add(model, q1, |k| external[k]);
                }
                for k in 0..v.len() {
                    v1[k] += change[k];
                    displacement[k] += 0.5 * h * change[k];
                }
                impulses.rest(v, v1, displacement);
            }
            let are_hit = met && impulses.are_hit(v);
            if let Some(contacts) = contacts {
                let lost = contacts.account(h, are_hit);
                (by_impulses.sliding, by_impulses.impacts) = (lost.friction, lost.impacts);
            }
            if met {
                let is_impact = contacts.as_ref().map_or(are_hit, ContactImpulses::was_impact);
                let lost = impulses.account(joints, h, (v, v1), is_impact);
                (by_impulses.friction, by_impulses.stops) = (lost.friction, lost.stops);
                if let Some(equalities) = equalities {
                    equalities.settle(h, impulses.of_held(), is_impact);
                }
            }
        }
        // ∫Dv·v dt as the impulse D∫v dt times the mean velocity: what the step's momentum lost of energy.
        let damping: f64 =
            (0..v.len()).map(|k| joints.damping[k] * displacement[k] * 0.5 * (v[k] + v1[k])).sum();
        // Where stiff damping overshot, friction has the wrong sign over the step: that is taken from damping.
        let overshot = by_impulses.friction.min(0.0) + by_impulses.stops.min(0.0);
        let damping = damping + overshot;
        self.last.damping += if joints.adds_energy { damping } else { damping.max(0.0) };
        self.last.friction += by_impulses.friction.max(0.0);
        self.last.stops += by_impulses.stops.max(0.0);
        // In an impact friction may give what the normal impulses take, and the other way round: together they take. Where contacts
        // stick or roll, what then is below zero is the scheme's own error, and no energy that comes back.
        let (sliding, impacts) = (by_impulses.sliding, by_impulses.impacts);
        self.last.sliding += (sliding + impacts.min(0.0)).max(0.0);
        self.last.impacts += (impacts + sliding.min(0.0)).max(0.0);
        check_finite("v after the step", v1)?;
        self.kept.see(v1);
        integrate(model, q, displacement, q1);
        // The return from a deep start moves weight without a force.
        let is_deep = contacts.as_ref().is_some_and(|contacts| contacts.start_depth() > DEEP)
            || stops.iter().any(|stop| stop.gap(q) < -DEEP);
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
                let kept = |stop: &joints::Stop| stop.gap(q1) - stop.gap(q).min(0.0) * left;
                let bounds = stops.iter().map(|stop| {
                    let gap = kept(stop);
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
                integrate(model, before, change, q1);
            }
            contacts.note_depth();
            land_on_stops(stops, q, q1);
        } else if let Some(equalities) = equalities {
            self.kept.is_rough |= stops.iter().any(|stop| stop.gap(q1) < -BEYOND);
            let robot = (model, &mut *workspace);
            impulses.put_on_equalities(robot, factor, (equalities, stops), h, (q, q1), change)?;
        } else if has_stops {
            self.kept.is_rough |= stops.iter().any(|stop| stop.gap(q1) < -BEYOND);
            impulses.put_on_stops(factor, &joints.stops, h, (q, q1), change, |way, from, to| {
                integrate(model, from, way, to);
            })?;
        }
        if is_deep {
            // τ along that way counts as work of the motors.
            difference(model, uncorrected, q1, change);
            let work: f64 = tau.iter().zip(&*change).map(|(tau, way)| tau * way).sum();
            self.last.corrections += work + energy_before - energy(workspace, q1, v1);
        }
        check_finite("q after the step", q1)?;
        translations.restore(model, workspace, joints, q1, v1);
        // A solver that was interrupted left no result.
        if self.interrupt.is_set() {
            return Err(IntegratorError::Interrupted);
        }
        q.copy_from_slice(q1);
        v.copy_from_slice(v1);
        Ok(true)
    }
}
