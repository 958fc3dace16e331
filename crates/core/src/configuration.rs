//! The configuration space: q ⊕ δ, q₁ ⊖ q₀, q̇ from v, conventions, and the map to a robot with joints
//! locked.

pub mod configuration_rate;
pub mod conventions;
pub mod cotangent;
pub mod displacement_rate;
pub(crate) mod joint_map;
pub mod joint_sum;
pub mod manifold;
pub mod named_pose;
pub mod retraction;
pub mod retraction_pullback;
