//! The configuration space: q ⊕ δ, q₁ ⊖ q₀, q̇ from v, the conventions, and the space of a robot with joints locked.

pub(crate) mod configuration;
pub(crate) mod configuration_rate;
pub mod conventions;
pub(crate) mod cotangent;
pub(crate) mod displacement_rate;
pub(crate) mod joint_map;
pub(crate) mod joint_sum;
pub(crate) mod named_pose;
pub(crate) mod retraction;
pub(crate) mod retraction_pullback;
