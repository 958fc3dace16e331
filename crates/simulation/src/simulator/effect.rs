//! The effects that a simulation can switch off, by name.

use core::fmt;
use core::str::FromStr;

use thiserror::Error;

/// An effect that acts in a simulation unless it is switched off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Effect {
    /// Damping and dry friction of joints and tendons, and the forces of the fluid.
    Dissipation,
    /// Position limits of joints and length limits of tendons, as inelastic stops.
    Limits,
    /// Limits of the torques that a controller requests.
    EffortLimits,
    /// Springs of tendons, ball joints and free joints, and gravity compensation.
    Springs,
    /// The actuators of the file, driven by their controls.
    Actuators,
    /// Equalities: kinematic loops and coupled joints.
    Equalities,
    /// All contacts: with the ground, with fixed geometry, and between links.
    Contacts,
    /// Contacts between links, and between links and fixed geometry other than planes and height fields.
    LinkContacts,
}

impl Effect {
    /// All effects.
    pub const ALL: [Self; 8] = [
        Self::Dissipation,
        Self::Limits,
        Self::EffortLimits,
        Self::Springs,
        Self::Actuators,
        Self::Equalities,
        Self::Contacts,
        Self::LinkContacts,
    ];

    /// The name of the effect in the command and in Python.
    ///
    /// ```
    /// use robot_dynamics::simulation::Effect;
    /// assert_eq!(Effect::LinkContacts.name(), "link-contacts");
    /// assert!(Effect::ALL.into_iter().all(|effect| effect.name().parse() == Ok(effect)));
    /// ```
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dissipation => "dissipation",
            Self::Limits => "limits",
            Self::EffortLimits => "effort-limits",
            Self::Springs => "springs",
            Self::Actuators => "actuators",
            Self::Equalities => "equalities",
            Self::Contacts => "contacts",
            Self::LinkContacts => "link-contacts",
        }
    }
}

/// The error for an unknown name of an effect.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no effect `{name}` to switch off; there are {}", Effect::ALL.map(Effect::name).join(", "))]
pub struct UnknownEffect {
    /// The unknown name.
    pub name: String,
}

impl FromStr for Effect {
    type Err = UnknownEffect;
    fn from_str(name: &str) -> Result<Self, UnknownEffect> {
        let same = |effect: &Self| effect.name() == name.trim().replace('_', "-");
        Self::ALL.into_iter().find(same).ok_or_else(|| UnknownEffect { name: name.to_owned() })
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
