//! Where frames are, how they move, and how that changes.
//!
//! A velocity of a frame is given in one of three ways, and the function's name says which:
//! *world aligned*: the velocity of the frame's origin and ω, along the world's axes;
//! *in frame*: the same two vectors along the frame's own axes (the body twist, MR §3.3.2);
//! *in world*: ω and the velocity of the point of the moving body that passes the world's origin (the spatial
//! twist, MR §3.3.2).

use dynamics::Scalar;
use number::View;
use number::dispatch::{Hardware, Kernel};

use crate::model::Frame;
use crate::model::length::check_length;
use crate::scratch::compiled_once::{OverNumber, compiled_once, run};
use crate::spatial::algebra::{M3, V3};
use crate::spatial::screw::{Place, Screw};
use crate::stages::place::{place_all_in_world, place_chain};
use crate::stages::screws::{accelerate_screws, move_screws, place_screws, shifted, turn_screws};
use crate::stages::shifts::in_world;
use crate::{FrameId, Model, Pose, Workspace};

/// `world_from_frame`: x_world = R x_frame + p. **(MR §3.3)**
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePose<S = f64> {
    /// R, by rows: its columns are the frame's axes in the world.
    pub rotation: [[S; 3]; 3],
    /// p: the frame's origin in the world \[m\].
    pub translation: [S; 3],
}

impl From<FramePose> for Pose {
    fn from(FramePose { rotation, translation }: FramePose) -> Self {
        Self { rotation, translation }
    }
}

/// A velocity (m/s and rad/s) or an acceleration (m/s² and rad/s²) of a frame. Which point the linear part
/// belongs to, and which axes both parts are given in, the function that returns it says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<S = f64> {
    /// The linear part.
    pub linear: [S; 3],
    /// The angular part.
    pub angular: [S; 3],
}

/// `world_from_frame` in the configuration q.
///
/// ```
/// use multibody::{
///     JointDescription, JointKind, LinkDescription, Model, Pose, RobotDescription, Workspace, frame_pose,
/// };
/// # let mass = dynamics::MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::identity()).ok();
/// let mut robot = RobotDescription::new("arm");
/// robot.links.push(LinkDescription { name: "base".into(), mass_properties: None });
/// robot.links.push(LinkDescription { name: "arm".into(), mass_properties: mass });
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
    let mut pose = FramePose { rotation: [[zero; 3]; 3], translation: [zero; 3] };
    run(workspace, OneFramePose { model, q, frame: model.frame_of(frame), pose: &mut pose });
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
    fn run<N: View<S>, H: Hardware>(self, workspace: &mut Workspace<N>) {
        if let Some(body) = self.frame.body {
            place_chain::<_, false>(self.model, workspace, N::view(self.q), body);
        } else {
            crate::model::length::check_length("q", self.q.len(), self.model.nq);
        }
        *self.pose = pose_of(&workspace.world, self.frame);
    }
}

/// `world_from_frame` of every frame, in the order of [`Model::frames`].
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
    run(workspace, FramePoses { model, q, poses });
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
    fn run<N: View<S>, H: Hardware>(self, workspace: &mut Workspace<N>) {
        let Self { model, q, poses } = self;
        place_all_in_world(model, workspace, N::view(q));
        let world = &workspace.world[..];
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

/// The velocity of the frame's origin and ω, along the world's axes \[m/s, rad/s\].
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[doc(alias = "LOCAL_WORLD_ALIGNED")]
#[inline]
#[track_caller]
pub fn frame_velocity_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.admit(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    Moving::moved(model, workspace, q, v, frame).velocity_world_aligned()
}

/// The velocity of the frame's origin and ω, along the frame's own axes \[m/s, rad/s\].
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[doc(alias = "LOCAL")]
#[inline]
#[track_caller]
pub fn frame_velocity_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.admit(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    let moving = Moving::moved(model, workspace, q, v, frame);
    moving.along_own_axes(&moving.velocity_world_aligned())
}

/// ω, and the velocity of the point of the frame's body that passes the world's origin, along the world's
/// axes \[m/s, rad/s\].
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[doc(alias = "WORLD")]
#[inline]
#[track_caller]
pub fn frame_velocity_in_world<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.admit(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    let moving = Moving::moved(model, workspace, q, v, frame);
    moving.at_world_origin(&moving.twist)
}

/// The classical acceleration of the frame's origin, p̈, and ω̇, along the world's axes; the rate of
/// [`frame_velocity_world_aligned`]. Gravity is no part of it \[m/s², rad/s²\].
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[inline]
#[track_caller]
pub fn frame_classical_acceleration_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.admit(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    Moving::accelerated(model, workspace, q, v, Some(a), frame).classical_world_aligned()
}

/// The spatial acceleration at the frame's origin, p̈ − ω × ṗ, and ω̇, along the frame's own axes; the rate of
/// the components of [`frame_velocity_in_frame`]. **(RBDA §2.11)**
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[inline]
#[track_caller]
pub fn frame_spatial_acceleration_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.admit(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    Moving::accelerated(model, workspace, q, v, Some(a), frame).spatial_in_frame()
}

/// The spatial acceleration at the world's origin, along the world's axes; the rate of
/// [`frame_velocity_in_world`]. **(RBDA §2.11)**
///
/// # Panics
/// If a slice has the wrong length, or the frame is another model's.
#[inline]
#[track_caller]
pub fn frame_spatial_acceleration_in_world<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.admit(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    Moving::accelerated(model, workspace, q, v, Some(a), frame).spatial_in_world()
}

/// A frame with its body's motion, in its body's inertial frame of [`place_screws`].
pub(crate) struct Moving<S: Scalar> {
    /// The frame, from the inertial frame.
    pub place: Place<S>,
    pub twist: Screw<S>,
    pub rate: Screw<S>,
    /// The inertial frame's origin in the world.
    pub origin: V3<S>,
}

impl<S: Scalar> Moving<S> {
    /// Reads what [`move_screws`] (and [`accelerate_screws`]) wrote.
    #[inline(always)]
    fn new(model: &Model, workspace: &Workspace<S>, frame: FrameId) -> Self {
        let frame = model.frame_of(frame);
        let own = constant(frame);
        match frame.body {
            Some(body) => Self {
                place: workspace.world[body].then(&own),
                twist: workspace.twist[body],
                rate: workspace.twist_rate[body],
                origin: in_world(model, workspace, body),
            },
            None => Self { place: own, twist: Screw::zero(), rate: Screw::zero(), origin: V3::zero() },
        }
    }

    #[inline(always)]
    pub(crate) fn moved(
        model: &Model,
        workspace: &mut Workspace<S>,
        q: &[S],
        v: &[S],
        frame: FrameId,
    ) -> Self {
        place_screws(model, workspace, q);
        move_screws(model, workspace, v);
        Self::new(model, workspace, frame)
    }

    #[inline(always)]
    pub(crate) fn accelerated(
        model: &Model,
        workspace: &mut Workspace<S>,
        q: &[S],
        v: &[S],
        a: Option<&[S]>,
        frame: FrameId,
    ) -> Self {
        place_screws(model, workspace, q);
        move_screws(model, workspace, v);
        turn_screws(model, workspace);
        accelerate_screws(model, workspace, a);
        Self::new(model, workspace, frame)
    }

    /// ṗ = u + ω × p.
    #[inline(always)]
    fn velocity_world_aligned(&self) -> Twist<S> {
        let Screw { linear, angular } = shifted(&self.twist, self.place.translation);
        Twist { linear: linear.array(), angular: angular.array() }
    }

    /// p̈ = u̇ + ω̇ × p + ω × ṗ.
    #[inline(always)]
    pub(crate) fn classical_world_aligned(&self) -> Twist<S> {
        let velocity = shifted(&self.twist, self.place.translation);
        let spatial = shifted(&self.rate, self.place.translation);
        let linear = spatial.linear + velocity.angular.cross(velocity.linear);
        Twist { linear: linear.array(), angular: spatial.angular.array() }
    }

    #[inline(always)]
    pub(crate) fn spatial_in_frame(&self) -> Twist<S> {
        let Screw { linear, angular } = shifted(&self.rate, self.place.translation);
        self.along_own_axes(&Twist { linear: linear.array(), angular: angular.array() })
    }

    #[inline(always)]
    pub(crate) fn spatial_in_world(&self) -> Twist<S> {
        self.at_world_origin(&self.rate)
    }

    /// A motion of the inertial frame as that of the frame's origin, along the frame's own axes.
    #[inline(always)]
    pub(crate) fn screw_in_frame(&self, motion: &Screw<S>) -> Screw<S> {
        let Screw { linear, angular } = shifted(motion, self.place.translation);
        let turn = &self.place.rotation;
        Screw { linear: turn.transpose_mul(linear), angular: turn.transpose_mul(angular) }
    }

    #[inline(always)]
    fn along_own_axes(&self, twist: &Twist<S>) -> Twist<S> {
        let turn = |v: [S; 3]| self.place.rotation.transpose_mul(V3::new(v)).array();
        Twist { linear: turn(twist.linear), angular: turn(twist.angular) }
    }

    #[inline(always)]
    fn at_world_origin(&self, twist: &Screw<S>) -> Twist<S> {
        let Screw { linear, angular } = shifted(twist, -self.origin);
        Twist { linear: linear.array(), angular: angular.array() }
    }
}
