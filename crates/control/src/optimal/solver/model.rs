//! The linear-quadratic model of the whole trajectory: the change that a step promises.

use super::memory::{NodeModel, Policy};
use crate::optimal::dense::{add_matrix_vector, dot};
use crate::optimal::problem::Problem;

/// The first and second derivative, by the length of a step, of the cost of the model.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ModelChange {
    pub slope: f64,
    pub curvature: f64,
}

impl ModelChange {
    /// The change of the cost by a step of this length.
    pub(super) fn along(self, length: f64) -> f64 {
        length * self.slope + 0.5 * length * length * self.curvature
    }
}

/// The memory of a pass over the model.
#[derive(Clone, Debug)]
pub(super) struct ModelPass {
    /// The displacements δx of a node and the next, and δu.
    state: Vec<f64>,
    next: Vec<f64>,
    control: Vec<f64>,
    product: Vec<f64>,
}

impl ModelPass {
    pub(super) fn new(problem: &Problem) -> Self {
        let n = problem.state_space().tangent();
        let m = (0..problem.nodes()).map(|node| problem.controls(node)).max().unwrap_or(0);
        Self { state: vec![0.0; n], next: vec![0.0; n], control: vec![0.0; m], product: vec![0.0; n.max(m)] }
    }

    /// The derivatives of the model's cost along the full step of the policies, which closes the gaps.
    pub(super) fn change(&mut self, gaps: &[f64], models: &[NodeModel], policies: &[Policy]) -> ModelChange {
        let n = self.state.len();
        let mut change = ModelChange::default();
        self.state.copy_from_slice(&gaps[..n]);
        for (node, model) in models.iter().enumerate() {
            change.slope += dot(&model.state_gradient, &self.state);
            let product = &mut self.product[..n];
            product.fill(0.0);
            add_matrix_vector(&model.state_hessian, &self.state, product);
            change.curvature += dot(product, &self.state);
            let Some(policy) = policies.get(node) else { break };
            let m = policy.feedforward.len();
            let du = &mut self.control[..m];
            du.copy_from_slice(&policy.feedforward);
            add_matrix_vector(&policy.gain, &self.state, du);
            change.slope += dot(&model.control_gradient, du);
            let product = &mut self.product[..m];
            product.fill(0.0);
            add_matrix_vector(&model.control_hessian, du, product);
            change.curvature += dot(product, du);
            product.fill(0.0);
            add_matrix_vector(&model.cross_hessian, &self.state, product);
            change.curvature += 2.0 * dot(product, du);
            self.next.copy_from_slice(&gaps[(node + 1) * n..(node + 2) * n]);
            add_matrix_vector(&model.a, &self.state, &mut self.next);
            add_matrix_vector(&model.b, du, &mut self.next);
            std::mem::swap(&mut self.state, &mut self.next);
        }
        change
    }
}
