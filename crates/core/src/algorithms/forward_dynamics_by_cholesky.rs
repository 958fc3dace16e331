//! Forward dynamics by M and its factor: for robots with coupled branches, and as an independent route in
//! tests.
//!
//! Cost: O(n depth²) for a tree, O(n³) with coupled branches.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use crate::Model;
use crate::algorithms::inverse_dynamics::NewtonEuler;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::factorization::sparse;
use crate::kinematics::wrench::FrameWrench;
use crate::workspace::buffers::{DenseBuffers, Workspace};
use crate::workspace::compiled_once::run;

/// The acceleration of [`forward_dynamics`](crate::forward_dynamics) by an independent route. M comes from
/// the composite-rigid-body algorithm, C v + g from the Newton–Euler recursion. M = LᵀDL keeps the tree's
/// zeros.
///
/// ```
/// use robot_dynamics::algorithms::{forward_dynamics, forward_dynamics_by_cholesky};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let w = &mut Workspace::new(&model);
/// let (mut a, mut by_cholesky) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
/// forward_dynamics(&model, w, &q, &v, &tau, &mut a);
/// forward_dynamics_by_cholesky(&model, w, &q, &v, &tau, &mut by_cholesky);
/// // The two routes differ by κ(M) times rounding.
/// assert!(a.iter().zip(&by_cholesky).all(|(a, other)| (a - other).abs() < 1e-9 * (1.0 + a.abs())));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn forward_dynamics_by_cholesky<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    acceleration: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("tau", tau.len(), model.nv);
    check_length("the acceleration", acceleration.len(), model.nv);
    accelerate_by_cholesky(model, workspace, q, v, tau, &[], acceleration);
}

/// The same under wrenches: x = τ − (inverse dynamics at a = 0), then M a = x. Leaves the factor of M in the
/// workspace.
pub(crate) fn accelerate_by_cholesky<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    tau: &[S],
    wrenches: &[FrameWrench<S>],
    acceleration: &mut [S],
) {
    workspace.allocate_matrices(model);
    let Workspace { tree, dense: DenseBuffers { matrix, vector: bias, dof_parent, .. }, .. } = workspace;
    run(tree, NewtonEuler { wrenches, ..NewtonEuler::bias(model, q, v, bias) });
    run(tree, CompositeBodies { model, q, mass: matrix, entries: Entries::Related });
    for ((a, &tau), &bias) in acceleration.iter_mut().zip(tau).zip(&*bias) {
        *a = tau - bias;
    }
    sparse::factor(dof_parent, matrix);
    sparse::solve(dof_parent, matrix, acceleration);
}
