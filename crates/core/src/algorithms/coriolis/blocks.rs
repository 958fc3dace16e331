//! The Coriolis matrix of one state, in blocks of four columns.

use robot_dynamics_number::Scalar;

use super::branch::Branch;
use crate::Model;
use crate::kinematics::world_frame::{add_composite, inertia_in_world};
use crate::model::WORLD;
use crate::spatial::inertia::{MassFlux, SpatialInertia};
use crate::workspace::branch_block::BranchBlock;
use crate::workspace::momentum_block::{
    WIDTH, clear_margins, components, project, write_entries, write_force,
};
use crate::workspace::tree::TreeMemory;

impl<S: Scalar> BranchBlock<S> {
    #[inline(always)]
    fn write(&mut self, lane: usize, branch: &Branch<S>) {
        write_force(&mut self.above, lane, &branch.above);
        write_force(&mut self.inertial, lane, &branch.inertial);
        let ([x, y, z], lane) = (branch.turning.array(), lane % WIDTH);
        self.turning[0][lane] = x;
        self.turning[1][lane] = y;
        self.turning[2][lane] = z;
    }

    /// [`Branch::beyond`] of the four columns.
    #[inline(always)]
    fn beyond(&self, [.., ax, ay, az]: &[S; 6], rate: &[S; 6]) -> [S; WIDTH] {
        let ([x, y, z], mut entries) = (&self.turning, project(&self.inertial, rate));
        for k in 0..WIDTH {
            entries[k] = ax.mul_add(x[k], ay.mul_add(y[k], az.mul_add(z[k], entries[k])));
        }
        entries
    }
}

/// Writes all entries of C. Call after [`compute_column_rates`](crate::kinematics::world_frame::compute_column_rates).
#[inline(always)]
pub(super) fn write_matrix<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, coriolis: &mut [N]) {
    gather_branches(model, tree);
    project_branches(model, tree, coriolis);
}

/// The [`Branch`] of each DoF, in blocks.
#[inline(always)]
fn gather_branches<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, world, twists) = (&model.bodies[..n], &tree.world.pose[..n], &tree.world.twist[..n]);
    let (columns, rates) = (&tree.world.column[..], &tree.world.column_rate[..]);
    let (composites, flows) = (&mut tree.inertias.composite[..n], &mut tree.world.flow[..n]);
    let blocks = &mut tree.blocks.branch_block[..];
    for i in 0..n {
        let inertia = inertia_in_world(&bodies[i], &world[i]);
        flows[i] = MassFlux::of(&inertia, &twists[i]);
        composites[i] = inertia;
    }
    // The contribution of body i + 1 to body i.
    let mut from_child: Option<(SpatialInertia<S>, MassFlux<S>)> = None;
    for i in (0..n).rev() {
        let (body, mut composite, mut flow) = (&bodies[i], composites[i], flows[i]);
        if let Some((composite_beyond, flow_beyond)) = &from_child {
            add_composite(&mut composite, composite_beyond);
            flow.add(flow_beyond);
        }
        for dof in body.dof..body.dof + body.motion.nv() {
            let branch = Branch::new(&composite, &flow, &columns[dof], &rates[dof]);
            blocks[dof / WIDTH].write(dof, &branch);
        }
        from_child = None;
        if body.parent.wrapping_add(1) == i {
            from_child = Some((composite, flow));
        } else if body.parent != WORLD {
            add_composite(&mut composites[body.parent], &composite);
            flows[body.parent].add(&flow);
        }
    }
}

/// The entries of C from the branches.
#[inline(always)]
fn project_branches<N: Scalar>(model: &Model, tree: &mut TreeMemory<N>, coriolis: &mut [N]) {
    let n = model.nv;
    let (dofs, columns, rates) = (&model.dofs[..n], &tree.world.column[..n], &tree.world.column_rate[..n]);
    let blocks = &mut tree.blocks.branch_block[..];
    if model.leaf_count > 1 {
        coriolis.fill(N::zero());
    }
    // From the last row on: a row's first block overwrites entries left of the diagonal, which later rows
    // set.
    for i in (0..n).rev() {
        let (row, below) = coriolis[i * n..].split_at_mut(n);
        let (s, rate, end) = (components(&columns[i]), components(&rates[i]), dofs[i].end);
        for b in i / WIDTH..end.div_ceil(WIDTH) {
            let block = &mut blocks[b];
            let [x, y, z, w] = project(&block.above, &s);
            write_entries(row, b, [x, y, z, w]);
            block.beyond = block.beyond(&s, &rate);
        }
        if model.leaf_count > 1 {
            clear_margins(row, i, end);
        }
        let mut at = i;
        for j in i + 1..end {
            below[at] = blocks[j / WIDTH].beyond[j % WIDTH];
            at += n;
        }
    }
}
