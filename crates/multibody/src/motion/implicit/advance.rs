//! One step: the smooth part, then the impulses of what does not yield, then the positions.

use dynamics::{DynamicsError, IntegratorError, check_finite};

use super::kept::copy_active;
use super::{Implicit, Memory};
use crate::contact::{ContactImpulses, ImpulsiveStep, Mark};
use crate::motion::simulate::Losses;
use crate::{Model, Workspace, integrate};

/// Components that meet a stop or the ground in a step take it again in so many parts, as what acts before the impact and after it
/// differs.
pub(super) const PARTS: u32 = 16;

/// Whether a step that ends beyond a stop may be taken as it is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Whole {
    OrNothing,
    AsItIs,
}

/// Which components took a step.
#[derive(Clone, Copy, PartialEq)]
enum Taken {
    /// Those that moved.
    All,
    /// Those that meet nothing, which alone move now.
    Some,
    None,
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
        self.lost.fill(Losses::default());
        self.components.clear_found();
        let may_act = self.joints.has_friction()
            || (self.has_stops && self.joints.has_stops())
            || self.impulses.acts()
            || self.contacts.is_some()
            || self.equalities.is_some();
        let (mut taken, mut is_written) = (Taken::All, false);
        if may_act {
            taken = self.find(model, workspace, h, q, whole);
            if taken == Taken::None {
                return Ok(false);
            }
            is_written = self.act(model, workspace, h, (q, v))?;
        }
        self.add_losses_of(v);
        let Memory { stage_v: v1, stage_q: q1, displacement, .. } = &mut self.memory;
        check_finite("v after the step", v1)?;
        self.kept.see(&self.components, v1);
        integrate(model, q, displacement, q1);
        self.put_positions(model, workspace, tau, h, q, is_written)?;
        let Self { components, translations, joints, memory, interrupt, .. } = self;
        let Memory { stage_v: v1, stage_q: q1, .. } = memory;
        check_finite("q after the step", q1)?;
        translations.restore(model, workspace, joints, q1, v1);
        // A solver that was interrupted left no result.
        if interrupt.is_set() {
            return Err(IntegratorError::Interrupted);
        }
        copy_active(model, components, (q1, v1), (q, v));
        Ok(taken == Taken::All)
    }

    /// Finds the contacts of the step from q that the smooth part leads on; if components that meet something are to be left out, does so.
    fn find(&mut self, model: &Model, workspace: &mut Workspace, h: f64, q: &[f64], whole: Whole) -> Taken {
        let Self { joints, impulses, contacts, components, memory, .. } = self;
        let q1 = &mut memory.stage_q;
        integrate(model, q, &memory.displacement, q1);
        if let Some(contacts) = contacts {
            contacts.find(model, workspace, (h, f64::from(PARTS)), q1, components);
        }
        if whole == Whole::AsItIs {
            return Taken::All;
        }
        if self.has_stops {
            for stop in joints.stops.iter().filter(|stop| impulses.meets(stop, q, q1)) {
                components.set(Mark::Meets, components.tree_of_row(&joints.rows[stop.row]));
            }
        }
        if !components.has_any(Mark::Meets) {
            return Taken::All;
        }
        if let Some(contacts) = contacts.as_mut().filter(|_| !components.is_one()) {
            contacts.join_near(model, components);
        }
        if !components.activate_marked(Mark::Meets, false) {
            components.activate_all();
            return Taken::None;
        }
        if let Some(contacts) = contacts {
            contacts.leave_inactive(components);
        }
        Taken::Some
    }

    /// The impulses of friction, stops, equalities and contacts, and what they change; whether `matrix` of the memory is M̂ then.
    fn act(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        (q, v): (&[f64], &[f64]),
    ) -> Result<bool, IntegratorError> {
        let Self {
            joints,
            factor,
            impulses,
            contacts,
            equalities,
            translations,
            memory,
            interrupt,
            components,
            lost,
            ..
        } = self;
        let Memory {
            force: change, stage_v: v1, stage_q: q1, displacement, matrix, applied: external, ..
        } = memory;
        let stops = if self.has_stops { &joints.stops[..] } else { &[] };
        let mut is_written = false;
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
        Ok(is_written)
    }

    /// Adds the losses of the pass from v to those of the step, component by component.
    fn add_losses_of(&mut self, v: &[f64]) {
        let Self { joints, components, memory, lost, last_of, .. } = self;
        let Memory { displacement, stage_v: v1, .. } = memory;
        // ∫Dv·v dt as the impulse D∫v dt times the mean velocity: what the step's momentum lost of energy.
        for k in (0..v.len()).filter(|k| components.moves(*k)) {
            let damping = joints.damping[k] * displacement[k] * 0.5 * (v[k] + v1[k]);
            lost[components.leader(components.tree_of(k))].damping += damping;
        }
        for (last, lost) in last_of.iter_mut().zip(&*lost) {
            add_lost(last, lost, joints.adds_energy);
        }
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
