//! What one freedom changes of the motion, between the derivatives' sweeps.

use dynamics::Scalar;

use crate::spatial::screw::Screw;

/// How the parent's motion carries a freedom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slope<S: Scalar> {
    /// ψ = V_p × S.
    pub once: Screw<S>,
    /// ψ′ = A_p × S + V_p × ψ.
    pub twice: Screw<S>,
    /// Ṡ + ψ.
    pub swept: Screw<S>,
}
