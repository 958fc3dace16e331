//! The derivatives of one step of a stepper by its state, forces and parameters.

use robot_dynamics_core::{Model, PARAMETERS_PER_LINK};
use robot_dynamics_description::check_length;

use super::checks::check_inputs;
use super::results::{LinearizationMethod, LinearizedStepWithParameters};
use crate::motion::RobotState;
use crate::{StepError, StepForces, StepWorkspace, Stepper};

/// [`linearize_stepper`](crate::linearize_stepper) with the derivatives by controls of actuators, inertial
/// parameters and contact friction, by the equations that the step satisfies.
///
/// The controls are those that the stepper holds over the step. The inertial parameters are those of
/// [`inertial_parameters`](robot_dynamics_core::inertial_parameters), without armatures and springs. A
/// contact that sticks or is open does not depend on its friction. The result says whether a contact, a
/// friction force or a control is at a transition; the derivatives are then one-sided.
///
/// ```
/// use robot_dynamics::contact::Ground;
/// use robot_dynamics::derivatives::{LinearizedStep, LinearizedStepWithParameters, RobotState};
/// use robot_dynamics::derivatives::linearize_stepper_with_parameters;
/// use robot_dynamics::description::{Base, LinkDescription, LinkShape, MassProperties, Pose};
/// use robot_dynamics::description::{RobotDescription, Shape, ShapeRole};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Method, SimulationBuilder, StepForces, StepWorkspace, Stepper};
/// // A brick slides along y: v′ = v − μ g h.
/// let mut robot = RobotDescription::new("brick");
/// robot.base = Base::Floating;
/// let brick = MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
/// robot.links.push(LinkDescription::new("brick", brick));
/// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
/// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
/// let model = Model::new(robot)?;
/// let builder = SimulationBuilder::new(&model).method(Method::Implicit);
/// let mut stepper = builder.ground(Ground::level(0.0).with_friction(0.4)).build()?.into_stepper();
/// let (w, h, forces) = (&mut StepWorkspace::new(&model), 1e-3, StepForces::new(&[0.0; 6], true));
/// let mut q = [0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0];
/// let mut v = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
/// stepper.step(&model, w, &forces, h, &mut q, &mut v)?;
/// let (mut a, mut b, mut by_friction) = ([0.0; 144], [0.0; 72], [0.0; 12]);
/// let step = LinearizedStep { by_state: &mut a, by_force: &mut b };
/// let (by_control, by_inertial) = (&mut [], &mut []);
/// let out = LinearizedStepWithParameters { step, by_control, by_inertial, by_friction: &mut by_friction };
/// let state = RobotState { q: &q, v: &v };
/// linearize_stepper_with_parameters(&model, &mut stepper, w, &forces, h, state, out)?;
/// assert!((by_friction[7] + 9.81 * h).abs() < 1e-9); // ∂v′/∂μ
/// assert!((by_friction[1] + 0.5 * 9.81 * h * h).abs() < 1e-9); // ∂y′/∂μ
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// - [`StepError`] if an input is not finite, `h` is not positive, or the step fails.
/// - [`StepError::ParametersNotDifferentiable`] if the step has no analytic derivative. Nothing is then
///   written.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn linearize_stepper_with_parameters<S: Stepper>(
    model: &Model,
    stepper: &mut S,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    RobotState { q, v }: RobotState<'_>,
    out: LinearizedStepWithParameters<'_>,
) -> Result<LinearizationMethod, StepError> {
    let nv = model.nv();
    let LinearizedStepWithParameters { step, by_control, by_inertial, by_friction } = &out;
    check_inputs(model, forces, h, RobotState { q, v }, step)?;
    for (name, given, columns) in [
        ("the derivatives by controls", by_control.len(), stepper.control_count()),
        (
            "the derivatives by inertial parameters",
            by_inertial.len(),
            PARAMETERS_PER_LINK * model.moving_links().count(),
        ),
        ("the derivatives by friction", by_friction.len(), 1),
    ] {
        if given > 0 {
            check_length(name, given, 2 * nv * columns);
        }
    }
    let method = stepper.linearize_with_parameters(model, workspace, forces, h, RobotState { q, v }, out)?;
    match method {
        LinearizationMethod::Analytic { .. } => Ok(method),
        LinearizationMethod::Differences { reason } => Err(StepError::ParametersNotDifferentiable { reason }),
    }
}
