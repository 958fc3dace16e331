//! Projections onto the constraint: the nearest configuration and the nearest velocity, in the metric M.
//!
//! Gauss–Newton steps q ← q ⊕ δ with δ = −M⁻¹Aᵀ(A M⁻¹Aᵀ)⁻¹φ, halved far from the constraint, and v ← P v.
//! **(PRM 10.19)** Cost: that of `row_factor` for each step, about three steps near the constraint. q and v
//! change only on success.

use nalgebra::DVector;
use robot_dynamics_core::{Model, Workspace, integrate};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::check_computed;
use robot_dynamics_number::{InvalidInput, check_finite, check_number};

use super::forward_dynamics::LargestEntry;
use super::row_factor::{FactoredRows, MassFactor, RowFactor, factor_rows};
use super::{ConstraintError, ConstraintOptions, ConstraintSet};

/// The most Gauss–Newton steps of a projection; near the constraint it takes three.
const MAX_ITERATIONS: usize = 100;

/// The result of a projection onto the constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PositionProjection {
    /// max |φ| before \[m or rad\].
    pub before: f64,
    /// max |φ| after.
    pub after: f64,
    /// Gauss–Newton steps taken.
    pub iterations: usize,
}

/// Moves q onto φ(q) = 0 by Gauss–Newton in the metric M on the manifold. Its step is q ← q ⊕ δ with δ =
/// −M⁻¹Aᵀ(A M⁻¹Aᵀ)⁻¹φ, until max |φ| ≤ `tolerance` \[m or rad\]. Rows without φ are ignored.
///
/// It takes the δ with the least ½ δᵀMδ that closes the gap to first order, so heavy links move least. Far
/// from the constraint, a step is halved until |φ| decreases. A row that depends on others, such as one
/// across the plane of a planar loop, may be off by [`ConstraintOptions::dependence`]. The reason is that
/// axes in files are parallel only to their last digit. q is changed only on success.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintOptions, ConstraintSet, project_position};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = robot_dynamics::description::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// let set = ConstraintSet::new(&model, [("hold", FrameConstraint::point_contact(ball, [0.0; 3]).into())])?;
/// let mut q = [0.3, 0.0, 0.4, 0.0, 0.0, 0.6, 0.8]; // held at the origin it should be
/// let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
/// let projection = project_position(&model, w, &set, &options, 1e-12, &mut q)?;
/// assert_eq!(projection.before, 0.4); // of x, y and z the farthest off
/// assert!(q[..3].iter().all(|x| x.abs() <= 1e-12));
/// assert!((q[5] - 0.6).abs() < 1e-12); // nothing asked it to turn
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstraintError::NotConverged`] with the worst row; a singular M; an input, an option or a row
/// that is not finite.
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn project_position(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    tolerance: f64,
    q: &mut [f64],
) -> Result<PositionProjection, ConstraintError> {
    check_length("q", q.len(), model.nq());
    check_finite("q", q)?;
    check_number("the tolerance", tolerance)?;
    if tolerance < 0.0 {
        return Err(InvalidInput::unmet("the tolerance", "must not be negative").into());
    }
    options.check()?;
    let rest = vec![0.0; model.nv()];
    let (mut at, mut moved) = (q.to_vec(), q.to_vec());
    let mut rows = set.rows(model, workspace, &at, &rest);
    rows.check(set.row_names())?;
    let before = rows.position_error.amax_or_zero();
    let mut iterations = 0;
    loop {
        let error = rows.position_error.amax_or_zero();
        if error <= tolerance {
            q.copy_from_slice(&at);
            return Ok(PositionProjection { before, after: error, iterations });
        }
        let give_up = |iterations| {
            let worst = rows.position_error.icamax();
            let name = set.row_names()[worst].clone();
            ConstraintError::NotConverged { iterations, name, error }
        };
        if iterations == MAX_ITERATIONS {
            return Err(give_up(iterations));
        }
        let mass = MassFactor::new(model, workspace, &at)?;
        for (i, _) in rows.holonomic.iter().enumerate().filter(|(_, holonomic)| !**holonomic) {
            rows.matrix.row_mut(i).fill(0.0);
        }
        let factor = RowFactor::of(set, &mass, &rows, options.dependence)?;
        let step = -factor.responses.tr_mul(&factor.solve_triangle(&rows.position_error));
        let size = rows.position_error.norm();
        let mut fraction = 1.0;
        loop {
            integrate(model, &at, (&step * fraction).as_slice(), &mut moved);
            let next = set.rows(model, workspace, &moved, &rest);
            if next.position_error.norm() < size {
                rows = next;
                break;
            }
            fraction *= 0.5;
            // A step reduced to 2⁻³⁰ does not help: φ is at a nonzero minimum, or at rounding.
            if fraction < 1e-9 {
                // No step can close the error of a dependent row that is below its dependence.
                let mut left = rows.position_error.clone();
                for row in factor.dependent_indices() {
                    left[row] = if left[row].abs() <= options.dependence { 0.0 } else { left[row] };
                }
                if left.amax_or_zero() <= tolerance {
                    q.copy_from_slice(&at);
                    return Ok(PositionProjection { before, after: error, iterations });
                }
                return Err(give_up(iterations));
            }
        }
        core::mem::swap(&mut at, &mut moved);
        iterations += 1;
    }
}

/// v ← P v: the velocity nearest to v, in kinetic energy, that the constraint allows. Returns the energy
/// taken out, ½ nᵀM n with n = (1−P) v \[J\]. v is changed only on success. **(PRM 10.19)**
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintOptions, ConstraintSet, project_velocity};
/// use robot_dynamics::model::{Workspace, neutral};
/// # use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
/// # use robot_dynamics::model::Model;
/// # let mut robot = RobotDescription::new("ball");
/// # robot.base = Base::Floating;
/// # let ball = robot_dynamics::description::MassProperties::new(2.0, [0.0; 3].into(), nalgebra::Matrix3::identity()).ok();
/// # robot.links.push(LinkDescription::new("ball", ball));
/// # let model = Model::new(robot)?;
/// # let ball = model.frame_named("ball")?;
/// // Held at its centre, a ball of 2 kg loses ½ m v² and goes on turning.
/// let set = ConstraintSet::new(&model, [("hold", FrameConstraint::point_contact(ball, [0.0; 3]).into())])?;
/// let mut v = [1.0, 2.0, 3.0, 0.1, 0.2, 0.3];
/// let (w, options) = (&mut Workspace::new(&model), ConstraintOptions::default());
/// let lost = project_velocity(&model, w, &set, &options, &neutral(&model), &mut v)?;
/// assert!((lost - 0.5 * 2.0 * (1.0 + 4.0 + 9.0)).abs() < 1e-13);
/// assert!(v.iter().zip([0.0, 0.0, 0.0, 0.1, 0.2, 0.3]).all(|(v, expected)| (v - expected).abs() < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ConstraintError`] if M is singular, or an input, an option, a row or a result is not finite.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn project_velocity(
    model: &Model,
    workspace: &mut Workspace,
    set: &ConstraintSet,
    options: &ConstraintOptions,
    q: &[f64],
    v: &mut [f64],
) -> Result<f64, ConstraintError> {
    let FactoredRows { mass, factor, .. } = factor_rows(model, workspace, (set, options), (q, v))?;
    let before = DVector::from_column_slice(v);
    let allowed = factor.project_velocity(&before);
    let removed = before - &allowed;
    let energy = 0.5 * removed.dot(&(&mass.mass * &removed));
    check_computed("the projected v", allowed.as_slice())?;
    check_number("the energy removed", energy)?;
    v.copy_from_slice(allowed.as_slice());
    Ok(energy)
}
