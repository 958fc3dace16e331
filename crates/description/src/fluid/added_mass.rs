//! The added mass of an ellipsoid in potential flow.

use core::f64::consts::PI;

/// Nodes of the 15-point Gauss–Kronrod rule on 0 … 1 below ½, and their weights **(QUADPACK, qk15)**. Both
/// are rounded to eight digits after the point, so that the added masses agree with MuJoCo's.
const KRONROD: [(f64, f64); 7] = [
    (0.004_272_31, 0.011_467_66),
    (0.025_446_04, 0.031_546_05),
    (0.067_567_79, 0.052_395_01),
    (0.129_234_41, 0.070_326_63),
    (0.206_956_38, 0.084_502_36),
    (0.297_077_42, 0.095_175_29),
    (0.396_107_52, 0.102_216_47),
];

/// The weight of the middle.
const MIDDLE: f64 = 0.104_741_07;

/// The least denominator, as in MuJoCo.
const LEAST: f64 = 1e-14;

/// The added mass along each axis \[m³\] and the added moment about each axis \[m⁵\], divided by the density.
///
/// With κ_i = ∫₀^∞ r_x r_y r_z / √((r_i² + λ)³ (r_j² + λ)(r_k² + λ)) dλ and the volume V **(Tuckerman 1925)**
///
/// m_i = V κ_i / (2 − κ_i),
/// J_i = V/5 (r_j² − r_k²)² (κ_k − κ_j) / (2(r_j² − r_k²) + (r_j² + r_k²)(κ_j − κ_k)).
pub(super) fn of_ellipsoid(r: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let volume = 4.0 / 3.0 * PI * r[0] * r[1] * r[2];
    let kappa: [f64; 3] = core::array::from_fn(|i| kappa(r[i], r[(i + 1) % 3], r[(i + 2) % 3]));
    let mass = kappa.map(|kappa| volume * kappa / (2.0 - kappa).max(LEAST));
    let moment = core::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (difference, sum) = (r[j] * r[j] - r[k] * r[k], r[j] * r[j] + r[k] * r[k]);
        // Numerator and denominator have the same sign.
        let denominator = (2.0 * difference + sum * (kappa[j] - kappa[k])).abs().max(LEAST);
        volume / 5.0 * (difference * difference * (kappa[k] - kappa[j]).abs() / denominator)
    });
    (mass, moment)
}

/// κ of the axis with the half length a, by λ = s x³/(1 − x)² with the scale s = (a³bc)^⅖.
fn kappa(a: f64, b: f64, c: f64) -> f64 {
    let scale = (a * a * a * b * c).powf(0.4);
    // `x` and its distance `rest` from 1.
    let term = |x: f64, rest: f64, weight: f64| {
        let lambda = scale * (x * x * x / (rest * rest));
        let derivative = scale * (x * x * (3.0 - x) / (rest * rest * rest));
        let [a, b, c] = [a, b, c].map(|r| 1.0 + lambda / (r * r));
        weight * derivative / (a * (a * b * c).sqrt())
    };
    let sides: f64 = KRONROD
        .iter()
        .map(|&(node, weight)| term(node, 1.0 - node, weight) + term(1.0 - node, node, weight))
        .sum();
    (sides + term(0.5, 0.5, MIDDLE)) / (a * a)
}

#[cfg(test)]
mod tests {
    use super::{kappa, of_ellipsoid};

    /// κ sums to 2 over the axes, by the integral of a total derivative. The rule has an error of about 1e-6.
    #[test]
    fn the_integrals_sum_to_two() {
        for [a, b, c] in [[1.0, 1.0, 1.0], [0.3, 0.2, 0.5], [0.05, 0.1, 0.2]] {
            let sum = kappa(a, b, c) + kappa(b, c, a) + kappa(c, a, b);
            assert!((sum - 2.0).abs() < 1e-5, "{sum}");
        }
    }

    /// A ball moves half of the fluid that it displaces, and no fluid if it only rotates.
    #[test]
    fn a_ball_has_half_of_the_displaced_mass() {
        let (mass, moment) = of_ellipsoid([2.0; 3]);
        let volume = 4.0 / 3.0 * core::f64::consts::PI * 8.0;
        assert!((mass[1] / volume - 0.5).abs() < 1e-6 && moment == [0.0; 3]);
    }
}
