//! The library's calls for one state and for rows of states.

use robot_dynamics::algorithms;
use robot_dynamics::batch::{self, BatchFloat, BatchWorkspace};
use robot_dynamics::derivatives::{
    self, ForwardDynamicsDerivativesMut, ForwardPullbackMut, InverseDynamicsDerivativesMut,
    InversePullbackMut, MotionCotangents, RobotState, StepPullbackWorkspace, TrajectoryCotangents,
    step_pullback,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Integrator, StepForces};
use robot_dynamics_functions::Function;

use crate::STEP;

/// The integrator whose step is pulled back.
pub(crate) fn integrator(function: &Function) -> Option<Integrator> {
    let rows = [Function::SemiImplicitEulerStep, Function::Rk4Step];
    rows.into_iter().find(|step| step.clone().pullback() == *function).and_then(|step| step.integrator())
}

/// The library's memory for one state.
pub(crate) struct Memory {
    plain: Workspace<f64>,
    step: StepPullbackWorkspace<f64>,
}

impl Memory {
    pub(crate) fn new(model: &Model) -> Self {
        Self { plain: Workspace::new(model), step: StepPullbackWorkspace::new(model) }
    }

    /// The library's call for one state.
    pub(crate) fn call(
        &mut self,
        model: &Model,
        function: &Function,
        arguments: &[&[f64]],
        results: &mut [Vec<f64>],
    ) {
        let Self { plain: w, step } = self;
        if let Some(row) = integrator(function) {
            let ([q, v, tau, h, cotangent], [x, y, z]) = (arguments, results) else {
                unreachable!("a step's pullback has five arguments")
            };
            x.copy_from_slice(&cotangent[..model.nv()]);
            y.copy_from_slice(&cotangent[model.nv()..]);
            let forces = StepForces::new(tau, true);
            let cotangents =
                MotionCotangents { by_position: x, by_velocity: y, by_force: z, parameters: &mut [] };
            step_pullback(model, row, step, &forces, h[0], RobotState { q, v }, cotangents)
                .expect("a regular M");
            return;
        }
        match (function, arguments, results) {
            (Function::InverseDynamics, [q, v, a], [x]) => algorithms::inverse_dynamics(model, w, q, v, a, x),
            (Function::ForwardDynamics, [q, v, tau], [x]) => {
                algorithms::forward_dynamics(model, w, q, v, tau, x);
            }
            (Function::MassMatrix, [q], [x]) => algorithms::mass_matrix(model, w, q, x),
            (Function::MassMatrixFactor, [q], [x]) => algorithms::mass_matrix_factor(model, w, q, x),
            (Function::InverseDynamicsDerivatives, [q, v, a], [by_position, by_velocity]) => {
                let out = InverseDynamicsDerivativesMut { by_position, by_velocity };
                derivatives::inverse_dynamics_derivatives(model, w, q, v, a, out);
            }
            (Function::ForwardDynamicsDerivatives, [q, v, tau], [by_position, by_velocity, by_force]) => {
                let out = ForwardDynamicsDerivativesMut { by_position, by_velocity, by_force };
                derivatives::forward_dynamics_derivatives(model, w, q, v, tau, out);
            }
            (
                Function::InverseDynamicsPullback,
                [q, v, a, l],
                [by_position, by_velocity, by_acceleration],
            ) => {
                let out =
                    InversePullbackMut { by_position, by_velocity, by_acceleration, parameters: &mut [] };
                derivatives::inverse_dynamics_pullback(model, w, q, v, a, l, out);
            }
            (
                Function::ForwardDynamicsPullback,
                [q, v, tau, l],
                [acceleration, by_position, by_velocity, by_force],
            ) => {
                let out = ForwardPullbackMut {
                    acceleration,
                    by_position,
                    by_velocity,
                    by_force,
                    parameters: &mut [],
                };
                derivatives::forward_dynamics_pullback(model, w, q, v, tau, l, out);
            }
            _ => unreachable!("a function has its arguments and results"),
        }
    }
}

/// The library's call for rows, and whether it exists.
pub(crate) fn call_rows<T: BatchFloat>(
    function: &Function,
    model: &Model,
    w: &mut BatchWorkspace<T>,
    arguments: &[&[T]],
    results: &mut [Vec<T>],
) -> bool {
    if let Some(row) = integrator(function) {
        let ([q, v, tau, _, cotangent], [x, y, z]) = (arguments, results) else {
            unreachable!("a step's pullback has five arguments")
        };
        let half = x.len();
        x.copy_from_slice(&cotangent[..half]);
        y.copy_from_slice(&cotangent[half..]);
        let how = batch::Rollout::new(row, STEP, 1);
        let (torques, trajectory) = (batch::Torques::Held(tau), TrajectoryCotangents::default());
        let inputs = batch::RolloutPullbackInputs { spacing: 0, torques, q, v, trajectory };
        let cotangents =
            MotionCotangents { by_position: x, by_velocity: y, by_force: z, parameters: &mut [] };
        batch::rollout_pullback(model, w, &how, &inputs, cotangents, None).expect("finite results");
        return true;
    }
    let ran = match (function, arguments, results) {
        (Function::InverseDynamics, [q, v, a], [x]) => batch::inverse_dynamics(model, w, q, v, a, x),
        (Function::ForwardDynamics, [q, v, tau], [x]) => batch::forward_dynamics(model, w, q, v, tau, x),
        (Function::MassMatrix, [q], [x]) => batch::mass_matrix(model, w, q, x),
        (Function::InverseDynamicsDerivatives, [q, v, a], [by_position, by_velocity]) => {
            batch::inverse_dynamics_derivatives(
                model,
                w,
                q,
                v,
                a,
                InverseDynamicsDerivativesMut { by_position, by_velocity },
            )
        }
        (Function::ForwardDynamicsDerivatives, [q, v, tau], [by_position, by_velocity, by_force]) => {
            let out = ForwardDynamicsDerivativesMut { by_position, by_velocity, by_force };
            batch::forward_dynamics_derivatives(model, w, q, v, tau, out)
        }
        (Function::InverseDynamicsPullback, [q, v, a, l], [by_position, by_velocity, by_acceleration]) => {
            batch::inverse_dynamics_pullback(
                model,
                w,
                q,
                v,
                a,
                l,
                InversePullbackMut { by_position, by_velocity, by_acceleration, parameters: &mut [] },
            )
        }
        (
            Function::ForwardDynamicsPullback,
            [q, v, tau, l],
            [acceleration, by_position, by_velocity, by_force],
        ) => {
            let out =
                ForwardPullbackMut { acceleration, by_position, by_velocity, by_force, parameters: &mut [] };
            batch::forward_dynamics_pullback(model, w, q, v, tau, l, out)
        }
        _ => return false,
    };
    ran.expect("finite results");
    true
}
