//! The energy of a run: what the forces put in and took out, and what the integrator made up.

use nalgebra::SVector;

use super::{Integrator, IntegratorError, State};
use crate::Dynamics;

/// The books of a run, one entry per step: E = E₀ + (work of u) − (dissipated by b) + (the integrator's error).
///
/// Energies in J. For a run without u and b the imbalance is the energy drift.
///
/// ```
/// use dynamics::{EnergyLedger, Integrator, Reach2R};
/// use nalgebra::vector;
/// let arm = Reach2R::worked_example();
/// let (mut q, mut qd, u) = (vector![0.0, 0.0], vector![0.0, 0.0], vector![30.0, 6.0]);
/// let mut ledger = EnergyLedger::open(&arm, &q, &qd);
/// for _ in 0..1000 {
///     let next = Integrator::RungeKutta4.step(&arm, &q, &qd, &u, 1e-3)?;
///     ledger.record(&arm, (&q, &qd), (&next.0, &next.1), &u, 1e-3);
///     (q, qd) = next;
/// }
/// // The motors put energy in, and all of it is accounted for.
/// assert!(ledger.work() > 1.0 && ledger.max_imbalance() < 1e-7);
/// # Ok::<(), dynamics::IntegratorError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyLedger {
    start: f64,
    kinetic: f64,
    potential: f64,
    work: f64,
    dissipated: f64,
    max_change: f64,
    max_imbalance: f64,
    max_kinetic: f64,
    potentials: [f64; 2],
    max_through: f64,
}

impl EnergyLedger {
    /// Opens the books at K and V \[J\].
    pub fn new(kinetic: f64, potential: f64) -> Self {
        Self {
            start: kinetic + potential,
            kinetic,
            potential,
            work: 0.0,
            dissipated: 0.0,
            max_change: 0.0,
            max_imbalance: 0.0,
            max_kinetic: kinetic,
            potentials: [potential; 2],
            max_through: 0.0,
        }
    }

    /// Opens the books at (q, q̇) with E₀ = K + V.
    pub fn open<D: Dynamics<N> + ?Sized, const N: usize>(
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
    ) -> Self {
        Self::new(system.kinetic_energy(q, qd), system.potential_energy(q))
    }

    /// Enters K and V of now, and all work and dissipation since the start \[J\].
    pub fn enter(&mut self, kinetic: f64, potential: f64, work: f64, dissipated: f64) {
        (self.kinetic, self.potential, self.work, self.dissipated) = (kinetic, potential, work, dissipated);
        self.max_kinetic = self.max_kinetic.max(kinetic);
        let [least, most] = self.potentials;
        self.potentials = [least.min(potential), most.max(potential)];
        self.max_through = self.max_through.max(work.abs()).max(dissipated.abs());
        self.max_change = self.max_change.max((self.now() - self.start).abs());
        self.max_imbalance = self.max_imbalance.max(self.imbalance().abs());
    }

    /// Enters one step of `h` \[s\] from state `from` to state `to` (each (q, q̇)) under the held force u.
    ///
    /// The work of u is u·(q₁−q₀), exact along any path; ∫ b·q̇ dt is taken by Simpson's rule on the cubic
    /// through both states, order 4.
    pub fn record<D: Dynamics<N> + ?Sized, const N: usize>(
        &mut self,
        system: &D,
        from: (&SVector<f64, N>, &SVector<f64, N>),
        to: (&SVector<f64, N>, &SVector<f64, N>),
        u: &SVector<f64, N>,
        h: f64,
    ) {
        let ((q0, qd0), (q1, qd1)) = (from, to);
        let work = self.work + u.dot(&(q1 - q0));

        // The cubic Hermite interpolant at the middle of the step.
        let q_middle = (q0 + q1) / 2.0 + (qd0 - qd1) * (h / 8.0);
        let qd_middle = (q1 - q0) * (1.5 / h) - (qd0 + qd1) / 4.0;
        let power = |q, qd: &SVector<f64, N>| system.dissipation(q, qd).dot(qd);
        let lost = (power(q0, qd0) + 4.0 * power(&q_middle, &qd_middle) + power(q1, qd1)) * (h / 6.0);
        self.enter(system.kinetic_energy(q1, qd1), system.potential_energy(q1), work, self.dissipated + lost);
    }

    /// E₀ \[J\].
    pub fn start(&self) -> f64 {
        self.start
    }

    /// E after the last step \[J\].
    pub fn now(&self) -> f64 {
        self.kinetic + self.potential
    }

    /// K after the last step \[J\].
    pub fn kinetic(&self) -> f64 {
        self.kinetic
    }

    /// V after the last step \[J\].
    pub fn potential(&self) -> f64 {
        self.potential
    }

    /// ∫ u·q̇ dt so far \[J\].
    pub fn work(&self) -> f64 {
        self.work
    }

    /// ∫ b·q̇ dt so far \[J\]: positive where b takes energy out.
    pub fn dissipated(&self) -> f64 {
        self.dissipated
    }

    /// E − E₀ − work + dissipated \[J\]: zero for the exact motion.
    pub fn imbalance(&self) -> f64 {
        self.now() - self.start - self.work + self.dissipated
    }

    /// The largest |imbalance| so far \[J\].
    pub fn max_imbalance(&self) -> f64 {
        self.max_imbalance
    }

    /// Whether neither work nor dissipation was entered so far, so that E should have stayed at E₀.
    pub fn is_conservative(&self) -> bool {
        self.max_through == 0.0
    }

    /// The energy that the run moved about \[J\]: max K + max V − min V, or the largest |work| or |dissipated| where that is more. Unlike |E₀|
    /// it does not depend on where V is zero.
    pub fn energy_moved(&self) -> f64 {
        let [least, most] = self.potentials;
        (self.max_kinetic + most - least).max(self.max_through)
    }

    /// max |imbalance| / [`energy_moved`](Self::energy_moved): the relative error of any run, driven and damped ones too.
    ///
    /// ```
    /// let mut ledger = dynamics::EnergyLedger::new(0.0, -1000.0);
    /// ledger.enter(3.0, -999.0, 4.5, 0.48); // motors put in 4.5 J, dampers took 0.48 J
    /// assert!((ledger.energy_moved() - 4.5).abs() < 1e-12);
    /// assert!((ledger.relative_imbalance() - 0.02 / 4.5).abs() < 1e-12);
    /// assert!(!ledger.is_conservative());
    /// ```
    pub fn relative_imbalance(&self) -> f64 {
        if self.max_imbalance == 0.0 { 0.0 } else { self.max_imbalance / self.energy_moved() }
    }

    /// max |E − E₀| / [`scale`](Self::scale): the relative error of a conservative run. In other runs it holds what motors and dampers did, and
    /// [`relative_imbalance`](Self::relative_imbalance) is the error.
    pub fn drift(&self) -> f64 {
        if self.max_change == 0.0 { 0.0 } else { self.max_change / self.scale() }
    }

    /// What an energy is compared with, [`energy_scale`] of the run so far \[J\].
    pub fn scale(&self) -> f64 {
        energy_scale(self.start, self.max_kinetic)
    }
}

/// What an energy error is compared with: |E₀|, or the largest kinetic energy of the run where |E₀| is below
/// 1e-9 of that, since the zero of V is a convention and E₀ may sit on it \[J\].
///
/// ```
/// assert_eq!(dynamics::energy_scale(-85.4, 70.0), 85.4);
/// assert_eq!(dynamics::energy_scale(1e-12, 70.0), 70.0);
/// ```
pub fn energy_scale(start: f64, largest_kinetic: f64) -> f64 {
    if start.abs() > 1e-9 * largest_kinetic { start.abs() } else { largest_kinetic }
}

/// A whole run with its ledger and the imbalance early and late, which tells drift from oscillation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnergyRun<const N: usize> {
    /// (q, q̇) at the end.
    pub end: State<N>,
    /// The books.
    pub ledger: EnergyLedger,
    /// The largest |imbalance| in the first tenth of the steps \[J\].
    pub first_tenth: f64,
    /// The largest |imbalance| in the last tenth of the steps \[J\]: of the size of the first where the
    /// error only oscillates, about ten times it or more where it accumulates.
    pub last_tenth: f64,
}

/// Runs `steps` steps of `h` \[s\] from (q0, q̇0) with u held throughout, keeping the books.
///
/// ```
/// use dynamics::{Integrator, Reach2R, energy_run};
/// use nalgebra::{Vector2, vector};
/// // An arm swings about the vertical: the symplectic row's error stays, Runge–Kutta's grows with every step.
/// let (arm, q0, rest) = (Reach2R::worked_example(), vector![-1.3, 0.1], Vector2::zeros());
/// let growth = |row| {
///     let run = energy_run(&arm, &q0, &rest, &rest, 0.01, 4000, row)?;
///     Ok::<f64, dynamics::IntegratorError>(run.last_tenth / run.first_tenth)
/// };
/// assert!(growth(Integrator::VariationalMidpoint)? < 2.0);
/// assert!(growth(Integrator::RungeKutta4)? > 5.0);
/// # Ok::<(), dynamics::IntegratorError>(())
/// ```
///
/// # Errors
/// Where [`Integrator::step`] gives one; [`IntegratorError::EnergyNotFinite`] where the motion blows up.
///
/// # Panics
/// If `h` is not positive and finite.
pub fn energy_run<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q0: &SVector<f64, N>,
    qd0: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
    steps: usize,
    integrator: Integrator,
) -> Result<EnergyRun<N>, IntegratorError> {
    let (mut q, mut qd) = (*q0, *qd0);
    let mut ledger = EnergyLedger::open(system, &q, &qd);
    let (mut first_tenth, mut last_tenth) = (0.0_f64, 0.0_f64);
    let tenth = steps.div_ceil(10);
    for done in 1..=steps {
        let next = integrator.step(system, &q, &qd, u, h)?;
        ledger.record(system, (&q, &qd), (&next.0, &next.1), u, h);
        (q, qd) = next;
        let imbalance = ledger.imbalance().abs();
        if !imbalance.is_finite() {
            return Err(IntegratorError::EnergyNotFinite { steps_done: done });
        }
        if done <= tenth {
            first_tenth = first_tenth.max(imbalance);
        }
        if done > steps - tenth {
            last_tenth = last_tenth.max(imbalance);
        }
    }
    Ok(EnergyRun { end: (q, qd), ledger, first_tenth, last_tenth })
}

/// The energy drift of a run: max over the steps of |E − E₀| / |E₀|, E = K + V, with u held throughout.
///
/// It measures the integrator where u = 0 and b = 0. Where |E₀| is nothing to compare with, the divisor
/// is [`EnergyLedger::scale`]'s.
///
/// # Errors
/// Where [`Integrator::step`] gives one; [`IntegratorError::EnergyNotFinite`] where the motion blows up.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
///
/// ```
/// use dynamics::{Integrator, Reach2R, energy_drift};
/// use nalgebra::{vector, Vector2};
/// use std::f64::consts::PI;
/// let (arm, q0, rest) = (Reach2R::worked_example(), vector![PI / 4.0, PI / 2.0], Vector2::zeros());
/// let drift = energy_drift(&arm, &q0, &rest, &rest, 1e-3, 1000, Integrator::RungeKutta4)?;
/// assert!(drift < 1e-7);
/// # Ok::<(), dynamics::IntegratorError>(())
/// ```
pub fn energy_drift<D: Dynamics<N> + ?Sized, const N: usize>(
    system: &D,
    q0: &SVector<f64, N>,
    qd0: &SVector<f64, N>,
    u: &SVector<f64, N>,
    h: f64,
    steps: usize,
    integrator: Integrator,
) -> Result<f64, IntegratorError> {
    Ok(energy_run(system, q0, qd0, u, h, steps, integrator)?.ledger.drift())
}
