//! Vector-Jacobian products of the recursions: λᵀ ∂τ/∂q and its kin in O(n), without the Jacobian.
//!
//! τ = ID(q, v, a) and one cotangent λ, nv numbers: what is wanted is the gradient of the one number λᵀτ. In the inertial
//! frame of [`screws`](crate::stages::screws) freedom i has τᵢ = Sᵢᵀ Σ F over the bodies that it carries, so that
//!
//! λᵀτ = Σ_b L_b·F_b, L_b = Σ Sᵢ λᵢ over the freedoms i that carry body b:
//!
//! L is the velocity that the bodies would have if λ were v (λᵀτ is the power of that motion). Of the
//! [derivatives](crate::derivatives) of a body's force F = I A + V ×\* I V by a freedom j that carries it,
//!
//! ∂F/∂q_j = S_j ×\* F + I ψ′_j + 2B ψ_j, ∂F/∂v_j = I (Ṡ_j + ψ_j) + 2B S_j, ∂F/∂a_j = I S_j,
//! ψ_j = V_p × S_j, ψ′_j = A_p × S_j + V_p × ψ_j, Ṡ_j = V × S_j,
//!
//! with the parent p of j's body, whose own velocity is V. The turn S_j ×\* F is seen by the freedoms on the way to the root
//! alone, as those of j's own body and beyond turn with it. So three sums over j's body and all beyond it are enough, the
//! cotangents that flow from the leaves to the root,
//!
//! P = Σ I L, D = Σ 2Bᵀ L, F = Σ F, where 2Bᵀ L = V ×\* I L − I (V × L) − L ×\* I V
//!
//! follows from 2B S = V ×\* I S − I (V × S) + S ×\* I V by X·(V × S) = −(V ×\* X)·S. With the same rule each product with a
//! ψ becomes one with S_j:
//!
//! ∂(λᵀτ)/∂q_j = S_j·(V_p ×\* (V_p ×\* P − D) − A_p ×\* P − L_p ×\* F),
//! ∂(λᵀτ)/∂v_j = S_j·(D − (V + V_p) ×\* P),
//! ∂(λᵀτ)/∂a_j = S_j·P: the vector M λ.
//!
//! Armature, springs and followers are added to the tree's freedoms as in the recursions. For a spherical or floating
//! joint ∂/∂q_j is the rate along q ⊕ δ eⱼ; [`cotangent_to_coordinates`](crate::cotangent_to_coordinates) says what that is
//! in the numbers of q.
//!
//! Forward dynamics a = FD(q, v, τ) solves ID(q, v, a) = τ. For a cotangent ā of a let M λ = ā; then
//!
//! āᵀ∂a/∂q = −λᵀ ∂ID/∂q, āᵀ∂a/∂v = −λᵀ ∂ID/∂v, āᵀ∂a/∂τ = λᵀ, at the acceleration that was computed.
//!
//! The articulated bodies that gave a give λ by one more sweep with their pivots, and L with it.
//!
//! Sources: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 3.2 and 15 (reverse mode, implicit functions); the
//! derivatives of forces as in [`derivatives`](crate::derivatives).

mod dissipation;
mod forward_dynamics;
mod inverse_dynamics;
mod parameter_values;
mod parameters;
mod sweeps;

pub use dissipation::dissipation_pullback;
pub(crate) use dissipation::pull_dissipation;
#[cfg(feature = "batch")]
pub(crate) use forward_dynamics::{ArticulatedBodiesPullback, negate, solve_negative};
pub use forward_dynamics::{forward_dynamics_pullback, forward_dynamics_pullback_with_parameters};
#[cfg(feature = "batch")]
pub(crate) use inverse_dynamics::NewtonEulerPullback;
pub use inverse_dynamics::{inverse_dynamics_pullback, inverse_dynamics_pullback_with_parameters};
pub use parameter_values::{ParameterError, parameter_values, with_parameters};
pub(crate) use parameters::check_parameters;
pub use parameters::{PASSIVE_PARAMETERS_PER_JOINT, ParameterCotangents, parameter_count};
