//! M = LᵀD L without the tree's zeros, O(n depth²), by tiles of rows with the same zeros.
//!
//! Eliminating from the last coordinate to the first causes no fill-in. Row k of the unit lower triangular L
//! has entries only at the ancestors of k. **(RBDA §6.5)** Entries are stored by depth, so the rows of all
//! ancestors start with the same columns. With mimic joints the coordinates do not form a tree. Then each
//! coordinate's parent is the previous one, and the rows are those of the dense triangle.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::M3;

use crate::factorization::tile::{TALLEST, Tile, WIDTH, by_count, tiles};

/// A lower triangle, each row's entries by depth, padded for whole blocks.
#[derive(Clone, Debug)]
pub struct TreeFactor<S> {
    /// The number of ancestors of each coordinate.
    depth: Vec<usize>,
    pub(crate) tiles: Vec<Tile>,
    /// The length of a row.
    width: usize,
    /// M; after elimination D L.
    rows: Vec<S>,
    /// −L below the diagonal, D⁻¹ on it. Entries above the diagonal are meaningless.
    lower: Vec<S>,
    /// A vector, by depth.
    scratch: Vec<S>,
}

impl<S: Scalar> TreeFactor<S> {
    /// `dof_parent` is λ.
    pub(crate) fn new(dof_parent: &[usize]) -> Self {
        let tallest = if M3::<S>::KEEPS_TRANSPOSE { TALLEST } else { 1 };
        let tiles = tiles(dof_parent, tallest, |_| true);
        let depth: Vec<usize> = tiles.iter().flat_map(|tile| tile.depth..tile.depth + tile.rows).collect();
        let deepest = depth.iter().max().map_or(0, |deepest| deepest + 1);
        let width = deepest.next_multiple_of(WIDTH);
        let zero = S::zero();
        Self {
            rows: vec![zero; width * depth.len()],
            lower: vec![zero; width * depth.len()],
            scratch: vec![zero; deepest],
            tiles,
            width,
            depth,
        }
    }

    /// The number of ancestors of coordinate k.
    #[inline(always)]
    pub(crate) fn depth(&self, k: usize) -> usize {
        self.depth[k]
    }

    /// The number of coordinates.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.depth.len()
    }

    /// The length of the longest row.
    #[inline(always)]
    pub(crate) fn deepest(&self) -> usize {
        self.scratch.len()
    }

    /// Row k of M, by depth.
    #[inline(always)]
    pub(crate) fn row_mut(&mut self, k: usize) -> &mut [S] {
        &mut self.rows[k * self.width..][..self.width]
    }

    /// −L and D⁻¹, and the length of a row.
    #[inline(always)]
    pub(crate) fn lower(&self) -> (&[S], usize) {
        (&self.lower, self.width)
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.rows.fill(S::zero());
    }

    /// Replaces M by L and D.
    #[inline(always)]
    pub(crate) fn factor(&mut self) {
        for at in (0..self.tiles.len()).rev() {
            let tile = self.tiles[at];
            by_count!(tile.rows, factor_tile::<S>(self, tile));
        }
    }

    /// W columns of a tile's rows of M, less the contributions of the rows beyond.
    #[inline(always)]
    fn less_beyond<const H: usize, const W: usize>(
        &self,
        Tile { first, depth, end, .. }: Tile,
        column: usize,
    ) -> [[S; W]; H] {
        let Self { rows, lower, width, .. } = self;
        let mut sum = [[S::zero(); W]; H];
        for i in 0..H {
            sum[i] = *part(rows, (first + i) * width + column);
        }
        for k in (first + H..end).rev() {
            let factors: &[S; H] = part(lower, k * width + depth);
            let row: &[S; W] = part(rows, k * width + column);
            for i in 0..H {
                add_scaled(&mut sum[i], factors[i], row);
            }
        }
        sum
    }

    /// W columns of a tile, from its diagonal block after elimination and −D⁻¹.
    #[inline(always)]
    fn eliminate<const H: usize, const W: usize>(
        &mut self,
        tile: Tile,
        column: usize,
        square: &[[S; H]; H],
        minus: &[S; H],
    ) {
        let mut sum = self.less_beyond::<H, W>(tile, column);
        let Self { rows, lower, width, .. } = self;
        let (first, width) = (tile.first, *width);
        for i in (0..H).rev() {
            let row = scaled(&sum[i], minus[i]);
            for j in 0..i {
                add_scaled(&mut sum[j], square[i][j], &row);
            }
            *part_mut(rows, (first + i) * width + column) = sum[i];
            *part_mut(lower, (first + i) * width + column) = row;
        }
    }

    /// x ← M⁻¹ x, after [`TreeFactor::factor`].
    #[inline(always)]
    pub(crate) fn solve(&mut self, x: &mut [S]) {
        let Self { tiles, lower, width, scratch, depth, .. } = self;
        let x = &mut x[..depth.len()];
        for tile in tiles.iter().rev() {
            by_count!(tile.rows, solve_transposed::<S>(lower, *width, *tile, x));
        }
        for tile in &*tiles {
            by_count!(tile.rows, solve_lower::<S>(lower, *width, *tile, x, scratch));
        }
    }
}

/// [`TreeFactor::factor`] for one tile, after those beyond it.
#[inline(always)]
fn factor_tile<S: Scalar, const H: usize>(factor: &mut TreeFactor<S>, tile: Tile) {
    let Tile { first, depth, .. } = tile;
    // The diagonal block first.
    let mut square: [[S; H]; H] = factor.less_beyond(tile, depth);
    let mut minus = [S::zero(); H];
    let mut own = [[S::zero(); H]; H];
    for i in (0..H).rev() {
        let inverse = S::one() / square[i][i];
        minus[i] = -inverse;
        own[i] = scaled(&square[i], minus[i]);
        for j in 0..i {
            let factor = square[i][j];
            add_scaled(&mut square[j], factor, &own[i]);
        }
        own[i][i] = inverse;
    }

    // One state fills its registers with wide columns; several states would waste whole registers.
    if M3::<S>::KEEPS_TRANSPOSE {
        for column in (0..depth).step_by(WIDTH) {
            factor.eliminate::<H, WIDTH>(tile, column, &square, &minus);
        }
    } else {
        for column in (0..depth).step_by(TALLEST) {
            factor.eliminate::<H, TALLEST>(tile, column, &square, &minus);
        }
    }
    for i in 0..H {
        factor.lower[(first + i) * factor.width + depth..][..=i].copy_from_slice(&own[i][..=i]);
    }
}

/// L⁻ᵀ.
#[inline(always)]
fn solve_transposed<S: Scalar, const H: usize>(
    lower: &[S],
    width: usize,
    Tile { first, depth, end, .. }: Tile,
    x: &mut [S],
) {
    let mut sum = *part::<S, H>(x, first);
    for k in (first + H..end).rev() {
        add_scaled(&mut sum, x[k], part(lower, k * width + depth));
    }
    for i in (1..H).rev() {
        let row: &[S; H] = part(lower, (first + i) * width + depth);
        for j in 0..i {
            sum[j] = row[j].mul_add(sum[i], sum[j]);
        }
    }
    *part_mut(x, first) = sum;
}

/// L⁻¹ D⁻¹.
#[inline(always)]
fn solve_lower<S: Scalar, const H: usize>(
    lower: &[S],
    width: usize,
    Tile { first, depth, .. }: Tile,
    x: &mut [S],
    solved: &mut [S],
) {
    let mut sum = *part::<S, H>(x, first);
    let row = |i| &lower[(first + i) * width..][..depth + H];
    for i in 0..H {
        let row = row(i);
        sum[i] *= row[depth + i];
        for (&factor, &x) in row[..depth].iter().zip(&*solved) {
            sum[i] = factor.mul_add(x, sum[i]);
        }
    }
    for i in 0..H {
        for j in 0..i {
            sum[i] = row(i)[depth + j].mul_add(sum[j], sum[i]);
        }
    }
    *part_mut(x, first) = sum;
    *part_mut(solved, depth) = sum;
}

/// N numbers from an index on.
#[inline(always)]
pub(crate) fn part<S, const N: usize>(numbers: &[S], from: usize) -> &[S; N] {
    numbers[from..].first_chunk().expect("rows have room for whole tiles")
}

#[inline(always)]
pub(crate) fn part_mut<S, const N: usize>(numbers: &mut [S], from: usize) -> &mut [S; N] {
    numbers[from..].first_chunk_mut().expect("rows have room for whole tiles")
}

/// a ← a + k x.
#[inline(always)]
pub(crate) fn add_scaled<S: Scalar, const N: usize>(a: &mut [S; N], k: S, x: &[S; N]) {
    for j in 0..N {
        a[j] = k.mul_add(x[j], a[j]);
    }
}

/// k a.
#[inline(always)]
pub(crate) fn scaled<S: Scalar, const N: usize>(a: &[S; N], k: S) -> [S; N] {
    let mut scaled = *a;
    for j in 0..N {
        scaled[j] *= k;
    }
    scaled
}
