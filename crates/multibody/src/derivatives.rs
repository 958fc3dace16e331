//! Derivatives of the recursions by configuration and velocity, in closed form.
//!
//! In the inertial frame of [`screws`](crate::stages::screws), moving along freedom j of body b, whose parent p moves
//! with V_p and accelerates with A_p (A_p of the world is −gravity), turns every motion and force of the bodies
//! beyond by S_j, and leaves behind what the parent imposes. With
//!
//! ψ_j = V_p × S_j,  ψ′_j = A_p × S_j + V_p × ψ_j,
//!
//! ∂V/∂q_j = S_j × V + ψ_j, ∂A/∂q_j = S_j × A + ψ_j × V + ψ′_j and, for the force F = I A + V ×\* I V of a body,
//!
//! ∂F/∂q_j = S_j ×\* F + I ψ′_j + 2B ψ_j,  ∂F/∂v_j = I (Ṡ_j + ψ_j) + 2B S_j,
//!
//! with the matrix B of [`coriolis`](crate::coriolis_matrix). All of it is linear in I, B and F, so that the
//! sums over the bodies beyond a joint serve every freedom on its way to the root. Cost: O(n depth).
//!
//! Sources: Singh, Russell, Wensing, *Efficient analytical derivatives of rigid-body dynamics using spatial
//! vector algebra*, IEEE Robotics and Automation Letters 7 (2022); Carpentier, Mansard, *Analytical
//! derivatives of rigid body dynamics algorithms*, RSS (2018).
//!
//! For a spherical or floating joint ∂/∂q_j is the rate along q ⊕ δ e_j, with [`integrate`](crate::integrate)'s
//! ⊕: the directions of v.

mod center_of_mass;
mod columns;
mod entries;
mod forward_dynamics;
mod frames;
mod gravity;
mod inverse_dynamics;
mod pullback;
mod solve_rows;

pub use center_of_mass::center_of_mass_velocity_derivative;
#[cfg(feature = "batch")]
pub(crate) use forward_dynamics::ForwardDynamicsSlopes;
pub use forward_dynamics::{forward_dynamics_derivatives, forward_dynamics_derivatives_with_wrenches};
pub use frames::{
    frame_acceleration_derivatives_in_frame, frame_acceleration_derivatives_world_aligned,
    frame_velocity_derivative_in_frame, frame_velocity_derivative_world_aligned,
};
pub use gravity::gravity_derivative;
#[cfg(feature = "batch")]
pub(crate) use inverse_dynamics::InverseDynamicsSlopes;
pub use inverse_dynamics::{inverse_dynamics_derivatives, inverse_dynamics_derivatives_with_wrenches};
#[cfg(feature = "batch")]
pub(crate) use pullback::{ArticulatedBodiesPullback, NewtonEulerPullback, negate, solve_negative};
pub use pullback::{
    PASSIVE_PARAMETERS_PER_JOINT, ParameterCotangents, ParameterError, dissipation_pullback,
    forward_dynamics_pullback, forward_dynamics_pullback_with_parameters, inverse_dynamics_pullback,
    inverse_dynamics_pullback_with_parameters, parameter_count, parameter_values, with_parameters,
};
pub(crate) use pullback::{check_parameters, pull_dissipation};
