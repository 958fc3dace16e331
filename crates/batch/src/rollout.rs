//! Rollouts of batches: (q, v) ← step(q, v, τ, h), repeated for each state of a table.
//!
//! The rows of the table of integrators run over the lanes of registers and over threads.
//! `rollout_by_stepper` takes any other stepper, state by state. Cost: steps × that of a step, without
//! allocation except for policies.
//!
//! A state that becomes invalid is listed and gets NaN; all others are valid. The bits do not depend on the
//! number of threads.

mod bad_rows;
mod error;
mod job;
#[cfg(feature = "native")]
mod machine_code;
mod outcome;
mod progress;
pub(crate) mod pullback;
pub(crate) mod states;
mod step;
mod stepper;
mod stepper_pullback;
mod torques;

pub use error::RolloutError;
pub use progress::{RolloutObserver, RolloutProgress, UNOBSERVED};
pub use pullback::RolloutPullbackInputs;
pub use robot_dynamics_simulation::{Rollout, StepperRollout};
pub use states::RolloutStates;
pub use stepper::rollout_by_stepper;
pub use stepper_pullback::rollout_pullback_by_stepper;
pub use torques::{PolicyInput, Torques};

use robot_dynamics_core::Model;
use robot_dynamics_simulation::MotionCotangents;

use crate::{BatchFloat, BatchWorkspace};

/// Advances each state (q, v) in place over `rollout.steps` steps.
///
/// Quaternions keep unit length, because the stages are those of Munthe-Kaas, as in
/// [`step`](robot_dynamics_simulation::step).
///
/// `progress`, if it is given, is called occasionally from any thread. If it breaks, the states that are not
/// at the end remain unchanged, and their trajectories are unspecified. With a [policy](Torques::Policy) each
/// call allocates the rows of each block.
///
/// # Errors
/// [`RolloutError`]; all states that it does not list are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, Rollout, RolloutStates, Torques, rollout};
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, neutral};
/// use robot_dynamics::simulation::Integrator;
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let (mut q, mut v) = (neutral(&model).repeat(20), vec![0.0; 20 * model.nv()]);
/// let how = Rollout::new(Integrator::SemiImplicitEuler, 1e-3, 100);
/// let mut workspace = BatchWorkspace::new(&model);
/// rollout(&model, &mut workspace, &how, Torques::Zero, RolloutStates::ends(&mut q, &mut v), None)?;
/// assert!(v.iter().any(|v| v.abs() > 0.1)); // the robot falls
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[track_caller]
pub fn rollout<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    torques: Torques<'_, T>,
    states: RolloutStates<'_, T>,
    progress: Option<RolloutObserver<'_>>,
) -> Result<(), RolloutError> {
    T::rollout(model, workspace, rollout, torques, states, progress.unwrap_or(UNOBSERVED))
}

/// The gradient of a loss along each state's rollout; see
/// [`rollout_pullback`](robot_dynamics_simulation::rollout_pullback). It maps cotangents of the rollout's
/// states to those of the initial state, the forces and the parameters.
///
/// - `by_position` and `by_velocity`, \[batch\]\[nv\], hold the gradients by the final states, and receive
///   those by the initial states.
/// - `by_force` is overwritten. It has the shape of the torques: \[batch\]\[nv\] if they are held,
///   \[batch\]\[steps\]\[nv\] if each step has its own, and empty without torques.
/// - `parameters` is empty or \[batch\]\[[`parameter_count`](robot_dynamics_core::parameter_count)\], one row per state, and overwritten.
///
/// Cotangents of configurations have nv numbers, along the displacements of [`integrate`](robot_dynamics_core::integrate())
/// at that configuration.
///
/// The states are recomputed from a checkpoint at every `spacing`-th step; 0 selects √steps, and `spacing` =
/// steps stores all states. See
/// [`RolloutPullbackWorkspace::new`](robot_dynamics_simulation::RolloutPullbackWorkspace::new), which gives
/// the memory per state. A thread holds one block of lanes, or 32 states with machine code. The states are
/// those of [`rollout`](crate::rollout), bit for bit if machine code takes the steps of both or of neither.
/// With cotangents of parameters the recursions take the steps here, and the states may differ by rounding.
///
/// `progress`, if it is given, is called occasionally from any thread. If it breaks, the states that are not
/// complete keep their `by_position` and `by_velocity`, and their other results are unspecified.
///
/// ```
/// use robot_dynamics::batch::{BatchWorkspace, Rollout, RolloutPullbackInputs, Torques, rollout_pullback};
/// use robot_dynamics::derivatives::{MotionCotangents, TrajectoryCotangents};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Integrator;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let integrator = Integrator::SemiImplicitEuler;
/// let how = Rollout::new(integrator, 0.01, 50).with_dissipation(false);
/// // The final speed of three swings, by the torque held over each.
/// let (q, v, tau) = ([0.0, 0.5, 1.0], [0.0; 3], [0.1; 3]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0; 3], [1.0; 3], [0.0; 3]);
/// let (w, torques) = (&mut BatchWorkspace::<f64>::new(&model), Torques::Held(&tau));
/// let trajectory = TrajectoryCotangents::default();
/// let inputs = RolloutPullbackInputs { spacing: 0, torques, q: &q, v: &v, trajectory };
/// let cotangents = MotionCotangents {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
///     parameters: &mut [],
/// };
/// rollout_pullback(&model, w, &how, &inputs, cotangents, None)?;
/// assert!(by_tau.iter().all(|x| *x > 0.0 && *x < 50.0 * 0.01 / 0.5)); // h/(m l²) per step at most, reduced by gravity
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`RolloutError`]; all states that it does not list are valid. [`RolloutError::Policy`] if a policy gives
/// the torques, because its derivatives by the state are unknown.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn rollout_pullback<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    rollout: &Rollout,
    inputs: &RolloutPullbackInputs<'_, T>,
    cotangents: MotionCotangents<'_, T>,
    progress: Option<RolloutObserver<'_>>,
) -> Result<(), RolloutError> {
    let MotionCotangents { by_position, by_velocity, by_force, parameters } = cotangents;
    let results = [by_position, by_velocity, by_force, parameters];
    T::rollout_pullback(model, workspace, rollout, inputs, results, progress.unwrap_or(UNOBSERVED))
}
