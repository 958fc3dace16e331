//! The half step of a rotation that makes the variational midpoint keep a free body's energy.

use crate::Quaternion;
use crate::spatial::algebra::V3;

/// The rotation T(a) by ψ about a, sin ψ = |a|, for a = ½hω: from the start of a step to its middle, and
/// again from the middle to the end.
///
/// Any rotation by |a| + O(|a|³) about a gives a symplectic midpoint step that keeps angular momentum. Of a
/// free body, Π₁ − Π₀ is a multiple of a × π and Π₁ + Π₀ of Eπ, where E is the symmetric part of T; the energy
/// stays iff 𝓘⁻¹Eπ lies along ω, while the discrete action says 𝓘ω = Sπ, S the symmetric part of the derivative
/// of T. E ∝ S is tan ψ = |a| dψ/d|a|, solved by sin ψ = |a|. The result is the discrete rotor of Moser and
/// Veselov, *Discrete versions of some classical integrable systems*, Commun. Math. Phys. 139 (1991).
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfTurn {
    a: V3<f64>,
    /// cos ψ.
    cosine: f64,
}

impl HalfTurn {
    /// None where |½hω| ≥ 1: the step is too long for the turn.
    pub(super) fn new(omega: V3<f64>, h: f64) -> Option<Self> {
        let a = omega * (0.5 * h);
        let left = 1.0 - a.dot(a);
        // Also false for NaN.
        if left > 0.0 { Some(Self { a, cosine: left.sqrt() }) } else { None }
    }

    /// T as a quaternion of unit length: (a, 1 + cos ψ) up to its length.
    pub(super) fn quaternion(&self) -> Quaternion {
        let [x, y, z] = self.a.array();
        Quaternion::from_xyzw([x, y, z, 1.0 + self.cosine]).normalized()
    }

    /// Tᵀ x = x − a × x + a × (a × x)/(1+c): x in the axes of half a step later.
    ///
    /// In this form rounding touches the change of x, not x: a matrix that turns nearly alike from step to
    /// step would stretch x by the same rounding each time.
    pub(super) fn carry(&self, x: V3<f64>) -> V3<f64> {
        let once = self.a.cross(x);
        x + (self.a.cross(once) * (1.0 / (1.0 + self.cosine)) - once)
    }

    /// ∂L/∂ω at the middle from the momentum Π₀ at the start and the moment F on the middle.
    ///
    /// μ = S(TᵀΠ₀ + ½hF) − ½h a×F/(1+c), with S x = x + a (a·x)/(c(1+c)), c = cos ψ.
    pub(super) fn middle_momentum(&self, start: V3<f64>, moment: V3<f64>, h: f64) -> V3<f64> {
        let carried = self.carry(start) + moment * (0.5 * h);
        let c = self.cosine;
        carried + self.a * (self.a.dot(carried) / (c * (1.0 + c)))
            - self.a.cross(moment) * (0.5 * h / (1.0 + c))
    }

    /// Π₁ = Tᵀ(TᵀΠ₀ + h F).
    pub(super) fn end_momentum(&self, start: V3<f64>, moment: V3<f64>, h: f64) -> V3<f64> {
        self.carry(self.carry(start) + moment * h)
    }
}
