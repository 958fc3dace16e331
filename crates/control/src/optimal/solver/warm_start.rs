//! The start of a solver: states and controls of the user, or the last solution shifted by a node.

use std::ops::Range;

use robot_dynamics_number::{InputProblem, InvalidInput, check_finite};

use super::Fddp;
use crate::optimal::cost::Cost;
use crate::optimal::error::OptimalControlError;

impl Fddp {
    /// Starts from states and controls, which need not satisfy the dynamics: N + 1 states and N lists of
    /// controls. Controls are moved within their bounds.
    ///
    /// # Errors
    /// [`InvalidInput`] if a count or a length differs from the problem's, or a number is not finite.
    pub fn set_trajectory<X, U>(&mut self, states: &[X], controls: &[U]) -> Result<(), InvalidInput>
    where
        X: AsRef<[f64]>,
        U: AsRef<[f64]>,
    {
        let nodes = self.policies.len();
        check_count("the states", states.len(), nodes + 1)?;
        for (node, state) in states.iter().enumerate() {
            self.problem().state_space().check(&format!("state {node}"), state.as_ref())?;
        }
        self.set_controls(controls)?;
        for (node, state) in states.iter().enumerate() {
            self.current.state_mut(node).copy_from_slice(state.as_ref());
        }
        Ok(())
    }

    /// Starts from controls and the states of their rollout from x₀: without defects, as iLQR does.
    ///
    /// # Errors
    /// [`OptimalControlError`] if a count or a length differs from the problem's, a number is not finite, or
    /// the rollout fails.
    pub fn set_rollout<U: AsRef<[f64]>>(&mut self, controls: &[U]) -> Result<(), OptimalControlError> {
        self.set_controls(controls)?;
        self.current.clamp(&self.workers[0]);
        let problem = &mut self.workers[0];
        self.current.state_mut(0).copy_from_slice(&problem.initial_state);
        for node in 0..self.policies.len() {
            let next = self.trial.state_mut(node + 1);
            problem.step(node, self.current.state(node), self.current.control(node), next)?;
            self.current.state_mut(node + 1).copy_from_slice(next);
        }
        Ok(())
    }

    fn set_controls<U: AsRef<[f64]>>(&mut self, controls: &[U]) -> Result<(), InvalidInput> {
        check_count("the controls", controls.len(), self.policies.len())?;
        for (node, control) in controls.iter().enumerate() {
            let (quantity, control) = (format!("the controls of node {node}"), control.as_ref());
            check_count(&quantity, control.len(), self.problem().controls(node))?;
            check_finite(&quantity, control)?;
        }
        for (node, control) in controls.iter().enumerate() {
            self.current.control_mut(node).copy_from_slice(control.as_ref());
        }
        Ok(())
    }

    /// Changes x₀. The trajectory stays; its first state then has a defect, which the next solution closes.
    ///
    /// # Errors
    /// [`InvalidInput`] if it is not a state.
    pub fn set_initial_state(&mut self, state: &[f64]) -> Result<(), InvalidInput> {
        self.workers.iter_mut().try_for_each(|problem| problem.set_initial_state(state))
    }

    /// Changes the cost of some nodes, for example its target; the trajectory stays.
    ///
    /// # Errors
    /// As [`Problem::set_running_cost`](crate::optimal::Problem::set_running_cost).
    pub fn set_running_cost(&mut self, nodes: Range<usize>, cost: &Cost) -> Result<(), InvalidInput> {
        self.workers.iter_mut().try_for_each(|problem| problem.set_running_cost(nodes.clone(), cost.clone()))
    }

    /// Changes the cost of the last state; the trajectory stays.
    ///
    /// # Errors
    /// As [`Problem::set_terminal_cost`](crate::optimal::Problem::set_terminal_cost).
    pub fn set_terminal_cost(&mut self, cost: &Cost) -> Result<(), InvalidInput> {
        self.workers.iter_mut().try_for_each(|problem| problem.set_terminal_cost(cost.clone()))
    }

    /// Shifts the trajectory by one node, for the next period of a controller: x_k ← x_{k+1}, u_k ← u_{k+1}.
    /// The last controls repeat, and the last state follows from them, or repeats if that step fails.
    pub fn shift(&mut self) {
        let nodes = self.policies.len();
        let (trial, current) = (&mut self.trial, &mut self.current);
        for node in 0..=nodes {
            trial.state_mut(node).copy_from_slice(current.state((node + 1).min(nodes)));
        }
        for node in 0..nodes {
            let next = current.control((node + 1).min(nodes - 1));
            // Phases may have other controls; those keep their own.
            let next = if next.len() == current.control(node).len() { next } else { current.control(node) };
            trial.control_mut(node).copy_from_slice(next);
        }
        std::mem::swap(trial, current);
        let (last, next) = (nodes - 1, trial.state_mut(nodes));
        if self.workers[0].step(last, current.state(last), current.control(last), next).is_ok() {
            current.state_mut(nodes).copy_from_slice(trial.state(nodes));
        }
    }
}

fn check_count(quantity: &str, found: usize, expected: usize) -> Result<(), InvalidInput> {
    if found == expected {
        return Ok(());
    }
    let (owner, hint) = ("the problem".to_owned(), "");
    Err(InvalidInput::new(quantity, InputProblem::WrongLength { found, expected, owner, hint }))
}
