//! The problem of the rows of each component: as part of its contact problem, or on its own.

use robot_dynamics_integrators::IntegratorError;

use super::super::bounded_problem::BoundedProblem;
use super::super::stiff_factor::StiffFactor;
use super::{Impulses, SOFTER, along};
use crate::contact::{Components, JointRow, Mark};

impl Impulses {
    /// The rows of components with contacts, as input of the contact problem, and the output for their
    /// multipliers.
    pub(in super::super) fn rows_beside<'a>(
        &'a mut self,
        components: &'a Components,
    ) -> (impl Iterator<Item = JointRow<'a>> + 'a, &'a mut [f64]) {
        let BoundedProblem { lower, upper, .. } = &self.problem;
        let terms = &self.terms;
        self.beside.clear();
        self.beside.resize(self.rows.len(), 0.0);
        let rows = self.rows.iter().enumerate();
        let rows =
            rows.filter(|(_, row)| components.has(Mark::Touched, components.tree_of_row(&terms[**row])));
        let row = |(i, &row): (usize, &usize)| {
            let terms: &[(usize, f64)] = &terms[row];
            JointRow { terms, speed: self.back[i], lower: lower[i], upper: upper[i] }
        };
        (rows.map(row), &mut self.beside)
    }

    /// Stores the multipliers that the contact problem found for these rows.
    pub(in super::super) fn take_multipliers(&mut self, components: &Components) {
        let mut found = self.beside.iter();
        for (x, &row) in self.problem.x.iter_mut().zip(&self.rows) {
            if components.has(Mark::Touched, components.tree_of_row(&self.terms[row]))
                && let Some(found) = found.next()
            {
                *x = *found;
            }
        }
    }

    /// Whether there are rows of components without contacts.
    pub(in super::super) fn has_rows_apart(&self, components: &Components) -> bool {
        self.rows.iter().any(|&row| !components.has(Mark::Touched, self.tree_of(row, components)))
    }

    /// Solves for the rows of components without contacts, component by component, from the velocity after
    /// the smooth part. Writes M̂⁻¹Eᵀλ of their coordinates to `change`.
    pub(in super::super) fn solve_apart(
        &mut self,
        factor: &StiffFactor,
        v1: &[f64],
        components: &Components,
        change: &mut [f64],
    ) -> Result<(), IntegratorError> {
        let leader = |impulses: &Self, i: usize| {
            let tree = impulses.tree_of(impulses.rows[i], components);
            (!components.has(Mark::Touched, tree)).then(|| components.leader(tree))
        };
        let mut part_rows = core::mem::take(&mut self.part_rows);
        let mut is_solved = Ok(());
        for first in 0..self.rows.len() {
            let own = leader(self, first);
            // Handle each component at its first row.
            if own.is_none() || (0..first).any(|i| leader(self, i) == own) {
                continue;
            }
            part_rows.clear();
            part_rows.extend((first..self.rows.len()).filter(|i| leader(self, *i) == own));
            is_solved = self.solve_part(factor, v1, &part_rows);
            if is_solved.is_err() {
                break;
            }
        }
        self.part_rows = part_rows;
        is_solved?;
        self.column.fill(0.0);
        for (i, &row) in self.rows.iter().enumerate() {
            if leader(self, i).is_some() {
                for (k, factor) in &self.terms[row] {
                    self.column[*k] += factor * self.problem.x[i];
                }
            }
        }
        factor.solve(&mut self.column);
        for (k, change) in change.iter_mut().enumerate() {
            if !components.has(Mark::Touched, components.tree_of(k)) {
                *change = self.column[k];
            }
        }
        Ok(())
    }

    /// The product of M and a change of velocity.
    pub(in super::super) fn multiply_mass_apart(&mut self, factor: &StiffFactor, change: &[f64]) -> &[f64] {
        factor.multiply_mass(change, &mut self.column);
        &self.column
    }

    /// Solves for these rows alone.
    fn solve_part(&mut self, factor: &StiffFactor, v1: &[f64], own: &[usize]) -> Result<(), IntegratorError> {
        let Self { rows, terms, problem, part, back, column, .. } = self;
        part.begin(own.len());
        for (to, &i) in own.iter().enumerate() {
            part.lower[to] = problem.lower[i];
            part.upper[to] = problem.upper[i];
            part.gradient[to] = along(&terms[rows[i]], v1) - back[i];
        }
        fill(factor, terms, &own.iter().map(|i| rows[*i]), column, part);
        solve(part, &terms[rows[own[0]]])?;
        for (x, &i) in part.x.iter().zip(own) {
            problem.x[i] = *x;
        }
        Ok(())
    }

    /// Solves `problem` for `rows`, and writes M̂⁻¹Eᵀλ to `change`.
    pub(super) fn apply(&mut self, factor: &StiffFactor, change: &mut [f64]) -> Result<(), IntegratorError> {
        let first: &[(usize, f64)] = self.rows.first().map_or(&[], |row| &self.terms[*row]);
        solve(&mut self.problem, first)?;
        change.fill(0.0);
        for (&row, multiplier) in self.rows.iter().zip(&self.problem.x) {
            for (k, factor) in &self.terms[row] {
                change[*k] += factor * multiplier;
            }
        }
        factor.solve(change);
        Ok(())
    }

    /// Writes W = EM̂⁻¹Eᵀ of `rows` to `problem`.
    pub(super) fn fill(&mut self, factor: &StiffFactor) {
        let Self { rows, terms, problem, column, .. } = self;
        fill(factor, terms, &rows.iter().copied(), column, problem);
    }
}

/// # Errors
/// Matrix or gradient is not finite.
fn solve(problem: &mut BoundedProblem, first: &[(usize, f64)]) -> Result<(), IntegratorError> {
    if !problem.solve() {
        let pivot = problem.matrix.first().copied().unwrap_or(f64::NAN);
        let coordinate = first.first().map_or(0, |(k, _)| *k);
        return Err(IntegratorError::SingularMass { coordinate, pivot });
    }
    Ok(())
}

/// Computes W = EM̂⁻¹Eᵀ of these rows.
fn fill(
    factor: &StiffFactor,
    terms: &[Vec<(usize, f64)>],
    rows: &(impl ExactSizeIterator<Item = usize> + Clone),
    column: &mut [f64],
    problem: &mut BoundedProblem,
) {
    let n = rows.len();
    for (i, row) in rows.clone().enumerate() {
        column.fill(0.0);
        for (k, factor) in &terms[row] {
            column[*k] = *factor;
        }
        factor.solve(column);
        for (j, other) in rows.clone().enumerate() {
            problem.matrix[j * n + i] = along(&terms[other], column);
        }
        if row >= column.len() {
            problem.matrix[i * n + i] *= 1.0 + SOFTER;
        }
    }
    for i in 0..n {
        for j in 0..i {
            let mean = 0.5 * (problem.matrix[i * n + j] + problem.matrix[j * n + i]);
            (problem.matrix[i * n + j], problem.matrix[j * n + i]) = (mean, mean);
        }
    }
}
