//! The velocity and the acceleration of a rotation exp(φ) from its rotation vector φ.
//!
//! The body velocity is ω = J φ̇, with the right Jacobian J(φ) = 1 − A \[φ\] + B \[φ\]², A = (1 − cos θ)/θ²,
//! B = (θ − sin θ)/θ³, θ = |φ|. J(−φ) φ̇ is the same velocity along the axes before the rotation.

use nalgebra::{Matrix3, Vector3};

/// The number of terms of the power series, of which the last is below 1e-17 at θ = π.
const TERMS: u32 = 14;

/// A and B, and their derivatives by θ, divided by θ.
struct Coefficients {
    a: f64,
    b: f64,
    a_rate: f64,
    b_rate: f64,
}

impl Coefficients {
    /// Up to π they come from power series of θ², without cancellation; above, from the closed forms.
    fn at(phi: &Vector3<f64>) -> Self {
        let square = phi.norm_squared();
        if square > core::f64::consts::PI.powi(2) {
            let angle = square.sqrt();
            let (sin, cos) = angle.sin_cos();
            let (a, b) = ((1.0 - cos) / square, (angle - sin) / (square * angle));
            return Self { a, b, a_rate: (sin / angle - 2.0 * a) / square, b_rate: (a - 3.0 * b) / square };
        }
        let (mut a, mut b, mut a_rate, mut b_rate) = (0.0, 0.0, 0.0, 0.0);
        // ±θ²ᵏ/(2k+2)!, and that power without one factor θ².
        let (mut term, mut before) = (0.5, 0.0);
        for k in 0..TERMS {
            let k = f64::from(k);
            a += term;
            b += term / (2.0 * k + 3.0);
            a_rate += 2.0 * k * before;
            b_rate += 2.0 * k * before / (2.0 * k + 3.0);
            before = -term / ((2.0 * k + 3.0) * (2.0 * k + 4.0));
            term = before * square;
        }
        Self { a, b, a_rate, b_rate }
    }
}

/// J(φ).
pub(crate) fn jacobian(phi: &Vector3<f64>) -> Matrix3<f64> {
    let Coefficients { a, b, .. } = Coefficients::at(phi);
    let cross = phi.cross_matrix();
    Matrix3::identity() - cross * a + cross * cross * b
}

/// J̇ φ̇: the part of ω̇ that is quadratic in φ̇.
pub(crate) fn quadratic(phi: &Vector3<f64>, rate: &Vector3<f64>) -> Vector3<f64> {
    let Coefficients { b, a_rate, b_rate, .. } = Coefficients::at(phi);
    let along = phi.dot(rate);
    let once = phi.cross(rate);
    phi.cross(&once) * (b_rate * along) - once * (a_rate * along) + rate.cross(&once) * b
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use nalgebra::Rotation3;

    use super::*;

    /// J φ̇ is the body velocity of exp(φ), and J(−φ) φ̇ that along the axes before it. J̇ φ̇ is the rate of J φ̇
    /// at constant φ̇. The angles lie on both sides of the change to the closed forms.
    #[test]
    fn jacobian_of_a_rotation_agrees_with_differences() {
        let direction = Vector3::new(0.48, -0.6, 0.64);
        let rate = Vector3::new(0.3, 0.7, -0.4);
        for angle in [0.0, 1e-3, 0.0999, 0.1001, 1.0, 3.0, PI - 1e-4, PI + 1e-4, 7.0, 20.0] {
            let phi = direction * angle;
            let h = 1e-6;
            let at = |t: f64| Rotation3::new(phi + rate * t);
            let spin = |turn: Rotation3<f64>| {
                let skew = (turn.matrix() - turn.matrix().transpose()) / (4.0 * h);
                Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)])
            };
            let in_body = spin(at(-h).inverse() * at(h));
            let before = spin(at(h) * at(-h).inverse());
            assert!((jacobian(&phi) * rate - in_body).norm() < 1e-9, "{angle}");
            assert!((jacobian(&-phi) * rate - before).norm() < 1e-9, "{angle}");
            let difference = (jacobian(&(phi + rate * h)) - jacobian(&(phi - rate * h))) * rate / (2.0 * h);
            assert!((quadratic(&phi, &rate) - difference).norm() < 1e-9, "{angle}: {difference}");
        }
    }
}
