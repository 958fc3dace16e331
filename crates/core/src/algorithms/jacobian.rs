//! Frame Jacobians: 6×nv matrices J with twist = J v, and the bias accelerations J̇ v. Cost: O(n).
//!
//! Matrices are row-major; the rows are linear x y z, then angular x y z. The three forms are those of
//! [`Twist`]: world aligned, in the frame, in the world. **(MR §5.1)**

use robot_dynamics_description::check_length;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::algorithms::frame_motion::{Moving, Twist};
use crate::algorithms::kinematics::constant;
use crate::kinematics::place::place_chain;
use crate::model::WORLD;
use crate::model::native::NativeFunction;
use crate::spatial::screw::{Screw, Transform};
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{OverNumber, TreeMemory};
use crate::{FrameId, Model, Workspace};

/// J of [`frame_velocity_world_aligned`](crate::frame_velocity_world_aligned): the velocity of the frame's
/// origin and ω along the world's axes, 6×nv.
///
/// ```
/// use robot_dynamics::algorithms::frame_jacobian_world_aligned;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (tip, mut jacobian) = (model.frame_named("tip")?, [0.0; 6]);
/// frame_jacobian_world_aligned(&model, &mut Workspace::new(&model), &[0.3], tip, &mut jacobian);
/// let expected = [-0.5 * 0.3_f64.sin(), 0.0, -0.5 * 0.3_f64.cos(), 0.0, 1.0, 0.0];
/// assert!(jacobian.iter().zip(expected).all(|(j, expected)| (j - expected).abs() < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[inline]
#[track_caller]
pub fn frame_jacobian_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    jacobian: &mut [S],
) {
    write_jacobian(workspace, FrameJacobian { model, q, frame, seen: Seen::WorldAligned, jacobian });
}

/// J of [`frame_velocity_in_frame`](crate::frame_velocity_in_frame): the velocity of the frame's origin and ω
/// along the frame's own axes, 6×nv. The body Jacobian. **(MR §5.1.2)**
///
/// ```
/// use robot_dynamics::algorithms::frame_jacobian_in_frame;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // In the rod's axes the tip moves along −z at every angle.
/// let (tip, mut jacobian) = (model.frame_named("tip")?, [0.0; 6]);
/// frame_jacobian_in_frame(&model, &mut Workspace::<f64>::new(&model), &[0.3], tip, &mut jacobian);
/// let expected = [0.0, 0.0, -0.5, 0.0, 1.0, 0.0];
/// assert!(jacobian.iter().zip(expected).all(|(j, expected)| (j - expected).abs() < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "body Jacobian")]
#[inline]
#[track_caller]
pub fn frame_jacobian_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    jacobian: &mut [S],
) {
    write_jacobian(workspace, FrameJacobian { model, q, frame, seen: Seen::InFrame, jacobian });
}

/// J of [`frame_velocity_in_world`](crate::frame_velocity_in_world): ω and the velocity of the point that
/// coincides with the world's origin, along the world's axes, 6×nv. The space Jacobian. **(MR §5.1.1)**
///
/// ```
/// use robot_dynamics::algorithms::frame_jacobian_in_world;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // The hinge is at the world's origin: the rod's point there does not move, at every angle.
/// let (tip, mut jacobian) = (model.frame_named("tip")?, [0.0; 6]);
/// frame_jacobian_in_world(&model, &mut Workspace::<f64>::new(&model), &[0.3], tip, &mut jacobian);
/// let expected = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// assert!(jacobian.iter().zip(expected).all(|(j, expected)| (j - expected).abs() < 1e-15));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "space Jacobian")]
#[inline]
#[track_caller]
pub fn frame_jacobian_in_world<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    jacobian: &mut [S],
) {
    write_jacobian(workspace, FrameJacobian { model, q, frame, seen: Seen::InWorld, jacobian });
}

/// Checks the arguments, and writes the Jacobian by machine code or by the recursion.
#[inline]
#[track_caller]
fn write_jacobian<S: Scalar>(workspace: &mut Workspace<S>, task: FrameJacobian<'_, S>) {
    let FrameJacobian { model, q, frame, seen, jacobian } = task;
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("the Jacobian", jacobian.len(), 6 * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, seen.native().of_frame(frame), &[q], &mut [&mut *jacobian]) {
        return;
    }
    run(&mut workspace.tree, FrameJacobian { model, q, frame, seen, jacobian });
}

/// The axes and the reference point of a Jacobian.
#[derive(Clone, Copy)]
pub enum Seen {
    WorldAligned,
    InFrame,
    InWorld,
}

impl Seen {
    /// The native function of this form, which may have machine code.
    pub fn native(self) -> NativeFunction {
        match self {
            Self::WorldAligned => NativeFunction::FrameJacobianWorldAligned,
            Self::InFrame => NativeFunction::FrameJacobianInFrame,
            Self::InWorld => NativeFunction::FrameJacobianInWorld,
        }
    }
}

/// The arguments of a frame Jacobian.
pub struct FrameJacobian<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub frame: FrameId,
    pub seen: Seen,
    pub jacobian: &'a mut [S],
}

compiled_once!(pub FrameJacobianKind, FrameJacobian);

impl<S: Scalar> Kernel<OverNumber, S> for FrameJacobian<'_, S> {
    /// Places only the bodies between the frame and the root, and writes one column for each of their DoFs.
    /// Columns of mimic joints add to their leaders'. The other columns are zero.
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, frame, seen, jacobian } = self;
        let (q, jacobian) = (N::view(q), N::view_mut(jacobian));
        jacobian.fill(N::zero());
        let frame = model.frame_of(frame);
        let Some(tip) = frame.body else { return };
        // A space Jacobian depends on the robot's position in the world.
        let origin = place_chain::<_, true>(model, tree, q, tip);
        let own = tree.screws.world[tip].then(&constant(frame));
        // The reference point. Its distance to each axis is computed directly, from a point near the robot,
        // so that accuracy does not suffer far from the world's origin.
        let mut point = if let Seen::InWorld = seen { -origin } else { own.translation };
        let mut at = tip;
        while at != WORLD {
            let body = &model.bodies[at];
            let world = &tree.screws.world[at];
            let from_point = Transform { rotation: world.rotation, translation: world.translation - point };
            for k in 0..body.motion.nv() {
                let mut column = body.motion.screw(k, &from_point);
                if let Seen::InFrame = seen {
                    column.linear = own.rotation.transpose_mul(column.linear);
                    column.angular = own.rotation.transpose_mul(column.angular);
                }
                write_reduced(model, jacobian, body.dof + k, &column);
            }
            if body.shifts_reference_point {
                point += tree.screws.levers[body.point];
            }
            at = body.parent;
        }
    }
}

/// Adds a tree DoF's column to the 6×nv matrix J G.
#[inline(always)]
fn write_reduced<N: Scalar>(model: &Model, jacobian: &mut [N], index: usize, column: &Screw<N>) {
    let (dof, nv) = (&model.dofs[index], model.nv);
    let ([x, y, z], [a, b, c]) = (column.linear.array(), column.angular.array());
    let rows = &mut jacobian[dof.coordinate..=dof.coordinate + 5 * nv];
    if model.needs_dense_factor {
        for (row, entry) in [x, y, z, a, b, c].into_iter().enumerate() {
            rows[row * nv] += entry.scale(dof.ratio);
        }
    } else {
        rows[0] = x;
        rows[nv] = y;
        rows[2 * nv] = z;
        rows[3 * nv] = a;
        rows[4 * nv] = b;
        rows[5 * nv] = c;
    }
}

/// Adds a tree DoF's column to a 6×nv matrix J G.
#[inline(always)]
pub fn add_column<S: Scalar>(model: &Model, matrix: &mut [S], index: usize, column: &Screw<S>) {
    let dof = &model.dofs[index];
    let entries = column.linear.array().into_iter().chain(column.angular.array());
    for (row, entry) in matrix.chunks_exact_mut(model.nv).zip(entries) {
        row[dof.coordinate] += entry.scale(dof.ratio);
    }
}

/// J̇ v of [`frame_jacobian_world_aligned`]: the classical acceleration p̈ of the frame's origin, and ω̇, at
/// a = 0, along the world's axes \[m/s², rad/s²\].
///
/// ```
/// use robot_dynamics::algorithms::frame_bias_acceleration_world_aligned;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // At constant speed the tip accelerates towards the hinge, l v².
/// let (w, tip) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let bias = frame_bias_acceleration_world_aligned(&model, w, &[0.0], &[3.0], tip);
/// assert!((bias.linear[0] + 0.5 * 3.0 * 3.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[inline]
#[track_caller]
pub fn frame_bias_acceleration_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    Moving::accelerated(model, &mut workspace.tree, q, v, None, frame).classical_world_aligned()
}

/// J̇ v of [`frame_jacobian_in_frame`]: the spatial acceleration at the frame's origin at a = 0, along the
/// frame's own axes \[m/s², rad/s²\].
///
/// ```
/// use robot_dynamics::algorithms::frame_bias_acceleration_in_frame;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // In the rod's axes the tip's velocity, l v along −z, does not change.
/// let (w, tip) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let bias = frame_bias_acceleration_in_frame(&model, w, &[0.3], &[3.0], tip);
/// assert!(bias.linear.iter().chain(&bias.angular).all(|x| x.abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[inline]
#[track_caller]
pub fn frame_bias_acceleration_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    Moving::accelerated(model, &mut workspace.tree, q, v, None, frame).spatial_in_frame()
}

/// J̇ v of [`frame_jacobian_in_world`]: the spatial acceleration at the world's origin at a = 0, along the
/// world's axes \[m/s², rad/s²\].
///
/// ```
/// use nalgebra::DVector;
/// use robot_dynamics::algorithms::frame_bias_acceleration_in_world;
/// use robot_dynamics::algorithms::frame_spatial_acceleration_in_world;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // The acceleration is J a + J̇ v.
/// let (w, hand) = (&mut Workspace::new(&model), model.frame_named("link9")?);
/// let bias = frame_bias_acceleration_in_world(&model, w, &q, &v, hand);
/// let by_a = model.frame_jacobian_in_world(&q, hand)? * DVector::from_column_slice(&a);
/// let acceleration = frame_spatial_acceleration_in_world(&model, w, &q, &v, &a, hand);
/// assert!((0..3).all(|i| (acceleration.linear[i] - by_a[i] - bias.linear[i]).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[inline]
#[track_caller]
pub fn frame_bias_acceleration_in_world<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
) -> Twist<S> {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    Moving::accelerated(model, &mut workspace.tree, q, v, None, frame).spatial_in_world()
}
