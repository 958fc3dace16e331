//! The inertia ellipse: joint velocities of equal kinetic energy.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_integrators::IntegratorError;

/// Sweeps of the eigenvalue iteration. Convergence is quadratic: 8 suffice below N = 100; 30 is the limit.
const SWEEPS: usize = 30;

/// The ellipsoid {q̇ : q̇ᵀM q̇ = level} by its semi-axes, longest first. **(MR §8.1)**
///
/// With M dᵢ = λᵢ dᵢ, semi-axis i is √(level/λᵢ) along the unit vector dᵢ. [`new`](Self::new) has the level 1
/// of the chapter, which is K = ½ J. The velocities of kinetic energy E are at level 2E, so their semi-axes
/// are √(2E) times longer: [`of_energy`](Self::of_energy). A long axis is a direction of small inertia.
///
/// Coordinates of mixed units (m and rad) give an ellipsoid whose shape depends on the units.
///
/// ```
/// use dynamics::{Dynamics, InertiaEllipse, Reach2R};
/// use nalgebra::vector;
/// use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
/// let arm = Reach2R::worked_example();
/// let ellipse = InertiaEllipse::new(&arm.mass(&vector![FRAC_PI_4, FRAC_PI_2])).unwrap();
/// assert!((ellipse.semi_axes - vector![1.928, 0.696]).abs().max() < 5e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaEllipse<const N: usize> {
    /// Semi-axes, longest first \[rad/s or m/s\].
    pub semi_axes: SVector<f64, N>,
    /// Column i is the unit direction of semi-axis i; its largest entry is positive.
    pub directions: SMatrix<f64, N, N>,
}

impl<const N: usize> InertiaEllipse<N> {
    /// The ellipsoid q̇ᵀM q̇ = 1 of a mass matrix.
    ///
    /// # Errors
    /// [`IntegratorError`] if M is not finite or not positive definite.
    pub fn new(mass: &SMatrix<f64, N, N>) -> Result<Self, IntegratorError> {
        crate::solve_mass(mass, &SVector::zeros())?;
        let (eigenvalues, vectors) = symmetric_eigen(mass);
        let mut order: [usize; N] = core::array::from_fn(|i| i);
        order.sort_by(|&i, &j| eigenvalues[i].total_cmp(&eigenvalues[j]));
        // Cholesky accepts a pivot of a few ε; the corresponding eigenvalue can round to zero or below.
        if let Some(&i) = order.first().filter(|&&i| eigenvalues[i] <= 0.0) {
            let coordinate = vectors.column(i).iamax();
            return Err(IntegratorError::SingularMass { coordinate, pivot: eigenvalues[i] });
        }
        let directions = SMatrix::from_fn(|row, i| {
            let column = vectors.column(order[i]);
            column[row] * column[column.iamax()].signum()
        });
        Ok(Self { semi_axes: SVector::from_fn(|i, _| eigenvalues[order[i]].sqrt().recip()), directions })
    }

    /// The velocities of kinetic energy ½ q̇ᵀM q̇ = `energy` \[J\]: semi-axes √(2E/λᵢ).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Panics
    /// If `energy` is not positive and finite.
    pub fn of_energy(mass: &SMatrix<f64, N, N>, energy: f64) -> Result<Self, IntegratorError> {
        assert!(energy > 0.0 && energy.is_finite(), "the energy must be positive and finite, got {energy} J");
        let unit = Self::new(mass)?;
        Ok(Self { semi_axes: unit.semi_axes * (2.0 * energy).sqrt(), ..unit })
    }

    /// The point of the ellipsoid over the point `unit` of the unit sphere: Σ unitᵢ semi-axisᵢ dᵢ.
    pub fn point(&self, unit: &SVector<f64, N>) -> SVector<f64, N> {
        self.directions * unit.component_mul(&self.semi_axes)
    }
}

/// Eigenvalues and unit eigenvectors (columns) of a symmetric matrix, by Jacobi rotations.
///
/// Each rotation zeroes one off-diagonal pair; sweeps over all pairs converge quadratically. For positive
/// definite matrices Jacobi's method computes small eigenvalues to relative precision. Source: Golub, Van
/// Loan, *Matrix Computations* (2013), ch. 8.5.
///
/// ```
/// use dynamics::symmetric_eigen;
/// use nalgebra::{SMatrix, matrix};
/// let m = matrix![2.0, 1.0; 1.0, 2.0]; // eigenvalues 1 and 3
/// let (values, vectors) = symmetric_eigen(&m);
/// assert!((values.min() - 1.0).abs() < 1e-15 && (values.max() - 3.0).abs() < 1e-15);
/// assert!((m * vectors - vectors * SMatrix::from_diagonal(&values)).norm() < 1e-15);
/// assert!((vectors.transpose() * vectors - SMatrix::identity()).norm() < 1e-15);
/// ```
pub fn symmetric_eigen<const N: usize>(matrix: &SMatrix<f64, N, N>) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    let (mut a, mut vectors) = (*matrix, SMatrix::<f64, N, N>::identity());
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..N {
            for q in p + 1..N {
                // An entry below the rounding of its diagonal pair counts as zero.
                if a[(p, q)].abs() <= f64::EPSILON * (a[(p, p)] * a[(q, q)]).abs().sqrt() {
                    continue;
                }
                rotated = true;
                // tan of the smaller angle that zeroes a_pq: t² + 2 cot(2φ) t − 1 = 0.
                let cot2 = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
                let t = cot2.signum() / (cot2.abs() + cot2.hypot(1.0));
                let c = t.hypot(1.0).recip();
                rotate(&mut a, &mut vectors, (p, q), (c, t * c));
            }
        }
        if !rotated {
            break;
        }
    }
    (a.diagonal(), vectors)
}

/// a ← JᵀaJ and V ← VJ for the rotation J by (cos, sin) in the plane of coordinates p and q.
fn rotate<const N: usize>(
    a: &mut SMatrix<f64, N, N>,
    vectors: &mut SMatrix<f64, N, N>,
    (p, q): (usize, usize),
    (c, s): (f64, f64),
) {
    for k in 0..N {
        let (x, y) = (a[(k, p)], a[(k, q)]);
        (a[(k, p)], a[(k, q)]) = (c * x - s * y, s * x + c * y);
    }
    for k in 0..N {
        let (x, y) = (a[(p, k)], a[(q, k)]);
        (a[(p, k)], a[(q, k)]) = (c * x - s * y, s * x + c * y);
        let (x, y) = (vectors[(k, p)], vectors[(k, q)]);
        (vectors[(k, p)], vectors[(k, q)]) = (c * x - s * y, s * x + c * y);
    }
    (a[(p, q)], a[(q, p)]) = (0.0, 0.0);
}
