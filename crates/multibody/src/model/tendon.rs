//! A fixed tendon as a robot's file states it.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{HigherTerms, Limits, PassiveForces, TendonSoftness};

/// A tendon whose length is a sum of joint positions, ℓ(q) = ℓ₀ + Σ cᵢ qᵢ: cables over drums, fingers that share a motor.
///
/// It adds what a joint of position ℓ would: −stiffness·(ℓ − rest) − damping·ℓ̇ − friction·sign ℓ̇, spread over its joints
/// by cᵢ. Its armature, what turns with it, adds armature·c cᵀ to M. Where its joints are on several branches M has entries
/// that no tree has: it is then factored as a whole, as for followers, O(n³) and not O(n).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct TendonDescription {
    /// Its name, unique among tendons.
    pub name: String,
    /// Joints of one freedom each, by name, with cᵢ.
    pub terms: Vec<(String, f64)>,
    /// ℓ₀, the length where all its joints are at 0.
    pub offset: f64,
    /// Armature, damping, friction and stiffness, as of a joint; `rest` is where the spring's dead band begins.
    pub passive: PassiveForces,
    /// What its spring and damper add beyond that.
    #[cfg_attr(feature = "serde", serde(default))]
    pub higher_terms: HigherTerms,
    /// By how much ℓ may exceed `passive.rest` before the spring pulls; 0 without a dead band, infinite for a spring that
    /// only pushes.
    pub dead_band: f64,
    /// Bounds on ℓ and on the force.
    pub limits: Limits,
    /// How its limits yield under MuJoCo's law.
    #[cfg_attr(feature = "serde", serde(default))]
    pub softness: TendonSoftness,
}

impl TendonDescription {
    /// A tendon over those joints, without forces of its own.
    ///
    /// ```
    /// let both_fingers = [("left".to_owned(), 0.5), ("right".to_owned(), 0.5)];
    /// let tendon = multibody::TendonDescription::new("grip", both_fingers);
    /// assert_eq!((tendon.terms.len(), tendon.offset), (2, 0.0));
    /// ```
    pub fn new(name: impl Into<String>, terms: impl IntoIterator<Item = (String, f64)>) -> Self {
        Self {
            name: name.into(),
            terms: terms.into_iter().collect(),
            offset: 0.0,
            passive: PassiveForces::default(),
            higher_terms: HigherTerms::default(),
            dead_band: 0.0,
            limits: Limits::default(),
            softness: TendonSoftness::default(),
        }
    }

    /// By how much the spring is stretched (positive) or pressed (negative) at length ℓ.
    ///
    /// ```
    /// use multibody::{PassiveForces, TendonDescription};
    /// let mut tendon = TendonDescription::new("grip", []);
    /// tendon.passive = PassiveForces::default().with_spring(10.0, 0.1);
    /// tendon.dead_band = 0.2; // slack from 0.1 to 0.3
    /// assert_eq!([0.0, 0.2, 0.5].map(|length| tendon.stretch(length)), [-0.1, 0.0, 0.2]);
    /// ```
    pub fn stretch(&self, length: f64) -> f64 {
        let beyond = length - self.passive.rest;
        if beyond < 0.0 { beyond } else { (beyond - self.dead_band).max(0.0) }
    }
}
