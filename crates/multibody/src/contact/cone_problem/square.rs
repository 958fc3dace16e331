//! What a block adds to Newton's matrix.

use super::projection::{Place, Slopes, place_by};
use crate::factor::paths::Paths;

/// Adds AᵀG A/R to the packed lower triangle, with `weighted` for the rows of G A/R.
pub(super) fn add_square(
    matrix: &mut [f64],
    paths: &Paths,
    support: &[usize],
    a: &[f64],
    slopes: (&Slopes, f64),
    weighted: &mut Vec<f64>,
) {
    let (slopes, inverse) = slopes;
    let count = support.len();
    if place_by(slopes) == Place::Elsewhere || count == 0 {
        return;
    }
    let rows = a.len() / count;
    weighted.clear();
    for slopes in &slopes[..rows] {
        let begin = weighted.len();
        weighted.resize(begin + count, 0.0);
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
                for (own, weighted) in a.chunks_exact(count).zip(weighted.chunks_exact(count)) {
                    for (&column, weighted) in support[..=i].iter().zip(weighted) {
                        to[paths.depth(column)] += own[i] * weighted;
                    }
                }
            }
            3 => {
                let [one, two, three] = [0, 1, 2].map(|r| &weighted[r * count..]);
                add(to, [a[i], a[count + i], a[2 * count + i]], [one, two, three]);
            }
            _ => {
                for (own, weighted) in a.chunks_exact(count).zip(weighted.chunks_exact(count)) {
                    add(to, [own[i]], [weighted]);
                }
            }
        }
    }
}

/// to ← to + Σ fᵢ rowᵢ.
#[inline(always)]
fn add<const N: usize>(to: &mut [f64], factors: [f64; N], rows: [&[f64]; N]) {
    let rows = rows.map(|row| &row[..to.len()]);
    for k in 0..to.len() {
        let sum: f64 = factors.iter().zip(&rows).map(|(factor, row)| factor * row[k]).sum();
        to[k] += sum;
    }
}
