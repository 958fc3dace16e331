//! The order of the columns in the derivatives of forward dynamics, in groups, tile by tile.

use core::ops::Range;

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use crate::factorization::sparse::dof_ancestors;
use crate::factorization::tile::{Tile, WIDTH};

/// Eight columns of one row of L⁻ᵀX, L⁻ᵀY and L⁻ᵀ; after the sweeps of −M⁻¹X, −M⁻¹Y and M⁻¹. No load crosses
/// a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct SolvedColumns<S>(pub [[S; WIDTH]; 3]);

impl<S: Scalar> SolvedColumns<S> {
    pub(crate) fn zero() -> Self {
        Self([[S::zero(); WIDTH]; 3])
    }
}

/// The columns that are solved for at once, and the rows of L⁻ᵀX with entries in them.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The groups, of eight columns each.
    pub groups: Range<usize>,
    /// For each group the rows that are not zero there, ascending.
    pub rows: Vec<Vec<usize>>,
    /// For each tile the groups in which it is not zero.
    pub places: Vec<Vec<TileRange>>,
}

/// A tile's entries in one group.
#[derive(Clone, Copy, Debug)]
pub struct TileRange {
    /// Its index, relative to the first group of the pass.
    pub group: usize,
    /// The range of the group's rows that are descendants of the tile.
    pub from: usize,
    pub until: usize,
    /// The number of these rows in which L⁻ᵀ has entries.
    pub inside: usize,
}

/// The passes, from the last columns to the first; `dof_parent` is λ. One state takes all columns at once, so
/// that independent paths overlap. Several states take eight columns, which fill the nearest cache.
pub fn passes<S: Scalar>(dof_parent: &[usize], tiles: &[Tile]) -> Vec<Pass> {
    let groups = dof_parent.len().div_ceil(WIDTH);
    let width = if M3::<S>::KEEPS_TRANSPOSE { groups.max(1) } else { 1 };
    let starts = (0..groups).step_by(width).rev();
    starts.map(|first| Pass::new(dof_parent, tiles, first..groups.min(first + width))).collect()
}

impl Pass {
    fn new(dof_parent: &[usize], tiles: &[Tile], groups: Range<usize>) -> Self {
        let (mut rows, mut places) = (Vec::new(), vec![Vec::new(); tiles.len()]);
        for (group, first) in groups.clone().map(|group| group * WIDTH).enumerate() {
            let last = dof_parent.len().min(first + WIDTH);
            let meets = |tile: &Tile| {
                (first < tile.end && tile.first < last)
                    || dof_ancestors(dof_parent, tile.first).any(|j| (first..last).contains(&j))
            };
            let own = tiles.iter().filter(|tile| meets(tile));
            let own: Vec<usize> = own.flat_map(|tile| tile.first..tile.first + tile.rows).collect();
            let before = |end: usize| own.partition_point(|&k| k < end);
            for (tile, places) in tiles.iter().zip(&mut places).filter(|(tile, _)| meets(tile)) {
                let (from, until) = (before(tile.first + tile.rows), before(tile.end));
                places.push(TileRange { group, from, until, inside: before(last).clamp(from, until) - from });
            }
            rows.push(own);
        }
        Self { groups, rows, places }
    }
}
