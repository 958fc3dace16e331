//! The Coriolis matrix in one pass from the leaves to the root, O(n depth).
//!
//! Divide each body into points p of mass dm with Jacobians J. Then M = ∫ JᵀJ dm, and C = ∫ JᵀJ̇ dm is the
//! matrix of the Christoffel symbols. In an inertial frame, J is (1 −\[p\]×) times the motions S of the DoFs.
//! A rigid set of points therefore enters with its inertia I and with
//!
//! B = ∫ (1 −\[p\]×)ᵀ(0 −\[ṗ\]×) dm = \[0 −\[f\]×; 0 tr(D) 1 − D\],  f = ∫ ṗ dm,  D = ∫ ṗ pᵀ dm.
//!
//! Let j be an ancestor of i, and I and B those of the subtree of i. Then C_ji = S_jᵀ(I Ṡ_i + B S_i) and
//! C_ij = S_iᵀ(I Ṡ_j + B S_j).
//!
//! B is the matrix ½((V×\*)I − I(V×) + (IV)×̄\*) with its zeros. Source: Echeandia, Wensing, *Numerical
//! methods to compute the Coriolis matrix and Christoffel symbols for rigid-body systems*, J. Comput.
//! Nonlinear Dyn. 16 (2021).

mod blocks;
mod branch;
mod paths;

pub(crate) use branch::Branch;

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::M3;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::kinematics::world_frame::{compute_column_rates, compute_columns, compute_twists};
use crate::model::native::NativeFunction;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

/// C(q,v), nv×nv, row-major: C v is the velocity product, Ṁ = C + Cᵀ, so Ṁ − 2C is skew-symmetric.
///
/// C is linear in v. If q̇ = v for every joint, C_ij = Σₖ Γⁱⱼₖ vₖ with the Christoffel symbols of M. **(PRM
/// 10.9)** The velocities of a quaternion joint are not rates of its coordinates; its C is the same integral
/// ∫ JᵀJ̇ dm.
///
/// ```
/// use robot_dynamics::algorithms::{coriolis_matrix, velocity_product};
/// use robot_dynamics::description::{Base, JointDescription, JointKind, LinkDescription, Pose};
/// use robot_dynamics::description::RobotDescription;
/// use robot_dynamics::model::{Model, Workspace};
/// # let mass = robot_dynamics::description::MassProperties::new(2.0, [0.1, 0.2, 0.3].into(), nalgebra::Matrix3::identity()).ok();
/// let mut robot = RobotDescription::new("thrown body");
/// robot.base = Base::Floating;
/// robot.links.push(LinkDescription::new("body", mass));
/// let model = Model::new(robot)?;
/// let mut workspace = Workspace::new(&model);
/// let (q, v) = ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [0.3, 0.1, -0.2, 1.0, 2.0, -1.0]);
/// let (mut c, mut product) = ([0.0; 36], [0.0; 6]);
/// coriolis_matrix(&model, &mut workspace, &q, &v, &mut c);
/// velocity_product(&model, &mut workspace, &q, &v, &mut product);
/// for (row, product) in c.chunks(6).zip(product) {
///     let sum: f64 = row.iter().zip(v).map(|(c, v)| c * v).sum();
///     assert!((sum - product).abs() < 1e-14);
/// }
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn coriolis_matrix<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    coriolis: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("the Coriolis matrix", coriolis.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::CoriolisMatrix, &[q, v], &mut [&mut *coriolis]) {
        return;
    }
    run(&mut workspace.tree, CoriolisMatrix { model, q, v, coriolis });
}

/// The arguments of [`coriolis_matrix`].
pub struct CoriolisMatrix<'a, S> {
    model: &'a Model,
    q: &'a [S],
    v: &'a [S],
    coriolis: &'a mut [S],
}

compiled_once!(CoriolisMatrix);

impl<S: Scalar> Kernel<TreeStorage, S> for CoriolisMatrix<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, coriolis } = self;
        let (q, v, coriolis) = (N::view(q), N::view(v), N::view_mut(coriolis));
        compute_columns(model, tree, q);
        compute_twists(model, tree, v);
        compute_column_rates(model, tree);
        if M3::<N>::KEEPS_TRANSPOSE && !model.needs_dense_factor && !model.points.carried {
            blocks::write_matrix(model, tree, coriolis);
        } else {
            paths::write_matrix(model, tree, coriolis);
        }
    }
}
