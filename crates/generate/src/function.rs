//! What can be generated: the names, arguments and results of the functions.

use core::fmt;
use core::str::FromStr;

use dynamics::Integrator;
use multibody::Model;

use crate::GenerateError;

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
    /// `world_from_frame` of a frame.
    FramePose(String),
    /// A frame's Jacobian along the world's axes.
    FrameJacobianWorldAligned(String),
    /// A frame's Jacobian along its own axes.
    FrameJacobianInFrame(String),
}

/// What an argument or a result is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    Nq,
    Nv,
    One,
    Fixed(usize),
    /// Ten numbers for each moving link.
    Parameters,
    /// The entries of M on and above the diagonal that are not always zero.
    Related,
}

impl Size {
    pub(crate) fn of(self, model: &Model) -> usize {
        match self {
            Self::Nq => model.nq(),
            Self::Nv => model.nv(),
            Self::One => 1,
            Self::Fixed(count) => count,
            Self::Parameters => multibody::inertial_parameters(model).len(),
            Self::Related => multibody::mass_matrix_related_entries(model).len(),
        }
    }
}

/// An argument: its name, its size, its unit.
pub(crate) type Argument = (&'static str, Size, &'static str);

/// A result: its name, its rows and columns (row-major), what it is.
pub(crate) type Outcome = (&'static str, Size, Size, &'static str);

const Q: Argument = ("q", Size::Nq, "configuration [rad, m; quaternions x y z w]");
const V: Argument = ("v", Size::Nv, "velocity [rad/s, m/s]");
const A: Argument = ("a", Size::Nv, "acceleration [rad/s², m/s²]");
const TAU: Argument = ("tau", Size::Nv, "generalized force [N·m, N]");
const H: Argument = ("h", Size::One, "the step [s]");
const COTANGENT: Argument = ("cotangent", Size::Nv, "λ, what the result's changes are weighted with");

const fn vector(name: &'static str, what: &'static str) -> Outcome {
    (name, Size::Nv, Size::One, what)
}

const fn square(name: &'static str, what: &'static str) -> Outcome {
    (name, Size::Nv, Size::Nv, what)
}

impl Function {
    /// All that no frame belongs to.
    pub const PLAIN: [Self; 21] = [
        Self::InverseDynamics,
        Self::ForwardDynamics,
        Self::MassMatrix,
        Self::MassMatrixRelated,
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
        Self::InverseDynamicsDerivatives,
        Self::ForwardDynamicsDerivatives,
        Self::InverseDynamicsPullback,
        Self::ForwardDynamicsPullback,
        Self::JointTorqueRegressor,
        Self::SemiImplicitEulerStep,
        Self::Rk4Step,
    ];

    /// The names of those of frames; each takes a frame's name after a colon.
    pub const OF_FRAMES: [&'static str; 3] =
        ["frame_pose", "frame_jacobian_world_aligned", "frame_jacobian_in_frame"];

    /// The library's name, without the frame's.
    pub(crate) fn stem(&self) -> &'static str {
        match self {
            Self::InverseDynamics => "inverse_dynamics",
            Self::ForwardDynamics => "forward_dynamics",
            Self::MassMatrix => "mass_matrix",
            Self::MassMatrixRelated => "mass_matrix_related",
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
            Self::InverseDynamicsDerivatives => "inverse_dynamics_derivatives",
            Self::ForwardDynamicsDerivatives => "forward_dynamics_derivatives",
            Self::InverseDynamicsPullback => "inverse_dynamics_pullback",
            Self::ForwardDynamicsPullback => "forward_dynamics_pullback",
            Self::JointTorqueRegressor => "joint_torque_regressor",
            Self::SemiImplicitEulerStep => "semi_implicit_euler_step",
            Self::Rk4Step => "rk4_step",
            Self::FramePose(_) => Self::OF_FRAMES[0],
            Self::FrameJacobianWorldAligned(_) => Self::OF_FRAMES[1],
            Self::FrameJacobianInFrame(_) => Self::OF_FRAMES[2],
        }
    }

    /// The frame whose it is.
    pub(crate) fn frame(&self) -> Option<&str> {
        match self {
            Self::FramePose(frame)
            | Self::FrameJacobianWorldAligned(frame)
            | Self::FrameJacobianInFrame(frame) => Some(frame),
            _ => None,
        }
    }

    /// What it gives, as an equation.
    pub(crate) fn equation(&self) -> &'static str {
        match self {
            Self::InverseDynamics => "tau = M(q) a + C(q,v) v + g(q)",
            Self::ForwardDynamics => "a = M(q)^-1 (tau - C(q,v) v - g(q))",
            Self::MassMatrix => "M(q), symmetric",
            Self::MassMatrixRelated => {
                "the entries of M(q) on and above the diagonal that are not always zero"
            }
            Self::InverseMassMatrix => "M(q)^-1, symmetric",
            Self::Bias => "C(q,v) v + g(q)",
            Self::Gravity => "g(q), gravity and the joints' springs",
            Self::VelocityProduct => "C(q,v) v",
            Self::CoriolisMatrix => "C(q,v) by Christoffel symbols",
            Self::Dissipation => "b(v), the joints' damping and friction",
            Self::KineticEnergy => "K = 1/2 v^T M v",
            Self::PotentialEnergy => "V(q), gravity and the joints' springs",
            Self::Momentum => "p = M(q) v",
            Self::CenterOfMass => "the centre of mass in the world",
            Self::InverseDynamicsDerivatives => "the slopes of inverse_dynamics, by q as displacements",
            Self::ForwardDynamicsDerivatives => "the slopes of forward_dynamics, by q as displacements",
            Self::InverseDynamicsPullback => "gradients of lambda^T tau, by q as displacements",
            Self::ForwardDynamicsPullback => "gradients of lambda^T a, by q as displacements",
            Self::JointTorqueRegressor => "Y(q,v,a) with Y pi = tau",
            Self::SemiImplicitEulerStep => {
                "v_next = v + h a(q, v, tau - b(v)), q_next = q moved along h v_next; b damping and friction"
            }
            Self::Rk4Step => {
                "from (q, v) over h by the classical Runge-Kutta method, tau held; a(q, v, tau - b(v)), b damping and friction"
            }
            Self::FramePose(_) => "world_from_frame: x_world = R x_frame + p",
            Self::FrameJacobianWorldAligned(_) => {
                "J v = velocity of the frame's origin, angular velocity; world axes"
            }
            Self::FrameJacobianInFrame(_) => {
                "J v = velocity of the frame's origin, angular velocity; its own axes"
            }
        }
    }

    /// Whether it has no value where M is singular.
    pub(crate) fn inverts_mass(&self) -> bool {
        matches!(
            self,
            Self::ForwardDynamics
                | Self::InverseMassMatrix
                | Self::ForwardDynamicsDerivatives
                | Self::ForwardDynamicsPullback
                | Self::SemiImplicitEulerStep
                | Self::Rk4Step
        )
    }

    /// The row of the table of integrators whose step it is.
    pub(crate) fn integrator(&self) -> Option<Integrator> {
        match self {
            Self::SemiImplicitEulerStep => Some(Integrator::SemiImplicitEuler),
            Self::Rk4Step => Some(Integrator::RungeKutta4),
            _ => None,
        }
    }

    pub(crate) fn arguments(&self) -> &'static [Argument] {
        match self {
            Self::InverseDynamics | Self::InverseDynamicsDerivatives | Self::JointTorqueRegressor => {
                &[Q, V, A]
            }
            Self::ForwardDynamics | Self::ForwardDynamicsDerivatives => &[Q, V, TAU],
            Self::InverseDynamicsPullback => &[Q, V, A, COTANGENT],
            Self::ForwardDynamicsPullback => &[Q, V, TAU, COTANGENT],
            Self::SemiImplicitEulerStep | Self::Rk4Step => &[Q, V, TAU, H],
            Self::Bias
            | Self::VelocityProduct
            | Self::CoriolisMatrix
            | Self::KineticEnergy
            | Self::Momentum => &[Q, V],
            Self::Dissipation => &[V],
            Self::MassMatrix
            | Self::MassMatrixRelated
            | Self::InverseMassMatrix
            | Self::Gravity
            | Self::PotentialEnergy
            | Self::CenterOfMass
            | Self::FramePose(_)
            | Self::FrameJacobianWorldAligned(_)
            | Self::FrameJacobianInFrame(_) => &[Q],
        }
    }

    pub(crate) fn results(&self) -> &'static [Outcome] {
        const JACOBIAN: &[Outcome] = &[("jacobian", Size::Fixed(6), Size::Nv, "linear rows, then angular")];
        match self {
            Self::InverseDynamics => const { &[vector("tau", "generalized force [N·m, N]")] },
            Self::ForwardDynamics => const { &[vector("a", "acceleration [rad/s², m/s²]")] },
            Self::MassMatrix => const { &[square("mass", "[kg·m², kg·m, kg]")] },
            Self::MassMatrixRelated => {
                &[("related", Size::Related, Size::One, "row by row [kg·m², kg·m, kg]")]
            }
            Self::InverseMassMatrix => const { &[square("inverse", "[1/(kg·m²), 1/(kg·m), 1/kg]")] },
            Self::Bias => const { &[vector("bias", "[N·m, N]")] },
            Self::Gravity => const { &[vector("gravity", "[N·m, N]")] },
            Self::VelocityProduct => const { &[vector("product", "[N·m, N]")] },
            Self::CoriolisMatrix => const { &[square("coriolis", "[kg·m²/s, kg·m/s, kg/s]")] },
            Self::Dissipation => const { &[vector("dissipation", "[N·m, N]")] },
            Self::KineticEnergy => &[("kinetic", Size::One, Size::One, "[J]")],
            Self::PotentialEnergy => &[("potential", Size::One, Size::One, "[J]")],
            Self::Momentum => const { &[vector("momentum", "[kg·m²/s, kg·m/s]")] },
            Self::CenterOfMass => &[("center", Size::Fixed(3), Size::One, "[m]")],
            Self::InverseDynamicsDerivatives => {
                const {
                    &[
                        square("by_position", "d tau / d q"),
                        square("by_velocity", "d tau / d v"),
                        square("by_acceleration", "d tau / d a = M"),
                    ]
                }
            }
            Self::ForwardDynamicsDerivatives => {
                const {
                    &[
                        square("by_position", "d a / d q"),
                        square("by_velocity", "d a / d v"),
                        square("by_force", "d a / d tau = M^-1"),
                    ]
                }
            }
            Self::InverseDynamicsPullback => {
                const {
                    &[
                        vector("by_position", "lambda^T d tau / d q"),
                        vector("by_velocity", "lambda^T d tau / d v"),
                        vector("by_acceleration", "lambda^T d tau / d a"),
                    ]
                }
            }
            Self::ForwardDynamicsPullback => {
                const {
                    &[
                        vector("acceleration", "a [rad/s², m/s²]"),
                        vector("by_position", "lambda^T d a / d q"),
                        vector("by_velocity", "lambda^T d a / d v"),
                        vector("by_force", "lambda^T d a / d tau"),
                    ]
                }
            }
            Self::JointTorqueRegressor => &[(
                "regressor",
                Size::Nv,
                Size::Parameters,
                "columns: for each moving link m, h (3), I about its origin (xx xy yy xz yz zz)",
            )],
            Self::SemiImplicitEulerStep | Self::Rk4Step => {
                const {
                    &[
                        ("q_next", Size::Nq, Size::One, "after the step; quaternions of unit length"),
                        vector("v_next", "after the step"),
                    ]
                }
            }
            Self::FramePose(_) => &[
                ("rotation", Size::Fixed(3), Size::Fixed(3), "R, the frame's axes are its columns"),
                ("translation", Size::Fixed(3), Size::One, "p, the frame's origin [m]"),
            ],
            Self::FrameJacobianWorldAligned(_) | Self::FrameJacobianInFrame(_) => JACOBIAN,
        }
    }
}

impl fmt::Display for Function {
    /// The library's name, and after a colon the frame's.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.stem())?;
        self.frame().map_or(Ok(()), |frame| write!(f, ":{frame}"))
    }
}

impl FromStr for Function {
    type Err = GenerateError;

    fn from_str(text: &str) -> Result<Self, GenerateError> {
        let unknown = || GenerateError::UnknownFunction { name: text.into() };
        match text.split_once(':') {
            None => Self::PLAIN.into_iter().find(|plain| plain.stem() == text).ok_or_else(unknown),
            Some((stem, frame)) => {
                let frame = frame.to_owned();
                match Self::OF_FRAMES.iter().position(|&name| name == stem) {
                    Some(0) => Ok(Self::FramePose(frame)),
                    Some(1) => Ok(Self::FrameJacobianWorldAligned(frame)),
                    Some(_) => Ok(Self::FrameJacobianInFrame(frame)),
                    None => Err(unknown()),
                }
            }
        }
    }
}
