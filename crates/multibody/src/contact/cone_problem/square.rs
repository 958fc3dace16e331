//! What the blocks add to Newton's matrix.

use core::array::from_fn;

use number::dispatch::{Call, Hardware};

use super::Block;
use super::projection::{Place, Slopes};
use super::rows::Rows;
use crate::factor::paths::{Paths, add, add_three, filled_up};

/// Adds AᵀG A/R of all blocks to the packed lower triangle.
pub(super) struct Add<'a> {
    pub(super) blocks: &'a [Block],
    pub(super) cones: &'a [usize],
    /// Of each cone.
    pub(super) slopes: &'a [Slopes],
    /// Of each single row 1/R, or 0.
    pub(super) weights: &'a [f64],
    pub(super) support: &'a [usize],
    pub(super) rows: &'a Rows,
    pub(super) paths: &'a Paths,
    pub(super) matrix: &'a mut [f64],
    /// Memory for the rows of G A/R.
    pub(super) weighted: &'a mut Vec<f64>,
}

impl Call for Add<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let Self { blocks, cones, slopes, weights, support, rows, paths, matrix, weighted } = self;
        for (k, a, row) in rows.singles(support) {
            *paths.diagonal_of(k, matrix) += a * (weights[row] * a);
        }
        let of_cones = cones.iter().zip(slopes).filter(|(_, slopes)| slopes.place != Place::Elsewhere);
        let of_cones = of_cones.map(|(index, slopes)| (*index, slopes));
        let of_rows = rows.wide_rows().filter(|index| weights[blocks[*index].rows.start] != 0.0);
        let of_rows = of_rows.map(|index| (index, &Slopes::WITHIN));
        for (index, slopes) in of_cones.chain(of_rows) {
            let block = &blocks[index];
            let support = &support[block.support.clone()];
            if support.is_empty() {
                continue;
            }
            let (count, inverse) = (block.rows.len(), 1.0 / block.softness);
            let a = rows.of_block(index, support.len(), count);
            weigh(a, count, slopes, inverse, weighted);
            add_square(paths, support, (a, weighted), matrix);
        }
    }
}

/// G A/R, row by row.
#[inline(always)]
fn weigh(a: &[f64], rows: usize, slopes: &Slopes, inverse: f64, weighted: &mut Vec<f64>) {
    weighted.clear();
    if slopes.place == Place::Within {
        weighted.extend(a.iter().map(|a| inverse * a));
        return;
    }
    weighted.resize(a.len(), 0.0);
    let width = a.len() / rows;
    if rows == 3 {
        let own = from_fn(|r| &a[r * width..][..width]);
        for (i, to) in weighted.chunks_exact_mut(width).enumerate() {
            add::<3>(to, from_fn(|j| inverse * slopes.entry(i, j)), own);
        }
        return;
    }
    for (i, to) in weighted.chunks_exact_mut(width).enumerate() {
        for (j, own) in a.chunks_exact(width).enumerate() {
            add(to, [inverse * slopes.entry(i, j)], [own]);
        }
    }
}

/// Adds AᵀW.
#[inline(always)]
fn add_square(paths: &Paths, support: &[usize], (a, weighted): (&[f64], &[f64]), matrix: &mut [f64]) {
    let (count, width) = (support.len(), filled_up(support.len()));
    let rows = a.len() / width;
    // A path to the root has its columns at the beginning of each of its rows; of other supports each column is found by its depth.
    let is_path = paths.depth(support[count - 1]) == count - 1;
    if is_path && rows == 3 {
        let (first, rest) = a.split_at(width);
        let (second, third) = rest.split_at(width);
        for (&row, ((f, g), h)) in support.iter().zip(first.iter().zip(second).zip(third)) {
            add_three(paths.row_of(row, matrix), [*f, *g, *h], weighted);
        }
        return;
    }
    for (i, &row) in support.iter().enumerate() {
        let to = paths.row_of(row, matrix);
        for (own, weighted) in a.chunks_exact(width).zip(weighted.chunks_exact(width)) {
            if is_path {
                add(to, [own[i]], [weighted]);
                continue;
            }
            for (&column, weighted) in support[..=i].iter().zip(weighted) {
                to[paths.depth(column)] += own[i] * weighted;
            }
        }
    }
}
