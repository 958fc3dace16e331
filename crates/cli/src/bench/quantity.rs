//! What is measured of a robot.

/// A quantity of one state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    InverseDynamics,
    ForwardDynamics,
    MassMatrix,
    CoriolisMatrix,
    InverseMassMatrix,
    FramePoses,
    TipJacobian,
    InverseDynamicsDerivatives,
    ForwardDynamicsDerivatives,
}

impl Quantity {
    /// All that is computed of one state.
    pub(super) const SINGLE: [Self; 9] = [
        Self::InverseDynamics,
        Self::ForwardDynamics,
        Self::MassMatrix,
        Self::CoriolisMatrix,
        Self::InverseMassMatrix,
        Self::FramePoses,
        Self::TipJacobian,
        Self::InverseDynamicsDerivatives,
        Self::ForwardDynamicsDerivatives,
    ];

    /// All that is computed of batches.
    pub(super) const BATCH: [Self; 6] = [
        Self::InverseDynamics,
        Self::ForwardDynamics,
        Self::MassMatrix,
        Self::InverseMassMatrix,
        Self::FramePoses,
        Self::TipJacobian,
    ];

    /// The name in JSON, which is the library's.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::InverseDynamics => "inverse_dynamics",
            Self::ForwardDynamics => "forward_dynamics",
            Self::MassMatrix => "mass_matrix",
            Self::CoriolisMatrix => "coriolis_matrix",
            Self::InverseMassMatrix => "inverse_mass_matrix",
            Self::FramePoses => "frame_poses",
            Self::TipJacobian => "tip_jacobian",
            Self::InverseDynamicsDerivatives => "inverse_dynamics_derivatives",
            Self::ForwardDynamicsDerivatives => "forward_dynamics_derivatives",
        }
    }

    /// The name in a table.
    pub(super) fn shown(self) -> &'static str {
        match self {
            Self::InverseDynamics => "inverse dynamics τ(q,v,a)",
            Self::ForwardDynamics => "forward dynamics a(q,v,τ)",
            Self::MassMatrix => "mass matrix M(q)",
            Self::CoriolisMatrix => "Coriolis matrix C(q,v)",
            Self::InverseMassMatrix => "inverse mass matrix M⁻¹(q)",
            Self::FramePoses => "poses of all frames",
            Self::TipJacobian => "Jacobian of the tip",
            Self::InverseDynamicsDerivatives => "∂τ/∂q, ∂τ/∂v",
            Self::ForwardDynamicsDerivatives => "∂a/∂q, ∂a/∂v, ∂a/∂τ",
        }
    }
}
