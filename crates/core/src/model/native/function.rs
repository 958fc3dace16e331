//! The functions that machine code may compute, and their expressions.

#[cfg(feature = "native")]
use robot_dynamics_expression::{Graph, Operand};
use robot_dynamics_integrators::Integrator;

use crate::{FrameId, ReferenceFrame};

/// A function that may be computed by machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NativeFunction {
    /// τ = M a + C v + g.
    InverseDynamics,
    /// C v + g.
    Bias,
    /// g(q), springs included.
    Gravity,
    /// C v.
    VelocityProduct,
    /// a = M⁻¹(τ − C v − g).
    ForwardDynamics,
    /// M(q).
    MassMatrix,
    /// The entries of M(q) on and above the diagonal that are not always zero.
    MassMatrixRelated,
    /// M(q)⁻¹.
    InverseMassMatrix,
    /// C(q, v), from the Christoffel symbols.
    CoriolisMatrix,
    /// p = M v.
    Momentum,
    /// K(q, v).
    KineticEnergy,
    /// V(q).
    PotentialEnergy,
    /// K(q, v) and V(q).
    Energies,
    /// 1/d of each DoF, the reciprocal pivots of the articulated-body algorithm.
    InversePivots,
    /// The centre of mass of the moving bodies in the world.
    CenterOfMass,
    /// J with ċ = J v.
    CenterOfMassJacobian,
    /// A_G with h_G = A_G v.
    CentroidalMomentumMatrix,
    /// ∂g/∂q.
    GravityDerivative,
    /// `world_from_frame` of all frames, only in batches.
    FramePoses,
    /// `world_from_frame` of a frame.
    FramePose,
    /// A frame's Jacobian in [`ReferenceFrame::LocalWorldAligned`].
    #[doc(alias = "FrameJacobianWorldAligned")]
    FrameJacobianLocalWorldAligned,
    /// A frame's Jacobian in [`ReferenceFrame::Local`].
    #[doc(alias = "FrameJacobianInFrame")]
    FrameJacobianLocal,
    /// A frame's Jacobian in [`ReferenceFrame::World`].
    #[doc(alias = "FrameJacobianInWorld")]
    FrameJacobianWorld,
    /// ∂τ/∂q, ∂τ/∂v.
    InverseDynamicsDerivatives,
    /// ∂a/∂q, ∂a/∂v, ∂a/∂τ.
    ForwardDynamicsDerivatives,
    /// λᵀ∂τ/∂q, λᵀ∂τ/∂v, λᵀ∂τ/∂a.
    InverseDynamicsPullback,
    /// a, λᵀ∂a/∂q, λᵀ∂a/∂v, λᵀ∂a/∂τ.
    ForwardDynamicsPullback,
    /// L and D of M = LᵀDL.
    MassMatrixFactor,
    /// A step of semi-implicit Euler with constant τ, and with damping and friction from its start.
    SemiImplicitEulerStep,
    /// A step of semi-implicit Euler without damping and friction.
    ConservativeSemiImplicitEulerStep,
    /// A step of the classical Runge–Kutta method with constant τ, and with damping and friction at each
    /// stage.
    Rk4Step,
    /// A step of the classical Runge–Kutta method without damping and friction.
    ConservativeRk4Step,
    /// The pullback of a step of semi-implicit Euler: from the cotangents of its end to those of q, v and τ.
    SemiImplicitEulerStepPullback,
    /// The same without damping and friction.
    ConservativeSemiImplicitEulerStepPullback,
    /// The pullback of a step of the classical Runge–Kutta method.
    Rk4StepPullback,
    /// The same without damping and friction.
    ConservativeRk4StepPullback,
}

impl NativeFunction {
    /// All functions.
    pub const ALL: [Self; 36] = [
        Self::InverseDynamics,
        Self::Bias,
        Self::Gravity,
        Self::VelocityProduct,
        Self::ForwardDynamics,
        Self::MassMatrix,
        Self::MassMatrixRelated,
        Self::InverseMassMatrix,
        Self::CoriolisMatrix,
        Self::Momentum,
        Self::KineticEnergy,
        Self::PotentialEnergy,
        Self::Energies,
        Self::InversePivots,
        Self::CenterOfMass,
        Self::CenterOfMassJacobian,
        Self::CentroidalMomentumMatrix,
        Self::GravityDerivative,
        Self::FramePoses,
        Self::FramePose,
        Self::FrameJacobianLocalWorldAligned,
        Self::FrameJacobianLocal,
        Self::FrameJacobianWorld,
        Self::InverseDynamicsDerivatives,
        Self::ForwardDynamicsDerivatives,
        Self::InverseDynamicsPullback,
        Self::ForwardDynamicsPullback,
        Self::MassMatrixFactor,
        Self::SemiImplicitEulerStep,
        Self::ConservativeSemiImplicitEulerStep,
        Self::Rk4Step,
        Self::ConservativeRk4Step,
        Self::SemiImplicitEulerStepPullback,
        Self::ConservativeSemiImplicitEulerStepPullback,
        Self::Rk4StepPullback,
        Self::ConservativeRk4StepPullback,
    ];

    /// The functions of one frame. Each has separate code for each frame.
    pub const OF_FRAMES: [Self; 4] = [
        Self::FramePose,
        Self::FrameJacobianLocalWorldAligned,
        Self::FrameJacobianLocal,
        Self::FrameJacobianWorld,
    ];

    /// The name of the library's function. That of a frame's Jacobian ends with
    /// [`ReferenceFrame::name`].
    ///
    /// ```
    /// assert_eq!(robot_dynamics::model::NativeFunction::MassMatrix.name(), "mass_matrix");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::InverseDynamics => "inverse_dynamics",
            Self::Bias => "bias",
            Self::Gravity => "gravity",
            Self::VelocityProduct => "velocity_product",
            Self::ForwardDynamics => "forward_dynamics",
            Self::MassMatrix => "mass_matrix",
            Self::MassMatrixRelated => "mass_matrix_related",
            Self::InverseMassMatrix => "inverse_mass_matrix",
            Self::CoriolisMatrix => "coriolis_matrix",
            Self::Momentum => "momentum",
            Self::KineticEnergy => "kinetic_energy",
            Self::PotentialEnergy => "potential_energy",
            Self::Energies => "energies",
            Self::InversePivots => "inverse_pivots",
            Self::CenterOfMass => "center_of_mass",
            Self::CenterOfMassJacobian => "center_of_mass_jacobian",
            Self::CentroidalMomentumMatrix => "centroidal_momentum_matrix",
            Self::GravityDerivative => "gravity_derivative",
            Self::FramePoses => "frame_poses",
            Self::FramePose => "frame_pose",
            Self::FrameJacobianLocalWorldAligned => "frame_jacobian_local_world_aligned",
            Self::FrameJacobianLocal => "frame_jacobian_local",
            Self::FrameJacobianWorld => "frame_jacobian_world",
            Self::InverseDynamicsDerivatives => "inverse_dynamics_derivatives",
            Self::ForwardDynamicsDerivatives => "forward_dynamics_derivatives",
            Self::InverseDynamicsPullback => "inverse_dynamics_pullback",
            Self::ForwardDynamicsPullback => "forward_dynamics_pullback",
            Self::MassMatrixFactor => "mass_matrix_factor",
            Self::SemiImplicitEulerStep => "semi_implicit_euler_step",
            Self::ConservativeSemiImplicitEulerStep => "conservative_semi_implicit_euler_step",
            Self::Rk4Step => "rk4_step",
            Self::ConservativeRk4Step => "conservative_rk4_step",
            Self::SemiImplicitEulerStepPullback => "semi_implicit_euler_step_pullback",
            Self::ConservativeSemiImplicitEulerStepPullback => {
                "conservative_semi_implicit_euler_step_pullback"
            }
            Self::Rk4StepPullback => "rk4_step_pullback",
            Self::ConservativeRk4StepPullback => "conservative_rk4_step_pullback",
        }
    }

    /// The function of a frame's Jacobian.
    pub fn frame_jacobian(reference_frame: ReferenceFrame) -> Self {
        match reference_frame {
            ReferenceFrame::Local => Self::FrameJacobianLocal,
            ReferenceFrame::World => Self::FrameJacobianWorld,
            ReferenceFrame::LocalWorldAligned => Self::FrameJacobianLocalWorldAligned,
        }
    }

    /// The function of a step of this method, with or without damping and friction.
    pub fn step(row: Integrator, dissipation: bool) -> Option<Self> {
        match (row, dissipation) {
            (Integrator::SemiImplicitEuler, true) => Some(Self::SemiImplicitEulerStep),
            (Integrator::SemiImplicitEuler, false) => Some(Self::ConservativeSemiImplicitEulerStep),
            (Integrator::RungeKutta4, true) => Some(Self::Rk4Step),
            (Integrator::RungeKutta4, false) => Some(Self::ConservativeRk4Step),
            _ => None,
        }
    }

    /// The pullback of a step of this method, with or without damping and friction.
    pub fn step_pullback(row: Integrator, dissipation: bool) -> Option<Self> {
        match (row, dissipation) {
            (Integrator::SemiImplicitEuler, true) => Some(Self::SemiImplicitEulerStepPullback),
            (Integrator::SemiImplicitEuler, false) => Some(Self::ConservativeSemiImplicitEulerStepPullback),
            (Integrator::RungeKutta4, true) => Some(Self::Rk4StepPullback),
            (Integrator::RungeKutta4, false) => Some(Self::ConservativeRk4StepPullback),
            _ => None,
        }
    }
}

/// A function of a model, with its frame if it is one of [`NativeFunction::OF_FRAMES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NativeTask {
    pub function: NativeFunction,
    pub frame: Option<FrameId>,
}

impl From<NativeFunction> for NativeTask {
    #[inline(always)]
    fn from(function: NativeFunction) -> Self {
        Self { function, frame: None }
    }
}

impl NativeFunction {
    /// This function for a frame.
    #[inline(always)]
    pub fn of_frame(self, frame: FrameId) -> NativeTask {
        NativeTask { function: self, frame: Some(frame) }
    }
}

/// A function of a model as an expression.
#[cfg(feature = "native")]
#[derive(Clone, Debug)]
pub struct NativeTrace {
    /// Its operations.
    pub graph: Graph,
    /// Its results, matrices by rows.
    pub results: Vec<Vec<Operand>>,
    /// The lengths of its arguments.
    pub lengths: Vec<usize>,
}
