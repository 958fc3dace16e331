//! The rigid body nearest to an inertia that no rigid body has.

use nalgebra::Matrix3;

/// The inertia 𝓘′ of a mass distribution whose second moment is nearest to that of 𝓘.
///
/// 𝓘 = ∫ρ(|r|²1 − r rᵀ) dV **(PRM 10.42)** has the second moment Σ = ∫ρ r rᵀ dV = ½ tr(𝓘) 1 − 𝓘. The moments
/// and their triangle inequality are right exactly when Σ has no negative eigenvalue. Raising those to zero
/// gives the nearest such Σ′ in the Frobenius norm, and 𝓘′ = tr(Σ′) 1 − Σ′.
pub(crate) fn nearest_inertia(inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let second_moment = Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
    let mut eigen = second_moment.symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(0.0));
    let raised = eigen.recompose();
    Matrix3::identity() * raised.trace() - raised
}
