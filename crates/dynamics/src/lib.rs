//! Robot dynamics from the Lagrangian.
//!
//! One symmetric positive definite matrix M(q) and one scalar V(q) determine the dynamics of an arm. The
//! kinetic energy is K = ½ q̇ᵀM(q) q̇, the potential energy V(q), and the motion follows from the two:
//!
//! > **M(q) q̈ + C(q,q̇) q̇ + g(q) + b(q,q̇) = u** **(PRM 10.7)**
//!
//! The velocity-product forces C q̇ are derivatives of M, and gravity g is the derivative of V. b dissipates
//! energy, and u are the forces of the motors.
//!
//! ```
//! use dynamics::{Dynamics, PlanarArm, Reach2R, laws, rk4_step};
//! use nalgebra::{Vector2, vector};
//! use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
//!
//! // Two rods of 1 m, 2 kg and 1 kg, in a vertical plane.
//! let arm = Reach2R::uniform(1.0, 2.0, 1.0, 1.0, 9.81);
//! let q = vector![FRAC_PI_4, FRAC_PI_2];
//!
//! // The torque g(q) holds the arm; joint 1 at 1 rad/s causes a force on joint 2.
//! assert!((arm.gravity(&q) - vector![10.4051, -3.4684]).norm() < 1e-4);
//! assert!((arm.velocity_product(&q, &vector![1.0, 0.0]) - vector![0.0, 0.5]).norm() < 1e-12);
//!
//! // The arm falls, and its energy is conserved.
//! let (mut position, mut velocity) = (q, Vector2::zeros());
//! let start = arm.energy(&position, &velocity);
//! for _ in 0..1000 {
//!     (position, velocity) = rk4_step(&arm, &position, &velocity, &Vector2::zeros(), 1e-3)?;
//! }
//! assert!(position[0] < 0.0);
//! assert!((arm.energy(&position, &velocity) - start).abs() < 1e-7 * start);
//!
//! // Every model obeys the same laws, which one call checks.
//! laws::check_all("Reach3R", &PlanarArm::reach_3r(), &laws::States::new(1))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Overview, in the order of dependence
//!
//! | subject | equation | items |
//! | --- | --- | --- |
//! | scalar types of formulas; exact derivatives | f(x + ε) = f(x) + f′(x) ε, ε² = 0 | [`Scalar`], [`Dual`] |
//! | a system, forwards and backwards | q̈ = M⁻¹(u − C q̇ − g − b) | [`Dynamics`] |
//! | Christoffel symbols | Γⁱⱼₖ = ½(∂M_ij/∂qₖ + ∂M_ik/∂qⱼ − ∂M_jk/∂qᵢ) | [`Lagrangian`], [`christoffel`], [`christoffel_by_differences`] |
//! | the Coriolis matrix and its skew property | C_ij = Σₖ Γⁱⱼₖ q̇ₖ, Ṁ − 2C skew | [`Christoffel::coriolis_matrix`], [`skew_symmetry_defect`] |
//! | M, V, g from the bodies of a mechanism | M = Σ (m J_cᵀJ_c + I J_ωᵀJ_ω) | [`BodyJacobian`], [`mass_from_bodies`] |
//! | actuation | u = T(q) f, T = Jᵀ for a force at a point | [`generalized_force`], [`PlanarKinematics`] |
//! | laws of every model | dE/dt = u·q̇ − b·q̇ and others | [`laws`] |
//! | models | | [`Reach2R`], [`PlanarArm`], [`RpArm`], [`PolarMass`], [`PlanarBody`], [`KnifeEdge`] |
//! | constraints on velocities | A(q) q̇ = 0, M q̈ + … = u + Aᵀλ | [`constrained_forward_dynamics`], [`ConstraintProjections`] |
//! | rotation of a rigid body | 𝓘ω̇ + ω × 𝓘ω = τ | [`RotationalInertia`], [`euler_in_body`], [`euler_body_step`] |
//! | motion in time | (q, q̇) → (q, q̇) after h seconds | [`Integrator`], [`rk4_step`], [`energy_drift`] |
//! | control | τ = g(q\*) + Kp(q\*−q) − Kd q̇ | [`PdHold`], [`linearize`], [`InertiaEllipse`] |
//! | time parameterisation of a path | a(s) s̈ + b(s) ṡ² + c(s) = τ | [`PathDynamics`] |
//! | the two-link arm at one pose, every number | | [`WorkedExample`] |
//!
//! # Conventions
//!
//! Coordinates are in rad or m, so forces are in N·m or N; energies are in J. Angles are counter-clockwise
//! from the horizontal x axis, y points up, gravity acts along −y. States are `nalgebra` vectors of fixed
//! size, `SVector<f64, N>`. Invalid data (a NaN, a singular M) are an error that names the quantity and the
//! entry; an invalid call panics.
//!
//! # Sources
//!
//! - **PRM** Choset et al., *Principles of Robot Motion* (2005)
//! - **MLS** Murray, Li, Sastry, *A Mathematical Introduction to Robotic Manipulation* (1994)
//! - **MR** Lynch, Park, *Modern Robotics* (2017)
//! - **RBDA** Featherstone, *Rigid Body Dynamics Algorithms* (2008)
//! - **HLW** Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006)

// The equation of motion,
mod equation;

// the recipe for its terms, and the forces that drive it.
mod actuation;
mod body_jacobian;
mod lagrange;

// The laws that every model must obey.
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
mod euler_body;
mod exact_free_body;
mod rigid_body;

// Motion in time.
mod integration;

// Control.
mod control;
mod inertia_ellipse;
mod linearization;
mod path;

// The two-link arm at one pose, every number.
mod worked_example;

pub use actuation::{PlanarKinematics, actuator_velocity, generalized_force};
pub use body_jacobian::{BodyJacobian, gravity_from_bodies, mass_from_bodies, potential_from_bodies};
pub use constraint::{
    ConstrainedStep, ConstraintError, ConstraintProjections, DependentRow, FromRows, Pfaffian, PfaffianOver,
    RowFactor, StabilizedConstraint, constrained_forward_dynamics, constrained_forward_dynamics_by_lu,
    constrained_rk4_step, reduced_acceleration,
};
pub use control::{HoldReport, HoldRun, PdHold, REACH_TORQUE_LIMITS, hold};
pub use equation::{Dynamics, solve_mass};
pub use euler_body::{Attitude, cayley_body_step, euler_body_step};
pub use exact_free_body::{FreeRotation, complete_elliptic_k, incomplete_elliptic_f, jacobi_sn_cn_dn};
pub use inertia_ellipse::{InertiaEllipse, symmetric_eigen};
pub use integration::{
    EnergyRun, State, SystemEnergy, SystemStep, energy_drift, energy_run, explicit_euler_step, rk4_step,
    semi_implicit_euler_step, variational_midpoint_step, variational_yoshida4_step,
};
pub use knife_edge::KnifeEdge;
pub use lagrange::{
    Christoffel, FromLagrangian, Lagrangian, christoffel, christoffel_by_differences, mass_derivatives,
    mass_rate, skew_symmetry_defect,
};
pub use linearization::{Linearization, linearize, linearize_by_differences};
pub use path::{
    FourierLoop, Path, PathDynamics, PathPoint, REACH_REPLAY_SPEED, fastest_constant_speed, peak_torque,
    reach_replay,
};
pub use planar_arm::{Link, PlanarArm, Reach3R};
pub use planar_body::PlanarBody;
pub use polar_mass::PolarMass;
pub use reach2r::Reach2R;
pub use rigid_body::{euler_in_body, euler_in_principal_axes, euler_in_world};
pub use robot_dynamics_description::{
    InertiaError, MassProperties, PrincipalInertia, RotationalInertia, parallel_axis, parallel_axis_planar,
    six_digits,
};
pub use robot_dynamics_integrators::{
    EnergyAccount, Integrator, IntegratorError, Stage, StepScheme, Symplectic, energy_scale,
};
pub use rp_arm::RpArm;
pub use worked_example::WorkedExample;

// The scalar types of formulas, their exact derivatives, and the seeded generator of test states.
pub use robot_dynamics_number::{Dual, Scalar, SplitMix64};

#[cfg(feature = "trees")]
mod trees;
#[cfg(feature = "trees")]
pub use trees::{FixedSize, FixedSizeError};
