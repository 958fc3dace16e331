//! The laws of a [`Lagrangian`] system, with exact derivatives.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_number::Dual;

use super::identities::{check, conditioning, rounding, size_of, velocity_scale};
use super::violation::Judge;
use super::{Report, Sample, States, Violation};
use crate::{Dynamics, Lagrangian, christoffel, mass_rate, skew_symmetry_defect};

/// Checks every law on a system that also has a [`Lagrangian`]. The laws of [`check`] are repeated with exact
/// derivatives of M and V, so that only rounding limits them.
///
/// ```
/// use dynamics::{PolarMass, laws};
/// use nalgebra::vector;
/// // Away from r = 0, where M is singular, every law holds to rounding.
/// let states = laws::States::new(1).within(vector![0.5, -3.0], vector![2.0, 3.0]);
/// let report = laws::check_all("polar mass", &PolarMass { m: 2.0, a_g: 9.81 }, &states)?;
/// assert!(report.worst.iter().any(|(law, _)| *law == "g = ∂V/∂q"));
/// assert!(report.worst.iter().all(|(_, found_over_allowed)| *found_over_allowed <= 1.0));
/// # Ok::<(), laws::Violation>(())
/// ```
///
/// # Errors
/// The first violated law with the model, the state, the defect found and the allowed one.
pub fn check_all<const N: usize>(
    model: &str,
    system: &(impl Dynamics<N> + Lagrangian<N>),
    states: &States<N>,
) -> Result<Report, Violation> {
    let mut report = check(model, system, states)?;
    let mut judge = Judge::new(model, states);
    for sample in states.iter() {
        check_exactly(&mut judge, system, &sample)?;
    }
    report.worst.extend(judge.report.worst);
    Ok(report)
}

fn check_exactly<const N: usize>(
    judge: &mut Judge<'_, N>,
    system: &(impl Dynamics<N> + Lagrangian<N>),
    sample: &Sample<N>,
) -> Result<(), Violation> {
    let Sample { q, qd, u, .. } = sample;
    let coordinates = &q.data.0[0];
    let eps = rounding::<N>();
    let mass = system.mass(q);
    let (kappa, _) = conditioning(&mass);

    let over = system.mass_over(coordinates);
    let defect = size_of(&(mass - SMatrix::from_fn(|i, j| over[i][j])));
    judge.require("M of Dynamics = M of Lagrangian", sample, defect, eps * size_of(&mass))?;

    let potential = system.potential_over(&Dual::variables(coordinates));
    let size = potential.value.abs() + SVector::from(potential.gradient).norm();
    let defect = (system.potential_energy(q) - potential.value).abs();
    judge.require("V of Dynamics = V of Lagrangian", sample, defect, eps * size)?;
    let gravity = system.gravity(q);
    let defect = size_of(&(gravity - SVector::from(potential.gradient)));
    judge.require("g = ∂V/∂q", sample, defect, eps * size)?;

    let symbols = christoffel(system, q);
    let matrix = system.coriolis_matrix(q, qd);
    let size = velocity_scale(&mass, &matrix, qd);
    let defect = size_of(&(system.velocity_product(q, qd) - symbols.velocity_product(qd)));
    judge.require("C q̇ = q̇ᵀΓ q̇", sample, defect, eps * size)?;
    let defect = size_of(&(matrix - symbols.coriolis_matrix(qd)));
    judge.require("C_ij = Σₖ Γⁱⱼₖ q̇ₖ", sample, defect, eps * size)?;
    // Ṁ is one derivative along q̇; C is a combination of partial derivatives, or a closed form.
    let rate = mass_rate(system, q, qd);
    let defect = skew_symmetry_defect(&rate, &matrix);
    judge.require("Ṁ − 2C is skew-symmetric", sample, defect, eps * size)?;

    // dE/dt: E over dual numbers that move with (q̇, q̈). The solve for q̈ may be off by κ ε in M q̈.
    let Ok(qdd) = system.try_forward(q, qd, u) else {
        return judge.require("a motion exists", sample, f64::NAN, 0.0);
    };
    let energy_rate = energy_rate(system, q, qd, &qdd);
    let loss = system.dissipation(q, qd);
    let force_size = u.norm() + loss.norm() + gravity.norm() + symbols.velocity_product(qd).norm();
    let size = kappa * force_size * qd.norm() + rate.norm() * qd.norm_squared();
    let defect = (energy_rate - (u - loss).dot(qd)).abs();
    judge.require("dE/dt = u·q̇ − b·q̇", sample, defect, eps * size)
}

/// dE/dt = d/ds (½ (q̇+sq̈)ᵀ M(q+sq̇) (q̇+sq̈) + V(q+sq̇)) at s = 0, exact.
fn energy_rate<const N: usize>(
    system: &impl Lagrangian<N>,
    q: &SVector<f64, N>,
    qd: &SVector<f64, N>,
    qdd: &SVector<f64, N>,
) -> f64 {
    type Moving = Dual<f64, 1>;
    let moving = |at: &SVector<f64, N>, rate: &SVector<f64, N>| -> [Moving; N] {
        core::array::from_fn(|i| Dual { value: at[i], gradient: [rate[i]] })
    };
    let (position, velocity) = (moving(q, qd), moving(qd, qdd));
    let mass = system.mass_over(&position);
    let mut energy = system.potential_over(&position);
    for i in 0..N {
        for j in 0..N {
            energy += velocity[i] * mass[i][j] * velocity[j] * Dual::constant(0.5);
        }
    }
    energy.gradient[0]
}
