//! Vector-Jacobian products on batches: λᵀ∂τ/∂q and the like, one λ for each state.
//!
//! The recursions are those of `robot_dynamics_core::inverse_dynamics_pullback`, in the lanes of registers.
//! Cost: two to three times the function, O(n) for each state. Tables of parameters have ten numbers a link,
//! and writing them may take longer than the recursion.

use robot_dynamics_core::{ForwardPullbackMut, InversePullbackMut, Model};

use crate::tables::InputTables;
use crate::{BadStates, BatchFloat, BatchWorkspace};

/// λᵀ∂τ/∂q, λᵀ∂τ/∂v and M λ of each state and its own λ; see
/// [`inverse_dynamics_pullback`](robot_dynamics_core::inverse_dynamics_pullback).
///
/// q is \[batch\]\[nq\]; v, a, the cotangent λ and the results are \[batch\]\[nv\]. `parameters` is empty or
/// \[batch\]\[[`parameter_count`](robot_dynamics_core::parameter_count)\], one row per state in the layout of
/// [`ParameterCotangents`](robot_dynamics_core::ParameterCotangents); the rows are overwritten.
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // τ = m l² a − m g l cos q, so λ ∂τ/∂q = λ m g l sin q.
/// let (q, v, a, lambda) = ([0.0, 0.3], [1.0; 2], [2.0; 2], [1.0, 3.0]);
/// let (mut by_q, mut by_v, mut by_a) = ([0.0; 2], [0.0; 2], [0.0; 2]);
/// let w = &mut BatchWorkspace::<f64>::new(&model);
/// let outputs = batch::InversePullbackMut {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_acceleration: &mut by_a,
///     parameters: &mut [],
/// };
/// batch::inverse_dynamics_pullback(&model, w, &q, &v, &a, &lambda, outputs)?;
/// assert!((0..2).all(|i| (by_q[i] - lambda[i] * 9.81 * q[i].sin()).abs() < 1e-13));
/// assert!((0..2).all(|i| (by_a[i] - lambda[i] * 0.5).abs() < 1e-14)); // m l²
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "VJP")]
#[track_caller]
pub fn inverse_dynamics_pullback<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    a: &[T],
    cotangent: &[T],
    results: InversePullbackMut<'_, T>,
) -> Result<(), BadStates> {
    let InversePullbackMut { by_position, by_velocity, by_acceleration, parameters } = results;
    let tables = tables(model, "a", [q, v, a, cotangent]);
    let results = [&mut [], by_position, by_velocity, by_acceleration, parameters];
    T::pullback(model, workspace, false, &tables, results)
}

/// a = M⁻¹(τ − C v − g) of each state and, for its own cotangent ā, āᵀ∂a/∂q, āᵀ∂a/∂v and M⁻¹ā; see
/// [`forward_dynamics_pullback`](robot_dynamics_core::forward_dynamics_pullback).
///
/// q is \[batch\]\[nq\]; v, tau, the cotangent and the results are \[batch\]\[nv\]. `parameters` is empty or
/// \[batch\]\[[`parameter_count`](robot_dynamics_core::parameter_count)\], one row per state in the layout of
/// [`ParameterCotangents`](robot_dynamics_core::ParameterCotangents); the rows are overwritten.
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // a = (τ + m g l cos q)/(m l²)
/// let (q, v, tau, cotangent) = ([0.0, 0.3], [1.0; 2], [0.7; 2], [1.0, 3.0]);
/// let [mut a, mut by_q, mut by_v, mut by_tau] = [[0.0; 2]; 4];
/// let w = &mut BatchWorkspace::<f64>::new(&model);
/// let outputs = batch::ForwardPullbackMut {
///     acceleration: &mut a,
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
///     parameters: &mut [],
/// };
/// batch::forward_dynamics_pullback(&model, w, &q, &v, &tau, &cotangent, outputs)?;
/// assert!((0..2).all(|i| (by_q[i] + cotangent[i] * 9.81 / 0.5 * q[i].sin()).abs() < 1e-12));
/// assert!((0..2).all(|i| (by_tau[i] - cotangent[i] / 0.5).abs() < 1e-13)); // 1/(m l²)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result, including those with a singular M; all other
/// results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "VJP")]
#[track_caller]
pub fn forward_dynamics_pullback<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    tau: &[T],
    cotangent: &[T],
    results: ForwardPullbackMut<'_, T>,
) -> Result<(), BadStates> {
    let ForwardPullbackMut { acceleration, by_position, by_velocity, by_force, parameters } = results;
    let tables = tables(model, "tau", [q, v, tau, cotangent]);
    let results = [acceleration, by_position, by_velocity, by_force, parameters];
    T::pullback(model, workspace, true, &tables, results)
}

/// The states and their cotangents: q, v, a or τ, λ.
fn tables<'a, T>(model: &Model, third: &'static str, rows: [&'a [T]; 4]) -> InputTables<'a, T, 4> {
    let (nq, nv) = (model.nq, model.nv);
    InputTables { names: ["q", "v", third, "the cotangent"], widths: [nq, nv, nv, nv], rows }
}
