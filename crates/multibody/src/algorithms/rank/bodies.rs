//! Bodies along the world's axes, each about its own origin.

use dynamics::Scalar;
use number::View;

use crate::Model;
use crate::model::WORLD;
use crate::scratch::extent::Scratch;
use crate::scratch::tree::TreeMemory;
use crate::spatial::algebra::{M3, Sym3, V3};
use crate::spatial::screw::{Articulated, Force, Place, Screw};
use crate::stages::place::{evaluate_angles, place_body};

/// q → each freedom's motion in `column`, each body's inertia in `articulated`, and in `world` its rotation with p, the
/// way from its parent's origin to its own.
#[inline(always)]
pub(super) fn place<N: View<f64>>(model: &Model, tree: &mut TreeMemory<N>, scratch: &mut Scratch, q: &[N]) {
    evaluate_angles(model, tree, q);
    let n = model.bodies.len();
    let bodies = &model.bodies[..n];
    let (angle, sine, cosine) = (&tree.angles.angle[..n], &tree.angles.sine[..n], &tree.angles.cosine[..n]);
    let (world, columns) = (&mut tree.screws.world[..n], &mut tree.screws.column[..]);
    let articulated = &mut tree.inertias.articulated[..n];
    let distance = &mut scratch.distance[..n];
    for i in 0..n {
        let body = &bodies[i];
        let local = place_body(body, angle[i], sine[i], cosine[i], q);
        let placed = if body.parent == WORLD {
            Place { rotation: local.rotation, translation: V3::zero() }
        } else {
            let carrier = &world[body.parent].rotation;
            distance[i] = local.translation.dot(local.translation).value().sqrt();
            Place { rotation: carrier.times(&local.rotation), translation: *carrier * local.translation }
        };
        let about_origin = Place { rotation: placed.rotation, translation: V3::zero() };
        for k in 0..body.motion.nv() {
            columns[body.dof + k] = body.motion.screw(k, &about_origin);
        }
        let own = &mut articulated[i];
        own.mass = Sym3::multiple_of_identity(N::from_f64(body.mass));
        own.coupling = M3::skew(-(placed.rotation * V3::constant(&body.first_moment)));
        own.inertia = Sym3::constant(&body.inertia).rotated(&placed.rotation);
        world[i] = placed;
    }
}

/// I s: the force that a motion s about the body's origin takes.
#[inline(always)]
pub(super) fn response<S: Scalar>(inertia: &Articulated<S>, s: &Screw<S>) -> Force<S> {
    Force {
        linear: inertia.mass * s.linear + inertia.coupling * s.angular,
        angular: inertia.coupling.transpose_mul(s.linear) + inertia.inertia * s.angular,
    }
}

/// Adds a child's inertia to its parent's, about the parent's origin:
/// H′ = H − M\[p\], I′ = I + G + Gᵀ with G = ½\[p\](H + H′). **(RBDA §2.13)**
#[inline(always)]
pub(super) fn add_shifted<S: Scalar>(parent: &mut Articulated<S>, child: &Articulated<S>, p: V3<S>) {
    let coupling = child.coupling - child.mass.full().times(&M3::skew(p));
    let moved = M3::skew(p * S::from_f64(0.5)).times(&(child.coupling + coupling));
    parent.mass = parent.mass + child.mass;
    parent.coupling = parent.coupling + coupling;
    parent.inertia = parent.inertia + child.inertia + Sym3::from_columns(&(moved + moved.transpose()));
}
