//! Momentum and the slope of the kinetic energy, in one sweep out and one in.

use crate::algorithms::mass_matrix::force_in_parent;
use crate::model::WORLD;
use crate::scratch::tree::{InBodies, PerFreedom, TreeMemory};
use crate::spatial::algebra::{Sym3, V3};
use crate::spatial::screw::{Force, Screw};
use crate::stages::place::{gather, move_bodies, place_bodies};
use crate::{Model, Workspace};

/// p = M(q) v and ∂K/∂q at constant v, along the freedoms' own directions, in O(n).
///
/// Outward, each body's velocity (u, ω) in its own frame. Inward, the momentum H of everything beyond a
/// joint. A joint of freedoms s has p = sᵀH. Moving the joint by δ turns the velocity w that its parent
/// passes on by −δ s × w, so ∂K/∂q = H·(w × s) = −sᵀ(w ×\* H), with (u,ω) ×\* (f,n) = (ω×f, ω×n + u×f).
/// **(RBDA §2.9)** For quaternion joints this is the derivative along q ⊕ δ.
pub(super) fn momentum_and_slope(
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
        bodies: InBodies { place, velocity, force, .. },
        freedoms: PerFreedom { v, a, tau },
        ..
    } = tree;
    for (i, body) in model.bodies.iter().enumerate() {
        let Screw { linear: u, angular: w } = velocity[i];
        let h = V3::constant(&body.first_moment);
        force[i] = Force {
            linear: u * body.mass + w.cross(h),
            angular: h.cross(u) + Sym3::constant(&body.inertia) * w,
        };
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let h = force[i];
        // What the parent passes on.
        let joint = body.motion.velocity(&v[body.dof..]);
        let (u, w) = (velocity[i].linear - joint.linear, velocity[i].angular - joint.angular);
        let turned = Force { linear: w.cross(h.linear), angular: w.cross(h.angular) + u.cross(h.linear) };
        for k in 0..body.motion.nv() {
            let dof = body.dof + k;
            let armature = model.dofs[dof].passive.armature;
            tau[dof] = body.motion.force_along(k, &h) + armature * v[dof];
            a[dof] = -body.motion.force_along(k, &turned);
        }
        if body.parent != WORLD {
            let passed = force_in_parent(&place[i], &h);
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
    use super::*;
    use crate::{Base, RandomRobotOptions, kinetic_energy_gradient, random_robot, random_state};

    /// Against the sweeps in world axes, on trees of every joint with followers, armature and tendons.
    /// Entries reach 1e3: 1e-11 is 1e-14 of that, some fifty roundings.
    #[test]
    fn one_sweep_gives_what_two_give() {
        let options =
            RandomRobotOptions { base: Base::Floating, mimic: 0.3, tendons: 2, ..Default::default() };
        for seed in 0..50 {
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let state = random_state(&model, &mut dynamics::SplitMix64::new(seed));
            let mut workspace = Workspace::new(&model);
            let [mut p, mut slope, mut expected] = [(); 3].map(|()| vec![0.0; model.nv()]);
            momentum_and_slope(&model, &mut workspace, &state.q, &state.v, &mut p, &mut slope);
            let largest_difference =
                |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            crate::momentum(&model, &mut workspace, &state.q, &state.v, &mut expected);
            let defect = largest_difference(&p, &expected);
            assert!(defect < 1e-11, "robot {seed}: momentum differs by {defect:e}");
            kinetic_energy_gradient(&model, &mut workspace, &state.q, &state.v, &mut expected);
            let defect = largest_difference(&slope, &expected);
            assert!(defect < 1e-11, "robot {seed}: slope differs by {defect:e}");
        }
    }
}
