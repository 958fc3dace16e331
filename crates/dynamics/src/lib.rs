//! Robot dynamics from the Lagrangian: M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u.

// What a formula is written over.
mod dual;
mod scalar;

// The equation of motion and the recipe that yields its terms.
mod actuation;
mod equation;
mod lagrange;
pub mod laws;

// Models, one file each.
mod knife_edge;
mod planar_arm;
mod planar_body;
mod polar_mass;
mod reach2r;
mod rp_arm;

// Pfaffian constraints A(q) q̇ = 0.
mod constraint;

// Rotation of a rigid body.
mod free_body_exact;
mod inertia;
mod rigid_body;

// Motion in time.
mod integrate;

// Control.
mod control;
mod inertia_ellipse;
mod linearize;
mod path;

pub use dual::Dual;
pub use equation::{Dynamics, DynamicsError, check_finite, solve_mass};
pub use integrate::{
    Integrator, IntegratorError, State, energy_drift, explicit_euler_step, rk4_step, semi_implicit_euler_step,
};
pub use lagrange::{
    Christoffel, FromLagrangian, Lagrangian, christoffel, christoffel_by_differences, mass_derivatives,
    mass_rate, skew_symmetry_defect,
};
pub use reach2r::Reach2R;
pub use scalar::Scalar;
