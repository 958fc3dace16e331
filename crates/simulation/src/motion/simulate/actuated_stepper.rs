//! Explicit steps whose forces depend on the state within each step: actuators, tendons, gravity
//! compensation.

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::{Model, Workspace, dissipation, integrate};
use robot_dynamics_integrators::{EnergyAccount, Integrator, IntegratorError, Stage, StepScheme};

use super::energy_account::end_energies;
use super::gains::{add_actuation_gains, add_passive_gains};
use super::{StepError, Stepper};
use crate::motion::integrate::explicit::{StageSystem, advance};
use crate::motion::integrate::stage_memory::{StageMemory, most_stages};
use crate::motion::integrate::{accelerate, check_step};
use crate::motion::step_actuation::ActuatorLoad;
use crate::{Actuation, ActuationWorkspace, StateTransition, StepForces, StepWorkspace};

clone_in_place! {
    /// The controls of a step, and the activations at its start.
    #[derive(Debug)]
    struct HeldControls {
        controls: Vec<f64>,
        activations: Vec<f64>,
        /// The rates of the states of controllers and motors at all stages of the last step, at its start
        /// first.
        state_rates: Vec<f64>,
        /// These states at the end of the last step.
        state_end: Vec<f64>,
        /// The length of the last step \[s\].
        length: f64,
    }
}

impl HeldControls {
    /// The activations at `time` \[s\] after the step's start, written to `memory`. States of controllers are
    /// those at the start.
    fn after<'m>(&self, actuation: &Actuation, time: f64, memory: &'m mut [f64]) -> &'m mut [f64] {
        memory.copy_from_slice(&self.activations);
        if time > 0.0 {
            actuation.activate(&self.controls, time, memory);
        }
        memory
    }

    /// The states at the start of the step.
    fn state_start(&self) -> &[f64] {
        &self.activations[self.controls.len()..]
    }

    /// Writes the states at `time` \[s\] within the last step: the parabola through both ends with the rate
    /// at the start.
    fn states_after(&self, time: f64, states: &mut [f64]) {
        let (h, part) = (self.length, time / self.length);
        for (k, (start, end)) in self.state_start().iter().zip(&self.state_end).enumerate() {
            let rate = h * self.state_rates[k];
            states[k] = if part == 1.0 { *end } else { start + part * (rate + part * (end - start - rate)) };
        }
    }

    /// Sets the states at the end of a step from the rates at its stages.
    fn finish(&mut self, actuation: &Actuation, stages: &[Stage], h: f64) {
        let count = self.state_end.len();
        self.length = h;
        for k in 0..count {
            let rate: f64 = stages
                .iter()
                .enumerate()
                .map(|(j, stage)| stage.v_weight * self.state_rates[j * count + k])
                .sum();
            self.state_end[k] = self.activations[self.controls.len() + k] + h * rate;
        }
        actuation.bound_states(&mut self.state_end);
    }
}

clone_in_place! {
    /// Takes explicit steps with actuators, tendons and gravity compensation; every stage evaluates their
    /// forces.
    #[derive(Debug)]
    pub struct ActuatedStepper {
        actuation: Actuation,
        integrator: Integrator,
        memory: ActuationWorkspace,
        held: HeldControls,
        /// Scratch for the activations within a step.
        activations: Vec<f64>,
        of_step: ActuatorLoad,
    }
}

impl ActuatedStepper {
    pub fn new(actuation: Actuation, nv: usize, integrator: Integrator) -> Self {
        let (activations, states) = (vec![0.0; actuation.activation_count()], actuation.state_count());
        Self {
            memory: actuation.workspace(),
            held: HeldControls {
                controls: vec![0.0; actuation.control_count()],
                activations: activations.clone(),
                state_rates: vec![0.0; most_stages() * states],
                state_end: vec![0.0; states],
                length: 0.0,
            },
            activations,
            of_step: ActuatorLoad::new(&actuation, nv),
            actuation,
            integrator,
        }
    }

    /// Takes over the rest positions of springs that yielded.
    pub(crate) fn copy_rest_positions(&mut self, from: &Self) {
        self.actuation.copy_rest_positions(&from.actuation);
    }

    /// Holds these controls over the next step, which starts with these activations.
    pub(crate) fn set_controls(&mut self, controls: &[f64], activations: &[f64]) {
        self.held.controls.copy_from_slice(controls);
        self.held.activations.copy_from_slice(activations);
    }

    /// Writes the states of controllers and motors at `length` \[s\] within the last step.
    pub(crate) fn copy_states(&self, length: f64, states: &mut [f64]) {
        self.held.states_after(length, states);
    }
}

impl Stepper for ActuatedStepper {
    fn order(&self) -> u32 {
        self.integrator.order()
    }

    fn step(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        forces: &StepForces<'_>,
        h: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError> {
        check_step(h)?;
        let StepScheme::Explicit(stages) = self.integrator.scheme() else {
            return Err(StepError::NotExplicit { integrator: self.integrator.name() });
        };
        let StepWorkspace { dynamics, force, held: driven, stages: memory, .. } = workspace;
        let mut memory = StageMemory::new(model, stages.len(), memory);
        let mut motion = ActuatedTree {
            model,
            workspace: dynamics,
            actuation: (&self.actuation, &mut self.memory),
            held: &mut self.held,
            activations: &mut self.activations,
            stages: (stages, h),
            evaluated: (0..stages.len()).filter(|&at| Stage::needs_acceleration(stages, at)),
            driven,
            external: forces.tau,
            dissipation: forces.dissipation,
            force,
        };
        advance(model, stages, &mut motion, h, &mut memory, (q, v))?;
        self.held.finish(&self.actuation, stages, h);
        Ok(())
    }

    fn stored_energy(&mut self, q: &[f64]) -> f64 {
        self.actuation.stored_energy(&mut self.memory, q)
    }

    fn explicit_gains(&self, model: &Model, dissipation: bool, stiffness: &mut [f64], damping: &mut [f64]) {
        add_passive_gains(model, dissipation, stiffness, damping);
        add_actuation_gains(&self.actuation, model.nv, stiffness, damping);
    }

    fn control_count(&self) -> usize {
        self.actuation.control_count()
    }

    fn actuator_forces(&self) -> &[f64] {
        &self.of_step.forces
    }

    fn actuator_torques(&self) -> &[f64] {
        &self.of_step.torques
    }

    /// Integrates work and losses by Simpson's rule over the step's ends and middle, of order 4. A bound that
    /// is met inside a step lowers the order for that step.
    fn record(
        &mut self,
        model: &Model,
        workspace: &mut StepWorkspace,
        energy_account: &mut EnergyAccount,
        transition: StateTransition<'_>,
    ) {
        let (kinetic, potential) = end_energies(model, workspace, transition);
        let StateTransition { from, to, forces, h } = transition;
        let yielded = self.actuation.yield_springs(&mut self.memory, to.0);
        let stored = self.stored_energy(to.0);
        let StepWorkspace { displacement, q: middle_q, v: middle_v, force, .. } = workspace;
        // The middle of the cubic through the ends: half the displacement plus h/8 times the difference of
        // the velocities.
        for k in 0..displacement.len() {
            displacement[k] = 0.5 * displacement[k] + h / 8.0 * (from.1[k] - to.1[k]);
        }
        integrate(model, from.0, displacement, middle_q);
        let held = &self.held;
        let ActuatorLoad { forces: mean_forces, torques: mean_torques } = &mut self.of_step;
        mean_forces.fill(0.0);
        mean_torques.fill(0.0);
        let memory = &mut self.memory;
        let (mut input, mut lost) = (0.0, 0.0);
        let ends = [(1.0, 0.0, from), (4.0, 0.5 * h, (&**middle_q, &**middle_v)), (1.0, h, to)];
        for (weight, time, (q, v)) in ends {
            let weight = weight / 6.0;
            let u = held.after(&self.actuation, time, &mut self.activations);
            if time > 0.0 {
                held.states_after(time, &mut u[held.controls.len()..]);
            }
            self.actuation.actuator_torques(model, memory, u, q, v, force);
            add_scaled(mean_forces, weight, memory.actuator_forces());
            add_scaled(mean_torques, weight, force);
            self.actuation.add_unstored(memory, force);
            add_scaled(force, 1.0, forces.tau);
            input += weight * force.iter().zip(v).map(|(tau, v)| tau * v).sum::<f64>();
            lost += weight * self.actuation.dissipated_power(model, memory, q, v);
            if forces.dissipation {
                dissipation(model, v, force);
                lost += weight * force.iter().zip(v).map(|(b, v)| b * v).sum::<f64>();
            }
        }
        let work = energy_account.work() + h * input;
        let dissipated = energy_account.dissipated() + h * lost + yielded;
        energy_account.enter(kinetic, potential + stored, work, dissipated);
    }
}

/// y += a x.
fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}

/// A tree under forces that depend on its state.
struct ActuatedTree<'a, I> {
    model: &'a Model,
    workspace: &'a mut Workspace,
    actuation: (&'a Actuation, &'a mut ActuationWorkspace),
    held: &'a mut HeldControls,
    /// Scratch for the activations of a stage.
    activations: &'a mut [f64],
    /// The stages and the step \[s\].
    stages: (&'static [Stage], f64),
    /// The numbers of the stages with an acceleration.
    evaluated: I,
    /// Scratch for the driving forces, and for these minus b(v).
    driven: &'a mut [f64],
    force: &'a mut [f64],
    /// The torques that are held over the step.
    external: &'a [f64],
    /// Whether joint damping and friction act.
    dissipation: bool,
}

impl<I: Iterator<Item = usize>> StageSystem<f64> for ActuatedTree<'_, I> {
    type Error = IntegratorError;

    fn move_along(&self, q: &[f64], displacement: &[f64], moved: &mut [f64]) {
        integrate(self.model, q, displacement, moved);
    }

    /// States of controllers follow the rows of the velocity.
    fn accelerate(&mut self, q: &[f64], v: &[f64], acceleration: &mut [f64]) -> Result<(), IntegratorError> {
        let Self { actuation: (actuation, memory), held, stages: (stages, h), .. } = self;
        let stage = self.evaluated.next().unwrap_or(0);
        let row = stages[stage].v_row;
        let u = held.after(actuation, *h * row.iter().sum::<f64>(), self.activations);
        let count = held.state_end.len();
        for (k, state) in u[held.controls.len()..].iter_mut().enumerate() {
            *state +=
                *h * row.iter().enumerate().map(|(j, a)| a * held.state_rates[j * count + k]).sum::<f64>();
        }
        actuation.forces(self.model, memory, u, q, v, self.driven);
        held.state_rates[stage * count..][..count].copy_from_slice(memory.state_rates());
        add_scaled(self.driven, 1.0, self.external);
        let forces = StepForces::new(self.driven, self.dissipation);
        accelerate(self.model, self.workspace, &forces, self.force, (q, v), acceleration)
    }
}
