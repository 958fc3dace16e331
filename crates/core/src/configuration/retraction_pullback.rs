//! Pullbacks of q ⊕ Θ and of Θ̇.
//!
//! Displacements Θ = (ρ, φ), linear part first; a rotation has no ρ. With cᵢ = Σₖ (−|φ|²)ᵏ/(2k + i)!,
//!
//! R = 1 + c₁\[φ\]× + c₂\[φ\]×², x = ρ + c₂ φ × ρ + c₃ φ × (φ × ρ)
//!
//! are the rotation and the translation of the exponential. Variations δq₀ = (u₀, w₀) and δΘ of q₁ = q₀ ⊕ Θ
//! change q₁ by
//!
//! w₁ = Rᵀw₀ + J δφ, u₁ = Rᵀ(u₀ + w₀ × x + δx), with J = 1 − c₂\[φ\]× + c₃\[φ\]×².
//!
//! With f′ = R f, a cotangent (f, n) of q₁ gives these cotangents:
//!
//! - for q₀: (f′, R n + x × f′)
//! - for ρ: f′ − c₂ φ × f′ + c₃ φ × (φ × f′)
//! - for φ: n + c₂ φ × n + c₃ φ × (φ × n) + c₂ ρ × f′ + c₃ ((φ × ρ) × f′ + ρ × (f′ × φ)) + k φ
//!
//! Here k = f′·((2c₄ − c₃) φ × ρ + (3c₅ − c₄) φ × (φ × ρ)), because ∂c₂/∂φ = (2c₄ − c₃) φ and
//! ∂c₃/∂φ = (3c₅ − c₄) φ. No formula divides by |φ| or branches on it.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::Model;
use crate::configuration::displacement_rate::{bracket, store};
use crate::configuration::manifold::{CoordinateRange, coordinate_ranges, vector_at};
use crate::joint::Chart;

/// From a cotangent of q₁ = q₀ ⊕ Θ to those of q₀ and Θ, for rotations up to 12 rad. No integration step
/// takes a larger one.
#[inline(always)]
pub fn pull_move<S: Scalar>(
    model: &Model,
    theta: &[S],
    moved: &[S],
    start: &mut [S],
    displacement: &mut [S],
) {
    // A mimic joint writes its leader's numbers again, with the same values.
    for CoordinateRange { chart, v: k, .. } in coordinate_ranges(model) {
        match chart {
            Chart::Line => (start[k], displacement[k]) = (moved[k], moved[k]),
            Chart::Rotation => {
                let (phi, n) = (vector_at(theta, k), vector_at(moved, k));
                let c = Coefficients::of(phi);
                let once = phi.cross(n);
                let twice = phi.cross(once);
                store(n.add_scaled(c.c1, once).add_scaled(c.c2, twice), &mut start[k..]);
                store(n.add_scaled(c.c2, once).add_scaled(c.c3, twice), &mut displacement[k..]);
            }
            Chart::Placement => {
                let (rho, phi) = (vector_at(theta, k), vector_at(theta, k + 3));
                let (f, n) = (vector_at(moved, k), vector_at(moved, k + 3));
                let c = Coefficients::of(phi);
                let across = phi.cross(f);
                let f = f.add_scaled(c.c1, across).add_scaled(c.c2, phi.cross(across));
                let spin = phi.cross(n);
                let twirl = phi.cross(spin);
                let turned = n.add_scaled(c.c1, spin).add_scaled(c.c2, twirl);
                let once = phi.cross(rho);
                let twice = phi.cross(once);
                let shift = rho.add_scaled(c.c2, once).add_scaled(c.c3, twice);
                store(f, &mut start[k..]);
                store(turned + shift.cross(f), &mut start[k + 3..]);
                let across = phi.cross(f);
                let linear = f.sub_scaled(c.c2, across).add_scaled(c.c3, phi.cross(across));
                let along = (once * c.c2_derivative).add_scaled(c.c3_derivative, twice).dot(f);
                let angular = n
                    .add_scaled(c.c2, spin + rho.cross(f))
                    .add_scaled(c.c3, twirl + once.cross(f) - rho.cross(across))
                    .add_scaled(along, phi);
                store(linear, &mut displacement[k..]);
                store(angular, &mut displacement[k + 3..]);
            }
        }
    }
}

/// From a cotangent r of Θ̇ = v + ½\[Θ,v\] + ¹⁄₁₂\[Θ,\[Θ,v\]\] to those of Θ and v: with z = \[Θ,v\],
///
/// for v: r + ½ adᵀ_Θ r + ¹⁄₁₂ adᵀ_Θ adᵀ_Θ r, for Θ: −½ adᵀ_v r − ¹⁄₁₂ (adᵀ_z r + adᵀ_v adᵀ_Θ r).
#[inline(always)]
pub fn pull_rate<S: Scalar>(
    model: &Model,
    (theta, v): (&[S], &[S]),
    rate: &[S],
    displacement: &mut [S],
    velocity: &mut [S],
) {
    for CoordinateRange { chart, v: k, .. } in coordinate_ranges(model) {
        if chart == Chart::Line {
            (displacement[k], velocity[k]) = (S::zero(), rate[k]);
            continue;
        }
        let (t, w, r) = (read(chart, theta, k), read(chart, v, k), read(chart, rate, k));
        let once = coadjoint(t, r);
        let twice = coadjoint(t, once);
        let (by_w, by_z) = (coadjoint(w, r), coadjoint(bracket(t, w), r));
        let by_both = coadjoint(w, once);
        let (half, twelfth) = (S::from_f64(0.5), S::from_f64(1.0 / 12.0));
        let linear = r.0.add_scaled(half, once.0).add_scaled(twelfth, twice.0);
        let angular = r.1.add_scaled(half, once.1).add_scaled(twelfth, twice.1);
        write(chart, velocity, k, (linear, angular));
        let linear = (by_w.0 * half).add_scaled(twelfth, by_z.0 + by_both.0);
        let angular = (by_w.1 * half).add_scaled(twelfth, by_z.1 + by_both.1);
        write(chart, displacement, k, (-linear, -angular));
    }
}

/// Subtracts ½ adᵀ_α g from the result: the part of a gradient's rate along α that depends on the order of
/// displacements. It is zero for joints without a quaternion.
pub fn subtract_half_bracket(model: &Model, direction: &[f64], gradient: &[f64], result: &mut [f64]) {
    for CoordinateRange { chart, v: k, .. } in coordinate_ranges(model) {
        if chart == Chart::Line {
            continue;
        }
        let (linear, angular) = coadjoint(read(chart, direction, k), read(chart, gradient, k));
        let before = read(chart, result, k);
        write(chart, result, k, (before.0.sub_scaled(0.5, linear), before.1.sub_scaled(0.5, angular)));
    }
}

/// A joint's part of a vector, linear and angular; a rotation has no linear part.
#[inline(always)]
fn read<S: Scalar>(chart: Chart, x: &[S], k: usize) -> (V3<S>, V3<S>) {
    if chart == Chart::Placement {
        (vector_at(x, k), vector_at(x, k + 3))
    } else {
        (V3::zero(), vector_at(x, k))
    }
}

/// The inverse of [`read`].
#[inline(always)]
fn write<S: Scalar>(chart: Chart, to: &mut [S], k: usize, (linear, angular): (V3<S>, V3<S>)) {
    if chart == Chart::Placement {
        store(linear, &mut to[k..]);
        store(angular, &mut to[k + 3..]);
    } else {
        store(angular, &mut to[k..]);
    }
}

/// adᵀ_t r = (f × ω, f × u + n × ω) for t = (u, ω), r = (f, n): r·\[t,w\] = w·adᵀ_t r.
#[inline(always)]
fn coadjoint<S: Scalar>(t: (V3<S>, V3<S>), r: (V3<S>, V3<S>)) -> (V3<S>, V3<S>) {
    (r.0.cross(t.1), r.0.cross(t.0) + r.1.cross(t.1))
}

/// c₁ to c₃, and the factors 2c₄ − c₃ and 3c₅ − c₄ of the derivatives of c₂ and c₃.
struct Coefficients<S> {
    c1: S,
    c2: S,
    c3: S,
    c2_derivative: S,
    c3_derivative: S,
}

impl<S: Scalar> Coefficients<S> {
    /// c₄ and c₅ of ⅛φ come from their series, whose tenth terms are below 1e-17 for |φ| < 12. Then
    /// cᵢ = 1/i! − |φ|² cᵢ₊₂, and φ is doubled three times by
    ///
    /// c₅(2φ) = (c₅ + c₄ + c₂c₃)/16, c₄(2φ) = c₃(1 + c₁)/8.
    #[inline(always)]
    fn of(phi: V3<S>) -> Self {
        let one = S::one();
        let mut y = phi.dot(phi).scale(1.0 / 64.0);
        let (mut c4, mut c5) = (one, one);
        for k in (1..10u32).rev() {
            let n = f64::from(2 * k + 3);
            c4 = one - (y * c4).scale(1.0 / (n * (n + 1.0)));
            c5 = one - (y * c5).scale(1.0 / ((n + 1.0) * (n + 2.0)));
        }
        (c4, c5) = (c4.scale(1.0 / 24.0), c5.scale(1.0 / 120.0));
        for _ in 0..3 {
            let (c1, c2, c3) = lower(y, c4, c5);
            (c4, c5) = ((c3 * (one + c1)).scale(1.0 / 8.0), (c5 + c4 + c2 * c3).scale(1.0 / 16.0));
            y = y.scale(4.0);
        }
        let (c1, c2, c3) = lower(y, c4, c5);
        Self { c1, c2, c3, c2_derivative: c4.scale(2.0) - c3, c3_derivative: c5.scale(3.0) - c4 }
    }
}

/// c₁ = 1 − y c₃, c₂ = ½ − y c₄, c₃ = ⅙ − y c₅ with y = |φ|².
#[inline(always)]
fn lower<S: Scalar>(y: S, c4: S, c5: S) -> (S, S, S) {
    let (c2, c3) = (S::from_f64(0.5) - y * c4, S::from_f64(1.0 / 6.0) - y * c5);
    (S::one() - y * c3, c2, c3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed forms with sines where they cancel least, and the limits at 0. The tolerance is a few
    /// rounding errors of numbers below 1.
    #[test]
    fn coefficients_are_their_closed_forms() {
        for theta in [1.0_f64, 2.0, 3.1, 5.0, 8.0, 12.0] {
            let c = Coefficients::of(V3::new([0.6 * theta, 0.0, -0.8 * theta]));
            let (sine, cosine, square) = (theta.sin(), theta.cos(), theta * theta);
            let (c2, c3) = ((1.0 - cosine) / square, (theta - sine) / (square * theta));
            let (c4, c5) = ((0.5 - c2) / square, (1.0 / 6.0 - c3) / square);
            let expected = [sine / theta, c2, c3, 2.0 * c4 - c3, 3.0 * c5 - c4];
            for (found, expected) in
                [c.c1, c.c2, c.c3, c.c2_derivative, c.c3_derivative].into_iter().zip(expected)
            {
                assert!((found - expected).abs() < 1e-14, "{found} {expected} at {theta}");
            }
        }
        let c = Coefficients::of(V3::<f64>::zero());
        assert_eq!([c.c1, c.c2], [1.0, 0.5]);
        assert!((c.c3 - 1.0 / 6.0).abs() < 1e-16 && (c.c2_derivative + 1.0 / 12.0).abs() < 1e-16);
        assert!((c.c3_derivative + 1.0 / 60.0).abs() < 1e-16);
    }
}
