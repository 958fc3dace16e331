//! Products with A and Aᵀ.

use super::ConeProblem;

impl ConeProblem {
    /// Adds Aᵀp to `to`.
    pub(crate) fn add_forces(&self, p: &[f64], to: &mut [f64]) {
        for block in &self.blocks {
            let support = &self.support[block.support.clone()];
            let rows = self.entries[block.entries..].chunks_exact(support.len().max(1));
            for (row, p) in rows.zip(&p[block.rows.clone()]) {
                for (&k, a) in support.iter().zip(row) {
                    to[k] += a * p;
                }
            }
        }
    }

    /// Computes A x into `to`.
    pub(crate) fn multiply(&self, x: &[f64], to: &mut Vec<f64>) {
        to.clear();
        for block in &self.blocks {
            let support = &self.support[block.support.clone()];
            let rows = self.entries[block.entries..].chunks_exact(support.len().max(1));
            to.extend(
                rows.take(block.rows.len())
                    .map(|row| support.iter().zip(row).map(|(&k, a)| a * x[k]).sum::<f64>()),
            );
        }
    }

    /// Arranges the rows of all blocks for the solver's loops.
    pub(super) fn arrange(&mut self) {
        if !self.is_arranged {
            self.rows.arrange(&self.blocks, &self.support, &self.entries);
            self.is_arranged = true;
        }
    }

    /// Declares that p̄ acts already: x is caused by p − p̄, so f + Aᵀp̄ takes the place of f.
    pub(in crate::contact) fn count_multipliers(&mut self) {
        self.counted.clone_from(&self.multiplier);
    }

    /// Adds Aᵀp of the solution to `to`.
    pub(in crate::contact) fn add_found_forces(&mut self, to: &mut [f64]) {
        self.arrange();
        self.rows.add_forces(&self.support, &self.multiplier, to);
    }

    /// Computes Aᵀ(p − p̄) − f of the solution into `to`: M x in exact arithmetic.
    pub(in crate::contact) fn find_impulses(&mut self, to: &mut [f64]) {
        self.arrange();
        self.missing.clear();
        self.missing.extend(self.multiplier.iter().zip(&self.counted).map(|(p, counted)| p - counted));
        to.iter_mut().zip(&self.force).for_each(|(to, force)| *to = -force);
        self.rows.add_forces(&self.support, &self.missing, to);
    }

    /// Computes the same as [`multiply`](Self::multiply), faster.
    pub(in crate::contact) fn find_products(&mut self, x: &[f64], to: &mut Vec<f64>) {
        self.arrange();
        to.resize(self.start.len(), 0.0);
        self.rows.multiply(&self.support, x, to);
    }

    /// Adds A v to c₀.
    pub(crate) fn add_speeds(&mut self, v: &[f64]) {
        let mut speeds = core::mem::take(&mut self.change);
        self.find_products(v, &mut speeds);
        self.start.iter_mut().zip(&speeds).for_each(|(start, speed)| *start += speed);
        self.change = speeds;
    }
}
