//! Mass, centre of mass and rotational inertia of a rigid body, checked on construction.
//!
//! The inertia of a density ρ about the origin is 𝓘 = ∫ ρ (|r|²1 − r rᵀ) dV **(PRM 10.42)**. Its principal
//! moments are ∫ρ(y²+z²), ∫ρ(x²+z²), ∫ρ(x²+y²). So none is negative, and none exceeds the sum of the other
//! two. [`MassProperties::new`] rejects other matrices.

mod error;
mod mass_properties;
mod mesh;
mod parallel_axis;
mod principal;
mod repair;
mod rotational;
mod shapes;

pub use error::{InertiaError, six_digits};
pub use mass_properties::MassProperties;
pub use parallel_axis::{parallel_axis, parallel_axis_planar};
pub use principal::PrincipalInertia;
pub use rotational::RotationalInertia;
