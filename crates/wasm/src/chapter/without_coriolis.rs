//! The lie of the lab: a system whose velocity-product forces are left out.

use dynamics::Dynamics;
use nalgebra::{SMatrix, SVector};

/// M q̈ + g + b = u: the equation of motion with C q̇ struck out. Its energy wanders off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WithoutCoriolis<D>(pub(crate) D);

impl<D: Dynamics<N>, const N: usize> Dynamics<N> for WithoutCoriolis<D> {
    fn mass(&self, q: &SVector<f64, N>) -> SMatrix<f64, N, N> {
        self.0.mass(q)
    }

    fn velocity_product(&self, _: &SVector<f64, N>, _: &SVector<f64, N>) -> SVector<f64, N> {
        SVector::zeros()
    }

    fn gravity(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        self.0.gravity(q)
    }

    fn potential_energy(&self, q: &SVector<f64, N>) -> f64 {
        self.0.potential_energy(q)
    }
}
