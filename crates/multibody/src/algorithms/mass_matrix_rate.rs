//! Ṁ, by differentiating the composite-rigid-body algorithm.

use dynamics::{Dual, Scalar};

use crate::Model;
use crate::algorithms::mass_matrix::{CompositeBodies, Entries};
use crate::model::length::check_length;
use crate::scratch::compiled_once::run;
use crate::scratch::workspace::{Dense, Workspace};
use crate::space::configuration_rate::configuration_rate;

/// Ṁ(q,v) = d/dt M(q(t)) with q̇ from v: the exact derivative of [`mass_matrix`](crate::mass_matrix) over dual numbers, nv×nv,
/// row-major.
///
/// It shares no step with [`coriolis_matrix`](crate::coriolis_matrix), whose C + Cᵀ it must equal.
///
/// ```
/// use multibody::{Workspace, mass_matrix_rate};
/// use nalgebra::DMatrix;
/// # use multibody::*;
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut dynamics::SplitMix64::new(1));
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
    workspace.robot.check(model, "the workspace");
    check_length("q", q.len(), model.nq);
    check_length("v", v.len(), model.nv);
    check_length("the rate of the mass matrix", rate.len(), model.nv * model.nv);
    workspace.make_room_for_matrices(model);
    let Workspace { tree, dense: Dense { matrix, vector, coordinates, .. }, .. } = workspace;
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
