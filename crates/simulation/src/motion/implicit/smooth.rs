//! The smooth part of a step: a two-stage Rosenbrock step.

use robot_dynamics_core::algorithms::inverse_dynamics::bias_by_recursion;
use robot_dynamics_core::configuration::displacement_rate::displacement_rate;
use robot_dynamics_core::{Model, Workspace, integrate};
use robot_dynamics_integrators::IntegratorError;

use super::{ImplicitIntegrator, Memory};

/// γ = 1 − 1/√2: L-stable; of the two L-stable values, the one with the smaller error.
const GAMMA: f64 = 1.0 - core::f64::consts::FRAC_1_SQRT_2;

impl ImplicitIntegrator {
    /// The smooth part; writes Θ to `memory.displacement` and v₁ to `memory.stage_v`.
    pub(super) fn smooth(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        tau: &[f64],
        h: f64,
        (q, v): (&[f64], &[f64]),
    ) -> Result<(), IntegratorError> {
        let Self { joints, factor, impulses, drive, contacts, equalities, translations, memory, .. } = self;
        let Memory {
            q_rate: [q1, q2],
            acceleration: [a1, a2],
            force,
            stage_v,
            stage_q: middle,
            displacement,
            driven,
            carried,
            applied,
            ..
        } = memory;
        let (nv, g) = (v.len(), GAMMA * h);
        if let Some(contacts) = contacts {
            contacts.begin(model, workspace, (q, v));
        }
        if let Some(equalities) = equalities {
            equalities.begin(model, workspace, q);
        }
        displacement.iter_mut().zip(v).for_each(|(way, v)| *way = 0.5 * h * v);
        integrate(model, q, displacement, middle);
        factor.factor(model, workspace, middle, joints, g)?;
        // The forces of friction, stops and equalities of the last step.
        carried.copy_from_slice(&impulses.forces()[..nv]);
        if let Some(contacts) = contacts {
            contacts.carry(model, workspace, middle, carried);
        }
        if let Some(equalities) = equalities {
            equalities.carry(model, workspace, middle, carried);
        }
        impulses.add_turned(&joints.stops, middle, carried);
        // τ − Cv − g − Dv at the middle, for another velocity.
        applied.fill(0.0);
        let mut apply = |workspace: &mut Workspace, v: &[f64], to: &mut [f64]| {
            // The recursion gives a component of several bodies the same bits as in a model of its own;
            // machine code for one model would not.
            bias_by_recursion(model, workspace, middle, v, force);
            match drive {
                Some(drive) => drive.forces(model, middle, v, driven),
                None => driven.fill(0.0),
            }
            for k in 0..nv {
                let own = tau[k] + driven[k] + carried[k];
                applied[k] += own;
                to[k] += own - force[k] - joints.damping[k] * v[k];
            }
        };
        // M̂ k₁ᵥ = τ − Cv − g − Dv + (½ − γ)hKv; k₁Θ = v + γh k₁ᵥ.
        a1.fill(0.0);
        apply(workspace, v, a1);
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
        apply(workspace, stage_v, a2);
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
        }
        translations.add(model, middle, |k| 0.5 * h * applied[k]);
        Ok(())
    }
}
