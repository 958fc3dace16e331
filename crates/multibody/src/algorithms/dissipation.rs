//! Forces that take energy out of the joints.

use dynamics::Scalar;

use crate::Model;
use crate::model::length::check_length;

/// b(v) = damping · v + friction · sign v for each joint: the forces the motors must supply on top of the
/// rigid-body ones. Their power vᵀb is never negative.
///
/// ```
/// use multibody::{Model, PassiveForces, dissipation, pendulum};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_damping(0.3).with_friction(0.1);
/// let (model, mut b) = (Model::new(robot)?, [0.0]);
/// dissipation(&model, &[-2.0], &mut b);
/// assert_eq!(b, [0.3 * -2.0 - 0.1]); // against the motion
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn dissipation<S: Scalar>(model: &Model, v: &[S], dissipation: &mut [S]) {
    check_length("v", v.len(), model.nv);
    check_length("the dissipation", dissipation.len(), model.nv);
    dissipate(model, v, dissipation);
}

/// [`dissipation`] wherever it is called from.
#[inline(always)]
pub(crate) fn dissipate<S: Scalar>(model: &Model, v: &[S], dissipation: &mut [S]) {
    dissipation.fill(S::zero());
    for dof in &model.dofs {
        let rate = v[dof.coordinate].scale(dof.ratio);
        let force = rate.scale(dof.passive.damping) + rate.signum0().scale(dof.passive.friction);
        dissipation[dof.coordinate] += force.scale(dof.ratio);
    }
}

/// The diagonal of ∂b/∂v, nv entries: each coordinate's damping, with those that follow it. The matrix has no
/// other entries. Friction is flat away from v = 0 and counts nothing.
///
/// ```
/// use multibody::{Model, PassiveForces, dissipation_derivative, pendulum};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_damping(0.3).with_friction(0.1);
/// let (model, mut diagonal) = (Model::new(robot)?, [0.0]);
/// dissipation_derivative(&model, &mut diagonal);
/// assert_eq!(diagonal, [0.3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If the slice has the wrong length.
#[track_caller]
pub fn dissipation_derivative<S: Scalar>(model: &Model, diagonal: &mut [S]) {
    check_length("the diagonal", diagonal.len(), model.nv);
    diagonal.fill(S::zero());
    for dof in &model.dofs {
        diagonal[dof.coordinate] += S::from_f64(dof.passive.damping * dof.ratio * dof.ratio);
    }
}
