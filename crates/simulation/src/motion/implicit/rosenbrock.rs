//! The smooth part of a step: a two-stage Rosenbrock step.

use robot_dynamics_core::algorithms::inverse_dynamics::bias_by_recursion;
use robot_dynamics_core::configuration::displacement_rate::displacement_rate;
use robot_dynamics_core::{Model, Workspace, integrate};
use robot_dynamics_integrators::IntegratorError;

use super::joints::Joints;
use super::{ImplicitIntegrator, ImplicitMemory};
use crate::motion::step_actuation::StepActuation;

/// γ = 1 − 1/√2: L-stable; of the two L-stable values, the one with the smaller error.
pub(super) const GAMMA: f64 = 1.0 - core::f64::consts::FRAC_1_SQRT_2;

impl ImplicitIntegrator {
    /// Takes the smooth part of a step; writes Θ to `memory.displacement` and v₁ to `memory.stage_v`.
    pub(super) fn rosenbrock_step(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        (q, v): (&[f64], &[f64]),
    ) -> Result<(), IntegratorError> {
        if let Some(contacts) = &mut self.contacts {
            contacts.begin(model, workspace, (q, v));
        }
        if let Some(equalities) = &mut self.equalities {
            equalities.begin(model, workspace, q);
        }
        self.factor_at_middle(model, workspace, h, (q, v))?;
        self.carry_constraint_forces(model, workspace);
        self.solve_stages(model, workspace, tau, h, v);
        let Self { translations, memory, record, .. } = self;
        record.record_stages(&memory.acceleration[0], &memory.acceleration[1], &memory.applied);
        translations.add(model, &memory.stage_q, |k| 0.5 * h * memory.applied[k]);
        Ok(())
    }

    /// Writes the middle qₘ = q ⊕ ½hv to `memory.stage_q`, and factors M̂ there, with the damping by a fluid.
    fn factor_at_middle(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        h: f64,
        (q, v): (&[f64], &[f64]),
    ) -> Result<(), IntegratorError> {
        let Self { joints, factor, drive, memory, .. } = self;
        let ImplicitMemory { displacement, stage_q: middle, .. } = memory;
        displacement.iter_mut().zip(v).for_each(|(way, v)| *way = 0.5 * h * v);
        integrate(model, q, displacement, middle);
        if let Some(drive) = drive.as_mut().filter(|drive| drive.actuation().has_fluid()) {
            factor.clear_damping();
            drive.for_each_damping(model, (middle, v), |row, column, entry| {
                factor.add_damping(row, column, entry);
            });
        }
        factor.factor(model, workspace, middle, joints, GAMMA * h)
    }

    /// Writes the forces of friction, stops, contacts and equalities of the last step to `memory.carried`, at
    /// the middle of this step.
    fn carry_constraint_forces(&mut self, model: &Model, workspace: &mut Workspace) {
        let Self { joints, impulses, contacts, equalities, paths, memory, .. } = self;
        let ImplicitMemory { stage_q: middle, carried, .. } = memory;
        carried.copy_from_slice(impulses.forces());
        if let Some(contacts) = contacts {
            contacts.carry(model, workspace, middle, carried);
        }
        if let Some(equalities) = equalities {
            equalities.carry(model, workspace, middle, carried);
        }
        paths.carry(model, workspace, middle, impulses, carried);
        impulses.add_turned(&joints.stops, middle, carried);
    }

    /// Solves both stages, and sums the forces that they apply in `memory.applied`.
    fn solve_stages(&mut self, model: &Model, workspace: &mut Workspace, tau: &[f64], h: f64, v: &[f64]) {
        let Self { joints, factor, drive, memory, .. } = self;
        let ImplicitMemory {
            q_rate: [q1, q2],
            acceleration: [a1, a2],
            force: bias,
            stage_v,
            stage_q: middle,
            displacement,
            driven,
            carried,
            applied,
            fluid: [fluid, product],
            ..
        } = memory;
        let (nv, g) = (v.len(), GAMMA * h);
        applied.fill(0.0);
        fluid.fill(0.0);
        let mut forces =
            MiddleForces { model, joints, middle, tau, carried, drive, bias, driven, applied, fluid };
        // M̂ k₁ᵥ = τ − Cv − g − Dv + (½ − γ)hKv; k₁Θ = v + γh k₁ᵥ.
        a1.fill(0.0);
        forces.add(workspace, v, a1);
        joints.subtract_stiffness(g - 0.5 * h, v, a1);
        factor.solve(a1);
        for k in 0..nv {
            q1[k] = v[k] + g * a1[k];
            displacement[k] = h * q1[k];
            stage_v[k] = v[k] + h * a1[k];
        }
        // M̂ k₂ᵥ = τ − Cv − g − Dv − 2M k₁ᵥ − K(hk₁Θ − ½hv₀ + γh(Θ̇ − 2k₁Θ)) at v₀ + hk₁ᵥ; k₂Θ = Θ̇ − 2k₁Θ + γh
        // k₂ᵥ.
        displacement_rate(model, displacement, stage_v, q2);
        factor.multiply_mass(a1, a2);
        for a2 in a2.iter_mut() {
            *a2 *= -2.0;
        }
        forces.add(workspace, stage_v, a2);
        for k in 0..nv {
            q2[k] -= 2.0 * q1[k];
            displacement[k] += g * q2[k] - 0.5 * h * v[k];
        }
        joints.subtract_stiffness(1.0, displacement, a2);
        factor.solve(a2);
        for k in 0..nv {
            q2[k] += g * a2[k];
            displacement[k] = 0.5 * h * (3.0 * q1[k] + q2[k]);
            stage_v[k] = v[k] + 0.5 * h * (3.0 * a1[k] + a2[k]);
            a1[k] += a2[k];
        }
        // Both stages together give M (v₁ − v₀) = ½h (F₁ + F₂ − γhD(k₁ + k₂)).
        if factor.multiply_damping(a1, product) {
            for k in 0..nv {
                fluid[k] = 0.5 * h * (fluid[k] - g * product[k]);
            }
        }
    }
}

/// The forces at the middle of a step as a function of velocity.
struct MiddleForces<'a> {
    model: &'a Model,
    joints: &'a Joints,
    middle: &'a [f64],
    tau: &'a [f64],
    /// The constraint forces of the last step.
    carried: &'a [f64],
    drive: &'a mut Option<StepActuation>,
    /// C v + g, and the forces of actuation.
    bias: &'a mut [f64],
    driven: &'a mut [f64],
    /// The sum of the forces of all calls without C v, gravity and damping.
    applied: &'a mut [f64],
    /// The sum of the forces of a fluid of all calls.
    fluid: &'a mut [f64],
}

impl MiddleForces<'_> {
    /// Adds τ − Cv − g − Dv to `sum`, where τ includes actuation and the constraint forces of the last step.
    fn add(&mut self, workspace: &mut Workspace, v: &[f64], sum: &mut [f64]) {
        let Self { model, joints, middle, tau, carried, drive, bias, driven, applied, fluid } = self;
        // The recursion gives a component of several bodies the same bits as in a model of its own; machine
        // code for one model would not.
        bias_by_recursion(model, workspace, middle, v, bias);
        match drive {
            Some(drive) => drive.forces(model, middle, v, driven),
            None => driven.fill(0.0),
        }
        if let Some(forces) = drive.as_ref().and_then(StepActuation::last_fluid_forces) {
            fluid.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        }
        for k in 0..v.len() {
            let own = tau[k] + driven[k] + carried[k];
            applied[k] += own;
            sum[k] += own - bias[k] - joints.damping[k] * v[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::{Model, Workspace};
    use robot_dynamics_description::{PassiveForces, pendulum};

    use super::super::ImplicitIntegrator;
    use super::GAMMA;

    /// The velocity of a damped joint without other forces: v₁ = R(z)v₀ with z = −hd/I and the stability
    /// function R(z) = (1 + (1 − 2γ)z)/(1 − γz)², which vanishes as z → −∞.
    #[test]
    fn damping_follows_the_stability_function() {
        const INERTIA: f64 = 0.5;
        const H: f64 = 1e-2;
        for z in [-1e-3_f64, -0.3, -1.0, -30.0, -1e3, -1e9] {
            let mut robot = pendulum(2.0, 0.5);
            robot.gravity = [0.0; 3];
            robot.joints[0].passive = PassiveForces::default().with_damping(-z * INERTIA / H);
            let model = Model::new(robot).unwrap();
            let (mut workspace, mut stepper) = (Workspace::new(&model), ImplicitIntegrator::new(&model));
            stepper.joints.choose(true);
            stepper.rosenbrock_step(&model, &mut workspace, &[0.0], H, (&[0.3], &[2.0])).unwrap();
            let expected = 2.0 * (1.0 + (1.0 - 2.0 * GAMMA) * z) / (1.0 - GAMMA * z).powi(2);
            let found = stepper.memory.stage_v[0];
            assert!((found - expected).abs() < 1e-14, "z = {z}: {found}, {expected}");
        }
    }
}
