//! The pullback of damping and friction.

use dynamics::Scalar;

use super::parameters::{
    DAMPING, FRICTION, PASSIVE_PARAMETERS_PER_JOINT, check_parameters, with_passive_places,
};
use crate::Model;
use crate::model::length::check_length;

/// λᵀ ∂b/∂v of b = damping · v + friction · sign v, nv numbers; see [`dissipation`](crate::dissipation).
///
/// b is diagonal in v. Friction is smooth where no v is 0 and flat there, so it counts nothing in ∂b/∂v; at v = 0, where it has
/// no derivative, the value is that of both sides, 0. `parameters` is empty or has
/// [`parameter_count`](crate::parameter_count) numbers; λᵀ∂b/∂(damping) = λ v and λᵀ∂b/∂(friction) = λ sign v of each joint
/// are **added** to it.
///
/// Forward dynamics takes τ − b(v): with `by_force` of
/// [`forward_dynamics_pullback`](crate::forward_dynamics_pullback) call this with λ = −`by_force`, and add.
///
/// ```
/// use multibody::{Model, PassiveForces, ParameterCotangents, dissipation_pullback, parameter_count, pendulum};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_damping(0.3).with_friction(0.1);
/// let model = Model::new(robot)?;
/// let (mut by_v, mut parameters) = ([0.0], vec![0.0; parameter_count(&model)]);
/// dissipation_pullback(&model, &[-2.0], &[5.0], &mut by_v, &mut parameters);
/// assert_eq!(by_v, [5.0 * 0.3]);
/// assert_eq!(ParameterCotangents::of(&model, &parameters).passive[..3], [0.0, 5.0 * -2.0, -5.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn dissipation_pullback<S: Scalar>(
    model: &Model,
    v: &[S],
    cotangent: &[S],
    by_velocity: &mut [S],
    parameters: &mut [S],
) {
    check_length("v", v.len(), model.nv);
    check_length("the cotangent", cotangent.len(), model.nv);
    check_length("the cotangent of v", by_velocity.len(), model.nv);
    check_parameters(model, parameters);
    by_velocity.fill(S::zero());
    pull_dissipation(model, v, cotangent, 1.0, by_velocity, parameters);
}

/// [`dissipation_pullback`] of `sign` λ, added to both results.
#[inline(always)]
pub(crate) fn pull_dissipation<S: Scalar>(
    model: &Model,
    v: &[S],
    cotangent: &[S],
    sign: f64,
    by_velocity: &mut [S],
    parameters: &mut [S],
) {
    for (first, dof) in with_passive_places(model) {
        let (rate, own) =
            (v[dof.coordinate].scale(dof.ratio), cotangent[dof.coordinate].scale(sign * dof.ratio));
        by_velocity[dof.coordinate] += own.scale(dof.passive.damping * dof.ratio);
        if !parameters.is_empty() {
            let to = &mut parameters[first..first + PASSIVE_PARAMETERS_PER_JOINT];
            to[DAMPING] += own * rate;
            to[FRICTION] += own * rate.signum0();
        }
    }
}
