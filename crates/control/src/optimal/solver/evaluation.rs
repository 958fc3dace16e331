//! The functions of a node: one step, the cost, and the linear-quadratic model, in several threads.

use super::memory::{NodeModel, Trajectory};
use crate::optimal::dynamics::LinearizedDynamics;
use crate::optimal::error::{Evaluation, OptimalControlError};
use crate::optimal::problem::Problem;
use robot_dynamics_number::check_result;
use robot_dynamics_simulation::StepError;

impl Problem {
    /// f(x, u) of a node.
    pub(in crate::optimal) fn step(
        &mut self,
        node: usize,
        x: &[f64],
        u: &[f64],
        next: &mut [f64],
    ) -> Result<(), OptimalControlError> {
        let index = self.nodes[node].dynamics;
        self.dynamics[index].step(x, u, next).map_err(failed(node, Evaluation::Dynamics))
    }

    /// The cost of a node, the terminal one included, with the terms of its constraints.
    pub(in crate::optimal) fn cost(
        &mut self,
        node: usize,
        x: &[f64],
        u: &[f64],
    ) -> Result<f64, OptimalControlError> {
        self.reuse_forces(node);
        let mut cost = self.own_cost(node, x, u).map_err(failed(node, Evaluation::Cost))?;
        let penalty = self.penalty;
        for constraint in self.constraints.iter_mut().filter(|one| one.applies_to(node)) {
            let term = constraint.value(node, x, u, penalty);
            cost += term.map_err(failed(node, Evaluation::Constraint))?;
        }
        let finite = check_result("the cost", &[cost]).map_err(StepError::from);
        finite.map_err(failed(node, Evaluation::Cost))?;
        Ok(cost)
    }

    /// Hands the forces of a node's last evaluation to its terms.
    fn reuse_forces(&mut self, node: usize) {
        let Some(of_node) = self.nodes.get(node) else { return };
        if let Some(forces) = self.dynamics[of_node.dynamics].contact_forces() {
            self.costs[of_node.cost].reuse(&forces);
            let own = self.constraints.iter_mut().filter(|one| one.applies_to(node));
            own.for_each(|constraint| constraint.reuse(&forces));
        }
    }

    /// The cost of a node without the terms of its constraints.
    pub(super) fn own_cost(&mut self, node: usize, x: &[f64], u: &[f64]) -> Result<f64, StepError> {
        match self.nodes.get(node) {
            Some(of_node) => self.costs[of_node.cost].value(x, u),
            None => self.terminal_cost().value(x, u),
        }
    }

    /// The model of a node, the terminal one included.
    fn linearize(
        &mut self,
        node: usize,
        x: &[f64],
        u: &[f64],
        model: &mut NodeModel,
    ) -> Result<(), OptimalControlError> {
        let cost = match self.nodes.get(node) {
            Some(of_node) => {
                let derivatives = LinearizedDynamics { by_state: &mut model.a, by_control: &mut model.b };
                let linearized = self.dynamics[of_node.dynamics].linearize(x, u, derivatives);
                linearized.map_err(failed(node, Evaluation::Linearization))?;
                self.reuse_forces(node);
                &mut self.costs[self.nodes[node].cost]
            }
            None => self.terminal_cost(),
        };
        cost.expand(x, u, model.expansion()).map_err(failed(node, Evaluation::Cost))?;
        let (penalty, mut expansion) = (self.penalty, model.expansion());
        for constraint in self.constraints.iter_mut().filter(|one| one.applies_to(node)) {
            let added = constraint.add_expansion(node, x, u, penalty, &mut expansion);
            added.map_err(failed(node, Evaluation::Constraint))?;
        }
        let gradients = model.state_gradient.iter().chain(&model.control_gradient);
        let finite = check_result("the gradient of the cost", gradients).map_err(StepError::from);
        finite.map_err(failed(node, Evaluation::Cost))
    }
}

pub(super) fn failed(node: usize, evaluation: Evaluation) -> impl Fn(StepError) -> OptimalControlError {
    move |cause| OptimalControlError::Node { node, evaluation, cause }
}

/// Computes the models of all nodes along a trajectory; each worker of several takes a range of them.
pub(super) fn linearize_nodes(
    workers: &mut [Problem],
    trajectory: &Trajectory,
    models: &mut [NodeModel],
) -> Result<(), OptimalControlError> {
    let share = models.len().div_ceil(workers.len());
    let linearize = |worker: &mut Problem, first: usize, models: &mut [NodeModel]| {
        let mut nodes = models.iter_mut().zip(first..);
        nodes.try_for_each(|(model, node)| {
            worker.linearize(node, trajectory.state(node), trajectory.control(node), model)
        })
    };
    if let [worker] = workers {
        return linearize(worker, 0, models);
    }
    let ranges = models.chunks_mut(share).zip(workers.iter_mut()).enumerate();
    std::thread::scope(|scope| {
        let start = |(index, (models, worker))| {
            let linearize = &linearize;
            scope.spawn(move || linearize(worker, index * share, models))
        };
        let threads: Vec<_> = ranges.map(start).collect();
        // The first error is that of the first node.
        threads
            .into_iter()
            .try_for_each(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}
