//! The pullback of steps and rollouts by any stepper, with contact, stops and friction.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;

use super::checks::{check_floats, check_given, check_rollout_floats, check_rollout_lengths};
use super::cotangents::{MotionCotangents, TrajectoryCotangents};
use super::stepper_checkpoints::{StepperPullbackWorkspace, multiply_transposed, pull_back_by_stepper};
use super::stepper_rollout::StepperRollout;
use super::tables::RolloutTables;
use crate::motion::RobotState;
use crate::motion::integrate::check_step;
use crate::motion::linearize_step::linearize_stepper;
use crate::motion::linearize_step::results::{LinearizationMethod, LinearizedStep, LinearizedSteps};
use crate::motion::simulate::StepError;
use crate::{StepForces, StepWorkspace, Stepper};

/// The pullback of one step of any [`Stepper`]: (q̄₀, v̄₀) = Aᵀ (q̄₁, v̄₁), τ̄ = Bᵀ (q̄₁, v̄₁), with contact,
/// stops and dry friction.
///
/// A and B are those of [`linearize_stepper`], which says how they are computed and what stays constant. The
/// result names their method. The arguments are those of [`step_pullback`](crate::step_pullback), without
/// parameters. On an error all results are unchanged.
///
/// ```
/// use robot_dynamics::derivatives::{MotionCotangents, RobotState, stepper_pullback};
/// use robot_dynamics::description::{PassiveForces, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Method, SimulationBuilder, StepForces, StepWorkspace};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].passive = PassiveForces::default().with_friction(30.0);
/// let model = Model::new(robot)?;
/// let mut stepper = SimulationBuilder::new(&model).method(Method::Implicit).build()?.into_stepper();
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0], [1.0], [0.0]);
/// let cotangents = MotionCotangents {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_force: &mut by_tau,
///     parameters: &mut [],
/// };
/// let (w, forces) = (&mut StepWorkspace::new(&model), StepForces::new(&[0.5], true));
/// let state = RobotState { q: &[0.1], v: &[0.0] };
/// stepper_pullback(&model, &mut stepper, w, &forces, 1e-3, state, cotangents)?;
/// // Friction holds the joint: no force changes its velocity.
/// assert!(by_tau[0].abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`linearize_stepper`]; also a cotangent that is not finite.
///
/// # Panics
/// If a slice has the wrong length, or `parameters` is not empty.
#[track_caller]
pub fn stepper_pullback<S: Stepper + Clone>(
    model: &Model,
    stepper: &mut S,
    workspace: &mut StepWorkspace,
    forces: &StepForces<'_>,
    h: f64,
    state: RobotState<'_>,
    cotangents: MotionCotangents<'_, f64>,
) -> Result<LinearizationMethod, StepError> {
    let MotionCotangents { by_position, by_velocity, by_force, parameters } = cotangents;
    let nv = model.nv;
    check_length("the cotangent of q", by_position.len(), nv);
    check_length("the cotangent of v", by_velocity.len(), nv);
    check_length("the cotangent of tau", by_force.len(), nv);
    check_length("the parameters", parameters.len(), 0);
    check_given("the cotangent of q", by_position)?;
    check_given("the cotangent of v", by_velocity)?;
    let (mut a, mut b) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
    let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
    let method = linearize_stepper(model, stepper, workspace, forces, h, state, out)?;
    check_floats("the derivative of a step", &a)?;
    check_floats("the derivative of a step", &b)?;
    let cotangent = [&*by_position, &*by_velocity].concat();
    multiply_transposed(&b, &cotangent, &mut [by_force]);
    multiply_transposed(&a, &cotangent, &mut [by_position, by_velocity]);
    Ok(method)
}

/// The gradient of a loss along a rollout by any [`Stepper`], with contact, stops and dry friction, such as
/// that of a simulation ([`Simulation::stepper`](crate::simulator::Simulation::stepper)).
///
/// The steps are those of the stepper, bit for bit. Each is pulled back by A and B of [`linearize_stepper`]:
/// analytic for steps of `implicit`, and differences for others. The result counts both, and the steps at a
/// transition, where the gradient is one-sided. The forces that a step takes over from the step before count
/// as constant, which leaves an error of about 1e-3 of the gradient of a ball that rolls for 60 steps. With
/// [`StepperRollout::with_restarts`] there are no such forces, and the gradient is exact. The arguments are
/// those of [`rollout_pullback`](crate::rollout_pullback), without parameters. On an error `by_position` and
/// `by_velocity` are unchanged.
///
/// ```
/// use robot_dynamics::derivatives::{MotionCotangents, RobotState, StepperPullbackWorkspace};
/// use robot_dynamics::derivatives::{StepperRollout, TrajectoryCotangents, rollout_pullback_by_stepper};
/// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, MassProperties};
/// use robot_dynamics::description::{PassiveForces, Pose, RobotDescription};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Method, SimulationBuilder};
/// // A block of 1000 kg/m³ · 2e-3 m³ slides against a friction of 3 N.
/// let mut robot = RobotDescription::new("slider");
/// robot.links.push(LinkDescription::new("rail", None));
/// let brick = MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.2, 0.1, 0.1))?;
/// robot.links.push(LinkDescription::new("brick", brick));
/// let slide = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
/// let mut joint = JointDescription::new("slide", slide, "rail", "brick", Pose::IDENTITY);
/// joint.passive = PassiveForces::default().with_friction(3.0);
/// robot.joints.push(joint);
/// let model = Model::new(robot)?;
/// let stepper = SimulationBuilder::new(&model).method(Method::Implicit).build()?.into_stepper();
/// let (rollout, start) = (StepperRollout::new(&stepper, 0.01, 100), RobotState { q: &[0.0], v: &[0.0] });
/// let w = &mut StepperPullbackWorkspace::new(&model, 0);
/// // The final position by a force that is held over one second.
/// for (force, expected) in [(2.0, 0.0), (5.0, 0.5 / 2.0)] {
///     let (mut by_q, mut by_v, mut by_tau) = ([1.0], [0.0], [0.0]);
///     let cotangents = MotionCotangents {
///         by_position: &mut by_q,
///         by_velocity: &mut by_v,
///         by_force: &mut by_tau,
///         parameters: &mut [],
///     };
///     let trajectory = TrajectoryCotangents::default();
///     let steps =
///         rollout_pullback_by_stepper(&model, &rollout, w, start, &[force], trajectory, cotangents)?;
///     assert_eq!((steps.analytic, steps.differences), (100, 0));
///     assert!((by_tau[0] - expected).abs() < 1e-9); // t²/2m if it moves
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`StepError`] if an argument is not finite, or if a step or its derivative fails.
///
/// # Panics
/// If a slice has the wrong length, or `parameters` is not empty.
#[track_caller]
pub fn rollout_pullback_by_stepper<S: Stepper + Clone>(
    model: &Model,
    rollout: &StepperRollout<'_, S>,
    workspace: &mut StepperPullbackWorkspace<S>,
    state: RobotState<'_>,
    tau: &[f64],
    trajectory: TrajectoryCotangents<'_, f64>,
    cotangents: MotionCotangents<'_, f64>,
) -> Result<LinearizedSteps, StepError> {
    let RobotState { q, v } = state;
    let nv = model.nv;
    check_step(rollout.step)?;
    check_length("q", q.len(), model.nq);
    check_length("v", v.len(), nv);
    check_rollout_lengths(nv, (rollout.steps, rollout.samples()), tau, &trajectory, &cotangents);
    check_length("the parameters", cotangents.parameters.len(), 0);
    check_rollout_floats(RobotState { q, v }, tau, &trajectory, &cotangents)?;
    let MotionCotangents { by_position, by_velocity, by_force, .. } = cotangents;
    let (mut by_q, mut by_v) = (by_position.to_vec(), by_velocity.to_vec());
    by_force.fill(0.0);
    let mut tables = RolloutTables { tau, trajectory, by_force };
    let way = (rollout, rollout.spacing(workspace.spacing));
    let counts = pull_back_by_stepper(model, way, &mut tables, workspace, state, (&mut by_q, &mut by_v))?;
    check_floats("the cotangent of q at the start", &by_q)?;
    check_floats("the cotangent of v at the start", &by_v)?;
    check_floats("the cotangent of tau", by_force)?;
    by_position.copy_from_slice(&by_q);
    by_velocity.copy_from_slice(&by_v);
    // Tables do not cancel.
    Ok(counts.unwrap_or_default())
}
