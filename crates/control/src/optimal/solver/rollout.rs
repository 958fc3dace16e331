//! The forward pass: the nonlinear rollout of the policies, and the defects of a trajectory.

use super::memory::{Policy, Trajectory};
use crate::optimal::dense::dot;
use crate::optimal::error::OptimalControlError;
use crate::optimal::problem::Problem;

/// The memory of a rollout.
#[derive(Clone, Debug)]
pub(super) struct RolloutMemory {
    next: Vec<f64>,
    displacement: Vec<f64>,
}

impl RolloutMemory {
    pub(super) fn new(problem: &Problem) -> Self {
        let space = problem.state_space();
        Self { next: vec![0.0; space.coordinates()], displacement: vec![0.0; space.tangent()] }
    }

    /// Writes the defects x₀ ⊖ x_0 and f(x_k, u_k) ⊖ x_{k+1}; returns the cost.
    pub(super) fn defects(
        &mut self,
        problem: &mut Problem,
        trajectory: &Trajectory,
        gaps: &mut [f64],
    ) -> Result<f64, OptimalControlError> {
        let n = self.displacement.len();
        let mut cost = 0.0;
        problem.space.difference(trajectory.state(0), &problem.initial_state, &mut gaps[..n]);
        for node in 0..problem.nodes() {
            let (x, u) = (trajectory.state(node), trajectory.control(node));
            problem.step(node, x, u, &mut self.next)?;
            let gap = &mut gaps[(node + 1) * n..(node + 2) * n];
            problem.space.difference(trajectory.state(node + 1), &self.next, gap);
            cost += problem.cost(node, x, u)?;
        }
        Ok(cost + problem.cost(problem.nodes(), trajectory.state(problem.nodes()), &[])?)
    }

    /// Rolls the policies out with a step length α into `trial`; returns its cost.
    ///
    /// u = u_k + α k + K (x ⊖ x_k) within the bounds, and x_{k+1} = f(x, u) ⊕ (α − 1) f̄_{k+1}: the defects
    /// f̄ shrink by 1 − α, as in the linear model.
    pub(super) fn roll_out(
        &mut self,
        problem: &mut Problem,
        (current, gaps): (&Trajectory, &[f64]),
        policies: &[Policy],
        length: f64,
        trial: &mut Trajectory,
    ) -> Result<f64, OptimalControlError> {
        let n = self.displacement.len();
        let mut cost = 0.0;
        self.next.copy_from_slice(&problem.initial_state);
        for node in 0..=policies.len() {
            self.open_gap(problem, &gaps[node * n..(node + 1) * n], length, trial.state_mut(node));
            let Some(policy) = policies.get(node) else { break };
            problem.space.difference(current.state(node), trial.state(node), &mut self.displacement);
            let rows = policy.gain.chunks_exact(n).zip(&policy.feedforward).zip(current.control(node));
            for (u, ((gain, k), now)) in trial.control_mut(node).iter_mut().zip(rows) {
                *u = now + length * k + dot(gain, &self.displacement);
            }
            problem.control_bounds(node).clamp(trial.control_mut(node));
            let (x, u) = (trial.state(node), trial.control(node));
            problem.step(node, x, u, &mut self.next)?;
            cost += problem.cost(node, x, u)?;
        }
        Ok(cost + problem.cost(policies.len(), trial.state(policies.len()), &[])?)
    }

    /// x = `next` ⊕ (α − 1) f̄.
    fn open_gap(&mut self, problem: &Problem, gap: &[f64], length: f64, x: &mut [f64]) {
        if length == 1.0 || gap.iter().all(|f| *f == 0.0) {
            x.copy_from_slice(&self.next);
            return;
        }
        self.displacement.iter_mut().zip(gap).for_each(|(d, f)| *d = (length - 1.0) * f);
        problem.space.integrate(&self.next, &self.displacement, x);
    }
}
