//! The derivatives of a and λ by the state and by the coefficients of given forces.
//!
//! M δa − Aᵀδλ = S δu − δID + δ(Aᵀ)λ,  A δa = −δ(A a + Ȧv + d A v + p φ), with δID and δ(A a + Ȧv) at fixed
//! a, and δ(Aᵀ)λ at fixed λ. All columns are solved at once by the factors that gave a and λ.

use robot_dynamics_core::{InverseDynamicsDerivativesMut, Model, inverse_dynamics_derivatives};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;

use super::kernels::RightSides;
use super::{HeldDynamics, RowFeedback};
use crate::StepError;
use crate::equality::row_derivatives::RowWeights;
use crate::motion::RobotState;

impl HeldDynamics {
    /// Computes a and λ for τ, and their derivatives by (δq, δv, δu) for τ + S δu. `columns` is S, nv×m,
    /// row-major.
    ///
    /// [`motion_by_inputs`](Self::motion_by_inputs) and
    /// [`multipliers_by_inputs`](Self::multipliers_by_inputs) then have 2nv + m columns. If rows depend on
    /// others, the derivatives are those along which the rank stays.
    ///
    /// ```
    /// use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, HeldDynamics, RowFeedback, SpatialAxis};
    /// use robot_dynamics::description::{Pose, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::derivatives::RobotState;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let hold = FrameConstraint::contact(model.frame_named("tip")?, Pose::IDENTITY, &[SpatialAxis::Z]);
    /// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
    /// let mut held = HeldDynamics::new(&model, &set, RowFeedback::default())?;
    /// held.linearize(&model, RobotState { q: &[0.3], v: &[0.0] }, &[1.0], &[1.0])?;
    /// // λ l cos q = τ + m g l cos q
    /// let (by, by_force) = (held.multipliers_by_inputs(), 1.0 / (0.5 * 0.3_f64.cos()));
    /// assert!((by[2] - by_force).abs() < 1e-13 && (by[0] - by_force * 0.3_f64.tan()).abs() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`solve`](Self::solve), and a derivative that is not finite.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model is another.
    #[track_caller]
    pub fn linearize(
        &mut self,
        model: &Model,
        state: RobotState<'_>,
        tau: &[f64],
        columns: &[f64],
    ) -> Result<(), StepError> {
        self.solve(model, state, tau)?;
        let (RobotState { q, v }, nv, count) = (state, model.nv(), self.multipliers.len());
        let m = columns.len() / nv.max(1);
        check_length("the columns of the forces", columns.len(), nv * m);
        let width = 2 * nv + m;
        let Self { workspace, rows, matrix, squares: [by_position, by_velocity], .. } = self;
        let (a, multipliers) = (&self.acceleration, &self.multipliers);
        let derivatives = InverseDynamicsDerivativesMut { by_position, by_velocity };
        inverse_dynamics_derivatives(model, workspace, q, v, a, derivatives);
        let moving = rows.moving(model, q, v, a);
        moving.force_derivative(multipliers, |i, j, entry| by_position[i * nv + j] -= entry);
        self.by_inputs.resize(nv * width, 0.0);
        for (i, to) in self.by_inputs.chunks_exact_mut(width).enumerate() {
            let row = i * nv..(i + 1) * nv;
            to[..nv].iter_mut().zip(&by_position[row.clone()]).for_each(|(to, by)| *to = -by);
            to[nv..2 * nv].iter_mut().zip(&by_velocity[row]).for_each(|(to, by)| *to = -by);
            to[2 * nv..].copy_from_slice(&columns[i * m..(i + 1) * m]);
        }
        let rates = &mut self.multipliers_by_inputs;
        rates.clear();
        rates.resize(count * width, 0.0);
        let RowFeedback { position, velocity } = self.feedback;
        moving.each_entry(RowWeights { acceleration: 1.0, rate: velocity }, |row, at, [by_q, by_v]| {
            rates[row * width + at] -= by_q;
            rates[row * width + nv + at] -= by_v;
        });
        // ∂φ/∂q = A.
        for (row, equality) in rows.rows().iter().enumerate() {
            if position != 0.0 && equality.error.is_some() {
                let to = &mut rates[row * width..][..nv];
                to.iter_mut().zip(&matrix[row * nv..]).for_each(|(to, a)| *to -= position * a);
            }
        }
        let forces = &mut self.by_inputs;
        self.basis.solve(RightSides { forces, rates, width });
        check_computed("the derivatives of the acceleration", forces)?;
        check_computed("the derivatives of the multipliers", rates)?;
        Ok(())
    }
}
