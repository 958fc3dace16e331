//! The derivatives of the kinetic energy K = ½ vᵀM(q) v: the momentum p = ∂K/∂v = M v, and ∂K/∂q.
//!
//! p is the momentum of each DoF's subtree, projected on its motion, without M. For a quaternion joint, entry
//! k of ∂K/∂q is the rate of K along the motion eₖ at constant v. Cost: O(n).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use crate::kinematics::placement::gather;
use crate::kinematics::shifts::{pass_inward, pass_outward};
use crate::kinematics::world_frame::{
    compute_columns, compute_twists, inertia_in_world, momentum_of, motion_cross,
};
use crate::model::WORLD;
use crate::model::native::NativeFunction;
use crate::spatial::motion::MotionVector;
use crate::workspace::native::computed_natively;
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// p = ∂K/∂v = M(q) v \[N·s, N·m·s\] in O(n), without M: the momentum of each DoF's subtree, projected on its
/// motion. Armature is included.
///
/// ```
/// use nalgebra::DVector;
/// use robot_dynamics::algorithms::momentum;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let mut p = vec![0.0; model.nv()];
/// momentum(&model, &mut Workspace::new(&model), &q, &v, &mut p);
/// let product = model.mass_matrix(&q)? * DVector::from_column_slice(&v);
/// assert!(p.iter().zip(&product).all(|(p, product)| (p - product).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn momentum<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    momentum: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("the momentum", momentum.len(), model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::Momentum, &[q, v], &mut [&mut *momentum]) {
        return;
    }
    collect_momenta(model, &mut workspace.tree, q, v);
    for (index, dof) in model.dofs.iter().enumerate() {
        let rotor = workspace.tree.dofs.v[index].scale(dof.passive.armature);
        workspace.tree.dofs.tau[index] =
            workspace.tree.world.column[index].dot(&workspace.tree.bodies.force[dof.body]) + rotor;
    }
    for rotor in &model.rotors {
        rotor.add_force(&workspace.tree.dofs.v, &mut workspace.tree.dofs.tau);
    }
    gather(model, &workspace.tree.dofs.tau, momentum);
}

/// ∂K/∂q at constant v \[N, N·m\]. If q̇ = v for every joint, Hamel's equations read ṗ = τ + ∂K/∂q − ∂V/∂q.
///
/// For a quaternion joint, entry k is the rate of K when the joint moves with the unit velocity eₖ and v
/// stays constant.
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::{kinetic_energy_gradient, mass_matrix_rate};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let options = RandomRobotOptions { kinds: JointKinds::VectorSpace, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // C v = Ṁ v − ∂K/∂q, for a robot with q̇ = v.
/// let nv = model.nv();
/// let (mut rate, mut gradient) = (vec![0.0; nv * nv], vec![0.0; nv]);
/// mass_matrix_rate(&model, &mut Workspace::new(&model), &q, &v, &mut rate);
/// kinetic_energy_gradient(&model, &mut Workspace::new(&model), &q, &v, &mut gradient);
/// let rate_v = DMatrix::from_row_slice(nv, nv, &rate) * DVector::from_column_slice(&v);
/// let product = model.velocity_product(&q, &v)?;
/// assert!((rate_v - DVector::from_vec(gradient) - product).amax() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn kinetic_energy_gradient<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    gradient: &mut [S],
) {
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("the gradient", gradient.len(), model.nv);
    collect_momenta(model, &mut workspace.tree, q, v);
    for (index, dof) in model.dofs.iter().enumerate() {
        let parent = model.bodies[dof.body].parent;
        // The displacement S rotates the subtree and the velocities within it, but not the velocity V of the
        // parent. Relative to the rotated bodies, V changes by V × S.
        let mut carried =
            if parent == WORLD { MotionVector::zero() } else { workspace.tree.world.twist[parent] };
        pass_outward(&model.bodies[dof.body], &workspace.tree.world.levers, &mut carried);
        let change = motion_cross(&carried, &workspace.tree.world.column[index]);
        workspace.tree.dofs.tau[index] = change.dot(&workspace.tree.bodies.force[dof.body]);
    }
    gather(model, &workspace.tree.dofs.tau, gradient);
}

/// Writes Σ I V over each body's subtree to `tree.bodies.force`.
#[inline(always)]
fn collect_momenta<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, q: &[S], v: &[S]) {
    compute_columns(model, tree, q);
    compute_twists(model, tree, v);
    for (i, body) in model.bodies.iter().enumerate() {
        let inertia = inertia_in_world(body, &tree.world.pose[i]);
        tree.bodies.force[i] = momentum_of(&inertia, &tree.world.twist[i]);
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent != WORLD {
            let mut beyond = tree.bodies.force[i];
            pass_inward(body, &tree.world.levers, &mut beyond);
            tree.bodies.force[body.parent].add(&beyond);
        }
    }
}
