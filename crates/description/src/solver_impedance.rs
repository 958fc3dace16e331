//! The compliance of constraints under MuJoCo's law.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Parameters of a soft constraint, in the numbers of MJCF (`solref`, `solimp`): see `SoftConstraints`.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[doc(alias = "Softness")]
pub struct SolverImpedance {
    /// Time constant \[s\] and damping ratio; if both are negative, −stiffness and −damping.
    pub solref: [f64; 2],
    /// The impedance d as a function of the violation: d at zero, d at the width and beyond, the width \[m or
    /// rad\], midpoint, power.
    pub solimp: [f64; 5],
}

/// Prints the name `Softness` of version 0.1: the text enters the fingerprint of a robot.
impl core::fmt::Debug for SolverImpedance {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { solref, solimp } = self;
        f.debug_struct("Softness").field("solref", solref).field("solimp", solimp).finish()
    }
}

impl Default for SolverImpedance {
    /// MuJoCo's defaults: 20 ms, critically damped, d from 0.9 to 0.95 within a millimetre.
    fn default() -> Self {
        Self { solref: [0.02, 1.0], solimp: [0.9, 0.95, 0.001, 0.5, 2.0] }
    }
}

/// Parameters of a joint for MuJoCo's law.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
#[doc(alias = "JointSoftness")]
pub struct JointSolverImpedance {
    /// The softness of its position limits.
    pub limit: SolverImpedance,
    /// The softness of its dry friction.
    pub friction: SolverImpedance,
    /// The distance from a limit within which the limit is active \[rad or m\].
    pub margin: f64,
    /// q in the robot's reference pose, at which the law computes the joint's weight \[rad or m\]; for a
    /// joint of one DoF.
    pub reference: f64,
    /// Whether the law weighs the joint and its body by the body's mass alone, for all directions and without
    /// armature. MuJoCo does so for a body without children whose joints are slides along its axes and whose
    /// inertia is in its frame (`body_simple`).
    #[cfg_attr(feature = "serde", serde(default))]
    pub is_weighed_by_mass: bool,
}

/// Prints the name `JointSoftness` of version 0.1, and omits the field `is_weighed_by_mass` if it is false:
/// the text enters the fingerprint of a robot.
impl core::fmt::Debug for JointSolverImpedance {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { limit, friction, margin, reference, is_weighed_by_mass } = self;
        let mut fields = f.debug_struct("JointSoftness");
        fields
            .field("limit", limit)
            .field("friction", friction)
            .field("margin", margin)
            .field("reference", reference);
        if *is_weighed_by_mass {
            fields.field("is_weighed_by_mass", is_weighed_by_mass);
        }
        fields.finish()
    }
}

/// Parameters of a tendon for MuJoCo's law.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
#[doc(alias = "TendonSoftness")]
pub struct TendonSolverImpedance {
    /// The softness of its length limits.
    pub limit: SolverImpedance,
    /// The softness of its dry friction.
    pub friction: SolverImpedance,
    /// The distance from a limit within which the limit is active.
    pub margin: f64,
}

/// Prints the name `TendonSoftness` of version 0.1: the text enters the fingerprint of a robot.
impl core::fmt::Debug for TendonSolverImpedance {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { limit, friction, margin } = self;
        f.debug_struct("TendonSoftness")
            .field("limit", limit)
            .field("friction", friction)
            .field("margin", margin)
            .finish()
    }
}
