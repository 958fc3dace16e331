//! Derivatives of constrained motions by q, v and τ, and their pullbacks, in closed form.
//!
//! A constrained motion solves M a + C v + g = τ + Aᵀλ and A a = −Ȧv − 2γ A v − γ² φ. The differential of
//! both equations is a system with the same matrix, for each direction of q, v and τ:
//!
//! M δa − Aᵀδλ = δτ − δID + δ(Aᵀ)λ,  A δa = −δ(A a + Ȧv + 2γ A v + γ² φ),
//!
//! where δID and δ(A a + Ȧv) are changes at fixed a, and δ(Aᵀ)λ is one at fixed λ. The factors of M and of
//! the rows, which gave a and λ, solve it. A pullback needs one solution of the transposed system. It reads
//! uᵀδ(Aᵀ)λ as λᵀδ(A u), a derivative of velocities.
//!
//! Sources: Griewank, Walther, *Evaluating Derivatives* (2008), ch. 15 (implicit functions); Carpentier,
//! Budhiraja, Mansard, *Proximal and sparse resolution of constrained dynamic equations*, RSS (2021).
//!
//! **Dependent rows.** The derivatives are those along which the rank stays, as for a planar loop that is
//! closed in space. The acceleration is then smooth. With [`RedundantRows::Drop`](super::RedundantRows::Drop)
//! the multipliers of dropped rows are 0 with all their derivatives. With
//! [`RedundantRows::Proximal`](super::RedundantRows::Proximal) the derivatives are those of the shortest
//! multipliers. Where the rank changes, there are no derivatives.
//!
//! Columns of ∂/∂q are rates along q ⊕ δ eⱼ, as in `robot_dynamics_core`'s derivatives.

mod forward;
mod forward_pullback;
mod impulse;
mod inverse;
mod inverse_pullback;
mod shortest;
mod system;

pub use forward::{ConstrainedMotionDerivatives, constrained_forward_dynamics_derivatives};
pub use forward_pullback::{
    ConstrainedMotionPullback, ConstrainedPullbackInputs, constrained_forward_dynamics_pullback,
};
pub use impulse::{
    ContactImpulseDerivatives, ContactImpulsePullback, ImpulsePullbackInputs, contact_impulse_derivatives,
    contact_impulse_pullback,
};
pub use inverse::{ConstrainedTorqueDerivatives, constrained_inverse_dynamics_derivatives};
pub use inverse_pullback::{
    ConstrainedTorquePullback, ConstrainedTorquePullbackInputs, constrained_inverse_dynamics_pullback,
};
