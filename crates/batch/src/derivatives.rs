//! Derivatives of dynamics on batches: ∂τ/∂(q, v) and ∂a/∂(q, v, τ), one matrix each for every state.
//!
//! Equations, sources and costs for a state are those of `robot_dynamics_core`'s derivatives, O(n depth) and
//! O(nv² depth). The matrices of large robots exceed the cache, so the time is that of writing them;
//! pullbacks avoid this.

use robot_dynamics_core::{ForwardDynamicsDerivativesMut, InverseDynamicsDerivativesMut, Model};

use crate::tables::InputTables;
use crate::{BadStates, BatchFloat, BatchWorkspace};

/// ∂τ/∂q and ∂τ/∂v of each state; see [`inverse_dynamics_derivatives`](robot_dynamics_core::inverse_dynamics_derivatives).
///
/// q is \[batch\]\[nq\]; v and a are \[batch\]\[nv\]; the derivatives are \[batch\]\[nv\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // τ = m l² a − m g l cos q, so ∂τ/∂q = m g l sin q.
/// let (q, v, a, mut by_q, mut by_v) = ([0.0, 0.3], [1.0; 2], [2.0; 2], [0.0; 2], [1.0; 2]);
/// let workspace = &mut BatchWorkspace::<f64>::new(&model);
/// let outputs = batch::InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
/// batch::inverse_dynamics_derivatives(&model, workspace, &q, &v, &a, outputs)?;
/// assert!((0..2).all(|state| (by_q[state] - 2.0 * 9.81 * 0.5 * q[state].sin()).abs() < 1e-14));
/// assert!(by_v.iter().all(|by_v| by_v.abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "computeRNEADerivatives")]
#[track_caller]
pub fn inverse_dynamics_derivatives<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    a: &[T],
    derivatives: InverseDynamicsDerivativesMut<'_, T>,
) -> Result<(), BadStates> {
    let InverseDynamicsDerivativesMut { by_position, by_velocity } = derivatives;
    let tables =
        InputTables { names: ["q", "v", "a"], widths: [model.nq, model.nv, model.nv], rows: [q, v, a] };
    T::derivatives(model, workspace, false, &tables, [by_position, by_velocity, &mut []])
}

/// ∂a/∂q, ∂a/∂v and ∂a/∂τ = M⁻¹ of each state; see
/// [`forward_dynamics_derivatives`](robot_dynamics_core::forward_dynamics_derivatives).
///
/// q is \[batch\]\[nq\]; v and tau are \[batch\]\[nv\]; the derivatives are \[batch\]\[nv\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // a = (τ + m g l cos q)/(m l²): the derivatives are −(g/l) sin q, 0 and 1/(m l²).
/// let (q, v, tau) = ([0.0, 0.3], [1.0; 2], [0.7; 2]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0; 2], [0.0; 2], [0.0; 2]);
/// let workspace = &mut BatchWorkspace::<f64>::new(&model);
/// let outputs = batch::ForwardDynamicsDerivativesMut {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
/// };
/// batch::forward_dynamics_derivatives(&model, workspace, &q, &v, &tau, outputs)?;
/// assert!((0..2).all(|state| (by_q[state] + 9.81 / 0.5 * q[state].sin()).abs() < 1e-13));
/// assert!(by_tau.iter().all(|by_tau| (by_tau - 1.0 / (2.0 * 0.25)).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result, including those with a singular M; all other
/// results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "computeABADerivatives")]
#[track_caller]
pub fn forward_dynamics_derivatives<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    tau: &[T],
    derivatives: ForwardDynamicsDerivativesMut<'_, T>,
) -> Result<(), BadStates> {
    let ForwardDynamicsDerivativesMut { by_position, by_velocity, by_force } = derivatives;
    let tables =
        InputTables { names: ["q", "v", "tau"], widths: [model.nq, model.nv, model.nv], rows: [q, v, tau] };
    T::derivatives(model, workspace, true, &tables, [by_position, by_velocity, by_force])
}
