//! A spline through rotations, with a continuous angular acceleration.
//!
//! Between knots R(t) = Rᵢ exp(φ(t)) with a cubic φ from φ(0) = 0 to φ(h) = rᵢ = log(Rᵢᵀ Rᵢ₊₁). The body
//! velocity is ω = J φ′, with the right Jacobian J of `rotation_vector`. The velocities at the knots follow
//! from equal accelerations on both sides of each knot, and zero acceleration at the ends.
//!
//! Source of the cubic in the tangent space: Kang, Park, *Cubic spline algorithms for orientation
//! interpolation*, International Journal for Numerical Methods in Engineering 46 (1999).

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::Quaternion;
use robot_dynamics_number::InvalidInput;

use crate::rotation_vector::{jacobian, quadratic};

/// The limit of iterations for the velocities at the knots.
const MOST_ITERATIONS: usize = 200;

/// Iterations end when no velocity changes by more than this fraction of the largest.
const CONVERGED: f64 = 1e-14;

/// A spline through rotations at knots.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RotationSpline {
    rotations: Vec<Quaternion>,
    /// rᵢ of each interval.
    turns: Vec<Vector3<f64>>,
    /// ω at the knots.
    velocities: Vec<Vector3<f64>>,
}

/// A rotation with its body velocity and the rate of that.
pub(super) struct RotationPoint {
    pub(super) rotation: Quaternion,
    pub(super) velocity: Vector3<f64>,
    pub(super) acceleration: Vector3<f64>,
}

/// The inverse of J, which exists below a full turn.
fn inverse_jacobian(phi: &Vector3<f64>) -> Matrix3<f64> {
    jacobian(phi).try_inverse().unwrap_or_else(Matrix3::identity)
}

impl RotationSpline {
    /// The spline through these rotations at the knots; an error if the velocities are not found.
    pub(super) fn through(knots: &[f64], rotations: Vec<Quaternion>) -> Result<Self, InvalidInput> {
        let turns: Vec<Vector3<f64>> = rotations
            .windows(2)
            .map(|ends| Vector3::from(ends[0].conjugate().times(ends[1]).log()))
            .collect();
        let steps: Vec<f64> = knots.windows(2).map(|ends| ends[1] - ends[0]).collect();
        let mut velocities = vec![Vector3::zeros(); rotations.len()];
        for _iteration in 0..MOST_ITERATIONS {
            let next = velocities_of(&steps, &turns, &velocities);
            let change = next.iter().zip(&velocities).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            let largest = next.iter().map(Vector3::norm).fold(0.0, f64::max);
            velocities = next;
            if change <= CONVERGED * largest {
                return Ok(Self { rotations, turns, velocities });
            }
        }
        let requirement = "turn too far between waypoints for a smooth spline; add waypoints";
        Err(InvalidInput::unmet("the rotations", requirement))
    }

    /// The rotation at the fraction of an interval of this length.
    pub(super) fn at(&self, interval: usize, fraction: f64, length: f64) -> RotationPoint {
        let (turn, start) = (self.turns[interval], self.velocities[interval]);
        let end = inverse_jacobian(&turn) * self.velocities[interval + 1];
        let (t, h) = (fraction, length);
        // Hermite's cubic with values 0 and r, and slopes φ′(0) and φ′(h).
        let (square, cube) = (t * t, t * t * t);
        let phi = turn * (3.0 * square - 2.0 * cube)
            + start * (h * (t - 2.0 * square + cube))
            + end * (h * (cube - square));
        let rate = turn * (6.0 * (t - square) / h)
            + start * (1.0 - 4.0 * t + 3.0 * square)
            + end * (3.0 * square - 2.0 * t);
        let second =
            turn * ((6.0 - 12.0 * t) / (h * h)) + start * ((6.0 * t - 4.0) / h) + end * ((6.0 * t - 2.0) / h);
        let matrix = jacobian(&phi);
        RotationPoint {
            rotation: self.rotations[interval].times(Quaternion::exp(phi.into())).normalized(),
            velocity: matrix * rate,
            acceleration: matrix * second + quadratic(&phi, &rate),
        }
    }
}

/// The velocities at the knots for quadratic terms at the last ones, by elimination in a tridiagonal system
/// of 3×3 blocks.
///
/// 2/h₋ J₋ ω₋ + 4 (1/h₋ + 1/h₊) ω + 2/h₊ J₊⁻¹ ω₊ = 6 r₋/h₋² + 6 r₊/h₊² − (the rate of J₋) φ′₋.
fn velocities_of(steps: &[f64], turns: &[Vector3<f64>], last: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let n = last.len();
    let mut upper = vec![Matrix3::zeros(); n];
    let mut found = vec![Vector3::zeros(); n];
    for i in 0..n {
        let (mut diagonal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        if i + 1 < n {
            let (h, turn) = (steps[i], turns[i]);
            diagonal += Matrix3::from_diagonal_element(4.0 / h);
            right += turn * (6.0 / (h * h));
            upper[i] = inverse_jacobian(&turn) * (2.0 / h);
        }
        if i > 0 {
            let (h, turn) = (steps[i - 1], turns[i - 1]);
            let lower = jacobian(&turn) * (2.0 / h);
            diagonal += Matrix3::from_diagonal_element(4.0 / h);
            right += turn * (6.0 / (h * h)) - quadratic(&turn, &(inverse_jacobian(&turn) * last[i]));
            diagonal -= lower * upper[i - 1];
            right -= lower * found[i - 1];
        }
        let inverse = diagonal.try_inverse().unwrap_or_else(Matrix3::identity);
        upper[i] = inverse * upper[i];
        found[i] = inverse * right;
    }
    for i in (0..n - 1).rev() {
        found[i] = found[i] - upper[i] * found[i + 1];
    }
    found
}
