//! Frame Jacobians: 6×nv matrices J with velocity = J v, and the bias accelerations J̇ v. Cost: O(n).
//!
//! Matrices are row-major; the rows are linear x y z, then angular x y z. [`ReferenceFrame`] states the axes
//! and the reference point.

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::V3;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::algorithms::frame_motion::{MovingFrame, SpatialAcceleration};
use crate::algorithms::kinematics::constant;
use crate::kinematics::placement::place_chain;
use crate::model::WORLD;
use crate::model::native::NativeFunction;
use crate::spatial::motion::MotionVector;
use crate::spatial::transform::Transform;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{FrameId, Model, ReferenceFrame, Workspace};

/// J of [`frame_velocity`](crate::frame_velocity) in the same reference frame, 6×nv: velocity = J v.
///
/// The body Jacobian is that in [`ReferenceFrame::Local`], the space Jacobian that in
/// [`ReferenceFrame::World`]. **(MR §5.1)**
///
/// ```
/// use robot_dynamics::algorithms::{ReferenceFrame, frame_jacobian};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, tip) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let mut close = |reference_frame, expected: [f64; 6]| {
///     let mut jacobian = [0.0; 6];
///     frame_jacobian(&model, w, &[0.3], tip, reference_frame, &mut jacobian);
///     jacobian.iter().zip(expected).all(|(j, expected)| (j - expected).abs() < 1e-15)
/// };
/// let across = [-0.5 * 0.3_f64.sin(), 0.0, -0.5 * 0.3_f64.cos(), 0.0, 1.0, 0.0];
/// assert!(close(ReferenceFrame::LocalWorldAligned, across));
/// // In the rod's axes the tip moves along −z at every angle.
/// assert!(close(ReferenceFrame::Local, [0.0, 0.0, -0.5, 0.0, 1.0, 0.0]));
/// // The hinge is at the world's origin: the rod's point there does not move, at every angle.
/// assert!(close(ReferenceFrame::World, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "body Jacobian")]
#[doc(alias = "space Jacobian")]
#[doc(alias = "frame_jacobian_in_frame")]
#[doc(alias = "frame_jacobian_in_world")]
#[doc(alias = "frame_jacobian_world_aligned")]
#[inline]
#[track_caller]
pub fn frame_jacobian<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    reference_frame: ReferenceFrame,
    jacobian: &mut [S],
) {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("the Jacobian", jacobian.len(), 6 * model.nv);
    let (native, function) = (&mut workspace.tree.native, NativeFunction::frame_jacobian(reference_frame));
    if computed_natively(model, native, function.of_frame(frame), &[q], &mut [&mut *jacobian]) {
        return;
    }
    run(&mut workspace.tree, FrameJacobian { model, q, frame, reference_frame, jacobian });
}

/// The arguments of a frame Jacobian.
pub struct FrameJacobian<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub frame: FrameId,
    pub reference_frame: ReferenceFrame,
    pub jacobian: &'a mut [S],
}

compiled_once!(FrameJacobian);

impl<S: Scalar> Kernel<TreeStorage, S> for FrameJacobian<'_, S> {
    /// Places only the bodies between the frame and the root, and writes one column for each of their DoFs.
    /// Columns of mimic joints add to their leaders'. The other columns are zero.
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, frame, reference_frame, jacobian } = self;
        let (q, jacobian) = (N::view(q), N::view_mut(jacobian));
        jacobian.fill(N::zero());
        let frame = model.frame_of(frame);
        let Some(tip) = frame.body else { return };
        // A space Jacobian depends on the robot's position in the world.
        let origin = place_chain::<_, true>(model, tree, q, tip);
        let own = tree.world.pose[tip].compose(&constant(frame));
        // The reference point. Its distance to each axis is computed directly, from a point near the robot,
        // so that accuracy does not suffer far from the world's origin.
        let mut point = if let ReferenceFrame::World = reference_frame { -origin } else { own.translation };
        let mut at = tip;
        while at != WORLD {
            let body = &model.bodies[at];
            let world = &tree.world.pose[at];
            let from_point = Transform { rotation: world.rotation, translation: world.translation - point };
            for k in 0..body.motion.nv() {
                let mut column = body.motion.screw(k, &from_point);
                if let ReferenceFrame::Local = reference_frame {
                    column.linear = own.rotation.transpose_mul(column.linear);
                    column.angular = own.rotation.transpose_mul(column.angular);
                }
                write_reduced(model, jacobian, body.dof + k, &column);
            }
            if body.shifts_reference_point {
                point += tree.world.levers[body.point];
            }
            at = body.parent;
        }
    }
}

/// Adds a tree DoF's column to the 6×nv matrix J G.
#[inline(always)]
fn write_reduced<N: Scalar>(model: &Model, jacobian: &mut [N], index: usize, column: &MotionVector<N>) {
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
pub fn add_column<S: Scalar>(model: &Model, matrix: &mut [S], index: usize, column: &MotionVector<S>) {
    add_entries(model, matrix, index, column.linear, column.angular);
}

/// The same, from the two parts of the column.
#[inline(always)]
pub fn add_entries<S: Scalar>(model: &Model, matrix: &mut [S], index: usize, linear: V3<S>, angular: V3<S>) {
    let dof = &model.dofs[index];
    let entries = linear.array().into_iter().chain(angular.array());
    for (row, entry) in matrix.chunks_exact_mut(model.nv).zip(entries) {
        row[dof.coordinate] += entry.scale(dof.ratio);
    }
}

/// J̇ v of [`frame_jacobian`] in the same reference frame \[m/s², rad/s²\]:
/// [`frame_acceleration`](crate::frame_acceleration) at a = 0.
///
/// It is the classical acceleration in [`ReferenceFrame::LocalWorldAligned`], and the spatial acceleration in
/// the other two.
///
/// ```
/// use nalgebra::DVector;
/// use robot_dynamics::algorithms::{ReferenceFrame, frame_acceleration, frame_bias_acceleration};
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // The acceleration is J a + J̇ v.
/// let (w, hand) = (&mut Workspace::new(&model), model.frame_named("link9")?);
/// for seen in ReferenceFrame::ALL {
///     let bias = frame_bias_acceleration(&model, w, &q, &v, hand, seen);
///     let by_a = model.frame_jacobian(&q, hand, seen)? * DVector::from_column_slice(&a);
///     let acceleration = frame_acceleration(&model, w, &q, &v, &a, hand, seen);
///     assert!((0..3).all(|i| (acceleration.linear[i] - by_a[i] - bias.linear[i]).abs() < 1e-11));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "frame_bias_acceleration_in_frame")]
#[doc(alias = "frame_bias_acceleration_in_world")]
#[doc(alias = "frame_bias_acceleration_world_aligned")]
#[inline]
#[track_caller]
pub fn frame_bias_acceleration<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
    reference_frame: ReferenceFrame,
) -> SpatialAcceleration<S> {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    MovingFrame::accelerated(model, &mut workspace.tree, q, v, None, frame).acceleration(reference_frame)
}
