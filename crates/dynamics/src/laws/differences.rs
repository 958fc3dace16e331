//! Directional derivatives of any function, by eighth-order central differences.

use core::ops::{Add, Mul, Sub};

/// The distance between stencil points, in the norm of the direction.
const STEP: f64 = 0.01;

/// d/ds f(s) at s = 0, where f is a function restricted to a line with the speed `speed` = ‖direction‖.
///
/// f′ ≈ Σₖ wₖ (f(kh) − f(−kh))/h with w = 4/5, −1/5, 4/105, −1/280; the error is h⁸f⁽⁹⁾/630.
pub(super) fn derivative<T>(speed: f64, f: impl Fn(f64) -> T) -> T
where
    T: Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    let step = if speed > 0.0 { STEP / speed } else { STEP };
    let odd_part = |k: f64, weight: f64| (f(k * step) - f(-k * step)) * (weight / step);
    odd_part(1.0, 0.8) + odd_part(2.0, -0.2) + odd_part(3.0, 4.0 / 105.0) + odd_part(4.0, -1.0 / 280.0)
}

/// The error allowed to [`derivative`], relative to the terms of its differences: truncation plus rounding.
///
/// Along a unit direction the angles of a chain of N joints sum to at most √N rad, and M is quadratic in
/// their sines. It varies with a frequency ω ≤ 2√N, so that h⁸f⁽⁹⁾/630 ≤ (hω)⁸ω/630. Rounding leaves a few
/// ε/h; 100 are allowed.
pub(super) fn missed<const N: usize>() -> f64 {
    let omega = 2.0 * (N as f64).sqrt();
    (STEP * omega).powi(8) * omega / 630.0 + 100.0 * f64::EPSILON / STEP
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stencil is exact for polynomials of degree up to 8, by its error term.
    #[test]
    fn exact_up_to_degree_eight() {
        for degree in 1..=8 {
            let slope = derivative(1.0, |s| (1.0 + s).powi(degree));
            assert!((slope - f64::from(degree)).abs() < 1e-12, "degree {degree}: {slope}");
        }
    }

    #[test]
    fn sine_to_rounding() {
        let slope = derivative(2.0, |s| (0.3 + 2.0 * s).sin());
        assert!((slope - 2.0 * 0.3_f64.cos()).abs() < 1e-13);
    }
}
