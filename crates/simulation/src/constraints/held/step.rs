//! A step of semi-implicit Euler with held rows: v′ = v + h a, q′ = q ⊕ h v′, with derivatives.

use robot_dynamics_core::{Model, integrate};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;

use super::HeldDynamics;
use crate::StepError;
use crate::motion::RobotState;
use crate::motion::integrate::check_step;
use crate::motion::linearize_step::displacement::retraction_change;

/// The derivatives A and B of a step with held rows, as the outputs of [`HeldDynamics::linearize_step`].
#[derive(Debug)]
pub struct LinearizedHeldStep<'a> {
    /// A, 2nv×2nv, row-major.
    pub by_state: &'a mut [f64],
    /// B, the derivative by the coefficients u of the forces S u, 2nv×m, row-major.
    pub by_control: &'a mut [f64],
}

impl HeldDynamics {
    /// Writes the state after h seconds to (`next_q`, `next_v`).
    ///
    /// # Errors
    /// As [`solve`](Self::solve), and if h is not positive.
    ///
    /// # Panics
    /// As [`solve`](Self::solve).
    #[track_caller]
    pub fn step(
        &mut self,
        model: &Model,
        state: RobotState<'_>,
        tau: &[f64],
        h: f64,
        [next_q, next_v]: [&mut [f64]; 2],
    ) -> Result<(), StepError> {
        check_step(h)?;
        self.solve(model, state, tau)?;
        check_length("the next v", next_v.len(), model.nv());
        let displacement = &mut self.vectors[0];
        for (i, next) in next_v.iter_mut().enumerate() {
            *next = state.v[i] + h * self.acceleration[i];
            displacement[i] = h * *next;
        }
        integrate(model, state.q, displacement, next_q);
        check_computed("the next q", next_q)?;
        Ok(())
    }

    /// Writes A and B of the step with τ + S δu. `columns` is S, nv×m, row-major.
    ///
    /// # Errors
    /// As [`linearize`](Self::linearize), and if h is not positive.
    ///
    /// # Panics
    /// As [`linearize`](Self::linearize).
    #[track_caller]
    pub fn linearize_step(
        &mut self,
        model: &Model,
        state: RobotState<'_>,
        (tau, columns): (&[f64], &[f64]),
        h: f64,
        LinearizedHeldStep { by_state, by_control }: LinearizedHeldStep<'_>,
    ) -> Result<(), StepError> {
        check_step(h)?;
        self.linearize(model, state, tau, columns)?;
        let (nv, m) = (model.nv(), columns.len() / model.nv().max(1));
        check_length("A", by_state.len(), 4 * nv * nv);
        check_length("B", by_control.len(), 2 * nv * m);
        let (width, [displacement_change, q_change]) = (2 * nv + m, &mut self.changes);
        let displacement = &mut self.vectors[0];
        for ((to, v), a) in displacement.iter_mut().zip(state.v).zip(&self.acceleration) {
            *to = h * (v + h * a);
        }
        displacement_change.resize(nv * width, 0.0);
        q_change.resize(nv * width, 0.0);
        for (i, row) in displacement_change.chunks_exact_mut(width).enumerate() {
            let by = &self.by_inputs[i * width..(i + 1) * width];
            row.iter_mut().zip(by).for_each(|(to, by)| *to = h * h * by);
            row[nv + i] += h;
        }
        retraction_change(model, displacement, displacement_change, q_change);
        for i in 0..nv {
            let row = &q_change[i * width..(i + 1) * width];
            by_state[i * 2 * nv..][..2 * nv].copy_from_slice(&row[..2 * nv]);
            by_control[i * m..][..m].copy_from_slice(&row[2 * nv..]);
            let (row, to) = (&self.by_inputs[i * width..(i + 1) * width], nv + i);
            let to_state = &mut by_state[to * 2 * nv..][..2 * nv];
            to_state.iter_mut().zip(row).for_each(|(to, by)| *to = h * by);
            to_state[to] += 1.0;
            by_control[to * m..][..m].iter_mut().zip(&row[2 * nv..]).for_each(|(to, by)| *to = h * by);
        }
        Ok(())
    }
}
