//! The change of the smooth part of a step.

use robot_dynamics_core::configuration::displacement_rate::displacement_rate;
use robot_dynamics_core::{
    InverseDynamicsDerivativesMut, Model, Workspace, integrate, inverse_dynamics_derivatives, mass_matrix,
};

use super::super::ImplicitIntegrator;
use super::super::rosenbrock::GAMMA;
use super::StepRecord;
use super::columns::Columns;
use super::parameters::regressor;
use crate::motion::linearize_step::displacement::{add_identity, rate_change, retraction_change};
use crate::motion::linearize_step::product::multiply_changes;
use crate::motion::simulate::StepError;
use crate::placement::Placement;

/// The smooth part of a step and its changes.
pub(super) struct SmoothChange {
    /// qₘ, and Θ at the end.
    pub(super) middle: Vec<f64>,
    pub(super) theta: Vec<f64>,
    pub(super) theta_change: Vec<f64>,
    pub(super) v_change: Vec<f64>,
    pub(super) middle_change: Vec<f64>,
    /// The change of the sum of both stages' forces without C v, gravity and damping.
    pub(super) applied_change: Vec<f64>,
    /// Whether a control is at a bound, so that the derivative by it is one-sided.
    pub(super) is_at_bound: bool,
}

/// ∂f/∂q and ∂f/∂v of the generalized forces at one stage, nv×nv.
struct StageDerivatives {
    /// Without inertia: τ, actuators, tendons, and forces of the last step.
    own: [Vec<f64>; 2],
    /// With −(M k + C v + g) and −D v.
    all: [Vec<f64>; 2],
}

impl ImplicitIntegrator {
    /// The change of the smooth part.
    pub(super) fn smooth_change(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        (h, columns): (f64, &Columns),
        (q0, v0): (&[f64], &[f64]),
        placement: &mut Placement,
    ) -> Result<SmoothChange, StepError> {
        let (nv, width, g) = (model.nv, columns.width(), GAMMA * h);
        let zeros = || vec![0.0; nv * width];
        let half: Vec<f64> = v0.iter().map(|v| 0.5 * h * v).collect();
        let mut middle = vec![0.0; model.nq];
        integrate(model, q0, &half, &mut middle);
        let (mut half_change, mut middle_change) = (zeros(), zeros());
        add_identity(&mut half_change, nv, 1, 0.5 * h);
        retraction_change(model, &half, &half_change, &mut middle_change);

        placement.set(model, workspace, &middle);
        let mut carried = vec![0.0; nv * nv];
        if let Some(contacts) = &self.contacts {
            contacts.vary_carried(model, placement, &mut carried);
        }
        let rows = self.carried_rows();
        self.vary_moving_rows((model, workspace), &middle, &rows, v0, &mut carried);
        let inverse = self.inverse(g)?;
        let stiffness = self.stiffness(nv);
        let StepRecord { first, second, .. } = &self.record;
        let (first, second) = (first.clone(), second.clone());

        // M̂ δk₁ = δF.
        let stage = self.stage_derivatives(model, workspace, &middle, (v0, &first), &carried);
        let [by_position, mut by_velocity] = stage.all;
        let mut applied_change = zeros();
        multiply_changes(&[(&stage.own[0], &middle_change)], width, &mut applied_change);
        add_block(&mut applied_change, nv, 1, &stage.own[1]);
        by_velocity.iter_mut().zip(&stiffness).for_each(|(sum, k)| *sum -= (g - 0.5 * h) * k);
        let mut right = zeros();
        multiply_changes(&[(&by_position, &middle_change)], width, &mut right);
        add_block(&mut right, nv, 1, &by_velocity);
        add_identity(&mut right, nv, 2, 1.0);
        let (by_control, mut is_at_bound) = self.forces_by_controls(model, columns, (&middle, v0));
        let by_inertial = regressor(model, workspace, columns, [&middle, v0, &first]);
        columns.add(&mut right, columns.first_control(), 1.0, &by_control);
        columns.add(&mut right, columns.first_inertial(), -1.0, &by_inertial);
        columns.add(&mut applied_change, columns.first_control(), 1.0, &by_control);
        let mut first_change = zeros();
        multiply_changes(&[(&inverse, &right)], width, &mut first_change);

        // Θ₁ = h(v₀ + γh k₁), v′ = v₀ + h k₁, and Θ̇ there.
        let theta_1: Vec<f64> = v0.iter().zip(&first).map(|(v, k)| h * (v + g * k)).collect();
        let v_1: Vec<f64> = v0.iter().zip(&first).map(|(v, k)| v + h * k).collect();
        let scaled = |change: &[f64], by: f64| change.iter().map(|x| by * x).collect::<Vec<_>>();
        let mut theta_1_change = scaled(&first_change, h * g);
        add_identity(&mut theta_1_change, nv, 1, h);
        let mut v_1_change = scaled(&first_change, h);
        add_identity(&mut v_1_change, nv, 1, 1.0);
        let (mut rate, mut rate_by) = (vec![0.0; nv], zeros());
        displacement_rate(model, &theta_1, &v_1, &mut rate);
        rate_change(model, (&theta_1, &theta_1_change), (&v_1, &v_1_change), &mut rate_by);

        // M̂ δk₂ = δF − 2M δk₁ − K δ(Θ₁ + γh(Θ̇ − 2Θ₁/h) − ½hv₀).
        let sum: Vec<f64> = second.iter().zip(&first).map(|(second, first)| second + 2.0 * first).collect();
        let stage = self.stage_derivatives(model, workspace, &middle, (&v_1, &sum), &carried);
        let mut mass = vec![0.0; nv * nv];
        mass_matrix(model, workspace, &middle, &mut mass);
        for entry in &mut mass {
            *entry *= -2.0;
        }
        let mut way: Vec<f64> = theta_1_change
            .iter()
            .zip(&rate_by)
            .map(|(theta, rate)| -(theta + g * (rate - 2.0 * theta / h)))
            .collect();
        add_identity(&mut way, nv, 1, 0.5 * h);
        let [by_position, by_velocity] = &stage.all;
        let pairs: [(&[f64], &[f64]); 4] = [
            (by_position, &middle_change),
            (by_velocity, &v_1_change),
            (&mass, &first_change),
            (&stiffness, &way),
        ];
        multiply_changes(&pairs, width, &mut right);
        add_identity(&mut right, nv, 2, 1.0);
        let (by_control, is_second_at_bound) = self.forces_by_controls(model, columns, (&middle, &v_1));
        is_at_bound |= is_second_at_bound;
        let by_inertial = regressor(model, workspace, columns, [&middle, &v_1, &sum]);
        columns.add(&mut right, columns.first_control(), 1.0, &by_control);
        columns.add(&mut right, columns.first_inertial(), -1.0, &by_inertial);
        columns.add(&mut applied_change, columns.first_control(), 1.0, &by_control);
        let mut second_change = zeros();
        multiply_changes(&[(&inverse, &right)], width, &mut second_change);
        let own: [(&[f64], &[f64]); 2] = [(&stage.own[0], &middle_change), (&stage.own[1], &v_1_change)];
        multiply_changes(&own, width, &mut right);
        applied_change.iter_mut().zip(&right).for_each(|(sum, change)| *sum += change);
        add_identity(&mut applied_change, nv, 2, 2.0);

        // Θ = ½h(3k₁Θ + k₂Θ) with k₂Θ = Θ̇ − 2k₁Θ + γh k₂; v₁ = v₀ + ½h(3k₁ + k₂).
        let theta = (0..nv).map(|k| 0.5 * (theta_1[k] + h * (rate[k] + g * second[k]))).collect();
        let (mut theta_change, mut v_change) = (zeros(), zeros());
        for i in 0..nv * width {
            theta_change[i] = 0.5 * (theta_1_change[i] + h * (rate_by[i] + g * second_change[i]));
            v_change[i] = 0.5 * h * (3.0 * first_change[i] + second_change[i]);
        }
        add_identity(&mut v_change, nv, 1, 1.0);
        Ok(SmoothChange { middle, theta, theta_change, v_change, middle_change, applied_change, is_at_bound })
    }

    /// The derivatives of the forces at the middle, at velocity v and acceleration `a`.
    fn stage_derivatives(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        middle: &[f64],
        (v, a): (&[f64], &[f64]),
        carried: &[f64],
    ) -> StageDerivatives {
        let nv = model.nv;
        let (mut by_position, mut by_velocity) = (carried.to_vec(), vec![0.0; nv * nv]);
        if let Some(drive) = self.drive.as_mut().filter(|drive| !drive.actuation().is_empty()) {
            drive.add_derivatives(model, (middle, v), (&mut by_position, &mut by_velocity));
        }
        let own = [by_position, by_velocity];
        let zeros = || vec![0.0; nv * nv];
        let (mut by_position, mut by_velocity) = (zeros(), zeros());
        let out =
            InverseDynamicsDerivativesMut { by_position: &mut by_position, by_velocity: &mut by_velocity };
        inverse_dynamics_derivatives(model, workspace, middle, v, a, out);
        let less = |own: &[f64], inertial: &[f64]| own.iter().zip(inertial).map(|(own, x)| own - x).collect();
        let mut all: [Vec<f64>; 2] = [less(&own[0], &by_position), less(&own[1], &by_velocity)];
        for k in 0..nv {
            all[1][k * nv + k] -= self.joints.damping[k];
        }
        StageDerivatives { own, all }
    }

    /// K of springs, servos and tendons, as the step treats them.
    fn stiffness(&self, nv: usize) -> Vec<f64> {
        let mut stiffness = vec![0.0; nv * nv];
        for (k, row) in stiffness.chunks_exact_mut(nv).enumerate() {
            let mut unit = vec![0.0; nv];
            unit[k] = 1.0;
            self.joints.subtract_stiffness(-1.0, &unit, row);
        }
        stiffness
    }
}

/// Adds a matrix to a block.
fn add_block(change: &mut [f64], nv: usize, block: usize, matrix: &[f64]) {
    let width = change.len() / nv.max(1);
    for (row, own) in change.chunks_exact_mut(width.max(1)).zip(matrix.chunks_exact(nv.max(1))) {
        row[block * nv..(block + 1) * nv].iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
    }
}
