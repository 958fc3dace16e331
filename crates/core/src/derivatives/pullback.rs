//! Pullbacks (vector-Jacobian products) of the recursions, such as λᵀ ∂τ/∂q, in O(n) without the Jacobian.
//!
//! Given τ = ID(q, v, a) and a cotangent λ of nv numbers, the pullback is the gradient of λᵀτ. In the
//! inertial frame of [`world_frame`](crate::kinematics::world_frame), DoF i has τᵢ = Sᵢᵀ Σ F over its subtree, so
//!
//! λᵀτ = Σ_b L_b·F_b, L_b = Σ Sᵢ λᵢ over the DoFs i from the root to body b:
//!
//! L is the velocity of the bodies if λ were v, and λᵀτ is the power of that motion. The
//! [derivatives](crate::derivatives) of a body's force F = I A + V ×\* I V by an ancestor's DoF j are
//!
//! ∂F/∂q_j = S_j ×\* F + I ψ′_j + 2B ψ_j, ∂F/∂v_j = I (Ṡ_j + ψ_j) + 2B S_j, ∂F/∂a_j = I S_j,
//! ψ_j = V_p × S_j, ψ′_j = A_p × S_j + V_p × ψ_j, Ṡ_j = V × S_j,
//!
//! where p is the parent of j's body and V that body's own velocity. The rotation S_j ×\* F affects only the
//! DoFs between j and the root, because those of j's body and its subtree rotate with it. So three sums over
//! the subtree of j are enough, the cotangents that flow from the leaves to the root,
//!
//! P = Σ I L, D = Σ 2Bᵀ L, F = Σ F, where 2Bᵀ L = V ×\* I L − I (V × L) − L ×\* I V
//!
//! follows from 2B S = V ×\* I S − I (V × S) + S ×\* I V and X·(V × S) = −(V ×\* X)·S. The same rule turns
//! each product with a ψ into one with S_j:
//!
//! ∂(λᵀτ)/∂q_j = S_j·(V_p ×\* (V_p ×\* P − D) − A_p ×\* P − L_p ×\* F),
//! ∂(λᵀτ)/∂v_j = S_j·(D − (V + V_p) ×\* P),
//! ∂(λᵀτ)/∂a_j = S_j·P: the vector M λ.
//!
//! Armature, springs and mimic joints are added to the tree's DoFs as in the recursions. For a spherical or
//! floating joint ∂/∂q_j is the rate along q ⊕ δ eⱼ;
//! [`cotangent_to_coordinates`](crate::cotangent_to_coordinates) converts it to the numbers of q.
//!
//! Forward dynamics a = FD(q, v, τ) solves ID(q, v, a) = τ. For a cotangent ā of a let M λ = ā; then
//!
//! āᵀ∂a/∂q = −λᵀ ∂ID/∂q, āᵀ∂a/∂v = −λᵀ ∂ID/∂v, āᵀ∂a/∂τ = λᵀ, at the acceleration that was computed.
//!
//! The articulated-body recursion for a gives λ, and L, by one more sweep with its pivots.
//!
//! Sources: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 3.2 and 15 (reverse mode, implicit
//! functions). The derivatives of forces have the sources of [`derivatives`](crate::derivatives).

mod dissipation;
mod forward_dynamics;
mod inverse_dynamics;
mod parameter_values;
mod parameters;
mod sweeps;

pub use dissipation::{dissipation_pullback, pull_dissipation};
pub use forward_dynamics::{
    ArticulatedBodiesPullback, ForwardPullbackInputs, ForwardPullbackMut, forward_dynamics_pullback,
    forward_dynamics_pullback_with_parameters, negate, solve_negative,
};
pub use inverse_dynamics::{
    InversePullbackInputs, InversePullbackMut, NewtonEulerPullback, inverse_dynamics_pullback,
    inverse_dynamics_pullback_with_parameters,
};
pub use parameter_values::{parameter_values, with_parameters};
pub use parameters::{PASSIVE_PARAMETERS_PER_JOINT, ParameterCotangents, check_parameters, parameter_count};
