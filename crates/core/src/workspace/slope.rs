//! Intermediate results of the derivatives' sweeps, for one DoF.

use robot_dynamics_number::Scalar;

use crate::spatial::motion::MotionVector;

/// Derivatives of the motion by one DoF.
#[derive(Clone, Copy, Debug)]
pub struct Slope<S: Scalar> {
    /// ψ = V_p × S.
    pub once: MotionVector<S>,
    /// ψ′ = A_p × S + V_p × ψ.
    pub twice: MotionVector<S>,
    /// Ṡ + ψ.
    pub swept: MotionVector<S>,
}
