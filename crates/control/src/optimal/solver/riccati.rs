//! The backward pass: the Riccati recursion over the models of the nodes.
//!
//! With the value V′ = ½ δxᵀP δx + pᵀδx of the next node and its defect f:
//!
//! > Qₓ = ℓₓ + Aᵀ(p + P f),  Qᵤ = ℓᵤ + Bᵀ(p + P f),
//! > Qₓₓ = ℓₓₓ + AᵀP A,  Qᵤₓ = ℓᵤₓ + BᵀP A,  Qᵤᵤ = ℓᵤᵤ + BᵀP B + μ 1
//!
//! k minimizes ½ kᵀQᵤᵤ k + Qᵤᵀk within the bounds; K = −Qᵤᵤ⁻¹Qᵤₓ for the controls that are not at a bound.
//! Then P ← Qₓₓ + QᵤₓᵀK and p ← Qₓ + Qᵤₓᵀk.
//!
//! Without defects and with k = 0 in all nodes, p is the multiplier of the dynamics and Qᵤ the derivative of
//! the Lagrangian by u. The multiplier by the open loop, λ = ℓₓ + Aᵀλ′, would lose all digits on unstable
//! systems.
//!
//! Sources: Tassa, Mansard, Todorov, ICRA 2014; Mastalli et al., ICRA 2020, for the defects.

use super::memory::{NodeModel, Policy, Trajectory};
use crate::optimal::box_qp::{BoxQp, BoxQpStatus};
use crate::optimal::control_bounds::ControlBounds;
use crate::optimal::dense::{
    add_matrix_vector, add_product, add_symmetric_product, add_transposed_product, add_transposed_vector,
    factorize, mirror_lower, solve_factored,
};
use crate::optimal::problem::Problem;

/// The memory of the recursion.
#[derive(Clone, Debug)]
pub(super) struct Riccati {
    n: usize,
    /// P and p of the next node.
    hessian: Vec<f64>,
    gradient: Vec<f64>,
    /// p + P f.
    moved_gradient: Vec<f64>,
    /// P A and P B.
    hessian_a: Vec<f64>,
    hessian_b: Vec<f64>,
    /// Qₓₓ, Qᵤₓ, Qᵤᵤ, Qₓ, Qᵤ.
    q_xx: Vec<f64>,
    q_ux: Vec<f64>,
    q_uu: Vec<f64>,
    q_x: Vec<f64>,
    q_u: Vec<f64>,
    /// The bounds relative to the controls.
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// By number of controls.
    box_qps: Vec<Option<BoxQp>>,
}

/// Qᵤᵤ of a node is not positive definite.
#[derive(Debug)]
pub(super) struct Indefinite;

impl Riccati {
    pub(super) fn new(problem: &Problem) -> Self {
        let n = problem.state_space().tangent();
        let counts = (0..problem.nodes()).map(|node| problem.controls(node));
        let m = counts.clone().max().unwrap_or(0);
        let mut box_qps = vec![None; m + 1];
        counts.for_each(|m| box_qps[m] = Some(BoxQp::new(m)));
        Self {
            n,
            hessian: vec![0.0; n * n],
            gradient: vec![0.0; n],
            moved_gradient: vec![0.0; n],
            hessian_a: vec![0.0; n * n],
            hessian_b: vec![0.0; n * m],
            q_xx: vec![0.0; n * n],
            q_ux: vec![0.0; n * m],
            q_uu: vec![0.0; m * m],
            q_x: vec![0.0; n],
            q_u: vec![0.0; m],
            lower: vec![0.0; m],
            upper: vec![0.0; m],
            box_qps,
        }
    }

    /// Computes the policies of all nodes with the regularization μ. Returns the largest entry of Qᵤ, at a
    /// bound only its part that points inwards.
    pub(super) fn solve(
        &mut self,
        problem: &Problem,
        (trajectory, gaps): (&Trajectory, &[f64]),
        models: &[NodeModel],
        policies: &mut [Policy],
        regularization: f64,
    ) -> Result<f64, Indefinite> {
        let (n, terminal) = (self.n, &models[policies.len()]);
        let mut most = 0.0_f64;
        self.hessian.copy_from_slice(&terminal.state_hessian);
        self.gradient.copy_from_slice(&terminal.state_gradient);
        for (node, policy) in policies.iter_mut().enumerate().rev() {
            let gap = &gaps[(node + 1) * n..(node + 2) * n];
            self.expand(&models[node], gap, regularization);
            let bounds = problem.control_bounds(node);
            most = most.max(self.projected_gradient(bounds, trajectory.control(node)));
            if bounds.is_bounded() {
                self.minimize_within(bounds, trajectory.control(node), policy)?;
            } else {
                self.minimize(policy)?;
            }
            self.take_value(policy);
        }
        Ok(most)
    }

    /// The largest of |Qᵤ|, or of the distance from u to u − Qᵤ within the bounds.
    fn projected_gradient(&self, bounds: &ControlBounds, u: &[f64]) -> f64 {
        let entries = self.q_u.iter().zip(u).zip(bounds.lower.iter().zip(&bounds.upper));
        entries.fold(0.0, |most, ((g, u), (low, high))| {
            let towards = if *g > 0.0 { u - low } else { high - u };
            most.max(g.abs().min(towards))
        })
    }

    /// The derivatives of Q.
    fn expand(&mut self, model: &NodeModel, gap: &[f64], regularization: f64) {
        let (n, m) = (self.n, model.control_gradient.len());
        self.moved_gradient.copy_from_slice(&self.gradient);
        add_matrix_vector(&self.hessian, gap, &mut self.moved_gradient);
        let (hessian_a, hessian_b) = (&mut self.hessian_a, &mut self.hessian_b[..n * m]);
        hessian_a.fill(0.0);
        add_product(n, n, &self.hessian, &model.a, hessian_a);
        hessian_b.fill(0.0);
        add_product(n, m, &self.hessian, &model.b, hessian_b);
        self.q_xx.copy_from_slice(&model.state_hessian);
        add_symmetric_product(n, &model.a, hessian_a, &mut self.q_xx);
        let (q_ux, q_uu) = (&mut self.q_ux[..m * n], &mut self.q_uu[..m * m]);
        q_ux.copy_from_slice(&model.cross_hessian);
        add_transposed_product(m, n, &model.b, hessian_a, q_ux);
        q_uu.copy_from_slice(&model.control_hessian);
        add_symmetric_product(m, &model.b, hessian_b, q_uu);
        mirror_lower(m, q_uu);
        for i in 0..m {
            q_uu[i * m + i] += regularization;
        }
        self.q_x.copy_from_slice(&model.state_gradient);
        add_transposed_vector(&model.a, &self.moved_gradient, &mut self.q_x);
        let q_u = &mut self.q_u[..m];
        q_u.copy_from_slice(&model.control_gradient);
        add_transposed_vector(&model.b, &self.moved_gradient, q_u);
    }

    /// k = −Qᵤᵤ⁻¹Qᵤ and K = −Qᵤᵤ⁻¹Qᵤₓ; overwrites Qᵤᵤ by its factor.
    fn minimize(&mut self, policy: &mut Policy) -> Result<(), Indefinite> {
        let m = policy.feedforward.len();
        let (q_uu, q_ux) = (&mut self.q_uu[..m * m], &self.q_ux[..m * self.n]);
        if !factorize(m, q_uu) {
            return Err(Indefinite);
        }
        negate(&self.q_u[..m], &mut policy.feedforward);
        solve_factored(m, q_uu, 1, &mut policy.feedforward);
        negate(q_ux, &mut policy.gain);
        solve_factored(m, q_uu, self.n, &mut policy.gain);
        Ok(())
    }

    /// k within the bounds, and K of the free controls.
    fn minimize_within(
        &mut self,
        bounds: &ControlBounds,
        u: &[f64],
        policy: &mut Policy,
    ) -> Result<(), Indefinite> {
        let (n, m) = (self.n, u.len());
        for i in 0..m {
            self.lower[i] = bounds.lower[i] - u[i];
            self.upper[i] = bounds.upper[i] - u[i];
        }
        let within = (&self.lower[..m], &self.upper[..m]);
        let qp = self.box_qps[m].as_mut().expect("a program for this number of controls");
        let status = qp.solve(&self.q_uu[..m * m], &self.q_u[..m], within, &mut policy.feedforward);
        if status != BoxQpStatus::Solved {
            policy.feedforward.fill(0.0);
            return Err(Indefinite);
        }
        let (free, factor) = qp.free();
        // The rows of the free controls first, then each to its place from the last.
        for (row, &i) in free.iter().enumerate() {
            negate(&self.q_ux[i * n..(i + 1) * n], &mut policy.gain[row * n..(row + 1) * n]);
        }
        solve_factored(free.len(), factor, n, &mut policy.gain[..free.len() * n]);
        let mut row = free.len();
        for i in (0..m).rev() {
            if row > 0 && free[row - 1] == i {
                row -= 1;
                policy.gain.copy_within(row * n..(row + 1) * n, i * n);
            } else {
                policy.gain[i * n..(i + 1) * n].fill(0.0);
            }
        }
        Ok(())
    }

    /// P and p of this node.
    fn take_value(&mut self, policy: &Policy) {
        let (n, m) = (self.n, policy.feedforward.len());
        add_symmetric_product(n, &self.q_ux[..m * n], &policy.gain, &mut self.q_xx);
        mirror_lower(n, &mut self.q_xx);
        std::mem::swap(&mut self.hessian, &mut self.q_xx);
        add_transposed_vector(&self.q_ux[..m * n], &policy.feedforward, &mut self.q_x);
        std::mem::swap(&mut self.gradient, &mut self.q_x);
    }
}

fn negate(x: &[f64], to: &mut [f64]) {
    to.iter_mut().zip(x).for_each(|(to, x)| *to = -x);
}
