//! The configuration space: q ⊕ δ, q₁ ⊖ q₀, q̇ from v, and the conventions.

pub(crate) mod configuration;
pub(crate) mod configuration_rate;
pub mod conventions;
pub(crate) mod displacement_rate;
#[cfg(feature = "batch")]
pub(crate) mod retraction;
