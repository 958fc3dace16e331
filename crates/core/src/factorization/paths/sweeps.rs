//! The sweeps over packed rows that solve and multiply: from the leaves to the root and back.
//!
//! Rows of a branch whose diagonals lie in the same four have equally many fours left of it. That number is a
//! constant in the loops over these rows.

use super::four::{Four, WIDTH, fours, product, subtract, sum_at, with_constant};
use super::pattern::{LONGEST, Paths, Run};

/// A path's entries.
type Path = [Four; LONGEST / WIDTH];

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
            let runs = &self.runs[branch.runs.clone()];
            clear(runs, &mut path);
            for run in runs.iter().rev() {
                let x = &mut x[run.rows.clone()];
                with_constant!(run.fours, |N| { sweep_inward(N, run, l, &mut path, x) });
            }
            self.path_to(branch).iter().zip(path.as_flattened()).for_each(|(&i, sum)| x[i] += sum);
        }
        for branch in &self.branches {
            let runs = &self.runs[branch.runs.clone()];
            clear(runs, &mut path);
            gather(self.path_to(branch), x, &mut path);
            for run in runs {
                let x = &mut x[run.rows.clone()];
                with_constant!(run.fours, |N| { sweep_outward(N, run, l, &mut path, x) });
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
            let runs = &self.runs[branch.runs.clone()];
            let last = self.rows[branch.end - 1];
            gather(&self.columns[last.begin..=last.diagonal], x, &mut path);
            clear(runs, &mut sums);
            for run in runs.iter().rev() {
                let to = &mut to[run.rows.clone()];
                with_constant!(run.fours, |N| { sweep_both(N, run, m, (&path, &mut sums), to) });
            }
            self.path_to(branch).iter().zip(sums.as_flattened()).for_each(|(&i, sum)| to[i] += sum);
        }
    }
}

/// Gathers the entries of these columns.
#[inline(always)]
fn gather(columns: &[usize], x: &[f64], path: &mut Path) {
    path.as_flattened_mut().iter_mut().zip(columns).for_each(|(to, &i)| *to = x[i]);
}

/// Sets the path to zero, as far as these runs extend.
#[inline(always)]
fn clear(runs: &[Run], path: &mut Path) {
    let count = runs.last().map_or(0, |run| run.fours + 1);
    with_constant!(count, |N| { path[..N].fill([0.0; WIDTH]) });
}

/// x ← L⁻ᵀx for a run's rows, with its contributions to the rows of their ancestors.
#[inline(always)]
fn sweep_inward(n: usize, run: &Run, l: &[Four], path: &mut Path, x: &mut [f64]) {
    let rows = l[run.begin..][..x.len() * (n + 1)].chunks_exact(n + 1);
    let path = &mut path[..=n];
    for (at, (x, row)) in x.iter_mut().zip(rows).enumerate().rev() {
        // This entry and those after it are final, so the products may overwrite them.
        let value = *x + path[n][(run.first + at) % WIDTH];
        *x = value;
        subtract(path, value, row);
    }
}

/// x ← L⁻¹D⁻¹x for a run's rows. The path is zero after them.
#[inline(always)]
fn sweep_outward(n: usize, run: &Run, l: &[Four], path: &mut Path, x: &mut [f64]) {
    let rows = l[run.begin..][..x.len() * (n + 1)].chunks_exact(n + 1);
    let path = &mut path[..=n];
    for (at, (x, row)) in x.iter_mut().zip(rows).enumerate() {
        let at = (run.first + at) % WIDTH;
        *x = *x / row[n][at] - product(row, path);
        path[n][at] = *x;
    }
}

/// M x for a run's rows, which are padded with 0, with its contributions to their ancestors.
#[inline(always)]
fn sweep_both(n: usize, run: &Run, m: &[Four], (path, sums): (&Path, &mut Path), to: &mut [f64]) {
    let rows = m[run.begin..][..to.len() * (n + 1)].chunks_exact(n + 1);
    let (path, sums) = (&path[..=n], &mut sums[..=n]);
    for (at, (to, row)) in to.iter_mut().zip(rows).enumerate().rev() {
        let at = (run.first + at) % WIDTH;
        *to += sums[n][at] + product(row, path);
        // Entries after it on the path are final.
        subtract(sums, -path[n][at], row);
    }
}
