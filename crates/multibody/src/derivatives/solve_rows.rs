//! −M⁻¹X, −M⁻¹Y and M⁻¹ at once, given M = LᵀD L with the tree's zeros.
//!
//! Lᵀ first, from the last row: row i takes −L_ki times row k from every k beyond i. Then L, from the first: row k
//! takes −L_ki times row i from every i that carries it. Columns are taken by eights. Row i of L⁻ᵀX is
//! zero in the columns of freedoms that neither carry i nor are carried by it; L⁻ᵀ has entries at i and beyond only.

use dynamics::Scalar;

use super::layout::{WIDTH, store, store_first};
use super::scratch::Scratch;
use super::tree_factor::TreeFactor;
use crate::Model;
use crate::algebra::M3;
use crate::dispatch::Route;
use crate::sparse_cholesky::carriers;

/// Eight columns of one row of L⁻ᵀX, L⁻ᵀY and L⁻ᵀ; later of −M⁻¹X, −M⁻¹Y and M⁻¹. No load crosses a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Solved<S> {
    by_position: [S; WIDTH],
    by_velocity: [S; WIDTH],
    by_force: [S; WIDTH],
}

impl<S: Scalar> Solved<S> {
    pub(super) fn zero() -> Self {
        let zero = [S::zero(); WIDTH];
        Self { by_position: zero, by_velocity: zero, by_force: zero }
    }
}

/// Columns that are solved for at once, and the rows of L⁻ᵀX that are not zero there.
#[derive(Clone, Debug)]
pub(crate) struct ColumnGroup {
    first: usize,
    /// Eights of columns.
    eights: usize,
    /// The rows, ascending; and how many of them come before the first that row does not carry.
    rows: Vec<(usize, usize)>,
    /// How many of them lie before the last column's end.
    inside: usize,
    /// All other rows.
    absent: Vec<usize>,
}

/// The groups of columns of a model; `carrier` is λ. One state fills its registers by sixteen columns of three
/// matrices, several states by eight of one.
pub(super) fn column_groups<S: Scalar>(model: &Model, carrier: &[usize]) -> Vec<ColumnGroup> {
    let n = model.nv;
    let width = if M3::<S>::KEEPS_TRANSPOSE { 2 * WIDTH } else { WIDTH };
    let end = |i: usize| if model.has_mimic { n } else { model.dofs[i].end };
    let group = |first: usize| {
        let last = n.min(first + width);
        let meets = |i: &usize| {
            let own = first < end(*i) && *i < last;
            own || carriers(carrier, *i).any(|j| (first..last).contains(&j))
        };
        let (present, absent): (Vec<usize>, Vec<usize>) = (0..n).partition(meets);
        let until = |i: usize| present.partition_point(|&k| k < end(i));
        let inside = present.partition_point(|&i| i < last);
        let rows = present.iter().map(|&i| (i, until(i))).collect();
        ColumnGroup { first, eights: (last - first).div_ceil(WIDTH), rows, inside, absent }
    };
    (0..n).step_by(width).map(group).collect()
}

/// From X, Y and the factored M: −M⁻¹X, −M⁻¹Y and M⁻¹, row-major.
#[inline(always)]
pub(super) fn solve_rows<S: Scalar, R: Route<S>>(
    scratch: &mut Scratch<R::Number>,
    by_position: &mut [S],
    by_velocity: &mut [S],
    by_force: &mut [S],
) {
    let Scratch { mass, by_position: x, by_velocity: y, groups, solved, carriers, .. } = scratch;
    let mut to = [by_position, by_velocity, by_force];
    for group in groups.iter() {
        if group.eights == 2 {
            solve_transposed::<_, 2>(mass, group, x, y, solved);
            solve_lower::<S, R, 2>(mass, solved, carriers, group.first, &mut to);
        } else {
            solve_transposed::<_, 1>(mass, group, x, y, solved);
            solve_lower::<S, R, 1>(mass, solved, carriers, group.first, &mut to);
        }
    }
}

/// L⁻ᵀX, L⁻ᵀY and L⁻ᵀ for a group of C eights of columns.
#[inline(always)]
fn solve_transposed<S: Scalar, const C: usize>(
    mass: &TreeFactor<S>,
    group: &ColumnGroup,
    right_x: &[[S; WIDTH]],
    right_y: &[[S; WIDTH]],
    solved: &mut [[Solved<S>; 2]],
) {
    let (l, width) = mass.rows();
    let n = solved.len();
    let from = group.first / WIDTH * n;
    let (right_x, right_y) = (&right_x[from..][..C * n], &right_y[from..][..C * n]);
    let zero = [[S::zero(); WIDTH]; C];
    for &i in &group.absent {
        solved[i] = [Solved::zero(); 2];
    }
    for (at, &(i, until)) in group.rows.iter().enumerate().rev() {
        let depth = mass.depth(i);
        let (mut x, mut y, mut z) = (zero, zero, zero);
        for c in 0..C {
            (x[c], y[c]) = (right_x[c * n + i], right_y[c * n + i]);
        }
        // The row that was finished last comes last: the others need not wait for it.
        let inside = group.inside.clamp(at + 1, until);
        let (far, near) = (&group.rows[inside..until], &group.rows[at + 1..inside]);
        if M3::<S>::KEEPS_TRANSPOSE {
            for &(k, _) in far.iter().rev() {
                let (factor, row) = (l[k * width + depth], &solved[k]);
                for c in 0..C {
                    add_scaled(&mut x[c], factor, &row[c].by_position);
                    add_scaled(&mut y[c], factor, &row[c].by_velocity);
                }
            }
        } else {
            for c in 0..C {
                for &(k, _) in group.rows[at + 1..until].iter().rev() {
                    add_scaled(&mut x[c], l[k * width + depth], &solved[k][c].by_position);
                }
                for &(k, _) in group.rows[at + 1..until].iter().rev() {
                    add_scaled(&mut y[c], l[k * width + depth], &solved[k][c].by_velocity);
                }
            }
        }
        if at < group.inside {
            for c in 0..C {
                for j in 0..WIDTH {
                    z[c][j] = if group.first + c * WIDTH + j == i { S::one() } else { S::zero() };
                }
            }
            for &(k, _) in near.iter().rev() {
                let (factor, row) = (l[k * width + depth], &solved[k]);
                for c in 0..C {
                    if M3::<S>::KEEPS_TRANSPOSE {
                        add_scaled(&mut x[c], factor, &row[c].by_position);
                        add_scaled(&mut y[c], factor, &row[c].by_velocity);
                    }
                    add_scaled(&mut z[c], factor, &row[c].by_force);
                }
            }
        }
        let row = &mut solved[i];
        for c in 0..C {
            row[c] = Solved { by_position: x[c], by_velocity: y[c], by_force: z[c] };
        }
    }
}

/// The rest of the way for C eights of columns from `first` on, and the results.
#[inline(always)]
fn solve_lower<S: Scalar, R: Route<S>, const C: usize>(
    mass: &TreeFactor<R::Number>,
    solved: &[[Solved<R::Number>; 2]],
    carriers: &mut [[Solved<R::Number>; 2]],
    first: usize,
    [by_position, by_velocity, by_force]: &mut [&mut [S]; 3],
) {
    let n = solved.len();
    let (l, width) = mass.rows();
    let to = by_position
        .chunks_exact_mut(n)
        .zip(by_velocity.chunks_exact_mut(n))
        .zip(by_force.chunks_exact_mut(n));
    for ((k, (row, l)), ((to_x, to_y), to_z)) in solved.iter().zip(l.chunks_exact(width)).enumerate().zip(to)
    {
        let depth = mass.depth(k);
        let scale = l[depth];
        let zero = [[R::Number::zero(); WIDTH]; C];
        let (mut x, mut y, mut z) = (zero, zero, zero);
        for c in 0..C {
            // The sign changes over.
            x[c] = scaled(&row[c].by_position, -scale);
            y[c] = scaled(&row[c].by_velocity, -scale);
            z[c] = scaled(&row[c].by_force, scale);
        }
        if M3::<R::Number>::KEEPS_TRANSPOSE {
            for (&factor, carrier) in l[..depth].iter().zip(&*carriers) {
                for c in 0..C {
                    add_scaled(&mut x[c], factor, &carrier[c].by_position);
                    add_scaled(&mut y[c], factor, &carrier[c].by_velocity);
                    add_scaled(&mut z[c], factor, &carrier[c].by_force);
                }
            }
        } else {
            for c in 0..C {
                for (&factor, carrier) in l[..depth].iter().zip(&*carriers) {
                    add_scaled(&mut x[c], factor, &carrier[c].by_position);
                }
                for (&factor, carrier) in l[..depth].iter().zip(&*carriers) {
                    add_scaled(&mut y[c], factor, &carrier[c].by_velocity);
                }
                for (&factor, carrier) in l[..depth].iter().zip(&*carriers) {
                    add_scaled(&mut z[c], factor, &carrier[c].by_force);
                }
            }
        }
        let carrier = &mut carriers[depth];
        for c in 0..C {
            carrier[c] = Solved { by_position: x[c], by_velocity: y[c], by_force: z[c] };
            let at = first + c * WIDTH;
            let (to_x, to_y, to_z) = (&mut to_x[at..], &mut to_y[at..], &mut to_z[at..]);
            if at + WIDTH <= n {
                store::<S, R>(&x[c], to_x);
                store::<S, R>(&y[c], to_y);
                store::<S, R>(&z[c], to_z);
            } else {
                store_first::<S, R>(&carrier[c].by_position, to_x);
                store_first::<S, R>(&carrier[c].by_velocity, to_y);
                store_first::<S, R>(&carrier[c].by_force, to_z);
            }
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

/// k a.
#[inline(always)]
fn scaled<S: Scalar>(a: &[S; WIDTH], k: S) -> [S; WIDTH] {
    let mut scaled = *a;
    for j in 0..WIDTH {
        scaled[j] *= k;
    }
    scaled
}
