//! The constraints of the inner solver of an augmented Lagrangian.

use super::Fddp;
use super::evaluation::failed;
use crate::optimal::constraint::NodeConstraint;
use crate::optimal::error::{Evaluation, OptimalControlError};
use robot_dynamics_simulation::StepError;

impl Fddp {
    /// Changes the penalty of all threads; also sets all multipliers to zero if asked to.
    pub(in crate::optimal) fn set_penalty(&mut self, penalty: f64, clears_multipliers: bool) {
        for problem in &mut self.workers {
            problem.penalty = penalty;
            if clears_multipliers {
                problem.constraints.iter_mut().for_each(NodeConstraint::clear_multipliers);
            }
        }
    }

    pub(in crate::optimal) fn set_gradient_tolerance(&mut self, tolerance: f64) {
        self.options.gradient_tolerance = tolerance;
    }

    /// The largest violation of a constraint along the trajectory.
    pub(in crate::optimal) fn violation(&mut self) -> Result<f64, OptimalControlError> {
        let mut most = 0.0_f64;
        self.for_each_constraint(|constraint, node, x, u, penalty| {
            most = most.max(constraint.violation(node, x, u, penalty)?);
            Ok(())
        })?;
        Ok(most)
    }

    /// λ ← μ (z − Π z) of all constraints.
    pub(in crate::optimal) fn update_multipliers(&mut self) -> Result<(), OptimalControlError> {
        self.for_each_constraint(|constraint, node, x, u, penalty| {
            constraint.update_multipliers(node, x, u, penalty)
        })?;
        let (first, others) = self.workers.split_first_mut().expect("a problem");
        for other in others {
            for (to, from) in other.constraints.iter_mut().zip(&first.constraints) {
                to.copy_multipliers(from);
            }
        }
        Ok(())
    }

    /// The cost J of the trajectory without the terms of the constraints.
    pub(in crate::optimal) fn cost_without_constraints(&mut self) -> Result<f64, OptimalControlError> {
        let (problem, trajectory) = (&mut self.workers[0], &self.current);
        (0..=self.policies.len()).try_fold(0.0, |sum, node| {
            let cost = problem.own_cost(node, trajectory.state(node), trajectory.control(node));
            Ok(sum + cost.map_err(failed(node, Evaluation::Cost))?)
        })
    }

    fn for_each_constraint(
        &mut self,
        mut call: impl FnMut(&mut NodeConstraint, usize, &[f64], &[f64], f64) -> Result<(), StepError>,
    ) -> Result<(), OptimalControlError> {
        let (problem, trajectory) = (&mut self.workers[0], &self.current);
        let penalty = problem.penalty;
        for node in 0..=self.policies.len() {
            for constraint in problem.constraints.iter_mut().filter(|one| one.applies_to(node)) {
                let (x, u) = (trajectory.state(node), trajectory.control(node));
                call(constraint, node, x, u, penalty).map_err(failed(node, Evaluation::Constraint))?;
            }
        }
        Ok(())
    }
}
