//! The names, arguments and results of the functions.

mod contact;
mod signature;
mod size;

use robot_dynamics_core::ReferenceFrame;
use robot_dynamics_integrators::Integrator;

pub(crate) use self::signature::ArgumentRow;
pub use self::signature::{Argument, FunctionResult};
pub(crate) use self::size::Size;

/// A function of a robot, with the library's name.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Function {
    /// τ = M a + C v + g.
    InverseDynamics,
    /// a = M⁻¹(τ − C v − g).
    ForwardDynamics,
    /// M(q).
    MassMatrix,
    /// The entries of M(q) on and above the diagonal that are not always zero, row by row.
    MassMatrixRelated,
    /// L and D of M = LᵀDL.
    MassMatrixFactor,
    /// M(q)⁻¹.
    InverseMassMatrix,
    /// C v + g.
    Bias,
    /// g(q), springs included.
    Gravity,
    /// C v.
    VelocityProduct,
    /// C(q, v) of the Christoffel symbols.
    CoriolisMatrix,
    /// Damping and friction.
    Dissipation,
    /// K(q, v).
    KineticEnergy,
    /// V(q).
    PotentialEnergy,
    /// p = M v.
    Momentum,
    /// The centre of mass in the world.
    CenterOfMass,
    /// The Jacobian of the centre of mass.
    CenterOfMassJacobian,
    /// ∂τ/∂q, ∂τ/∂v, ∂τ/∂a.
    InverseDynamicsDerivatives,
    /// ∂a/∂q, ∂a/∂v, ∂a/∂τ.
    ForwardDynamicsDerivatives,
    /// λᵀ∂τ/∂q, λᵀ∂τ/∂v, λᵀ∂τ/∂a.
    InverseDynamicsPullback,
    /// a, λᵀ∂a/∂q, λᵀ∂a/∂v, λᵀ∂a/∂τ.
    ForwardDynamicsPullback,
    /// Y(q, v, a) with Y π = τ.
    JointTorqueRegressor,
    /// One step of h: v₁ = v + h a(q, v, τ − b(v)), q₁ = q ⊕ h v₁.
    SemiImplicitEulerStep,
    /// One step of h by the classical Runge–Kutta method, with τ constant over it; damping and friction
    /// follow v.
    Rk4Step,
    /// A step with contact, stops and friction by this number of sweeps; see
    /// [`ContactStep`](robot_dynamics_simulation::ContactStep).
    ContactStep {
        /// The number of sweeps.
        sweeps: u16,
    },
    /// The first stage of a step with contact: its problem, and the velocity without multipliers.
    ContactProblem,
    /// The second stage of a step with contact: the velocity with multipliers.
    ContactStart,
    /// The repeated stage of a step with contact: one sweep.
    ContactSweep,
    /// The second stage and a sweep, whose fixed point is the solution of a problem.
    ContactFixedPoint,
    /// The last stage of a step with contact: the state after it.
    ContactEnd,
    /// `world_from_frame` of all frames.
    FramePoses,
    /// `world_from_frame` of a frame.
    FramePose(String),
    /// A frame's Jacobian.
    #[doc(alias = "FrameJacobianInFrame")]
    #[doc(alias = "FrameJacobianInWorld")]
    #[doc(alias = "FrameJacobianWorldAligned")]
    FrameJacobian(ReferenceFrame, String),
    /// ∂results/∂argument for each argument of another function. See [`Function::derivatives`].
    Derivatives(Box<Self>),
    /// λᵀ ∂results/∂argument for each argument of another function. See [`Function::pullback`].
    Pullback(Box<Self>),
}

/// The kind of derivative of another function that a function computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DerivativeKind {
    /// The derivatives of each result with respect to each argument.
    Derivatives,
    /// The gradient of a weighted sum of the results with respect to each argument.
    Pullback,
}

impl DerivativeKind {
    pub(crate) const ALL: [Self; 2] = [Self::Derivatives, Self::Pullback];

    /// The suffix of the function's name.
    pub(crate) fn suffix(self) -> &'static str {
        match self {
            Self::Derivatives => "_derivatives",
            Self::Pullback => "_pullback",
        }
    }
}

impl Function {
    /// All functions without a frame and without contact, without their derivatives and pullbacks.
    pub const PLAIN: [Self; 24] = [
        Self::InverseDynamics,
        Self::ForwardDynamics,
        Self::MassMatrix,
        Self::MassMatrixRelated,
        Self::MassMatrixFactor,
        Self::InverseMassMatrix,
        Self::Bias,
        Self::Gravity,
        Self::VelocityProduct,
        Self::CoriolisMatrix,
        Self::Dissipation,
        Self::KineticEnergy,
        Self::PotentialEnergy,
        Self::Momentum,
        Self::CenterOfMass,
        Self::CenterOfMassJacobian,
        Self::InverseDynamicsDerivatives,
        Self::ForwardDynamicsDerivatives,
        Self::InverseDynamicsPullback,
        Self::ForwardDynamicsPullback,
        Self::JointTorqueRegressor,
        Self::SemiImplicitEulerStep,
        Self::Rk4Step,
        Self::FramePoses,
    ];

    /// The names of the functions of one frame; each is followed by a colon and the frame's name.
    pub const OF_FRAMES: [&'static str; 4] =
        ["frame_pose", "frame_jacobian_local_world_aligned", "frame_jacobian_local", "frame_jacobian_world"];

    /// The functions of one frame, as [`OF_FRAMES`](Self::OF_FRAMES) names them.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert_eq!(Function::of_frame("hand")[0].to_string(), "frame_pose:hand");
    /// ```
    #[must_use]
    pub fn of_frame(frame: &str) -> [Self; 4] {
        let jacobian = |reference_frame| Self::FrameJacobian(reference_frame, frame.to_owned());
        [
            Self::FramePose(frame.to_owned()),
            jacobian(ReferenceFrame::LocalWorldAligned),
            jacobian(ReferenceFrame::Local),
            jacobian(ReferenceFrame::World),
        ]
    }

    /// Its derivatives: for each argument, a matrix by rows with a row for each number of the results, one
    /// result after the other. Derivatives with respect to q, and of a configuration, are along
    /// displacements, nv numbers, as in [`robot_dynamics_simulation::linearize_step`]. The length of a step
    /// is constant.
    ///
    /// The library's recursions compute those of inverse and forward dynamics. All others use the chain rule
    /// through the graph, forward or backward, or the recursions, whichever takes fewer operations.
    /// Derivatives and pullbacks have none themselves.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert_eq!(Function::InverseDynamics.derivatives(), Function::InverseDynamicsDerivatives);
    /// assert_eq!(Function::Gravity.derivatives().to_string(), "gravity_derivatives");
    /// ```
    #[must_use]
    pub fn derivatives(self) -> Self {
        match self {
            Self::InverseDynamics => Self::InverseDynamicsDerivatives,
            Self::ForwardDynamics => Self::ForwardDynamicsDerivatives,
            function => Self::Derivatives(Box::new(function)),
        }
    }

    /// Its vector-Jacobian products: for each argument, λᵀ times the matrix of
    /// [`derivatives`](Self::derivatives), which is not formed. λ is the last argument, with a number for
    /// each row.
    ///
    /// The library's recursions compute those of inverse and forward dynamics. All others use the chain rule
    /// backward through the graph: some two to four times the function's operations, for any number of
    /// results and arguments.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// let pose = Function::FramePose("hand".into()).pullback();
    /// assert_eq!(pose.to_string(), "frame_pose_pullback:hand");
    /// ```
    #[must_use]
    pub fn pullback(self) -> Self {
        match self {
            Self::InverseDynamics => Self::InverseDynamicsPullback,
            Self::ForwardDynamics => Self::ForwardDynamicsPullback,
            function => Self::Pullback(Box::new(function)),
        }
    }

    /// The function that is differentiated through the graph, and the kind of derivative.
    pub(crate) fn derivative_of(&self) -> Option<(&Self, DerivativeKind)> {
        match self {
            Self::Derivatives(function) => Some((function, DerivativeKind::Derivatives)),
            Self::Pullback(function) => Some((function, DerivativeKind::Pullback)),
            _ => None,
        }
    }

    /// Whether it has derivatives and pullbacks: it is not a derivative or pullback itself.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert!(Function::Gravity.is_differentiable() && !Function::Gravity.derivatives().is_differentiable());
    /// ```
    pub fn is_differentiable(&self) -> bool {
        !matches!(
            self,
            Self::InverseDynamicsDerivatives
                | Self::ForwardDynamicsDerivatives
                | Self::InverseDynamicsPullback
                | Self::ForwardDynamicsPullback
                | Self::Derivatives(_)
                | Self::Pullback(_)
        )
    }

    /// Whether it computes derivatives or a pullback through the graph of another function.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert!(Function::Gravity.derivatives().is_through_graph());
    /// assert!(!Function::InverseDynamics.derivatives().is_through_graph()); // the library's recursions
    /// ```
    pub fn is_through_graph(&self) -> bool {
        self.derivative_of().is_some()
    }

    /// The library's name, without the frame's.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert_eq!(Function::FramePose("hand".into()).stem(), "frame_pose");
    /// ```
    pub fn stem(&self) -> String {
        match self.derivative_of() {
            Some((function, kind)) => function.stem() + kind.suffix(),
            None => match self {
                Self::ContactStep { sweeps } if *sweeps != Self::CONTACT_SWEEPS => {
                    format!("{}_{sweeps}_sweeps", self.plain_stem())
                }
                _ => self.plain_stem().into(),
            },
        }
    }

    pub(crate) fn plain_stem(&self) -> &'static str {
        match self {
            Self::Derivatives(_) | Self::Pullback(_) => {
                unreachable!("the name is that of another function and a suffix")
            }
            Self::InverseDynamics => "inverse_dynamics",
            Self::ForwardDynamics => "forward_dynamics",
            Self::MassMatrix => "mass_matrix",
            Self::MassMatrixRelated => "mass_matrix_related",
            Self::MassMatrixFactor => "mass_matrix_factor",
            Self::InverseMassMatrix => "inverse_mass_matrix",
            Self::Bias => "bias",
            Self::Gravity => "gravity",
            Self::VelocityProduct => "velocity_product",
            Self::CoriolisMatrix => "coriolis_matrix",
            Self::Dissipation => "dissipation",
            Self::KineticEnergy => "kinetic_energy",
            Self::PotentialEnergy => "potential_energy",
            Self::Momentum => "momentum",
            Self::CenterOfMass => "center_of_mass",
            Self::CenterOfMassJacobian => "center_of_mass_jacobian",
            Self::InverseDynamicsDerivatives => "inverse_dynamics_derivatives",
            Self::ForwardDynamicsDerivatives => "forward_dynamics_derivatives",
            Self::InverseDynamicsPullback => "inverse_dynamics_pullback",
            Self::ForwardDynamicsPullback => "forward_dynamics_pullback",
            Self::JointTorqueRegressor => "joint_torque_regressor",
            Self::SemiImplicitEulerStep => "semi_implicit_euler_step",
            Self::Rk4Step => "rk4_step",
            Self::ContactStep { .. } => "contact_step",
            Self::ContactProblem => "contact_problem",
            Self::ContactStart => "contact_start",
            Self::ContactSweep => "contact_sweep",
            Self::ContactFixedPoint => "contact_fixed_point",
            Self::ContactEnd => "contact_end",
            Self::FramePoses => "frame_poses",
            Self::FramePose(_) => Self::OF_FRAMES[0],
            Self::FrameJacobian(ReferenceFrame::LocalWorldAligned, _) => Self::OF_FRAMES[1],
            Self::FrameJacobian(ReferenceFrame::Local, _) => Self::OF_FRAMES[2],
            Self::FrameJacobian(ReferenceFrame::World, _) => Self::OF_FRAMES[3],
        }
    }

    /// The name of its frame, if it has one.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert_eq!(Function::FramePose("hand".into()).frame(), Some("hand"));
    /// ```
    pub fn frame(&self) -> Option<&str> {
        match self {
            Self::FramePose(frame) | Self::FrameJacobian(_, frame) => Some(frame),
            Self::Derivatives(function) | Self::Pullback(function) => function.frame(),
            _ => None,
        }
    }

    /// Whether it inverts M, so that it is undefined where M is singular.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert!(Function::ForwardDynamics.inverts_mass() && !Function::MassMatrix.inverts_mass());
    /// ```
    pub fn inverts_mass(&self) -> bool {
        if let Some((function, _)) = self.derivative_of() {
            return function.inverts_mass();
        }
        matches!(
            self,
            Self::ForwardDynamics
                | Self::MassMatrixFactor
                | Self::InverseMassMatrix
                | Self::ForwardDynamicsDerivatives
                | Self::ForwardDynamicsPullback
                | Self::SemiImplicitEulerStep
                | Self::Rk4Step
                | Self::ContactStep { .. }
                | Self::ContactProblem
        )
    }

    /// Whether it depends on the equation of motion alone. Mass may then be regrouped to the body that it
    /// moves with ([`Model::regrouped`](robot_dynamics_core::Model::regrouped)), which takes fewer operations.
    pub(crate) fn is_of_equation_of_motion(&self) -> bool {
        matches!(
            self,
            Self::InverseDynamics
                | Self::ForwardDynamics
                | Self::MassMatrix
                | Self::MassMatrixRelated
                | Self::MassMatrixFactor
                | Self::InverseMassMatrix
                | Self::Bias
                | Self::Gravity
                | Self::VelocityProduct
                | Self::CoriolisMatrix
                | Self::InverseDynamicsDerivatives
                | Self::ForwardDynamicsDerivatives
                | Self::InverseDynamicsPullback
                | Self::ForwardDynamicsPullback
                | Self::SemiImplicitEulerStep
                | Self::Rk4Step
        )
    }

    /// The integrator of which it computes a step.
    ///
    /// ```
    /// use robot_dynamics::simulation::Integrator;
    /// use robot_dynamics_functions::Function;
    /// assert_eq!(Function::Rk4Step.integrator(), Some(Integrator::RungeKutta4));
    /// ```
    pub fn integrator(&self) -> Option<Integrator> {
        match self {
            Self::SemiImplicitEulerStep => Some(Integrator::SemiImplicitEuler),
            Self::Rk4Step => Some(Integrator::RungeKutta4),
            _ => None,
        }
    }
}
