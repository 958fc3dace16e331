//! The impact on held rows: M (v⁺ − v⁻) = Aᵀι, A v⁺ = −e A v⁻, with derivatives.
//!
//! The jump d = v⁺ − v⁻ has the differential M δd − Aᵀδι = −δM d + δ(Aᵀ)ι, A δd = −(1 + e) A δv⁻ − δA (v⁺ +
//! e v⁻). δM d is the change of inverse dynamics at v = 0 and a = d, less that at a = 0.

use robot_dynamics_core::{InverseDynamicsDerivativesMut, Model, inverse_dynamics_derivatives};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;

use super::HeldDynamics;
use super::kernels::RightSides;
use crate::StepError;
use crate::equality::row_derivatives::RowWeights;
use crate::motion::RobotState;

/// The derivative of an impact, as the output of [`HeldDynamics::linearize_impact`].
#[derive(Debug)]
pub struct LinearizedImpact<'a> {
    /// The derivative of (δq, δv⁺) by (δq, δv⁻), 2nv×2nv, row-major.
    pub by_state: &'a mut [f64],
}

impl HeldDynamics {
    /// Writes v⁺ = v⁻ + M⁻¹Aᵀι with A v⁺ = −e A v⁻ to `velocity`. The impulses ι are then in
    /// [`multipliers`](Self::multipliers).
    ///
    /// # Errors
    /// [`StepError`] if a number is not finite, M is singular, or a result is not finite.
    ///
    /// # Panics
    /// If a slice has the wrong length, the model is another, or e is outside \[0, 1\].
    #[track_caller]
    pub fn impact(
        &mut self,
        model: &Model,
        state: RobotState<'_>,
        restitution: f64,
        velocity: &mut [f64],
    ) -> Result<(), StepError> {
        assert!((0.0..=1.0).contains(&restitution), "the restitution must lie in [0, 1], got {restitution}");
        check_length("the velocity after the impact", velocity.len(), model.nv());
        self.place(model, state)?;
        velocity.fill(0.0);
        for (c, a) in self.multipliers.iter_mut().zip(self.matrix.chunks_exact(model.nv())) {
            *c = -(1.0 + restitution) * a.iter().zip(state.v).map(|(a, v)| a * v).sum::<f64>();
        }
        self.basis.solve(RightSides { forces: velocity, rates: &mut self.multipliers, width: 1 });
        velocity.iter_mut().zip(state.v).for_each(|(jump, v)| *jump += v);
        check_computed("v after the impact", velocity)?;
        check_computed("the impulse", &self.multipliers)?;
        Ok(())
    }

    /// Computes an impact and its derivatives: those of v⁺ and ι by (δq, δv⁻) are in
    /// [`motion_by_inputs`](Self::motion_by_inputs) and
    /// [`multipliers_by_inputs`](Self::multipliers_by_inputs), with 2nv columns.
    ///
    /// # Errors
    /// As [`impact`](Self::impact), and a derivative that is not finite.
    ///
    /// # Panics
    /// As [`impact`](Self::impact).
    #[track_caller]
    pub fn linearize_impact(
        &mut self,
        model: &Model,
        state: RobotState<'_>,
        restitution: f64,
        LinearizedImpact { by_state }: LinearizedImpact<'_>,
    ) -> Result<(), StepError> {
        let (RobotState { q, v }, nv, count) = (state, model.nv(), self.multipliers.len());
        check_length("the derivative of the impact", by_state.len(), 4 * nv * nv);
        let mut velocity = std::mem::take(&mut self.velocity);
        let solved = self.impact(model, state, restitution, &mut velocity);
        self.velocity = velocity;
        solved?;
        let width = 2 * nv;
        let Self { workspace, rows, matrix, squares: [mass_change, unused], vectors: [jump, rest], .. } =
            self;
        rest.fill(0.0);
        self.by_inputs.clear();
        self.by_inputs.resize(nv * width, 0.0);
        for sign in [1.0, -1.0] {
            jump.iter_mut().zip(&self.velocity).zip(v).for_each(|((jump, after), before)| {
                *jump = if sign > 0.0 { 0.0 } else { after - before };
            });
            let derivatives = InverseDynamicsDerivativesMut { by_position: mass_change, by_velocity: unused };
            inverse_dynamics_derivatives(model, workspace, q, rest, jump, derivatives);
            for (to, change) in self.by_inputs.chunks_exact_mut(width).zip(mass_change.chunks_exact(nv)) {
                to.iter_mut().zip(change).for_each(|(to, change)| *to += sign * change);
            }
        }
        let sum = jump;
        sum.iter_mut().zip(&self.velocity).zip(v).for_each(|((sum, after), before)| {
            *sum = after + restitution * before;
        });
        let (forces, rates) = (&mut self.by_inputs, &mut self.multipliers_by_inputs);
        let moving = rows.moving(model, q, sum, rest);
        moving.force_derivative(&self.multipliers, |i, j, entry| forces[i * width + j] += entry);
        rates.clear();
        rates.resize(count * width, 0.0);
        moving.each_entry(RowWeights { acceleration: 0.0, rate: 1.0 }, |row, at, [by_q, _]| {
            rates[row * width + at] -= by_q;
        });
        for (to, a) in rates.chunks_exact_mut(width).zip(matrix.chunks_exact(nv)) {
            to[nv..].iter_mut().zip(a).for_each(|(to, a)| *to = -(1.0 + restitution) * a);
        }
        self.basis.solve(RightSides { forces, rates, width });
        for i in 0..nv {
            forces[i * width + nv + i] += 1.0;
        }
        check_computed("the derivatives of the velocity after the impact", forces)?;
        check_computed("the derivatives of the impulse", rates)?;
        let (positions, velocities) = by_state.split_at_mut(nv * width);
        positions.fill(0.0);
        (0..nv).for_each(|i| positions[i * width + i] = 1.0);
        velocities.copy_from_slice(forces);
        Ok(())
    }
}
