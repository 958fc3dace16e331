//! The Cholesky factor of M, kept for several right-hand sides.

use nalgebra::{SMatrix, SVector};
use robot_dynamics_integrators::IntegratorError;

use crate::solve_mass;

/// M = L Lᵀ.
pub(crate) struct MassFactor<const N: usize> {
    /// L, lower triangular; the upper triangle is not used.
    lower: SMatrix<f64, N, N>,
}

impl<const N: usize> MassFactor<N> {
    /// Factors a symmetric positive definite M.
    pub(crate) fn new(mass: &SMatrix<f64, N, N>) -> Result<Self, IntegratorError> {
        // The checked solve rejects a non-finite or singular M and names the coordinate.
        solve_mass(mass, &SVector::zeros())?;
        let mut lower = *mass;
        for j in 0..N {
            for k in 0..j {
                let factor = lower[(j, k)];
                for i in j..N {
                    let product = factor * lower[(i, k)];
                    lower[(i, j)] -= product;
                }
            }
            let root = lower[(j, j)].sqrt();
            for i in j..N {
                lower[(i, j)] /= root;
            }
        }
        Ok(Self { lower })
    }

    /// M⁻¹ f by L y = f, Lᵀ x = y.
    pub(crate) fn solve(&self, force: &SVector<f64, N>) -> SVector<f64, N> {
        let mut x = *force;
        for i in 0..N {
            for k in 0..i {
                x[i] -= self.lower[(i, k)] * x[k];
            }
            x[i] /= self.lower[(i, i)];
        }
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] -= self.lower[(k, i)] * x[k];
            }
            x[i] /= self.lower[(i, i)];
        }
        x
    }
}
