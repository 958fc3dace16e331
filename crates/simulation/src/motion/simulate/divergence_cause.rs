//! The reason for the step that is suggested after divergence.

use core::fmt;

/// The reason for the suggested step in [`RunError::Diverged`](super::RunError::Diverged).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DivergenceCause {
    /// Springs, dampers and servos that the method treats explicitly; the suggestion is half of the limit of
    /// stability.
    Stiffness,
    /// The speed at the start; a suggested step moves no coordinate by more than 0.1 rad or m.
    Speed,
    /// Neither explains the divergence; the suggestion is a tenth of the step.
    Unknown,
}

impl fmt::Display for DivergenceCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stiffness => "half of what the springs, dampers and servos let the method take",
            Self::Speed => "with which the speed at the start moves no coordinate by more than 0.1 rad or m",
            Self::Unknown => {
                "a tenth of this one; if that changes nothing, look at the controller's gains and for dampers with the wrong sign"
            }
        })
    }
}
