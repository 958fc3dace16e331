//! Pfaffian constraints A(q) q̇ = 0: velocities that a wheel, a blade or a rod forbids.
//!
//! The floor exerts the force Aᵀλ, which does no work on any allowed velocity. The motion satisfies M q̈ + C
//! q̇ + g + b = u + Aᵀλ with A q̈ + Ȧ q̇ = 0 **(PRM 10.16)**. This module rests on one factorisation, the
//! Gram–Schmidt form of the rows in the metric M⁻¹ ([`RowFactor`]).

mod error;
mod kkt;
mod mass_factor;
mod projection;
mod row_factor;
mod step;

use nalgebra::{SMatrix, SVector};
use robot_dynamics_number::{Dual, Scalar};

pub use error::{ConstraintError, DependentRow};
pub use kkt::{constrained_forward_dynamics, constrained_forward_dynamics_by_lu};
pub use projection::{ConstraintProjections, reduced_acceleration};
pub use row_factor::RowFactor;
pub use step::{ConstrainedStep, constrained_rk4_step};

/// `K` constraint rows on `N` coordinates: A(q) q̇ = 0. **(PRM 10.16)**
///
/// Write the rows over a generic scalar ([`PfaffianOver`]) and wrap them in [`FromRows`] to get Ȧ exactly.
pub trait Pfaffian<const K: usize, const N: usize> {
    /// A(q), K×N.
    fn rows(&self, q: &SVector<f64, N>) -> SMatrix<f64, K, N>;

    /// Ȧ(q,q̇) = Σₖ ∂A/∂qₖ q̇ₖ, K×N.
    fn rows_rate(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SMatrix<f64, K, N>;
}

/// Constraint rows written over a generic scalar.
pub trait PfaffianOver<const K: usize, const N: usize> {
    /// A(q), row by row.
    fn rows_over<S: Scalar>(&self, q: &[S; N]) -> [[S; N]; K];
}

/// Makes a [`PfaffianOver`] a [`Pfaffian`]: Ȧ is the derivative of A along q̇, by one dual number.
///
/// ```
/// use dynamics::{FromRows, Pfaffian, PfaffianOver};
/// use nalgebra::{matrix, vector};
/// use robot_dynamics_number::Scalar;
/// /// A rod of fixed length from the origin to (x, y): x ẋ + y ẏ = 0.
/// struct Rod;
/// impl PfaffianOver<1, 2> for Rod {
///     fn rows_over<S: Scalar>(&self, q: &[S; 2]) -> [[S; 2]; 1] {
///         [*q]
///     }
/// }
/// let rate = FromRows(Rod).rows_rate(&vector![0.6, -0.8], &vector![4.0, 3.0]);
/// assert_eq!(rate, matrix![4.0, 3.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FromRows<R>(pub R);

impl<R: PfaffianOver<K, N>, const K: usize, const N: usize> Pfaffian<K, N> for FromRows<R> {
    fn rows(&self, q: &SVector<f64, N>) -> SMatrix<f64, K, N> {
        let rows = self.0.rows_over(&q.data.0[0]);
        SMatrix::from_fn(|i, j| rows[i][j])
    }

    fn rows_rate(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SMatrix<f64, K, N> {
        let path: [Dual<f64, 1>; N] = core::array::from_fn(|i| Dual { value: q[i], gradient: [qd[i]] });
        let rows = self.0.rows_over(&path);
        SMatrix::from_fn(|i, j| rows[i][j].gradient[0])
    }
}

/// A constraint with feedback on a violating velocity: A q̇ decays as e^(−γt).
///
/// Ȧ is replaced by Ȧ + γA, so that the KKT solve imposes d(Aq̇)/dt = −γ Aq̇. It is an alternative to the
/// projection of [`constrained_rk4_step`] for callers with their own integrator. It needs no step of its own,
/// but it keeps A q̇ only near zero, and γ above about 2/h makes an explicit step unstable.
/// Source: Baumgarte, *Stabilization of constraints and integrals of motion* (1972), at velocity level.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "Stabilized")]
pub struct StabilizedConstraint<C> {
    /// The constraint.
    pub constraint: C,
    /// γ \[1/s\]; 0 disables the feedback.
    pub rate: f64,
}

impl<C: Pfaffian<K, N>, const K: usize, const N: usize> Pfaffian<K, N> for StabilizedConstraint<C> {
    fn rows(&self, q: &SVector<f64, N>) -> SMatrix<f64, K, N> {
        self.constraint.rows(q)
    }

    fn rows_rate(&self, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> SMatrix<f64, K, N> {
        self.constraint.rows_rate(q, qd) + self.constraint.rows(q) * self.rate
    }
}
