//! A path with a time law.

use super::{TreePath, TreePathPoint};

/// s(t) with ṡ² linear in s between grid points.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedPath {
    s: Vec<f64>,
    /// x = ṡ² at the grid points.
    x: Vec<f64>,
    /// t at the grid points.
    t: Vec<f64>,
}

/// The path parameter and its derivatives at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[doc(alias = "PathMoment")]
pub struct PathState {
    /// s.
    pub s: f64,
    /// ṡ \[1/s\].
    pub speed: f64,
    /// s̈ \[1/s²\].
    pub acceleration: f64,
}

impl TimedPath {
    /// Creates the time law from grid points and squared speeds. t grows by 2Δs/(ṡᵢ + ṡᵢ₊₁), exact for
    /// constant s̈.
    pub(super) fn new(s: Vec<f64>, x: Vec<f64>) -> Self {
        let mut t = vec![0.0];
        for i in 1..s.len() {
            t.push(t[i - 1] + 2.0 * (s[i] - s[i - 1]) / (x[i - 1].sqrt() + x[i].sqrt()));
        }
        Self { s, x, t }
    }

    /// The duration of the motion \[s\].
    pub fn duration(&self) -> f64 {
        self.t[self.t.len() - 1]
    }

    /// The grid of the path parameter.
    pub fn grid(&self) -> &[f64] {
        &self.s
    }

    /// ṡ² at the grid points.
    pub fn squared_speeds(&self) -> &[f64] {
        &self.x
    }

    /// t at the grid points \[s\].
    pub fn times(&self) -> &[f64] {
        &self.t
    }

    /// s̈ on interval i.
    ///
    /// # Panics
    /// Panics if there is no such interval.
    #[track_caller]
    pub fn acceleration(&self, interval: usize) -> f64 {
        (self.x[interval + 1] - self.x[interval]) / (2.0 * (self.s[interval + 1] - self.s[interval]))
    }

    /// ṡ² at s, by linear interpolation, which is exact between grid points.
    pub(super) fn squared_speed(&self, s: f64) -> f64 {
        let last = self.s.len() - 2;
        let i = self.s.partition_point(|&start| start <= s).saturating_sub(1).min(last);
        self.x[i] + (self.x[i + 1] - self.x[i]) * (s - self.s[i]) / (self.s[i + 1] - self.s[i])
    }

    /// s, ṡ and s̈ at time t; before and after the motion, those of its ends.
    pub fn at(&self, t: f64) -> PathState {
        let t = t.clamp(0.0, self.duration());
        let (i, s) = self.interval(t);
        let acceleration = self.acceleration(i);
        PathState { s, speed: (self.x[i].sqrt() + acceleration * (t - self.t[i])).max(0.0), acceleration }
    }

    /// The interval at a time of the motion, and s.
    pub(super) fn interval(&self, t: f64) -> (usize, f64) {
        let last = self.s.len() - 2;
        let i = self.t.partition_point(|&start| start <= t).saturating_sub(1).min(last);
        let since = t - self.t[i];
        let s = self.s[i] + since * (self.x[i].sqrt() + 0.5 * self.acceleration(i) * since);
        (i, s.min(self.s[i + 1]))
    }

    /// q, v and a at time t: v = q′ ṡ, a = q′ s̈ + q″ ṡ².
    pub fn state(&self, path: &impl TreePath, t: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let PathState { s, speed, acceleration } = self.at(t);
        let TreePathPoint { q, dq, ddq } = path.at(s);
        let v = dq.iter().map(|dq| dq * speed).collect();
        let a = dq.iter().zip(&ddq).map(|(dq, ddq)| dq * acceleration + ddq * (speed * speed)).collect();
        (q, v, a)
    }

    /// The same motion k times faster: ṡ is multiplied by k, s̈ and the motion part of τ by k².
    ///
    /// # Panics
    /// Panics if k is not positive and finite.
    #[must_use]
    #[track_caller]
    pub fn faster(&self, k: f64) -> Self {
        assert!(k > 0.0 && k.is_finite(), "a motion is played a positive number of times faster, got {k}");
        Self {
            s: self.s.clone(),
            x: self.x.iter().map(|x| x * k * k).collect(),
            t: self.t.iter().map(|t| t / k).collect(),
        }
    }
}
