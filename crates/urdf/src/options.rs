//! How a robot file is to be read.

/// Choices that a URDF file leaves to its reader. The default: base fixed to the world, not strict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The root link moves freely in the world: six more degrees of freedom.
    pub floating_base: bool,
    /// Physics that would be ignored (a gear reduction, a spring, an unknown attribute of an inertia) is an
    /// error instead of an entry in the report.
    pub strict: bool,
    /// An inertia that no rigid body has is replaced by the nearest one that a body has, and an inertia
    /// without mass by none, with an entry in the report, instead of being an error. Files in use have such
    /// inertias. A strict reading refuses them all the same.
    pub repair_inertia: bool,
}

impl Options {
    /// The same options with the root link free to move in the world.
    pub fn with_floating_base(self) -> Self {
        Self { floating_base: true, ..self }
    }

    /// The same options, replacing inertias that no rigid body has.
    pub fn with_repaired_inertia(self) -> Self {
        Self { repair_inertia: true, ..self }
    }

    /// The same options, refusing files whose physics cannot all be read.
    pub fn with_strict(self) -> Self {
        Self { strict: true, ..self }
    }
}
