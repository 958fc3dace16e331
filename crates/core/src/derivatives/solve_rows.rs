//! Computes −M⁻¹X, −M⁻¹Y and M⁻¹ together, from M = LᵀD L with the tree's zeros.
//!
//! The sweep with Lᵀ starts at the last row and subtracts L_ki times row k from row i for every descendant k.
//! The sweep with L starts at the first row and subtracts L_ki times row i from row k for every ancestor i.
//! Rows are processed by tiles, columns by groups of eight. Row i of L⁻ᵀX is zero in the columns of DoFs on
//! other branches. L⁻ᵀ has entries only at i and beyond.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;
use robot_dynamics_number::dispatch::Hardware;

use crate::factorization::tile::{Tile, WIDTH, by_count, each};
use crate::factorization::tree_factor::{TreeFactor, add_scaled, part, part_mut, scaled};
use crate::workspace::derivatives::DerivativeBuffers;
use crate::workspace::passes::{Pass, SolvedColumns, TileRange};

/// The indices of the matrices in a row.
const X: usize = 0;
const Y: usize = 1;
const Z: usize = 2;

/// From X, Y and the factored M: −M⁻¹X, −M⁻¹Y and M⁻¹, row-major.
#[inline(always)]
pub(super) fn solve_rows<N: Scalar, H: Hardware>(
    scratch: &mut DerivativeBuffers<N>,
    by_position: &mut [N],
    by_velocity: &mut [N],
    by_force: &mut [N],
) {
    let DerivativeBuffers { mass, by_position: x, by_velocity: y, passes, solved, ancestors, unit, .. } =
        scratch;
    let right = RightSides { x, y, unit };
    let mut to = [by_position, by_velocity, by_force];
    let n = mass.len();
    for pass in passes.iter() {
        let solved = &mut solved[pass.groups.start * n..pass.groups.end * n];
        for (tile, places) in mass.tiles.iter().zip(&pass.places).rev() {
            by_count!(tile.rows, solve_transposed::<N, H>(mass, *tile, pass, places, &right, solved));
        }
        let column = pass.groups.start * WIDTH;
        for tile in &mass.tiles {
            by_count!(tile.rows, solve_lower::<N, H>(mass, *tile, solved, ancestors, column, &mut to));
        }
    }
}

/// Whether a tile's rows of all matrices fit in the registers.
const fn all_at_once<N: Scalar, H: Hardware>() -> bool {
    H::HAS_32_REGISTERS && M3::<N>::KEEPS_TRANSPOSE
}

/// The right sides, in rows padded to multiples of eight.
struct RightSides<'a, S> {
    x: &'a [[S; WIDTH]],
    y: &'a [[S; WIDTH]],
    /// A one among zeros: eight consecutive numbers of it are a block of a unit row, or zero.
    unit: &'a [S; 2 * WIDTH],
}

/// L⁻ᵀX, L⁻ᵀY and L⁻ᵀ.
#[inline(always)]
fn solve_transposed<N: Scalar, H: Hardware, const ROWS: usize>(
    mass: &TreeFactor<N>,
    tile: Tile,
    pass: &Pass,
    places: &[TileRange],
    right: &RightSides<'_, N>,
    solved: &mut [SolvedColumns<N>],
) {
    let n = mass.len();
    let (first, eights) = (tile.first, n.div_ceil(WIDTH));
    let (l, width) = mass.lower();
    // −L between the tile's own rows.
    let mut own = [[N::zero(); ROWS]; ROWS];
    let (mut x, mut y) = ([&right.x[..0]; ROWS], [&right.y[..0]; ROWS]);
    each!(ROWS, i => {
        own[i] = *part(l, (first + i) * width + tile.depth);
        let from = (first + i) * eights + pass.groups.start;
        x[i] = &right.x[from..][..pass.groups.len()];
        y[i] = &right.y[from..][..pass.groups.len()];
    });
    let l = &l[tile.depth..];
    for &TileRange { group, from, until, inside } in places {
        let solved = &mut solved[group * n..][..n];
        let beyond = &pass.rows[group][from..until];
        if all_at_once::<N, H>() {
            let mut xy = [[[N::zero(); WIDTH]; 2]; ROWS];
            each!(ROWS, i => xy[i] = [x[i][group], y[i][group]]);
            take_beyond::<_, ROWS, X, 2>(l, width, &own, beyond, first, xy, solved);
        } else {
            let mut one = [[[N::zero(); WIDTH]; 1]; ROWS];
            each!(ROWS, i => one[i] = [x[i][group]]);
            take_beyond::<_, ROWS, X, 1>(l, width, &own, beyond, first, one, solved);
            each!(ROWS, i => one[i] = [y[i][group]]);
            take_beyond::<_, ROWS, Y, 1>(l, width, &own, beyond, first, one, solved);
        }
        let column = (pass.groups.start + group) * WIDTH;
        if first < column + WIDTH {
            let mut z = [[[N::zero(); WIDTH]; 1]; ROWS];
            each!(ROWS, i => {
                let own = (first + i).wrapping_sub(column);
                z[i] = [*part(right.unit, WIDTH.saturating_sub(own))];
            });
            take_beyond::<_, ROWS, Z, 1>(l, width, &own, &beyond[..inside], first, z, solved);
        }
    }
}

/// Subtracts L_ki times the rows k beyond from a tile's rows of L⁻ᵀ times P matrices, of which M is the
/// first.
#[inline(always)]
fn take_beyond<S: Scalar, const ROWS: usize, const M: usize, const P: usize>(
    l: &[S],
    width: usize,
    own: &[[S; ROWS]; ROWS],
    beyond: &[usize],
    first: usize,
    mut sum: [[[S; WIDTH]; P]; ROWS],
    solved: &mut [SolvedColumns<S>],
) {
    // The row finished last comes last, so that the others do not wait for it.
    for &k in beyond.iter().rev() {
        let factors: &[S; ROWS] = part(l, k * width);
        let row: &[[S; WIDTH]; P] = part(&solved[k].0, M);
        each!(ROWS, i => each!(P, m => add_scaled(&mut sum[i][m], factors[i], &row[m])));
    }
    each!(ROWS, back => {
        let i = ROWS - 1 - back;
        // Every j < i. The count must be a constant expression, so it is also evaluated for absent rows.
        each!((ROWS - 1).saturating_sub(back), j => each!(P, m => {
            let row = sum[i][m];
            add_scaled(&mut sum[j][m], own[i][j], &row);
        }));
    });
    let to = &mut solved[first..][..ROWS];
    each!(ROWS, i => *part_mut(&mut to[i].0, M) = sum[i]);
}

/// The sweep with L, and the results.
#[inline(always)]
fn solve_lower<N: Scalar, H: Hardware, const ROWS: usize>(
    mass: &TreeFactor<N>,
    Tile { first, depth, .. }: Tile,
    solved: &[SolvedColumns<N>],
    ancestors: &mut [SolvedColumns<N>],
    column: usize,
    to: &mut [&mut [N]; 3],
) {
    let n = mass.len();
    let (l, width) = mass.lower();
    let mut rows = [&l[..0]; ROWS];
    each!(ROWS, i => rows[i] = &l[(first + i) * width..][..depth + ROWS]);
    let groups = solved.chunks_exact(n).zip(ancestors.chunks_exact_mut(mass.deepest())).enumerate();
    // From the last group: padding beyond a row's end overwrites the start of the next row, which is written
    // later.
    for (group, (solved, ancestors)) in groups.rev() {
        let own: &[_; ROWS] = part(solved, first);
        let at = first * n + column + group * WIDTH;
        if all_at_once::<N, H>() {
            take_ancestors::<_, ROWS, X, 3>(&rows, depth, own, ancestors, to, at, n);
        } else {
            take_ancestors::<_, ROWS, X, 1>(&rows, depth, own, ancestors, to, at, n);
            take_ancestors::<_, ROWS, Y, 1>(&rows, depth, own, ancestors, to, at, n);
            take_ancestors::<_, ROWS, Z, 1>(&rows, depth, own, ancestors, to, at, n);
        }
    }
}

/// A tile's rows of P matrices, of which M is the first.
#[inline(always)]
fn take_ancestors<N: Scalar, const ROWS: usize, const M: usize, const P: usize>(
    rows: &[&[N]; ROWS],
    depth: usize,
    own: &[SolvedColumns<N>; ROWS],
    ancestors: &mut [SolvedColumns<N>],
    to: &mut [&mut [N]; 3],
    at: usize,
    n: usize,
) {
    let mut sum = [[[N::zero(); WIDTH]; P]; ROWS];
    each!(ROWS, i => each!(P, m => {
        let scale = rows[i][depth + i];
        // The sign changes for X and Y.
        sum[i][m] = scaled(&own[i].0[M + m], if M + m == Z { scale } else { -scale });
    }));
    for (p, SolvedColumns(ancestor)) in ancestors[..depth].iter().enumerate() {
        let ancestor: &[_; P] = part(ancestor, M);
        each!(ROWS, i => each!(P, m => add_scaled(&mut sum[i][m], rows[i][p], &ancestor[m])));
    }
    let ancestors = &mut ancestors[depth..][..ROWS];
    each!(ROWS, i => {
        each!(i, j => each!(P, m => {
            let row = sum[j][m];
            add_scaled(&mut sum[i][m], rows[i][depth + j], &row);
        }));
        *part_mut(&mut ancestors[i].0, M) = sum[i];
    });
    each!(ROWS, i => each!(P, m => {
        store(&sum[i][m], &ancestors[i].0[M + m], to[M + m], at + i * n);
    }));
}

/// Writes eight numbers, or as many as there is memory for.
#[inline(always)]
fn store<N: Scalar>(row: &[N; WIDTH], same: &[N; WIDTH], to: &mut [N], at: usize) {
    if let Some(to) = to.get_mut(at..at + WIDTH) {
        to.copy_from_slice(row);
    } else {
        store_end(same, &mut to[at..]);
    }
}

/// The end of the last row. A separate function that works from memory, because inlining it would use
/// registers that the main path needs.
#[cold]
#[inline(never)]
fn store_end<N: Scalar>(row: &[N; WIDTH], to: &mut [N]) {
    for (to, &from) in to.iter_mut().zip(row) {
        *to = from;
    }
}
