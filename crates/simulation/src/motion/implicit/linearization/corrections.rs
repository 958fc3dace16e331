//! The change of the position corrections.
//!
//! A correction moves q by w = M̂⁻¹Aᵀp, where the rows A that push close their gaps: A w = −g. With M̂ at the
//! middle of the step and A at q, M̂ δw = ∂(Aᵀp)/∂q δq − ∂(M w)/∂qₘ δqₘ + Aᵀδp and A δw = −δg − ∂(A w)/∂q δq.

use robot_dynamics_core::{Model, Workspace};

use super::super::ImplicitIntegrator;
use super::columns::Columns;
use super::parameters::inertia_regressor;
use super::record::Correction;
use super::rows::inertia_derivative;
use super::systems::{solve_dependent, transpose};
use crate::motion::linearize_step::displacement::retraction_change;
use crate::motion::linearize_step::product::multiply_changes;
use crate::placement::Placement;

impl ImplicitIntegrator {
    /// Takes a change of q through all position corrections of the step from q₀. A violation at the start
    /// leaves the fraction `kept`.
    pub(super) fn correction_changes(
        &mut self,
        (model, workspace): (&Model, &mut Workspace),
        (kept, columns): (f64, &Columns),
        q0: &[f64],
        inverse: &[f64],
        (middle, middle_change): (&[f64], &[f64]),
        q_change: &mut Vec<f64>,
    ) {
        let mut placement = Placement::new(model);
        for correction in &core::mem::take(&mut self.record.corrections) {
            let start_rows = self.start_rows(model, workspace, q0, correction, &mut placement);
            let (nv, width, count) = (model.nv, columns.width(), correction.rows.len());
            let (mut bend, mut turned) = (vec![0.0; nv * nv], vec![0.0; count * nv]);
            let gap_rows =
                self.vary_rows((model, workspace), correction, (&mut bend, &mut turned), &mut placement);
            let inertia = inertia_derivative(model, workspace, middle, &correction.way);
            let a = &correction.entries;
            // At fixed p.
            let mut right = vec![0.0; nv * width];
            multiply_changes(&[(&bend, q_change), (&inertia, middle_change)], width, &mut right);
            let by_inertial = inertia_regressor(model, workspace, columns, (middle, &correction.way));
            columns.add(&mut right, columns.first_inertial(), -1.0, &by_inertial);
            let mut way_change = vec![0.0; nv * width];
            multiply_changes(&[(inverse, &right)], width, &mut way_change);
            let transposed = transpose(a, count, nv);
            let mut response = vec![0.0; nv * count];
            multiply_changes(&[(inverse, &transposed)], count, &mut response);
            let mut system = vec![0.0; count * count];
            multiply_changes(&[(a, &response)], count, &mut system);
            let mut missing = vec![0.0; count * width];
            let pairs: [(&[f64], &[f64]); 3] = [(&gap_rows, q_change), (a, &way_change), (&turned, q_change)];
            multiply_changes(&pairs, width, &mut missing);
            for (row, start) in missing.chunks_exact_mut(width).zip(start_rows.chunks_exact(nv)) {
                for (k, x) in row.iter_mut().enumerate() {
                    *x = kept * start.get(k).copied().unwrap_or(0.0) - *x;
                }
            }
            solve_dependent(&mut system, count, &mut missing, width);
            multiply_changes(&[(&response, &missing)], width, &mut right);
            way_change.iter_mut().zip(&right).for_each(|(sum, change)| *sum += change);
            move_change(model, &correction.way, &way_change, q_change);
        }
    }

    /// Adds ∂(Aᵀp)/∂q of the rows of a correction, and writes ∂(A w)/∂q. Returns ∂g/∂q of the gaps at the
    /// start of the correction.
    fn vary_rows(
        &mut self,
        (model, workspace): (&Model, &mut Workspace),
        correction: &Correction,
        (bend, turned): (&mut [f64], &mut [f64]),
        placement: &mut Placement,
    ) -> Vec<f64> {
        let (nv, Correction { q, rows, way, entries, .. }) = (model.nv, correction);
        let mut gap_rows = entries.clone();
        if let Some(contacts) = &self.contacts {
            placement.set(model, workspace, q);
            contacts.vary_correction(model, placement, rows, way, bend, turned);
        }
        let moving: Vec<_> = rows
            .iter()
            .enumerate()
            .filter_map(|(i, row)| row.corrected.moving.map(|own| (i, row, own)))
            .collect();
        let numbers: Vec<_> =
            moving.iter().map(|(_, row, (number, sign))| (*number, sign * row.multiplier)).collect();
        let velocity = self.vary_moving_rows((model, workspace), q, &numbers, way, bend);
        for ((i, _, (number, sign)), velocity) in moving.into_iter().zip(velocity.chunks_exact(nv.max(1))) {
            let own = i * nv..(i + 1) * nv;
            turned[own.clone()].iter_mut().zip(velocity).for_each(|(to, x)| *to = sign * x);
            gap_rows[own.clone()].fill(0.0);
            for &(k, factor) in &self.impulses.terms()[number] {
                gap_rows[own.start + k] += sign * factor;
            }
        }
        gap_rows
    }

    /// The rows at q₀ of the violations of which a part remains, and zeros otherwise.
    fn start_rows(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        q0: &[f64],
        correction: &Correction,
        placement: &mut Placement,
    ) -> Vec<f64> {
        let nv = model.nv;
        let mut start = vec![0.0; correction.entries.len()];
        placement.set(model, workspace, q0);
        if correction.rows.iter().any(|row| row.corrected.is_from_start && row.corrected.moving.is_some()) {
            self.turn_rows(model, workspace, q0, &self.kept.v.clone());
        }
        let rows = correction.rows.iter().zip(correction.entries.chunks_exact(nv));
        for ((row, entries), start) in rows.zip(start.chunks_exact_mut(nv)) {
            match (row.contact, row.corrected.moving, &self.contacts) {
                _ if !row.corrected.is_from_start => {}
                (Some(number), _, Some(contacts)) => contacts.add_normal_row(model, placement, number, start),
                (_, Some((number, sign)), _) => {
                    for &(k, factor) in &self.impulses.terms()[number] {
                        start[k] += sign * factor;
                    }
                }
                _ => start.copy_from_slice(entries),
            }
        }
        start
    }
}

/// The change of q ⊕ w: e^(−ad w) δq + J(w) δw.
fn move_change(model: &Model, way: &[f64], way_change: &[f64], q_change: &mut Vec<f64>) {
    let (nv, width) = (model.nv, way_change.len() / model.nv.max(1));
    let zeros = || vec![0.0; nv * width];
    let (mut carried, mut moved) = (zeros(), zeros());
    retraction_change(model, way, &zeros(), &mut carried);
    retraction_change(model, way, way_change, &mut moved);
    let mut matrix = vec![0.0; nv * nv];
    for k in 0..nv {
        matrix[k * nv..(k + 1) * nv].copy_from_slice(&carried[k * width..k * width + nv]);
    }
    let mut sum = zeros();
    multiply_changes(&[(&matrix, q_change)], width, &mut sum);
    for ((sum, moved), carried) in sum.iter_mut().zip(&moved).zip(&carried) {
        *sum += moved - carried;
    }
    *q_change = sum;
}
