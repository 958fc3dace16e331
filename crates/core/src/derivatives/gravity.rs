//! The Hessian ∂g/∂q of the potential energy, springs included. Cost: O(n depth).
//!
//! For a DoF i and a DoF j of a descendant's or the same body, ∂g_j/∂q_i = (m_j s_j + σ_j × h_j)·(−g × σ_i).
//! Here m and h are the mass and first moment of the subtree of j, and (s, σ) is the motion of a DoF. The
//! DoFs of one spherical or floating joint do not commute, so their block is not symmetric.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::kinematics::world_frame::{composites_in_world, compute_columns};
use crate::model::native::NativeFunction;
use crate::workspace::native::computed_natively;
use crate::{Model, Workspace};

/// ∂g/∂q, nv×nv, row-major \[N·m/rad, N/m\]: the second derivative of V by q, springs included. O(n depth).
///
/// For a DoF i and a DoF j of a descendant's or the same body: ∂g_j/∂q_i = (m_j s_j + σ_j × h_j)·(−g × σ_i).
/// Here m and h are the mass and first moment of the subtree of j, and (s, σ) is the motion of a DoF.
///
/// The matrix is symmetric except between the DoFs of one spherical or floating joint. Their directions do
/// not commute, and column j is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use robot_dynamics::derivatives::gravity_derivative;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut hessian = [0.0];
/// gravity_derivative(&model, &mut Workspace::<f64>::new(&model), &[0.3], &mut hessian);
/// assert!((hessian[0] - 2.0 * 9.81 * 0.5 * 0.3_f64.sin()).abs() < 1e-14); // of V = −m g l sin q
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "computeGeneralizedGravityDerivatives")]
#[inline]
#[track_caller]
pub fn gravity_derivative<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    hessian: &mut [S],
) {
    workspace.check_inputs(model, q);
    let nv = model.nv;
    check_length("the derivative of gravity", hessian.len(), nv * nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::GravityDerivative, &[q], &mut [&mut *hessian]) {
        return;
    }
    compute_columns(model, &mut workspace.tree, q);
    composites_in_world(model, &mut workspace.tree);
    hessian.fill(S::zero());
    let up = V3::from_f64(model.gravity().map(|g| -g));
    for (i, dof) in model.dofs.iter().enumerate() {
        let body = &model.bodies[dof.body];
        let own = body.dof..body.dof + body.motion.nv();
        let carried = up.cross(workspace.tree.world.column[i].angular);
        for j in own.start..dof.end {
            let other = &model.dofs[j];
            let (composite, s) =
                (&workspace.tree.inertias.composite[other.body], &workspace.tree.world.column[j]);
            let momentum = s.angular.cross(composite.first_moment).add_scaled(composite.mass, s.linear);
            let entry = momentum.dot(carried).scale(dof.ratio * other.ratio);
            hessian[other.coordinate * nv + dof.coordinate] += entry;
            if !own.contains(&j) {
                hessian[dof.coordinate * nv + other.coordinate] += entry;
            }
        }
        if model.has_springs {
            let stiffness = dof.passive.stiffness * dof.ratio * dof.ratio;
            hessian[dof.coordinate * (nv + 1)] += S::from_f64(stiffness);
        }
    }
}
