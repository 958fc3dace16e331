//! The optimal control problem: dynamics, costs and bounds by node.

use std::ops::Range;

use robot_dynamics_number::InvalidInput;

use super::constraint::NodeConstraint;
use super::residual::{Residual, ResidualInputs};
use super::{ControlBounds, Cost, DiscreteDynamics, StateSpace};

/// A problem with N nodes: x₀, and the dynamics, cost and bounds of each node.
///
/// All nodes have one state space. Nodes may have different dynamics, as the phases of a gait do, and
/// different costs.
///
/// ```
/// use nalgebra::dmatrix;
/// use robot_dynamics::control::optimal::{ControlBounds, ControlResidual, Cost, LinearDynamics, Problem};
/// use robot_dynamics::control::optimal::{StateResidual, StateSpace};
/// // A mass of 1 kg, pushed for 30 steps of 0.1 s with at most 1 N, comes to rest at the origin.
/// let mass = LinearDynamics::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1])?;
/// let mut problem = Problem::new(mass, &[1.0, 0.0], 30)?;
/// let (mut running, mut terminal) = (Cost::new(), Cost::new());
/// running.add(ControlResidual::new(&[0.0])?, 0.1)?;
/// terminal.add(StateResidual::new(&StateSpace::vector(2), &[0.0, 0.0])?, 100.0)?;
/// problem.set_running_cost(0..30, running)?;
/// problem.set_terminal_cost(terminal)?;
/// problem.set_control_bounds(0..30, ControlBounds::new(&[-1.0], &[1.0])?)?;
/// assert_eq!(problem.nodes(), 30);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[doc(alias = "ShootingProblem")]
pub struct Problem {
    pub(super) space: StateSpace,
    pub(super) initial_state: Vec<f64>,
    pub(super) dynamics: Vec<Box<dyn DiscreteDynamics>>,
    /// The last one is the terminal cost.
    pub(super) costs: Vec<Cost>,
    pub(super) bounds: Vec<ControlBounds>,
    pub(super) nodes: Vec<Node>,
    pub(super) constraints: Vec<NodeConstraint>,
    /// μ of the constraints' terms.
    pub(super) penalty: f64,
}

/// The parts of a node, by their indices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub dynamics: usize,
    pub cost: usize,
    pub bounds: usize,
    pub controls: usize,
}

/// The index of the terminal cost, and that of the running cost 0.
const TERMINAL: usize = 0;
const NO_COST: usize = 1;

impl Problem {
    /// A problem with one dynamics in all nodes, without costs and bounds.
    ///
    /// # Errors
    /// [`InvalidInput`] if there are no nodes, the dynamics has no controls, or x₀ is not a state.
    pub fn new(
        dynamics: impl DiscreteDynamics + 'static,
        initial_state: &[f64],
        nodes: usize,
    ) -> Result<Self, InvalidInput> {
        let (space, controls) = (dynamics.state_space().clone(), dynamics.controls());
        if nodes == 0 || controls == 0 {
            return Err(InvalidInput::unmet("the problem", "needs a node and a control; it has none"));
        }
        space.check("the initial state", initial_state)?;
        let node = Node { dynamics: 0, cost: NO_COST, bounds: 0, controls };
        Ok(Self {
            space,
            initial_state: initial_state.to_vec(),
            dynamics: vec![Box::new(dynamics)],
            costs: vec![Cost::new(), Cost::new()],
            bounds: vec![ControlBounds::unbounded(controls)],
            nodes: vec![node; nodes],
            constraints: Vec::new(),
            penalty: 1.0,
        })
    }

    /// The number of nodes N; the trajectory has N + 1 states.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// The state space.
    pub fn state_space(&self) -> &StateSpace {
        &self.space
    }

    /// x₀.
    pub fn initial_state(&self) -> &[f64] {
        &self.initial_state
    }

    /// The number of controls of a node.
    ///
    /// # Panics
    /// If the node does not exist.
    #[track_caller]
    pub fn controls(&self, node: usize) -> usize {
        self.nodes[node].controls
    }

    /// The bounds of a node.
    ///
    /// # Panics
    /// If the node does not exist.
    #[track_caller]
    pub fn control_bounds(&self, node: usize) -> &ControlBounds {
        &self.bounds[self.nodes[node].bounds]
    }

    /// Changes x₀.
    ///
    /// # Errors
    /// [`InvalidInput`] if it is not a state.
    pub fn set_initial_state(&mut self, state: &[f64]) -> Result<(), InvalidInput> {
        self.space.check("the initial state", state)?;
        self.initial_state.copy_from_slice(state);
        Ok(())
    }

    /// Gives some nodes other dynamics. If the number of controls changes, these nodes lose cost and bounds.
    ///
    /// # Errors
    /// [`InvalidInput`] if the range is beyond the nodes, or the state space differs. Nodes without controls,
    /// such as impacts, are allowed.
    pub fn set_dynamics(
        &mut self,
        nodes: Range<usize>,
        dynamics: impl DiscreteDynamics + 'static,
    ) -> Result<(), InvalidInput> {
        self.check_range(&nodes)?;
        let controls = dynamics.controls();
        if !dynamics.state_space().equals(&self.space) {
            let required = "must have the problem's state space";
            return Err(InvalidInput::unmet("the dynamics of a node", required));
        }
        let (index, bounds) = (self.dynamics.len(), self.bounds.len());
        self.dynamics.push(Box::new(dynamics));
        self.bounds.push(ControlBounds::unbounded(controls));
        for node in &mut self.nodes[nodes] {
            let kept =
                if node.controls == controls { *node } else { Node { cost: NO_COST, bounds, ..*node } };
            *node = Node { dynamics: index, controls, ..kept };
        }
        Ok(())
    }

    /// Gives some nodes a cost.
    ///
    /// # Errors
    /// [`InvalidInput`] if the range is beyond the nodes, or a term expects other states or controls.
    pub fn set_running_cost(&mut self, nodes: Range<usize>, cost: Cost) -> Result<(), InvalidInput> {
        self.check_range(&nodes)?;
        for node in &self.nodes[nodes.clone()] {
            self.check_cost(&cost, node.controls)?;
        }
        self.nodes[nodes.clone()].iter_mut().for_each(|node| node.cost = NO_COST);
        // A cost that no node uses any more is replaced.
        let is_used = |index: usize| self.nodes.iter().any(|node| node.cost == index);
        let unused = (NO_COST + 1..self.costs.len()).find(|index| !is_used(*index));
        let index = unused.unwrap_or(self.costs.len());
        self.costs.resize_with(self.costs.len().max(index + 1), Cost::new);
        self.costs[index] = cost;
        self.nodes[nodes].iter_mut().for_each(|node| node.cost = index);
        Ok(())
    }

    /// Sets the cost of the last state, ℓ_N(x_N).
    ///
    /// # Errors
    /// [`InvalidInput`] if a term expects another state, or depends on controls.
    pub fn set_terminal_cost(&mut self, cost: Cost) -> Result<(), InvalidInput> {
        self.check_cost(&cost, 0)?;
        self.costs[TERMINAL] = cost;
        Ok(())
    }

    /// Bounds the controls of some nodes.
    ///
    /// # Errors
    /// [`InvalidInput`] if the range is beyond the nodes, or a node has another number of controls.
    pub fn set_control_bounds(
        &mut self,
        nodes: Range<usize>,
        bounds: ControlBounds,
    ) -> Result<(), InvalidInput> {
        self.check_range(&nodes)?;
        for node in &self.nodes[nodes.clone()] {
            if node.controls != bounds.lower.len() {
                let counts = format!("are {}, the node has {} controls", bounds.lower.len(), node.controls);
                return Err(InvalidInput::unmet("the bounds on the controls", counts));
            }
        }
        let index = self.bounds.len();
        self.bounds.push(bounds);
        self.nodes[nodes].iter_mut().for_each(|node| node.bounds = index);
        Ok(())
    }

    /// Constrains some nodes: l ≤ c(x, u) ≤ h by entry; equal bounds are an equality.
    /// [`AugmentedLagrangian`](super::AugmentedLagrangian) solves problems with constraints.
    ///
    /// # Errors
    /// [`InvalidInput`] if the range is beyond the nodes, c expects other states or controls, or the bounds
    /// are not one for each entry.
    pub fn add_constraint(
        &mut self,
        nodes: Range<usize>,
        constraint: impl Residual + 'static,
        lower: &[f64],
        upper: &[f64],
    ) -> Result<(), InvalidInput> {
        self.check_range(&nodes)?;
        let constraint = NodeConstraint::new(Box::new(constraint), lower, upper, nodes.clone())?;
        for node in &self.nodes[nodes] {
            check_inputs("the constraint", constraint.expects(), &self.space, node.controls)?;
        }
        self.constraints.push(constraint);
        Ok(())
    }

    /// Constrains the last state: l ≤ c(x_N) ≤ h by entry.
    ///
    /// # Errors
    /// As [`add_constraint`](Self::add_constraint), and if c depends on controls.
    pub fn add_terminal_constraint(
        &mut self,
        constraint: impl Residual + 'static,
        lower: &[f64],
        upper: &[f64],
    ) -> Result<(), InvalidInput> {
        let last = self.nodes();
        let constraint = NodeConstraint::new(Box::new(constraint), lower, upper, last..last + 1)?;
        check_inputs("the terminal constraint", constraint.expects(), &self.space, 0)?;
        self.constraints.push(constraint);
        Ok(())
    }

    /// The terminal cost.
    pub(super) fn terminal_cost(&mut self) -> &mut Cost {
        &mut self.costs[TERMINAL]
    }

    fn check_range(&self, nodes: &Range<usize>) -> Result<(), InvalidInput> {
        let count = self.nodes();
        if nodes.start < nodes.end && nodes.end <= count {
            return Ok(());
        }
        let required = format!("must be a range within 0..{count}, got {}..{}", nodes.start, nodes.end);
        Err(InvalidInput::unmet("the nodes", required))
    }

    fn check_cost(&self, cost: &Cost, controls: usize) -> Result<(), InvalidInput> {
        for (index, term) in cost.terms().iter().enumerate() {
            check_inputs(&format!("term {index} of the cost"), term.expects(), &self.space, controls)?;
        }
        Ok(())
    }
}

/// Checks that a function of a node expects the node's states and controls.
pub(super) fn check_inputs(
    quantity: &str,
    expected: ResidualInputs,
    space: &StateSpace,
    controls: usize,
) -> Result<(), InvalidInput> {
    let found = [("coordinates of x", space.coordinates()), ("controls", controls)];
    for ((unit, found), expected) in found.into_iter().zip([expected.coordinates, expected.controls]) {
        if let Some(expected) = expected.filter(|expected| *expected != found) {
            return Err(InvalidInput::unmet(
                quantity,
                format!("expects {expected} {unit}, the node has {found}"),
            ));
        }
    }
    Ok(())
}
