//! The Lagrange recipe for any robot: a slow and simple reference for the recursions.
//!
//! K = ½ vᵀM(q) v and V(q) determine the motion. This module works on the links and joints of the
//! description, in the file's own axes, including fixed joints. From the compiled
//! [`Model`](robot_dynamics_core::Model) it uses only the indices of the joints in q and v. Forward
//! kinematics rotates about any axis by Rodrigues' formula and computes the Jacobians of every link
//! ([`link_kinematics`]). Then
//!
//! ```text
//! M = Σ (m J_cᵀJ_c + J_ωᵀ R 𝓘 Rᵀ J_ω) + armature,  V = −Σ m g·c + Σ ½ stiffness (q − rest)²,   (PRM 10.6)
//! ```
//!
//! and every derivative of M and V is exact by dual numbers, without step sizes, recursions or spatial
//! algebra.
//!
//! # The equation of motion
//! If q̇ = v it is Lagrange's equation, d/dt(M v) − ∂K/∂q + ∂V/∂q = τ. The v of a spherical or floating joint
//! is the child's velocity in its own axes, which is not the derivative of any coordinates. The equation is
//! then that of Euler and Poincaré (also of Boltzmann and Hamel). With Xᵢ the derivative along the motion of
//! eᵢ (q̇ = N(q) eᵢ) and p = M v,
//!
//! ```text
//! ṗᵢ − Xᵢ(K) + (ad term)ᵢ + Xᵢ(V) = τᵢ.
//! ```
//!
//! Let u be the linear and w the angular velocity of such a joint. Its ad term is w × p_u in the rows of u,
//! and w × p_w + u × p_u in the rows of w. It is zero for all other joints. For a free rigid body these are
//! Newton's equation and Euler's equation (PRM 10.44) in the body frame. p does not include armature, whose
//! force is armature·v̇ by definition. Source: Poincaré, *Sur une forme nouvelle des équations de la
//! mécanique* (1901); MLS §4.2 for Lagrange's equation.
//!
//! # Cost
//! O(n) links times O(nv²) for M, and that for every direction of differentiation: suitable for tests and
//! teaching. All matrices are row-major nv×nv, as in the rest of the crate.
//!
//! ```
//! use robot_dynamics::description::{RandomRobotOptions, random_robot};
//! use robot_dynamics::model::{Model, Workspace, random_state};
//! use robot_dynamics::number::SplitMix64;
//! use robot_dynamics::verification::lagrange;
//! let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
//! let state = random_state(&model, &mut SplitMix64::new(1));
//! let reference = lagrange::bias(&model, &state.q, &state.v);
//! let mut bias = vec![0.0; model.nv()];
//! robot_dynamics::algorithms::bias(&model, &mut Workspace::new(&model), &state.q, &state.v, &mut bias);
//! assert!(bias.iter().zip(&reference).all(|(a, b)| (a - b).abs() < 1e-11));
//! # Ok::<(), robot_dynamics::description::ModelError>(())
//! ```

mod algebra;
mod christoffel;
mod energies;
mod equation;
mod kinematics;

pub use christoffel::{Christoffel, christoffel, coriolis_matrix, mass_rate};
pub use energies::{kinetic_energy, mass_matrix, potential_energy};
pub use equation::{bias, forward_dynamics, gravity, inverse_dynamics, position_rate, velocity_product};
pub use kinematics::{LinkKinematics, link_kinematics};
