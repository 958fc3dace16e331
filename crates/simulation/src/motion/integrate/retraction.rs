//! The half-step rotation with which the variational midpoint conserves a free body's energy.

use robot_dynamics_description::Quaternion;
use robot_dynamics_number::algebra::V3;

/// The rotation T(a) by ψ about a, sin ψ = |a|, for a = ½hω. It leads from the start of a step to its middle,
/// and from the middle to the end.
///
/// Any rotation by |a| + O(|a|³) about a gives a symplectic midpoint step that conserves angular momentum.
/// Let E be the symmetric part of T. For a free body, Π₁ − Π₀ is a multiple of a × π, and Π₁ + Π₀ a multiple
/// of Eπ. The energy is conserved iff 𝓘⁻¹Eπ is parallel to ω. The discrete action gives 𝓘ω = Sπ, with S the
/// symmetric part of the derivative of T. E ∝ S requires tan ψ = |a| dψ/d|a|, which sin ψ = |a| solves. The
/// result is the discrete rotor of Moser and Veselov, *Discrete versions of some classical integrable
/// systems*, Commun. Math. Phys. 139 (1991).
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfTurn {
    a: V3<f64>,
    /// cos ψ.
    cosine: f64,
}

impl HalfTurn {
    /// `None` if |½hω| ≥ 1: the step is too long for the rotation.
    pub(super) fn new(omega: V3<f64>, h: f64) -> Option<Self> {
        let a = omega * (0.5 * h);
        let left = 1.0 - a.dot(a);
        // Also false for NaN.
        if left > 0.0 { Some(Self { a, cosine: left.sqrt() }) } else { None }
    }

    /// T as a unit quaternion, proportional to (a, 1 + cos ψ).
    pub(super) fn quaternion(&self) -> Quaternion {
        let [x, y, z] = self.a.array();
        Quaternion::from_xyzw([x, y, z, 1.0 + self.cosine]).normalized()
    }

    /// Tᵀ x = x − a × x + a × (a × x)/(1+c): x in the axes half a step later.
    ///
    /// In this form rounding affects the change of x and not x itself. A matrix that is nearly the same in
    /// every step would scale x by the same rounding error each time.
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
