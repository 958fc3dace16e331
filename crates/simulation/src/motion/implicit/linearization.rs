//! The derivatives A and B of a step by the equations that the step satisfies.
//!
//! A change is a matrix of nv rows, the derivative of a vector by (δq₀, δv₀, δτ), and by controls, inertial
//! parameters and friction if they are asked for (`columns`).
//!
//! 1. **Smooth part** (`smooth`). The stages solve M̂k = F. M k + C v + g is inverse dynamics, so
//!    M̂ δk = δF − ∂τ_ID/∂q δq − ∂τ_ID/∂v δv at fixed k.
//! 2. **Impulses** (`rows`). The contacts, stops and friction forces of the step keep their state: a contact
//!    sticks, slides or is open. With the Delassus matrix G = A M̂⁻¹Aᵀ and the velocities c of the rows:
//!    sticking rows have δc = 0; sliding ones have p_t = −μ pₙ c_t/|c_t| and δcₙ = 0. Where Coulomb's law has
//!    no solution, δcₙ = μ c_tᵀδc_t/|c_t|, as in the convex problem that the step solves instead.
//! 3. **Positions.** A row that corrected the position keeps its gap: A δq₁ is 0, or the remaining part of a
//!    violation at the start.
//!
//! The forces that the step takes over from the last one are constant.

mod columns;
mod corrections;
mod divided;
mod landing;
mod moving_rows;
mod parameters;
mod record;
mod rows;
mod smooth;
mod systems;

use robot_dynamics_core::{Model, Workspace, integrate};

use super::ImplicitIntegrator;
use super::momentum::TargetChanges;
use crate::contact::returns;
use crate::motion::RobotState;
use crate::motion::linearize_step::displacement::retraction_change;
use crate::motion::linearize_step::results::{LinearizationMethod, LinearizedStepWithParameters};
use crate::motion::simulate::StepError;
use crate::motion::step_actuation::StepActuation;
use crate::placement::Placement;
use crate::{StepForces, StepWorkspace};

pub(super) use self::record::{SolvedRow, StepRecord};

use self::columns::Columns;
use self::rows::ImpulseChange;
use self::smooth::SmoothChange;

impl ImplicitIntegrator {
    /// Writes A and B of the step from this state, if every part of it has an analytic derivative. The
    /// stepper's state does not change.
    pub(super) fn linearize_analytically(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        state: RobotState<'_>,
        out: LinearizedStepWithParameters<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        if let Some(reason) = self.part_without_derivative() {
            return Ok(LinearizationMethod::Differences { reason });
        }
        let (mut q1, mut v1) = (state.q.to_vec(), state.v.to_vec());
        self.joints.choose(forces.dissipation);
        self.store_state(state.q, state.v);
        let begun = self.kept.clone();
        self.record.begin();
        let taken = self.step_or_go_back(model, workspace, forces, h, (&mut q1, &mut v1));
        self.record.is_on = false;
        let method = taken.map_err(StepError::from).and_then(|()| match self.record.parts.len() {
            _ if self.record.is_apart => {
                Ok(LinearizationMethod::Differences { reason: "an impact of a part of the bodies" })
            }
            1 => self.differentiate(model, &mut workspace.dynamics, h, state, (&q1, &v1), out),
            _ => self.differentiate_parts(model, workspace, forces, (h, &begun), (&q1, &v1), out),
        });
        // A part that failed left the record on.
        self.record.is_on = false;
        if let Some(contacts) = &mut self.contacts {
            contacts.begin_whole();
        }
        self.components.activate_all();
        self.kept.copy_from(&begun);
        self.take_back(&mut q1, &mut v1);
        method
    }

    /// The effect of this robot that has no analytic derivative, if there is one.
    fn part_without_derivative(&self) -> Option<&'static str> {
        let drive = self.drive.as_ref().map(StepActuation::actuation);
        if drive.is_some_and(crate::Actuation::has_fluid) {
            return Some("a fluid");
        }
        if drive.is_some_and(crate::Actuation::has_yielding_springs) {
            return Some("springs that yield");
        }
        if drive.is_some_and(crate::Actuation::has_controllers) {
            return Some("states of controllers and motors");
        }
        if self.contacts.as_ref().is_some_and(crate::contact::ContactImpulses::has_moving_surfaces) {
            return Some("moving surfaces");
        }
        None
    }

    /// The property of the recorded pass that has no analytic derivative, if there is one.
    fn step_without_derivative(&self) -> Option<&'static str> {
        if self.factor.has_armature() {
            return Some("an inertia that is singular in this configuration");
        }
        let contacts = self.contacts.as_ref().filter(|_| !self.record.change.is_empty())?;
        contacts.recorded().any(|contact| contact.rebounds).then_some("a rebound")
    }

    /// Computes A and B of the recorded pass.
    fn differentiate(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        RobotState { q: q0, v: v0 }: RobotState<'_>,
        (q1, v1): (&[f64], &[f64]),
        out: LinearizedStepWithParameters<'_>,
    ) -> Result<LinearizationMethod, StepError> {
        if let Some(reason) = self.step_without_derivative() {
            return Ok(LinearizationMethod::Differences { reason });
        }
        let LinearizedStepWithParameters { step: mut out, by_control, by_inertial, by_friction } = out;
        let controls = self.drive.as_mut().map_or(0, |drive| drive.controls().len());
        let controls = if by_control.is_empty() { 0 } else { controls };
        let columns = &Columns::new(model, controls, !by_inertial.is_empty(), !by_friction.is_empty());
        let (nv, width) = (model.nv, columns.width());
        let mut placement = Placement::new(model);
        placement.set(model, workspace, q0);
        let inertial = (columns.inertial > 0).then(|| columns.first_inertial());
        let mut targets = self.translations.start_changes((model, &placement), h, v0, (width, inertial));
        let mut smooth = self.smooth_change(model, workspace, (h, columns), (q0, v0), &mut placement)?;
        let applied = (&self.record.applied[..], &smooth.applied_change[..]);
        let at_middle = (&smooth.middle[..], &smooth.middle_change[..]);
        self.translations.add_changes(model, at_middle, applied, 0.5 * h, &mut targets);

        // The inertia of impulses and of corrections.
        let acts = !(self.record.change.is_empty() && self.record.corrections.is_empty());
        let inverse = if acts { self.inverse(0.5 * h)? } else { Vec::new() };
        let mut at_transition = smooth.is_at_bound;
        if !self.record.before.is_empty() {
            let (at, targets) = ((model, &mut *workspace, &mut placement), &mut targets);
            at_transition |= self.add_impulses(at, (h, columns), (q0, v0), &inverse, &mut smooth, targets);
        }

        // The positions and the momentum at the end.
        let SmoothChange { middle, theta: mut way, theta_change, mut v_change, middle_change, .. } = smooth;
        self.record.change.iter().zip(&mut way).for_each(|(change, way)| *way += 0.5 * h * change);
        let mut q_change = vec![0.0; nv * width];
        retraction_change(model, &way, &theta_change, &mut q_change);
        let has_impulses = !self.record.change.is_empty();
        let moved_times = has_impulses.then(|| self.move_impacts(h, q0, &inverse, &mut q_change)).flatten();
        let kept = returns(h);
        let at_middle = (&middle[..], &middle_change[..]);
        self.correction_changes((model, workspace), (kept, columns), q0, &inverse, at_middle, &mut q_change);
        placement.set(model, workspace, q1);
        let (here, speeds) = ((q1, &q_change[..]), (&self.record.after[..], v1));
        let (translations, at) = (&self.translations, (model, &placement));
        translations.restore_changes(at, &self.joints, here, speeds, &targets, &mut v_change);
        if let Some(times) = moved_times {
            let end = (q1, v1);
            self.change_acceleration((model, workspace), (h, columns), end, times, &mut v_change);
        }

        out.write_changes(nv, &q_change, &v_change);
        let changes = [&q_change[..], &v_change];
        columns.write((columns.first_control(), columns.controls), changes, by_control);
        columns.write((columns.first_inertial(), columns.inertial), changes, by_inertial);
        columns.write((columns.first_friction(), columns.friction), changes, by_friction);
        Ok(LinearizationMethod::Analytic { at_transition })
    }

    /// Adds the change by the impulses at the end of the smooth part; returns whether one of them is at a
    /// transition.
    fn add_impulses(
        &mut self,
        (model, workspace, placement): (&Model, &mut Workspace, &mut Placement),
        (h, columns): (f64, &Columns),
        (q0, v0): (&[f64], &[f64]),
        inverse: &[f64],
        smooth: &mut SmoothChange,
        targets: &mut TargetChanges,
    ) -> bool {
        let SmoothChange { middle, theta, theta_change, v_change, middle_change, .. } = smooth;
        let (mut free, mut q_change) = (vec![0.0; model.nq], vec![0.0; theta_change.len()]);
        integrate(model, q0, theta, &mut free);
        retraction_change(model, theta, theta_change, &mut q_change);
        placement.set(model, workspace, &free);
        let StepRecord { first, second, before, .. } = &self.record;
        let stages = v0.iter().zip(first.iter().zip(second));
        let unrestored: Vec<f64> =
            stages.map(|(v, (first, second))| v + 0.5 * h * (3.0 * first + second)).collect();
        let (here, speeds) = ((&free[..], &q_change[..]), (&unrestored[..], &before[..]));
        let at = (model, &*placement);
        self.translations.restore_changes(at, &self.joints, here, speeds, targets, v_change);
        if self.record.change.is_empty() {
            return false;
        }
        let changes = (&q_change[..], &middle_change[..], &v_change[..]);
        let ImpulseChange { velocity, impulse, is_at_transition } = self.impulse_change(
            (model, workspace, placement),
            (h, columns),
            (q0, &free, middle),
            inverse,
            changes,
        );
        let impulse = (&self.record.impulse[..], &impulse[..]);
        self.translations.add_changes(model, here, impulse, 1.0, targets);
        for ((change, v), way) in velocity.iter().zip(v_change).zip(&mut *theta_change) {
            *v += change;
            *way += 0.5 * h * change;
        }
        self.keep_at_rest(v0, theta_change);
        is_at_transition
    }

    /// A joint that sticks and was at rest does not move, unless it had a velocity.
    fn keep_at_rest(&self, v0: &[f64], theta_change: &mut [f64]) {
        let (nv, width) = (v0.len(), theta_change.len() / v0.len().max(1));
        for row in self.record.rows.iter().filter(|row| row.is_free && row.number < nv) {
            let [(k, _)] = row.terms[..] else { continue };
            if v0[k] == 0.0 && self.record.after[k] == 0.0 {
                for (column, entry) in theta_change[k * width..(k + 1) * width].iter_mut().enumerate() {
                    if column != nv + k {
                        *entry = 0.0;
                    }
                }
            }
        }
    }

    /// M̂⁻¹ with g = γh or ½h. The factor has M at the middle of the recorded step.
    fn inverse(&mut self, g: f64) -> Result<Vec<f64>, StepError> {
        let Self { factor, joints, memory, .. } = self;
        factor.stiffen(joints, g)?;
        let nv = memory.stage_v.len();
        let mut inverse = vec![0.0; nv * nv];
        for (k, row) in inverse.chunks_exact_mut(nv.max(1)).enumerate() {
            row[k] = 1.0;
            factor.solve(row);
        }
        Ok(inverse)
    }
}
