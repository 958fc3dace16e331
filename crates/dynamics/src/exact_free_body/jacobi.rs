//! Jacobi's elliptic functions by the arithmetic-geometric mean.
//!
//! Source: Abramowitz, Stegun, *Handbook of Mathematical Functions* (1964), §16.4 and §17.6. The parameter
//! is m = k².

use core::f64::consts::FRAC_PI_2;

/// Sufficient for any complement above 1e-300: the mean converges quadratically.
const LEVELS: usize = 16;

/// m, stored as its complement 1 − m: near m = 1 the functions depend on that difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parameter {
    pub(super) complement: f64,
}

impl Parameter {
    fn new(m: f64) -> Self {
        assert!((0.0..=1.0).contains(&m), "the parameter m must lie in [0, 1], got {m}");
        Self { complement: 1.0 - m }
    }

    /// The means (aₙ, bₙ) from a₀ = 1, b₀ = √(1−m) until cₙ₊₁ = (aₙ − bₙ)/2 is round-off.
    fn means(self) -> Vec<(f64, f64)> {
        let (mut a, mut b) = (1.0_f64, self.complement.sqrt());
        let mut levels = vec![(a, b)];
        while a - b > f64::EPSILON * a && levels.len() < LEVELS {
            (a, b) = (f64::midpoint(a, b), (a * b).sqrt());
            levels.push((a, b));
        }
        levels
    }

    /// 2ᴺa_N: the factor between the last angle of the sequence and the argument.
    fn stretch(levels: &[(f64, f64)]) -> f64 {
        let mut stretch = levels[levels.len() - 1].0;
        for _ in 1..levels.len() {
            stretch *= 2.0;
        }
        stretch
    }

    /// K(m).
    pub(super) fn complete(self) -> f64 {
        if self.complement == 0.0 {
            return f64::INFINITY;
        }
        let levels = self.means();
        FRAC_PI_2 / levels[levels.len() - 1].0
    }

    /// F(φ|m).
    pub(super) fn incomplete(self, phi: f64) -> f64 {
        if self.complement == 0.0 {
            return phi.sin().atanh();
        }
        let levels = self.means();
        let mut angle = phi;
        for &(a, b) in &levels[..levels.len() - 1] {
            // tan(φₙ₊₁ − φₙ) = (bₙ/aₙ) tan φₙ; as a small correction to 2φₙ it has no branches.
            let (sine, cosine) = angle.sin_cos();
            angle = 2.0 * angle - ((a - b) * sine * cosine).atan2(a * cosine * cosine + b * sine * sine);
        }
        angle / Self::stretch(&levels)
    }

    /// (sn, cn, dn)(u|m).
    pub(super) fn sn_cn_dn(self, u: f64) -> (f64, f64, f64) {
        if self.complement == 0.0 {
            return (u.tanh(), 1.0 / u.cosh(), 1.0 / u.cosh());
        }
        let levels = self.means();
        let mut phi = Self::stretch(&levels) * u;
        for pair in levels.windows(2).rev() {
            let ((previous_a, previous_b), (a, b)) = (pair[0], pair[1]);
            // sin(2φₙ₋₁ − φₙ) = (cₙ/aₙ) sin φₙ. The angle comes from both sides of the triangle
            // (aₙ² − cₙ² = bₙ²): near cₙ/aₙ = 1 the arc sine alone loses half the digits.
            let (sine, cosine) = phi.sin_cos();
            let across = (previous_a - previous_b) / 2.0 * sine;
            phi = f64::midpoint(phi, across.atan2((a * cosine).hypot(b * sine)));
        }
        let (sn, cn) = phi.sin_cos();
        // dn² = 1 − m sn², in a form without cancellation near m = 1.
        (sn, cn, (cn * cn + self.complement * sn * sn).sqrt())
    }
}

/// K(m) = π/(2 agm(1, √(1−m))): the complete elliptic integral of the first kind; ∞ at m = 1. **(A&S 17.6)**
///
/// ```
/// use std::f64::consts::{FRAC_PI_2, PI};
/// assert!((dynamics::complete_elliptic_k(0.0) - FRAC_PI_2).abs() < 1e-15);
/// // A pendulum let go at 90° takes 18 % longer than one that swings a little: T/T₀ = 2 K(½)/π.
/// let longer = 2.0 * dynamics::complete_elliptic_k((PI / 4.0).sin().powi(2)) / PI;
/// assert!((longer - 1.180_340_599_016_096).abs() < 1e-15);
/// ```
///
/// # Panics
/// If m is not in \[0, 1\].
pub fn complete_elliptic_k(m: f64) -> f64 {
    Parameter::new(m).complete()
}

/// F(φ|m) = ∫₀^φ dθ/√(1 − m sin²θ): the incomplete elliptic integral of the first kind. **(A&S 17.6)**
///
/// At m = 1 only for |φ| ≤ π/2.
///
/// ```
/// use dynamics::{complete_elliptic_k, incomplete_elliptic_f, jacobi_sn_cn_dn};
/// // A quarter turn is the complete integral; sn is the sine of the inverse of F.
/// let quarter = incomplete_elliptic_f(std::f64::consts::FRAC_PI_2, 0.3);
/// assert!((quarter - complete_elliptic_k(0.3)).abs() < 1e-15);
/// let (sn, _, _) = jacobi_sn_cn_dn(incomplete_elliptic_f(0.6, 0.3), 0.3);
/// assert!((sn - 0.6_f64.sin()).abs() < 1e-15);
/// ```
///
/// # Panics
/// If m is not in \[0, 1\].
pub fn incomplete_elliptic_f(phi: f64, m: f64) -> f64 {
    Parameter::new(m).incomplete(phi)
}

/// (sn, cn, dn)(u|m). **(A&S 16.4)**
///
/// # Panics
/// If m is not in \[0, 1\].
///
/// ```
/// let (sn, cn, dn) = dynamics::jacobi_sn_cn_dn(0.7, 0.3);
/// assert!((sn * sn + cn * cn - 1.0).abs() < 1e-15);
/// assert!((dn * dn + 0.3 * sn * sn - 1.0).abs() < 1e-15);
/// ```
pub fn jacobi_sn_cn_dn(u: f64, m: f64) -> (f64, f64, f64) {
    Parameter::new(m).sn_cn_dn(u)
}
