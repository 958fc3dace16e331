//! The first stage of every algorithm: each body's placement in its parent, from q.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use crate::Model;
use crate::joint::Position;
use crate::model::{Body, WORLD};
use crate::spatial::motion::MotionVector;
use crate::spatial::transform::Transform;
use crate::workspace::tree::{BodyBuffers, TreeMemory};

/// Writes `parent_from_body` of every body.
#[inline(always)]
pub fn place_bodies<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, q: &[S]) {
    evaluate_angles(model, tree, q);
    let n = model.bodies.len();
    let (bodies, angle) = (&model.bodies[..n], &tree.angles.angle[..n]);
    let (sine, cosine) = (&tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let place = &mut tree.bodies.place[..n];
    for i in 0..n {
        place[i] = place_body(&bodies[i], angle[i], sine[i], cosine[i], q);
    }
}

/// Positions of the one-DoF joints, with sines and cosines. Quaternion joints read q themselves; their entry
/// here is not used.
#[inline(always)]
pub fn evaluate_angles<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, q: &[N]) {
    // Public functions check the length of q; a kernel's own memory was allocated with the tree.
    debug_assert!(q.len() == model.nq, "q has {} entries, the model needs {}", q.len(), model.nq);
    if let Some(first) = model.first_angle {
        let angles = &q[first..];
        tree.angles.angle.copy_from_slice(angles);
        N::sin_cos_each(angles, &mut tree.angles.sine, &mut tree.angles.cosine);
        return;
    }
    for (angle, body) in tree.angles.angle.iter_mut().zip(&model.bodies) {
        *angle = q[body.q_index];
        if model.needs_dense_factor {
            let dof = &model.dofs[body.dof];
            *angle = angle.scale(dof.ratio) + N::from_f64(dof.offset);
        }
    }
    N::sin_cos_each(&tree.angles.angle, &mut tree.angles.sine, &mut tree.angles.cosine);
}

/// Writes `world_from_body` of one body and of its ancestors. With `LOCAL`, the placements are relative to
/// the body's reference point, which the function returns; otherwise it returns 0. Bodies that only slide
/// then have valid axes, but no valid position.
#[inline(always)]
pub fn place_chain<N: Scalar, const LOCAL: bool>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    q: &[N],
    tip: usize,
) -> V3<N> {
    evaluate_angles(model, tree, q);
    let n = model.bodies.len();
    let (bodies, chain) = (&model.bodies[..n], &mut tree.world.chain[..n]);
    let (angle, sine, cosine) = (&tree.angles.angle[..n], &tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let (world, levers) = (&mut tree.world.pose[..n], &mut tree.world.levers[..]);
    let (mut at, mut length) = (tip, 0);
    while at != WORLD {
        chain[length] = at;
        length += 1;
        at = bodies[at].parent;
    }
    let mut last = Transform { rotation: M3::zero(), translation: V3::zero() };
    let mut point = V3::zero();
    for &i in chain[..length].iter().rev() {
        let body = &bodies[i];
        let place = place_body(body, angle[i], sine[i], cosine[i], q);
        last = if body.parent == WORLD { place } else { last.compose(&place) };
        if LOCAL && body.is_point {
            levers[body.point] = last.translation;
            point += last.translation;
            last.translation = V3::zero();
        }
        world[i] = last;
    }
    point
}

/// Writes `world_from_body` of every body.
#[inline(always)]
pub fn place_all_in_world<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, q: &[N]) {
    evaluate_angles(model, tree, q);
    let n = model.bodies.len();
    let bodies = &model.bodies[..n];
    let (angle, sine, cosine) = (&tree.angles.angle[..n], &tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let world = &mut tree.world.pose[..n];
    if n == 0 {
        return;
    }
    // The previous body is mostly the parent. A local variable avoids a load from memory. Before the first,
    // see `compute_columns`.
    let mut last = world[0];
    for i in 0..n {
        let body = &bodies[i];
        let place = place_body(body, angle[i], sine[i], cosine[i], q);
        last = if body.parent == WORLD {
            place
        } else if body.parent + 1 == i {
            last.compose(&place)
        } else {
            world[body.parent].compose(&place)
        };
        world[i] = last;
    }
}

/// Writes `world_from_body` of every body after [`place_bodies`].
#[inline(always)]
pub fn places_in_world<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>) {
    let (place, world) = (&tree.bodies.place, &mut tree.world.pose);
    for (i, body) in model.bodies.iter().enumerate() {
        world[i] = if body.parent == WORLD { place[i] } else { world[body.parent].compose(&place[i]) };
    }
}

/// `parent_from_body` of one body.
#[inline(always)]
pub fn place_body<N: Scalar>(body: &Body, angle: N, sine: N, cosine: N, q: &[N]) -> Transform<N> {
    let rest =
        Transform { rotation: M3::constant(&body.rotation), translation: V3::constant(&body.translation) };
    body.motion.place(&rest, &Position { angle, sine, cosine, q, start: body.q_index })
}

/// Writes every body's velocity in its own frame, u of its origin and ω. It is the parent's, Rᵀ(u + ω × p)
/// and Rᵀω, plus the joint's. Call after [`place_bodies`].
#[inline(always)]
pub fn move_bodies<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, v: &[S]) {
    spread(model, v, &mut tree.dofs.v);
    let (rates, BodyBuffers { place, velocity, .. }) = (&tree.dofs.v[..], &mut tree.bodies);
    for (i, body) in model.bodies.iter().enumerate() {
        let parent = if body.parent == WORLD { MotionVector::zero() } else { velocity[body.parent] };
        velocity[i] = motion_in_body(&place[i], &parent);
        velocity[i].add(&body.motion.velocity(&rates[body.dof..]));
    }
}

/// The parent's motion at the body's origin, along the body's axes: Rᵀ(u + ω × p) and Rᵀω.
#[inline(always)]
pub fn motion_in_body<S: Scalar>(place: &Transform<S>, parent: &MotionVector<S>) -> MotionVector<S> {
    let carried = parent.linear + parent.angular.cross(place.translation);
    MotionVector {
        linear: place.rotation.transpose_mul(carried),
        angular: place.rotation.transpose_mul(parent.angular),
    }
}

/// Distributes v (or a) to the tree's DoFs; mimic joints move by their ratio.
#[inline(always)]
pub fn spread<N: Scalar>(model: &Model, from: &[N], tree: &mut [N]) {
    if model.needs_dense_factor {
        for (tree, dof) in tree.iter_mut().zip(&model.dofs) {
            *tree = from[dof.coordinate].scale(dof.ratio);
        }
    } else {
        tree.copy_from_slice(from);
    }
}

/// Gathers forces from the tree's DoFs: τ = Gᵀ τ_tree.
#[inline(always)]
pub fn gather<N: Scalar>(model: &Model, tree: &[N], to: &mut [N]) {
    if model.needs_dense_factor {
        to.fill(N::zero());
        for (tree, dof) in tree.iter().zip(&model.dofs) {
            to[dof.coordinate] += tree.scale(dof.ratio);
        }
    } else {
        to.copy_from_slice(tree);
    }
}
