//! The mass matrix by the composite-rigid-body algorithm.
//!
//! The bodies beyond a joint move as one rigid body when that joint alone accelerates; the force it takes,
//! F = I^c s, felt by each joint on the way to the root, is that joint's column of M. **(RBDA §6.2)**

use dynamics::Scalar;

use crate::algebra::{Sym3, V3};
use crate::model::{Motion, WORLD};
use crate::place::{check_length, place_bodies};
use crate::workspace::{Composite, Force, Place};
use crate::{Model, Workspace};

/// M(q), nv×nv symmetric, row-major, both triangles; K = ½ vᵀM v. Armature counts on the diagonal.
/// **(RBDA §6.2)**
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "CRBA")]
#[inline]
pub fn mass_matrix<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], mass: &mut [S]) {
    check_length("the mass matrix", mass.len(), model.nv * model.nv);
    place_bodies(model, workspace, q);
    composite_inertias(model, workspace);
    mass.fill(S::zero());
    let nv = model.nv;
    for (i, body) in model.bodies.iter().enumerate() {
        for k in 0..body.motion.nv() {
            let dof = body.dof + k;
            let mut force = composite_force(body.motion, k, &workspace.composite[i]);
            // M is symmetric: the freedoms of this body up to k, then every ancestor's.
            let mut at = i;
            let mut row = k + 1;
            loop {
                let ancestor = &model.bodies[at];
                for other in 0..row {
                    let entry = force_along(ancestor.motion, other, &force);
                    add_entry(model, mass, nv, dof, ancestor.dof + other, entry);
                }
                if ancestor.parent == WORLD {
                    break;
                }
                force = force_in_parent(&workspace.place[at], &force);
                at = ancestor.parent;
                row = model.bodies[at].motion.nv();
            }
        }
    }
    if model.has_armature {
        for dof in &model.dofs {
            mass[dof.coordinate * (nv + 1)] += S::from_f64(dof.passive.armature * dof.ratio * dof.ratio);
        }
    }
}

/// Adds a tree entry M_{i j} (and its mirror image) to the reduced matrix GᵀMG.
#[inline(always)]
fn add_entry<S: Scalar>(model: &Model, mass: &mut [S], nv: usize, i: usize, j: usize, entry: S) {
    if !model.has_mimic {
        mass[i * nv + j] = entry;
        mass[j * nv + i] = entry;
        return;
    }
    let (a, b) = (&model.dofs[i], &model.dofs[j]);
    let entry = entry.scale(a.ratio * b.ratio);
    mass[a.coordinate * nv + b.coordinate] += entry;
    if i != j {
        mass[b.coordinate * nv + a.coordinate] += entry;
    }
}

/// Each body's inertia with everything that hangs on it, in the body's frame.
#[inline(always)]
pub(crate) fn composite_inertias<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = Composite {
            mass: S::from_f64(body.mass),
            first_moment: V3::from_f64(body.first_moment.0),
            inertia: Sym3::from_f64(body.inertia.0),
        };
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        if body.parent != WORLD {
            let moved = composite_in_parent(&workspace.place[i], &workspace.composite[i]);
            let parent = &mut workspace.composite[body.parent];
            parent.mass += moved.mass;
            parent.first_moment += moved.first_moment;
            parent.inertia = parent.inertia + moved.inertia;
        }
    }
}

/// m, h′ = R h + m p, I′ = R I Rᵀ + 2(p·g)1 − (p gᵀ + g pᵀ) with g = R h + ½ m p: the parallel-axis
/// theorem twice, from the origin to the centre of mass and on to the parent's origin. **(RBDA §2.13)**
#[inline(always)]
pub(crate) fn composite_in_parent<S: Scalar>(place: &Place<S>, composite: &Composite<S>) -> Composite<S> {
    let p = place.translation;
    let turned = place.rotation * composite.first_moment;
    let g = turned.add_scaled(composite.mass.scale(0.5), p);
    let [px, py, pz] = p.0;
    let [gx, gy, gz] = g.0;
    let (xx, yy, zz) = (px * gx, py * gy, pz * gz);
    let shift = Sym3([
        (yy + zz).scale(2.0),
        -(px * gy + gx * py),
        -(px * gz + gx * pz),
        (xx + zz).scale(2.0),
        -(py * gz + gy * pz),
        (xx + yy).scale(2.0),
    ]);
    Composite {
        mass: composite.mass,
        first_moment: turned.add_scaled(composite.mass, p),
        inertia: composite.inertia.rotated(&place.rotation) + shift,
    }
}

/// I^c s: the force and moment about the body's origin that a unit acceleration of freedom k takes.
#[inline(always)]
pub(crate) fn composite_force<S: Scalar>(motion: Motion, k: usize, composite: &Composite<S>) -> Force<S> {
    let h = composite.first_moment;
    let [hx, hy, hz] = h.0;
    let o = S::zero();
    let inertia = composite.inertia.full();
    // About x, y, z: F = e × h, N = I e. Along x, y, z: F = m e, N = h × e.
    let about = |axis: usize| Force {
        linear: V3([[o, -hz, hy], [hz, o, -hx], [-hy, hx, o]][axis]),
        angular: inertia.row(axis),
    };
    let along = |axis: usize| {
        let mut linear = V3::zero();
        linear.0[axis] = composite.mass;
        Force { linear, angular: V3([[o, hz, -hy], [-hz, o, hx], [hy, -hx, o]][axis]) }
    };
    match motion {
        Motion::Revolute => about(2),
        Motion::Prismatic => along(2),
        Motion::Helical(pitch) => {
            let (turn, slide) = (about(2), along(2));
            let pitch = S::from_f64(pitch);
            Force {
                linear: turn.linear.add_scaled(pitch, slide.linear),
                angular: turn.angular.add_scaled(pitch, slide.angular),
            }
        }
        Motion::Spherical => about(k),
        Motion::Floating if k < 3 => along(k),
        Motion::Floating => about(k - 3),
    }
}

/// sₖᵀ F for freedom k of a body, F in the body's frame.
#[inline(always)]
pub(crate) fn force_along<S: Scalar>(motion: Motion, k: usize, force: &Force<S>) -> S {
    match motion {
        Motion::Revolute => force.angular.0[2],
        Motion::Prismatic => force.linear.0[2],
        Motion::Helical(pitch) => force.linear.0[2].scale(pitch) + force.angular.0[2],
        Motion::Spherical => force.angular.0[k],
        Motion::Floating if k < 3 => force.linear.0[k],
        Motion::Floating => force.angular.0[k - 3],
    }
}

/// The same force, about the parent's origin in the parent's frame.
#[inline(always)]
pub(crate) fn force_in_parent<S: Scalar>(place: &Place<S>, force: &Force<S>) -> Force<S> {
    let linear = place.rotation * force.linear;
    Force { linear, angular: place.rotation * force.angular + place.translation.cross(linear) }
}
