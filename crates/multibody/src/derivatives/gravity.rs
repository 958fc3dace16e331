//! The Hessian of the potential energy.

use dynamics::Scalar;

use crate::model::length::check_length;
use crate::model::native::NativeFunction;
use crate::scratch::native::computed_natively;
use crate::spatial::algebra::V3;
use crate::stages::screws::{composites_in_world, place_screws};
use crate::{Model, Workspace};

/// ∂g/∂q, nv×nv, row-major: the second derivative of V by q; springs count in it. N·m/rad, N/m. O(n depth).
///
/// For freedom i and freedom j of a body beyond, or of the same body: ∂g_j/∂q_i = (m_j s_j + σ_j × h_j)·(−g × σ_i),
/// with the mass m and first moment h of all beyond j and the motion (s, σ) of a freedom. It is symmetric but
/// between the freedoms of one spherical or floating joint, whose directions do not commute:
/// column j is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use multibody::{Model, Workspace, gravity_derivative, pendulum};
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
    workspace.admit(model, q);
    let nv = model.nv;
    check_length("the derivative of gravity", hessian.len(), nv * nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::GravityDerivative, &[q], &mut [&mut *hessian]) {
        return;
    }
    place_screws(model, &mut workspace.tree, q);
    composites_in_world(model, &mut workspace.tree);
    hessian.fill(S::zero());
    let up = V3::from_f64(model.gravity().map(|g| -g));
    for (i, dof) in model.dofs.iter().enumerate() {
        let body = &model.bodies[dof.body];
        let own = body.dof..body.dof + body.motion.nv();
        let carried = up.cross(workspace.tree.screws.column[i].angular);
        for j in own.start..dof.end {
            let other = &model.dofs[j];
            let (composite, s) =
                (&workspace.tree.inertias.composite[other.body], &workspace.tree.screws.column[j]);
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
