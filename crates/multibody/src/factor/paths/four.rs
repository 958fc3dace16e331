//! Rows of numbers, four at a time.

use core::ops::Range;

/// Entries that are handled at a time.
pub(super) const WIDTH: usize = 4;

/// a ← a − f b, of rows that are filled up.
#[inline(always)]
pub(super) fn subtract(a: &mut [f64], f: f64, b: &[f64]) {
    let (a, b) = (a.as_chunks_mut::<WIDTH>().0, b.as_chunks::<WIDTH>().0);
    for (a, b) in a.iter_mut().zip(b) {
        // All are read before one is written: so the compiler may take them at a time.
        let (old, b) = (*a, *b);
        *a = core::array::from_fn(|k| old[k] - f * b[k]);
    }
}

/// Each row less its factor times b; all are filled up and equally long.
#[inline(always)]
pub(super) fn subtract_from_all([r, s, t, u]: [&mut [f64]; WIDTH], f: [f64; WIDTH], b: &[f64]) {
    let [r, s, t, u] = [r, s, t, u].map(|row| row.as_chunks_mut::<WIDTH>().0.iter_mut());
    let b = b.as_chunks::<WIDTH>().0;
    for (((r, s), (t, u)), b) in r.zip(s).zip(t.zip(u)).zip(b) {
        for (row, f) in [r, s, t, u].into_iter().zip(f) {
            let old = *row;
            *row = core::array::from_fn(|k| old[k] - f * b[k]);
        }
    }
}

/// These parts of a slice, which follow one upon the other.
#[inline(always)]
pub(super) fn parts(all: &mut [f64], [r, s, t, u]: [Range<usize>; WIDTH]) -> [&mut [f64]; WIDTH] {
    let (all, last) = all.split_at_mut(u.start);
    let (all, third) = all.split_at_mut(t.start);
    let (first, second) = all.split_at_mut(s.start);
    [&mut first[r], &mut second[..s.len()], &mut third[..t.len()], &mut last[..u.len()]]
}

/// Σ of the products of two rows, in four sums at a time.
#[inline(always)]
pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    let ((a, last_a), (b, last_b)) = (a.as_chunks::<WIDTH>(), b.as_chunks::<WIDTH>());
    let mut sums = [0.0; WIDTH];
    for (a, b) in a.iter().zip(b) {
        sums = core::array::from_fn(|k| sums[k] + a[k] * b[k]);
    }
    let rest: f64 = last_a.iter().zip(last_b).map(|(a, b)| a * b).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// a ← a + Σ f b, of rows that are filled up.
#[inline(always)]
pub(crate) fn add<const N: usize>(a: &mut [f64], factors: [f64; N], rows: [&[f64]; N]) {
    let rows = rows.map(|row| row.as_chunks::<WIDTH>().0);
    for (at, a) in a.as_chunks_mut::<WIDTH>().0.iter_mut().enumerate() {
        let mut sums = *a;
        for (f, row) in factors.iter().zip(&rows) {
            let row = row[at];
            sums = core::array::from_fn(|k| sums[k] + f * row[k]);
        }
        *a = sums;
    }
}

/// Σ of entries and x in their columns, in four sums at a time.
#[inline(always)]
pub(super) fn sum_at(columns: &[usize], row: &[f64], x: &[f64]) -> f64 {
    let (columns, last_columns) = columns.as_chunks::<WIDTH>();
    let (row, last) = row.as_chunks::<WIDTH>();
    let mut sums = [0.0; WIDTH];
    for (columns, row) in columns.iter().zip(row) {
        (0..WIDTH).for_each(|k| sums[k] += row[k] * x[columns[k]]);
    }
    let rest: f64 = last_columns.iter().zip(last).map(|(&i, entry)| entry * x[i]).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}
