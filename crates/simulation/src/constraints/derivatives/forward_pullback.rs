//! The pullback of constrained forward dynamics. Cost: that of the motion, plus one solution of the system.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{Model, Workspace, parameter_count};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::check_finite;

use super::super::forward_dynamics::{ConstrainedMotion, SolvedMotion};
use super::super::{ConstraintError, ConstraintOptions, ConstraintSet};
use super::shortest::ShortestMultipliers;
use super::system::{pull_inverse_dynamics, solve_system};
use crate::equality::row_derivatives::RowWeights;

/// A constrained motion and the gradient of āᵀa + λ̄ᵀλ.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedMotionPullback {
    /// The motion: a, λ and the rank.
    pub motion: ConstrainedMotion,
    /// The gradient by q, nv numbers; along [`integrate`](robot_dynamics_core::integrate)(q, δ eⱼ) for
    /// quaternion joints.
    pub by_position: DVector<f64>,
    /// The gradient by v, nv numbers.
    pub by_velocity: DVector<f64>,
    /// The gradient by τ, nv numbers.
    pub by_force: DVector<f64>,
    /// The gradient by the description's parameters: see
    /// [`ParameterCotangents::of`](robot_dynamics_core::ParameterCotangents::of).
    pub parameters: DVector<f64>,
}

/// The inputs of [`constrained_forward_dynamics_pullback`].
#[derive(Clone, Copy, Debug)]
pub struct ConstrainedPullbackInputs<'a> {
    /// The configuration, nq numbers.
    pub q: &'a [f64],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [f64],
    /// The generalized forces, nv numbers \[N·m, N\].
    pub tau: &'a [f64],
    /// ā, the cotangent of the acceleration, nv numbers.
    pub acceleration: &'a [f64],
    /// λ̄, the cotangent of the multipliers, K numbers.
    pub multipliers: &'a [f64],
}

/// Returns a and λ of [`constrained_forward_dynamics`](super::super::constrained_forward_dynamics) and the
/// gradient of āᵀa + λ̄ᵀλ by q, v, τ and the description's parameters.
///
/// It equals the cotangents times the matrices of
/// [`constrained_forward_dynamics_derivatives`](super::super::constrained_forward_dynamics_derivatives), at the
/// cost of one solution. With M μ − Aᵀy = ā and A μ = −λ̄, the gradient by τ is μ, that by v is
/// −μᵀ∂ID/∂v + yᵀ∂(A a + Ȧv)/∂v, and that by q likewise with λᵀ∂(A μ)/∂q. The function allocates.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::derivatives::{ConstrainedPullbackInputs, constrained_forward_dynamics_pullback};
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// // The tip of a rod is held at its height: λ l cos q = τ + m g l cos q.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let hold = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
/// let inputs = ConstrainedPullbackInputs {
///     q: &[0.3],
///     v: &[0.0],
///     tau: &[1.0],
///     acceleration: &[0.0],
///     multipliers: &[3.0],
/// };
/// let by = constrained_forward_dynamics_pullback(&model, w, &set, &options, inputs)?;
/// assert!((by.by_force[0] - 3.0 / (0.5 * 0.3_f64.cos())).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`constrained_forward_dynamics`](super::super::constrained_forward_dynamics), and a cotangent or a
/// gradient that is not finite.
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "vector-Jacobian product")]
#[track_caller]
pub fn constrained_forward_dynamics_pullback(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    inputs: ConstrainedPullbackInputs<'_>,
) -> Result<ConstrainedMotionPullback, ConstraintError> {
    let ConstrainedPullbackInputs { q, v, tau, acceleration, multipliers } = inputs;
    check_length("the cotangent of a", acceleration.len(), model.nv());
    check_length("the cotangent of λ", multipliers.len(), set.len());
    check_finite("the cotangent of a", acceleration)?;
    check_finite("the cotangent of λ", multipliers)?;
    let solved = SolvedMotion::new(model, workspace, (set, options), [q, v, tau])?;
    let SolvedMotion { motion, rows, mass, factor } = &solved;
    let (nv, a) = (model.nv(), motion.acceleration.as_slice());
    let shortest = ShortestMultipliers::of(&solved, options);
    let all = DMatrix::from_column_slice(set.len(), 1, multipliers);
    let along = shortest.as_ref().map_or_else(|| all.clone(), |shortest| shortest.project(&all));
    let [mu, y] = solve_system(mass, factor, DMatrix::from_column_slice(nv, 1, acceleration), &-&along);
    let mu = DVector::from_column_slice(mu.as_slice());
    let mut parameters = DVector::zeros(parameter_count(model));
    let [mut by_position, mut by_velocity, _] =
        pull_inverse_dynamics(model, workspace, [q, v, a], &-&mu, parameters.as_mut_slice());
    if let Some(placed) = set.placed(model, workspace, q) {
        let rate = options.stabilization.map_or(0.0, |feedback| feedback.rate);
        let weights = RowWeights { acceleration: 1.0, rate: 2.0 * rate };
        placed.moving(model, q, v, a).each_entry(weights, |row, at, [entry, by_v]| {
            by_position[at] += y[row] * entry;
            by_velocity[at] += y[row] * by_v;
        });
        for row in (0..set.len()).filter(|&row| rows.holonomic[row] && rate != 0.0) {
            by_position += rows.matrix.row(row).transpose() * (rate * rate * y[row]);
        }
        let rest = vec![0.0; nv];
        placed
            .moving(model, q, mu.as_slice(), &rest)
            .add_rate_gradient(motion.multipliers.as_slice(), by_position.as_mut_slice());
        if let Some(shortest) = &shortest {
            let across = &all - &along;
            placed
                .moving(model, q, shortest.preimage.as_slice(), &rest)
                .add_rate_gradient(across.as_slice(), by_position.as_mut_slice());
        }
    }
    for (quantity, values) in [
        ("the gradient by q", &by_position),
        ("the gradient by v", &by_velocity),
        ("the gradient by τ", &mu),
        ("the gradient by a parameter", &parameters),
    ] {
        check_computed(quantity, values.as_slice())?;
    }
    let motion = solved.motion;
    Ok(ConstrainedMotionPullback { motion, by_position, by_velocity, by_force: mu, parameters })
}
