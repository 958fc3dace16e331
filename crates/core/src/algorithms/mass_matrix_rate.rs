//! Ṁ(q, v) = Σₖ ∂M/∂qₖ q̇ₖ, by the composite-rigid-body algorithm over dual numbers. Cost: O(n depth).
//!
//! For robots with q̇ = v, Ṁ = C + Cᵀ. This module shares no step with the Coriolis matrix and checks it.

use robot_dynamics_description::check_length;
use robot_dynamics_number::{Dual, Scalar};

use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::configuration::configuration_rate::configuration_rate;
use crate::workspace::buffers::{DenseBuffers, Workspace};
use crate::workspace::compiled_once::run;

/// Ṁ(q,v) = d/dt M(q(t)) with q̇ from v, nv×nv, row-major: the exact derivative of
/// [`mass_matrix`](crate::mass_matrix) over dual numbers.
///
/// It shares no step with [`coriolis_matrix`](crate::coriolis_matrix), whose C + Cᵀ equals Ṁ.
///
/// ```
/// use nalgebra::DMatrix;
/// use robot_dynamics::algorithms::mass_matrix_rate;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let nv = model.nv();
/// let mut rate = vec![0.0; nv * nv];
/// let dual = &mut Workspace::new(&model); // over dual numbers
/// mass_matrix_rate(&model, dual, &q, &v, &mut rate);
/// let c = model.coriolis_matrix(&q, &v)?;
/// assert!((DMatrix::from_row_slice(nv, nv, &rate) - (&c + c.transpose())).amax() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn mass_matrix_rate<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<Dual<S, 1>>,
    q: &[S],
    v: &[S],
    rate: &mut [S],
) {
    model.check_identity(&workspace.robot, "the workspace");
    check_length("q", q.len(), model.nq);
    check_length("v", v.len(), model.nv);
    check_length("the rate of the mass matrix", rate.len(), model.nv * model.nv);
    workspace.allocate_matrices(model);
    let Workspace { tree, dense: DenseBuffers { matrix, vector, coordinates, .. }, .. } = workspace;
    let (position, position_rate) = coordinates.split_at_mut(model.nq);
    for (dual, &q) in position.iter_mut().zip(q) {
        *dual = Dual::constant(q);
    }
    for (dual, &v) in vector.iter_mut().zip(v) {
        *dual = Dual::constant(v);
    }
    configuration_rate(model, position, vector, position_rate);
    for (dual, rate) in position.iter_mut().zip(&*position_rate) {
        dual.gradient = [rate.value];
    }
    run(tree, CompositeBodies { model, q: position, mass: matrix, entries: Entries::All });
    for (rate, entry) in rate.iter_mut().zip(&*matrix) {
        *rate = entry.gradient[0];
    }
}
