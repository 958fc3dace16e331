//! Second derivatives: contracted with a multiplier, times a direction, and as tensors.
//!
//! f is τ(q, v, a), a(q, v, τ) or the motion of a frame, and x is a displacement of (q, v, a) or (q, v, τ).
//! In q it is that of [`integrate`](crate::integrate), q ⊕ x_q. The Hessian of λᵀf is
//!
//! H_αβ = ∂²/∂s∂t λᵀf(x ⊕ (s α + t β)) at s = t = 0.
//!
//! It is symmetric also for joints with quaternions, and λᵀf(x) = λᵀf + gᵀx + ½ xᵀH x + O(|x|³). With the
//! gradient g_β = D_β λᵀf, the derivative D_α g_β depends on the order of α and β for these joints. Their
//! displacements do not commute: exp(sα) exp(tβ) = exp(sα + tβ + ½ st \[α,β\] + …). So
//!
//! H_αβ = D_α g_β − ½ g·\[α,β\] = ½ (D_α g_β + D_β g_α)
//!
//! with the bracket of the joint's rotations or rigid motions; it is zero for all other joints.
//!
//! D_α g is the [pullback](crate::inverse_dynamics_pullback) over dual numbers, with four directions in one
//! call: O(n). The Hessian takes 2nv directions: τ is linear in a and a is linear in τ, so those blocks are
//! zero or follow from the others. The tensors are the derivatives of the
//! [first derivatives](crate::inverse_dynamics_derivatives) in the same way.
//!
//! Sources: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 5 (forward over reverse); Absil, Mahony,
//! Sepulchre, *Optimization Algorithms on Matrix Manifolds* (2008), §5.5 (Hessians along retractions). For
//! the same tensors in closed form: Singh, Russell, Wensing, *On second-order derivatives of rigid-body
//! dynamics* (2023).

mod contracted;
mod forward_dynamics;
mod frames;
mod inverse_dynamics;
mod lanes;
mod tensors;

pub use forward_dynamics::{
    ForwardDirections, ForwardHessianProductMut, ForwardSecondDerivativesMut, forward_dynamics_hessian,
    forward_dynamics_hessian_product, forward_dynamics_pullback_derivative,
    forward_dynamics_second_derivatives,
};
pub use frames::{
    FramePoseInputs, FrameVelocityHessianProductMut, FrameVelocityInputs, frame_jacobian_derivative,
    frame_pose_hessian, frame_pose_hessian_product, frame_velocity_hessian, frame_velocity_hessian_product,
};
pub use inverse_dynamics::{
    InverseDirections, InverseHessianProductMut, InverseSecondDerivativesMut, inverse_dynamics_hessian,
    inverse_dynamics_hessian_product, inverse_dynamics_pullback_derivative,
    inverse_dynamics_second_derivatives,
};
pub use lanes::SecondOrderWorkspace;
