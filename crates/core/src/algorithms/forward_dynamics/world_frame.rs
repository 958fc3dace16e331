//! The articulated-body algorithm in one inertial frame ([`world_frame`](crate::kinematics::world_frame)).
//! **(RBDA §7.3)**

#![allow(non_snake_case)] // the book's U and Iᴬ

use robot_dynamics_number::algebra::{M3, Sym3, V3};
use robot_dynamics_number::{Scalar, View};

use super::spring::less_spring;
use crate::Model;
use crate::kinematics::shifts::pass_outward;
use crate::kinematics::world_frame::{
    compute_columns, compute_twists, force_cross, inertia_in_world, momentum_of, motion_cross,
};
use crate::kinematics::wrench::{FrameWrench, subtract_wrenches};
use crate::model::WORLD;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::{DofElimination, SpatialInertia};
use crate::spatial::motion::MotionVector;
use crate::workspace::tree::TreeMemory;

/// Replaces τ in `tree.dofs` by a.
#[inline(always)]
pub(crate) fn accelerate<S: Scalar, N: View<S>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    q: &[N],
    v: &[N],
    wrenches: &[FrameWrench<S>],
) {
    compute_columns(model, tree, q);
    compute_twists(model, tree, v);
    free_bodies(model, tree);
    subtract_in_world(model, tree, wrenches);
    eliminate_dofs(model, tree);
    accelerate_dofs(model, tree);
}

/// Initializes each body: its inertia and its bias force V ×\* I V. Writes to `twist_rate` the acceleration
/// V × S v due to its joint's motion at q̈ = 0.
#[inline(always)]
fn free_bodies<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, world, twists) = (&model.bodies[..n], &tree.world.pose[..n], &tree.world.twist[..n]);
    let (rates, columns) = (&tree.dofs.v[..], &tree.world.column[..]);
    let (twist_rates, articulated) = (&mut tree.world.twist_rate[..n], &mut tree.inertias.articulated[..n]);
    for i in 0..n {
        let (body, twist) = (&bodies[i], &twists[i]);
        let mut joint = MotionVector::zero();
        for dof in body.dof..body.dof + body.motion.nv() {
            joint.add_scaled(rates[dof], &columns[dof]);
        }
        twist_rates[i] = motion_cross(twist, &joint);
        let inertia = inertia_in_world(body, &world[i]);
        let momentum = momentum_of(&inertia, twist);
        let SpatialInertia { mass, first_moment, inertia } = inertia;
        let own = &mut articulated[i];
        own.mass = Sym3::multiple_of_identity(mass);
        own.coupling = M3::skew(-first_moment);
        if M3::<S>::KEEPS_TRANSPOSE {
            own.coupling_back = M3::skew(first_moment);
        }
        own.inertia = inertia;
        own.bias = force_cross(twist, &momentum);
    }
}

/// Subtracts external wrenches from the bias forces.
#[inline(always)]
fn subtract_in_world<S: Scalar, N: View<S>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    wrenches: &[FrameWrench<S>],
) {
    if wrenches.is_empty() {
        return;
    }
    tree.bodies.force.fill(ForceVector::zero());
    subtract_wrenches(model, &mut tree.bodies.force, wrenches);
    for ((articulated, force), place) in
        tree.inertias.articulated.iter_mut().zip(&tree.bodies.force).zip(&tree.world.pose)
    {
        articulated.bias.add(&place.force_in_parent(force));
    }
}

/// The inward pass: each DoF's [`DofElimination`], and each body's contribution to its parent.
#[inline(always)]
fn eliminate_dofs<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, twist_rates, angle) =
        (&model.bodies[..n], &tree.world.twist_rate[..n], &tree.angles.angle[..n]);
    let (tau, columns, pivots) = (&tree.dofs.tau[..], &tree.world.column[..], &mut tree.inertias.pivot[..]);
    let (all, levers) = (&mut tree.inertias.articulated[..n], &tree.world.levers[..]);
    for i in (0..n).rev() {
        let body = &bodies[i];
        let mut IA = all[i];
        // pᴬ + Iᴬ c: the bias including the velocity-dependent acceleration.
        let pushed = IA.times(&twist_rates[i]);
        IA.bias.add(&pushed);
        for index in (body.dof..body.dof + body.motion.nv()).rev() {
            let dof = &model.dofs[index];
            let force = less_spring(model, index, tau[index], angle[i]);
            let armature = S::from_f64(dof.passive.armature);
            let (pivot, U, inverse) = IA.pivot(&columns[index], force, armature);
            let last = index == body.dof;
            if last && body.parent != WORLD {
                // Vector registers form the sum while the division is pending. Independent divisions overlap
                // too.
                if body.shifts_reference_point {
                    IA.eliminate(&pivot, &U, inverse);
                    IA.shift(levers[body.point]);
                    all[body.parent].add(&IA);
                } else if M3::<S>::KEEPS_TRANSPOSE {
                    IA.add(&all[body.parent]);
                    IA.eliminate(&pivot, &U, inverse);
                    all[body.parent] = IA;
                } else {
                    IA.eliminate(&pivot, &U, inverse);
                    all[body.parent].add(&IA);
                }
            } else if !last {
                IA.eliminate(&pivot, &U, inverse);
            }
            pivots[index] = pivot;
        }
    }
}

/// The outward pass: q̈ = (u − Uᵀa)/d, and each body's acceleration in `twist_rate`.
#[inline(always)]
fn accelerate_dofs<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let ground = MotionVector { linear: V3::from_f64(model.gravity().map(|g| -g)), angular: V3::zero() };
    let n = model.bodies.len();
    let (bodies, twist_rates) = (&model.bodies[..n], &mut tree.world.twist_rate[..n]);
    let (pivots, columns, accelerations) =
        (&tree.inertias.pivot[..], &tree.world.column[..], &mut tree.dofs.a[..]);
    let levers = &tree.world.levers[..];
    let mut last = ground;
    for i in 0..n {
        let body = &bodies[i];
        if body.parent == WORLD {
            last = ground;
        } else if body.parent + 1 != i {
            last = twist_rates[body.parent];
        }
        pass_outward(body, levers, &mut last);
        // V̇ = V̇_parent + c + S q̈. Adding c first shortens the chain of dependent operations.
        let mut own = twist_rates[i];
        if M3::<S>::KEEPS_TRANSPOSE {
            own.add(&last);
        }
        for index in body.dof..body.dof + body.motion.nv() {
            let DofElimination { column: U_by_d, residual: u_by_d, .. } = &pivots[index];
            let a = *u_by_d - U_by_d.dot(&last);
            accelerations[index] = a;
            last.add_scaled(a, &columns[index]);
            if M3::<S>::KEEPS_TRANSPOSE {
                own.add_scaled(a, &columns[index]);
            }
        }
        if !M3::<S>::KEEPS_TRANSPOSE {
            own.add(&last);
        }
        twist_rates[i] = own;
        last = own;
    }
}
