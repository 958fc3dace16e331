//! The forces of a node's held contacts, which its residuals read.

use std::sync::Arc;

use robot_dynamics_core::Model;
use robot_dynamics_simulation::{ConstraintSet, HeldDynamics};

use super::actuation_matrix::ActuationMatrix;

/// The forces of held contacts at the last evaluation of a node's dynamics.
///
/// A solver hands them to the residuals of the node by [`Residual::reuse`](crate::optimal::Residual::reuse).
/// A residual on forces then need not solve the dynamics again.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ContactForces<'a> {
    /// The state of the evaluation.
    pub x: &'a [f64],
    /// Its controls.
    pub u: &'a [f64],
    /// λ, one number for each held row \[N, or N·m for a rotation\].
    pub multipliers: &'a [f64],
    pub(in crate::optimal) evaluated: &'a EvaluatedForces,
    pub(in crate::optimal) phase: &'a Arc<ContactPhase>,
}

/// The constants of a step, which its clones share.
#[derive(Debug)]
pub(in crate::optimal) struct ContactPhase {
    pub(super) model: Arc<Model>,
    pub(super) set: ConstraintSet,
    pub(super) actuation: ActuationMatrix,
    /// S, nv×m.
    pub(super) columns: Vec<f64>,
    pub(super) step: f64,
}

/// The arguments and the forces of the last evaluation.
#[derive(Clone, Debug, Default)]
pub(in crate::optimal) struct EvaluatedForces {
    pub(super) x: Vec<f64>,
    pub(super) u: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
    /// ∂λ/∂(δx, u), K×(n + m); empty after an evaluation without derivatives.
    pub(super) by_inputs: Vec<f64>,
}

impl EvaluatedForces {
    pub(super) fn set(&mut self, x: &[f64], u: &[f64], held: &HeldDynamics, has_derivatives: bool) {
        let by_inputs = if has_derivatives { held.multipliers_by_inputs() } else { &[] };
        let parts = [(&mut self.x, x), (&mut self.u, u), (&mut self.multipliers, held.multipliers())];
        for (to, from) in parts.into_iter().chain([(&mut self.by_inputs, by_inputs)]) {
            to.clear();
            to.extend_from_slice(from);
        }
    }

    pub(super) fn is_at(&self, x: &[f64], u: &[f64]) -> bool {
        self.x == x && self.u == u
    }
}
