//! Inertias, and results of their elimination.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, Sym3, V3};

use crate::spatial::force::ForceVector;

/// The inertia of a rigid body or subtree: mass, first moment, inertia about the frame's origin.
#[derive(Clone, Copy, Debug)]
pub struct SpatialInertia<S: Scalar> {
    pub mass: S,
    pub first_moment: V3<S>,
    pub inertia: Sym3<S>,
}

/// Rates of mass transport of moving points p: ∫ ṗ dm and ∫ ṗ pᵀ dm.
#[derive(Clone, Copy, Debug)]
pub struct MassFlux<S: Scalar> {
    pub momentum: V3<S>,
    pub first_moment_rate: M3<S>,
}

/// An articulated-body inertia \[M H; Hᵀ I\] (linear first) with its bias force. **(RBDA §7.1)**
#[derive(Clone, Copy, Debug)]
pub struct ArticulatedInertia<S: Scalar> {
    pub mass: Sym3<S>,
    pub coupling: M3<S>,
    /// Hᵀ, for scalar types with `KEEPS_TRANSPOSE`.
    pub coupling_back: M3<S>,
    pub inertia: Sym3<S>,
    pub bias: ForceVector<S>,
}

/// The result of one DoF's elimination: U/d, u/d and 1/d with U = Iᴬ s, d = sᵀU, u = τ − sᵀpᴬ. **(RBDA eq.
/// 7.43–7.45)**
#[derive(Clone, Copy, Debug)]
pub struct DofElimination<S: Scalar> {
    pub column: ForceVector<S>,
    pub residual: S,
    pub inverse: S,
}
