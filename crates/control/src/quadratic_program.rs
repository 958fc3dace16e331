//! Strictly convex quadratic programs: minimize ½ xᵀH x + gᵀx with l ≤ C x ≤ u.
//!
//! A dual active-set method. It starts at the minimizer under a working set of rows, and adds the most
//! violated row until none is left. Every step keeps the multipliers nonnegative and increases the dual
//! objective, so it ends after finitely many rows. The working set of one program is the first guess for the
//! next one.
//!
//! With H = L Lᵀ and the working rows as columns of N: J = L⁻ᵀQ, JᵀN = (R, 0), R upper triangular. A step
//! costs O(n²). Source: Goldfarb, Idnani, *A numerically stable dual method for solving strictly convex
//! quadratic programs*, Mathematical Programming 27 (1983).

mod rows;
mod working_set;

pub(crate) use rows::{RowBounds, Side, WorkingRow, dot};
use working_set::WorkingSet;

use crate::optimal::dense::factorize;

/// The largest scaled violation of a row, relative to one plus its scaled bound, that counts as rounding.
const FEASIBILITY: f64 = 1e-10;

/// The factor of the tolerance after a solution whose rounding violated further rows, and its largest value.
const GROWTH: f64 = 10.0;
const LARGEST_TOLERANCE: f64 = 1e-7;

/// The steps for each variable and row after which the method gives up.
const STEPS_PER_ROW: usize = 10;

/// The reason why a program has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum QuadraticProgramError {
    /// The Hessian is not positive definite.
    Indefinite,
    /// The row contradicts the others.
    Infeasible { row: usize },
    /// The steps were used up.
    NotConverged { steps: usize },
}

/// The memory of the method.
#[derive(Clone, Debug, Default)]
pub(crate) struct DualActiveSet {
    set: WorkingSet,
    hessian: Vec<f64>,
    direction: Vec<f64>,
    change: Vec<f64>,
}

impl DualActiveSet {
    /// Memory for programs of up to `variables` variables.
    pub(crate) fn new(variables: usize) -> Self {
        Self {
            set: WorkingSet::new(variables),
            hessian: Vec::with_capacity(variables * variables),
            direction: Vec::with_capacity(variables),
            change: Vec::with_capacity(variables),
        }
    }

    /// Factors H, n×n, of which only the lower half is read. The working set becomes empty.
    pub(crate) fn set_hessian(&mut self, n: usize, hessian: &[f64]) -> Result<(), QuadraticProgramError> {
        self.hessian.clear();
        self.hessian.extend_from_slice(hessian);
        if !factorize(n, &mut self.hessian) {
            return Err(QuadraticProgramError::Indefinite);
        }
        self.set.start(n, &self.hessian);
        Ok(())
    }

    /// The rows that hold as equalities.
    pub(crate) fn working_rows(&self) -> &[WorkingRow] {
        self.set.rows()
    }

    /// Adds rows as a guess of the working set. Rows that depend on the others are left out.
    pub(crate) fn guess(&mut self, bounds: RowBounds<'_>, rows: impl Iterator<Item = (usize, Side)>) {
        let n = self.set.variables();
        for (row, side) in rows.filter(|(row, _)| *row < bounds.lower.len()) {
            let is_bounded = bounds.bound(row, side).is_finite();
            if is_bounded && self.set.rows().iter().all(|own| own.row != row) {
                self.set.project(bounds.row(n, row), side);
                if self.set.is_independent() {
                    self.set.push(row, side, 0.0);
                }
            }
        }
    }

    /// The minimizer for a gradient, from the present working set. Returns the number of steps.
    pub(crate) fn solve(
        &mut self,
        gradient: &[f64],
        bounds: RowBounds<'_>,
        x: &mut [f64],
    ) -> Result<usize, QuadraticProgramError> {
        let (n, rows) = (gradient.len(), bounds.lower.len());
        let most = STEPS_PER_ROW * (n + rows) + STEPS_PER_ROW;
        let mut steps = self.set.minimize(gradient, bounds, x);
        let (mut is_exact, mut is_repeated, mut tolerance) = (true, false, FEASIBILITY);
        loop {
            match most_violated(bounds, x, tolerance) {
                Some((row, side)) => {
                    steps += self.add(row, side, bounds, x)?;
                    if is_exact && is_repeated {
                        tolerance = (GROWTH * tolerance).min(LARGEST_TOLERANCE);
                    }
                    is_exact = false;
                }
                None if is_exact => return Ok(steps),
                None => {
                    // The sums of steps have more rounding than one solution with the final set.
                    steps += self.set.minimize(gradient, bounds, x);
                    (is_exact, is_repeated) = (true, true);
                }
            }
            if steps > most {
                return Err(QuadraticProgramError::NotConverged { steps });
            }
        }
    }

    /// Adds a violated row, and drops those whose multipliers reach zero on the way. Returns the number of
    /// steps.
    fn add(
        &mut self,
        row: usize,
        side: Side,
        bounds: RowBounds<'_>,
        x: &mut [f64],
    ) -> Result<usize, QuadraticProgramError> {
        let normal = bounds.row(x.len(), row);
        let bound = bounds.bound(row, side);
        let (mut multiplier, mut steps) = (0.0, 0);
        loop {
            steps += 1;
            self.set.project(normal, side);
            self.set.multiplier_change(&mut self.change);
            let blocking = self.set.blocking(&self.change);
            let full = self.set.is_independent().then(|| {
                self.set.primal_direction(&mut self.direction);
                (bound - side.sign() * dot(normal, x)) / self.set.curvature()
            });
            let length = match (full, blocking) {
                (None, None) => return Err(QuadraticProgramError::Infeasible { row }),
                (Some(full), Some((_, blocked))) => full.min(blocked),
                (Some(length), None) | (None, Some((_, length))) => length,
            };
            multiplier += length;
            self.set.change_multipliers(-length, &self.change);
            if full.is_some() {
                x.iter_mut().zip(&self.direction).for_each(|(x, d)| *x += length * d);
            }
            match blocking {
                Some((index, blocked)) if full.is_none_or(|full| blocked < full) => self.set.remove(index),
                _ => {
                    self.set.push(row, side, multiplier);
                    return Ok(steps);
                }
            }
        }
    }
}

/// The row with the largest scaled violation above the tolerance.
fn most_violated(bounds: RowBounds<'_>, x: &[f64], tolerance: f64) -> Option<(usize, Side)> {
    let mut most = None;
    let mut largest = 0.0;
    for (row, scale) in bounds.scales.iter().enumerate() {
        let value = dot(bounds.row(x.len(), row), x);
        for side in [Side::Lower, Side::Upper] {
            let bound = bounds.bound(row, side);
            let violation = (bound - side.sign() * value) * scale;
            let allowed = tolerance * (1.0 + bound.abs() * scale);
            if violation > allowed && violation > largest {
                largest = violation;
                most = Some((row, side));
            }
        }
    }
    most
}

#[cfg(test)]
mod tests;
