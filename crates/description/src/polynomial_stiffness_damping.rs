//! Polynomial terms of springs and dampers.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Forces of a spring and a damper in addition to −k x and −d ẋ, as for quadratic drag and stiffening
/// springs. A spring stretched by x adds −k₂ x² − k₃ x³, a damper −d₂ ẋ|ẋ| − d₃ ẋ³. `Actuation` applies them;
/// they are not part of g and b.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[doc(alias = "HigherTerms")]
pub struct PolynomialStiffnessDamping {
    /// k₂ and k₃ \[N·m/rad², N·m/rad³ or N/m², N/m³\].
    pub stiffness: [f64; 2],
    /// d₂ and d₃ \[N·m·s²/rad², N·m·s³/rad³ or N·s²/m², N·s³/m³\].
    pub damping: [f64; 2],
}

/// Prints the name `HigherTerms` of version 0.1: the text enters the fingerprint of a robot.
impl core::fmt::Debug for PolynomialStiffnessDamping {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { stiffness, damping } = self;
        f.debug_struct("HigherTerms").field("stiffness", stiffness).field("damping", damping).finish()
    }
}

impl PolynomialStiffnessDamping {
    /// Whether all terms are zero.
    ///
    /// ```
    /// assert!(robot_dynamics::description::PolynomialStiffnessDamping::default().is_zero());
    /// ```
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    /// −k₂ x² − k₃ x³.
    ///
    /// ```
    /// use robot_dynamics::description::PolynomialStiffnessDamping;
    /// let stiffening = PolynomialStiffnessDamping { stiffness: [0.0, 2.0], damping: [0.0; 2] };
    /// assert_eq!(stiffening.spring_force(-0.5), 0.25);
    /// ```
    pub fn spring_force(&self, x: f64) -> f64 {
        let [k2, k3] = self.stiffness;
        -(k2 + k3 * x) * x * x
    }

    /// The energy of these terms of the spring \[J\], k₂ x³/3 + k₃ x⁴/4.
    ///
    /// ```
    /// use robot_dynamics::description::PolynomialStiffnessDamping;
    /// let (terms, h) = (PolynomialStiffnessDamping { stiffness: [3.0, 2.0], damping: [0.0; 2] }, 1e-6);
    /// let derivative = (terms.energy(0.5 + h) - terms.energy(0.5 - h)) / (2.0 * h);
    /// assert!((derivative + terms.spring_force(0.5)).abs() < 1e-9);
    /// ```
    pub fn energy(&self, x: f64) -> f64 {
        let [k2, k3] = self.stiffness;
        (k2 / 3.0 + 0.25 * k3 * x) * x * x * x
    }

    /// −d₂ ẋ|ẋ| − d₃ ẋ³.
    ///
    /// ```
    /// use robot_dynamics::description::PolynomialStiffnessDamping;
    /// let drag = PolynomialStiffnessDamping { stiffness: [0.0; 2], damping: [2.0, 0.0] };
    /// assert_eq!((drag.damping_force(0.5), drag.damping_force(-0.5)), (-0.5, 0.5));
    /// ```
    pub fn damping_force(&self, rate: f64) -> f64 {
        let [d2, d3] = self.damping;
        -(d2 * rate.abs() + d3 * rate * rate) * rate
    }
}
