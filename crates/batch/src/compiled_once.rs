//! The batch algorithms for `f64` and `f32`, compiled once in this crate.
//!
//! A generic function is compiled in every program that calls it, and each of these takes seconds for each
//! instruction set. The methods below are not generic, so programs call the compiled code of this library.

use core::ops::ControlFlow;

use robot_dynamics_core::Model;
use robot_dynamics_simulation::Rollout;

use super::compute::{self, Tables};
use super::kinematics::{Jacobian, Poses};
use super::recursions::{Acceleration, Forces, InverseMass, Mass};
use super::related_mass::RelatedMass;
use super::rollout::{RolloutError, RolloutProgress, Torques};
use super::workspace::{BatchOptions, Pool};
use super::{BadStates, BatchWorkspace, derivatives, pullback, rollout};

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

/// The states of a rollout, start and end in place, and their trajectories.
pub struct Motion<'a, T> {
    pub q: &'a mut [T],
    pub v: &'a mut [T],
    pub trajectory: (&'a mut [T], &'a mut [T]),
}

/// A callback for progress, called occasionally from any thread.
pub(super) type Progress<'a> = &'a (dyn Fn(RolloutProgress) -> ControlFlow<()> + Sync);

/// The compiled algorithms of a number type. `f64` and `f32` implement it; no other type can.
pub trait CompiledOnce: Sized {
    fn workspace(model: &Model, pool: Pool, options: BatchOptions) -> BatchWorkspace<Self>
    where
        Self: super::BatchFloat;

    fn compute(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        quantity: Quantity<'_>,
        tables: &Tables<'_, Self>,
        result: &str,
        output: &mut [Self],
    ) -> Result<(), BadStates>
    where
        Self: super::BatchFloat;

    fn derivatives(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        is_forward: bool,
        tables: &Tables<'_, Self>,
        results: [&mut [Self]; 3],
    ) -> Result<(), BadStates>
    where
        Self: super::BatchFloat;

    fn rollout(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        rollout: &Rollout,
        torques: Torques<'_, Self>,
        motion: Motion<'_, Self>,
        progress: Progress<'_>,
    ) -> Result<(), RolloutError>
    where
        Self: super::BatchFloat;

    fn pullback(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        is_forward: bool,
        tables: &Tables<'_, Self, 4>,
        results: [&mut [Self]; 5],
    ) -> Result<(), BadStates>
    where
        Self: super::BatchFloat;

    fn rollout_pullback(
        model: &Model,
        workspace: &mut BatchWorkspace<Self>,
        rollout: &Rollout,
        given: &rollout::pullback::PullbackInputs<'_, Self>,
        results: [&mut [Self]; 4],
        progress: Progress<'_>,
    ) -> Result<(), RolloutError>
    where
        Self: super::BatchFloat;
}

macro_rules! compiled_once {
    ($float:ty) => {
        impl CompiledOnce for $float {
            fn workspace(model: &Model, pool: Pool, options: BatchOptions) -> BatchWorkspace<Self> {
                BatchWorkspace::on(model, pool, options)
            }

            #[track_caller]
            fn compute(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                quantity: Quantity<'_>,
                tables: &Tables<'_, Self>,
                result: &str,
                output: &mut [Self],
            ) -> Result<(), BadStates> {
                match quantity {
                    Quantity::Forces(forces) => {
                        compute::compute(model, workspace, forces, tables, result, output)
                    }
                    Quantity::Acceleration => {
                        compute::compute(model, workspace, Acceleration, tables, result, output)
                    }
                    Quantity::Mass => compute::compute(model, workspace, Mass, tables, result, output),
                    Quantity::RelatedMass => {
                        compute::compute(model, workspace, RelatedMass, tables, result, output)
                    }
                    Quantity::InverseMass => {
                        compute::compute(model, workspace, InverseMass, tables, result, output)
                    }
                    Quantity::Poses(poses) => {
                        compute::compute(model, workspace, poses, tables, result, output)
                    }
                    Quantity::Jacobian(jacobian) => {
                        compute::compute(model, workspace, jacobian, tables, result, output)
                    }
                }
            }

            #[track_caller]
            fn derivatives(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                is_forward: bool,
                tables: &Tables<'_, Self>,
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
                motion: Motion<'_, Self>,
                progress: Progress<'_>,
            ) -> Result<(), RolloutError> {
                rollout::move_states(model, workspace, rollout, torques, motion, progress)
            }

            #[track_caller]
            fn pullback(
                model: &Model,
                workspace: &mut BatchWorkspace<Self>,
                is_forward: bool,
                tables: &Tables<'_, Self, 4>,
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
                given: &rollout::pullback::PullbackInputs<'_, Self>,
                results: [&mut [Self]; 4],
                progress: Progress<'_>,
            ) -> Result<(), RolloutError> {
                rollout::pullback::compute(model, workspace, rollout, given, results, progress)
            }
        }
    };
}
compiled_once!(f64);
compiled_once!(f32);
