//! Arguments and results of each function: names, shapes, units.

use robot_dynamics_core::{Model, ReferenceFrame};

use super::size::{Matrix, Size};
use super::{DerivativeKind, Function};

/// An argument: its name, its size, its unit.
pub(crate) type ArgumentRow = (&'static str, Size, &'static str);

/// An argument of a function of one robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument {
    /// Its name.
    pub name: &'static str,
    /// The count of its numbers.
    pub length: usize,
    /// Its unit.
    pub unit: &'static str,
}

/// A result of a function of one robot, a matrix by rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(alias = "Outcome")]
pub struct FunctionResult {
    /// Its name.
    pub name: &'static str,
    /// Its rows.
    pub rows: usize,
    /// Its columns, 1 for a vector.
    pub columns: usize,
    /// Its meaning and its unit.
    pub what: &'static str,
}

const Q: ArgumentRow = ("q", Size::Nq, "configuration [rad, m; quaternions x y z w]");
const V: ArgumentRow = ("v", Size::Nv, "velocity [rad/s, m/s]");
const A: ArgumentRow = ("a", Size::Nv, "acceleration [rad/s², m/s²]");
const TAU: ArgumentRow = ("tau", Size::Nv, "generalized force [N·m, N]");
const H: ArgumentRow = ("h", Size::One, "the step [s]");
const FRICTION: ArgumentRow = ("friction", Size::One, "coefficient of friction of the ground");
const IMPULSES: ArgumentRow =
    ("impulses", Size::Impulses, "multipliers that the sweeps start from [N·s; of joints N·m·s or N·s]");
const PROBLEM: ArgumentRow = ("problem", Size::Problem, "the table of contact_problem");
const SCALED: ArgumentRow = ("velocity", Size::Nv, "sqrt(D) L v, where M + h damping = L^T D L");
const COTANGENT: ArgumentRow = ("cotangent", Size::Nv, "λ, what the result's changes are weighted with");

const fn vector(name: &'static str, what: &'static str) -> Matrix {
    (name, Size::Nv, Size::One, what)
}

const fn square(name: &'static str, what: &'static str) -> Matrix {
    (name, Size::Nv, Size::Nv, what)
}

const INVERSE_DERIVATIVES: &[Matrix] = &[
    square("by_position", "d tau / d q"),
    square("by_velocity", "d tau / d v"),
    square("by_acceleration", "d tau / d a = M"),
];

const FORWARD_DERIVATIVES: &[Matrix] = &[
    square("by_position", "d a / d q"),
    square("by_velocity", "d a / d v"),
    square("by_force", "d a / d tau = M^-1"),
];

const INVERSE_PULLBACK: &[Matrix] = &[
    vector("by_position", "lambda^T d tau / d q"),
    vector("by_velocity", "lambda^T d tau / d v"),
    vector("by_acceleration", "lambda^T d tau / d a"),
];

const FORWARD_PULLBACK: &[Matrix] = &[
    vector("acceleration", "a [rad/s², m/s²]"),
    vector("by_position", "lambda^T d a / d q"),
    vector("by_velocity", "lambda^T d a / d v"),
    vector("by_force", "lambda^T d a / d tau"),
];

const NEXT_STATE: &[Matrix] = &[
    ("q_next", Size::Nq, Size::One, "after the step; quaternions of unit length"),
    vector("v_next", "after the step"),
];

const NEXT_IMPULSES: Matrix =
    ("impulses_next", Size::Impulses, Size::One, "of contacts along z, x, y [N·s]; of joints [N·m·s or N·s]");

const JACOBIAN: &[Matrix] = &[("jacobian", Size::Fixed(6), Size::Nv, "linear rows, then angular")];

impl Function {
    /// The equation of its results.
    ///
    /// ```
    /// use robot_dynamics_functions::Function;
    /// assert_eq!(Function::Bias.equation(), "C(q,v) v + g(q)");
    /// ```
    pub fn equation(&self) -> String {
        match self.derivative_of() {
            Some((function, DerivativeKind::Derivatives)) => {
                format!("the derivatives of {function}, along displacements of q")
            }
            Some((function, DerivativeKind::Pullback)) => {
                format!(
                    "gradients of the results of {function}, weighted with cotangents, along displacements of q"
                )
            }
            None => self.plain_equation().into(),
        }
    }

    fn plain_equation(&self) -> &'static str {
        match self {
            Self::Derivatives(_) | Self::Pullback(_) => unreachable!("the equation names another function"),
            Self::InverseDynamics => "tau = M(q) a + C(q,v) v + g(q)",
            Self::ForwardDynamics => "a = M(q)^-1 (tau - C(q,v) v - g(q))",
            Self::MassMatrix => "M(q), symmetric",
            Self::MassMatrixRelated => {
                "the entries of M(q) on and above the diagonal that are not always zero"
            }
            Self::MassMatrixFactor => {
                "L below the diagonal and D on it, M(q) = L^T D L with ones on L's diagonal"
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
            Self::CenterOfMassJacobian => "J v = velocity of the centre of mass; world axes",
            Self::InverseDynamicsDerivatives => "the derivatives of inverse_dynamics, by q as displacements",
            Self::ForwardDynamicsDerivatives => "the derivatives of forward_dynamics, by q as displacements",
            Self::InverseDynamicsPullback => "gradients of lambda^T tau, by q as displacements",
            Self::ForwardDynamicsPullback => "gradients of lambda^T a, by q as displacements",
            Self::JointTorqueRegressor => "Y(q,v,a) with Y pi = tau",
            Self::SemiImplicitEulerStep => {
                "v_next = v + h a(q, v, tau - b(v)), q_next = q moved along h v_next; b damping and friction"
            }
            Self::Rk4Step => {
                "from (q, v) over h by the classical Runge-Kutta method, tau held; a(q, v, tau - b(v)), b damping and friction"
            }
            Self::ContactStep { .. } => {
                "(M + h D)(v_next - v) = h (tau - C v - g - D v) + J^T p, q_next = q moved along h v_next; D damping, p of contacts, stops and friction by projected Gauss-Seidel sweeps"
            }
            Self::ContactProblem => {
                "the rows and bounds of a step with contact, and its velocity without multipliers"
            }
            Self::ContactStart => "velocity + (J L^-1 D^-1/2)^T impulses",
            Self::ContactSweep => "one projected Gauss-Seidel sweep of a step with contact",
            Self::ContactFixedPoint => "contact_start, and then contact_sweep",
            Self::ContactEnd => "v_next = L^-1 D^-1/2 velocity, q_next = q moved along h v_next",
            Self::FramePoses => "world_from_frame of all frames: x_world = R x_frame + p",
            Self::FramePose(_) => "world_from_frame: x_world = R x_frame + p",
            Self::FrameJacobian(ReferenceFrame::LocalWorldAligned, _) => {
                "J v = velocity of the frame's origin, angular velocity; world axes"
            }
            Self::FrameJacobian(ReferenceFrame::Local, _) => {
                "J v = velocity of the frame's origin, angular velocity; its own axes"
            }
            Self::FrameJacobian(ReferenceFrame::World, _) => {
                "J v = velocity of the body's point at the world's origin, angular velocity; world axes"
            }
        }
    }

    /// Its arguments for this robot, in order. Those of a pullback are those of the function and the weights
    /// of the results.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let names: Vec<_> = Function::Bias.arguments(&model).iter().map(|argument| argument.name).collect();
    /// assert_eq!(names, ["q", "v"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn arguments(&self, model: &Model) -> Vec<Argument> {
        let argument = |(name, size, unit): ArgumentRow| Argument { name, length: size.of(model), unit };
        self.rows_of_arguments().into_iter().map(argument).collect()
    }

    /// Its results for this robot, in order.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics_functions::Function;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mass = Function::MassMatrix.results(&model)[0];
    /// assert_eq!((mass.name, mass.rows, mass.columns), ("mass", 1, 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn results(&self, model: &Model) -> Vec<FunctionResult> {
        let outcome = |(name, rows, columns, what): Matrix| FunctionResult {
            name,
            rows: rows.of(model),
            columns: columns.of(model),
            what,
        };
        self.matrices().into_iter().map(outcome).collect()
    }

    pub(crate) fn rows_of_arguments(&self) -> Vec<ArgumentRow> {
        let Some((function, kind)) = self.derivative_of() else {
            return self.plain_arguments().to_vec();
        };
        let mut arguments = function.rows_of_arguments();
        if kind == DerivativeKind::Pullback {
            let (name, _, what) = COTANGENT;
            arguments.push((name, Size::of_all_changes(&function.matrices()), what));
        }
        arguments
    }

    /// The arguments to differentiate with respect to, and their indices: all except the length of a step and
    /// the multipliers that its sweeps start from.
    pub(crate) fn varied_arguments(&self) -> impl Iterator<Item = (usize, ArgumentRow)> + use<> {
        let is_step = matches!(self, Self::ContactStep { .. });
        let is_varied = move |name: &str| name != H.0 && !(is_step && name == IMPULSES.0);
        self.rows_of_arguments().into_iter().enumerate().filter(move |(_, (name, ..))| is_varied(name))
    }

    fn plain_arguments(&self) -> &'static [ArgumentRow] {
        match self {
            Self::Derivatives(_) | Self::Pullback(_) => unreachable!("those of another function"),
            Self::InverseDynamics | Self::InverseDynamicsDerivatives | Self::JointTorqueRegressor => {
                &[Q, V, A]
            }
            Self::ForwardDynamics | Self::ForwardDynamicsDerivatives => &[Q, V, TAU],
            Self::InverseDynamicsPullback => &[Q, V, A, COTANGENT],
            Self::ForwardDynamicsPullback => &[Q, V, TAU, COTANGENT],
            Self::SemiImplicitEulerStep | Self::Rk4Step => &[Q, V, TAU, H],
            Self::ContactStep { .. } => &[Q, V, TAU, H, FRICTION, IMPULSES],
            Self::ContactProblem => &[Q, V, TAU, H, FRICTION],
            Self::ContactStart | Self::ContactSweep | Self::ContactFixedPoint => &[PROBLEM, SCALED, IMPULSES],
            Self::ContactEnd => &[PROBLEM, SCALED, Q, H],
            Self::Bias
            | Self::VelocityProduct
            | Self::CoriolisMatrix
            | Self::KineticEnergy
            | Self::Momentum => &[Q, V],
            Self::Dissipation => &[V],
            Self::MassMatrix
            | Self::MassMatrixRelated
            | Self::MassMatrixFactor
            | Self::InverseMassMatrix
            | Self::Gravity
            | Self::PotentialEnergy
            | Self::CenterOfMass
            | Self::CenterOfMassJacobian
            | Self::FramePoses
            | Self::FramePose(_)
            | Self::FrameJacobian(..) => &[Q],
        }
    }

    pub(crate) fn matrices(&self) -> Vec<Matrix> {
        let Some((function, kind)) = self.derivative_of() else {
            return self.plain_results().to_vec();
        };
        let (rows, what) = match kind {
            DerivativeKind::Derivatives => {
                let results = function.matrices();
                (
                    Some(Size::of_all_changes(&results)),
                    "a row for each number of the results, one result after the other",
                )
            }
            DerivativeKind::Pullback => (None, "the gradient"),
        };
        let by = |(_, (name, size, _)): (usize, ArgumentRow)| {
            let size = size.of_changes();
            rows.map_or((derivative_name(name), size, Size::One, what), |rows| {
                (derivative_name(name), rows, size, what)
            })
        };
        function.varied_arguments().map(by).collect()
    }

    fn plain_results(&self) -> &'static [Matrix] {
        match self {
            Self::Derivatives(_) | Self::Pullback(_) => unreachable!("those of another function"),
            Self::InverseDynamics => const { &[vector("tau", "generalized force [N·m, N]")] },
            Self::ForwardDynamics => const { &[vector("a", "acceleration [rad/s², m/s²]")] },
            Self::MassMatrix => const { &[square("mass", "[kg·m², kg·m, kg]")] },
            Self::MassMatrixRelated => {
                &[("related", Size::Related, Size::One, "row by row [kg·m², kg·m, kg]")]
            }
            Self::MassMatrixFactor => const { &[square("factor", "L and D [D: kg·m², kg]")] },
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
            Self::CenterOfMassJacobian => &[("jacobian", Size::Fixed(3), Size::Nv, "[m, 1]")],
            Self::InverseDynamicsDerivatives => INVERSE_DERIVATIVES,
            Self::ForwardDynamicsDerivatives => FORWARD_DERIVATIVES,
            Self::InverseDynamicsPullback => INVERSE_PULLBACK,
            Self::ForwardDynamicsPullback => FORWARD_PULLBACK,
            Self::JointTorqueRegressor => &[(
                "regressor",
                Size::Nv,
                Size::Parameters,
                "columns: for each moving link m, h (3), I about its origin (xx xy yy xz yz zz)",
            )],
            Self::SemiImplicitEulerStep | Self::Rk4Step | Self::ContactEnd => NEXT_STATE,
            Self::ContactStep { .. } => const { &[NEXT_STATE[0], NEXT_STATE[1], NEXT_IMPULSES] },
            Self::ContactProblem => &[
                ("problem", Size::Problem, Size::One, "rows and bounds"),
                ("velocity", Size::Nv, Size::One, "sqrt(D) L v with the initial multipliers"),
            ],
            Self::ContactStart => &[("velocity_next", Size::Nv, Size::One, "with the multipliers")],
            Self::ContactSweep | Self::ContactFixedPoint => {
                const { &[("velocity_next", Size::Nv, Size::One, "after the sweep"), NEXT_IMPULSES] }
            }
            Self::FramePoses => &[("poses", Size::Poses, Size::One, "for each frame R by rows, then p [m]")],
            Self::FramePose(_) => &[
                ("rotation", Size::Fixed(3), Size::Fixed(3), "R, the frame's axes are its columns"),
                ("translation", Size::Fixed(3), Size::One, "p, the frame's origin [m]"),
            ],
            Self::FrameJacobian(..) => JACOBIAN,
        }
    }
}

/// The name of the derivatives with respect to an argument.
fn derivative_name(argument: &str) -> &'static str {
    match argument {
        "q" => "by_position",
        "v" => "by_velocity",
        "a" => "by_acceleration",
        "tau" => "by_force",
        "friction" => "by_friction",
        "problem" => "by_problem",
        "velocity" => "by_scaled_velocity",
        "impulses" => "by_impulses",
        other => unreachable!("no derivatives with respect to {other}"),
    }
}
