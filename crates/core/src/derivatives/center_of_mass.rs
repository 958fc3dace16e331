//! ∂ċ/∂q, the derivative of the centre of mass's velocity at constant v. Cost: O(n).
//!
//! m ∂ċ/∂q_j is the linear part of σ × p + I (V × S). Here p and I are the momentum and inertia of the
//! subtree of j, S = (s, σ) its motion, and V the velocity of its parent. ∂c/∂q and ∂ċ/∂v are both the
//! Jacobian of the centre of mass.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use crate::kinematics::shifts::{pass_inertia, pass_inward, pass_outward};
use crate::kinematics::world_frame::{
    compute_columns, compute_twists, inertia_in_world, momentum_of, motion_cross,
};
use crate::model::WORLD;
use crate::spatial::motion::MotionVector;
use crate::{Model, Workspace};

/// ∂ċ/∂q at constant v, 3×nv, row-major, along the world's axes. ∂c/∂q and ∂ċ/∂v are both
/// [`center_of_mass_jacobian`](crate::center_of_mass_jacobian).
///
/// A displacement along DoF j rotates the momentum p of its subtree, except for the part due to the parent's
/// velocity V. So m ∂ċ/∂q_j is the linear part of σ × p + I (V × S), with p and I of the subtree. For a
/// quaternion joint, column j is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::center_of_mass_bias_acceleration;
/// use robot_dynamics::derivatives::center_of_mass_velocity_derivative;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // At constant v, ċ changes along the motion by (∂ċ/∂q) v = J̇ v.
/// let (w, mut by_position) = (&mut Workspace::new(&model), vec![0.0; 3 * model.nv()]);
/// center_of_mass_velocity_derivative(&model, w, &q, &v, &mut by_position);
/// let rate = DMatrix::from_row_slice(3, model.nv(), &by_position) * DVector::from_column_slice(&v);
/// let bias = center_of_mass_bias_acceleration(&model, w, &q, &v);
/// assert!((0..3).all(|i| (rate[i] - bias[i]).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn center_of_mass_velocity_derivative<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    by_position: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    let nv = model.nv;
    check_length("the derivative of the centre of mass's velocity", by_position.len(), 3 * nv);
    compute_columns(model, &mut workspace.tree, q);
    compute_twists(model, &mut workspace.tree, v);
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &workspace.tree.world.pose[i]);
        workspace.tree.bodies.force[i] = momentum_of(&inertia, &workspace.tree.world.twist[i]);
        workspace.tree.inertias.composite[i] = inertia;
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent != WORLD {
            let (mut force, mut composite) =
                (workspace.tree.bodies.force[i], workspace.tree.inertias.composite[i]);
            pass_inward(body, &workspace.tree.world.levers, &mut force);
            pass_inertia(body, &workspace.tree.world.levers, &mut composite);
            workspace.tree.bodies.force[body.parent].add(&force);
            crate::kinematics::world_frame::add_composite(
                &mut workspace.tree.inertias.composite[body.parent],
                &composite,
            );
        }
    }
    by_position.fill(S::zero());
    let inverse_mass = 1.0 / model.mass();
    for (dof, s) in model.dofs.iter().zip(&workspace.tree.world.column) {
        let parent = model.bodies[dof.body].parent;
        let mut parent_twist =
            if parent == WORLD { MotionVector::zero() } else { workspace.tree.world.twist[parent] };
        pass_outward(&model.bodies[dof.body], &workspace.tree.world.levers, &mut parent_twist);
        let carried =
            momentum_of(&workspace.tree.inertias.composite[dof.body], &motion_cross(&parent_twist, s)).linear;
        let change = s.angular.cross(workspace.tree.bodies.force[dof.body].linear) + carried;
        for (row, entry) in change.array().into_iter().enumerate() {
            by_position[row * nv + dof.coordinate] += entry.scale(dof.ratio * inverse_mass);
        }
    }
}
