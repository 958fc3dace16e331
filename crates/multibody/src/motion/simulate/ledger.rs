//! The energy of a run: what the motors put in, what the joints took out, what the integrator made up.

use crate::joint::Chart;
use crate::space::configuration::{stretches, vector_at};
use crate::space::retraction::bracket;
use crate::spatial::algebra::V3;
use crate::{
    Model, StepForces, Workspace, difference, dissipation, kinetic_energy, neutral, potential_energy,
};

/// The books of a run, one entry per step: E = E₀ + (work of τ) − (dissipated by b) + (the integrator's error).
///
/// Energies in J. The quadratures have order 4, that of the best rows of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyLedger {
    start: f64,
    entries: Entries,
    displacement: Vec<f64>,
    middle: Vec<f64>,
    force: Vec<f64>,
}

/// What a step changes \[J\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entries {
    kinetic: f64,
    potential: f64,
    work: f64,
    dissipated: f64,
    max_change: f64,
    max_imbalance: f64,
    max_kinetic: f64,
}

impl EnergyLedger {
    /// Opens the books at (q, v) with E₀ = K + V.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn open(model: &Model, workspace: &mut Workspace, q: &[f64], v: &[f64]) -> Self {
        let kinetic = kinetic_energy(model, workspace, q, v);
        let potential = potential_energy(model, workspace, q);
        let nothing = vec![0.0; model.nv()];
        Self {
            start: kinetic + potential,
            entries: Entries {
                kinetic,
                potential,
                work: 0.0,
                dissipated: 0.0,
                max_change: 0.0,
                max_imbalance: 0.0,
                max_kinetic: kinetic,
            },
            displacement: nothing.clone(),
            middle: nothing.clone(),
            force: nothing,
        }
    }

    /// The books of a run from (q, v), and these; or why there is no such run, with the books of neutral at rest, as a
    /// start that is none has no energy. `overflow` makes an error of the coordinate that moves fastest and E₀, where
    /// that is not finite.
    pub(crate) fn open_start<E>(
        model: &Model,
        workspace: &mut Workspace,
        q: &[f64],
        v: &[f64],
        start: Result<(), E>,
        overflow: impl FnOnce(usize, f64) -> E,
    ) -> (Self, Vec<f64>, Vec<f64>, Result<(), E>) {
        let error = match start {
            Ok(()) => {
                let ledger = Self::open(model, workspace, q, v);
                if ledger.start.is_finite() {
                    return (ledger, q.to_vec(), v.to_vec(), Ok(()));
                }
                overflow(fastest(v), ledger.start)
            }
            Err(error) => error,
        };
        let (q, v) = (neutral(model), vec![0.0; model.nv()]);
        (Self::open(model, workspace, &q, &v), q, v, Err(error))
    }

    /// [`record`](Self::record), unless an energy is not finite then: the books stay as they are.
    ///
    /// # Errors
    /// The coordinate that moves fastest, and E.
    pub(crate) fn record_finite(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        from: (&[f64], &[f64]),
        to: (&[f64], &[f64]),
        forces: &StepForces<'_>,
        h: f64,
    ) -> Result<(), (usize, f64)> {
        let before = self.entries;
        self.record(model, workspace, from, to, forces, h);
        if self.imbalance().is_finite() {
            return Ok(());
        }
        let energy = self.now();
        self.entries = before;
        Err((fastest(to.1), energy))
    }

    /// Enters one step of `h` \[s\] from state `from` to state `to` (each (q, v)) under the forces of the step.
    ///
    /// The work of the held τ is τ·∫v dt. For plain coordinates ∫v dt = q₁ − q₀, exact along any path; for
    /// quaternion joints it is q₁ ⊖ q₀ − h²/12 \[v₀,v₁\], the Magnus expansion up to O(h⁵) **(HLW §IV.7)**.
    /// ∫ b·v dt is taken by Simpson's rule on the parabola for v with this integral.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn record(
        &mut self,
        model: &Model,
        workspace: &mut Workspace,
        from: (&[f64], &[f64]),
        to: (&[f64], &[f64]),
        forces: &StepForces<'_>,
        h: f64,
    ) {
        let ((q0, v0), (q1, v1)) = (from, to);
        self.entries.kinetic = kinetic_energy(model, workspace, q1, v1);
        self.entries.potential = potential_energy(model, workspace, q1);
        difference(model, q0, q1, &mut self.displacement);
        self.take_off_commutators(model, v0, v1, h);
        self.entries.work += dot(forces.tau, &self.displacement);
        if forces.dissipation {
            for k in 0..v0.len() {
                self.middle[k] = 1.5 / h * self.displacement[k] - 0.25 * (v0[k] + v1[k]);
            }
            let mut power = |v: &[f64]| {
                dissipation(model, v, &mut self.force);
                dot(&self.force, v)
            };
            self.entries.dissipated += (power(v0) + 4.0 * power(&self.middle) + power(v1)) * (h / 6.0);
        }
        self.note_extremes();
    }

    /// Enters a state whose work and dissipation were integrated with the motion.
    #[cfg(feature = "adaptive")]
    pub(super) fn enter(&mut self, kinetic: f64, potential: f64, work: f64, dissipated: f64) {
        self.entries = Entries { kinetic, potential, work, dissipated, ..self.entries };
        self.note_extremes();
    }

    fn note_extremes(&mut self) {
        let (change, imbalance) = (self.now() - self.start, self.imbalance());
        let entries = &mut self.entries;
        entries.max_kinetic = entries.max_kinetic.max(entries.kinetic);
        entries.max_change = entries.max_change.max(change.abs());
        entries.max_imbalance = entries.max_imbalance.max(imbalance.abs());
    }

    fn take_off_commutators(&mut self, model: &Model, v0: &[f64], v1: &[f64], h: f64) {
        let factor = -h * h / 12.0;
        let mut add = |k: usize, x: V3<f64>| {
            let sum = vector_at(&self.displacement, k).add_scaled(factor, x);
            self.displacement[k..k + 3].copy_from_slice(&sum.array());
        };
        for stretch in stretches(model) {
            let k = stretch.v;
            match stretch.chart {
                Chart::Line => {}
                Chart::Rotation => add(k, vector_at(v0, k).cross(vector_at(v1, k))),
                Chart::Placement => {
                    let at = |v| (vector_at(v, k), vector_at(v, k + 3));
                    let (linear, angular) = bracket(at(v0), at(v1));
                    add(k, linear);
                    add(k + 3, angular);
                }
            }
        }
    }

    /// E₀ \[J\].
    pub fn start(&self) -> f64 {
        self.start
    }

    /// E after the last step \[J\].
    pub fn now(&self) -> f64 {
        self.entries.kinetic + self.entries.potential
    }

    /// K after the last step \[J\].
    pub fn kinetic(&self) -> f64 {
        self.entries.kinetic
    }

    /// V after the last step \[J\].
    pub fn potential(&self) -> f64 {
        self.entries.potential
    }

    /// ∫ τ·v dt so far \[J\].
    pub fn work(&self) -> f64 {
        self.entries.work
    }

    /// ∫ b·v dt so far \[J\]: what damping and friction took out.
    pub fn dissipated(&self) -> f64 {
        self.entries.dissipated
    }

    /// E − E₀ − work + dissipated \[J\]: zero for the exact motion.
    pub fn imbalance(&self) -> f64 {
        self.now() - self.start - self.entries.work + self.entries.dissipated
    }

    /// The largest |imbalance| so far \[J\].
    pub fn max_imbalance(&self) -> f64 {
        self.entries.max_imbalance
    }

    /// max |E − E₀| / [`scale`](Self::scale): the energy drift, where nothing puts energy in or takes it out.
    pub fn drift(&self) -> f64 {
        if self.entries.max_change == 0.0 { 0.0 } else { self.entries.max_change / self.scale() }
    }

    /// What an energy is compared with, [`dynamics::energy_scale`] of the run so far \[J\].
    pub fn scale(&self) -> f64 {
        dynamics::energy_scale(self.start, self.entries.max_kinetic)
    }
}

/// The coordinate that moves fastest: squares overflow before velocities do.
pub(super) fn fastest(v: &[f64]) -> usize {
    (0..v.len()).max_by(|&i, &j| v[i].abs().total_cmp(&v[j].abs())).unwrap_or(0)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
