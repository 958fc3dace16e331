//! Robot dynamics from the Lagrangian: M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u.

mod dual;
mod equation;
mod lagrange;
mod reach2r;
mod scalar;

pub use dual::Dual;
pub use equation::{Dynamics, DynamicsError, check_finite, solve_mass};
pub use lagrange::{
    Christoffel, FromLagrangian, Lagrangian, christoffel, christoffel_by_differences, mass_derivatives,
    mass_rate, skew_symmetry_defect,
};
pub use reach2r::Reach2R;
pub use scalar::Scalar;
