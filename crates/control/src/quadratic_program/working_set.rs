//! The factors of the rows that hold as equalities.

use super::rows::{RowBounds, Side, WorkingRow, dot};

/// A row depends on the working set if its projection is below this fraction of itself.
const INDEPENDENCE: f64 = 1e-10;

/// The working rows N, and the factors J = L⁻ᵀQ and R with JᵀN = (R, 0).
#[derive(Clone, Debug, Default)]
pub(super) struct WorkingSet {
    n: usize,
    rows: Vec<WorkingRow>,
    /// Jᵀ, row-major: row j is column j of J.
    basis: Vec<f64>,
    /// R by columns of n entries; column k has k + 1 that count.
    triangle: Vec<f64>,
    /// Jᵀc of the last row that was projected.
    projection: Vec<f64>,
    scratch: Vec<f64>,
}

impl WorkingSet {
    pub(super) fn new(n: usize) -> Self {
        Self {
            n,
            rows: Vec::with_capacity(n),
            basis: Vec::with_capacity(n * n),
            triangle: Vec::with_capacity(n * n),
            projection: Vec::with_capacity(n),
            scratch: Vec::with_capacity(n),
        }
    }

    pub(super) fn variables(&self) -> usize {
        self.n
    }

    pub(super) fn rows(&self) -> &[WorkingRow] {
        &self.rows
    }

    /// An empty set with J = L⁻ᵀ.
    pub(super) fn start(&mut self, n: usize, factor: &[f64]) {
        self.n = n;
        self.rows.clear();
        for (memory, length) in [
            (&mut self.basis, n * n),
            (&mut self.triangle, n * n),
            (&mut self.projection, n),
            (&mut self.scratch, n),
        ] {
            memory.clear();
            memory.resize(length, 0.0);
        }
        for i in 0..n {
            let (above, own) = self.basis.split_at_mut(i * n);
            let own = &mut own[..n];
            own[i] = 1.0;
            for (row, &l) in above.chunks_exact(n).zip(&factor[i * n..i * n + i]) {
                // Row k of L⁻¹ ends at column k; the zeros after it are cheap.
                own[..i].iter_mut().zip(row).for_each(|(x, above)| *x -= l * above);
            }
            let inverse = 1.0 / factor[i * n + i];
            own[..=i].iter_mut().for_each(|x| *x *= inverse);
        }
    }

    fn basis_row(&self, j: usize) -> &[f64] {
        &self.basis[j * self.n..(j + 1) * self.n]
    }

    /// Jᵀc for the row with the sign of its side.
    pub(super) fn project(&mut self, row: &[f64], side: Side) {
        for j in 0..self.n {
            self.projection[j] = side.sign() * dot(self.basis_row(j), row);
        }
    }

    /// cᵀJ₂J₂ᵀc of the projected row.
    pub(super) fn curvature(&self) -> f64 {
        let free = &self.projection[self.rows.len()..];
        dot(free, free)
    }

    /// Whether the projected row is independent of the working rows.
    pub(super) fn is_independent(&self) -> bool {
        let all = dot(&self.projection, &self.projection);
        self.curvature() > INDEPENDENCE * INDEPENDENCE * all
    }

    /// J₂J₂ᵀc: the direction in which the projected row grows and the working rows stay.
    pub(super) fn primal_direction(&self, direction: &mut Vec<f64>) {
        direction.clear();
        direction.resize(self.n, 0.0);
        for j in self.rows.len()..self.n {
            let d = self.projection[j];
            direction.iter_mut().zip(self.basis_row(j)).for_each(|(x, b)| *x += d * b);
        }
    }

    /// R⁻¹J₁ᵀc: the decrease of the working multipliers for each unit of the projected row's.
    pub(super) fn multiplier_change(&self, change: &mut Vec<f64>) {
        change.clear();
        change.extend_from_slice(&self.projection[..self.rows.len()]);
        self.solve_upper(change);
    }

    /// R⁻¹x.
    fn solve_upper(&self, x: &mut [f64]) {
        for k in (0..x.len()).rev() {
            let column = &self.triangle[k * self.n..];
            x[k] /= column[k];
            let entry = x[k];
            x[..k].iter_mut().zip(column).for_each(|(x, r)| *x -= entry * r);
        }
    }

    /// The working row whose multiplier reaches zero first, and the step at which it does.
    pub(super) fn blocking(&self, change: &[f64]) -> Option<(usize, f64)> {
        let steps = self.rows.iter().zip(change).enumerate().filter(|(_, (_, change))| **change > 0.0);
        steps
            .map(|(index, (row, change))| (index, row.multiplier.max(0.0) / change))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    pub(super) fn change_multipliers(&mut self, length: f64, change: &[f64]) {
        self.rows.iter_mut().zip(change).for_each(|(row, change)| row.multiplier += length * change);
    }

    /// Adds the projected row; a reflection of J₂ makes its projection a multiple of the first column.
    pub(super) fn push(&mut self, row: usize, side: Side, multiplier: f64) {
        let (n, count) = (self.n, self.rows.len());
        let free = &mut self.projection[count..];
        let norm = dot(free, free).sqrt();
        let first = if free[0] > 0.0 { -norm } else { norm };
        free[0] -= first;
        let length = dot(free, free);
        if length > 0.0 {
            self.scratch.fill(0.0);
            for (w, row) in free.iter().zip(self.basis[count * n..].chunks_exact(n)) {
                self.scratch.iter_mut().zip(row).for_each(|(sum, b)| *sum += w * b);
            }
            for (w, row) in free.iter().zip(self.basis[count * n..].chunks_exact_mut(n)) {
                let factor = 2.0 * w / length;
                row.iter_mut().zip(&self.scratch).for_each(|(b, sum)| *b -= factor * sum);
            }
        }
        let column = &mut self.triangle[count * n..][..=count];
        column[..count].copy_from_slice(&self.projection[..count]);
        column[count] = first;
        self.rows.push(WorkingRow { row, side, multiplier });
    }

    /// Removes a row; rotations make R triangular again.
    pub(super) fn remove(&mut self, index: usize) {
        let n = self.n;
        self.rows.remove(index);
        for column in index..self.rows.len() {
            let (own, next) = self.triangle.split_at_mut((column + 1) * n);
            own[column * n..].copy_from_slice(&next[..n]);
        }
        for k in index..self.rows.len() {
            let (a, b) = (self.triangle[k * n + k], self.triangle[k * n + k + 1]);
            let norm = a.hypot(b);
            let (c, s) = (a / norm, b / norm);
            for column in k..self.rows.len() {
                let pair = &mut self.triangle[column * n + k..][..2];
                let [x, y] = [pair[0], pair[1]];
                pair.copy_from_slice(&[c * x + s * y, c * y - s * x]);
            }
            let (above, below) = self.basis.split_at_mut((k + 1) * n);
            for (x, y) in above[k * n..].iter_mut().zip(&mut below[..n]) {
                (*x, *y) = (c * *x + s * *y, c * *y - s * *x);
            }
        }
    }

    /// The minimizer with the working rows as equalities; rows with negative multipliers are dropped. Returns
    /// the number of dropped rows.
    pub(super) fn minimize(&mut self, gradient: &[f64], bounds: RowBounds<'_>, x: &mut [f64]) -> usize {
        let mut dropped = 0;
        loop {
            self.equality_minimizer(gradient, bounds, x);
            let multipliers = self.rows.iter().map(|row| row.multiplier).enumerate();
            let negative = multipliers.filter(|(_, u)| *u < 0.0).min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((index, _)) = negative else { return dropped };
            self.remove(index);
            dropped += 1;
        }
    }

    /// x = J₁ y₁ − J₂J₂ᵀg with Rᵀy₁ = b; the multipliers are R⁻¹(y₁ + J₁ᵀg).
    fn equality_minimizer(&mut self, gradient: &[f64], bounds: RowBounds<'_>, x: &mut [f64]) {
        let (n, count) = (self.n, self.rows.len());
        x.fill(0.0);
        self.scratch.fill(0.0);
        for k in 0..count {
            let WorkingRow { row, side, .. } = self.rows[k];
            let column = &self.triangle[k * n..][..=k];
            let known = dot(&column[..k], &self.projection[..k]);
            self.projection[k] = (bounds.bound(row, side) - known) / column[k];
        }
        for j in 0..n {
            let slope = dot(self.basis_row(j), gradient);
            let coefficient = if j < count { self.projection[j] } else { -slope };
            if j < count {
                self.scratch[j] = coefficient + slope;
            }
            x.iter_mut().zip(self.basis_row(j)).for_each(|(x, b)| *x += coefficient * b);
        }
        let mut multipliers = core::mem::take(&mut self.scratch);
        self.solve_upper(&mut multipliers[..count]);
        self.rows.iter_mut().zip(&multipliers).for_each(|(row, u)| row.multiplier = *u);
        self.scratch = multipliers;
    }
}
