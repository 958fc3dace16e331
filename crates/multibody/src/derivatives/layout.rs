//! Where the entries of a matrix stand.

use dynamics::Scalar;

use crate::dispatch::Route;

/// Columns side by side.
pub(crate) const WIDTH: usize = 8;

/// A matrix as a run of numbers: entry (i, j) stands at `row` i + `group` ⌊j/8⌋ + j mod 8.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub grouped: bool,
    row: usize,
    group: usize,
}

/// Where row i and column i start: entry (i, j) stands at the row of i plus the column of j.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Address {
    pub row: usize,
    pub column: usize,
}

impl Layout {
    /// n×n, row-major.
    #[inline(always)]
    pub(super) fn dense(n: usize) -> Self {
        Self { grouped: false, row: n, group: WIDTH }
    }

    /// Groups of eight columns, each by rows.
    #[inline(always)]
    pub(super) fn groups(n: usize) -> Self {
        Self { grouped: true, row: WIDTH, group: WIDTH * n }
    }

    #[inline(always)]
    pub(super) fn address(self, i: usize) -> Address {
        Address { row: self.row * i, column: i / WIDTH * self.group + i % WIDTH }
    }
}

/// Writes eight numbers.
#[inline(always)]
pub(super) fn store<S: Scalar, R: Route<S>>(from: &[R::Number; WIDTH], to: &mut [S]) {
    let to = &mut to[..WIDTH];
    for l in 0..WIDTH {
        to[l] = R::store(from[l]);
    }
}

/// Writes as many numbers as there is room for.
#[inline(always)]
pub(super) fn store_first<S: Scalar, R: Route<S>>(from: &[R::Number; WIDTH], to: &mut [S]) {
    let (pairs, last) = to.as_chunks_mut::<2>();
    for (to, from) in pairs.iter_mut().zip(from.as_chunks::<2>().0) {
        *to = [R::store(from[0]), R::store(from[1])];
    }
    if let ([to], Some(&from)) = (last, from.get(2 * pairs.len())) {
        *to = R::store(from);
    }
}
