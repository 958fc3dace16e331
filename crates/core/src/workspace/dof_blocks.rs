//! The DoFs' vectors, four DoFs side by side.
//!
//! The DoFs of a block are a chain on the way from the root. A sum over one of them for their descendants is
//! then a sum over all of them. The DoFs of one body have a block of their own.

use core::ops::Range;

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use crate::Model;
use crate::factorization::sparse::{NONE, dof_parents};
use crate::factorization::tile::{TALLEST, Tile, tiles};
use crate::spatial::force::ForceVector;
use crate::spatial::motion::MotionVector;
use crate::workspace::motion_derivatives::MotionDerivatives;

/// The number of DoFs side by side.
pub(crate) const LANES: usize = TALLEST;

/// The vectors of up to four DoFs. No load of a row crosses a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct DofBlock<S> {
    /// Terms of an ancestor: ψ′, then the angular part of ψ. In the second half of the rows: Ṡ + ψ, then the
    /// angular part of S.
    pub motions: [[S; 2 * LANES]; 9],
    /// Terms of a descendant: S ×\* F + I ψ′ + 2B ψ. In the second half of the rows: I (Ṡ + ψ) + 2B S. The
    /// moment comes before the force.
    pub forces: [[S; 2 * LANES]; 6],
    /// S, its angular part before the linear one.
    pub columns: [[S; LANES]; 6],
    /// The same, DoF by DoF.
    pub column: [[S; 6]; LANES],
    /// I S, then the moment of 2Bᵀ S, whose force is zero; DoF by DoF.
    pub inertial: [[S; 9]; LANES],
    pub tile: Tile,
    /// The last ancestor outside the block, or [`NONE`].
    pub before: usize,
    /// The body, if these are DoFs of one body with several.
    pub(crate) joint_body: Option<usize>,
    /// Whether the ancestors have another reference point, and the lever from there to the block's.
    pub shifts_reference_point: bool,
    pub lever: [S; 3],
}

/// All DoFs in blocks along paths from the root.
#[derive(Clone, Debug)]
pub struct Paths<S> {
    pub blocks: Vec<DofBlock<S>>,
    /// The block and lane of each DoF.
    lanes: Vec<(usize, usize)>,
}

impl<S: Scalar> Paths<S> {
    pub fn new(model: &Model) -> Self {
        let dof_parent = dof_parents(model);
        let several = |dof: usize| {
            let body = model.dofs[dof].body;
            (model.bodies[body].motion.nv() > 1).then_some(body)
        };
        let shifts_reference_point = |dof: usize| {
            let body = &model.bodies[model.dofs[dof].body];
            body.shifts_reference_point && body.dof == dof
        };
        let tiles = tiles(&dof_parent, LANES, |k| several(k) == several(k - 1) && !shifts_reference_point(k));
        let mut lanes = vec![(0, 0); dof_parent.len()];
        for (at, tile) in tiles.iter().enumerate() {
            for lane in 0..tile.rows {
                lanes[tile.first + lane] = (at, lane);
            }
        }
        let zero = S::zero();
        let block = |&tile: &Tile| DofBlock {
            motions: [[zero; 2 * LANES]; 9],
            forces: [[zero; 2 * LANES]; 6],
            columns: [[zero; LANES]; 6],
            column: [[zero; 6]; LANES],
            inertial: [[zero; 9]; LANES],
            tile,
            before: lanes.get(dof_parent[tile.first]).map_or(NONE, |lane| lane.0),
            joint_body: several(tile.first),
            shifts_reference_point: shifts_reference_point(tile.first),
            lever: [zero; 3],
        };
        Self { blocks: tiles.iter().map(block).collect(), lanes }
    }

    /// The block and lane of a DoF.
    #[inline(always)]
    pub(crate) fn seat(&mut self, dof: usize) -> (&mut DofBlock<S>, usize) {
        let (block, lane) = self.lanes[dof];
        (&mut self.blocks[block], lane % LANES)
    }
}

impl<S: Scalar> DofBlock<S> {
    #[inline(always)]
    pub(crate) fn write_column(&mut self, lane: usize, s: &MotionVector<S>) {
        self.column[lane] = turn_first(s.angular, s.linear);
        write(&mut self.columns, lane, 0, s.angular);
        write(&mut self.columns, lane, 3, s.linear);
        write(&mut self.motions, LANES + lane, 6, s.angular);
    }

    /// The forces about a point that is at −d from the present one.
    #[inline(always)]
    pub fn shifted(&self, d: &[S; 3]) -> Self {
        let mut shifted = *self;
        for inertial in &mut shifted.inertial {
            let [fx, fy, fz, nx, ny, nz, ..] = *inertial;
            let [x, y, z, ..] = turned_about(d, [nx, ny, nz, fx, fy, fz]);
            (inertial[3], inertial[4], inertial[5]) = (x, y, z);
        }
        for l in 0..2 * LANES {
            let force = turned_about(d, self.forces.map(|row| row[l]));
            for k in 0..6 {
                shifted.forces[k][l] = force[k];
            }
        }
        shifted
    }

    /// I S, the moment before the force.
    #[inline(always)]
    pub(crate) fn inertial_turn_first(&self, lane: usize) -> [S; 6] {
        let [a, b, c, d, e, f, ..] = self.inertial[lane];
        [d, e, f, a, b, c]
    }

    #[inline(always)]
    pub(crate) fn write_motion(&mut self, lane: usize, motion: &MotionDerivatives<S>) {
        write(&mut self.motions, lane, 0, motion.psi_prime.linear);
        write(&mut self.motions, lane, 3, motion.psi_prime.angular);
        write(&mut self.motions, lane, 6, motion.psi.angular);
        write(&mut self.motions, LANES + lane, 0, motion.velocity_term.linear);
        write(&mut self.motions, LANES + lane, 3, motion.velocity_term.angular);
    }

    /// S ×\* F + I ψ′ + 2B ψ.
    #[inline(always)]
    pub(crate) fn write_force_derivative(&mut self, lane: usize, force_derivative: &ForceVector<S>) {
        write(&mut self.forces, lane, 0, force_derivative.angular);
        write(&mut self.forces, lane, 3, force_derivative.linear);
    }

    /// I (Ṡ + ψ) + 2B S.
    #[inline(always)]
    pub(crate) fn write_above(&mut self, lane: usize, above: &ForceVector<S>) {
        write(&mut self.forces, LANES + lane, 0, above.angular);
        write(&mut self.forces, LANES + lane, 3, above.linear);
    }
}

/// n + d × f of a force, with the moment before the force.
#[inline(always)]
pub(crate) fn turned_about<S: Scalar>([x, y, z]: &[S; 3], [a, b, c, fx, fy, fz]: [S; 6]) -> [S; 6] {
    let (x, y, z) = (*x, *y, *z);
    [a + y * fz - z * fy, b + z * fx - x * fz, c + x * fy - y * fx, fx, fy, fz]
}

/// The angular part before the linear one.
#[inline(always)]
fn turn_first<S: Scalar>(angular: V3<S>, linear: V3<S>) -> [S; 6] {
    let ([a, b, c], [d, e, f]) = (angular.array(), linear.array());
    [a, b, c, d, e, f]
}

#[inline(always)]
fn write<S: Scalar, const N: usize, const K: usize>(
    rows: &mut [[S; N]; K],
    lane: usize,
    first: usize,
    vector: V3<S>,
) {
    let [x, y, z] = vector.array();
    rows[first][lane] = x;
    rows[first + 1][lane] = y;
    rows[first + 2][lane] = z;
}

/// Σₖ weightₖ rowₖ for at least the lanes `dofs`, for all matrices side by side.
#[inline(always)]
pub fn project<S: Scalar, const K: usize, const N: usize>(
    weights: &[S; K],
    rows: &[[S; N]; K],
    dofs: Range<usize>,
) -> [S; N] {
    let mut sums = [S::zero(); N];
    if M3::<S>::KEEPS_TRANSPOSE {
        for l in 0..N {
            sums[l] = rows[0][l] * weights[0];
        }
        for k in 1..K {
            for l in 0..N {
                sums[l] = weights[k].mul_add(rows[k][l], sums[l]);
            }
        }
    } else {
        for l in dofs.start..dofs.end.min(LANES) {
            for l in (l..N).step_by(LANES) {
                let mut sum = rows[0][l] * weights[0];
                for k in 1..K {
                    sum = weights[k].mul_add(rows[k][l], sum);
                }
                sums[l] = sum;
            }
        }
    }
    sums
}
