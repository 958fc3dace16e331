//! Machine code in place of the recursions, compiled when a function is first called.
//!
//! A `Tracer` returns the expression of a model's function, and the crate `native` compiles it. The tracer
//! belongs to a crate that depends on this one.
//!
//! The model keeps the code, so the results of a function are reproducible bit for bit after the first call.
//! Copies of a model share it. A function keeps its recursion in three cases: its expression is too long, the
//! processor or system does not allow code, or machine code is switched off.

#[cfg(not(feature = "native"))]
mod absent;
#[cfg(feature = "native")]
mod kernels;
mod report;
#[cfg(feature = "native")]
mod size;

#[cfg(feature = "native")]
use robot_dynamics_expression::{Arithmetic, Graph, Operand};
use robot_dynamics_integrators::Integrator;

use crate::{FrameId, Model};

#[cfg(not(feature = "native"))]
pub(crate) use self::absent::Native;
#[cfg(feature = "native")]
pub(crate) use self::kernels::Native;
#[cfg(feature = "native")]
pub use self::kernels::Number;
pub use self::report::{NativeCode, NativeReport, NativeUse};

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
    /// A frame's Jacobian along the world's axes.
    FrameJacobianWorldAligned,
    /// A frame's Jacobian along its own axes.
    FrameJacobianInFrame,
    /// The Jacobian of the point of a frame's body that coincides with the world's origin, along the world's
    /// axes.
    FrameJacobianInWorld,
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
        Self::FrameJacobianWorldAligned,
        Self::FrameJacobianInFrame,
        Self::FrameJacobianInWorld,
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
        Self::FrameJacobianWorldAligned,
        Self::FrameJacobianInFrame,
        Self::FrameJacobianInWorld,
    ];

    /// The name of the library's function.
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
            Self::FrameJacobianWorldAligned => "frame_jacobian_world_aligned",
            Self::FrameJacobianInFrame => "frame_jacobian_in_frame",
            Self::FrameJacobianInWorld => "frame_jacobian_in_world",
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

/// Returns the expression of a model's function, or the reason for a missing one. The name is that of the
/// frame, for [`NativeFunction::OF_FRAMES`].
#[cfg(feature = "native")]
pub type Tracer = fn(&Model, NativeFunction, Option<&str>, Arithmetic) -> Result<NativeTrace, String>;

impl Model {
    /// This model with machine code, compiled from the tracer's expressions when a function is first called.
    /// The environment variable `ROBOT_DYNAMICS_NATIVE=0` disables it.
    ///
    /// ```
    /// use robot_dynamics::algorithms::mass_matrix;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::{Model, Workspace};
    /// let model = Model::new(pendulum(2.0, 0.5))?.with_tracer(|_, _, _, _| Err("not traced".into()));
    /// let mut mass = [0.0];
    /// mass_matrix(&model, &mut Workspace::new(&model), &[0.3], &mut mass); // by the recursion
    /// assert_eq!(mass, [0.5]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    #[cfg(feature = "native")]
    #[must_use]
    pub fn with_tracer(mut self, tracer: Tracer) -> Self {
        self.native = Native::new(tracer);
        self
    }

    /// This model with or without machine code. Without it the recursions compute everything, and results
    /// differ by rounding. A model without a tracer, such as one from [`Model::new`], never has machine code.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?.with_native(false);
    /// assert!(model.native().reason.is_some()); // the reason for the recursions
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    #[must_use]
    pub fn with_native(mut self, on: bool) -> Self {
        self.native.switch(on);
        self
    }

    /// A copy for changes: the machine code of this model would be wrong for it.
    pub fn without_native_code(&self) -> Self {
        Self { native: Native::default(), ..self.clone() }
    }

    /// This robot without damping and friction of its joints, to trace functions without them.
    #[doc(hidden)]
    #[must_use]
    pub fn without_dissipation(&self) -> Self {
        let mut model = self.without_native_code();
        for dof in &mut model.dofs {
            (dof.passive.damping, dof.passive.friction) = (0.0, 0.0);
        }
        model
    }

    /// The functions that machine code computes, and the reasons why recursions compute the others.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// println!("{}", model.native());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn native(&self) -> NativeReport {
        self.native.report(self)
    }
}
