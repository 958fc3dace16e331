//! The numbers of batches, `f64` and `f32`, and the batch algorithms compiled once for each in this crate.
//!
//! A generic function is compiled in every program that calls it, and each of these takes seconds for each
//! instruction set. The methods below are not generic, so programs call the compiled code of this library.

use robot_dynamics_core::Model;
use robot_dynamics_number::Float;
use robot_dynamics_simulation::Rollout;

use crate::computation::frames::{Jacobian, Poses};
use crate::computation::operation::compute;
use crate::computation::recursions::{Acceleration, Forces, InverseMass, Mass};
use crate::computation::related_mass::RelatedMass;
use crate::computation::{derivatives, pullback};
use crate::rollout::pullback::{RolloutPullbackInputs, compute as pull_rollout_back};
use crate::rollout::states::{RolloutStates, move_states};
use crate::rollout::{RolloutError, RolloutObserver, Torques};
use crate::tables::InputTables;
use crate::threads::Pool;
use crate::{BadStates, BatchOptions, BatchWorkspace};

/// A quantity with one table of results.
#[derive(Clone, Copy)]
pub enum Quantity<'a> {
    Forces(Forces),
    Acceleration,
    Mass,
    RelatedMass,
    InverseMass,
    Poses(Poses<'a>),
    Jacobian(Jacobian),
}

/// A number type of batches: `f64` or `f32`.
pub trait BatchFloat: Float {
    #[doc(hidden)]
    fn workspace(model: &Model, pool: Pool, options: BatchOptions) -> BatchWorkspace<Self>;

    #[doc(hidden)]
    fn compute(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        quantity: Quantity<'_>,
        tables: &InputTables<'_, Self>,
        result: &str,
        output: &mut [Self],
    ) -> Result<(), BadStates>;

    #[doc(hidden)]
    fn derivatives(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        is_forward: bool,
        tables: &InputTables<'_, Self>,
        results: [&mut [Self]; 3],
    ) -> Result<(), BadStates>;

    #[doc(hidden)]
    fn rollout(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        rollout: &Rollout,
        torques: Torques<'_, Self>,
        states: RolloutStates<'_, Self>,
        progress: RolloutObserver<'_>,
    ) -> Result<(), RolloutError>;

    #[doc(hidden)]
    fn pullback(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        is_forward: bool,
        tables: &InputTables<'_, Self, 4>,
        results: [&mut [Self]; 5],
    ) -> Result<(), BadStates>;

    #[doc(hidden)]
    fn rollout_pullback(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        rollout: &Rollout,
        given: &RolloutPullbackInputs<'_, Self>,
        results: [&mut [Self]; 4],
        progress: RolloutObserver<'_>,
    ) -> Result<(), RolloutError>;
}

macro_rules! batch_float {
    ($float:ty) => {
        impl BatchFloat for $float {
            fn workspace(model: &Model, pool: Pool, options: BatchOptions) -> BatchWorkspace<Self> {
                BatchWorkspace::on(model, pool, options)
            }

            #[track_caller]
            fn compute(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                quantity: Quantity<'_>,
                tables: &InputTables<'_, Self>,
                result: &str,
                output: &mut [Self],
            ) -> Result<(), BadStates> {
                match quantity {
                    Quantity::Forces(forces) => compute(model, workspace, forces, tables, result, output),
                    Quantity::Acceleration => compute(model, workspace, Acceleration, tables, result, output),
                    Quantity::Mass => compute(model, workspace, Mass, tables, result, output),
                    Quantity::RelatedMass => compute(model, workspace, RelatedMass, tables, result, output),
                    Quantity::InverseMass => compute(model, workspace, InverseMass, tables, result, output),
                    Quantity::Poses(poses) => compute(model, workspace, poses, tables, result, output),
                    Quantity::Jacobian(jacobian) => {
                        compute(model, workspace, jacobian, tables, result, output)
                    }
                }
            }

            #[track_caller]
            fn derivatives(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                is_forward: bool,
                tables: &InputTables<'_, Self>,
                results: [&mut [Self]; 3],
            ) -> Result<(), BadStates> {
                if is_forward {
                    derivatives::compute::<Self, true>(model, workspace, tables, results)
                } else {
                    derivatives::compute::<Self, false>(model, workspace, tables, results)
                }
            }

            #[track_caller]
            fn rollout(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                rollout: &Rollout,
                torques: Torques<'_, Self>,
                states: RolloutStates<'_, Self>,
                progress: RolloutObserver<'_>,
            ) -> Result<(), RolloutError> {
                move_states(model, workspace, rollout, torques, states, progress)
            }

            #[track_caller]
            fn pullback(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                is_forward: bool,
                tables: &InputTables<'_, Self, 4>,
                results: [&mut [Self]; 5],
            ) -> Result<(), BadStates> {
                if is_forward {
                    pullback::compute::<Self, true>(model, workspace, tables, results)
                } else {
                    pullback::compute::<Self, false>(model, workspace, tables, results)
                }
            }

            #[track_caller]
            fn rollout_pullback(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                rollout: &Rollout,
                given: &RolloutPullbackInputs<'_, Self>,
                results: [&mut [Self]; 4],
                progress: RolloutObserver<'_>,
            ) -> Result<(), RolloutError> {
                pull_rollout_back(model, workspace, rollout, given, results, progress)
            }
        }
    };
}
batch_float!(f64);
batch_float!(f32);
