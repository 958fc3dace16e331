//! Blocks of four forces, for matrices that are computed row by row.
//!
//! Component by component, four forces are six vector registers. Four entries of a row of sᵀF then take six
//! products of a number with a register.

use robot_dynamics_number::Scalar;

use crate::spatial::force::ForceVector;
use crate::spatial::motion::MotionVector;

/// The number of columns in a block.
pub(crate) const WIDTH: usize = 4;

/// Four forces, component by component: linear, then angular.
pub(crate) type MomentumBlock<S> = [[S; WIDTH]; 6];

/// The number of blocks for this many columns.
pub(crate) fn momentum_blocks(columns: usize) -> usize {
    columns.div_ceil(WIDTH)
}

/// Writes one of the forces.
#[inline(always)]
pub(crate) fn write_force<S: Scalar>(block: &mut MomentumBlock<S>, lane: usize, force: &ForceVector<S>) {
    let ([fx, fy, fz], [nx, ny, nz]) = (force.linear.array(), force.angular.array());
    let lane = lane % WIDTH;
    block[0][lane] = fx;
    block[1][lane] = fy;
    block[2][lane] = fz;
    block[3][lane] = nx;
    block[4][lane] = ny;
    block[5][lane] = nz;
}

/// sᵀF of the four forces, with s given by its components.
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

/// The components of a motion.
#[inline(always)]
pub(crate) fn components<S: Scalar>(motion: &MotionVector<S>) -> [S; 6] {
    let ([lx, ly, lz], [ax, ay, az]) = (motion.linear.array(), motion.angular.array());
    [lx, ly, lz, ax, ay, az]
}

/// Writes block `b` of a row, up to the end of the row.
#[inline(always)]
pub(crate) fn write_entries<S: Scalar>(row: &mut [S], b: usize, entries: [S; WIDTH]) {
    // Avoids a copy of variable length, which would be a function call.
    match &mut row[b * WIDTH..] {
        [x, y, z, w, ..] => (*x, *y, *z, *w) = entries.into(),
        [x, y, z] => (*x, *y, *z) = (entries[0], entries[1], entries[2]),
        [x, y] => (*x, *y) = (entries[0], entries[1]),
        [x] => *x = entries[0],
        [] => {}
    }
}

/// Sets row i's first and last block to zero, except for columns i to `end`.
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
