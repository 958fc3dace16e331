//! Vector-Jacobian products of the two solutions of the equation of motion.

use robot_dynamics::batch::{self, BadStates, BatchWorkspace};
use robot_dynamics::derivatives::{
    ForwardPullbackInputs, ForwardPullbackMut, InversePullbackInputs, InversePullbackMut,
    forward_dynamics_pullback_with_parameters, inverse_dynamics_pullback_with_parameters,
};
use robot_dynamics::model::{Model, Workspace};

use crate::ffi::ArrayNumber;
use crate::results::{MOST_OPERANDS, MOST_RESULTS, Results};

/// The function whose pullback is computed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pullback {
    InverseDynamics,
    ForwardDynamics,
}

impl Pullback {
    /// Computes one state. Reads q, v, a or τ, and the cotangent. Writes the cotangents of the first three
    /// and, if their slice is not empty, of the parameters.
    pub(crate) fn of_one(
        self,
        model: &Model,
        workspace: &mut Workspace,
        &[q, v, third, cotangent, _]: &[&[f64]; MOST_OPERANDS],
        [by_q, by_v, by_third, by_parameters]: Results<'_>,
    ) {
        // The library adds to these.
        by_parameters.fill(0.0);
        match self {
            Self::InverseDynamics => inverse_dynamics_pullback_with_parameters(
                model,
                workspace,
                InversePullbackInputs { q, v, a: third, wrenches: &[], cotangent },
                InversePullbackMut {
                    by_position: by_q,
                    by_velocity: by_v,
                    by_acceleration: by_third,
                    parameters: by_parameters,
                },
            ),
            Self::ForwardDynamics => {
                let a = &mut vec![0.0; model.nv()];
                let out = ForwardPullbackMut {
                    acceleration: a,
                    by_position: by_q,
                    by_velocity: by_v,
                    by_force: by_third,
                    parameters: by_parameters,
                };
                forward_dynamics_pullback_with_parameters(
                    model,
                    workspace,
                    ForwardPullbackInputs { q, v, tau: third, wrenches: &[], cotangent },
                    out,
                );
            }
        }
    }

    /// Computes many states.
    pub(crate) fn of_many<T: ArrayNumber>(
        self,
        model: &Model,
        workspace: &mut BatchWorkspace<T>,
        [q, v, third, cotangent, _]: [&[T]; MOST_OPERANDS],
        [by_q, by_v, by_third, by_parameters]: [&mut [T]; MOST_RESULTS],
    ) -> Result<(), BadStates> {
        let w = workspace;
        match self {
            Self::InverseDynamics => batch::inverse_dynamics_pullback(
                model,
                w,
                q,
                v,
                third,
                cotangent,
                batch::InversePullbackMut {
                    by_position: by_q,
                    by_velocity: by_v,
                    by_acceleration: by_third,
                    parameters: by_parameters,
                },
            ),
            Self::ForwardDynamics => {
                let a = &mut vec![T::of(0.0); third.len()];
                let out = batch::ForwardPullbackMut {
                    acceleration: a,
                    by_position: by_q,
                    by_velocity: by_v,
                    by_force: by_third,
                    parameters: by_parameters,
                };
                batch::forward_dynamics_pullback(model, w, q, v, third, cotangent, out)
            }
        }
    }
}
