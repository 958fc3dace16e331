//! Derivatives of constrained forward dynamics on batches, and pullbacks.
//!
//! The numbers of each state are those of `robot_dynamics_simulation`, bit for bit. Each thread computes one
//! state at a time, and allocates in each call.

use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_simulation::{ConstrainedPullbackInputs, ConstraintOptions, ConstraintSet};

use crate::bad_states::BadStateSet;
use crate::distribution::for_each_state;
use crate::tables::check_table;
use crate::{BadStates, BatchWorkspace};

/// The inputs of [`constrained_forward_dynamics_derivatives`] and of its pullback.
#[derive(Clone, Copy, Debug)]
pub struct ConstrainedInputs<'a> {
    /// The constraints.
    pub set: &'a ConstraintSet,
    /// The treatment of dependent rows and the feedback.
    pub options: &'a ConstraintOptions,
    /// Configurations, \[batch\]\[nq\].
    pub q: &'a [f64],
    /// Velocities, \[batch\]\[nv\].
    pub v: &'a [f64],
    /// Generalized forces, \[batch\]\[nv\].
    pub tau: &'a [f64],
}

/// The outputs of [`constrained_forward_dynamics_derivatives`].
#[derive(Debug)]
pub struct ConstrainedDerivativesMut<'a> {
    /// a, \[batch\]\[nv\].
    pub acceleration: &'a mut [f64],
    /// λ, \[batch\]\[K\].
    pub multipliers: &'a mut [f64],
    /// ∂a/∂q, \[batch\]\[nv\]\[nv\].
    pub acceleration_by_position: &'a mut [f64],
    /// ∂a/∂v, \[batch\]\[nv\]\[nv\].
    pub acceleration_by_velocity: &'a mut [f64],
    /// ∂a/∂τ, \[batch\]\[nv\]\[nv\].
    pub acceleration_by_force: &'a mut [f64],
    /// ∂λ/∂q, \[batch\]\[K\]\[nv\].
    pub multipliers_by_position: &'a mut [f64],
    /// ∂λ/∂v, \[batch\]\[K\]\[nv\].
    pub multipliers_by_velocity: &'a mut [f64],
    /// ∂λ/∂τ, \[batch\]\[K\]\[nv\].
    pub multipliers_by_force: &'a mut [f64],
}

/// a and λ of constrained forward dynamics of each state, and their derivatives; see
/// [`constrained_forward_dynamics_derivatives`](robot_dynamics_simulation::constrained_forward_dynamics_derivatives).
///
/// ```
/// use robot_dynamics::batch::{
///     BatchWorkspace, ConstrainedDerivativesMut, ConstrainedInputs, constrained_forward_dynamics_derivatives,
/// };
/// use robot_dynamics::constraints::{ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::Model;
/// // The tip of a rod is held at its height: λ l cos q = τ + m g l cos q.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let hold = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = &ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let (q, options) = ([0.0_f64, 0.3], &ConstraintOptions::default());
/// let inputs = ConstrainedInputs { set, options, q: &q, v: &[0.0; 2], tau: &[1.0; 2] };
/// let mut results = [[0.0; 2]; 8];
/// let [a, lambda, a_by_q, a_by_v, a_by_tau, by_q, by_v, by_tau] = &mut results;
/// let outputs = ConstrainedDerivativesMut {
///     acceleration: a,
///     multipliers: lambda,
///     acceleration_by_position: a_by_q,
///     acceleration_by_velocity: a_by_v,
///     acceleration_by_force: a_by_tau,
///     multipliers_by_position: by_q,
///     multipliers_by_velocity: by_v,
///     multipliers_by_force: by_tau,
/// };
/// constrained_forward_dynamics_derivatives(&model, &BatchWorkspace::new(&model), inputs, outputs)?;
/// assert!((0..2).all(|i| (by_tau[i] - 2.0 / q[i].cos()).abs() < 1e-13));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result: a number that is not finite, a singular M, rows
/// that contradict each other, or dependent rows that are refused. Their results are NaN; all others are
/// valid.
///
/// # Panics
/// If a table has the wrong length, or the workspace or the set belongs to another model.
#[track_caller]
pub fn constrained_forward_dynamics_derivatives(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    inputs: ConstrainedInputs<'_>,
    results: ConstrainedDerivativesMut<'_>,
) -> Result<(), BadStates> {
    let ConstrainedInputs { set, options, q, v, tau } = inputs;
    let (nv, count, batch) = (model.nv(), set.len(), check_inputs(model, workspace, &inputs));
    let results = [
        results.acceleration,
        results.multipliers,
        results.acceleration_by_position,
        results.acceleration_by_velocity,
        results.acceleration_by_force,
        results.multipliers_by_position,
        results.multipliers_by_velocity,
        results.multipliers_by_force,
    ];
    let widths = [nv, count, nv * nv, nv * nv, nv * nv, count * nv, count * nv, count * nv];
    let names = ["a", "λ", "∂a/∂q", "∂a/∂v", "∂a/∂τ", "∂λ/∂q", "∂λ/∂v", "∂λ/∂τ"];
    for ((table, width), name) in results.iter().zip(widths).zip(names) {
        check_table(name, table.len(), batch, width);
    }
    let bad = BadStateSet::default();
    for_each_state(workspace, batch, results, &|| Workspace::new(model), &|memory, state, results| {
        let [q, v, tau] = rows(state, [(q, model.nq()), (v, nv), (tau, nv)]);
        let found = robot_dynamics_simulation::constrained_forward_dynamics_derivatives(
            model, memory, set, options, q, v, tau,
        );
        let Ok(by) = found else {
            for row in results {
                row.fill(f64::NAN);
            }
            bad.add(1, state);
            return;
        };
        let [a, lambda, matrices @ ..] = results;
        a.copy_from_slice(by.motion.acceleration.as_slice());
        lambda.copy_from_slice(by.motion.multipliers.as_slice());
        let found = [
            &by.acceleration_by_position,
            &by.acceleration_by_velocity,
            &by.acceleration_by_force,
            &by.multipliers_by_position,
            &by.multipliers_by_velocity,
            &by.multipliers_by_force,
        ];
        for (to, from) in matrices.into_iter().zip(found) {
            write_rows(from.as_slice(), from.nrows(), to);
        }
    });
    bad.into_result(batch)
}

/// The outputs of [`constrained_forward_dynamics_pullback`].
#[derive(Debug)]
pub struct ConstrainedPullbackMut<'a> {
    /// a, \[batch\]\[nv\].
    pub acceleration: &'a mut [f64],
    /// λ, \[batch\]\[K\].
    pub multipliers: &'a mut [f64],
    /// The gradients by q, \[batch\]\[nv\].
    pub by_position: &'a mut [f64],
    /// The gradients by v, \[batch\]\[nv\].
    pub by_velocity: &'a mut [f64],
    /// The gradients by τ, \[batch\]\[nv\].
    pub by_force: &'a mut [f64],
}

/// a and λ of constrained forward dynamics of each state, and the gradient of āᵀa + λ̄ᵀλ with each state's own
/// cotangents; see
/// [`constrained_forward_dynamics_pullback`](robot_dynamics_simulation::constrained_forward_dynamics_pullback).
///
/// The cotangents are \[batch\]\[nv\] of a and \[batch\]\[K\] of λ.
///
/// ```
/// use robot_dynamics::batch::{
///     BatchWorkspace, ConstrainedInputs, ConstrainedPullbackMut, constrained_forward_dynamics_pullback,
/// };
/// use robot_dynamics::constraints::{ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::Model;
/// // The tip of a rod is held at its height: λ l cos q = τ + m g l cos q.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let hold = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = &ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let (q, options, w) = ([0.0_f64, 0.3], &ConstraintOptions::default(), &BatchWorkspace::new(&model));
/// let inputs = ConstrainedInputs { set, options, q: &q, v: &[0.0; 2], tau: &[1.0; 2] };
/// let [mut a, mut lambda, mut by_q, mut by_v, mut by_tau] = [[0.0; 2]; 5];
/// let outputs = ConstrainedPullbackMut {
///     acceleration: &mut a,
///     multipliers: &mut lambda,
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
/// };
/// constrained_forward_dynamics_pullback(&model, w, inputs, [&[0.0; 2], &[3.0; 2]], outputs)?;
/// assert!((0..2).all(|i| (by_tau[i] - 3.0 * 2.0 / q[i].cos()).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`constrained_forward_dynamics_derivatives`].
///
/// # Panics
/// If a table has the wrong length, or the workspace or the set belongs to another model.
#[doc(alias = "VJP")]
#[track_caller]
pub fn constrained_forward_dynamics_pullback(
    model: &Model,
    workspace: &BatchWorkspace<f64>,
    inputs: ConstrainedInputs<'_>,
    [acceleration, multipliers]: [&[f64]; 2],
    results: ConstrainedPullbackMut<'_>,
) -> Result<(), BadStates> {
    let ConstrainedInputs { set, options, q, v, tau } = inputs;
    let (nv, count, batch) = (model.nv(), set.len(), check_inputs(model, workspace, &inputs));
    check_table("the cotangents of a", acceleration.len(), batch, nv);
    check_table("the cotangents of λ", multipliers.len(), batch, count);
    let results = [
        results.acceleration,
        results.multipliers,
        results.by_position,
        results.by_velocity,
        results.by_force,
    ];
    let widths = [nv, count, nv, nv, nv];
    let names = ["a", "λ", "the gradient by q", "the gradient by v", "the gradient by τ"];
    for ((table, width), name) in results.iter().zip(widths).zip(names) {
        check_table(name, table.len(), batch, width);
    }
    let bad = BadStateSet::default();
    for_each_state(workspace, batch, results, &|| Workspace::new(model), &|memory, state, results| {
        let [q, v, tau] = rows(state, [(q, model.nq()), (v, nv), (tau, nv)]);
        let [acceleration, multipliers] = rows(state, [(acceleration, nv), (multipliers, count)]);
        let inputs = ConstrainedPullbackInputs { q, v, tau, acceleration, multipliers };
        let found = robot_dynamics_simulation::constrained_forward_dynamics_pullback(
            model, memory, set, options, inputs,
        );
        let Ok(by) = found else {
            for row in results {
                row.fill(f64::NAN);
            }
            bad.add(1, state);
            return;
        };
        let motion = &by.motion;
        let found =
            [&motion.acceleration, &motion.multipliers, &by.by_position, &by.by_velocity, &by.by_force];
        results.into_iter().zip(found).for_each(|(to, from)| to.copy_from_slice(from.as_slice()));
    });
    bad.into_result(batch)
}

/// Checks the tables of inputs and returns the number of states.
#[track_caller]
fn check_inputs(model: &Model, workspace: &BatchWorkspace<f64>, inputs: &ConstrainedInputs<'_>) -> usize {
    workspace.check(model);
    let (nq, nv) = (model.nq(), model.nv());
    let found = inputs.q.len();
    assert!(found.is_multiple_of(nq.max(1)), "q has {found} numbers, not a multiple of nq = {nq}");
    let batch = found / nq.max(1);
    check_table("v", inputs.v.len(), batch, nv);
    check_table("tau", inputs.tau.len(), batch, nv);
    batch
}

/// The rows of a state in tables of these widths.
fn rows<const N: usize>(state: usize, tables: [(&[f64], usize); N]) -> [&[f64]; N] {
    tables.map(|(table, width)| &table[state * width..(state + 1) * width])
}

/// Writes a matrix, which is given by columns of `count` numbers, row by row.
fn write_rows(columns: &[f64], count: usize, to: &mut [f64]) {
    let width = columns.len() / count.max(1);
    for (i, x) in to.iter_mut().enumerate() {
        *x = columns[i / width + count * (i % width)];
    }
}
