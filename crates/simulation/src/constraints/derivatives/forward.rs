//! ∂a and ∂λ of constrained forward dynamics by q, v and τ. Cost: O(n depth + nv² depth + K nv²).

use nalgebra::DMatrix;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_integrators::check_computed;

use super::super::forward_dynamics::{ConstrainedMotion, SolvedMotion};
use super::super::{ConstraintError, ConstraintOptions, ConstraintSet};
use super::shortest::ShortestMultipliers;
use super::system::{force_derivative, inverse_derivatives, rate_derivative, solve_system};
use crate::equality::row_derivatives::RowWeights;

/// A constrained motion and its derivatives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConstrainedMotionDerivatives {
    /// The motion: a, λ and the rank.
    pub motion: ConstrainedMotion,
    /// ∂a/∂q, nv×nv; along [`integrate`](robot_dynamics_core::integrate)(q, δ eⱼ) for quaternion joints.
    pub acceleration_by_position: DMatrix<f64>,
    /// ∂a/∂v, nv×nv.
    pub acceleration_by_velocity: DMatrix<f64>,
    /// ∂a/∂τ, nv×nv: symmetric, positive semi-definite, and A ∂a/∂τ = 0.
    pub acceleration_by_force: DMatrix<f64>,
    /// ∂λ/∂q, K×nv.
    pub multipliers_by_position: DMatrix<f64>,
    /// ∂λ/∂v, K×nv.
    pub multipliers_by_velocity: DMatrix<f64>,
    /// ∂λ/∂τ, K×nv.
    pub multipliers_by_force: DMatrix<f64>,
}

/// Returns a and λ of [`constrained_forward_dynamics`](super::super::constrained_forward_dynamics) with their
/// derivatives by q, v and τ.
///
/// They are exact, for every kind of row and with Baumgarte's terms. If rows depend on others, they are the
/// derivatives along which the rank stays, as for a planar loop that is closed in space. The multipliers of
/// dropped rows are then 0 with all their derivatives. With
/// [`RedundantRows::Proximal`](super::super::RedundantRows::Proximal) the derivatives are those of the shortest
/// multipliers. Damping and friction are not included. The function allocates.
///
/// ```
/// use robot_dynamics::constraints::{ConstraintOptions, ConstraintSet, FrameConstraint, SpatialAxis};
/// use robot_dynamics::derivatives::constrained_forward_dynamics_derivatives;
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// // A rod on a hinge, whose tip is held at its height: the tip cannot move, and λ carries the torque.
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let tip = model.frame_named("tip")?;
/// let hold = FrameConstraint::contact(tip, Pose::IDENTITY, &[SpatialAxis::Z]);
/// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
/// let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
/// let by = constrained_forward_dynamics_derivatives(&model, w, &set, &options, &[0.3], &[0.0], &[1.0])?;
/// assert!(by.acceleration_by_force[(0, 0)].abs() < 1e-15);
/// // λ l cos q = τ + m g l cos q, because the height of the tip is −l sin q.
/// let by_force = 1.0 / (0.5 * 0.3_f64.cos());
/// assert!((by.multipliers_by_force[(0, 0)] - by_force).abs() < 1e-14);
/// assert!((by.multipliers_by_position[(0, 0)] - by_force * 0.3_f64.tan()).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`constrained_forward_dynamics`](super::super::constrained_forward_dynamics), and a derivative that
/// is not finite.
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "computeConstraintDynamicsDerivatives")]
#[track_caller]
pub fn constrained_forward_dynamics_derivatives(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    q: &[f64],
    v: &[f64],
    tau: &[f64],
) -> Result<ConstrainedMotionDerivatives, ConstraintError> {
    let solved = SolvedMotion::new(model, workspace, (set, options), [q, v, tau])?;
    let SolvedMotion { motion, rows, mass, factor } = &solved;
    let (nv, count, a) = (model.nv(), set.len(), motion.acceleration.as_slice());
    let [mut force_by_position, force_by_velocity] =
        inverse_derivatives(model, workspace, [q, v, a]).map(|matrix| -matrix);
    let [mut rate_by_position, mut rate_by_velocity] = [(); 2].map(|()| DMatrix::zeros(count, nv));
    let shortest = ShortestMultipliers::of(&solved, options);
    let mut null = DMatrix::zeros(count, nv);
    if let Some(placed) = set.placed(model, workspace, q) {
        let moving = placed.moving(model, q, v, a);
        force_by_position += force_derivative(&moving, motion.multipliers.as_slice(), nv);
        let rate = options.stabilization.map_or(0.0, |feedback| feedback.rate);
        let weights = RowWeights { acceleration: 1.0, rate: 2.0 * rate };
        moving.each_entry(weights, |row, at, [by_position, by_velocity]| {
            rate_by_position[(row, at)] -= by_position;
            rate_by_velocity[(row, at)] -= by_velocity;
        });
        // ∂φ/∂q = A.
        for row in (0..count).filter(|&row| rows.holonomic[row] && rate != 0.0) {
            let change = rows.matrix.row(row) * (rate * rate);
            rate_by_position.row_mut(row).zip_apply(&change, |entry, change| *entry -= change);
        }
        if let Some(shortest) = &shortest {
            let preimage = shortest.preimage.as_slice();
            null = rate_derivative(&placed.moving(model, q, preimage, &vec![0.0; nv]), count, nv);
        }
    }
    let solve = |forces, rates: &DMatrix<f64>| solve_system(mass, factor, forces, rates);
    let [acceleration_by_position, mut multipliers_by_position] = solve(force_by_position, &rate_by_position);
    let [acceleration_by_velocity, mut multipliers_by_velocity] = solve(force_by_velocity, &rate_by_velocity);
    let [acceleration_by_force, mut multipliers_by_force] =
        solve(DMatrix::identity(nv, nv), &DMatrix::zeros(count, nv));
    if let Some(shortest) = &shortest {
        for multipliers in
            [&mut multipliers_by_position, &mut multipliers_by_velocity, &mut multipliers_by_force]
        {
            *multipliers = shortest.project(multipliers);
        }
        multipliers_by_position += &null - shortest.project(&null);
    }
    let by = ConstrainedMotionDerivatives {
        motion: solved.motion,
        acceleration_by_position,
        acceleration_by_velocity,
        acceleration_by_force,
        multipliers_by_position,
        multipliers_by_velocity,
        multipliers_by_force,
    };
    for (quantity, matrix) in [
        ("∂a/∂q", &by.acceleration_by_position),
        ("∂a/∂v", &by.acceleration_by_velocity),
        ("∂a/∂τ", &by.acceleration_by_force),
        ("∂λ/∂q", &by.multipliers_by_position),
        ("∂λ/∂v", &by.multipliers_by_velocity),
        ("∂λ/∂τ", &by.multipliers_by_force),
    ] {
        check_computed(quantity, matrix.as_slice())?;
    }
    Ok(by)
}
