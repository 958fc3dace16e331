//! Inverse kinematics: a configuration with a given pose or position of a frame, T(q) = T\* or p(q) = p\*.
//!
//! Damped least-squares steps q ← q ⊕ δ with δ = −Jₑᵀ(JₑJₑᵀ + λ1)⁻¹e, e = log(T\*⁻¹T) and λ proportional to
//! |e|². A coordinate that would exceed its limit stops there. Random starts follow if one start fails. A step
//! costs O(n) for the Jacobian, and a 6×6 system.
//!
//! Several configurations may have the pose: the result is near the start, not necessarily the nearest. It
//! depends on the seed. Sources: Sugihara, *Solvability-unconcerned inverse kinematics by the
//! Levenberg–Marquardt method*, IEEE Trans. Robotics 27 (2011); Beeson, Ames, *TRAC-IK*, Humanoids 2015.
//! **(MR §6.2)**

pub(crate) mod bounds;
mod damped_step;
pub(crate) mod error;
mod frame_problem;
pub(crate) mod iteration;
mod options;

pub use error::InverseKinematicsError;
pub use options::{FrameTarget, InverseKinematicsOptions, InverseKinematicsSolution};

use robot_dynamics_core::{FrameId, Model, Workspace, check_configuration};

use self::bounds::Bounds;
use self::error::{check_options, check_target};
use self::frame_problem::FrameProblem;
use self::iteration::{Iteration, Search};

/// Finds a configuration within the limits in which a frame reaches its target: T(q) = T\*, or p(q) = p\*.
///
/// `target` is a [`Pose`](robot_dynamics_description::Pose) `world_from_frame`\*, or only the position \[m\]
/// of the frame's origin. `start` is a configuration, nq numbers. If there are many solutions, the result is
/// near the start, because each step is a damped least-squares step, q ← q ⊕ δ with
///
/// > δ = −Jₑᵀ (JₑJₑᵀ + λ 1)⁻¹ e,  e = log(T\*⁻¹T), Jₑ = D J, λ = μ |e|²/2
///
/// (for a position e = p − p\*), where D is the
/// [`log_derivative`](robot_dynamics_description::Pose::log_derivative) and J the frame's Jacobian. The
/// damping decreases with the error, so the last steps converge quadratically, and the steps approach an
/// unreachable target as closely as possible. μ decreases if the linear model is accurate, and increases if a
/// step would not reduce the error.
///
/// A coordinate that would exceed its limit stops there, and the others compensate. The limits of mimic
/// joints apply as well; quaternions have none. A start outside the limits is first moved to them. If a start
/// does not lead to a solution, random configurations within the limits follow, which are the same for equal
/// seeds. Memory is allocated before the steps, not during them.
///
/// Sources: Sugihara, *Solvability-unconcerned inverse kinematics by the Levenberg–Marquardt method*, IEEE
/// Trans. Robotics 27 (2011); Beeson, Ames, *TRAC-IK*, Humanoids 2015, for the restarts. **(MR §6.2)**
///
/// ```
/// use robot_dynamics::algorithms::frame_pose;
/// use robot_dynamics::control::{InverseKinematicsOptions, inverse_kinematics};
/// use robot_dynamics::description::{JointKinds, Pose, RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, Workspace, neutral};
/// let options = RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
/// let model = Model::new(random_robot(4, &options))?;
/// let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name)?;
/// let w = &mut Workspace::new(&model);
/// let target: Pose = frame_pose(&model, w, &[0.4; 7], hand).into();
/// let found =
///     inverse_kinematics(&model, w, hand, target, &neutral(&model), &InverseKinematicsOptions::default())?;
/// let reached = frame_pose(&model, w, &found.q, hand);
/// assert!((0..3).all(|i| (reached.translation[i] - target.translation[i]).abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// - [`InverseKinematicsError::NoSolution`], with the nearest configuration, if none is within the
///   tolerances.
/// - Other variants if the start, the target or an option is invalid.
///
/// # Panics
/// Panics if the frame or the workspace belongs to another model.
#[doc(alias = "IK")]
#[doc(alias = "damped least squares")]
#[track_caller]
pub fn inverse_kinematics(
    model: &Model,
    workspace: &mut Workspace,
    frame: FrameId,
    target: impl Into<FrameTarget>,
    start: &[f64],
    options: &InverseKinematicsOptions,
) -> Result<InverseKinematicsSolution, InverseKinematicsError> {
    let target = target.into();
    let name = &model.frame_of(frame).name;
    check_options(options)?;
    check_target(&target)?;
    check_configuration(model, start).map_err(|error| error.of("the start's q"))?;

    let bounds = Bounds::new(model);
    let mut problem = FrameProblem::new(model, (frame, &target), options, &bounds);
    let found = Iteration::new(model, options, &bounds).search(&mut problem, workspace, start);
    let error = problem.error(workspace, &found.q);
    let Search { q, evaluation, iterations, restarts } = found;
    let (position_error, angle_error) = (error.position, error.angle);
    let solution = InverseKinematicsSolution { q, position_error, angle_error, iterations, restarts };
    if evaluation.is_found {
        return Ok(solution);
    }
    Err(InverseKinematicsError::NoSolution {
        frame: name.clone(),
        robot: model.name().to_owned(),
        best: Box::new(solution),
    })
}
