//! The derivatives of one step of any stepper, analytic where the method has them.

use robot_dynamics_core::Model;

use super::checks::check_inputs;
use super::differences::linearize_by_differences;
use super::results::{LinearizationMethod, LinearizedStep};
use crate::motion::RobotState;
use crate::{StepError, StepForces, StepWorkspace, Stepper};

/// A and B of one step of any [`Stepper`]: (δq₁, δv₁) = A (δq₀, δv₀) + B δτ, with contact, stops and dry
/// friction.
///
/// The layout is that of [`linearize_step`](crate::linearize_step). The derivatives of
/// [`ImplicitIntegrator`](crate::ImplicitIntegrator) are those of its equations, with the contacts, stops and
/// friction forces that act in the step. Each keeps its state: a contact sticks, slides or is open. Where
/// that state is about to change, A and B are one-sided and the result says so. Closed loops and coupled
/// joints hold at the end of a step, so the derivatives of q₁ and v₁ keep them. The time of an impact moves
/// with the state, as in a saltation matrix. Fluids, rebounds, and impacts of some bodies while others keep
/// their whole step have no analytic derivative yet: they, and all other methods, use
/// [`linearize_by_differences`](crate::linearize_by_differences).
///
/// Redundant contacts that slide in different directions do not determine their forces. The derivatives then
/// belong to one distribution of them, and may differ from differences.
///
/// The stepper keeps its state, and with it the forces of the last step, which count as constant. A stepper
/// with contacts should therefore have taken a step to (q, v).
///
/// ```
/// use robot_dynamics::derivatives::{LinearizationMethod, LinearizedStep, RobotState, linearize_stepper};
/// use robot_dynamics::description::{PassiveForces, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Method, SimulationBuilder, StepForces, StepWorkspace};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_friction(30.0);
/// let model = Model::new(robot)?;
/// let mut stepper = SimulationBuilder::new(&model).method(Method::Implicit).build()?.into_stepper();
/// let (mut a, mut b) = ([0.0; 4], [0.0; 2]);
/// let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
/// let (w, state) = (&mut StepWorkspace::new(&model), RobotState { q: &[0.1], v: &[0.0] });
/// let forces = StepForces::new(&[0.5], true);
/// let method = linearize_stepper(&model, &mut stepper, w, &forces, 1e-3, state, out)?;
/// assert_eq!(method, LinearizationMethod::Analytic { at_transition: false });
/// // Friction holds the joint: a push does not move it.
/// assert!(b.iter().all(|x| x.abs() < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`StepError`] if an input is not finite, `h` is not positive, or a step fails;
/// [`StepError::Discontinuous`] if the step is discontinuous on both sides.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub fn linearize_stepper<S: Stepper + Clone>(
    model: &Model,
    stepper: &mut S,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    RobotState { q, v }: RobotState<'_>,
    out: LinearizedStep<'_>,
) -> Result<LinearizationMethod, StepError> {
    check_inputs(model, forces, h, RobotState { q, v }, &out)?;
    let LinearizedStep { by_state, by_force } = out;
    let out = LinearizedStep { by_state: &mut *by_state, by_force: &mut *by_force };
    let method = stepper.linearize(model, workspace, forces, h, RobotState { q, v }, out)?;
    if matches!(method, LinearizationMethod::Differences { .. }) {
        let out = LinearizedStep { by_state, by_force };
        linearize_by_differences(model, stepper, workspace, forces, h, RobotState { q, v }, out)?;
    }
    Ok(method)
}
