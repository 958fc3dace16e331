//! The energy of a run against the energy it started with.

use nalgebra::SVector;

use super::{Integrator, IntegratorError};
use crate::Dynamics;

/// The energy drift of a run: max over the steps of |E − E₀| / |E₀|, E = K + V, with u held throughout.
///
/// A measure of the integrator where u = 0 and b = 0. The zero of V is a convention, so |E₀| may be
/// nothing to compare with: where |E₀| is below 1e-9 of the largest kinetic energy of the run, that
/// kinetic energy is the divisor.
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
    let (mut q, mut qd) = (*q0, *qd0);
    let start = system.energy(&q, &qd);
    let mut worst: f64 = 0.0;
    let mut kinetic: f64 = system.kinetic_energy(&q, &qd);
    for done in 1..=steps {
        (q, qd) = integrator.step(system, &q, &qd, u, h)?;
        let k = system.kinetic_energy(&q, &qd);
        let energy = k + system.potential_energy(&q);
        if !energy.is_finite() {
            return Err(IntegratorError::EnergyNotFinite { steps_done: done });
        }
        worst = worst.max((energy - start).abs());
        kinetic = kinetic.max(k);
    }
    let scale = if start.abs() > 1e-9 * kinetic { start.abs() } else { kinetic };
    Ok(if worst == 0.0 { 0.0 } else { worst / scale })
}
