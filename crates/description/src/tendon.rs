//! Fixed tendons, as a robot's file describes them.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{Limits, PassiveForces, PolynomialStiffnessDamping, TendonSolverImpedance};

/// A tendon with the length ℓ(q) = ℓ₀ + Σ cᵢ qᵢ, a sum of joint positions. Examples are a cable over drums,
/// and fingers that share a motor.
///
/// Its force is that of a joint with the position ℓ, −stiffness·(ℓ − rest) − damping·ℓ̇ − friction·sign ℓ̇,
/// and acts on its joints by the factors cᵢ. Its armature adds armature·c cᵀ to M. If its joints are on
/// several branches, M has entries between branches. M then needs a dense factorization, as for mimic joints,
/// O(n³) instead of O(n).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct TendonDescription {
    /// Its name, unique among tendons.
    pub name: String,
    /// Joints of one DoF each, by name, with cᵢ.
    pub terms: Vec<(String, f64)>,
    /// ℓ₀, the length with all its joints at 0.
    pub offset: f64,
    /// Armature, damping, friction and stiffness, as for a joint; `rest` is the start of the spring's dead
    /// band.
    pub passive: PassiveForces,
    /// Polynomial terms of its spring and damper.
    #[cfg_attr(feature = "serde", serde(default))]
    pub higher_terms: PolynomialStiffnessDamping,
    /// The largest elastic stretch of its spring. Beyond it the spring yields: its dead band follows. 0 for a
    /// spring that never yields. If the dead band begins at 0, a stretch moves its end alone.
    #[cfg_attr(feature = "serde", serde(default))]
    pub spring_yield: f64,
    /// The length of the dead band: the spring pulls beyond `passive.rest` plus this length. 0 without a dead
    /// band, infinite for a spring that only pushes.
    pub dead_band: f64,
    /// Bounds on ℓ and on the force.
    pub limits: Limits,
    /// The softness of its limits under MuJoCo's law.
    #[cfg_attr(feature = "serde", serde(default))]
    pub softness: TendonSolverImpedance,
}

impl TendonDescription {
    /// A tendon over these joints, without passive forces.
    ///
    /// ```
    /// let both_fingers = [("left".to_owned(), 0.5), ("right".to_owned(), 0.5)];
    /// let tendon = robot_dynamics::description::TendonDescription::new("grip", both_fingers);
    /// assert_eq!((tendon.terms.len(), tendon.offset), (2, 0.0));
    /// ```
    pub fn new(name: impl Into<String>, terms: impl IntoIterator<Item = (String, f64)>) -> Self {
        Self {
            name: name.into(),
            terms: terms.into_iter().collect(),
            offset: 0.0,
            passive: PassiveForces::default(),
            higher_terms: PolynomialStiffnessDamping::default(),
            spring_yield: 0.0,
            dead_band: 0.0,
            limits: Limits::default(),
            softness: TendonSolverImpedance::default(),
        }
    }

    /// The stretch (positive) or compression (negative) of the spring at length ℓ.
    ///
    /// ```
    /// use robot_dynamics::description::{PassiveForces, TendonDescription};
    /// let mut tendon = TendonDescription::new("grip", []);
    /// tendon.passive = PassiveForces::default().with_spring(10.0, 0.1);
    /// tendon.dead_band = 0.2; // slack from 0.1 to 0.3
    /// assert_eq!([0.0, 0.2, 0.5].map(|length| tendon.stretch(length)), [-0.1, 0.0, 0.2]);
    /// ```
    pub fn stretch(&self, length: f64) -> f64 {
        self.passive.stretch(length, self.dead_band)
    }
}
