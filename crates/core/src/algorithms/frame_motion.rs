//! Velocities and accelerations of frames. Cost: O(n).

use robot_dynamics_description::{Pose, check_length};
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use crate::algorithms::kinematics::constant;
use crate::kinematics::shifts::in_world;
use crate::kinematics::world_frame::{
    compute_column_rates, compute_columns, compute_twist_rates, compute_twists, shifted,
};
use crate::spatial::motion::MotionVector;
use crate::spatial::transform::Transform;
use crate::workspace::tree::TreeMemory;
use crate::{Frame, FrameId, Model, ReferenceFrame, Workspace};

/// The velocity of a frame \[m/s, rad/s\]. The [`ReferenceFrame`] states the axes and the reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<S = f64> {
    /// The velocity of the reference point.
    pub linear: [S; 3],
    /// The angular velocity.
    pub angular: [S; 3],
}

/// The acceleration of a frame \[m/s², rad/s²\]: the time derivative of the numbers of a [`Twist`] in the
/// same [`ReferenceFrame`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialAcceleration<S = f64> {
    /// The linear part; see [`frame_acceleration`].
    pub linear: [S; 3],
    /// The angular acceleration.
    pub angular: [S; 3],
}

impl<S: Scalar> From<MotionVector<S>> for Twist<S> {
    #[inline(always)]
    fn from(motion: MotionVector<S>) -> Self {
        Self { linear: motion.linear.array(), angular: motion.angular.array() }
    }
}

impl<S: Scalar> From<MotionVector<S>> for SpatialAcceleration<S> {
    #[inline(always)]
    fn from(motion: MotionVector<S>) -> Self {
        Self { linear: motion.linear.array(), angular: motion.angular.array() }
    }
}

/// The velocity of a frame \[m/s, rad/s\], J v with J of [`frame_jacobian`](crate::frame_jacobian).
///
/// | reference frame | linear part | angular part | axes |
/// | --- | --- | --- | --- |
/// | `Local` | ṗ of the frame's origin p | ω | the frame's |
/// | `World` | ṗ − ω × p | ω | the world's |
/// | `LocalWorldAligned` | ṗ | ω | the world's |
///
/// ```
/// use robot_dynamics::algorithms::{ReferenceFrame, frame_velocity};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, tip) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let mut velocity = |seen| frame_velocity(&model, w, &[0.3], &[3.0], tip, seen);
/// let aligned = velocity(ReferenceFrame::LocalWorldAligned);
/// assert!((aligned.linear[0] + 0.5 * 3.0 * 0.3_f64.sin()).abs() < 1e-14); // l v, across the rod
/// assert!((aligned.linear[2] + 0.5 * 3.0 * 0.3_f64.cos()).abs() < 1e-14);
/// assert!((aligned.angular[1] - 3.0).abs() < 1e-14);
/// // In the rod's axes the tip moves along −z at every angle.
/// let local = velocity(ReferenceFrame::Local);
/// assert!(local.linear[0].abs() < 1e-14 && (local.linear[2] + 0.5 * 3.0).abs() < 1e-14);
/// // The rod's point at the world's origin is the hinge, which does not move.
/// let world = velocity(ReferenceFrame::World);
/// assert!(world.linear.iter().all(|x| x.abs() < 1e-14) && (world.angular[1] - 3.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "frame_velocity_in_frame")]
#[doc(alias = "frame_velocity_in_world")]
#[doc(alias = "frame_velocity_world_aligned")]
#[inline]
#[track_caller]
pub fn frame_velocity<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
    reference_frame: ReferenceFrame,
) -> Twist<S> {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    MovingFrame::moved(model, &mut workspace.tree, q, v, frame).velocity(reference_frame)
}

/// The acceleration of a frame \[m/s², rad/s²\]: the time derivative of the numbers of [`frame_velocity`] in
/// the same reference frame, J a + J̇ v. It does not include gravity. **(RBDA §2.11)**
///
/// | reference frame | linear part | angular part | axes |
/// | --- | --- | --- | --- |
/// | `Local` | spatial, p̈ − ω × ṗ | ω̇ | the frame's |
/// | `World` | spatial, p̈ − ω̇ × p − ω × ṗ | ω̇ | the world's |
/// | `LocalWorldAligned` | classical, p̈ | ω̇ | the world's |
///
/// `Local` and `World` agree with Pinocchio's `getFrameAcceleration`. `LocalWorldAligned` agrees with its
/// `getFrameClassicalAcceleration(LOCAL_WORLD_ALIGNED)`. Its `getFrameAcceleration(LOCAL_WORLD_ALIGNED)`
/// differs by ω × ṗ: it returns the spatial acceleration along the world's axes.
///
/// ```
/// use robot_dynamics::algorithms::{ReferenceFrame, frame_acceleration};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, tip) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let mut acceleration = |q, seen| frame_acceleration(&model, w, &[q], &[3.0], &[2.0], tip, seen);
/// // Horizontal: l v² towards the hinge, l a downwards.
/// let p = acceleration(0.0, ReferenceFrame::LocalWorldAligned).linear;
/// assert!((p[0] + 0.5 * 3.0 * 3.0).abs() < 1e-14 && (p[2] + 0.5 * 2.0).abs() < 1e-14);
/// // In the rod's axes the tip's velocity, l v along −z, changes by l a. The rod's rotation does not count.
/// let rate = acceleration(0.3, ReferenceFrame::Local);
/// assert!(rate.linear[0].abs() < 1e-14 && (rate.linear[2] + 0.5 * 2.0).abs() < 1e-14);
/// // The rod's point at the world's origin is the hinge, which stays at rest.
/// let rate = acceleration(0.3, ReferenceFrame::World);
/// assert!(rate.linear.iter().all(|x| x.abs() < 1e-14) && (rate.angular[1] - 2.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "frame_classical_acceleration_world_aligned")]
#[doc(alias = "frame_spatial_acceleration_in_frame")]
#[doc(alias = "frame_spatial_acceleration_in_world")]
#[inline]
#[track_caller]
pub fn frame_acceleration<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    frame: FrameId,
    reference_frame: ReferenceFrame,
) -> SpatialAcceleration<S> {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    MovingFrame::accelerated(model, &mut workspace.tree, q, v, Some(a), frame).acceleration(reference_frame)
}

/// A frame and its body's motion, in the body's inertial frame of [`compute_columns`].
pub struct MovingFrame<S: Scalar> {
    /// The frame's placement in the inertial frame.
    pub place: Transform<S>,
    pub twist: MotionVector<S>,
    pub rate: MotionVector<S>,
    /// The inertial frame's origin in the world.
    pub origin: V3<S>,
}

impl<S: Scalar> MovingFrame<S> {
    /// Reads the results of [`compute_twists`] and, if called, of [`compute_twist_rates`].
    #[inline(always)]
    fn new(model: &Model, tree: &TreeMemory<S>, frame: FrameId) -> Self {
        Self::of_frame(model, tree, model.frame_of(frame))
    }

    /// The same for any frame on a body.
    #[inline(always)]
    pub fn of_frame(model: &Model, tree: &TreeMemory<S>, frame: &Frame) -> Self {
        let at = Self::at(model, tree, frame.body);
        Self { place: at.place.compose(&constant(frame)), ..at }
    }

    /// The same for a body's own frame, or the world's.
    #[inline(always)]
    pub fn at(model: &Model, tree: &TreeMemory<S>, body: Option<usize>) -> Self {
        match body {
            Some(body) => Self {
                place: tree.world.pose[body],
                twist: tree.world.twist[body],
                rate: tree.world.twist_rate[body],
                origin: in_world(model, tree, body),
            },
            None => Self {
                place: Transform { rotation: M3::from_f64(Pose::IDENTITY.rotation), translation: V3::zero() },
                twist: MotionVector::zero(),
                rate: MotionVector::zero(),
                origin: V3::zero(),
            },
        }
    }

    #[inline(always)]
    pub fn moved(model: &Model, tree: &mut TreeMemory<S>, q: &[S], v: &[S], frame: FrameId) -> Self {
        compute_columns(model, tree, q);
        compute_twists(model, tree, v);
        Self::new(model, tree, frame)
    }

    #[inline(always)]
    pub fn accelerated(
        model: &Model,
        tree: &mut TreeMemory<S>,
        q: &[S],
        v: &[S],
        a: Option<&[S]>,
        frame: FrameId,
    ) -> Self {
        compute_columns(model, tree, q);
        compute_twists(model, tree, v);
        compute_column_rates(model, tree);
        compute_twist_rates(model, tree, a);
        Self::new(model, tree, frame)
    }

    /// The velocity of [`frame_velocity`].
    #[inline(always)]
    pub fn velocity(&self, reference_frame: ReferenceFrame) -> Twist<S> {
        match reference_frame {
            ReferenceFrame::Local => self.motion_in_frame(&self.twist).into(),
            ReferenceFrame::World => self.motion_in_world(&self.twist).into(),
            ReferenceFrame::LocalWorldAligned => self.velocity_world_aligned(),
        }
    }

    /// The acceleration of [`frame_acceleration`].
    #[inline(always)]
    pub fn acceleration(&self, reference_frame: ReferenceFrame) -> SpatialAcceleration<S> {
        match reference_frame {
            ReferenceFrame::Local => self.motion_in_frame(&self.rate).into(),
            ReferenceFrame::World => self.motion_in_world(&self.rate).into(),
            ReferenceFrame::LocalWorldAligned => self.classical_world_aligned(),
        }
    }

    /// ṗ = u + ω × p.
    #[inline(always)]
    pub fn velocity_world_aligned(&self) -> Twist<S> {
        shifted(&self.twist, self.place.translation).into()
    }

    /// p̈ = u̇ + ω̇ × p + ω × ṗ.
    #[inline(always)]
    pub fn classical_world_aligned(&self) -> SpatialAcceleration<S> {
        let velocity = shifted(&self.twist, self.place.translation);
        let spatial = shifted(&self.rate, self.place.translation);
        let linear = spatial.linear + velocity.angular.cross(velocity.linear);
        MotionVector { linear, ..spatial }.into()
    }

    /// A motion in the inertial frame, about the frame's origin and along the frame's own axes.
    #[inline(always)]
    pub fn motion_in_frame(&self, motion: &MotionVector<S>) -> MotionVector<S> {
        let MotionVector { linear, angular } = shifted(motion, self.place.translation);
        let turn = &self.place.rotation;
        MotionVector { linear: turn.transpose_mul(linear), angular: turn.transpose_mul(angular) }
    }

    /// A motion in the inertial frame, about the world's origin.
    #[inline(always)]
    pub fn motion_in_world(&self, motion: &MotionVector<S>) -> MotionVector<S> {
        shifted(motion, -self.origin)
    }
}
