//! −M⁻¹ X, −M⁻¹ Y and M⁻¹ at once, given M = LᵀL with the tree's zeros.

use dynamics::Scalar;

use super::slope_block::{SlopeBlock, WIDTH, store};
use crate::dispatch::Route;
use crate::{Model, Workspace};

/// From X and Y in `workspace.slope_block` and L of [`factor`](crate::sparse_cholesky::factor): −M⁻¹X, −M⁻¹Y and
/// M⁻¹, row-major.
///
/// Lᵀ first, from the last row: row i takes L_ki times row k from every k beyond i. Then L, from the first: row k
/// takes L_ki times row i from every i that carries it. Row i of L⁻ᵀX has zeros to the right of all that is
/// beyond i, as the tree has; L⁻ᵀ has them to the left of i, too.
#[inline(always)]
pub(super) fn solve_rows<S: Scalar, R: Route<S>>(
    model: &Model,
    workspace: &mut Workspace<R::Number>,
    l: &[R::Number],
    by_position: &mut [S],
    by_velocity: &mut [S],
    by_force: &mut [S],
) {
    let mut to = [by_position, by_velocity, by_force];
    let blocks = model.nv.div_ceil(WIDTH);
    for b in (0..blocks - blocks % 2).step_by(2) {
        solve_blocks::<S, R, 2>(model, workspace, l, b, &mut to);
    }
    if blocks % 2 == 1 {
        solve_blocks::<S, R, 1>(model, workspace, l, blocks - 1, &mut to);
    }
}

/// [`solve_rows`] for C blocks of columns from block `b` on: the factors are fetched once for all.
#[inline(always)]
fn solve_blocks<S: Scalar, R: Route<S>, const C: usize>(
    model: &Model,
    workspace: &mut Workspace<R::Number>,
    l: &[R::Number],
    b: usize,
    [by_position, by_velocity, by_force]: &mut [&mut [S]; 3],
) {
    let n = model.nv;
    let first = b * WIDTH;
    let Workspace { carrier, slope_block, solved_block, inverse_block, path, .. } = workspace;
    let (carrier, path) = (&carrier[..n], &mut path[..n]);
    let right = &slope_block[b * n..][..C * n];
    let rows = &mut solved_block.as_chunks_mut::<C>().0[..n];
    let inverse = &mut inverse_block.as_chunks_mut::<C>().0[..n];
    let zero = [R::Number::zero(); WIDTH];
    for i in (0..n).rev() {
        let end = if model.has_mimic { n } else { model.dofs[i].end };
        let (above, below) = rows.split_at_mut(i + 1);
        let (inverse_above, inverse_below) = inverse.split_at_mut(i + 1);
        let (row, own) = (&mut above[i], &mut inverse_above[i]);
        *own = [zero; C];
        if end <= first {
            *row = [SlopeBlock::zero(); C];
            continue;
        }
        // The row that was finished last comes last: the others need not wait for it.
        let count = end - (i + 1);
        let beyond = below[..count].iter().zip(&inverse_below[..count]);
        let column = l[(i + 1) * n..end * n].chunks_exact(n);
        let (mut x, mut y) = ([zero; C], [zero; C]);
        for c in 0..C {
            (x[c], y[c]) = (right[c * n + i].by_position, right[c * n + i].by_velocity);
        }
        let scale = l[i * n + i];
        if i < first + C * WIDTH {
            if first <= i {
                own[(i - first) / WIDTH][(i - first) % WIDTH] = R::Number::one();
            }
            let mut z = *own;
            for ((row, own), factors) in beyond.zip(column).rev() {
                let factor = -factors[i];
                for c in 0..C {
                    add_scaled(&mut x[c], factor, &row[c].by_position);
                    add_scaled(&mut y[c], factor, &row[c].by_velocity);
                    add_scaled(&mut z[c], factor, &own[c]);
                }
            }
            for c in 0..C {
                own[c] = scaled(&z[c], scale);
            }
        } else {
            for ((row, _), factors) in beyond.zip(column).rev() {
                let factor = -factors[i];
                for c in 0..C {
                    add_scaled(&mut x[c], factor, &row[c].by_position);
                    add_scaled(&mut y[c], factor, &row[c].by_velocity);
                }
            }
        }
        for c in 0..C {
            row[c].by_position = scaled(&x[c], scale);
            row[c].by_velocity = scaled(&y[c], scale);
        }
    }
    let mut depth = 0;
    for k in 0..n {
        while depth > 0 && path[depth - 1] != carrier[k] {
            depth -= 1;
        }
        let factors = &l[k * n..][..n];
        let (mut x, mut y, mut z) = ([zero; C], [zero; C], inverse[k]);
        for c in 0..C {
            (x[c], y[c]) = (rows[k][c].by_position, rows[k][c].by_velocity);
        }
        for &i in &path[..depth] {
            let factor = factors[i];
            let (row, own) = (&rows[i], &inverse[i]);
            for c in 0..C {
                add_scaled(&mut x[c], factor, &row[c].by_position);
                add_scaled(&mut y[c], factor, &row[c].by_velocity);
                add_scaled(&mut z[c], -factor, &own[c]);
            }
        }
        // The sign changes over: the rows above are −M⁻¹X and −M⁻¹Y.
        for c in 0..C {
            rows[k][c].by_position = scaled(&x[c], -factors[k]);
            rows[k][c].by_velocity = scaled(&y[c], -factors[k]);
            inverse[k][c] = scaled(&z[c], factors[k]);
            let at = first + c * WIDTH;
            store::<S, R>(&rows[k][c].by_position, by_position, k, n, at);
            store::<S, R>(&rows[k][c].by_velocity, by_velocity, k, n, at);
            store::<S, R>(&inverse[k][c], by_force, k, n, at);
        }
        path[depth] = k;
        depth += 1;
    }
}

/// a ← a + k x.
#[inline(always)]
fn add_scaled<S: Scalar>(a: &mut [S; WIDTH], k: S, x: &[S; WIDTH]) {
    for j in 0..WIDTH {
        a[j] = k.mul_add(x[j], a[j]);
    }
}

#[inline(always)]
fn scaled<S: Scalar>(a: &[S; WIDTH], k: S) -> [S; WIDTH] {
    let mut scaled = *a;
    for j in 0..WIDTH {
        scaled[j] *= k;
    }
    scaled
}
