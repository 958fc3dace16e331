//! How the columns of the derivatives of forward dynamics are taken: some at a time, tile by tile.

use core::ops::Range;

use dynamics::Scalar;

use crate::factor::sparse::carriers;
use crate::factor::tile::{Tile, WIDTH};
use crate::spatial::algebra::M3;

/// Eight columns of one row of L⁻ᵀX, L⁻ᵀY and L⁻ᵀ; later of −M⁻¹X, −M⁻¹Y and M⁻¹. No load crosses a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Solved<S>(pub [[S; WIDTH]; 3]);

impl<S: Scalar> Solved<S> {
    pub(crate) fn zero() -> Self {
        Self([[S::zero(); WIDTH]; 3])
    }
}

/// Some of the columns, as many as are solved for at once, and where L⁻ᵀX has entries in them.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    /// Eights of columns.
    pub groups: Range<usize>,
    /// Of each eight the rows that are not zero there, ascending.
    pub rows: Vec<Vec<usize>>,
    /// Of each tile the eights where it is not zero.
    pub places: Vec<Vec<Place>>,
}

/// A tile's entries in one eight of columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Counted from the pass's first.
    pub group: usize,
    /// Which of the group's rows the tile carries.
    pub from: usize,
    pub until: usize,
    /// In how many of them L⁻ᵀ has entries.
    pub inside: usize,
}

/// From the last columns to the first; `carrier` is λ. One state takes all columns at once, so that the ways of
/// several need not wait for each other; several states take eight, which fill the nearest cache.
pub(crate) fn passes<S: Scalar>(carrier: &[usize], tiles: &[Tile]) -> Vec<Pass> {
    let groups = carrier.len().div_ceil(WIDTH);
    let width = if M3::<S>::KEEPS_TRANSPOSE { groups.max(1) } else { 1 };
    let starts = (0..groups).step_by(width).rev();
    starts.map(|first| Pass::new(carrier, tiles, first..groups.min(first + width))).collect()
}

impl Pass {
    fn new(carrier: &[usize], tiles: &[Tile], groups: Range<usize>) -> Self {
        let (mut rows, mut places) = (Vec::new(), vec![Vec::new(); tiles.len()]);
        for (group, first) in groups.clone().map(|group| group * WIDTH).enumerate() {
            let last = carrier.len().min(first + WIDTH);
            let meets = |tile: &Tile| {
                (first < tile.end && tile.first < last)
                    || carriers(carrier, tile.first).any(|j| (first..last).contains(&j))
            };
            let own = tiles.iter().filter(|tile| meets(tile));
            let own: Vec<usize> = own.flat_map(|tile| tile.first..tile.first + tile.rows).collect();
            let before = |end: usize| own.partition_point(|&k| k < end);
            for (tile, places) in tiles.iter().zip(&mut places).filter(|(tile, _)| meets(tile)) {
                let (from, until) = (before(tile.first + tile.rows), before(tile.end));
                places.push(Place { group, from, until, inside: before(last).clamp(from, until) - from });
            }
            rows.push(own);
        }
        Self { groups, rows, places }
    }
}
