//! From the tips to the root and back: what is solved and multiplied by packed rows.
//!
//! The rows of a branch whose diagonals are in one four have equally many fours to the left of them. That many is a constant of the loops over
//! them, in which the path's entries stay in registers.

use core::ops::Range;

use super::four::{Four, WIDTH, fours, product, product_of, subtract, sum_at, with_constant};
use super::{Branch, LONGEST, Paths};

/// A path's entries.
type Path = [Four; LONGEST / WIDTH];

/// Rows of a branch whose diagonals are in one four.
struct Run {
    rows: Range<usize>,
    /// How many fours are left of the one with the diagonals, and where in that the first diagonal is.
    fours: usize,
    first: usize,
    /// The first row's first four.
    begin: usize,
}

impl Paths {
    #[inline(always)]
    pub(super) fn solve_here(&self, l: &[f64], x: &mut [f64]) {
        if self.is_long {
            for (k, columns, row, _) in self.rows(l).rev() {
                let own = x[k];
                columns.iter().zip(row).for_each(|(&i, l)| x[i] -= l * own);
            }
            for (k, columns, row, pivot) in self.rows(l) {
                x[k] = x[k] / pivot - sum_at(columns, row, x);
            }
            return;
        }
        let (l, mut path) = (fours(l), [[0.0; WIDTH]; LONGEST / WIDTH]);
        for branch in self.branches.iter().rev() {
            let (to_branch, own) = path.as_flattened_mut().split_at_mut(branch.depth);
            to_branch.fill(0.0);
            own[..branch.end - branch.first].copy_from_slice(&x[branch.first..branch.end]);
            let mut end = branch.end;
            while end > branch.first {
                let run = self.last_run(branch, end);
                end = run.rows.start;
                let x = &mut x[run.rows.clone()];
                with_constant!(run.fours, |N| { sweep_inward(N, &run, l, &mut path, x) });
            }
            self.path_to(branch).iter().zip(path.as_flattened()).for_each(|(&i, sum)| x[i] += sum);
        }
        for branch in &self.branches {
            self.gather(branch, x, &mut path);
            let mut first = branch.first;
            while first < branch.end {
                let run = self.first_run(branch, first);
                first = run.rows.end;
                let x = &mut x[run.rows.clone()];
                with_constant!(run.fours, |N| { sweep_outward(N, &run, l, &mut path, x) });
            }
        }
    }

    #[inline(always)]
    pub(super) fn multiply_here(&self, m: &[f64], x: &[f64], to: &mut [f64]) {
        if self.is_long {
            for (k, columns, row, diagonal) in self.rows(m) {
                let own = x[k];
                columns.iter().zip(row).for_each(|(&i, m)| to[i] += m * own);
                to[k] = diagonal * own + sum_at(columns, row, x);
            }
            return;
        }
        to.fill(0.0);
        let m = fours(m);
        let (mut path, mut sums) = ([[0.0; WIDTH]; LONGEST / WIDTH], [[0.0; WIDTH]; LONGEST / WIDTH]);
        for branch in &self.branches {
            let (depth, count) = (branch.depth, branch.end - branch.first);
            self.gather(branch, x, &mut path);
            path.as_flattened_mut()[depth..][..count].copy_from_slice(&x[branch.first..branch.end]);
            sums.as_flattened_mut()[..depth + count].fill(0.0);
            let mut end = branch.end;
            while end > branch.first {
                let run = self.last_run(branch, end);
                end = run.rows.start;
                let to = &mut to[run.rows.clone()];
                with_constant!(run.fours, |N| { sweep_both(N, &run, m, (&path, &mut sums), to) });
            }
            self.path_to(branch).iter().zip(sums.as_flattened()).for_each(|(&i, sum)| to[i] += sum);
        }
    }

    /// The entries of what carries a branch.
    #[inline(always)]
    fn gather(&self, branch: &Branch, x: &[f64], path: &mut Path) {
        let columns = self.path_to(branch);
        path.as_flattened_mut().iter_mut().zip(columns).for_each(|(to, &i)| *to = x[i]);
    }

    /// The rows before `end` with one another.
    #[inline(always)]
    fn last_run(&self, branch: &Branch, end: usize) -> Run {
        let last = branch.depth + (end - branch.first) - 1;
        let fours = last / WIDTH;
        let first = (fours * WIDTH).max(branch.depth);
        self.run(end - (last + 1 - first)..end, fours, first)
    }

    /// The rows from `first` on with one another.
    #[inline(always)]
    fn first_run(&self, branch: &Branch, start: usize) -> Run {
        let first = branch.depth + (start - branch.first);
        let fours = first / WIDTH;
        let end = (start + ((fours + 1) * WIDTH - first)).min(branch.end);
        self.run(start..end, fours, first)
    }

    #[inline(always)]
    fn run(&self, rows: Range<usize>, fours: usize, first: usize) -> Run {
        Run { begin: self.rows[rows.start].begin / WIDTH, first: first % WIDTH, rows, fours }
    }
}

/// Runs the body for each of a run's rows, with its diagonal's place in the four as a constant.
macro_rules! each_row {
    ($run:ident, [$($place:literal)*], |$at:ident| $body:block) => {
        $(
            if $run.first <= $place && $place < $run.first + $run.rows.len() {
                const $at: usize = $place;
                $body
            }
        )*
    };
}

/// x ← L⁻ᵀx of a run's rows, and what it takes from those that carry them.
#[inline(always)]
fn sweep_inward(n: usize, run: &Run, l: &[Four], path: &mut Path, x: &mut [f64]) {
    let rows = &l[run.begin..][..x.len() * (n + 1)];
    let (path, [own, ..]) = path.split_at_mut(n) else { return };
    let mut done = *own;
    each_row!(run, [3 2 1 0], |AT| {
        let row = &rows[(AT - run.first) * (n + 1)..][..=n];
        // It is done, and so is what follows it: there products may go to it.
        let value = done[AT];
        x[AT - run.first] = value;
        subtract(path, value, &row[..n]);
        subtract(core::slice::from_mut(&mut done), value, &row[n..]);
    });
    *own = done;
}

/// x ← L⁻¹D⁻¹x of a run's rows.
#[inline(always)]
fn sweep_outward(n: usize, run: &Run, l: &[Four], path: &mut Path, x: &mut [f64]) {
    let rows = &l[run.begin..][..x.len() * (n + 1)];
    let (path, [own, ..]) = path.split_at_mut(n) else { return };
    let mut done = *own;
    each_row!(run, [0 1 2 3], |AT| {
        let row = &rows[(AT - run.first) * (n + 1)..][..=n];
        let x = &mut x[AT - run.first];
        *x = *x / row[n][AT] - (product(&row[..n], path) + product_of::<AT>(&row[n], &done));
        done[AT] = *x;
    });
    *own = done;
}

/// M x of a run's rows, and what it adds to those that carry them.
#[inline(always)]
fn sweep_both(n: usize, run: &Run, m: &[Four], (path, sums): (&Path, &mut Path), to: &mut [f64]) {
    let rows = &m[run.begin..][..to.len() * (n + 1)];
    let ((path, [own, ..]), (sums, [own_sums, ..])) = (path.split_at(n), sums.split_at_mut(n)) else {
        return;
    };
    let mut done = *own_sums;
    each_row!(run, [3 2 1 0], |AT| {
        let row = &rows[(AT - run.first) * (n + 1)..][..=n];
        let value = own[AT];
        to[AT - run.first] += done[AT] + row[n][AT] * value + (product(&row[..n], path) + product_of::<AT>(&row[n], own));
        // What follows it on the path is done.
        subtract(sums, -value, &row[..n]);
        subtract(core::slice::from_mut(&mut done), -value, &row[n..]);
    });
    *own_sums = done;
}
