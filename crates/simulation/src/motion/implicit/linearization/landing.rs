//! The change of a step by the time at which bodies meet.
//!
//! An impact at the time t of a pass of length h changes the velocity by D = M̂⁻¹Aᵀp and the acceleration from
//! a to a⁺:
//!
//! > q⁺ = q₀ ⊕ (v₀ h + D (h − t)),  v⁺ = S(q₀ ⊕ v₀ t, v₀ + a t) + a⁺ (h − t)
//!
//! The pass takes the mean h − t = ½h, and q⁺ jumps where the impact moves to the next pass. On average, t
//! follows the gap. With the normal rows N, δq⁺ = δq − D δt, N δq⁺ = 0 and δv⁺ = δS + (Ṡ − a⁺) δt. For
//! one contact δt = −N δq/(N v₀), which is the saltation matrix (Aizerman, Gantmacher 1958). Impacts in the
//! same pass have the mean of their δt in δv⁺.

use robot_dynamics_core::{Model, Workspace};

use super::super::ImplicitIntegrator;
use super::super::advance::{ImpactPolicy, PARTS};
use super::super::joints::Length;
use super::columns::Columns;
use super::systems::{push_row, solve_dependent, transpose};
use crate::contact::SLOW_TOUCHDOWN;
use crate::motion::linearize_step::product::multiply_changes;

/// A change of velocity in a pass above this fraction of the speeds is not an acceleration: another impact
/// follows.
const SUDDEN: f64 = 0.1;

/// The rows of impacts.
#[derive(Default)]
struct Impacts {
    /// N, nv numbers each.
    normals: Vec<f64>,
    /// Aᵀp of each, nv numbers.
    impulses: Vec<f64>,
}

/// The change of the times of impacts.
pub(super) struct ImpactTimes {
    /// The mean of δt, one number for each column.
    mean: Vec<f64>,
    /// N and M̂⁻¹Nᵀ.
    normals: Vec<f64>,
    responses: Vec<f64>,
}

impl ImplicitIntegrator {
    /// Moves the times of the impacts of the recorded pass of h from q₀ with the state. Returns them, if
    /// there are impacts.
    pub(super) fn move_impacts(
        &self,
        h: f64,
        q0: &[f64],
        inverse: &[f64],
        q_change: &mut [f64],
    ) -> Option<ImpactTimes> {
        let Impacts { normals, impulses } = self.impacts(h, q0);
        let nv = self.record.before.len();
        let count = normals.len() / nv.max(1);
        if count == 0 {
            return None;
        }
        let width = q_change.len() / nv;
        // D, one column for each impact.
        let mut jumps = vec![0.0; nv * count];
        multiply_changes(&[(inverse, &transpose(&impulses, count, nv))], count, &mut jumps);
        let mut system = vec![0.0; count * count];
        multiply_changes(&[(&normals, &jumps)], count, &mut system);
        let mut responses = vec![0.0; nv * count];
        multiply_changes(&[(inverse, &transpose(&normals, count, nv))], count, &mut responses);
        let mut times = vec![0.0; count * width];
        multiply_changes(&[(&normals, q_change)], width, &mut times);
        solve_dependent(&mut system, count, &mut times, width);
        let mut moved = vec![0.0; nv * width];
        multiply_changes(&[(&jumps, &times)], width, &mut moved);
        q_change.iter_mut().zip(&moved).for_each(|(sum, moved)| *sum -= moved);
        let mean = |column: usize| times[column..].iter().step_by(width).sum::<f64>() / count as f64;
        Some(ImpactTimes { mean: (0..width).map(mean).collect(), normals, responses })
    }

    /// Adds (Ṡ − a⁺) δt of a pass of h to (q₁, v₁). Further passes find a⁺; the state stays.
    pub(super) fn change_acceleration(
        &mut self,
        (model, workspace): (&Model, &mut Workspace),
        (h, columns): (f64, &Columns),
        (q1, v1): (&[f64], &[f64]),
        times: ImpactTimes,
        v_change: &mut [f64],
    ) {
        let (nv, width) = (model.nv, columns.width());
        let part = if self.record.is_part { h } else { h / f64::from(PARTS) };
        let (mut q, mut v) = (q1.to_vec(), v1.to_vec());
        self.store_state(q1, v1);
        let tau = core::mem::take(&mut self.record.tau);
        // The first of two passes closes the gap that the impact left.
        let mut after = v1.to_vec();
        let taken = (0..2).try_for_each(|_| {
            after.copy_from_slice(&v);
            let impacts = ImpactPolicy::AcceptStep;
            self.advance(model, workspace, &tau, part, (&mut q, &mut v), impacts).map(|_| ())
        });
        self.record.tau = tau;
        after.iter_mut().zip(&v).for_each(|(after, v)| *after = (v - *after) / part);
        self.take_back(&mut q, &mut v);
        let fastest = v1.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        if taken.is_err() || after.iter().any(|a| a.abs() * part > SUDDEN * fastest) {
            return;
        }
        let stages = self.record.first.iter().zip(&self.record.second);
        let before: Vec<f64> = stages.map(|(first, second)| 0.5 * (3.0 * first + second)).collect();
        // Ṡ − a⁺, without a change of the speeds at which bodies separate.
        let ImpactTimes { mean, normals, responses } = times;
        let rows = v_change.chunks_exact(width);
        let rates = self.record.before.iter().chain(&before);
        let kept = rows.map(|row| row.iter().zip(rates.clone()).map(|(entry, x)| entry * x).sum::<f64>());
        let mut jump: Vec<f64> = kept.zip(&after).map(|(kept, after)| kept - after).collect();
        let count = normals.len() / nv;
        let (mut away, mut along) = (vec![0.0; count], vec![0.0; nv]);
        let mut system = vec![0.0; count * count];
        multiply_changes(&[(&normals, &responses)], count, &mut system);
        multiply_changes(&[(&normals, &jump)], 1, &mut away);
        solve_dependent(&mut system, count, &mut away, 1);
        multiply_changes(&[(&responses, &away)], 1, &mut along);
        jump.iter_mut().zip(&along).for_each(|(jump, along)| *jump -= along);
        for (row, jump) in v_change.chunks_exact_mut(width).zip(&jump) {
            row.iter_mut().zip(&mean).for_each(|(sum, time)| *sum += jump * time);
        }
    }

    /// The contacts and stops of joints that are met in this pass.
    fn impacts(&self, h: f64, q0: &[f64]) -> Impacts {
        let before = &self.record.before;
        let nv = before.len();
        let mut impacts = Impacts::default();
        if let Some(contacts) = &self.contacts {
            let problem = contacts.velocity_problem();
            let mut recorded = contacts.recorded();
            problem.each_block(|_, range, support, entries| {
                let Some(contact) = recorded.next() else { return };
                let approach: f64 = support.iter().zip(entries).map(|(k, entry)| entry * before[*k]).sum();
                if contact.is_new && contact.gap < 0.0 && approach < -SLOW_TOUCHDOWN {
                    let terms = |row| terms_of(support, row);
                    push_row(&mut impacts.normals, nv, terms(entries));
                    let rows = entries.chunks_exact(support.len().max(1)).zip(&problem.multiplier[range]);
                    let terms = rows.flat_map(|(row, p)| terms(row).map(move |(k, entry)| (k, p * entry)));
                    push_row(&mut impacts.impulses, nv, terms);
                }
            });
        }
        for row in self.record.rows.iter().filter(|row| row.is_free && row.multiplier != 0.0) {
            let approach: f64 = row.terms.iter().map(|(k, factor)| factor * before[*k]).sum();
            let is_met = self.joints.stops.iter().any(|stop| {
                let is_own = stop.row == row.number && !matches!(stop.length, Length::Path(_));
                let (gap, speed) = if is_own { (stop.gap(q0), stop.sign * approach) } else { (-1.0, 0.0) };
                gap > 0.0 && speed < -SLOW_TOUCHDOWN && gap + h * speed < 0.0
            });
            if is_met {
                push_row(&mut impacts.normals, nv, row.terms.iter().copied());
                let terms = row.terms.iter().map(|(k, factor)| (*k, row.multiplier * factor));
                push_row(&mut impacts.impulses, nv, terms);
            }
        }
        impacts
    }
}

/// The entries of a row by their coordinates.
fn terms_of<'a>(support: &'a [usize], row: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
    support.iter().copied().zip(row.iter().copied())
}
