//! Momentum and the gradient of the kinetic energy, in one outward and one inward recursion.

use robot_dynamics_core::kinematics::placement::{gather, move_bodies, place_bodies};
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::spatial::force::ForceVector;
use robot_dynamics_core::spatial::motion::MotionVector;
use robot_dynamics_core::workspace::tree::{BodyBuffers, DofBuffers, TreeMemory};
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_number::algebra::{Sym3, V3};

/// p = M(q) v and ∂K/∂q at constant v, along the joints' own directions, in O(n).
///
/// The outward recursion computes each body's velocity (u, ω) in its own frame. The inward recursion computes
/// the momentum H of the subtree of a joint. A joint with motion subspace s has p = sᵀH. A displacement δ of
/// the joint changes the velocity w from its parent by −δ s × w. Therefore ∂K/∂q = H·(w × s) = −sᵀ(w ×\* H),
/// with (u,ω) ×\* (f,n) = (ω×f, ω×n + u×f). **(RBDA §2.9)** For quaternion joints this is the derivative
/// along q ⊕ δ.
pub(super) fn momentum_and_kinetic_gradient(
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    v: &[f64],
    momentum: &mut [f64],
    slope: &mut [f64],
) {
    let tree = &mut workspace.tree;
    place_bodies(model, tree, q);
    move_bodies(model, tree, v);
    let TreeMemory {
        bodies: BodyBuffers { place, velocity, force, .. }, dofs: DofBuffers { v, a, tau }, ..
    } = tree;
    for (i, body) in model.bodies.iter().enumerate() {
        let MotionVector { linear: u, angular: w } = velocity[i];
        let h = V3::constant(&body.first_moment);
        force[i] = ForceVector {
            linear: u * body.mass + w.cross(h),
            angular: h.cross(u) + Sym3::constant(&body.inertia) * w,
        };
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let h = force[i];
        // The velocity from the parent.
        let joint = body.motion.velocity(&v[body.dof..]);
        let (u, w) = (velocity[i].linear - joint.linear, velocity[i].angular - joint.angular);
        let turned =
            ForceVector { linear: w.cross(h.linear), angular: w.cross(h.angular) + u.cross(h.linear) };
        for k in 0..body.motion.nv() {
            let dof = body.dof + k;
            let armature = model.dofs[dof].passive.armature;
            tau[dof] = body.motion.force_along(k, &h) + armature * v[dof];
            a[dof] = -body.motion.force_along(k, &turned);
        }
        if body.parent != WORLD {
            let passed = place[i].force_in_parent(&h);
            let parent = &mut force[body.parent];
            parent.linear += passed.linear;
            parent.angular += passed.angular;
        }
    }
    for rotor in &model.rotors {
        rotor.add_force(v, tau);
    }
    gather(model, tau, momentum);
    gather(model, a, slope);
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::{kinetic_energy_gradient, random_state};
    use robot_dynamics_description::{Base, RandomRobotOptions, random_robot};

    use super::*;

    /// Compares with recursions in world axes, on trees with every joint type, mimic joints, armature and
    /// tendons. Entries reach 1e3, so 1e-11 is a relative error of 1e-14, or about fifty roundings.
    #[test]
    fn one_sweep_gives_what_two_give() {
        let options =
            RandomRobotOptions { base: Base::Floating, mimic: 0.3, tendons: 2, ..Default::default() };
        for seed in 0..50 {
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let state = random_state(&model, &mut robot_dynamics_number::SplitMix64::new(seed));
            let mut workspace = Workspace::new(&model);
            let [mut p, mut slope, mut expected] = [(); 3].map(|()| vec![0.0; model.nv()]);
            momentum_and_kinetic_gradient(&model, &mut workspace, &state.q, &state.v, &mut p, &mut slope);
            let largest_difference =
                |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            robot_dynamics_core::momentum(&model, &mut workspace, &state.q, &state.v, &mut expected);
            let defect = largest_difference(&p, &expected);
            assert!(defect < 1e-11, "robot {seed}: momentum differs by {defect:e}");
            kinetic_energy_gradient(&model, &mut workspace, &state.q, &state.v, &mut expected);
            let defect = largest_difference(&slope, &expected);
            assert!(defect < 1e-11, "robot {seed}: slope differs by {defect:e}");
        }
    }
}
