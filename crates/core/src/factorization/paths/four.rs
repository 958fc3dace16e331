//! Operations on rows, four entries at a time.

use core::array::from_fn;

/// The number of entries in one step.
pub const WIDTH: usize = 4;

pub type Four = [f64; WIDTH];

/// A padded row in units of four entries.
#[inline(always)]
pub fn fours(row: &[f64]) -> &[Four] {
    row.as_chunks().0
}

#[inline(always)]
pub fn fours_mut(row: &mut [f64]) -> &mut [Four] {
    row.as_chunks_mut().0
}

/// Runs the body for a range of fours in parts of N, starting at `at`. N is a constant in each part, so that
/// the compiler unrolls the part's loops.
macro_rules! in_parts {
    ($from:expr, $to:expr, |$n:ident, $at:ident| $body:block) => {{
        let (mut at, to): (usize, usize) = ($from, $to);
        macro_rules! part {
            ($count:literal) => {{
                const $n: usize = $count;
                let $at = at;
                $body
            }};
        }
        while at + 4 <= to {
            part!(4);
            at += 4;
        }
        match to - at {
            1 => part!(1),
            2 => part!(2),
            3 => part!(3),
            _ => {}
        }
    }};
}
pub(super) use in_parts;

/// Runs the body with N, the first number, as a constant if it is small.
#[doc(hidden)]
#[macro_export]
macro_rules! with_constant {
    ($number:expr, |$n:ident| $body:block) => {{
        macro_rules! with {
            ($value:expr) => {{
                const $n: usize = $value;
                $body
            }};
        }
        match $number {
            0 => with!(0),
            1 => with!(1),
            2 => with!(2),
            3 => with!(3),
            4 => with!(4),
            5 => with!(5),
            _ => {
                #[allow(non_snake_case)]
                let $n: usize = $number;
                $body
            }
        }
    }};
}
pub use with_constant;

/// a ← a − f b.
#[inline(always)]
pub fn subtract(a: &mut [Four], f: f64, b: &[Four]) {
    for (a, b) in a.iter_mut().zip(b) {
        // Reads all entries before it writes one, so that the compiler can vectorize.
        let old = *a;
        *a = from_fn(|k| old[k] - f * b[k]);
    }
}

/// The dot product of two rows of fours, in four sums side by side.
#[inline(always)]
pub fn product(a: &[Four], b: &[Four]) -> f64 {
    let mut products = a.iter().zip(b).map(|(a, b)| -> Four { from_fn(|k| a[k] * b[k]) });
    let Some(mut sums) = products.next() else { return 0.0 };
    products.for_each(|product| sums = from_fn(|k| sums[k] + product[k]));
    let [even, odd] = from_fn(|k| sums[k] + sums[k + 2]);
    even + odd
}

/// a ← a + Σ f b for padded rows.
#[inline(always)]
pub fn add<const N: usize>(a: &mut [f64], factors: [f64; N], rows: [&[f64]; N]) {
    let rows = rows.map(fours);
    for (at, a) in fours_mut(a).iter_mut().enumerate() {
        let mut sums = *a;
        for (f, row) in factors.iter().zip(&rows) {
            let row = row[at];
            sums = from_fn(|k| sums[k] + f * row[k]);
        }
        *a = sums;
    }
}

/// The same for the three rows of a block that are at least as long as `a`, if `a` is short.
#[inline(always)]
pub fn add_three(a: &mut [f64], [f, g, h]: [f64; 3], rows: &[f64]) {
    let (a, rows) = (fours_mut(a), fours(rows));
    let width = rows.len() / 3;
    let (r, rest) = rows.split_at(width);
    let (s, t) = rest.split_at(width);
    in_parts!(0, a.len(), |N, at| {
        let parts = [&r[at..], &s[at..], &t[at..]].map(|row| row.first_chunk::<N>());
        if let (Some(a), [Some(r), Some(s), Some(t)]) = (a[at..].first_chunk_mut::<N>(), parts) {
            for four in 0..N {
                let old = a[four];
                a[four] = from_fn(|k| ((old[k] + f * r[four][k]) + g * s[four][k]) + h * t[four][k]);
            }
        }
    });
}

/// Σ of entries times x in their columns, in four sums side by side.
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
