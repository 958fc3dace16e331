//! Placements and Jacobians of frames, of batches.

use dynamics::{Scalar, StateLanes};

use super::block::Operation;
use super::compute::{Tables, compute};
use super::{BadStates, BatchFloat, BatchWorkspace};
use crate::algebra::V3;
use crate::dispatch::Route;
use crate::kinematics::{Moving, pose_of};
use crate::model::WORLD;
use crate::place::{place_bodies_by, place_in_world};
use crate::screws::{place_screws_by, shifted};
use crate::workspace::Screw;
use crate::{FrameId, Model, Workspace};

/// Numbers of one placement.
pub const NUMBERS_PER_POSE: usize = 12;

#[derive(Clone, Copy)]
struct Poses<'a> {
    frames: &'a [FrameId],
}

impl<T> Operation<T> for Poses<'_> {
    fn width(self, _: &Model) -> usize {
        NUMBERS_PER_POSE * self.frames.len()
    }

    #[inline(always)]
    fn run<S: StateLanes<Float = T>, R: Route<S>>(
        self,
        model: &Model,
        workspace: &mut Workspace<R::Number>,
        [q, ..]: [&[S]; 3],
        poses: &mut [S],
    ) {
        place_bodies_by::<S, R>(model, workspace, q);
        place_in_world(model, workspace);
        for (frame, to) in self.frames.iter().zip(poses.chunks_exact_mut(NUMBERS_PER_POSE)) {
            let pose = pose_of(workspace, &model.frames[frame.0]);
            for i in 0..3 {
                for j in 0..3 {
                    to[3 * i + j] = R::store(pose.rotation[i][j]);
                }
                to[9 + i] = R::store(pose.translation[i]);
            }
        }
    }
}

/// Which velocity a Jacobian yields.
#[derive(Clone, Copy)]
enum Form {
    WorldAligned,
    InFrame,
    InWorld,
}

#[derive(Clone, Copy)]
struct Jacobian {
    frame: FrameId,
    form: Form,
}

impl<T> Operation<T> for Jacobian {
    fn width(self, model: &Model) -> usize {
        6 * model.nv
    }

    #[inline(always)]
    fn run<S: StateLanes<Float = T>, R: Route<S>>(
        self,
        model: &Model,
        workspace: &mut Workspace<R::Number>,
        [q, ..]: [&[S]; 3],
        jacobian: &mut [S],
    ) {
        let origin = place_screws_by::<S, R>(model, workspace, q);
        let place = Moving::new(model, workspace, self.frame, origin).place;
        let point = if let Form::InWorld = self.form { -origin } else { place.translation };
        jacobian.fill(S::zero());
        let mut at = model.frames[self.frame.0].body.unwrap_or(WORLD);
        while at != WORLD {
            let body = &model.bodies[at];
            for index in body.dof..body.dof + body.motion.nv() {
                let Screw { mut linear, mut angular } = shifted(&workspace.column[index], point);
                if let Form::InFrame = self.form {
                    linear = place.rotation.transpose_mul(linear);
                    angular = place.rotation.transpose_mul(angular);
                }
                let dof = &model.dofs[index];
                add_rows::<S, R>(&mut jacobian[dof.coordinate..], model.nv, linear, dof.ratio);
                add_rows::<S, R>(
                    &mut jacobian[3 * model.nv + dof.coordinate..],
                    model.nv,
                    angular,
                    dof.ratio,
                );
            }
            at = body.parent;
        }
    }
}

/// Adds k x to three numbers, `stride` apart.
#[inline(always)]
fn add_rows<S: StateLanes, R: Route<S>>(to: &mut [S], stride: usize, x: V3<R::Number>, k: f64) {
    let [x, y, z] = x.array();
    to[0] = R::store(R::load(to[0]) + x.scale(k));
    to[stride] = R::store(R::load(to[stride]) + y.scale(k));
    to[2 * stride] = R::store(R::load(to[2 * stride]) + z.scale(k));
}

#[track_caller]
fn check_frame(model: &Model, frame: FrameId) {
    let count = model.frames.len();
    assert!(frame.0 < count, "frame {} is another model's: robot `{}` has {count}", frame.0, model.name());
}

/// `world_from_frame` of some frames in each state; see [`frame_pose`](crate::frame_pose).
///
/// q is \[batch\]\[nq\]; the poses are \[batch\]\[frames\]\[12\]: the rotation by rows, then the translation.
///
/// # Errors
/// [`BadStates`] names the states without a valid result; all others have theirs.
///
/// # Panics
/// If a table has the wrong length, or the workspace or a frame is another model's.
#[doc(alias = "forward kinematics")]
pub fn frame_poses<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    frames: &[FrameId],
    poses: &mut [T],
) -> Result<(), BadStates> {
    for &frame in frames {
        check_frame(model, frame);
    }
    let tables = Tables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    compute(model, workspace, Poses { frames }, &tables, "the poses", poses)
}

macro_rules! jacobian {
    ($(#[$doc:meta])* $name:ident, $form:ident) => {
        $(#[$doc])*
        ///
        /// q is \[batch\]\[nq\]; the Jacobians are \[batch\]\[6\]\[nv\].
        ///
        /// # Errors
        /// [`BadStates`] names the states without a valid result; all others have theirs.
        ///
        /// # Panics
        /// If a table has the wrong length, or the workspace or the frame is another model's.
        pub fn $name<T: BatchFloat>(
            model: &Model,
            workspace: &mut BatchWorkspace<T>,
            q: &[T],
            frame: FrameId,
            jacobian: &mut [T],
        ) -> Result<(), BadStates> {
            check_frame(model, frame);
            let tables = Tables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
            let operation = Jacobian { frame, form: Form::$form };
            compute(model, workspace, operation, &tables, "the Jacobian", jacobian)
        }
    };
}
jacobian!(
    /// J of a frame along the world's axes in each state; see
    /// [`frame_jacobian_world_aligned`](crate::frame_jacobian_world_aligned).
    frame_jacobian_world_aligned,
    WorldAligned
);
jacobian!(
    /// J of a frame along its own axes in each state; see
    /// [`frame_jacobian_in_frame`](crate::frame_jacobian_in_frame).
    frame_jacobian_in_frame,
    InFrame
);
jacobian!(
    /// J of the point that passes the world's origin in each state; see
    /// [`frame_jacobian_in_world`](crate::frame_jacobian_in_world).
    frame_jacobian_in_world,
    InWorld
);
