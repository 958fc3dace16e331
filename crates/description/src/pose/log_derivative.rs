//! The derivative of the logarithm of a placement.

use nalgebra::{Matrix3, Vector3};

use super::exponential::{coefficients, series};
use crate::Pose;

impl Pose {
    /// The 6×6 matrix D, by rows, with log(T exp η) = log T + D η + O(η²), where T is this placement.
    ///
    /// η and log T are six numbers, linear before angular; η is a displacement along the moving frame's axes.
    /// With J of `frame_jacobian` along the frame's axes, J δ is the displacement of the frame. D J δ is the
    /// change of log(`target_from_frame`). D is the inverse of the right Jacobian of SE(3),
    ///
    /// > D = \[N, X; 0, N\], N = 1 + ½φ̂ + E φ̂², X = (½p̂ − E((φ×p)^ + φ̂ p̂) + 2E′ (φ×(φ×p)) φᵀ) N
    ///
    /// with (u, φ) = log T, p its translation, E = (1 − ½θ cot ½θ)/θ², E′ its derivative by θ², and θ = |φ|.
    /// A displacement along the parent's axes, exp(η) T, has the D of the [`inverse`](Self::inverse). At
    /// θ = π, where the logarithm is discontinuous, D belongs to the branch of [`log`](Self::log). **(MLS
    /// §2.4; Bullo, Murray, *Proportional derivative control on the Euclidean group*, ECC 1995)**
    ///
    /// ```
    /// use robot_dynamics::description::Pose;
    /// let pose = Pose::exp([0.3, -0.2, 0.1], [0.4, 0.5, -0.6]);
    /// let ahead = pose.compose(&Pose::exp([1e-7, 0.0, 0.0], [0.0; 3])); // 1e-7 m along its own x axis
    /// let (before, after, d) = (pose.log().0, ahead.log().0, pose.log_derivative());
    /// assert!((0..3).all(|i| ((after[i] - before[i]) / 1e-7 - d[i][0]).abs() < 1e-6));
    /// ```
    #[doc(alias = "Jlog6")]
    #[doc(alias = "right Jacobian")]
    pub fn log_derivative(&self) -> [[f64; 6]; 6] {
        let (_, angular) = self.log();
        let (phi, p) = (Vector3::from(angular), Vector3::from(self.translation));
        let (e, slope) = cotangent(phi.norm_squared());
        let turn = phi.cross_matrix();
        let same = Matrix3::identity() + turn * 0.5 + turn * turn * e;
        let (once, point) = (phi.cross(&p), p.cross_matrix());
        let twice = phi.cross(&once) * (2.0 * slope);
        let by_turn = point * 0.5 - (once.cross_matrix() + turn * point) * e + twice * phi.transpose();
        let mixed = by_turn * same;
        core::array::from_fn(|i| {
            core::array::from_fn(|j| match (i < 3, j < 3) {
                (true, false) => mixed[(i, j - 3)],
                (false, true) => 0.0,
                _ => same[(i % 3, j % 3)],
            })
        })
    }
}

/// E = (1 − ½θ cot ½θ)/θ² and dE/d(θ²), as functions of θ².
///
/// Above 1 rad E′ = (½(s − c) − (1 − c))/θ⁴ with c = ½θ cot ½θ and s = (½θ / sin ½θ)². Its cancellation loses
/// at most a factor of sixty. Below, the series have no cancellation. With Sₘ = Σ (−θ²)ᵏ/(2k+m)!,
/// E = (S₃ − 2S₄)/(2S₂), and S₂′ = S₄ − ½S₃, S₃′ = ½(3S₅ − S₄), S₄′ = 2S₆ − ½S₅.
fn cotangent(theta_squared: f64) -> (f64, f64) {
    let x = theta_squared;
    if x < 1.0 {
        let (s2, s3, s4) = coefficients(x);
        let (s5, s6) = (series(5, x), series(6, x));
        let e = (s3 - 2.0 * s4) / (2.0 * s2);
        let numerator = 0.5 * (3.0 * s5 - s4) - 2.0 * (2.0 * s6 - 0.5 * s5);
        (e, (numerator - 2.0 * e * (s4 - 0.5 * s3)) / (2.0 * s2))
    } else {
        let half = 0.5 * x.sqrt();
        let (c, s) = (half / half.tan(), (half / half.sin()).powi(2));
        ((1.0 - c) / x, (0.5 * (s - c) - (1.0 - c)) / (x * x))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// log(T exp η), six numbers.
    fn moved(pose: &Pose, eta: [f64; 6]) -> [f64; 6] {
        let [x, y, z, a, b, c] = eta;
        let (u, phi) = pose.compose(&Pose::exp([x, y, z], [a, b, c])).log();
        [u[0], u[1], u[2], phi[0], phi[1], phi[2]]
    }

    /// Compares with differences of fourth order with step 1e-3. Truncation is 1e-12 times a fifth
    /// derivative, which grows like 1/(2π − θ)⁵ and is below 1e2 here. Rounding is 1e-15/1e-3.
    #[test]
    fn the_derivative_of_the_logarithm_is_that_of_differences() {
        let mut random = SplitMix64::new(6);
        let mut vector = |size: f64| [0; 3].map(|_| random.uniform(-size, size));
        for turn in [0.0, 1e-200, 1e-9, 1e-4, 0.3, 0.999, 1.001, 2.0, 3.0, PI - 0.01] {
            for _ in 0..50 {
                let axis = Vector3::from(vector(1.0));
                let pose = Pose::exp(vector(2.0), (axis * (turn / axis.norm())).into());
                let derivative = pose.log_derivative();
                for k in 0..6 {
                    let at = |step: f64| {
                        let mut eta = [0.0; 6];
                        eta[k] = step;
                        moved(&pose, eta)
                    };
                    let (near, back) = (at(1e-3), at(-1e-3));
                    let (far, far_back) = (at(2e-3), at(-2e-3));
                    for i in 0..6 {
                        let expected = (8.0 * (near[i] - back[i]) - (far[i] - far_back[i])) / 12e-3;
                        let found = derivative[i][k];
                        assert!(
                            (found - expected).abs() < 1e-10,
                            "turn {turn}, [{i}, {k}]: {found} {expected}"
                        );
                    }
                }
            }
        }
    }

    /// The two forms of E and E′ agree at 1 rad, up to the factor of sixty that the second loses.
    #[test]
    fn both_forms_of_the_cotangent_agree_at_their_seam() {
        let (below, above) = (cotangent(1.0_f64.next_down()), cotangent(1.0));
        assert!(
            (below.0 - above.0).abs() < 1e-15 && (below.1 - above.1).abs() < 1e-15,
            "{below:?} {above:?}"
        );
        // 1/12 + θ²/720 + …
        let start = cotangent(0.0);
        assert!((start.0 - 1.0 / 12.0).abs() < 1e-17 && (start.1 - 1.0 / 720.0).abs() < 1e-17, "{start:?}");
    }

    /// log(exp(η) T) = −log(T⁻¹ exp(−η)).
    #[test]
    fn a_displacement_along_the_parents_axes_has_the_inverses_derivative() {
        let pose = Pose::exp([0.3, -1.2, 0.1], [0.4, 1.5, -0.6]);
        let derivative = pose.inverse().log_derivative();
        let (u, _) = pose.log();
        for k in 0..6 {
            let mut eta = [0.0; 6];
            eta[k] = 1e-6;
            let ahead = Pose::exp([eta[0], eta[1], eta[2]], [eta[3], eta[4], eta[5]]).compose(&pose).log().0;
            for i in 0..3 {
                // A one-sided difference, with an error of the size of its step.
                let found = derivative[i][k];
                let expected = (ahead[i] - u[i]) / 1e-6;
                assert!((found - expected).abs() < 1e-5, "[{i}, {k}]: {found} {expected}");
            }
        }
    }
}
