//! The laws of any [`Dynamics`], with derivatives by differences.

use nalgebra::{DMatrix, SMatrix, SVector};

use super::differences::{derivative, missed};
use super::violation::Judge;
use super::{Report, Sample, States, Violation};
use crate::lagrange::largest;
use crate::{Dynamics, skew_symmetry_defect, solve_mass};

/// Rounding allowed for identities without derivatives, relative to their terms: (16 + 4N) ε.
pub(super) fn rounding<const N: usize>() -> f64 {
    (16 + 4 * N) as f64 * f64::EPSILON
}

/// Checks every law on a system given by its [`Dynamics`] alone; a robot from a file, for instance.
///
/// ```
/// use dynamics::{Dynamics, PolarMass, laws};
/// use nalgebra::vector;
/// let mass: &dyn Dynamics<2> = &PolarMass { m: 2.0, a_g: 9.81 };
/// // M = diag(m, m r²) is singular at r = 0, and the states of this box touch it:
/// let everywhere = laws::States::new(1).within(vector![0.0, -3.0], vector![2.0, 3.0]);
/// let violation = laws::check("polar mass", mass, &everywhere).unwrap_err();
/// assert_eq!(violation.law, "M is positive definite");
/// // Away from it every law holds, and the report says how well.
/// let report = laws::check("polar mass", mass, &everywhere.within(vector![0.1, -3.0], vector![2.0, 3.0]))?;
/// assert!(report.worst.iter().all(|(_law, ratio)| *ratio <= 1.0));
/// # Ok::<(), laws::Violation>(())
/// ```
///
/// # Errors
/// The first violated law with the model, the state, the defect found and the allowed one.
pub fn check<const N: usize>(
    model: &str,
    system: &(impl Dynamics<N> + ?Sized),
    states: &States<N>,
) -> Result<Report, Violation> {
    let mut judge = Judge::new(model, states);
    for sample in states.iter() {
        check_algebra(&mut judge, system, &sample)?;
        check_derivatives(&mut judge, system, &sample)?;
    }
    Ok(judge.report)
}

/// The condition number κ(M) = λmax/λmin and the largest eigenvalue; κ = ∞ if M is not positive definite.
pub(super) fn conditioning<const N: usize>(mass: &SMatrix<f64, N, N>) -> (f64, f64) {
    let eigenvalues = DMatrix::from_column_slice(N, N, mass.as_slice()).symmetric_eigenvalues();
    let (low, high) = (eigenvalues.min(), eigenvalues.max());
    (if low > 0.0 { high / low } else { f64::INFINITY }, high)
}

/// The largest entry of a matrix or vector; NaN if any entry is NaN, which violates every law.
pub(super) fn size_of<const R: usize, const C: usize>(values: &SMatrix<f64, R, C>) -> f64 {
    largest(values.iter().copied())
}

/// The laws that compare values: symmetry, energies, columns, round trips, dissipation.
fn check_algebra<const N: usize>(
    judge: &mut Judge<'_, N>,
    system: &(impl Dynamics<N> + ?Sized),
    sample: &Sample<N>,
) -> Result<(), Violation> {
    let Sample { q, qd, u, qdd, .. } = sample;
    let eps = rounding::<N>();
    let mass = system.mass(q);
    judge.require("M is finite", sample, size_of(&mass), f64::MAX)?;
    let (kappa, stiffest) = conditioning(&mass);
    let (product, gravity, loss) =
        (system.velocity_product(q, qd), system.gravity(q), system.dissipation(q, qd));
    let bias = product + gravity + loss;
    let bias_size = product.norm() + gravity.norm() + loss.norm();

    judge.require("M = Mᵀ", sample, size_of(&(mass - mass.transpose())), eps * size_of(&mass))?;
    let pivots = if solve_mass(&mass, u).is_ok() { kappa } else { f64::NAN };
    judge.require("M is positive definite", sample, pivots, 0.1 / f64::EPSILON)?;
    for j in 0..N {
        let unit = SVector::from_fn(|i, _| f64::from(u8::from(i == j)));
        let column = system.inverse(q, qd, &unit) - system.inverse(q, qd, &SVector::zeros());
        let defect = size_of(&(column - mass.column(j)));
        judge.require(
            "inverse(eⱼ) − inverse(0) = M eⱼ",
            sample,
            defect,
            eps * (size_of(&mass) + bias_size),
        )?;
    }
    let defect = size_of(&(system.inverse(q, qd, &SVector::zeros()) - bias));
    judge.require("inverse(0) = C q̇ + g + b", sample, defect, eps * bias_size)?;

    // K by the sum over all entries.
    let kinetic: f64 = (0..N).map(|i| (0..N).map(|j| 0.5 * qd[i] * mass[(i, j)] * qd[j]).sum::<f64>()).sum();
    let kinetic_size = stiffest * qd.norm_squared();
    let defect = (system.kinetic_energy(q, qd) - kinetic).abs();
    judge.require("K = ½ q̇ᵀM q̇", sample, defect, eps * kinetic_size)?;
    let potential = system.potential_energy(q);
    let defect = (system.energy(q, qd) - kinetic - potential).abs();
    judge.require("E = K + V", sample, defect, eps * (kinetic_size + potential.abs()))?;

    let matrix = system.coriolis_matrix(q, qd);
    let size = velocity_scale(&mass, &matrix, qd);
    judge.require("C q̇ = velocity product", sample, size_of(&(matrix * qd - product)), eps * size)?;
    let defect = size_of(&(system.velocity_product(q, &(qd * -2.0)) - product * 4.0));
    judge.require("C q̇ is quadratic in q̇", sample, defect, eps * size)?;
    judge.require("b·q̇ ≥ 0", sample, -loss.dot(qd), eps * loss.norm() * qd.norm())?;

    // q̈ → u → q̈: an error ε in u becomes κ ε in q̈, and the bias cancels.
    let back = system.try_forward(q, qd, &system.inverse(q, qd, qdd));
    let defect = back.map_or(f64::NAN, |back| (back - qdd).norm());
    let size = qdd.norm() + bias_size / stiffest;
    judge.require("forward ∘ inverse = identity", sample, defect, eps * kappa * size)?;
    // u → q̈ → u: ‖M‖‖q̈‖ is at most κ times the force that causes q̈.
    let acceleration = system.try_forward(q, qd, u);
    let defect = acceleration.map_or(f64::NAN, |qdd| (system.inverse(q, qd, &qdd) - u).norm());
    judge.require("inverse ∘ forward = identity", sample, defect, eps * kappa * (u.norm() + bias_size))
}

/// The size of the terms in C q̇: the largest of ‖M‖‖q̇‖ (1 + ‖q̇‖) and ‖C‖ (1 + ‖q̇‖).
///
/// Polarisation adds unit velocities to q̇, hence the 1.
pub(super) fn velocity_scale<const N: usize>(
    mass: &SMatrix<f64, N, N>,
    coriolis: &SMatrix<f64, N, N>,
    qd: &SVector<f64, N>,
) -> f64 {
    (mass.norm() * qd.norm()).max(coriolis.norm()) * (1.0 + qd.norm())
}

/// The laws with a derivative: gravity, Euler–Lagrange, skew symmetry, power.
fn check_derivatives<const N: usize>(
    judge: &mut Judge<'_, N>,
    system: &(impl Dynamics<N> + ?Sized),
    sample: &Sample<N>,
) -> Result<(), Violation> {
    let Sample { q, qd, u, .. } = sample;
    let unit = |k: usize| SVector::<f64, N>::from_fn(|i, _| f64::from(u8::from(i == k)));
    let mass = system.mass(q);

    let gravity = system.gravity(q);
    let slope = SVector::from_fn(|k, _| derivative(1.0, |s| system.potential_energy(&(q + unit(k) * s))));
    let size = gravity.norm() + system.potential_energy(q).abs();
    judge.require("g = ∂V/∂q, by differences", sample, size_of(&(slope - gravity)), missed::<N>() * size)?;

    // Ṁ depends on M only; the checks below share no code with the model's C.
    let rate = derivative(qd.norm(), |s| system.mass(&(q + qd * s)));
    let kinetic_gradient =
        SVector::from_fn(|k, _| derivative(1.0, |s| 0.5 * qd.dot(&(system.mass(&(q + unit(k) * s)) * qd))));
    let matrix = system.coriolis_matrix(q, qd);
    let size = velocity_scale(&mass, &matrix, qd);
    let defect = size_of(&(rate * qd - kinetic_gradient - system.velocity_product(q, qd)));
    judge.require("C q̇ = Ṁ q̇ − ½ ∂(q̇ᵀM q̇)/∂q, by differences", sample, defect, missed::<N>() * size)?;
    let defect = skew_symmetry_defect(&rate, &matrix);
    judge.require("Ṁ − 2C is skew-symmetric, by differences", sample, defect, missed::<N>() * size)?;

    // dE/dt along the motion that u causes.
    let Ok(qdd) = system.try_forward(q, qd, u) else {
        return judge.require("a motion exists", sample, f64::NAN, 0.0);
    };
    let speed = qd.norm().hypot(qdd.norm());
    let energy_rate = derivative(speed, |s| system.energy(&(q + qd * s), &(qd + qdd * s)));
    let power = (u - system.dissipation(q, qd)).dot(qd);
    let energy_size = mass.norm() * qd.norm_squared() + system.potential_energy(q).abs();
    let size = energy_size * speed + mass.norm() * qdd.norm() * qd.norm();
    let defect = (energy_rate - power).abs();
    judge.require("dE/dt = u·q̇ − b·q̇, by differences", sample, defect, missed::<N>() * size)
}
