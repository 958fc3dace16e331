//! The memory of a solver: trajectories, models of the nodes, and policies.

use crate::optimal::cost::CostExpansion;
use crate::optimal::problem::Problem;

/// States and controls of all nodes.
#[derive(Clone, Debug)]
pub(crate) struct Trajectory {
    states: Vec<f64>,
    controls: Vec<f64>,
    /// The numbers of a state.
    coordinates: usize,
    /// The first control of each node, and the end.
    starts: Vec<usize>,
}

impl Trajectory {
    /// The initial state in all nodes, and the controls nearest to zero.
    pub(super) fn new(problem: &Problem) -> Self {
        let mut starts = vec![0];
        for node in 0..problem.nodes() {
            starts.push(starts[node] + problem.controls(node));
        }
        let states = problem.initial_state().repeat(problem.nodes() + 1);
        let controls = vec![0.0; starts[problem.nodes()]];
        let coordinates = problem.state_space().coordinates();
        let mut trajectory = Self { states, controls, coordinates, starts };
        trajectory.clamp(problem);
        trajectory
    }

    pub(super) fn state(&self, node: usize) -> &[f64] {
        &self.states[node * self.coordinates..][..self.coordinates]
    }

    pub(super) fn state_mut(&mut self, node: usize) -> &mut [f64] {
        &mut self.states[node * self.coordinates..][..self.coordinates]
    }

    /// The controls of a node; none at the terminal node.
    pub(super) fn control(&self, node: usize) -> &[f64] {
        let end = self.starts.get(node + 1).copied().unwrap_or(self.starts[node]);
        &self.controls[self.starts[node]..end]
    }

    pub(super) fn control_mut(&mut self, node: usize) -> &mut [f64] {
        &mut self.controls[self.starts[node]..self.starts[node + 1]]
    }

    /// Moves all controls within their bounds.
    pub(super) fn clamp(&mut self, problem: &Problem) {
        for node in 0..problem.nodes() {
            problem.control_bounds(node).clamp(self.control_mut(node));
        }
    }
}

/// The linear-quadratic model of a node.
#[derive(Clone, Debug)]
pub(crate) struct NodeModel {
    /// A and B.
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    /// The derivatives of the cost.
    pub state_gradient: Vec<f64>,
    pub control_gradient: Vec<f64>,
    pub state_hessian: Vec<f64>,
    pub cross_hessian: Vec<f64>,
    pub control_hessian: Vec<f64>,
}

impl NodeModel {
    /// The memory for n entries of δx and m controls; the terminal node has no dynamics.
    pub(super) fn new(n: usize, m: usize, is_terminal: bool) -> Self {
        Self {
            a: vec![0.0; if is_terminal { 0 } else { n * n }],
            b: vec![0.0; n * m],
            state_gradient: vec![0.0; n],
            control_gradient: vec![0.0; m],
            state_hessian: vec![0.0; n * n],
            cross_hessian: vec![0.0; m * n],
            control_hessian: vec![0.0; m * m],
        }
    }

    pub(super) fn expansion(&mut self) -> CostExpansion<'_> {
        CostExpansion {
            state_gradient: &mut self.state_gradient,
            control_gradient: &mut self.control_gradient,
            state_hessian: &mut self.state_hessian,
            cross_hessian: &mut self.cross_hessian,
            control_hessian: &mut self.control_hessian,
        }
    }
}

/// The policy δu = k + K δx of a node.
#[derive(Clone, Debug)]
pub(crate) struct Policy {
    /// k, m numbers.
    pub feedforward: Vec<f64>,
    /// K, m×n, row-major.
    pub gain: Vec<f64>,
}

impl Policy {
    pub(super) fn new(n: usize, m: usize) -> Self {
        Self { feedforward: vec![0.0; m], gain: vec![0.0; m * n] }
    }
}
