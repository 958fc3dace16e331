//! Where frames are.

use dynamics::Scalar;
use number::View;
use number::dispatch::{Hardware, Kernel};

use crate::model::Frame;
use crate::model::native::NativeFunction;
use crate::scratch::compiled_once::{OverNumber, compiled_once, run};
use crate::scratch::native::computed_natively;
use crate::scratch::tree::TreeMemory;
use crate::spatial::algebra::{M3, V3};
use crate::spatial::screw::Place;
use crate::stages::place::{place_all_in_world, place_chain};
use crate::{FrameId, Model, Pose, Workspace};

/// `world_from_frame`: x_world = R x_frame + p. **(MR §3.3)**
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePose<S = f64> {
    /// R, by rows: its columns are the frame's axes in the world.
    pub rotation: [[S; 3]; 3],
    /// p: the frame's origin in the world \[m\].
    pub translation: [S; 3],
}

/// Numbers of a pose.
pub(crate) const NUMBERS_PER_POSE: usize = 12;

impl<S: Copy> FramePose<S> {
    /// From R by rows, then p.
    #[inline(always)]
    fn of_numbers(numbers: &[S; NUMBERS_PER_POSE]) -> Self {
        let [x, y, z, translation] = *numbers.as_chunks::<3>().0 else { unreachable!("four threes") };
        Self { rotation: [x, y, z], translation }
    }
}

impl From<FramePose> for Pose {
    fn from(FramePose { rotation, translation }: FramePose) -> Self {
        Self { rotation, translation }
    }
}

/// `world_from_frame` in the configuration q.
///
/// ```
/// use multibody::{
///     JointDescription, JointKind, LinkDescription, Model, Pose, RobotDescription, Workspace, frame_pose,
/// };
/// # let mass = dynamics::MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity()).ok();
/// let mut robot = RobotDescription::new("arm");
/// robot.links.push(LinkDescription::new("base", None));
/// robot.links.push(LinkDescription::new("arm", mass));
/// let about_z = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
/// let at = Pose::from_translation([1.0, 0.0, 0.0]);
/// robot.joints.push(JointDescription::new("shoulder", about_z, "base", "arm", at));
/// let model = Model::new(robot)?;
/// let arm = model.frame("arm").expect("the arm is a frame");
/// let pose = frame_pose(&model, &mut Workspace::new(&model), &[std::f64::consts::FRAC_PI_2], arm);
/// assert_eq!(pose.translation, [1.0, 0.0, 0.0]);
/// assert!((pose.rotation[1][0] - 1.0).abs() < 1e-15); // its x axis points along the world's y
/// # Ok::<(), multibody::ModelError>(())
/// ```
///
/// # Panics
/// If q has the wrong length, or the frame is another model's.
#[inline]
#[track_caller]
pub fn frame_pose<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
) -> FramePose<S> {
    workspace.admit(model, q);
    let zero = S::zero();
    let (native, mut numbers) = (&mut workspace.tree.native, [zero; NUMBERS_PER_POSE]);
    model.frame_of(frame);
    let task = NativeFunction::FramePose.of_frame(frame);
    if computed_natively(model, native, task, &[q], &mut [&mut numbers]) {
        return FramePose::of_numbers(&numbers);
    }
    let mut pose = FramePose { rotation: [[zero; 3]; 3], translation: [zero; 3] };
    run(&mut workspace.tree, OneFramePose { model, q, frame: model.frame_of(frame), pose: &mut pose });
    pose
}

/// The arguments of [`frame_pose`].
pub(crate) struct OneFramePose<'a, S> {
    model: &'a Model,
    q: &'a [S],
    frame: &'a Frame,
    pose: &'a mut FramePose<S>,
}

compiled_once!(OneFramePoseKind, OneFramePose);

impl<S: Scalar> Kernel<OverNumber, S> for OneFramePose<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        if let Some(body) = self.frame.body {
            place_chain::<_, false>(self.model, tree, N::view(self.q), body);
        } else {
            crate::model::length::check_length("q", self.q.len(), self.model.nq);
        }
        *self.pose = pose_of(&tree.screws.world, self.frame);
    }
}

/// `world_from_frame` of every frame, in the order of [`Model::frames`].
///
/// ```
/// use multibody::{FramePose, Model, Pose, Workspace, frame_poses, pendulum};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut poses = vec![FramePose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] }; model.frames().len()];
/// frame_poses(&model, &mut Workspace::<f64>::new(&model), &[0.3], &mut poses);
/// let tip = model.frames().iter().position(|frame| frame.name == "tip").expect("the pendulum's tip");
/// assert!((poses[tip].translation[0] - 0.5 * 0.3_f64.cos()).abs() < 1e-15);
/// assert!((poses[tip].translation[2] + 0.5 * 0.3_f64.sin()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn frame_poses<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    poses: &mut [FramePose<S>],
) {
    workspace.admit(model, q);
    crate::model::length::check_length("the list of poses", poses.len(), model.frames.len());
    run(&mut workspace.tree, FramePoses { model, q, poses });
}

/// The arguments of [`frame_poses`].
pub(crate) struct FramePoses<'a, S> {
    model: &'a Model,
    q: &'a [S],
    poses: &'a mut [FramePose<S>],
}

compiled_once!(FramePosesKind, FramePoses);

impl<S: Scalar> Kernel<OverNumber, S> for FramePoses<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, poses } = self;
        place_all_in_world(model, tree, N::view(q));
        let world = &tree.screws.world[..];
        for (pose, frame) in poses.iter_mut().zip(&model.frames) {
            *pose = pose_of(world, frame);
        }
    }
}

/// `world_from_frame`, after the bodies are placed.
#[inline(always)]
pub(crate) fn pose_of<S: Scalar, N: View<S>>(world: &[Place<N>], frame: &Frame) -> FramePose<S> {
    let own = constant::<N>(frame);
    let place = if let Some(body) = frame.body { world[body].then(&own) } else { own };
    let [x, y, z] = place.rotation.rows();
    FramePose { rotation: [stored(x), stored(y), stored(z)], translation: stored(place.translation.array()) }
}

#[inline(always)]
fn stored<S: Scalar, N: View<S>>([x, y, z]: [N; 3]) -> [S; 3] {
    [x.value(), y.value(), z.value()]
}

#[inline(always)]
pub(crate) fn constant<S: Scalar>(frame: &Frame) -> Place<S> {
    Place { rotation: M3::constant(&frame.rotation), translation: V3::constant(&frame.translation) }
}
