//! The mass matrix of one state, four columns at a time.

use dynamics::Scalar;

use crate::Model;
use crate::model::WORLD;
use crate::scratch::momentum_block::{WIDTH, clear_margins, components, project, write_entries, write_force};
use crate::scratch::tree::TreeMemory;
use crate::spatial::screw::Composite;
use crate::stages::screws::{add_composite, inertia_in_world, momentum_of};

/// The momentum I^c S of each freedom, in blocks, after [`place_screws`](crate::stages::screws::place_screws).
#[inline(always)]
pub(super) fn gather_momenta<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    let n = model.bodies.len();
    let (bodies, world) = (&model.bodies[..n], &tree.screws.world[..n]);
    let (composites, columns) = (&mut tree.inertias.composite[..n], &tree.screws.column[..]);
    let blocks = &mut tree.blocks.momentum_block[..];
    for i in 0..n {
        composites[i] = inertia_in_world(&bodies[i], &world[i]);
    }
    // What hangs on body i by body i + 1.
    let mut handed: Option<Composite<S>> = None;
    for i in (0..n).rev() {
        let (body, mut whole) = (&bodies[i], composites[i]);
        if let Some(beyond) = &handed {
            add_composite(&mut whole, beyond);
        }
        for dof in body.dof..body.dof + body.motion.nv() {
            write_force(&mut blocks[dof / WIDTH], dof, &momentum_of(&whole, &columns[dof]));
        }
        handed = None;
        if body.parent.wrapping_add(1) == i {
            handed = Some(whole);
        } else if body.parent != WORLD {
            add_composite(&mut composites[body.parent], &whole);
        }
    }
}

/// M's entries, from the momenta: all, or those on and above the diagonal that are not always zero, and beside them what is of no meaning.
#[inline(always)]
pub(super) fn write_matrix<N: Scalar>(model: &Model, tree: &TreeMemory<N>, mass: &mut [N], all: bool) {
    let n = model.nv;
    let (dofs, columns) = (&model.dofs[..n], &tree.screws.column[..n]);
    let blocks = &tree.blocks.momentum_block[..];
    if all && model.tips > 1 {
        mass.fill(N::zero());
    }
    // From the last row: what a row's first block writes left of the diagonal, the rows above write over.
    for i in (0..n).rev() {
        let (row, below) = mass[i * n..].split_at_mut(n);
        let (s, end) = (components(&columns[i]), dofs[i].end);
        for b in i / WIDTH..end.div_ceil(WIDTH) {
            let [x, y, z, w] = project(&blocks[b], &s);
            write_entries(row, b, [x, y, z, w]);
        }
        if !all {
            continue;
        }
        if model.tips > 1 {
            clear_margins(row, i, end);
        }
        let mut at = i;
        for &entry in &row[i + 1..end] {
            below[at] = entry;
            at += n;
        }
    }
}
