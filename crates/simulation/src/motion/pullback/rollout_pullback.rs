//! The pullback of a rollout of one state.

use robot_dynamics_core::derivatives::check_parameters;
use robot_dynamics_core::{Model, NativeFunction, Workspace, parameter_count};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::StepScheme;
use robot_dynamics_number::Scalar;

use super::checkpoints::{memory_size, pull_back};
use super::checks::{check_floats, check_mass, check_rollout_floats, check_rollout_lengths};
use super::cotangents::{MotionCotangents, TrajectoryCotangents};
use super::rollout::Rollout;
use super::stages::add;
use super::step::OneState;
use super::tables::RolloutTables;
use crate::motion::RobotState;
use crate::motion::integrate::check_step;
use crate::motion::integrate::stage_memory::most_stages;
use crate::motion::simulate::StepError;

/// Scratch for [`rollout_pullback`] of one kind of rollout on one model.
#[derive(Clone, Debug)]
pub struct RolloutPullbackWorkspace<S: Scalar = f64> {
    dynamics: Workspace<S>,
    steps: usize,
    spacing: usize,
    memory: Vec<S>,
    by_position: Vec<S>,
    by_velocity: Vec<S>,
    cotangent: Vec<S>,
    parameters: Vec<S>,
}

impl<S: Scalar> RolloutPullbackWorkspace<S> {
    /// Allocates memory for this model and number of steps, with a checkpoint at every `spacing`-th step. It
    /// holds ⌈steps/spacing⌉ states, and `spacing` more with the accelerations of their stages. 0 selects
    /// √steps, which is near the minimum of memory; each step is then computed twice before its pullback.
    /// With `spacing` = steps all states are stored, and each step is computed once.
    ///
    /// ```
    /// use robot_dynamics::derivatives::{Rollout, RolloutPullbackWorkspace};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// # let integrator = robot_dynamics::simulation::Integrator::RungeKutta4;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let rollout = Rollout::new(integrator, 1e-3, 1_000_000).with_dissipation(false);
    /// assert_eq!(RolloutPullbackWorkspace::<f64>::new(&model, &rollout, 0).spacing(), 1000);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(model: &Model, rollout: &Rollout, spacing: usize) -> Self {
        let spacing = rollout.spacing(spacing);
        Self {
            dynamics: Workspace::new(model),
            steps: rollout.steps,
            spacing,
            memory: vec![S::zero(); memory_size(model, rollout, most_stages(), spacing)],
            by_position: vec![S::zero(); model.nv],
            by_velocity: vec![S::zero(); model.nv],
            cotangent: vec![S::zero(); 2 * model.nv],
            parameters: vec![S::zero(); parameter_count(model)],
        }
    }

    /// The number of steps between checkpoints.
    pub fn spacing(&self) -> usize {
        self.spacing
    }
}

/// The gradient of a loss along a rollout: maps cotangents of the rollout's states to those of the initial
/// state, the forces and the parameters. It forms no Jacobian, recomputes the required states from the
/// workspace's checkpoints, and does not allocate.
///
/// - `start` is the initial state.
/// - `tau` has nv numbers that are held over all steps, or \[steps\]\[nv\], or is empty.
/// - `trajectory` holds the gradients by the states after every `stride`-th step. The final state counts
///   twice if it is one of them.
/// - `cotangents` holds the gradients by the final state, and receives those by the initial state and by the
///   forces. The gradient by the parameters is **added**.
///
/// Cotangents of configurations have nv numbers, along the displacements of [`integrate`](robot_dynamics_core::integrate())
/// at that configuration: see
/// [`cotangent_from_coordinates`](robot_dynamics_core::cotangent_from_coordinates). On an error
/// `by_position`, `by_velocity` and `parameters` are unchanged.
///
/// ```
/// use robot_dynamics::derivatives::{MotionCotangents, RobotState, Rollout, RolloutPullbackWorkspace};
/// use robot_dynamics::derivatives::{TrajectoryCotangents, rollout_pullback};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Integrator;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let integrator = Integrator::SemiImplicitEuler;
/// let rollout = Rollout::new(integrator, 0.01, 50).with_dissipation(false);
/// // The final speed by the torques. Near the lowest point, the rest position, each one adds about
/// // h/(m l²).
/// let w = &mut RolloutPullbackWorkspace::<f64>::new(&model, &rollout, 0);
/// let (tau, down) = (vec![0.0; 50], [std::f64::consts::FRAC_PI_2]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0], [1.0], vec![0.0; 50]);
/// let cotangents = MotionCotangents {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
///     parameters: &mut [],
/// };
/// let (start, trajectory) = (RobotState { q: &down, v: &[0.0] }, TrajectoryCotangents::default());
/// rollout_pullback(&model, &rollout, w, start, &tau, trajectory, cotangents)?;
/// assert!((by_tau[49] - 0.01 / (2.0 * 0.25)).abs() < 1e-14 && by_tau[0] < by_tau[49]); // the pendulum swings back from earlier torques
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// - [`StepError`] if a given or computed float is not finite, if the step is not positive,
///   or if M(q) is singular, with the names of the joints (checked in advance for `f64`).
/// - [`StepError::NotDifferentiable`] for the variational rows.
///
/// # Panics
/// Panics if a slice has the wrong length, or the workspace is for another number of steps.
#[track_caller]
pub fn rollout_pullback<S: Scalar>(
    model: &Model,
    rollout: &Rollout,
    workspace: &mut RolloutPullbackWorkspace<S>,
    RobotState { q, v }: RobotState<'_, S>,
    tau: &[S],
    trajectory: TrajectoryCotangents<'_, S>,
    cotangents: MotionCotangents<'_, S>,
) -> Result<(), StepError> {
    check_step(rollout.step)?;
    let (w, nv) = (workspace, model.nv);
    w.dynamics.check_inputs(model, q);
    check_length("the workspace's steps", w.steps, rollout.steps);
    check_length("v", v.len(), nv);
    check_rollout_lengths(nv, (rollout.steps, rollout.samples()), tau, &trajectory, &cotangents);
    check_parameters(model, cotangents.parameters);
    let StepScheme::Explicit(stages) = rollout.integrator.scheme() else {
        return Err(StepError::NotDifferentiable { integrator: rollout.integrator });
    };
    check_rollout_floats(RobotState { q, v }, tau, &trajectory, &cotangents)?;
    let MotionCotangents { by_position, by_velocity, by_force, parameters } = cotangents;
    check_mass(model, &mut w.dynamics, q)?;
    w.by_position.copy_from_slice(by_position);
    w.by_velocity.copy_from_slice(by_velocity);
    w.parameters.fill(S::zero());
    by_force.fill(S::zero());
    let mut tables = RolloutTables { tau, trajectory, by_force };
    let own_parameters = &mut w.parameters[..parameters.len()];
    let cotangents = (&mut w.by_position[..], &mut w.by_velocity[..]);
    let way = (rollout, stages, w.spacing);
    let pullback = NativeFunction::step_pullback(rollout.integrator, rollout.dissipation);
    let accelerations = &mut OneState { workspace: &mut w.dynamics, pullback, cotangent: &mut w.cotangent };
    let sides = (accelerations, &mut tables);
    pull_back(model, way, sides, &mut w.memory, (q, v), cotangents, own_parameters);
    for (quantity, numbers) in [
        ("the cotangent of q at the start", &w.by_position[..]),
        ("the cotangent of v at the start", &w.by_velocity),
        ("the cotangent of tau", by_force),
        ("the cotangent of a parameter", &w.parameters),
    ] {
        check_floats(quantity, numbers)?;
    }
    by_position.copy_from_slice(&w.by_position);
    by_velocity.copy_from_slice(&w.by_velocity);
    add(parameters, &w.parameters[..parameters.len()]);
    Ok(())
}
