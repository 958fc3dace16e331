//! Poses and Jacobians of frames on batches.

use robot_dynamics_core::algorithms::jacobian::{FrameJacobian, Seen};
use robot_dynamics_core::algorithms::kinematics;
use robot_dynamics_core::algorithms::kinematics::pose_of;
use robot_dynamics_core::kinematics::place::place_all_in_world;
use robot_dynamics_core::model::native::NativeTask;
use robot_dynamics_core::{FrameId, FramePose, Model, NativeFunction, Workspace};
use robot_dynamics_number::StateLanes;
use robot_dynamics_number::dispatch::Hardware;

use super::block::Operation;
use super::compiled_once::Quantity;
use super::compute::Tables;
use super::within::call;
use super::{BadStates, BatchFloat, BatchWorkspace};

/// The number of entries in one pose.
pub const NUMBERS_PER_POSE: usize = kinematics::NUMBERS_PER_POSE;

#[derive(Clone, Copy)]
pub struct Poses<'a> {
    frames: &'a [FrameId],
}

impl<T> Operation<T> for Poses<'_> {
    fn width(self, _: &Model) -> usize {
        NUMBERS_PER_POSE * self.frames.len()
    }

    /// Machine code may exist for one frame and for all frames in order, not for other lists.
    fn native_task(self, model: &Model) -> Option<NativeTask> {
        if let [frame] = *self.frames {
            return Some(NativeFunction::FramePose.of_frame(frame));
        }
        let is_whole = self.frames.iter().map(|frame| frame.index).eq(0..model.frames.len());
        is_whole.then(|| NativeFunction::FramePoses.into())
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, ..]: [&[N]; 3],
        poses: &mut [N],
    ) {
        place_all_in_world(model, &mut workspace.tree, q);
        for (frame, to) in self.frames.iter().zip(poses.chunks_exact_mut(NUMBERS_PER_POSE)) {
            let FramePose { rotation, translation } =
                pose_of(&workspace.tree.screws.world, model.frame_of(*frame));
            to[..9].copy_from_slice(rotation.as_flattened());
            to[9..].copy_from_slice(&translation);
        }
    }
}

#[derive(Clone, Copy)]
pub struct Jacobian {
    frame: FrameId,
    seen: Seen,
}

impl<T> Operation<T> for Jacobian {
    fn width(self, model: &Model) -> usize {
        6 * model.nv
    }

    fn native_task(self, _: &Model) -> Option<NativeTask> {
        Some(self.seen.native().of_frame(self.frame))
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, ..]: [&[N]; 3],
        jacobian: &mut [N],
    ) {
        let Self { frame, seen } = self;
        call::<H, _, _>(&mut workspace.tree, FrameJacobian { model, q, frame, seen, jacobian });
    }
}

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
    let tables = Tables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    T::compute(model, workspace, Quantity::Poses(Poses { frames }), &tables, "the poses", poses)
}

macro_rules! jacobian {
    ($(#[$doc:meta])* $name:ident, $seen:ident) => {
        $(#[$doc])*
        ///
        /// q is \[batch\]\[nq\]; the Jacobians are \[batch\]\[6\]\[nv\].
        ///
        /// # Errors
        /// [`BadStates`] lists the states without a valid result; all other results are valid.
        ///
        /// # Panics
        /// Panics if a table has the wrong length, or the workspace or the frame belongs to another model.
        pub fn $name<T: BatchFloat>(
            model: &Model,
            workspace: &mut BatchWorkspace<T>,
            q: &[T],
            frame: FrameId,
            jacobian: &mut [T],
        ) -> Result<(), BadStates> {
            model.frame_of(frame);
            let tables = Tables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
            let operation = Quantity::Jacobian(Jacobian { frame, seen: Seen::$seen });
            T::compute(model, workspace, operation, &tables, "the Jacobian", jacobian)
        }
    };
}
jacobian!(
    /// J of a frame along the world's axes in each state; see
    /// [`frame_jacobian_world_aligned`](robot_dynamics_core::frame_jacobian_world_aligned).
    frame_jacobian_world_aligned,
    WorldAligned
);
jacobian!(
    /// J of a frame along its own axes in each state; see
    /// [`frame_jacobian_in_frame`](robot_dynamics_core::frame_jacobian_in_frame).
    frame_jacobian_in_frame,
    InFrame
);
jacobian!(
    /// J of the point of the frame's link at the world's origin in each state; see
    /// [`frame_jacobian_in_world`](robot_dynamics_core::frame_jacobian_in_world).
    frame_jacobian_in_world,
    InWorld
);
