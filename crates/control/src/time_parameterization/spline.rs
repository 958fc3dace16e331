//! A cubic spline through waypoints.

use super::{TreePath, TreePathPoint};
use robot_dynamics_number::{InputProblem, InvalidInput, check_finite, check_result};

/// The natural cubic spline through waypoints, twice continuously differentiable, for plain coordinates only;
/// for robots with quaternions see [`ConfigurationSpline`](super::ConfigurationSpline).
///
/// Knots are the cumulative sums of chord lengths to the power ½ (centripetal), scaled to s ∈ \[0, 1\], which
/// avoids loops between uneven waypoints. q″ = 0 at both ends. Sources: de Boor, *A Practical Guide to
/// Splines* (1978); Lee, *Choosing nodes in parametric curve interpolation* (1989).
///
/// ```
/// use robot_dynamics::control::{CubicSpline, TreePath};
/// let path = CubicSpline::through(&[vec![0.0, 0.0], vec![1.0, 0.5], vec![0.5, 1.0]])?;
/// assert_eq!(path.at(1.0).q, [0.5, 1.0]);
/// # Ok::<(), robot_dynamics::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CubicSpline {
    knots: Vec<f64>,
    points: Vec<Vec<f64>>,
    /// q″ at the knots; it is linear in between.
    curvatures: Vec<Vec<f64>>,
}

impl CubicSpline {
    /// Creates a spline through these configurations, in order.
    ///
    /// # Errors
    /// [`InvalidInput`] if there are fewer than two waypoints, their lengths differ, a number
    /// is not finite, or two consecutive waypoints are equal.
    pub fn through(waypoints: &[Vec<f64>]) -> Result<Self, InvalidInput> {
        let expected = waypoints.first().map_or(0, Vec::len);
        for (index, point) in waypoints.iter().enumerate() {
            if point.len() != expected {
                let (found, owner, hint) = (point.len(), "the path".into(), ", as the first waypoint has");
                let problem = InputProblem::WrongLength { found, expected, owner, hint };
                return Err(InvalidInput::new(format!("waypoint {index}"), problem));
            }
            check_finite(&format!("waypoint {index}"), point)?;
        }
        let chord = |ends: &[Vec<f64>]| -> f64 {
            ends[1].iter().zip(&ends[0]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let chords: Vec<f64> = waypoints.windows(2).map(chord).collect();
        Self::with_chords(waypoints.to_vec(), &chords)
    }

    /// The spline through waypoints of equal length with these lengths of chords.
    pub(super) fn with_chords(waypoints: Vec<Vec<f64>>, chords: &[f64]) -> Result<Self, InvalidInput> {
        if waypoints.len() < 2 {
            let found = format!("needs at least two waypoints, got {}", waypoints.len());
            return Err(InvalidInput::unmet("a spline", found));
        }
        let mut knots = vec![0.0];
        for (index, chord) in chords.iter().enumerate() {
            if *chord == 0.0 {
                let both = format!("waypoints {index} and {}", index + 1);
                return Err(InvalidInput::unmet(both, "are the same point; leave one out"));
            }
            knots.push(knots[index] + chord.sqrt());
        }
        let length = knots[knots.len() - 1];
        for s in &mut knots {
            *s /= length;
        }
        let curvatures = curvatures(&knots, &waypoints);
        for (index, (knot, curvature)) in knots.iter().zip(&curvatures).enumerate() {
            check_result(&format!("the spline at waypoint {index}"), curvature.iter().chain([knot]))?;
        }
        Ok(Self { knots, points: waypoints, curvatures })
    }

    /// The interval that contains s, the fraction of it before s, and its length.
    pub(super) fn interval(&self, s: f64) -> (usize, f64, f64) {
        let last = self.knots.len() - 2;
        let i = self.knots.partition_point(|&knot| knot <= s).saturating_sub(1).min(last);
        let h = self.knots[i + 1] - self.knots[i];
        (i, (s - self.knots[i]) / h, h)
    }

    /// s of each waypoint.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }
}

/// q″ at the knots: h₋ m₋ + 2 (h₋ + h₊) m + h₊ m₊ = 6 (Δ₊ − Δ₋), m = 0 at the ends, by forward elimination.
fn curvatures(knots: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (n, width) = (knots.len(), points[0].len());
    let step = |i: usize| knots[i + 1] - knots[i];
    let slope = |i: usize, k: usize| (points[i + 1][k] - points[i][k]) / step(i);
    let mut curvature = vec![vec![0.0; width]; n];
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let pivot = 2.0 * (step(i - 1) + step(i)) - step(i - 1) * upper[i - 1];
        upper[i] = step(i) / pivot;
        for k in 0..width {
            let right = 6.0 * (slope(i, k) - slope(i - 1, k));
            curvature[i][k] = (right - step(i - 1) * curvature[i - 1][k]) / pivot;
        }
    }
    for i in (1..n - 1).rev() {
        for k in 0..width {
            curvature[i][k] -= upper[i] * curvature[i + 1][k];
        }
    }
    curvature
}

impl TreePath for CubicSpline {
    fn at(&self, s: f64) -> TreePathPoint {
        let (i, t, h) = self.interval(s);
        let (p0, p1) = (&self.points[i], &self.points[i + 1]);
        let (m0, m1) = (&self.curvatures[i], &self.curvatures[i + 1]);
        let each = |f: &dyn Fn(usize) -> f64| (0..p0.len()).map(f).collect();
        // q = (1−t) p₀ + t p₁ − h²/6 [ (1−t)(1 − (1−t)²) m₀ + t (1 − t²) m₁ ]
        let r = 1.0 - t;
        let bend = |k: usize| r * (1.0 - r * r) * m0[k] + t * (1.0 - t * t) * m1[k];
        let bend_rate = |k: usize| (3.0 * r * r - 1.0) * m0[k] + (1.0 - 3.0 * t * t) * m1[k];
        TreePathPoint {
            q: each(&|k| r * p0[k] + t * p1[k] - h * h / 6.0 * bend(k)),
            dq: each(&|k| (p1[k] - p0[k]) / h - h / 6.0 * bend_rate(k)),
            ddq: each(&|k| r * m0[k] + t * m1[k]),
        }
    }

    fn start(&self) -> f64 {
        0.0
    }

    fn end(&self) -> f64 {
        1.0
    }

    fn corners(&self) -> &[f64] {
        &self.knots
    }
}
