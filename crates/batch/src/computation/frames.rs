//! Poses and Jacobians of frames of a block.

use robot_dynamics_core::algorithms::jacobian::FrameJacobian;
use robot_dynamics_core::algorithms::kinematics::{NUMBERS_PER_POSE, pose_of};
use robot_dynamics_core::kinematics::placement::place_all_in_world;
use robot_dynamics_core::model::native::NativeTask;
use robot_dynamics_core::{FrameId, Model, NativeFunction, ReferenceFrame, Workspace};
use robot_dynamics_number::StateLanes;
use robot_dynamics_number::dispatch::Hardware;

use crate::block::Operation;
use crate::kernel_call::call;

/// The poses of frames in the world.
#[derive(Clone, Copy)]
pub struct Poses<'a> {
    pub(crate) frames: &'a [FrameId],
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
            let pose = pose_of(&workspace.tree.world.pose, model.frame_of(*frame));
            to[..9].copy_from_slice(pose.rotation.as_flattened());
            to[9..].copy_from_slice(&pose.translation);
        }
    }
}

/// The Jacobian of a frame.
#[derive(Clone, Copy)]
pub struct Jacobian {
    pub(crate) frame: FrameId,
    pub(crate) reference_frame: ReferenceFrame,
}

impl<T> Operation<T> for Jacobian {
    fn width(self, model: &Model) -> usize {
        6 * model.nv
    }

    fn native_task(self, _: &Model) -> Option<NativeTask> {
        Some(NativeFunction::frame_jacobian(self.reference_frame).of_frame(self.frame))
    }

    #[inline(always)]
    fn run<N: StateLanes<Float = T>, H: Hardware>(
        self,
        model: &Model,
        workspace: &mut Workspace<N>,
        [q, ..]: [&[N]; 3],
        jacobian: &mut [N],
    ) {
        let Self { frame, reference_frame } = self;
        let kernel = FrameJacobian { model, q, frame, reference_frame, jacobian };
        call::<H, _, _>(&mut workspace.tree, kernel);
    }
}
