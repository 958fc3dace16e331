//! A rule for one element of the format.

/// The handling of an element by this reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Handling {
    /// Reads it and its content.
    Read,
    /// Counts it as appearance.
    Appearance,
    /// Ignores it because it does not affect the motion, with a description.
    NotDynamics(&'static str),
    /// Warns that it may affect the motion and is not in the model, with a description.
    Physics(&'static str),
}

/// One element of the format.
pub(crate) struct Rule {
    /// The possible parents.
    pub(crate) within: &'static [&'static str],
    pub(crate) name: &'static str,
    pub(crate) handling: Handling,
    /// Attributes that are read.
    pub(crate) read: &'static [&'static str],
    /// Attributes of appearance, contact and solvers, which do not enter the equations of motion.
    pub(crate) ignored: &'static [&'static str],
    /// Attributes of physics that is not in the model, with the value that has no effect.
    pub(crate) physics: &'static [(&'static str, &'static str)],
}

pub(super) const fn rule(within: &'static [&'static str], name: &'static str, handling: Handling) -> Rule {
    Rule { within, name, handling, read: &[], ignored: &[], physics: &[] }
}

pub(super) const fn read(
    within: &'static [&'static str],
    name: &'static str,
    read: &'static [&'static str],
) -> Rule {
    Rule { within, name, handling: Handling::Read, read, ignored: &[], physics: &[] }
}

impl Rule {
    pub(super) const fn ignored(self, ignored: &'static [&'static str]) -> Self {
        Self { ignored, ..self }
    }

    pub(super) const fn physics(self, physics: &'static [(&'static str, &'static str)]) -> Self {
        Self { physics, ..self }
    }
}

pub(super) const fn deformable(within: &'static [&'static str], name: &'static str) -> Rule {
    rule(within, name, Handling::Physics("deformable bodies are not in the model"))
}
