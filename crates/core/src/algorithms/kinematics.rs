//! Poses of frames in the world.
//!
//! `world_from_frame` is the product of the placements from the root to the frame. Cost: O(depth) for one
//! frame, O(n) for all. **(MR §3.3)**

use robot_dynamics_description::Pose;
use robot_dynamics_number::algebra::{M3, V3};
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::kinematics::placement::{place_all_in_world, place_chain};
use crate::model::Frame;
use crate::model::native::NativeFunction;
use crate::spatial::transform::Transform;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{FrameId, Model, Workspace};

/// The length of a pose as an array.
pub const NUMBERS_PER_POSE: usize = 12;

/// A pose from the rows of R, then p.
#[inline(always)]
fn of_numbers<S: Copy>(numbers: &[S; NUMBERS_PER_POSE]) -> Pose<S> {
    let [x, y, z, translation] = *numbers.as_chunks::<3>().0 else { unreachable!("four threes") };
    Pose { rotation: [x, y, z], translation }
}

/// `world_from_frame` in the configuration q \[m\].
///
/// ```
/// use robot_dynamics::algorithms::frame_pose;
/// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose};
/// use robot_dynamics::description::RobotDescription;
/// use robot_dynamics::model::{Model, Workspace};
/// # let mass = robot_dynamics::description::MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity()).ok();
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
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
///
/// # Panics
/// If q has the wrong length, or the frame belongs to another model.
#[inline]
#[track_caller]
pub fn frame_pose<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
) -> Pose<S> {
    workspace.check_inputs(model, q);
    let zero = S::zero();
    let (native, mut numbers) = (&mut workspace.tree.native, [zero; NUMBERS_PER_POSE]);
    model.frame_of(frame);
    let task = NativeFunction::FramePose.of_frame(frame);
    if computed_natively(model, native, task, &[q], &mut [&mut numbers]) {
        return of_numbers(&numbers);
    }
    let mut pose = Pose { rotation: [[zero; 3]; 3], translation: [zero; 3] };
    run(&mut workspace.tree, OneFramePose { model, q, frame: model.frame_of(frame), pose: &mut pose });
    pose
}

/// The arguments of [`frame_pose`].
pub struct OneFramePose<'a, S> {
    model: &'a Model,
    q: &'a [S],
    frame: &'a Frame,
    pose: &'a mut Pose<S>,
}

compiled_once!(OneFramePose);

impl<S: Scalar> Kernel<TreeStorage, S> for OneFramePose<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        if let Some(body) = self.frame.body {
            place_chain::<_, false>(self.model, tree, N::view(self.q), body);
        } else {
            robot_dynamics_description::check_length("q", self.q.len(), self.model.nq);
        }
        *self.pose = pose_of(&tree.world.pose, self.frame);
    }
}

/// `world_from_frame` of every frame, in the order of [`Model::frames`].
///
/// ```
/// use robot_dynamics::algorithms::frame_poses;
/// use robot_dynamics::description::{Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut poses = vec![Pose { rotation: [[0.0; 3]; 3], translation: [0.0; 3] }; model.frames().len()];
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
pub fn frame_poses<S: Scalar>(model: &Model, workspace: &mut Workspace<S>, q: &[S], poses: &mut [Pose<S>]) {
    workspace.check_inputs(model, q);
    robot_dynamics_description::check_length("the list of poses", poses.len(), model.frames.len());
    run(&mut workspace.tree, FramePoses { model, q, poses });
}

/// The arguments of [`frame_poses`].
pub struct FramePoses<'a, S> {
    model: &'a Model,
    q: &'a [S],
    poses: &'a mut [Pose<S>],
}

compiled_once!(FramePoses);

impl<S: Scalar> Kernel<TreeStorage, S> for FramePoses<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, poses } = self;
        place_all_in_world(model, tree, N::view(q));
        let world = &tree.world.pose[..];
        for (pose, frame) in poses.iter_mut().zip(&model.frames) {
            *pose = pose_of(world, frame);
        }
    }
}

/// `world_from_frame`, from the placements of the bodies.
#[inline(always)]
pub fn pose_of<S: Scalar, N: View<S>>(world: &[Transform<N>], frame: &Frame) -> Pose<S> {
    let own = constant::<N>(frame);
    let place = if let Some(body) = frame.body { world[body].compose(&own) } else { own };
    let [x, y, z] = place.rotation.rows();
    Pose { rotation: [stored(x), stored(y), stored(z)], translation: stored(place.translation.array()) }
}

#[inline(always)]
fn stored<S: Scalar, N: View<S>>([x, y, z]: [N; 3]) -> [S; 3] {
    [x.value(), y.value(), z.value()]
}

#[inline(always)]
pub fn constant<S: Scalar>(frame: &Frame) -> Transform<S> {
    Transform { rotation: M3::constant(&frame.rotation), translation: V3::constant(&frame.translation) }
}
