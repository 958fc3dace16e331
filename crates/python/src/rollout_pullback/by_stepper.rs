//! The pullback of rollouts with contact, stops and friction.

use pyo3::prelude::*;
use robot_dynamics::batch::{self, RolloutError};
use robot_dynamics::derivatives::{
    LinearizedSteps, MotionCotangents, RobotState, StepperPullbackWorkspace, StepperRollout,
    TrajectoryCotangents, rollout_pullback_by_stepper,
};
use robot_dynamics::simulation::{SimulationStepper, StepError};

use super::{PullbackTables, RolloutPullbackRequest, Steps};
use crate::errors::exception;
use crate::interrupts::{FEW_STEPS, interruptible, until};
use crate::number::Number;
use crate::threads;

impl RolloutPullbackRequest<'_, '_> {
    /// Computes states with contact, stops and friction. Returns those without a valid gradient, and how the
    /// steps were differentiated. A single state fails with its error.
    pub(super) fn by_stepper(
        &self,
        stepper: &SimulationStepper,
        states: Option<usize>,
        numbers: PullbackTables<'_, f64>,
    ) -> PyResult<(Vec<usize>, LinearizedSteps)> {
        let PullbackTables { q, v, tau, trajectory, by_position, by_velocity, by_force, by_parameters } =
            numbers;
        let Steps { step, steps, dissipates, stride } = self.how;
        let rollout =
            &StepperRollout::new(stepper, step, steps).with_dissipation(dissipates).with_stride(stride);
        let (model, spacing) = (&self.robot.model, self.spacing);
        let trajectory = TrajectoryCotangents { by_position: trajectory.0, by_velocity: trajectory.1 };
        let cotangents = MotionCotangents { by_position, by_velocity, by_force, parameters: by_parameters };
        let Some(states) = states else {
            let workspace = &mut StepperPullbackWorkspace::new(model, spacing);
            let start = RobotState { q, v };
            return rollout_pullback_by_stepper(
                model, rollout, workspace, start, tau, trajectory, cotangents,
            )
            .map(|counts| (Vec::new(), counts))
            .map_err(|error| match error {
                StepError::SingularMass(error) => exception(error),
                error => exception(error),
            });
        };
        let torques = self.torques(tau);
        let threads = self.threads.unwrap_or_else(threads::default_count);
        let memory = f64::batches(self.robot).take(model, threads)?;
        let workspace = &memory.workspace;
        let inputs = batch::RolloutPullbackInputs { spacing, torques, q, v, trajectory };
        // A step with contacts takes a hundred times as long as one without.
        let is_short = states * steps <= FEW_STEPS / 100;
        let outcome = interruptible(self.py, is_short, |cancelled| {
            let progress = until(cancelled);
            batch::rollout_pullback_by_stepper(
                model,
                workspace,
                rollout,
                &inputs,
                cotangents,
                Some(&progress),
            )
        });
        f64::batches(self.robot).give(memory);
        match outcome? {
            Ok(counts) => Ok((Vec::new(), counts)),
            Err(RolloutError::BadStates(bad)) => Ok((bad.states, LinearizedSteps::default())),
            Err(error) => Err(exception(error)),
        }
    }
}
