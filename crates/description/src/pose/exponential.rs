//! Exponential and logarithm of rigid motions, without cancellation at any angle up to π.

use robot_dynamics_number::algebra::V3;

use crate::{Pose, Quaternion};

/// The motion at constant body twist (u, φ) for unit time: (rotation, translation).
///
/// exp(u, φ) = (exp φ̂, V u) with V = 1 + B φ̂ + C φ̂², B = (1−cos θ)/θ², C = (θ−sin θ)/θ³, θ = |φ|.
/// **(MLS eq. 2.36; MR §3.3.3)**
#[doc(hidden)]
pub fn exp_motion(linear: V3<f64>, angular: V3<f64>) -> (Quaternion, V3<f64>) {
    let (b, c, _) = coefficients(angular.dot(angular));
    let once = angular.cross(linear);
    (Quaternion::exp(angular.array()), linear + once * b + angular.cross(once) * c)
}

/// The twist (u, φ) with |φ| ≤ π whose [`exp_motion`] is (rotation, translation).
///
/// V⁻¹ = 1 − ½φ̂ + E φ̂², E = (1 − ½θ cot ½θ)/θ² = (C − 2D)/(2B), D = (½ − B)/θ². The second form of E has no
/// difference of nearly equal numbers. **(MR §3.3.3)**
#[doc(hidden)]
pub fn log_motion(rotation: Quaternion, translation: V3<f64>) -> (V3<f64>, V3<f64>) {
    let angular = V3::new(rotation.log());
    let (b, c, d) = coefficients(angular.dot(angular));
    let once = angular.cross(translation);
    let e = (c - 2.0 * d) / (2.0 * b);
    (translation - once * 0.5 + angular.cross(once) * e, angular)
}

impl Pose {
    /// The placement of a frame that moves at the constant body twist (u, φ) for unit time. **(MLS eq.
    /// 2.36)**
    ///
    /// `linear` is u \[m\] and `angular` is φ \[rad\], both along the moving frame's axes.
    ///
    /// ```
    /// use robot_dynamics::description::Pose;
    /// use std::f64::consts::PI;
    /// // Forward by π while turning left by half a turn: a half circle of radius 1.
    /// let end = Pose::exp([PI, 0.0, 0.0], [0.0, 0.0, PI]);
    /// assert!(end.translation[0].abs() < 1e-15 && (end.translation[1] - 2.0).abs() < 1e-15);
    /// ```
    pub fn exp(linear: [f64; 3], angular: [f64; 3]) -> Self {
        let (rotation, translation) = exp_motion(V3::new(linear), V3::new(angular));
        Self::from_translation_quaternion_xyzw(translation.array(), rotation.to_xyzw())
    }

    /// The twist (u, φ) with |φ| ≤ π whose [`exp`](Self::exp) is this placement: (linear \[m\], angular \[rad\]).
    /// **(MR §3.3.3)**
    ///
    /// ```
    /// use robot_dynamics::description::Pose;
    /// let (linear, angular) = ([0.3, -0.2, 0.1], [0.4, 0.5, -0.6]);
    /// let (u, phi) = Pose::exp(linear, angular).log();
    /// assert!((0..3).all(|i| (u[i] - linear[i]).abs() < 1e-15 && (phi[i] - angular[i]).abs() < 1e-15));
    /// ```
    pub fn log(&self) -> ([f64; 3], [f64; 3]) {
        let rotation = Quaternion::from_rotation(&self.rotation);
        let (linear, angular) = log_motion(rotation, V3::new(self.translation));
        (linear.array(), angular.array())
    }
}

/// B, C and D of θ².
///
/// Below 1 rad they come from their power series Σ (−θ²)ᵏ/(2k+m)!, m = 2, 3, 4, whose ninth term is below
/// 1e-17 of the first. Above, they come from the closed forms, whose cancellation loses less than a factor of
/// ten.
pub(super) fn coefficients(theta_squared: f64) -> (f64, f64, f64) {
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
pub(super) fn series(m: u32, x: f64) -> f64 {
    let mut sum = 1.0;
    for k in (1..9).rev() {
        let n = f64::from(2 * k + m);
        sum = 1.0 - sum * x / (n * (n - 1.0));
    }
    sum / f64::from((1..=m).product::<u32>())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// exp ∘ log = id for rotations of every angle up to half a turn, including angles close to it. The
    /// numbers of a rotation have an error of 1e-16, and so does its axis near half a turn.
    #[test]
    fn the_logarithm_of_a_placement_leads_back_to_it() {
        let mut random = SplitMix64::new(5);
        let mut vector = |scale: f64| [0; 3].map(|_| random.uniform(-scale, scale));
        for turn in [0.0, 1e-200, 1e-9, 1e-4, 0.1, 1.0, 2.0, 3.0, PI - 1e-3, PI - 1e-7, PI] {
            for _ in 0..200 {
                let axis = V3::new(vector(1.0));
                let angular = (axis * (turn / axis.dot(axis).sqrt())).array();
                let pose = Pose::exp(vector(2.0), angular);
                let (u, phi) = pose.log();
                let back = Pose::exp(u, phi);
                let size = V3::new(phi).dot(V3::new(phi)).sqrt();
                assert!(size <= PI + 1e-15, "{size}");
                assert!((size - turn).abs() < 1e-14, "{turn}: {size}");
                for i in 0..3 {
                    assert!((back.translation[i] - pose.translation[i]).abs() < 2e-14, "{turn}");
                    for j in 0..3 {
                        assert!((back.rotation[i][j] - pose.rotation[i][j]).abs() < 2e-15, "{turn}");
                    }
                }
            }
        }
    }
}
