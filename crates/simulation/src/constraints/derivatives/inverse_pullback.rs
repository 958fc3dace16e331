//! The pullback of constrained inverse dynamics: the transpose of the maps in `inverse`.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace, parameter_count};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::check_finite;

use super::super::inverse::{ConstrainedTorque, SolvedTorque};
use super::super::{ConstraintError, ConstraintSet};
use super::inverse::{TorqueSystem, keep};
use super::system::pull_inverse_dynamics;

/// Torques and multipliers of a motion, and the gradient of τ̄ᵀτ + λ̄ᵀλ.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedTorquePullback {
    /// τ, λ and the residual.
    pub torque: ConstrainedTorque,
    /// The gradient by q, nv numbers; along [`integrate`](robot_dynamics_core::integrate)(q, δ eⱼ) for
    /// quaternion joints.
    pub by_position: DVector<f64>,
    /// The gradient by v, nv numbers.
    pub by_velocity: DVector<f64>,
    /// The gradient by a, nv numbers.
    pub by_acceleration: DVector<f64>,
    /// The gradient by the description's parameters: see
    /// [`ParameterCotangents::of`](robot_dynamics_core::ParameterCotangents::of).
    pub parameters: DVector<f64>,
}

/// The inputs of [`constrained_inverse_dynamics_pullback`].
#[derive(Clone, Copy, Debug)]
pub struct ConstrainedTorquePullbackInputs<'a> {
    /// The configuration, nq numbers.
    pub q: &'a [f64],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [f64],
    /// The acceleration, nv numbers \[rad/s², m/s²\].
    pub a: &'a [f64],
    /// The coordinates with a motor, nv.
    pub actuated: &'a [bool],
    /// τ̄, the cotangent of the torques, nv numbers.
    pub tau: &'a [f64],
    /// λ̄, the cotangent of the multipliers, K numbers.
    pub multipliers: &'a [f64],
}

/// Returns τ and λ of [`constrained_inverse_dynamics`](super::super::constrained_inverse_dynamics) and the
/// gradient of τ̄ᵀτ + λ̄ᵀλ by q, v, a and the description's parameters. It equals the cotangents times the
/// matrices of
/// [`constrained_inverse_dynamics_derivatives`](super::super::constrained_inverse_dynamics_derivatives). The
/// function allocates.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::derivatives::{
///     ConstrainedTorquePullbackInputs, constrained_inverse_dynamics_pullback,
/// };
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// // The tip of a rod without a motor is held at its height: λ l cos q = m g l cos q − m l² a.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let hold = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let inputs = ConstrainedTorquePullbackInputs {
///     q: &[0.3],
///     v: &[0.0],
///     a: &[2.0],
///     actuated: &[false],
///     tau: &[0.0],
///     multipliers: &[3.0],
/// };
/// let by = constrained_inverse_dynamics_pullback(&model, &mut Workspace::new(&model), &set, inputs)?;
/// assert!((by.by_acceleration[0] + 3.0 * 2.0 * 0.5 / 0.3_f64.cos()).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`constrained_inverse_dynamics`](super::super::constrained_inverse_dynamics), and a cotangent or a
/// gradient that is not finite.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn constrained_inverse_dynamics_pullback(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    inputs: ConstrainedTorquePullbackInputs<'_>,
) -> Result<ConstrainedTorquePullback, ConstraintError> {
    let ConstrainedTorquePullbackInputs { q, v, a, actuated, tau, multipliers } = inputs;
    check_length("the cotangent of tau", tau.len(), model.nv());
    check_length("the cotangent of λ", multipliers.len(), set.len());
    check_finite("the cotangent of tau", tau)?;
    check_finite("the cotangent of λ", multipliers)?;
    let solved = SolvedTorque::new(model, workspace, set, [q, v, a], actuated)?;
    let system = TorqueSystem::new(&solved, actuated);
    let driven = keep(&DVector::from_column_slice(tau), actuated, true);
    let multipliers = DVector::from_column_slice(multipliers);
    // The cotangent of x, and those of both right sides, C⁺ᵀ times the cotangents of their parts.
    let x = system.pull_multipliers(&multipliers) - system.basis.tr_mul(&driven);
    let first = &system.gram_inverse * &x;
    let second = &system.null * system.null.tr_mul(&x);
    let force = &driven
        + keep(&(&system.basis * &first), actuated, false)
        + keep(&(&system.basis * &second), actuated, true);
    let across = &multipliers - &system.range * system.range.tr_mul(&multipliers);
    let column = |x: &DVector<f64>| DMatrix::from_column_slice(x.len(), 1, x.as_slice());
    let weights = [
        system.pseudo_inverse_transposed(&column(&first)),
        system.pseudo_inverse_transposed(&column(&second)),
        column(&across),
    ];
    let mut parameters = DVector::zeros(parameter_count(model));
    let [mut by_position, by_velocity, by_acceleration] =
        pull_inverse_dynamics(model, workspace, [q, v, a], &force, parameters.as_mut_slice());
    if let Some(placed) = set.placed(model, workspace, q) {
        let rest = vec![0.0; model.nv()];
        let slice = by_position.as_mut_slice();
        placed
            .moving(model, q, force.as_slice(), &rest)
            .add_rate_gradient((-&solved.torque.multipliers).as_slice(), slice);
        for (weights, vector) in weights.iter().zip(&system.vectors) {
            placed.moving(model, q, vector.as_slice(), &rest).add_rate_gradient(weights.as_slice(), slice);
        }
    }
    for (quantity, values) in [
        ("the gradient by q", &by_position),
        ("the gradient by v", &by_velocity),
        ("the gradient by a", &by_acceleration),
        ("the gradient by a parameter", &parameters),
    ] {
        check_computed(quantity, values.as_slice())?;
    }
    Ok(ConstrainedTorquePullback {
        torque: solved.torque,
        by_position,
        by_velocity,
        by_acceleration,
        parameters,
    })
}
