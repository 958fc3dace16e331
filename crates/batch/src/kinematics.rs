//! Poses and Jacobians of frames on batches.

use robot_dynamics_core::algorithms::kinematics;
use robot_dynamics_core::{FrameId, Model, ReferenceFrame};

use crate::computation::frames::{Jacobian, Poses};
use crate::float::Quantity;
use crate::tables::InputTables;
use crate::{BadStates, BatchFloat, BatchWorkspace};

/// The number of entries in one pose.
pub const NUMBERS_PER_POSE: usize = kinematics::NUMBERS_PER_POSE;

/// `world_from_frame` of some frames in each state; see [`frame_pose`](robot_dynamics_core::frame_pose).
///
/// q is \[batch\]\[nq\]; the poses are \[batch\]\[frames\]\[12\]: the rotation by rows, then the translation.
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::{BatchWorkspace, NUMBERS_PER_POSE};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (q, tip, mut poses) = ([0.0, 0.3], model.frame_named("tip")?, [0.0; 2 * NUMBERS_PER_POSE]);
/// batch::frame_poses(&model, &mut BatchWorkspace::<f64>::new(&model), &q, &[tip], &mut poses)?;
/// let second = &poses[NUMBERS_PER_POSE..];
/// assert!((second[9] - 0.5 * 0.3_f64.cos()).abs() < 1e-15 && (second[11] + 0.5 * 0.3_f64.sin()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace or a frame belongs to another model.
#[doc(alias = "forward kinematics")]
#[track_caller]
pub fn frame_poses<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    frames: &[FrameId],
    poses: &mut [T],
) -> Result<(), BadStates> {
    for &frame in frames {
        model.frame_of(frame);
    }
    let tables = InputTables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    T::compute(model, workspace, Quantity::Poses(Poses { frames }), &tables, "the poses", poses)
}

/// J of a frame in each state; see [`frame_jacobian`](robot_dynamics_core::frame_jacobian).
///
/// q is \[batch\]\[nq\]; the Jacobians are \[batch\]\[6\]\[nv\].
///
/// ```
/// use robot_dynamics::algorithms::ReferenceFrame;
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (q, tip, mut jacobians) = ([0.0, 0.3], model.frame_named("tip")?, [0.0; 2 * 6]);
/// let workspace = &mut BatchWorkspace::<f64>::new(&model);
/// batch::frame_jacobian(&model, workspace, &q, tip, ReferenceFrame::Local, &mut jacobians)?;
/// // In the rod's axes the tip moves along −z at every angle.
/// assert!((jacobians[2] + 0.5).abs() < 1e-15 && (jacobians[8] + 0.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace or the frame belongs to another model.
#[doc(alias = "frame_jacobian_in_frame")]
#[doc(alias = "frame_jacobian_in_world")]
#[doc(alias = "frame_jacobian_world_aligned")]
#[track_caller]
pub fn frame_jacobian<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    frame: FrameId,
    reference_frame: ReferenceFrame,
    jacobian: &mut [T],
) -> Result<(), BadStates> {
    model.frame_of(frame);
    let tables = InputTables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    let operation = Quantity::Jacobian(Jacobian { frame, reference_frame });
    T::compute(model, workspace, operation, &tables, "the Jacobian", jacobian)
}
