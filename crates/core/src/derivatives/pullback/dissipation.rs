//! The pullback of damping and friction.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use super::parameters::{
    DAMPING, FRICTION, PASSIVE_PARAMETERS_PER_JOINT, check_parameters, with_passive_places,
};
use crate::Model;

/// λᵀ ∂b/∂v of b = damping · v + friction · sign v, nv numbers; see [`dissipation`](crate::dissipation).
///
/// b is diagonal in v. Friction has zero derivative at v ≠ 0. At v = 0, where it has none, the common
/// one-sided value 0 is used. `parameters` is empty or has [`parameter_count`](crate::parameter_count) numbers.
/// λᵀ∂b/∂(damping) = λ v and λᵀ∂b/∂(friction) = λ sign v of each joint are **added** to it.
///
/// Forward dynamics takes τ − b(v). To include b, call this function with λ = −`by_force` of
/// [`forward_dynamics_pullback`](crate::forward_dynamics_pullback), and add the results.
///
/// ```
/// use robot_dynamics::derivatives::{ParameterCotangents, dissipation_pullback, parameter_count};
/// use robot_dynamics::description::{PassiveForces, pendulum};
/// use robot_dynamics::model::Model;
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

/// Adds [`dissipation_pullback`] for `sign` λ to both results.
#[inline(always)]
pub fn pull_dissipation<S: Scalar>(
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
