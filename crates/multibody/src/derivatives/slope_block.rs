//! ∂τ/∂q and ∂τ/∂v by blocks of columns, each block by rows: eight columns of a row in a few registers.

use dynamics::Scalar;

use crate::dispatch::Route;

/// Columns side by side.
pub(crate) const WIDTH: usize = 8;

/// Eight columns of one row of both matrices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlopeBlock<S> {
    pub(super) by_position: [S; WIDTH],
    pub(super) by_velocity: [S; WIDTH],
}

impl<S: Scalar> SlopeBlock<S> {
    pub(crate) fn zero() -> Self {
        let zero = [S::zero(); WIDTH];
        Self { by_position: zero, by_velocity: zero }
    }
}

/// How many blocks two nv×nv matrices fill.
pub(crate) fn slope_blocks(nv: usize) -> usize {
    nv * nv.div_ceil(WIDTH)
}

/// Writes eight columns of a row, or what is left of it.
#[inline(always)]
pub(super) fn store<S: Scalar, R: Route<S>>(
    from: &[R::Number; WIDTH],
    to: &mut [S],
    row: usize,
    nv: usize,
    first: usize,
) {
    let to = &mut to[row * nv + first..(row + 1) * nv];
    if let Some(to) = to.first_chunk_mut::<WIDTH>() {
        for l in 0..WIDTH {
            to[l] = R::store(from[l]);
        }
    } else {
        for (to, &from) in to.iter_mut().zip(from) {
            *to = R::store(from);
        }
    }
}
