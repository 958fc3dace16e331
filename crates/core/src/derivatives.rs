//! Derivatives of the recursions by configuration and velocity, in closed form.
//!
//! Work in the inertial frame of [`world_frame`](crate::kinematics::world_frame). Let j be a DoF of body b, whose
//! parent p has the velocity V_p and the acceleration A_p (A_p of the world is −gravity). A displacement
//! along j changes the motions and forces of the subtree by the cross product with S_j. The parts that the
//! parent imposes do not change. With
//!
//! ψ_j = V_p × S_j,  ψ′_j = A_p × S_j + V_p × ψ_j,
//!
//! ∂V/∂q_j = S_j × V + ψ_j, ∂A/∂q_j = S_j × A + ψ_j × V + ψ′_j. For the force F = I A + V ×\* I V of a body,
//!
//! ∂F/∂q_j = S_j ×\* F + I ψ′_j + 2B ψ_j,  ∂F/∂v_j = I (Ṡ_j + ψ_j) + 2B S_j,
//!
//! with the matrix B of [`coriolis`](crate::coriolis_matrix). The expressions are linear in I, B and F, so
//! the sums over a subtree serve every DoF on its way to the root. Cost: O(n depth).
//!
//! Sources: Singh, Russell, Wensing, *Efficient analytical derivatives of rigid-body dynamics using spatial
//! vector algebra*, IEEE Robotics and Automation Letters 7 (2022); Carpentier, Mansard, *Analytical
//! derivatives of rigid body dynamics algorithms*, RSS (2018).
//!
//! For a spherical or floating joint, ∂/∂q_j is the rate along q ⊕ δ e_j in the directions of v, with ⊕ of
//! [`integrate`](crate::integrate).

mod center_of_mass;
mod columns;
mod entries;
mod forward_dynamics;
mod frames;
mod gravity;
mod inverse_dynamics;
mod pullback;
mod second_order;
mod solve_rows;

pub use center_of_mass::center_of_mass_velocity_derivative;
pub use forward_dynamics::{
    ForwardDynamicsDerivativesKernel, ForwardDynamicsDerivativesMut, forward_dynamics_derivatives,
    forward_dynamics_derivatives_with_wrenches,
};
pub use frames::{
    FrameAccelerationDerivativesMut, FrameAccelerationInputs, frame_acceleration_derivatives,
    frame_velocity_derivative,
};
pub use gravity::gravity_derivative;
pub use inverse_dynamics::{
    InverseDynamicsDerivativesKernel, InverseDynamicsDerivativesMut, inverse_dynamics_derivatives,
    inverse_dynamics_derivatives_with_wrenches,
};
pub use pullback::{
    ArticulatedBodiesPullback, ForwardPullbackInputs, ForwardPullbackMut, InversePullbackInputs,
    InversePullbackMut, NewtonEulerPullback, PASSIVE_PARAMETERS_PER_JOINT, ParameterCotangents,
    check_parameters, dissipation_pullback, forward_dynamics_pullback,
    forward_dynamics_pullback_with_parameters, inverse_dynamics_pullback,
    inverse_dynamics_pullback_with_parameters, negate, parameter_count, parameter_values, pull_dissipation,
    solve_negative, with_parameters,
};
pub use second_order::{
    ForwardDirections, ForwardHessianProductMut, ForwardSecondDerivativesMut, FramePoseInputs,
    FrameVelocityHessianProductMut, FrameVelocityInputs, InverseDirections, InverseHessianProductMut,
    InverseSecondDerivativesMut, SecondOrderWorkspace, forward_dynamics_hessian,
    forward_dynamics_hessian_product, forward_dynamics_pullback_derivative,
    forward_dynamics_second_derivatives, frame_jacobian_derivative, frame_pose_hessian,
    frame_pose_hessian_product, frame_velocity_hessian, frame_velocity_hessian_product,
    inverse_dynamics_hessian, inverse_dynamics_hessian_product, inverse_dynamics_pullback_derivative,
    inverse_dynamics_second_derivatives,
};
