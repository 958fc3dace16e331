//! The names, arguments and results of the functions.

mod signature;

use core::fmt;
use core::str::FromStr;

use dynamics::Integrator;

pub use self::signature::{Argument, Outcome};
pub(crate) use self::signature::{Row, Size};
use crate::FunctionError;

/// A function of a robot, as the library has it under the same name.
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
    /// One step of h by the classical Runge–Kutta method, τ held over it; damping and friction follow v.
    Rk4Step,
    /// `world_from_frame` of all frames.
    FramePoses,
    /// `world_from_frame` of a frame.
    FramePose(String),
    /// A frame's Jacobian along the world's axes.
    FrameJacobianWorldAligned(String),
    /// A frame's Jacobian along its own axes.
    FrameJacobianInFrame(String),
    /// The Jacobian of the point of a frame's body that passes the world's origin.
    FrameJacobianInWorld(String),
    /// ∂results/∂argument for each argument of another function. See [`Function::derivatives`].
    Derivatives(Box<Self>),
    /// λᵀ ∂results/∂argument for each argument of another function. See [`Function::pullback`].
    Pullback(Box<Self>),
}

/// The slopes of another function that a function computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slopes {
    /// Each result by each argument.
    Derivatives,
    /// A weighted sum of results by each argument.
    Pullback,
}

impl Slopes {
    const ALL: [Self; 2] = [Self::Derivatives, Self::Pullback];

    /// The end of the name.
    fn suffix(self) -> &'static str {
        match self {
            Self::Derivatives => "_derivatives",
            Self::Pullback => "_pullback",
        }
    }
}

impl Function {
    /// All that no frame belongs to, without the derivatives and pullbacks of them.
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

    /// The names of those of one frame; each takes the frame's name after a colon.
    pub const OF_FRAMES: [&'static str; 4] =
        ["frame_pose", "frame_jacobian_world_aligned", "frame_jacobian_in_frame", "frame_jacobian_in_world"];

    /// The functions of one frame, as [`OF_FRAMES`](Self::OF_FRAMES) names them.
    ///
    /// ```
    /// use functions::Function;
    /// assert_eq!(Function::of_frame("hand")[0].to_string(), "frame_pose:hand");
    /// ```
    #[must_use]
    pub fn of_frame(frame: &str) -> [Self; 4] {
        [
            Self::FramePose,
            Self::FrameJacobianWorldAligned,
            Self::FrameJacobianInFrame,
            Self::FrameJacobianInWorld,
        ]
        .map(|of| of(frame.to_owned()))
    }

    /// Its derivatives: for each argument a matrix with a row for each number of the results, matrices by rows, one result after the
    /// other. By q, and of a configuration, along displacements, nv numbers, as [`multibody::linearize_step`] has them; the length of a
    /// step is held.
    ///
    /// The library's recursions compute those of inverse and forward dynamics. All others come from the chain rule through the graph, forward
    /// or backward, or from the recursions, whichever is shorter. Derivatives and pullbacks have none.
    ///
    /// ```
    /// use functions::Function;
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

    /// Its vector-Jacobian products: for each argument λᵀ times the matrix of [`derivatives`](Self::derivatives), which is not formed; λ is the
    /// last argument, a number for each row.
    ///
    /// The library's recursions compute those of inverse and forward dynamics. All others come from the chain rule backward through the
    /// graph: some two to four times the function's operations, whatever its results and arguments.
    ///
    /// ```
    /// use functions::Function;
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

    /// The function whose slopes it gives, through the graph.
    pub(crate) fn slopes_of(&self) -> Option<(&Self, Slopes)> {
        match self {
            Self::Derivatives(function) => Some((function, Slopes::Derivatives)),
            Self::Pullback(function) => Some((function, Slopes::Pullback)),
            _ => None,
        }
    }

    /// Whether derivatives and pullbacks of it can be had: it gives none itself.
    ///
    /// ```
    /// use functions::Function;
    /// assert!(Function::Gravity.has_slopes() && !Function::Gravity.derivatives().has_slopes());
    /// ```
    pub fn has_slopes(&self) -> bool {
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

    /// Whether it gives derivatives or a pullback through the graph of another.
    ///
    /// ```
    /// use functions::Function;
    /// assert!(Function::Gravity.derivatives().is_through_graph());
    /// assert!(!Function::InverseDynamics.derivatives().is_through_graph()); // the library's recursions
    /// ```
    pub fn is_through_graph(&self) -> bool {
        self.slopes_of().is_some()
    }

    /// The library's name, without the frame's.
    ///
    /// ```
    /// use functions::Function;
    /// assert_eq!(Function::FramePose("hand".into()).stem(), "frame_pose");
    /// ```
    pub fn stem(&self) -> String {
        match self.slopes_of() {
            Some((function, slopes)) => function.stem() + slopes.suffix(),
            None => self.plain_stem().into(),
        }
    }

    fn plain_stem(&self) -> &'static str {
        match self {
            Self::Derivatives(_) | Self::Pullback(_) => unreachable!("named after another"),
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
            Self::FramePoses => "frame_poses",
            Self::FramePose(_) => Self::OF_FRAMES[0],
            Self::FrameJacobianWorldAligned(_) => Self::OF_FRAMES[1],
            Self::FrameJacobianInFrame(_) => Self::OF_FRAMES[2],
            Self::FrameJacobianInWorld(_) => Self::OF_FRAMES[3],
        }
    }

    /// The frame that it belongs to, if there is one.
    ///
    /// ```
    /// use functions::Function;
    /// assert_eq!(Function::FramePose("hand".into()).frame(), Some("hand"));
    /// ```
    pub fn frame(&self) -> Option<&str> {
        match self {
            Self::FramePose(frame)
            | Self::FrameJacobianWorldAligned(frame)
            | Self::FrameJacobianInFrame(frame)
            | Self::FrameJacobianInWorld(frame) => Some(frame),
            Self::Derivatives(function) | Self::Pullback(function) => function.frame(),
            _ => None,
        }
    }

    /// Whether it has no value where M is singular.
    ///
    /// ```
    /// use functions::Function;
    /// assert!(Function::ForwardDynamics.inverts_mass() && !Function::MassMatrix.inverts_mass());
    /// ```
    pub fn inverts_mass(&self) -> bool {
        if let Some((function, _)) = self.slopes_of() {
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
        )
    }

    /// Whether it depends on the equation of motion alone, so that mass may be counted with the body that it moves with
    /// ([`Model::regrouped`](multibody::Model::regrouped)), which leaves less to do.
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

    /// The row of the table of integrators whose step it is.
    ///
    /// ```
    /// use dynamics::Integrator;
    /// use functions::Function;
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

impl fmt::Display for Function {
    /// The library's name, and after a colon the frame's.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.stem())?;
        self.frame().map_or(Ok(()), |frame| write!(f, ":{frame}"))
    }
}

impl FromStr for Function {
    type Err = FunctionError;

    fn from_str(text: &str) -> Result<Self, FunctionError> {
        let unknown = || FunctionError::Unknown { name: text.into() };
        let (stem, frame) = text.split_once(':').map_or((text, None), |(stem, frame)| (stem, Some(frame)));
        let named = |stem: &str| match frame {
            None => Self::PLAIN.into_iter().find(|plain| plain.plain_stem() == stem),
            Some(frame) => Self::of_frame(frame).into_iter().find(|of_frame| of_frame.plain_stem() == stem),
        };
        if let Some(function) = named(stem) {
            return Ok(function);
        }
        let of_another = |slopes: Slopes| Some((named(stem.strip_suffix(slopes.suffix())?)?, slopes));
        match Slopes::ALL.into_iter().find_map(of_another) {
            None => Err(unknown()),
            Some((function, _)) if !function.has_slopes() => {
                Err(FunctionError::NoSlopes { function: text.into() })
            }
            Some((function, Slopes::Derivatives)) => Ok(function.derivatives()),
            Some((function, Slopes::Pullback)) => Ok(function.pullback()),
        }
    }
}
