//! The momenta of all DoFs as a 6×n matrix by rows, and their projections on a motion.

use robot_dynamics_number::Scalar;

use crate::spatial::force::ForceVector;
use crate::spatial::motion::MotionVector;

/// Writes a force as column `index` of a row-major 6×`width` matrix.
#[inline(always)]
pub fn write_column<S: Scalar>(rows: &mut [S], width: usize, index: usize, force: &ForceVector<S>) {
    let ([fx, fy, fz], [nx, ny, nz]) = (force.linear.array(), force.angular.array());
    let rows = &mut rows[index..=index + 5 * width];
    rows[0] = fx;
    rows[width] = fy;
    rows[2 * width] = fz;
    rows[3 * width] = nx;
    rows[4 * width] = ny;
    rows[5 * width] = nz;
}

/// sᵀ F for the forces F in consecutive columns.
#[inline(always)]
pub fn project_columns<N: Scalar>(
    rows: &[N],
    width: usize,
    columns: core::ops::Range<usize>,
    s: &MotionVector<N>,
    to: &mut [N],
) {
    let [lx, ly, lz] = s.linear.array();
    let [ax, ay, az] = s.angular.array();
    let count = columns.len();
    let row = |k: usize| &rows[k * width + columns.start..][..count];
    let (x0, x1, x2, x3, x4, x5) = (row(0), row(1), row(2), row(3), row(4), row(5));
    let to = &mut to[..count];
    for j in 0..count {
        let linear = lx.mul_add(x0[j], ly.mul_add(x1[j], lz * x2[j]));
        to[j] = ax.mul_add(x3[j], ay.mul_add(x4[j], az.mul_add(x5[j], linear)));
    }
}

/// sᵀ F for the force F in one column.
#[inline(always)]
pub fn project_column<S: Scalar>(rows: &[S], width: usize, column: usize, s: &MotionVector<S>) -> S {
    let row = |k: usize| rows[k * width + column];
    let ([lx, ly, lz], [ax, ay, az]) = (s.linear.array(), s.angular.array());
    lx * row(0) + ly * row(1) + lz * row(2) + ax * row(3) + ay * row(4) + az * row(5)
}
