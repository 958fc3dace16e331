//! The order in which rows of equalities are selected, by their independence of the selected rows.
//!
//! If rows depend on each other, the step requires a nearly orthogonal subset. Across the line between them,
//! two corners of a foot move alike except for the rotation in a step; along the line they are dependent. The
//! order is that of a Cholesky factorization of A M̂⁻¹Aᵀ with pivoting. Among several good rows the first is
//! selected, so that the choice rarely changes between steps.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::clone_in_place::clone_in_place;

use super::impulses::along;
use super::stiff_factor::StiffFactor;
use crate::equality::rows::EqualityRow;

/// A row is as good as the best one if its squared independent part is at least this fraction of the best
/// one's.
const AS_GOOD: f64 = 0.1;

clone_in_place! {
    /// The order of rows, and its memory.
    #[derive(Debug)]
    pub(super) struct Pivots {
        /// |aᵢ| in M̂⁻¹, and the longest of the same constraint in the same unit.
        pub(super) lengths: Vec<f64>,
        pub(super) scales: Vec<f64>,
        /// M̂⁻¹aᵢ, row by row.
        responses: Vec<f64>,
        /// The square of the part of each row that is independent of the selected rows.
        left: Vec<f64>,
        is_done: Vec<bool>,
        /// The column of the factor for each selected row.
        columns: Vec<f64>,
    }
}

impl Pivots {
    pub(super) fn new(count: usize, nv: usize) -> Self {
        Self {
            lengths: vec![0.0; count],
            scales: vec![0.0; count],
            responses: vec![0.0; count * nv],
            left: vec![0.0; count],
            is_done: vec![false; count],
            columns: Vec::with_capacity(count * count),
        }
    }

    /// Starts with no selected rows.
    pub(super) fn begin(&mut self, rows: &[EqualityRow], factor: &StiffFactor) {
        let nv = self.responses.len() / rows.len().max(1);
        self.is_done.fill(false);
        self.columns.clear();
        for (i, row) in rows.iter().enumerate() {
            let response = &mut self.responses[i * nv..(i + 1) * nv];
            response.fill(0.0);
            row.terms.iter().for_each(|&(k, factor)| response[k] = factor);
            factor.solve(response);
            let square = along(&row.terms, response);
            self.left[i] = square;
            // Preserves NaN.
            self.lengths[i] = square.max(0.0).sqrt() + 0.0 * square;
        }
        for (i, row) in rows.iter().enumerate() {
            let group = rows.iter().zip(&self.lengths).filter(|(other, _)| other.group == row.group);
            self.scales[i] = group.fold(0.0_f64, |most, (_, length)| most.max(*length));
        }
    }

    /// The next row to examine among these; each row is returned once.
    pub(super) fn next(&mut self, is_own: impl Fn(usize) -> bool) -> Option<usize> {
        let part = |i: usize| {
            let square = self.scales[i] * self.scales[i];
            if square > 0.0 { (self.left[i] / square).max(0.0) } else { 0.0 }
        };
        let is_left = |i: &usize| !self.is_done[*i] && is_own(*i);
        let best = (0..self.left.len()).filter(is_left).map(part).fold(0.0, f64::max);
        let next = (0..self.left.len()).filter(is_left).find(|i| part(*i) >= AS_GOOD * best)?;
        self.is_done[next] = true;
        Some(next)
    }

    /// The multipliers λ of least norm with the same forces Aᵀλ as the given ones, so that dependent rows
    /// share their forces. Rotations are weighted by the ratio of the longest rotational row to the longest
    /// other row, which makes the result independent of units. Rows shorter than the fraction `least` of
    /// their constraint's longest row have no force.
    ///
    /// The columns of the factor give A = L E with independent rows E, so Aᵀλ is unchanged if Lᵀλ is. With
    /// weights S, Sλ is the projection of the given multipliers on the range of S⁻¹L.
    pub(super) fn share(&self, rows: &[EqualityRow], multipliers: &[f64], least: f64) -> Vec<f64> {
        let count = rows.len();
        let rank = self.columns.len() / count.max(1);
        if rank == 0 || rank == count {
            return multipliers.to_vec();
        }
        let is_turn = |i: usize| rows[i].group % 2 == 1;
        let longest = |turns: bool| {
            let own = (0..count).filter(|&i| is_turn(i) == turns);
            own.fold(0.0_f64, |most, i| most.max(self.lengths[i]))
        };
        let weight = |i: usize| match longest(is_turn(i)) {
            0.0 => 1.0,
            length => length,
        };
        let weights: Vec<f64> = (0..count).map(weight).collect();
        let is_long = |i: usize| self.lengths[i] > least * self.scales[i];
        let range = DMatrix::from_fn(count, rank, |i, k| {
            if is_long(i) { self.columns[k * count + i] / weights[i] } else { 0.0 }
        });
        let given = DVector::from_fn(count, |i, _| weights[i] * multipliers[i]);
        let q = range.qr().q();
        let shared = &q * q.tr_mul(&given);
        (0..count).map(|i| if is_long(i) { shared[i] / weights[i] } else { 0.0 }).collect()
    }

    /// Selects a row, and subtracts its direction from the others.
    pub(super) fn take(&mut self, rows: &[EqualityRow], taken: usize) {
        let count = rows.len();
        let nv = self.responses.len() / count;
        let response = &self.responses[taken * nv..(taken + 1) * nv];
        let root = self.left[taken].max(f64::MIN_POSITIVE).sqrt();
        let begin = self.columns.len();
        for (i, row) in rows.iter().enumerate() {
            let (earlier, mut entry) = (&self.columns[..begin], 0.0);
            if !self.is_done[i] {
                let known: f64 = earlier.chunks_exact(count).map(|column| column[i] * column[taken]).sum();
                entry = (along(&row.terms, response) - known) / root;
                self.left[i] -= entry * entry;
            } else if i == taken {
                entry = root;
            }
            self.columns.push(entry);
        }
    }
}
