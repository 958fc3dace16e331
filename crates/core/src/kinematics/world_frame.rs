//! Every DoF as a motion in one inertial frame.
//!
//! The frame has the world's axes, and its origin is a reference point (module `model::reference_point`) that
//! moves with the robot. The DoFs' motions (u, ω) can be added and compared without rotations. The accuracy
//! does not suffer when the robot is far from the world's origin. For a DoF with axes fixed in its body,
//! which moves with V: Ṡ = V × S. **(RBDA §2.9, §3.5)**

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Sym3, V3};

use crate::Model;
use crate::kinematics::placement::{evaluate_angles, place_body, spread};
use crate::kinematics::shifts::{pass_inertia, pass_outward};
use crate::model::{Body, WORLD};
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::SpatialInertia;
use crate::spatial::motion::MotionVector;
use crate::spatial::transform::Transform;
use crate::workspace::tree::TreeMemory;

/// Reads q; writes placements in the inertial frame, the DoFs' motions `tree.world.column`, and the
/// reference points `tree.world.points`.
#[inline(always)]
pub fn compute_columns<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, q: &[N]) {
    evaluate_angles(model, tree, q);
    let n = model.bodies.len();
    let bodies = &model.bodies[..n];
    let (angle, sine, cosine) = (&tree.angles.angle[..n], &tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let (world, columns) = (&mut tree.world.pose[..n], &mut tree.world.column[..]);
    let (points, levers) = (&mut tree.world.points[..], &mut tree.world.levers[..]);
    if n == 0 {
        return;
    }
    // The previous body is mostly the parent. A local variable avoids a load from memory. Its value before
    // the first body is not read; a constant there makes compilers peel the first iteration, which costs
    // registers.
    let mut last = world[0];
    for i in 0..n {
        let body = &bodies[i];
        let place = place_body(body, angle[i], sine[i], cosine[i], q);
        last = if body.is_point {
            let mut at = place;
            if body.parent != WORLD {
                at = world[body.parent].compose(&place);
                levers[body.point] = at.translation;
                let parent = &bodies[body.parent];
                if !body.shifts_reference_point || parent.point != parent.tree {
                    at.translation += points[parent.point];
                }
            }
            points[body.point] = at.translation;
            Transform { translation: V3::zero(), ..at }
        } else if body.parent == WORLD {
            Transform { translation: place.translation - points[body.point], ..place }
        } else if body.parent + 1 == i {
            last.compose(&place)
        } else {
            world[body.parent].compose(&place)
        };
        world[i] = last;
        if body.motion.nv() == 1 {
            columns[body.dof] = body.motion.screw(0, &last);
        } else {
            // From memory, because the axis is not a constant.
            for k in 0..body.motion.nv() {
                columns[body.dof + k] = body.motion.screw(k, &world[i]);
            }
        }
    }
}

/// Writes each body's velocity V = Σ S v over its ancestors' DoFs and its own. Call after
/// [`compute_columns`].
#[inline(always)]
pub fn compute_twists<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, v: &[N]) {
    spread(model, v, &mut tree.dofs.v);
    let n = model.bodies.len();
    let (bodies, twists) = (&model.bodies[..n], &mut tree.world.twist[..n]);
    let (rates, columns, levers) = (&tree.dofs.v[..], &tree.world.column[..], &tree.world.levers[..]);
    let mut last = MotionVector::zero();
    for i in 0..n {
        let body = &bodies[i];
        if body.parent == WORLD {
            last = MotionVector::zero();
        } else if body.parent + 1 != i {
            last = twists[body.parent];
        }
        pass_outward(body, levers, &mut last);
        for dof in body.dof..body.dof + body.motion.nv() {
            last.add_scaled(rates[dof], &columns[dof]);
        }
        twists[i] = last;
    }
}

/// Ṡ = V × S of every DoF. Call after [`compute_twists`].
#[inline(always)]
pub fn compute_column_rates<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    for (body, twist) in model.bodies.iter().zip(&tree.world.twist) {
        for dof in body.dof..body.dof + body.motion.nv() {
            tree.world.column_rate[dof] = motion_cross(twist, &tree.world.column[dof]);
        }
    }
}

/// V̇ = Σ Ṡ v + S a of every body, without gravity; `None` means a = 0. Call after [`compute_column_rates`].
#[inline(always)]
pub fn compute_twist_rates<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, a: Option<&[S]>) {
    match a {
        Some(a) => {
            spread(model, a, &mut tree.dofs.a);
        }
        None => tree.dofs.a.fill(S::zero()),
    }
    for (i, body) in model.bodies.iter().enumerate() {
        let mut rate =
            if body.parent == WORLD { MotionVector::zero() } else { tree.world.twist_rate[body.parent] };
        pass_outward(body, &tree.world.levers, &mut rate);
        for dof in body.dof..body.dof + body.motion.nv() {
            rate.add_scaled(tree.dofs.v[dof], &tree.world.column_rate[dof]);
            rate.add_scaled(tree.dofs.a[dof], &tree.world.column[dof]);
        }
        tree.world.twist_rate[i] = rate;
    }
}

/// The same motion with the linear part of the point p: u + ω × p. A spatial acceleration shifts in the same
/// way.
#[inline(always)]
pub fn shifted<S: Scalar>(twist: &MotionVector<S>, point: V3<S>) -> MotionVector<S> {
    MotionVector { linear: twist.linear + twist.angular.cross(point), angular: twist.angular }
}

/// V × S = (ω × s + u × σ, ω × σ): the rate of a motion S that moves with V. **(RBDA eq. 2.31)**
#[inline(always)]
pub fn motion_cross<S: Scalar>(v: &MotionVector<S>, s: &MotionVector<S>) -> MotionVector<S> {
    MotionVector {
        linear: v.angular.cross(s.linear) + v.linear.cross(s.angular),
        angular: v.angular.cross(s.angular),
    }
}

/// V ×* F = (ω × f, ω × n + u × f): the rate of a force (or momentum) that moves with V. **(RBDA eq. 2.32)**
#[inline(always)]
pub fn force_cross<S: Scalar>(v: &MotionVector<S>, force: &ForceVector<S>) -> ForceVector<S> {
    ForceVector {
        linear: v.angular.cross(force.linear),
        angular: v.angular.cross(force.angular) + v.linear.cross(force.linear),
    }
}

/// I V = (m u + ω × h, h × u + I ω): momentum about the frame's origin.
#[inline(always)]
pub fn momentum_of<S: Scalar>(composite: &SpatialInertia<S>, v: &MotionVector<S>) -> ForceVector<S> {
    let h = composite.first_moment;
    ForceVector {
        linear: v.angular.cross(h).add_scaled(composite.mass, v.linear),
        angular: composite.inertia * v.angular + h.cross(v.linear),
    }
}

/// One body's inertia in the inertial frame, by the parallel-axis theorem twice: from the body's origin to
/// the centre of mass, and on to the frame's origin. **(RBDA §2.13)**
///
/// h′ = R h + m p, I′ = R I Rᵀ + 2(p·g)1 − (p gᵀ + g pᵀ) with g = R h + ½ m p.
#[inline(always)]
pub fn inertia_in_world<S: Scalar>(body: &Body, place: &Transform<S>) -> SpatialInertia<S> {
    let mass = S::from_f64(body.mass);
    let p = place.translation;
    let turned = place.rotation * V3::constant(&body.first_moment);
    let g = turned.add_scaled(S::from_f64(0.5 * body.mass), p);
    let inertia = (place.rotation.times(&M3::constant(&body.inertia)))
        .times_transpose(&place.rotation)
        .minus_outer(p, g)
        .minus_outer(g, p);
    SpatialInertia {
        mass,
        first_moment: turned.add_scaled(mass, p),
        inertia: Sym3::from_columns(&inertia).plus_multiple_of_identity(p.dot(g).scale(2.0)),
    }
}

/// The inertia of each body's subtree, in the inertial frame. For bodies that only slide, only the mass is
/// valid.
#[inline(always)]
pub fn composites_in_world<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, world) = (&model.bodies[..n], &tree.world.pose[..n]);
    let (composites, levers) = (&mut tree.inertias.composite[..n], &tree.world.levers[..]);
    for i in 0..n {
        composites[i] = inertia_in_world(&bodies[i], &world[i]);
    }
    for i in (0..n).rev() {
        let mut child = composites[i];
        pass_inertia(&bodies[i], levers, &mut child);
        let parent = bodies[i].parent;
        if parent != WORLD {
            add_composite(&mut composites[parent], &child);
        }
    }
}

/// to ← to + part.
#[inline(always)]
pub fn add_composite<S: Scalar>(to: &mut SpatialInertia<S>, part: &SpatialInertia<S>) {
    to.mass += part.mass;
    to.first_moment += part.first_moment;
    to.inertia = to.inertia + part.inertia;
}
