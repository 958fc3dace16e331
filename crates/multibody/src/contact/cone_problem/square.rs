//! What a block adds to Newton's matrix.

use number::dispatch::{Call, Hardware};

use super::projection::{Place, Slopes, place_by};
use crate::factor::paths::{Paths, add, filled_up};

/// What a block adds.
pub(super) struct Square<'a> {
    pub(super) paths: &'a Paths,
    pub(super) support: &'a [usize],
    pub(super) a: &'a [f64],
    /// G, and 1/R.
    pub(super) slopes: (&'a Slopes, f64),
}

/// Adds them to the packed lower triangle, with `weighted` for the rows of G A/R.
pub(super) struct Add<'a, B> {
    pub(super) blocks: B,
    pub(super) matrix: &'a mut [f64],
    pub(super) weighted: &'a mut Vec<f64>,
}

impl<'a, B: Iterator<Item = Square<'a>>> Call for Add<'_, B> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        for square in self.blocks {
            add_square(self.matrix, &square, self.weighted);
        }
    }
}

/// Adds AᵀG A/R.
#[inline(always)]
fn add_square(matrix: &mut [f64], square: &Square<'_>, weighted: &mut Vec<f64>) {
    let Square { paths, support, a, slopes } = *square;
    let (slopes, inverse) = slopes;
    let count = support.len();
    if place_by(slopes) == Place::Elsewhere || count == 0 {
        return;
    }
    let (rows, length) = (a.len() / count, filled_up(count));
    weighted.clear();
    for slopes in &slopes[..rows] {
        let begin = weighted.len();
        weighted.resize(begin + length, 0.0);
        for (slope, row) in slopes.iter().zip(a.chunks_exact(count)).filter(|(slope, _)| **slope != 0.0) {
            let factor = inverse * slope;
            weighted[begin..].iter_mut().zip(row).for_each(|(sum, a)| *sum += factor * a);
        }
    }
    // A path to the root has its columns at the beginning of each of its rows; of other supports each column is found by its depth.
    let is_path = paths.depth(support[count - 1]) == count - 1;
    for (i, &row) in support.iter().enumerate() {
        let to = paths.row_of(row, matrix);
        match rows {
            _ if !is_path => {
                for (own, weighted) in a.chunks_exact(count).zip(weighted.chunks_exact(length)) {
                    for (&column, weighted) in support[..=i].iter().zip(weighted) {
                        to[paths.depth(column)] += own[i] * weighted;
                    }
                }
            }
            3 => {
                let rows = [0, 1, 2].map(|r| &weighted[r * length..]);
                add(to, [0, 1, 2].map(|r| a[r * count + i]), rows);
            }
            _ => {
                for (own, weighted) in a.chunks_exact(count).zip(weighted.chunks_exact(length)) {
                    add(to, [own[i]], [weighted]);
                }
            }
        }
    }
}
