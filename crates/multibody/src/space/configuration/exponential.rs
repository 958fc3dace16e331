//! Exponential and logarithm of rigid motions, without cancellation at any angle up to π.

use crate::Quaternion;
use crate::spatial::algebra::V3;

/// The motion with body twist (u, φ) held for unit time: (rotation, translation).
///
/// exp(u, φ) = (exp φ̂, V u) with V = 1 + B φ̂ + C φ̂², B = (1−cos θ)/θ², C = (θ−sin θ)/θ³, θ = |φ|.
/// **(MLS eq. 2.36; MR §3.3.3)**
pub(crate) fn exp_motion(linear: V3<f64>, angular: V3<f64>) -> (Quaternion, V3<f64>) {
    let (b, c, _) = coefficients(angular.dot(angular));
    let once = angular.cross(linear);
    (Quaternion::exp(angular.array()), linear + once * b + angular.cross(once) * c)
}

/// The twist (u, φ) with |φ| ≤ π whose [`exp_motion`] is (rotation, translation).
///
/// V⁻¹ = 1 − ½φ̂ + E φ̂², E = (1 − ½θ cot ½θ)/θ² = (C − 2D)/(2B), D = (½ − B)/θ². The second form takes no
/// difference of nearly equal numbers. **(MR §3.3.3)**
pub(crate) fn log_motion(rotation: Quaternion, translation: V3<f64>) -> (V3<f64>, V3<f64>) {
    let angular = V3::new(rotation.log());
    let (b, c, d) = coefficients(angular.dot(angular));
    let once = angular.cross(translation);
    let e = (c - 2.0 * d) / (2.0 * b);
    (translation - once * 0.5 + angular.cross(once) * e, angular)
}

/// B, C and D of θ².
///
/// Below 1 rad by their power series Σ (−θ²)ᵏ/(2k+m)!, m = 2, 3, 4, whose ninth term is below 1e-17 of the
/// first; above, as written, where they lose less than a factor of ten to cancellation.
fn coefficients(theta_squared: f64) -> (f64, f64, f64) {
    if theta_squared < 1.0 {
        (series(2, theta_squared), series(3, theta_squared), series(4, theta_squared))
    } else {
        let theta = theta_squared.sqrt();
        let half_sine = (0.5 * theta).sin();
        let b = 2.0 * half_sine * half_sine / theta_squared;
        (b, (theta - theta.sin()) / (theta * theta_squared), (0.5 - b) / theta_squared)
    }
}

/// Σ (−x)ᵏ/(2k+m)! for k < 9, by Horner's rule.
fn series(m: u32, x: f64) -> f64 {
    let mut sum = 1.0;
    for k in (1..9).rev() {
        let n = f64::from(2 * k + m);
        sum = 1.0 - sum * x / (n * (n - 1.0));
    }
    sum / f64::from((1..=m).product::<u32>())
}
