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
    let n = model.nv;
    let Workspace { carrier, slope_block, solved_block, inverse_block, path, .. } = workspace;
    let rows = &mut solved_block[..n];
    let (carrier, path, inverse) = (&carrier[..n], &mut path[..n], &mut inverse_block[..n]);
    for (b, first) in (0..n).step_by(WIDTH).enumerate() {
        let right = &slope_block[b * n..][..n];
        for i in (0..n).rev() {
            let end = if model.has_mimic { n } else { model.dofs[i].end };
            let (above, below) = rows.split_at_mut(i + 1);
            let (inverse_above, inverse_below) = inverse.split_at_mut(i + 1);
            let (row, own) = (&mut above[i], &mut inverse_above[i]);
            *own = [R::Number::zero(); WIDTH];
            if end <= first {
                *row = SlopeBlock::zero();
                continue;
            }
            // The row that was finished last comes last: the others need not wait for it.
            let count = end - (i + 1);
            let beyond = below[..count].iter().zip(&inverse_below[..count]);
            let column = l[(i + 1) * n..end * n].chunks_exact(n);
            let (mut x, mut y) = (right[i].by_position, right[i].by_velocity);
            let scale = l[i * n + i];
            if i < first + WIDTH {
                if first <= i {
                    own[i - first] = R::Number::one();
                }
                let mut z = *own;
                for ((row, own), factors) in beyond.zip(column).rev() {
                    let factor = -factors[i];
                    add_scaled(&mut x, factor, &row.by_position);
                    add_scaled(&mut y, factor, &row.by_velocity);
                    add_scaled(&mut z, factor, own);
                }
                *own = scaled(&z, scale);
            } else {
                for ((row, _), factors) in beyond.zip(column).rev() {
                    let factor = -factors[i];
                    add_scaled(&mut x, factor, &row.by_position);
                    add_scaled(&mut y, factor, &row.by_velocity);
                }
            }
            row.by_position = scaled(&x, scale);
            row.by_velocity = scaled(&y, scale);
        }
        let mut depth = 0;
        for k in 0..n {
            while depth > 0 && path[depth - 1] != carrier[k] {
                depth -= 1;
            }
            let factors = &l[k * n..][..n];
            let (mut row, mut own) = (rows[k], inverse[k]);
            for &i in &path[..depth] {
                let factor = factors[i];
                add_scaled(&mut row.by_position, factor, &rows[i].by_position);
                add_scaled(&mut row.by_velocity, factor, &rows[i].by_velocity);
                add_scaled(&mut own, -factor, &inverse[i]);
            }
            // The sign changes over: the rows above are −M⁻¹X and −M⁻¹Y.
            rows[k].by_position = scaled(&row.by_position, -factors[k]);
            rows[k].by_velocity = scaled(&row.by_velocity, -factors[k]);
            inverse[k] = scaled(&own, factors[k]);
            store::<S, R>(&rows[k].by_position, by_position, k, n, first);
            store::<S, R>(&rows[k].by_velocity, by_velocity, k, n, first);
            store::<S, R>(&inverse[k], by_force, k, n, first);
            path[depth] = k;
            depth += 1;
        }
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
