//! How constraints yield under MuJoCo's law: data beside the dynamics.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// How a constraint yields, in the numbers of MJCF (`solref`, `solimp`): see [`SoftConstraints`](crate::SoftConstraints).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Softness {
    /// Time constant \[s\] and damping ratio; both negative: −stiffness and −damping.
    pub solref: [f64; 2],
    /// The impedance d as it grows with the violation: at none, at the width and beyond, the width \[m or rad\], midpoint, power.
    pub solimp: [f64; 5],
}

impl Default for Softness {
    /// MuJoCo's: 20 ms, critically damped, d from 0.9 to 0.95 within a millimetre.
    fn default() -> Self {
        Self { solref: [0.02, 1.0], solimp: [0.9, 0.95, 0.001, 0.5, 2.0] }
    }
}

/// What MuJoCo's law has to know of a joint.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct JointSoftness {
    /// How its position limits yield.
    pub limit: Softness,
    /// How its dry friction creeps.
    pub friction: Softness,
    /// So far from a limit that limit acts already \[rad or m\].
    pub margin: f64,
    /// q in the robot's reference pose, in which the law weighs it \[rad or m\]; of a joint of one freedom.
    pub reference: f64,
    /// Whether the law weighs the joint and its body by the body's mass alone, for all directions and without armature. MuJoCo does so for a body
    /// that carries no other one, whose joints are slides along its axes, and whose inertia has its frame (`body_simple`).
    #[cfg_attr(feature = "serde", serde(default))]
    pub is_weighed_by_mass: bool,
}

/// A joint that is weighed as every other one has the text, and a robot of such joints the fingerprint, that it had before the field was there.
impl core::fmt::Debug for JointSoftness {
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

/// What MuJoCo's law has to know of a tendon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct TendonSoftness {
    /// How the limits of its length yield.
    pub limit: Softness,
    /// How its dry friction creeps.
    pub friction: Softness,
    /// So far from a limit that limit acts already.
    pub margin: f64,
}
