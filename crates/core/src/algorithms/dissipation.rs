//! Damping and dry friction of the joints.
//!
//! b(v) = damping · v + friction · sign v is separate from the conservative terms of the equation of motion:
//! M v̇ + C v + g + b = τ. Cost: O(n).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use crate::Model;

/// b(v) = damping · v + friction · sign v for each joint: the forces that the motors must supply in addition
/// to the rigid-body forces \[N·m, N\]. Their power vᵀb is never negative.
///
/// ```
/// use robot_dynamics::algorithms::dissipation;
/// use robot_dynamics::description::{PassiveForces, pendulum};
/// use robot_dynamics::model::Model;
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_damping(0.3).with_friction(0.1);
/// let (model, mut b) = (Model::new(robot)?, [0.0]);
/// dissipation(&model, &[-2.0], &mut b);
/// assert_eq!(b, [0.3 * -2.0 - 0.1]); // opposes the motion
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

/// [`dissipation`] without the check of lengths.
#[inline(always)]
pub fn dissipate<S: Scalar>(model: &Model, v: &[S], dissipation: &mut [S]) {
    dissipation.fill(S::zero());
    for dof in &model.dofs {
        let rate = v[dof.coordinate].scale(dof.ratio);
        let force = rate.scale(dof.passive.damping) + rate.signum0().scale(dof.passive.friction);
        dissipation[dof.coordinate] += force.scale(dof.ratio);
    }
}

/// The diagonal of ∂b/∂v, nv entries: each coordinate's damping and that of its mimic joints. The other
/// entries of the matrix are zero. Friction does not contribute: its derivative is zero at v ≠ 0.
///
/// ```
/// use robot_dynamics::algorithms::dissipation_derivative;
/// use robot_dynamics::description::{PassiveForces, pendulum};
/// use robot_dynamics::model::Model;
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
