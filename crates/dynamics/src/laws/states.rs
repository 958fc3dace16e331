//! Seeded states at which laws are checked.

use core::f64::consts::{FRAC_PI_2, PI};

use nalgebra::SVector;
use robot_dynamics_number::SplitMix64;

/// A state with a force and an acceleration; units as in [`Dynamics`](crate::Dynamics).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sample<const N: usize> {
    /// The index in the sequence, from 0.
    pub index: usize,
    /// Coordinates q.
    pub q: SVector<f64, N>,
    /// Velocity q̇.
    pub qd: SVector<f64, N>,
    /// A force u, independent of the acceleration.
    pub u: SVector<f64, N>,
    /// An acceleration q̈, independent of the force.
    pub qdd: SVector<f64, N>,
}

/// A reproducible set of states: q uniform in a box, and q̇, u and q̈ uniform around zero.
///
/// Every fourth state is a corner case: its coordinates are rounded to multiples of π/2 inside the box. Arms
/// are stretched or folded there, and M is worst conditioned. Every eighth state is at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct States<const N: usize> {
    seed: u64,
    count: usize,
    lower: SVector<f64, N>,
    upper: SVector<f64, N>,
    speed: f64,
    force: f64,
}

impl<const N: usize> States<N> {
    /// 200 states with |qᵢ| ≤ π, |q̇ᵢ| ≤ 3, |uᵢ| and |q̈ᵢ| ≤ 10.
    pub fn new(seed: u64) -> Self {
        let half_turn = SVector::repeat(PI);
        Self { seed, count: 200, lower: -half_turn, upper: half_turn, speed: 3.0, force: 10.0 }
    }

    /// The same with coordinates between `lower` and `upper`, for coordinates with limits.
    ///
    /// # Panics
    /// If a `lower` is above its `upper`, or one of them is not finite.
    pub fn within(mut self, lower: SVector<f64, N>, upper: SVector<f64, N>) -> Self {
        for i in 0..N {
            assert!(
                lower[i] <= upper[i] && (upper[i] - lower[i]).is_finite(),
                "coordinate {i}: no value lies between {} and {}",
                lower[i],
                upper[i]
            );
        }
        (self.lower, self.upper) = (lower, upper);
        self
    }

    /// The same with `count` states.
    pub fn count(mut self, count: usize) -> Self {
        self.count = count;
        self
    }

    /// The seed of these states.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The states, in order.
    pub fn iter(&self) -> impl Iterator<Item = Sample<N>> + '_ {
        let mut random = SplitMix64::new(self.seed);
        (0..self.count).map(move |index| {
            let mut q = SVector::from_fn(|i, _| random.uniform(self.lower[i], self.upper[i]));
            let mut around_zero = |bound: f64| SVector::from_fn(|_, _| random.uniform(-bound, bound));
            let (mut qd, u, qdd) =
                (around_zero(self.speed), around_zero(self.force), around_zero(self.force));
            if index % 4 == 3 {
                q = SVector::from_fn(|i, _| {
                    ((q[i] / FRAC_PI_2).round() * FRAC_PI_2).clamp(self.lower[i], self.upper[i])
                });
            }
            if index % 8 == 7 {
                qd = SVector::zeros();
            }
            Sample { index, q, qd, u, qdd }
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::vector;

    use super::*;

    #[test]
    fn states_are_in_box_and_repeat() {
        let states = States::new(5).within(vector![0.2, -1.0], vector![2.0, 1.0]);
        let all: Vec<Sample<2>> = states.iter().collect();
        assert_eq!(all.len(), 200);
        assert!(all.iter().all(|s| s.q[0] >= 0.2 && s.q[0] <= 2.0 && s.q[1].abs() <= 1.0));
        assert_eq!(all, states.iter().collect::<Vec<_>>());
        assert_ne!(all[0], States::new(6).iter().next().unwrap());
    }

    #[test]
    fn states_include_corner_cases() {
        let folded = States::<2>::new(1).iter().any(|s| s.q[1].cos() < -1.0 + 1e-12);
        let at_rest = States::<2>::new(1).iter().any(|s| s.qd.norm() == 0.0);
        assert!(folded && at_rest);
    }

    #[test]
    #[should_panic(expected = "coordinate 1: no value lies between 2 and 1")]
    fn empty_box_panics() {
        let _ = States::new(0).within(vector![0.0, 2.0], vector![1.0, 1.0]);
    }
}
