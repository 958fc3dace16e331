//! The energy of a run of a fixed-size system: its steps recorded in an [`EnergyAccount`].

use nalgebra::SVector;
use robot_dynamics_integrators::{EnergyAccount, Integrator, IntegratorError};

use super::{State, SystemStep};
use crate::Dynamics;

/// The energy account of a [`Dynamics`] system.
///
/// ```
/// use dynamics::{Reach2R, SystemEnergy, SystemStep};
/// use nalgebra::vector;
/// use robot_dynamics_integrators::{EnergyAccount, Integrator};
/// let arm = Reach2R::worked_example();
/// let (mut q, mut qd, u) = (vector![0.0, 0.0], vector![0.0, 0.0], vector![30.0, 6.0]);
/// let mut energy_account = EnergyAccount::open(&arm, &q, &qd);
/// for _ in 0..1000 {
///     let next = Integrator::RungeKutta4.step(&arm, &q, &qd, &u, 1e-3)?;
///     energy_account.record(&arm, (&q, &qd), (&next.0, &next.1), &u, 1e-3);
///     (q, qd) = next;
/// }
/// // The motors put energy in, and all of it is accounted for.
/// assert!(energy_account.work() > 1.0 && energy_account.max_imbalance() < 1e-7);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
pub trait SystemEnergy: Sized {
    /// Opens the account at (q, q̇) with E₀ = K + V.
    fn open<D: Dynamics<N> + ?Sized, const N: usize>(
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
    ) -> Self;

    /// Records one step of `h` \[s\] from state `from` to state `to` (each (q, q̇)) under the held force u.
    ///
    /// The work of u is u·(q₁−q₀), exact along any path. ∫ b·q̇ dt is computed by Simpson's rule on the cubic
    /// through both states, of order 4.
    fn record<D: Dynamics<N> + ?Sized, const N: usize>(
        &mut self,
        system: &D,
        from: (&SVector<f64, N>, &SVector<f64, N>),
        to: (&SVector<f64, N>, &SVector<f64, N>),
        u: &SVector<f64, N>,
        h: f64,
    );
}

impl SystemEnergy for EnergyAccount {
    fn open<D: Dynamics<N> + ?Sized, const N: usize>(
        system: &D,
        q: &SVector<f64, N>,
        qd: &SVector<f64, N>,
    ) -> Self {
        Self::new(system.kinetic_energy(q, qd), system.potential_energy(q))
    }

    fn record<D: Dynamics<N> + ?Sized, const N: usize>(
        &mut self,
        system: &D,
        from: (&SVector<f64, N>, &SVector<f64, N>),
        to: (&SVector<f64, N>, &SVector<f64, N>),
        u: &SVector<f64, N>,
        h: f64,
    ) {
        let ((q0, qd0), (q1, qd1)) = (from, to);
        let work = self.work() + u.dot(&(q1 - q0));

        // The cubic Hermite interpolant at the midpoint of the step.
        let q_middle = (q0 + q1) / 2.0 + (qd0 - qd1) * (h / 8.0);
        let qd_middle = (q1 - q0) * (1.5 / h) - (qd0 + qd1) / 4.0;
        let power = |q, qd: &SVector<f64, N>| system.dissipation(q, qd).dot(qd);
        let lost = (power(q0, qd0) + 4.0 * power(&q_middle, &qd_middle) + power(q1, qd1)) * (h / 6.0);
        self.enter(
            system.kinetic_energy(q1, qd1),
            system.potential_energy(q1),
            work,
            self.dissipated() + lost,
        );
    }
}

/// A run with its energy account and the imbalance early and late, which distinguishes drift from
/// oscillation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnergyRun<const N: usize> {
    /// (q, q̇) at the end.
    pub end: State<N>,
    /// The energy account.
    pub energy_account: EnergyAccount,
    /// The largest |imbalance| in the first tenth of the steps \[J\].
    pub first_tenth: f64,
    /// The largest |imbalance| in the last tenth of the steps \[J\]. It has the size of the first tenth's if
    /// the error only oscillates, and about ten times that or more if the error accumulates.
    pub last_tenth: f64,
}

/// Runs `steps` steps of `h` \[s\] from (q0, q̇0) with u held throughout, and records the energy.
///
/// ```
/// use dynamics::{Reach2R, energy_run};
/// use nalgebra::{Vector2, vector};
/// use robot_dynamics_integrators::Integrator;
/// // An arm swings about the vertical: the symplectic row's error stays, Runge–Kutta's grows with every step.
/// let (arm, q0, rest) = (Reach2R::worked_example(), vector![-1.3, 0.1], Vector2::zeros());
/// let growth = |row| {
///     let run = energy_run(&arm, &q0, &rest, &rest, 0.01, 4000, row)?;
///     Ok::<f64, robot_dynamics_integrators::IntegratorError>(run.last_tenth / run.first_tenth)
/// };
/// assert!(growth(Integrator::VariationalMidpoint)? < 2.0);
/// assert!(growth(Integrator::RungeKutta4)? > 5.0);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
/// ```
///
/// # Errors
/// If [`SystemStep::step`] fails; [`IntegratorError::EnergyNotFinite`] if the motion diverges.
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
    let mut energy_account = EnergyAccount::open(system, &q, &qd);
    let (mut first_tenth, mut last_tenth) = (0.0_f64, 0.0_f64);
    let tenth = steps.div_ceil(10);
    for done in 1..=steps {
        let next = integrator.step(system, &q, &qd, u, h)?;
        energy_account.record(system, (&q, &qd), (&next.0, &next.1), u, h);
        (q, qd) = next;
        let imbalance = energy_account.imbalance().abs();
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
    Ok(EnergyRun { end: (q, qd), energy_account, first_tenth, last_tenth })
}

/// The energy drift of a run: max over the steps of |E − E₀| / |E₀|, E = K + V, with u held throughout.
///
/// It is the error of the integrator if u = 0 and b = 0. If |E₀| is too small for comparison, the divisor is
/// [`EnergyAccount::scale`].
///
/// # Errors
/// If [`SystemStep::step`] fails; [`IntegratorError::EnergyNotFinite`] if the motion diverges.
///
/// # Panics
/// If `h` \[s\] is not positive and finite.
///
/// ```
/// use dynamics::{Reach2R, energy_drift};
/// use nalgebra::{Vector2, vector};
/// use robot_dynamics_integrators::Integrator;
/// use std::f64::consts::PI;
/// let (arm, q0, rest) = (Reach2R::worked_example(), vector![PI / 4.0, PI / 2.0], Vector2::zeros());
/// let drift = energy_drift(&arm, &q0, &rest, &rest, 1e-3, 1000, Integrator::RungeKutta4)?;
/// assert!(drift < 1e-7);
/// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
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
    Ok(energy_run(system, q0, qd0, u, h, steps, integrator)?.energy_account.drift())
}
