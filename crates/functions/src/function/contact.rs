//! The functions of a step with contact.

use super::Function;

impl Function {
    /// The number of sweeps of the function `contact_step`; `contact_step_N_sweeps` has N.
    pub const CONTACT_SWEEPS: u16 = 16;

    /// The functions of a step with contact, for robots whose shapes it supports.
    pub const OF_CONTACT: [Self; 6] = [
        Self::ContactStep { sweeps: Self::CONTACT_SWEEPS },
        Self::ContactProblem,
        Self::ContactStart,
        Self::ContactSweep,
        Self::ContactFixedPoint,
        Self::ContactEnd,
    ];

    /// Whether it is a step with contact or a stage of one.
    pub(crate) fn is_of_contact(&self) -> bool {
        matches!(
            self,
            Self::ContactStep { .. }
                | Self::ContactProblem
                | Self::ContactStart
                | Self::ContactSweep
                | Self::ContactFixedPoint
                | Self::ContactEnd
        )
    }
}
