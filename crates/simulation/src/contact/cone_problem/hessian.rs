//! The contribution of the blocks to H.

use core::array::from_fn;

use robot_dynamics_core::factorization::paths::{Paths, add, add_three, filled_up};
use robot_dynamics_number::dispatch::{Call, Hardware};

use super::block::Block;
use super::projection::{MultiplierZone, ProjectionDerivative};
use super::rows::RowGroups;

/// Adds AᵀG A/R of all blocks to the packed lower triangle, with G = Π′ of each block.
pub(super) struct Add<'a> {
    pub(super) blocks: &'a [Block],
    pub(super) cones: &'a [usize],
    /// The derivatives of each cone.
    pub(super) derivatives: &'a [ProjectionDerivative],
    /// 1/R of each single row, or 0 if it is on a bound.
    pub(super) weights: &'a [f64],
    pub(super) support: &'a [usize],
    pub(super) rows: &'a RowGroups,
    pub(super) paths: &'a Paths,
    pub(super) matrix: &'a mut [f64],
    /// A buffer for the rows of G A/R.
    pub(super) weighted: &'a mut Vec<f64>,
}

impl Call for Add<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let Self { blocks, cones, derivatives, weights, support, rows, paths, matrix, weighted } = self;
        for (k, a, row) in rows.singles(support) {
            *paths.diagonal_of(k, matrix) += a * (weights[row] * a);
        }
        let of_cones = cones
            .iter()
            .zip(derivatives)
            .filter(|(_, derivatives)| derivatives.place != MultiplierZone::Elsewhere);
        let of_cones = of_cones.map(|(index, derivatives)| (*index, derivatives));
        let of_rows = rows.wide_rows().filter(|index| weights[blocks[*index].rows.start] != 0.0);
        let of_rows = of_rows.map(|index| (index, &ProjectionDerivative::WITHIN));
        for (index, derivatives) in of_cones.chain(of_rows) {
            let block = &blocks[index];
            let support = &support[block.support.clone()];
            if support.is_empty() {
                continue;
            }
            let (count, inverse) = (block.rows.len(), 1.0 / block.softness);
            let a = rows.of_block(index, support.len(), count);
            weigh(a, count, derivatives, inverse, weighted);
            add_square(paths, support, (a, weighted), matrix);
        }
    }
}

/// Computes G A/R, row by row.
#[inline(always)]
fn weigh(a: &[f64], rows: usize, derivatives: &ProjectionDerivative, inverse: f64, weighted: &mut Vec<f64>) {
    weighted.clear();
    if derivatives.place == MultiplierZone::Interior {
        weighted.extend(a.iter().map(|a| inverse * a));
        return;
    }
    weighted.resize(a.len(), 0.0);
    let width = a.len() / rows;
    if rows == 3 {
        let own = from_fn(|r| &a[r * width..][..width]);
        for (i, to) in weighted.chunks_exact_mut(width).enumerate() {
            add::<3>(to, from_fn(|j| inverse * derivatives.entry(i, j)), own);
        }
        return;
    }
    for (i, to) in weighted.chunks_exact_mut(width).enumerate() {
        for (j, own) in a.chunks_exact(width).enumerate() {
            add(to, [inverse * derivatives.entry(i, j)], [own]);
        }
    }
}

/// Adds AᵀW to the matrix.
#[inline(always)]
fn add_square(paths: &Paths, support: &[usize], (a, weighted): (&[f64], &[f64]), matrix: &mut [f64]) {
    let (count, width) = (support.len(), filled_up(support.len()));
    let rows = a.len() / width;
    // The columns of a path to the root are the first entries of each row. In other supports, each column is
    // found by its depth.
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
