//! The effects that a description states and a simulation may leave out, by name.

use core::fmt;
use core::str::FromStr;

use thiserror::Error;

/// Something that acts in a simulation unless it is switched off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Effect {
    /// Damping and dry friction of joints and tendons.
    Dissipation,
    /// Limits of positions of joints and of lengths of tendons, as inelastic stops.
    Limits,
    /// Limits of the torques that a controller asks for.
    EffortLimits,
    /// Springs of tendons, of ball joints and of free joints, and weight that is compensated.
    Springs,
    /// The actuators of the file, at their controls.
    Actuators,
    /// Equalities: closed loops and coupled joints.
    Equalities,
    /// All contacts: with the ground, with fixed geometry, and between links.
    Contacts,
    /// Contacts between links, and between links and fixed geometry other than planes and height fields.
    LinkContacts,
}

impl Effect {
    /// All of them.
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

    /// Its name, as the command and Python take it.
    ///
    /// ```
    /// use multibody::simulator::Effect;
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

/// A name that no effect has.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no effect `{name}` to switch off; there are {}", Effect::ALL.map(Effect::name).join(", "))]
pub struct UnknownEffect {
    /// As given.
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
