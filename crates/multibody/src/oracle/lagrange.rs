//! The Lagrange recipe for any robot: slow, obvious, the oracle of the recursions.
//!
//! K = ½ vᵀM(q) v and V(q) determine the motion. Everything here works on the links and joints as the
//! description names them, in the file's own axes, fixed joints and all; of the compiled [`Model`](crate::Model) only the
//! places of the joints in q and v are used. Forward kinematics turns about any axis by Rodrigues' formula
//! and carries the Jacobians of every link along ([`link_kinematics`]); then
//!
//! M = Σ (m J_cᵀJ_c + J_ωᵀ R 𝓘 Rᵀ J_ω) + armature, V = −Σ m g·c + Σ ½ stiffness (q − rest)², **(PRM 10.6)**
//!
//! and every derivative of M and V is exact, by dual numbers: no step size, no recursion, no spatial algebra.
//!
//! # The equation of motion
//! Where q̇ = v it is Lagrange's, d/dt(M v) − ∂K/∂q + ∂V/∂q = τ. The v of a spherical or floating joint is the
//! child's velocity in its own axes, no derivative of any coordinates, so the equation is Euler and
//! Poincaré's (also Boltzmann and Hamel's): with Xᵢ the derivative along the motion that eᵢ causes
//! (q̇ = N(q) eᵢ) and p = M v,
//!
//! ṗᵢ − Xᵢ(K) + (ad term)ᵢ + Xᵢ(V) = τᵢ,
//!
//! where the ad term of such a joint with linear velocity u and angular velocity w is w × p_u in the rows
//! of u and w × p_w + u × p_u in the rows of w, and zero for all other joints. For a free rigid body these
//! are Newton's equation and Euler's equation (PRM 10.44) in the body frame.
//! Armature is left out of p there: what it adds is armature·v̇, by definition.
//! Source: Poincaré, *Sur une forme nouvelle des équations de la mécanique* (1901); MLS §4.2 for Lagrange's.
//!
//! # Cost
//! O(n) links times O(nv²) for M, that for every direction of differentiation: fit for tests and for
//! teaching. All matrices are row-major nv×nv, as in the rest of the crate.
//!
//! ```
//! use dynamics::SplitMix64;
//! use multibody::{Model, RandomRobotOptions, Workspace, lagrange, random_robot, random_state};
//! let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
//! let state = random_state(&model, &mut SplitMix64::new(1));
//! let oracle = lagrange::bias(&model, &state.q, &state.v);
//! let mut bias = vec![0.0; model.nv()];
//! multibody::bias(&model, &mut Workspace::new(&model), &state.q, &state.v, &mut bias);
//! assert!(bias.iter().zip(&oracle).all(|(a, b)| (a - b).abs() < 1e-11));
//! # Ok::<(), multibody::ModelError>(())
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
