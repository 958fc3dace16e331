//! Muscles: force by activation, length and velocity.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// The force of a muscle, f = −F₀ (F_L(L) F_V(V) a + F_P(L)), which pulls. a is its activation, from 0 to 1.
///
/// L = range₀ + (ℓ − ℓ₀)/L₀ is the length in units of the optimal length L₀ = (ℓ₁ − ℓ₀)/(range₁ − range₀),
/// and V = ℓ̇/(L₀ v_max). F_L is 1 at L = 1 and 0 outside `active_range`. F_V is 1 at rest, 0 for V ≤ −1 and
/// `lengthening_force` for fast lengthening. F_P rises above L = 1. These are the curves of MuJoCo's muscles
/// **(MuJoCo documentation, Modeling, Muscles)**.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Muscle {
    /// F₀, the largest active force at rest \[N or N·m\].
    pub peak_force: f64,
    /// ℓ₀ and ℓ₁, the shortest and the longest length of the transmission.
    pub length_range: [f64; 2],
    /// L at ℓ₀ and at ℓ₁.
    pub range: [f64; 2],
    /// The lengths L between which the muscle can pull actively.
    pub active_range: [f64; 2],
    /// v_max, the velocity of shortening without force, in L₀ per second.
    pub shortening_velocity: f64,
    /// F_P at the upper end of `active_range`.
    pub passive_force: f64,
    /// F_V for fast lengthening.
    pub lengthening_force: f64,
}

impl Muscle {
    /// A muscle with this peak force and range of lengths, and MuJoCo's default curves.
    pub fn new(peak_force: f64, length_range: [f64; 2]) -> Self {
        Self {
            peak_force,
            length_range,
            range: [0.75, 1.05],
            active_range: [0.5, 1.6],
            shortening_velocity: 1.5,
            passive_force: 1.3,
            lengthening_force: 1.2,
        }
    }

    /// f \[N or N·m\] at the activation a, the length ℓ and the velocity ℓ̇.
    ///
    /// ```
    /// use robot_dynamics::description::Muscle;
    /// let muscle = Muscle::new(100.0, [0.2, 0.3]);
    /// let optimal = 0.2 + 0.25 * 0.1 / 0.3; // L = 1
    /// assert!((muscle.force(0.5, optimal, 0.0) + 50.0).abs() < 1e-12);
    /// ```
    pub fn force(&self, activation: f64, length: f64, velocity: f64) -> f64 {
        let (length, velocity) = self.normalized(length, velocity);
        let active = self.active_by_length(length) * self.active_by_velocity(velocity);
        -self.peak_force * (active * activation + self.passive(length))
    }

    /// L and V.
    fn normalized(&self, length: f64, velocity: f64) -> (f64, f64) {
        let [shortest, longest] = self.length_range;
        let optimal = (longest - shortest) / (self.range[1] - self.range[0]);
        let velocity = velocity / (optimal * self.shortening_velocity);
        (self.range[0] + (length - shortest) / optimal, velocity)
    }

    /// F_L: four parabolas that meet with equal slopes.
    fn active_by_length(&self, length: f64) -> f64 {
        let [lower, upper] = self.active_range;
        let (end, middle) =
            if length <= 1.0 { (lower, 0.5 * (lower + 1.0)) } else { (upper, 0.5 * (1.0 + upper)) };
        // The way from the end toward the maximum in units of a parabola's width: 0 at the end, 2 at L = 1.
        let way = (length - end) / (middle - end);
        if way <= 0.0 {
            0.0
        } else if way <= 1.0 {
            0.5 * way * way
        } else {
            1.0 - 0.5 * (2.0 - way).powi(2)
        }
    }

    /// F_V.
    fn active_by_velocity(&self, velocity: f64) -> f64 {
        let excess = self.lengthening_force - 1.0;
        if velocity <= -1.0 {
            0.0
        } else if velocity <= 0.0 {
            (velocity + 1.0).powi(2)
        } else if velocity < excess {
            self.lengthening_force - (excess - velocity).powi(2) / excess
        } else {
            self.lengthening_force
        }
    }

    /// F_P: half a parabola, and a line beyond the middle of L = 1 and the end of the active range.
    fn passive(&self, length: f64) -> f64 {
        let way = (length - 1.0) / (0.5 * (self.active_range[1] - 1.0));
        let rise = if way <= 1.0 { 0.5 * way.max(0.0).powi(2) } else { way - 0.5 };
        self.passive_force * rise
    }
}
