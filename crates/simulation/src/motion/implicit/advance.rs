//! One step: the smooth part, then the impulses of friction and constraints, then the positions.

use robot_dynamics_core::{Model, Workspace, integrate};
use robot_dynamics_integrators::{IntegratorError, check_computed};

use super::restoration::copy_active;
use super::{ImplicitIntegrator, ImplicitMemory};
use crate::contact::{ContactImpulses, ImpulsiveStep, Mark};
use crate::motion::simulate::Losses;

/// The number of parts in which components with an impact repeat a step, because the forces before and after
/// the impact differ.
pub(super) const PARTS: u32 = 16;

/// Whether to accept a step that ends beyond a stop or inside a contact.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ImpactPolicy {
    RejectStep,
    AcceptStep,
}

/// The components that took a step.
#[derive(Clone, Copy, PartialEq)]
enum AdvancedComponents {
    /// All that were active.
    All,
    /// The components without an impact, which alone remain active.
    WithoutImpacts,
    None,
}

impl ImplicitIntegrator {
    /// Takes a step of h of the active components, and returns whether all of them took it. With
    /// `RejectStep`, components with an impact get the mark `Meets` and are excluded, and only the others,
    /// which alone remain active, take the step. If no others exist, no step is taken and all components
    /// become active.
    pub(super) fn advance(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        (q, v): (&mut [f64], &mut [f64]),
        impacts: ImpactPolicy,
    ) -> Result<bool, IntegratorError> {
        self.check_interrupt()?;
        self.record_start(tau);
        self.paths.measure_start(model, workspace, q);
        self.translations.begin(model, workspace, h, (q, v));
        self.rosenbrock_step(model, workspace, tau, h, (q, v))?;
        self.lost.fill(Losses::default());
        self.components.clear_found();
        let may_act = self.joints.has_friction()
            || self.joints.has_stops()
            || self.impulses.acts()
            || self.contacts.is_some()
            || self.equalities.is_some();
        let (mut advanced, mut is_written) = (AdvancedComponents::All, false);
        if may_act {
            advanced = self.find_impacts(model, workspace, h, q, impacts);
            if advanced == AdvancedComponents::None {
                return Ok(false);
            }
            is_written = self.solve_impulses(model, workspace, h, (q, v))?;
        }
        self.add_losses_of(v);
        let ImplicitMemory { stage_v: v1, stage_q: q1, displacement, .. } = &mut self.memory;
        check_computed("v after the step", v1)?;
        self.kept.record_speeds(&self.components, v1);
        integrate(model, q, displacement, q1);
        self.correct_positions(model, workspace, tau, h, q, is_written)?;
        let Self { components, translations, joints, memory, interrupt, record, .. } = self;
        let ImplicitMemory { stage_v: v1, stage_q: q1, .. } = memory;
        check_computed("q after the step", q1)?;
        record.record_after(h, v1, components);
        translations.restore(model, workspace, joints, q1, v1);
        // An interrupted solver has no result.
        if interrupt.is_set() {
            return Err(IntegratorError::Interrupted);
        }
        copy_active(model, components, (q1, v1), (q, v));
        Ok(advanced == AdvancedComponents::All)
    }

    /// Begins the record of a pass.
    fn record_start(&mut self, tau: &[f64]) {
        self.record.begin_pass(tau);
        if let Some(contacts) = self.contacts.as_mut().filter(|_| self.record.is_on) {
            contacts.record_start();
        }
    }

    /// Records the contacts of the step.
    fn record_contacts(&mut self) {
        if let Some(contacts) = self.contacts.as_mut().filter(|_| self.record.is_on) {
            contacts.record_active();
        }
    }

    /// Finds the contacts at the end of the smooth part of a step from q. With `RejectStep`, excludes the
    /// components with an impact.
    fn find_impacts(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
        impacts: ImpactPolicy,
    ) -> AdvancedComponents {
        let Self { joints, impulses, contacts, components, paths, memory, .. } = self;
        let q1 = &mut memory.stage_q;
        integrate(model, q, &memory.displacement, q1);
        if let Some(contacts) = contacts {
            contacts.find(model, workspace, (h, f64::from(PARTS)), q1, components);
        }
        if impacts == ImpactPolicy::AcceptStep {
            return AdvancedComponents::All;
        }
        paths.measure_end(model, workspace, q1);
        let (start, end) = (paths.at_start(q), paths.at_end(q1));
        for stop in joints.stops.iter().filter(|stop| impulses.meets(stop, start, end)) {
            components.set(Mark::Meets, components.tree_of_row(&joints.rows[stop.row]));
        }
        if !components.has_any(Mark::Meets) {
            return AdvancedComponents::All;
        }
        if let Some(contacts) = contacts.as_mut().filter(|_| !components.is_one()) {
            contacts.join_near(model, components);
        }
        if !components.activate_marked(Mark::Meets, false) {
            components.activate_all();
            return AdvancedComponents::None;
        }
        if let Some(contacts) = contacts {
            contacts.leave_inactive(components);
        }
        AdvancedComponents::WithoutImpacts
    }

    /// Solves for the impulses of friction, stops, equalities and contacts, applies them to the end of the
    /// smooth part, and records their losses. Returns whether `matrix` of the memory is M̂.
    fn solve_impulses(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        (q, v): (&[f64], &[f64]),
    ) -> Result<bool, IntegratorError> {
        let touches = self.contacts.as_ref().is_some_and(ContactImpulses::touches);
        self.choose_rows(model, workspace, h, q, touches)?;
        if touches {
            self.solve_contacts(model, h, v)?;
        }
        let has_rows_apart = self.impulses.has_rows_apart(&self.components);
        if has_rows_apart {
            self.solve_rows_apart()?;
        }
        let has_impulses = touches || has_rows_apart;
        if has_impulses {
            self.record_contacts();
            let ImplicitMemory { force, applied, .. } = &self.memory;
            self.record.record_change(force, applied, self.impulses.solved_rows());
            self.apply_impulses(model, h, v);
        }
        self.account_for_impulses(h, v, has_impulses);
        Ok(touches)
    }

    /// Chooses the rows of friction, stops and equalities in the problem of the step, and factors M̂ if rows
    /// without contacts or equalities need it.
    fn choose_rows(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        q: &[f64],
        touches: bool,
    ) -> Result<(), IntegratorError> {
        let Self {
            joints,
            factor,
            impulses,
            equalities,
            translations,
            paths,
            memory,
            interrupt,
            components,
            record,
            ..
        } = self;
        let ImplicitMemory { stage_v: v1, stage_q: q1, .. } = memory;
        let stops = &joints.stops[..];
        translations.restore(model, workspace, joints, q1, v1);
        record.record_before(v1);
        impulses.turn(stops, q1, v1);
        paths.turn(model, workspace, q1, impulses);
        impulses.choose(joints, stops, h, (paths.at_start(q), paths.at_end(q1)), components);
        // Impulses use g = ½h: they change positions by ½h times their change of velocity, so that the
        // dissipation of dampers matches the energy account. The contact problem has its own factor.
        if equalities.is_some() || !touches || impulses.has_rows_apart(components) {
            factor.stiffen(joints, 0.5 * h)?;
        }
        if let Some(equalities) = equalities {
            equalities.place(model, workspace, q1);
            equalities.choose(factor, interrupt, components)?;
            impulses.copy_equality_rows(equalities);
            impulses.choose_held();
        }
        Ok(())
    }

    /// Solves the contact problem together with the rows of the components that touch. Writes M̂ to `matrix`
    /// and the changes of velocity to `force` of the memory. If bodies can be translated freely, also writes
    /// the generalized impulses to `applied`.
    ///
    /// # Errors
    /// The impulses are not finite.
    fn solve_contacts(&mut self, model: &Model, h: f64, v: &[f64]) -> Result<(), IntegratorError> {
        let Self { joints, factor, impulses, contacts, translations, memory, components, .. } = self;
        let Some(contacts) = contacts else { return Ok(()) };
        let ImplicitMemory { force: change, stage_v: v1, matrix, applied: impulse, .. } = memory;
        factor.write(joints, 0.5 * h, matrix);
        let step = ImpulsiveStep { h, paths: factor.paths(), matrix };
        let (rows, multipliers) = impulses.rows_beside(components);
        if !contacts.solve(model, step, (v, v1), rows, multipliers, change) {
            let quantity = "the impulse of the contacts";
            return Err(IntegratorError::NotFinite { quantity, index: 0 });
        }
        impulses.take_multipliers(components);
        if !translations.is_empty() {
            contacts.coordinate_impulses(impulse);
        }
        Ok(())
    }

    /// Solves for the rows of components without contacts, with the same results as [`solve_contacts`](Self::solve_contacts) in
    /// the coordinates of these components.
    fn solve_rows_apart(&mut self) -> Result<(), IntegratorError> {
        let Self { factor, impulses, translations, memory, components, .. } = self;
        let ImplicitMemory { force: change, stage_v: v1, applied: impulse, .. } = memory;
        impulses.solve_apart(factor, v1, components, change)?;
        if !translations.is_empty() {
            let product = impulses.multiply_mass_apart(factor, change);
            for k in 0..change.len() {
                if !components.has(Mark::Touched, components.tree_of(k)) {
                    impulse[k] = product[k];
                }
            }
        }
        Ok(())
    }

    /// Adds the change of velocity to v₁ and ½h of it to the displacement, and marks the components with
    /// impacts.
    fn apply_impulses(&mut self, model: &Model, h: f64, v: &[f64]) {
        let Self { impulses, translations, factor, memory, components, .. } = self;
        let ImplicitMemory {
            force: change,
            stage_v: v1,
            stage_q: q1,
            displacement,
            applied: impulse,
            fluid: [fluid, product],
            ..
        } = memory;
        if factor.multiply_damping(change, product) {
            fluid.iter_mut().zip(product).for_each(|(fluid, drag)| *fluid -= 0.5 * h * *drag);
        }
        if !translations.is_empty() {
            translations.add(model, q1, |k| impulse[k]);
        }
        for k in 0..v.len() {
            v1[k] += change[k];
            displacement[k] += 0.5 * h * change[k];
        }
        impulses.rest(v, v1, displacement);
        impulses.mark_hits(v, components);
    }

    /// Records the losses of contacts, friction and stops, and keeps the multipliers for the next step.
    fn account_for_impulses(&mut self, h: f64, v: &[f64], has_impulses: bool) {
        let Self { joints, impulses, contacts, equalities, paths, memory, components, lost, .. } = self;
        if let Some(contacts) = contacts {
            contacts.account(h, components, |leader, loss| {
                lost[leader].sliding += loss.friction;
                lost[leader].impacts += loss.impacts;
            });
        }
        impulses.account((joints, |row| paths.change_along(row)), h, (v, &memory.stage_v), components, lost);
        if let Some(equalities) = equalities.as_mut().filter(|_| has_impulses) {
            equalities.record_multipliers(h, impulses.of_held(), components);
        }
    }

    /// Adds the losses of the pass from v to those of the step, component by component.
    fn add_losses_of(&mut self, v: &[f64]) {
        let Self { joints, components, memory, lost, last_of, contacts, .. } = self;
        let ImplicitMemory { displacement, stage_v: v1, fluid: [fluid, _], .. } = memory;
        // ∫Dv·v dt is the impulse D∫v dt times the mean velocity, which is the energy that the change of
        // momentum takes. A fluid's impulse is that of the scheme.
        for k in (0..v.len()).filter(|k| components.moves(*k)) {
            let damping = (joints.damping[k] * displacement[k] - fluid[k]) * 0.5 * (v[k] + v1[k]);
            lost[components.leader(components.tree_of(k))].damping += damping;
        }
        let has_moving_surfaces = contacts.as_ref().is_some_and(ContactImpulses::has_moving_surfaces);
        for (last, lost) in last_of.iter_mut().zip(&*lost) {
            add_lost(last, lost, joints.adds_energy, has_moving_surfaces);
        }
    }
}

/// Adds the losses of one pass of a component.
fn add_lost(last: &mut Losses, lost: &Losses, adds_energy: bool, has_moving_surfaces: bool) {
    // If stiff damping overshoots, friction has the wrong sign over the step, and the difference is
    // subtracted from damping.
    let overshot = lost.friction.min(0.0) + lost.stops.min(0.0);
    let damping = lost.damping + overshot;
    last.damping += if adds_energy { damping } else { damping.max(0.0) };
    last.friction += lost.friction.max(0.0);
    last.stops += lost.stops.max(0.0);
    // In an impact, friction may supply part of the energy that the normal impulses dissipate, or the
    // reverse; only their sum is a loss. A negative sum of sticking or rolling contacts is an error of the
    // scheme and not a supply of energy.
    let (sliding, impacts) = (lost.sliding, lost.impacts);
    if has_moving_surfaces {
        // Their work is a negative loss.
        last.sliding += sliding;
        last.impacts += impacts;
        return;
    }
    last.sliding += (sliding + impacts.min(0.0)).max(0.0);
    last.impacts += (impacts + sliding.min(0.0)).max(0.0);
}
