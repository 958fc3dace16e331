//! Which configuration brings a frame where it should be.

mod attempt;
pub(crate) mod bounds;
mod damped_step;
mod error;
mod options;

pub use error::InverseKinematicsError;
pub use options::{FrameTarget, InverseKinematicsOptions, InverseKinematicsSolution};

use dynamics::SplitMix64;

use self::attempt::{Attempt, Patience};
use self::error::{check_options, check_target};
use crate::{FrameId, Model, MotionError, Workspace, check_configuration, random_within_limits};

/// A configuration within the limits in which a frame is where it should be: T(q) = T\*, or p(q) = p\*.
///
/// `target` is a [`Pose`](crate::Pose) `world_from_frame`\*, or the place \[m\] of the frame's origin alone; `start` is a
/// configuration, nq numbers. Of many solutions it finds one near the start: each step is the smallest that does what
/// it does, q ← q ⊕ δ with
///
/// > δ = −Jₑᵀ (JₑJₑᵀ + λ 1)⁻¹ e,  e = log(T\*⁻¹T), Jₑ = D J, λ = μ |e|²/2
///
/// (of a place e = p − p\*), D the [`log_derivative`](crate::Pose::log_derivative), J the frame's Jacobian. The damping
/// follows the error, so the last steps converge quadratically and a target out of reach is approached as near as
/// can be; μ falls where the linear model is right and rises where a step would not lead nearer. A coordinate
/// that would leave its limits goes up to the limit, and the others make up for it; limits of followers hold as
/// well, quaternions have none. A start outside the limits is moved to them first. Where it leads nowhere, random
/// configurations within the limits follow, the same for equal seeds. It allocates before its steps, not in them.
///
/// Sources: Sugihara, *Solvability-unconcerned inverse kinematics by the Levenberg–Marquardt method*, IEEE Trans.
/// Robotics 27 (2011); Beeson, Ames, *TRAC-IK*, Humanoids 2015, for the restarts. **(MR §6.2)**
///
/// ```
/// use multibody::{InverseKinematicsOptions, JointKinds, Model, Pose, RandomRobotOptions, Workspace};
/// use multibody::{frame_pose, inverse_kinematics, neutral, random_robot};
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
/// [`InverseKinematicsError::NoSolution`] with the nearest configuration where none is near enough; others where
/// the start is no configuration, the target not finite or no pose, or an option out of its range.
///
/// # Panics
/// If the frame or the workspace is another model's.
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
    check_configuration(model, start).map_err(MotionError::from)?;

    let mut attempt = Attempt::new(model, frame, &target, options);
    let mut best = attempt.run(workspace, start, Patience::Short);
    let mut random = SplitMix64::new(options.seed);
    while !best.is_found && best.solution.restarts < options.max_restarts {
        let start = random_within_limits(model, &mut random);
        best = best.nearer(attempt.run(workspace, &start, Patience::Short));
    }
    if !best.is_found {
        // As near as the nearest valley leads.
        let start = best.solution.q.clone();
        best = best.joined(attempt.run(workspace, &start, Patience::Long));
    }
    if best.is_found {
        return Ok(best.solution);
    }
    Err(InverseKinematicsError::NoSolution {
        frame: name.clone(),
        robot: model.name().to_owned(),
        best: Box::new(best.solution),
    })
}
