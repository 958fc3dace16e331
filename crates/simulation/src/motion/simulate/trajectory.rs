//! The samples of a run, in flat arrays.

use robot_dynamics_core::Model;
use robot_dynamics_integrators::EnergyAccount;

/// The samples of a run: time, state, torque and energies, one row each.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    nq: usize,
    nv: usize,
    times: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    kinetic: Vec<f64>,
    potential: Vec<f64>,
    contact_forces: Vec<[f64; 3]>,
}

/// One sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sample<'a> {
    /// Time since the start \[s\].
    pub time: f64,
    /// The configuration.
    pub q: &'a [f64],
    /// The velocity.
    pub v: &'a [f64],
    /// The torque from this sample on \[N·m or N\].
    pub tau: &'a [f64],
    /// K \[J\].
    pub kinetic: f64,
    /// V \[J\].
    pub potential: f64,
    /// The force of the ground on each link that can touch it \[N\]:
    /// [`StepInfo::contact_forces`](crate::StepInfo::contact_forces).
    pub contact_forces: &'a [[f64; 3]],
}

impl Sample<'_> {
    /// E = K + V \[J\].
    pub fn energy(&self) -> f64 {
        self.kinetic + self.potential
    }
}

impl Trajectory {
    pub fn new(model: &Model, capacity: usize) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        let numbers = Vec::with_capacity;
        Self {
            nq,
            nv,
            times: numbers(capacity),
            q: numbers(capacity * nq),
            v: numbers(capacity * nv),
            tau: numbers(capacity * nv),
            kinetic: numbers(capacity),
            potential: numbers(capacity),
            contact_forces: Vec::new(),
        }
    }

    pub fn push(
        &mut self,
        time: f64,
        (q, v): (&[f64], &[f64]),
        tau: &[f64],
        energy_account: &EnergyAccount,
        contact_forces: &[[f64; 3]],
    ) {
        self.times.push(time);
        self.q.extend_from_slice(q);
        self.v.extend_from_slice(v);
        self.tau.extend_from_slice(tau);
        self.kinetic.push(energy_account.kinetic());
        self.potential.push(energy_account.potential());
        self.contact_forces.extend_from_slice(contact_forces);
    }

    /// Adds the actuators' torques to the last sample, once they are known.
    pub(crate) fn add_to_last_tau(&mut self, torques: &[f64]) {
        let first = self.tau.len().saturating_sub(torques.len());
        for (tau, torque) in self.tau[first..].iter_mut().zip(torques) {
            *tau += torque;
        }
    }

    /// The number of samples.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Sample i.
    ///
    /// # Panics
    /// Panics if `i` is not less than [`len`](Self::len).
    #[track_caller]
    pub fn sample(&self, i: usize) -> Sample<'_> {
        let (nq, nv, links) = (self.nq, self.nv, self.contact_forces.len() / self.len());
        Sample {
            time: self.times[i],
            q: &self.q[i * nq..(i + 1) * nq],
            v: &self.v[i * nv..(i + 1) * nv],
            tau: &self.tau[i * nv..(i + 1) * nv],
            kinetic: self.kinetic[i],
            potential: self.potential[i],
            contact_forces: &self.contact_forces[i * links..(i + 1) * links],
        }
    }

    /// All samples in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Sample<'_>> {
        (0..self.len()).map(|i| self.sample(i))
    }
}
