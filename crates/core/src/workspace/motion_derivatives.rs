//! Intermediate results of the derivatives' sweeps, for one DoF.

use robot_dynamics_number::Scalar;

use crate::spatial::motion::MotionVector;

/// Derivatives of the motion by one DoF.
#[derive(Clone, Copy, Debug)]
pub struct MotionDerivatives<S: Scalar> {
    /// ψ = V_p × S.
    pub psi: MotionVector<S>,
    /// ψ′ = A_p × S + V_p × ψ.
    pub psi_prime: MotionVector<S>,
    /// Ṡ + ψ.
    pub velocity_term: MotionVector<S>,
}
