//! The pivots of a tree, DoF by DoF from the leaves to the root.

use robot_dynamics_number::View;
use robot_dynamics_number::dispatch::{Hardware, Kernel};

use super::bodies::{add_shifted, place, response};
use super::vanished_pivot::{VanishedPivot, is_clear, vanishes};
use crate::Model;
use crate::kinematics::world_frame::shifted;
use crate::model::WORLD;
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::DofElimination;
use crate::workspace::compiled_once::run_on_machine;
use crate::workspace::extent::RankBuffers;
use crate::workspace::tree::{TreeMemory, TreeStorage};

/// The arguments of the elimination.
struct Elimination<'a> {
    model: &'a Model,
    scratch: &'a mut RankBuffers,
    q: &'a [f64],
    bound: f64,
    on_vanished: &'a mut dyn FnMut(&VanishedPivot<'_>),
}

/// Calls `on_vanished` for the pivots of M(q) that vanish.
pub(super) fn eliminate(
    model: &Model,
    tree: &mut TreeMemory<f64>,
    scratch: &mut RankBuffers,
    q: &[f64],
    bound: f64,
    on_vanished: &mut dyn FnMut(&VanishedPivot<'_>),
) {
    run_on_machine(tree, &mut Some(Elimination { model, scratch, q, bound, on_vanished }));
}

impl Kernel<TreeStorage, f64> for Elimination<'_> {
    #[inline(always)]
    fn run<N: View<f64>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, scratch, q, bound, on_vanished } = self;
        place(model, tree, scratch, N::view(q));
        scratch.extent.copy_from_slice(&scratch.own);
        for i in (0..model.bodies.len()).rev() {
            let body = &model.bodies[i];
            let mut inertia = tree.inertias.articulated[i];
            for index in (body.dof..body.dof + body.motion.nv()).rev() {
                let s = tree.world.column[index];
                let armature = model.dofs[index].passive.armature;
                let size = scratch.extent[i].along(body.motion, index - body.dof) + armature;
                scratch.root[index] = size.sqrt();
                let column = response(&inertia, &s);
                let pivot = s.dot(&column) + N::from_f64(armature);
                let d = pivot.value();
                let left = d / size;
                if !is_clear(left, scratch.extent[i].least, bound) {
                    let total = follow(model, tree, scratch, index);
                    if vanishes(d, bound, total) {
                        on_vanished(&VanishedPivot {
                            index: model.dofs[index].coordinate,
                            pivot: d,
                            inertia: size,
                            share: &scratch.share[index..model.dofs[index].end],
                        });
                        // The DoF is locked: the elimination leaves it out.
                        tree.inertias.pivot[index].column = ForceVector::zero();
                        continue;
                    }
                }
                scratch.extent[i].least = scratch.extent[i].least.min(left);
                let inverse = N::one() / pivot;
                let scaled =
                    ForceVector { linear: column.linear * inverse, angular: column.angular * inverse };
                tree.inertias.pivot[index] = DofElimination { column: scaled, residual: inverse, inverse };
                if index > body.dof || body.parent != WORLD {
                    // Iᵃ = Iᴬ − U Uᵀ/d.
                    let (f, n) = (column.linear, column.angular);
                    inertia.mass = inertia.mass.minus_square(f, inverse, scaled.linear);
                    inertia.coupling = inertia.coupling.minus_scaled_outer(f, n, inverse, scaled.angular);
                    inertia.inertia = inertia.inertia.minus_square(n, inverse, scaled.angular);
                }
            }
            if body.parent != WORLD {
                let p = tree.world.pose[i].translation;
                add_shifted(&mut tree.inertias.articulated[body.parent], &inertia, p);
                let extent = scratch.extent[i];
                scratch.extent[body.parent].add(&extent, scratch.distance[i]);
            }
        }
    }
}

/// Computes the motion z that a unit velocity of DoF k alone causes in the DoFs beyond it: zᵢ = −Uᵢᵀa/dᵢ from
/// the root on. Writes |zᵢ| √Nᵢ to `share` and returns their sum.
#[inline(always)]
fn follow<N: View<f64>>(model: &Model, tree: &mut TreeMemory<N>, scratch: &mut RankBuffers, k: usize) -> f64 {
    let (first, end) = (model.dofs[k].body, model.dofs[k].end);
    scratch.share[k] = scratch.root[k];
    let mut total = scratch.root[k];
    for (i, body) in model.bodies.iter().enumerate().skip(first) {
        if body.dof >= end {
            break;
        }
        let (mut a, from) = if i == first {
            (tree.world.column[k], k + 1)
        } else {
            (shifted(&tree.world.twist_rate[body.parent], tree.world.pose[i].translation), body.dof)
        };
        for index in from..body.dof + body.motion.nv() {
            let z = -tree.inertias.pivot[index].column.dot(&a);
            a.add_scaled(z, &tree.world.column[index]);
            scratch.share[index] = z.value().abs() * scratch.root[index];
            total += scratch.share[index];
        }
        tree.world.twist_rate[i] = a;
    }
    total
}
