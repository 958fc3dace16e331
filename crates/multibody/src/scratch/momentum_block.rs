//! Four forces side by side, for matrices that are computed row by row.
//!
//! Component by component, four forces are six vector registers. A row of sᵀF takes six products of a number with a
//! register for every four entries.

use dynamics::Scalar;

use crate::spatial::screw::Force;

/// Columns in a block.
pub(crate) const WIDTH: usize = 4;

/// Four forces, component by component: linear, then angular.
pub(crate) type MomentumBlock<S> = [[S; WIDTH]; 6];

/// Blocks that hold so many columns.
pub(crate) fn momentum_blocks(columns: usize) -> usize {
    columns.div_ceil(WIDTH)
}

/// Writes one of the forces.
#[inline(always)]
pub(crate) fn write_force<S: Scalar>(block: &mut MomentumBlock<S>, lane: usize, force: &Force<S>) {
    let ([fx, fy, fz], [nx, ny, nz]) = (force.linear.array(), force.angular.array());
    let lane = lane % WIDTH;
    block[0][lane] = fx;
    block[1][lane] = fy;
    block[2][lane] = fz;
    block[3][lane] = nx;
    block[4][lane] = ny;
    block[5][lane] = nz;
}

/// sᵀF of the four, s by its components.
#[inline(always)]
pub(crate) fn project<S: Scalar>(block: &MomentumBlock<S>, [lx, ly, lz, ax, ay, az]: &[S; 6]) -> [S; WIDTH] {
    let [fx, fy, fz, nx, ny, nz] = block;
    let mut entries = [S::zero(); WIDTH];
    for k in 0..WIDTH {
        let linear = lx.mul_add(fx[k], ly.mul_add(fy[k], *lz * fz[k]));
        entries[k] = ax.mul_add(nx[k], ay.mul_add(ny[k], az.mul_add(nz[k], linear)));
    }
    entries
}

/// The components of a motion or force.
#[inline(always)]
pub(crate) fn components<S: Scalar>(force: &Force<S>) -> [S; 6] {
    let ([lx, ly, lz], [ax, ay, az]) = (force.linear.array(), force.angular.array());
    [lx, ly, lz, ax, ay, az]
}

/// Writes block `b` of a row, as far as the row goes.
#[inline(always)]
pub(crate) fn write_entries<S: Scalar>(row: &mut [S], b: usize, entries: [S; WIDTH]) {
    // Not a copy of so many numbers, which would be a call.
    match &mut row[b * WIDTH..] {
        [x, y, z, w, ..] => (*x, *y, *z, *w) = entries.into(),
        [x, y, z] => (*x, *y, *z) = (entries[0], entries[1], entries[2]),
        [x, y] => (*x, *y) = (entries[0], entries[1]),
        [x] => *x = entries[0],
        [] => {}
    }
}

/// Zeros in row i's first and last block, but in columns i to `end`.
#[inline(always)]
pub(crate) fn clear_margins<S: Scalar>(row: &mut [S], i: usize, end: usize) {
    let first = i / WIDTH * WIDTH;
    for k in 0..WIDTH - 1 {
        if first + k < i {
            row[first + k] = S::zero();
        }
        if end + k < row.len() {
            row[end + k] = S::zero();
        }
    }
}
