//! Polynomial terms of springs and dampers.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Forces of a spring and a damper in addition to −k x and −d ẋ, as for quadratic drag and stiffening
/// springs. A spring stretched by x adds −k₂ x² − k₃ x³, a damper −d₂ ẋ|ẋ| − d₃ ẋ³. `Actuation` applies them;
/// they are not part of g and b.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct HigherTerms {
    /// k₂ and k₃ \[N·m/rad², N·m/rad³ or N/m², N/m³\].
    pub stiffness: [f64; 2],
    /// d₂ and d₃ \[N·m·s²/rad², N·m·s³/rad³ or N·s²/m², N·s³/m³\].
    pub damping: [f64; 2],
}

impl HigherTerms {
    /// Whether all terms are zero.
    ///
    /// ```
    /// assert!(robot_dynamics::description::HigherTerms::default().is_zero());
    /// ```
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    /// −k₂ x² − k₃ x³.
    ///
    /// ```
    /// let stiffening = robot_dynamics::description::HigherTerms { stiffness: [0.0, 2.0], damping: [0.0; 2] };
    /// assert_eq!(stiffening.spring_force(-0.5), 0.25);
    /// ```
    pub fn spring_force(&self, x: f64) -> f64 {
        let [k2, k3] = self.stiffness;
        -(k2 + k3 * x) * x * x
    }

    /// The energy of these terms of the spring \[J\], k₂ x³/3 + k₃ x⁴/4.
    ///
    /// ```
    /// let (terms, h) = (robot_dynamics::description::HigherTerms { stiffness: [3.0, 2.0], damping: [0.0; 2] }, 1e-6);
    /// let slope = (terms.energy(0.5 + h) - terms.energy(0.5 - h)) / (2.0 * h);
    /// assert!((slope + terms.spring_force(0.5)).abs() < 1e-9);
    /// ```
    pub fn energy(&self, x: f64) -> f64 {
        let [k2, k3] = self.stiffness;
        (k2 / 3.0 + 0.25 * k3 * x) * x * x * x
    }

    /// −d₂ ẋ|ẋ| − d₃ ẋ³.
    ///
    /// ```
    /// let drag = robot_dynamics::description::HigherTerms { stiffness: [0.0; 2], damping: [2.0, 0.0] };
    /// assert_eq!((drag.damping_force(0.5), drag.damping_force(-0.5)), (-0.5, 0.5));
    /// ```
    pub fn damping_force(&self, rate: f64) -> f64 {
        let [d2, d3] = self.damping;
        -(d2 * rate.abs() + d3 * rate * rate) * rate
    }
}
