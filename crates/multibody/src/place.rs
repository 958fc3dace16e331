//! The first stage of every algorithm: from q to each body's placement in its parent.

use dynamics::Scalar;

use crate::algebra::{M3, V3};
use crate::model::{Body, Motion, WORLD};
use crate::workspace::Place;
use crate::{Model, Workspace};

/// Panics with both numbers when a slice has the wrong length.
#[inline(always)]
#[track_caller]
pub(crate) fn check_length(name: &str, found: usize, expected: usize) {
    assert!(found == expected, "{name} has {found} entries, the model needs {expected}");
}

/// Writes `parent_from_body` of every body.
#[inline(always)]
pub(crate) fn place_bodies<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S]) {
    check_length("q", q.len(), model.nq);
    for (angle, body) in workspace.angle.iter_mut().zip(&model.bodies) {
        let dof = &model.dofs[body.dof];
        // Quaternion joints read q themselves; their entry here is a harmless number.
        *angle = q[body.q_index];
        if model.has_mimic {
            *angle = angle.scale(dof.ratio) + S::from_f64(dof.offset);
        }
    }
    S::sin_cos_each(&workspace.angle, &mut workspace.sine, &mut workspace.cosine);
    for (i, body) in model.bodies.iter().enumerate() {
        workspace.place[i] = place_body(body, workspace.angle[i], workspace.sine[i], workspace.cosine[i], q);
    }
}

/// Writes `world_from_body` of every body, from [`place_bodies`].
#[inline(always)]
pub(crate) fn place_in_world<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    for (i, body) in model.bodies.iter().enumerate() {
        let place = workspace.place[i];
        workspace.world[i] =
            if body.parent == WORLD { place } else { workspace.world[body.parent].then(&place) };
    }
}

#[inline(always)]
fn place_body<S: Scalar>(body: &Body, angle: S, sine: S, cosine: S, q: &[S]) -> Place<S> {
    let rotation = M3::from_f64(body.rotation.0);
    let translation = V3::from_f64(body.translation.0);
    match body.motion {
        Motion::Revolute => Place { rotation: turn_about_z(&rotation, sine, cosine), translation },
        Motion::Prismatic => {
            Place { rotation, translation: translation.add_scaled(angle, rotation.column(2)) }
        }
        Motion::Helical(pitch) => Place {
            rotation: turn_about_z(&rotation, sine, cosine),
            translation: translation.add_scaled(angle.scale(pitch), rotation.column(2)),
        },
        Motion::Spherical => {
            let i = body.q_index;
            Place { rotation: rotation.times(&rotation_of(&q[i..i + 4])), translation }
        }
        Motion::Floating => {
            let i = body.q_index;
            Place {
                rotation: rotation.times(&rotation_of(&q[i + 3..i + 7])),
                translation: translation + rotation * V3([q[i], q[i + 1], q[i + 2]]),
            }
        }
    }
}

/// P Rz(q): only two columns change.
#[inline(always)]
fn turn_about_z<S: Scalar>(p: &M3<S>, sine: S, cosine: S) -> M3<S> {
    M3(p.0.map(|[x, y, z]| [cosine.mul_add(x, sine * y), cosine.mul_add(y, -(sine * x)), z]))
}

/// R of the quaternion (x y z w). It is divided by |q|², so that q need not be of unit length and the
/// derivative along |q| vanishes. **(RBDA eq. 4.13)**
#[inline(always)]
pub(crate) fn rotation_of<S: Scalar>(xyzw: &[S]) -> M3<S> {
    let [x, y, z, w] = [xyzw[0], xyzw[1], xyzw[2], xyzw[3]];
    let two = S::from_f64(2.0) / (x * x + y * y + z * z + w * w);
    let one = S::one();
    M3([
        [one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)],
        [two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)],
        [two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)],
    ])
}

/// Spreads v (or a) over the tree's freedoms: followers move by their ratio.
#[inline(always)]
pub(crate) fn spread<S: Scalar>(model: &Model, from: &[S], tree: &mut [S]) {
    if model.has_mimic {
        for (tree, dof) in tree.iter_mut().zip(&model.dofs) {
            *tree = from[dof.coordinate].scale(dof.ratio);
        }
    } else {
        tree.copy_from_slice(from);
    }
}

/// Gathers forces from the tree's freedoms: τ = Gᵀ τ_tree.
#[inline(always)]
pub(crate) fn gather<S: Scalar>(model: &Model, tree: &[S], to: &mut [S]) {
    if model.has_mimic {
        to.fill(S::zero());
        for (tree, dof) in tree.iter().zip(&model.dofs) {
            to[dof.coordinate] += tree.scale(dof.ratio);
        }
    } else {
        to.copy_from_slice(tree);
    }
}
