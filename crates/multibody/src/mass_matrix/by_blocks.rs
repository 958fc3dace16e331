//! The mass matrix of one state, four columns at a time.
//!
//! Four momenta side by side are one vector register a component: a row of M takes six products of a number with a
//! register for every four entries, whole registers throughout.

use dynamics::Scalar;

use crate::dispatch::Route;
use crate::model::WORLD;
use crate::screws::{add_composite, inertia_in_world, momentum_of};
use crate::workspace::{Composite, Force};
use crate::{Model, Workspace};

/// Columns in a block.
const WIDTH: usize = 4;

/// Four forces, component by component.
pub(crate) type MomentumBlock<S> = [[S; WIDTH]; 6];

/// Blocks that hold so many columns.
pub(crate) fn momentum_blocks(columns: usize) -> usize {
    columns.div_ceil(WIDTH)
}

/// The momentum I^c S of each freedom, in blocks, after [`place_screws`](crate::screws::place_screws).
#[inline(always)]
pub(super) fn gather_momenta<S: Scalar>(model: &Model, workspace: &mut Workspace<S>) {
    let n = model.bodies.len();
    let (bodies, world) = (&model.bodies[..n], &workspace.world[..n]);
    let (composites, columns) = (&mut workspace.composite[..n], &workspace.column[..]);
    let blocks = &mut workspace.momentum_block[..];
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
            write_column(&mut blocks[dof / WIDTH], dof % WIDTH, &momentum_of(&whole, &columns[dof]));
        }
        handed = None;
        if body.parent.wrapping_add(1) == i {
            handed = Some(whole);
        } else if body.parent != WORLD {
            add_composite(&mut composites[body.parent], &whole);
        }
    }
}

#[inline(always)]
fn write_column<S: Scalar>(block: &mut MomentumBlock<S>, lane: usize, force: &Force<S>) {
    let ([fx, fy, fz], [nx, ny, nz]) = (force.linear.array(), force.angular.array());
    let lane = lane % WIDTH;
    block[0][lane] = fx;
    block[1][lane] = fy;
    block[2][lane] = fz;
    block[3][lane] = nx;
    block[4][lane] = ny;
    block[5][lane] = nz;
}

/// All entries of M, from the momenta.
#[inline(always)]
pub(super) fn write_matrix<S: Scalar, R: Route<S>>(
    model: &Model,
    workspace: &Workspace<R::Number>,
    mass: &mut [S],
) {
    let n = model.nv;
    let (dofs, columns) = (&model.dofs[..n], &workspace.column[..n]);
    let blocks = &workspace.momentum_block[..];
    if model.has_branches {
        mass.fill(S::zero());
    }
    // From the last row: what a row's first block writes left of the diagonal, the rows above write over.
    for i in (0..n).rev() {
        let (row, below) = mass[i * n..].split_at_mut(n);
        let (first, end) = (i / WIDTH * WIDTH, dofs[i].end);
        let ([lx, ly, lz], [ax, ay, az]) = (columns[i].linear.array(), columns[i].angular.array());
        for b in i / WIDTH..end.div_ceil(WIDTH) {
            let [fx, fy, fz, nx, ny, nz] = &blocks[b];
            let mut entries = [S::zero(); WIDTH];
            for k in 0..WIDTH {
                let linear = lx.mul_add(fx[k], ly.mul_add(fy[k], lz * fz[k]));
                entries[k] = R::store(ax.mul_add(nx[k], ay.mul_add(ny[k], az.mul_add(nz[k], linear))));
            }
            match &mut row[b * WIDTH..] {
                [x, y, z, w, ..] => (*x, *y, *z, *w) = entries.into(),
                [x, y, z] => (*x, *y, *z) = (entries[0], entries[1], entries[2]),
                [x, y] => (*x, *y) = (entries[0], entries[1]),
                [x] => *x = entries[0],
                [] => {}
            }
        }
        if model.has_branches {
            // Entries of the row's first and last block that are none of a freedom and one that rides on it.
            for k in 0..WIDTH - 1 {
                if first + k < i {
                    row[first + k] = S::zero();
                }
                if end + k < n {
                    row[end + k] = S::zero();
                }
            }
        }
        let mut at = i;
        for &entry in &row[i + 1..end] {
            below[at] = entry;
            at += n;
        }
    }
}
