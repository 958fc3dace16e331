//! The Coriolis matrix entry by entry along the path from each DoF to the root.
//!
//! This form computes any robot: mimic joints, reference points that move, and several states at once.

use robot_dynamics_number::Scalar;

use super::branch::Branch;
use crate::Model;
use crate::kinematics::shifts::{pass_flow, pass_inertia};
use crate::kinematics::world_frame::{add_composite, inertia_in_world};
use crate::model::WORLD;
use crate::spatial::inertia::MassFlux;
use crate::workspace::tree::TreeMemory;

/// Writes all entries of C. Call after [`compute_column_rates`](crate::kinematics::world_frame::compute_column_rates).
#[inline(always)]
pub(super) fn write_matrix<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, coriolis: &mut [N]) {
    coriolis.fill(N::zero());
    let n = model.bodies.len();
    let (bodies, world, twists) = (&model.bodies[..n], &tree.world.pose[..n], &tree.world.twist[..n]);
    let (columns, rates) = (&tree.world.column[..], &tree.world.column_rate[..]);
    let levers = &tree.world.levers[..];
    let (composites, flows) = (&mut tree.inertias.composite[..n], &mut tree.world.flow[..n]);
    for i in 0..n {
        let inertia = inertia_in_world(&bodies[i], &world[i]);
        flows[i] = MassFlux::of(&inertia, &twists[i]);
        composites[i] = inertia;
    }
    for i in (0..n).rev() {
        let body = &bodies[i];
        let (mut composite, mut flow) = (composites[i], flows[i]);
        let own = body.dof..body.dof + body.motion.nv();
        for dof in own.clone() {
            let mut branch = Branch::new(&composite, &flow, &columns[dof], &rates[dof]);
            for other in own.clone() {
                add_entry(model, coriolis, other, dof, branch.above(&columns[other]));
            }
            branch.pass_inward(body, levers);
            let mut at = body.parent;
            while at != WORLD {
                let ancestor = &bodies[at];
                for other in ancestor.dof..ancestor.dof + ancestor.motion.nv() {
                    let (s, rate) = (&columns[other], &rates[other]);
                    add_entry(model, coriolis, other, dof, branch.above(s));
                    add_entry(model, coriolis, dof, other, branch.beyond(s, rate));
                }
                branch.pass_inward(ancestor, levers);
                at = ancestor.parent;
            }
        }
        if body.parent != WORLD {
            pass_inertia(body, levers, &mut composite);
            pass_flow(body, levers, &mut flow);
            add_composite(&mut composites[body.parent], &composite);
            flows[body.parent].add(&flow);
        }
    }
}

/// Adds a tree entry C_{i j} to the reduced matrix GᵀCG.
#[inline(always)]
fn add_entry<N: Scalar>(model: &Model, matrix: &mut [N], i: usize, j: usize, entry: N) {
    if model.needs_dense_factor {
        let (a, b) = (&model.dofs[i], &model.dofs[j]);
        matrix[a.coordinate * model.nv + b.coordinate] += entry.scale(a.ratio * b.ratio);
    } else {
        matrix[i * model.nv + j] = entry;
    }
}
