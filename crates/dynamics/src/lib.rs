//! Robot dynamics from the Lagrangian: M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u.

// What a formula is written over.
mod dual;
mod scalar;

// The equation of motion and the recipe that yields its terms.
mod actuation;
mod body_jacobian;
mod equation;
mod lagrange;

// The laws every model must obey, and the seeded states to check them at.
pub mod laws;
mod random;

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
mod euler_body;
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

pub use actuation::{PlanarKinematics, actuator_velocity, generalized_force};
pub use body_jacobian::{BodyJacobian, gravity_from_bodies, mass_from_bodies, potential_from_bodies};
pub use constraint::{
    ConstrainedStep, ConstraintError, ConstraintProjections, DependentRow, FromRows, Pfaffian, PfaffianOver,
    RowFactor, Stabilized, constrained_forward_dynamics, constrained_forward_dynamics_by_lu,
    constrained_rk4_step, reduced_acceleration,
};
pub use control::{HoldReport, HoldRun, PdHold, REACH_TORQUE_LIMITS, hold};
pub use dual::Dual;
pub use equation::{Dynamics, DynamicsError, check_finite, solve_mass};
pub use euler_body::{Attitude, RotationError, cayley_body_step, euler_body_step};
pub use free_body_exact::{FreeRotation, complete_elliptic_k, incomplete_elliptic_f, jacobi_sn_cn_dn};
pub use inertia::{
    InertiaError, MassProperties, PrincipalInertia, RotationalInertia, parallel_axis, parallel_axis_planar,
};
pub use inertia_ellipse::{InertiaEllipse, symmetric_eigen};
pub use integrate::{
    EnergyLedger, EnergyRun, Integrator, IntegratorError, State, Symplectic, energy_drift, energy_run,
    explicit_euler_step, rk4_step, semi_implicit_euler_step, variational_midpoint_step,
    variational_yoshida4_step,
};
pub use knife_edge::KnifeEdge;
pub use lagrange::{
    Christoffel, FromLagrangian, Lagrangian, christoffel, christoffel_by_differences, mass_derivatives,
    mass_rate, skew_symmetry_defect,
};
pub use linearize::{Linearization, linearize, linearize_by_differences};
pub use path::{
    FourierLoop, Path, PathDynamics, PathPoint, REACH_REPLAY_SPEED, fastest_constant_speed, peak_torque,
    reach_replay,
};
pub use planar_arm::{Link, PlanarArm, Reach3R};
pub use planar_body::PlanarBody;
pub use polar_mass::PolarMass;
pub use random::SplitMix64;
pub use reach2r::Reach2R;
pub use rigid_body::{euler_in_body, euler_in_principal_axes, euler_in_world};
pub use rp_arm::RpArm;
pub use scalar::Scalar;
