//! The derivatives of frame velocities and accelerations by configuration and velocity.
//!
//! With ψ and ψ′ of [`derivatives`](super), for the DoFs j from the root to the frame:
//!
//! ∂V/∂q_j = S_j × V + ψ_j, ∂A/∂q_j = S_j × A + ψ_j × V + ψ′_j,
//! ∂V/∂v_j = ∂A/∂a_j = S_j, ∂A/∂v_j = Ṡ_j + ψ_j + S_j × V.
//!
//! Along axes that rotate with the frame, the products with S_j vanish. Cost: O(n).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::algorithms::frame_motion::Moving;
use crate::algorithms::jacobian::add_column;
use crate::kinematics::screws::{motion_cross, shifted};
use crate::model::WORLD;
use crate::spatial::screw::{Force, Screw};
use crate::workspace::tree::TreeMemory;
use crate::{FrameId, Model, Workspace};

/// A DoF between the root and a frame, about the reference point of the frame's body.
struct Carrier<S: Scalar> {
    dof: usize,
    /// S and Ṡ.
    s: Screw<S>,
    turned: Screw<S>,
    /// V and A of the parent.
    velocity: Screw<S>,
    acceleration: Screw<S>,
}

/// Calls `column` with each DoF between the root and the frame.
#[inline(always)]
fn for_each_carrier<S: Scalar>(
    model: &Model,
    tree: &TreeMemory<S>,
    frame: FrameId,
    mut column: impl FnMut(&Carrier<S>),
) {
    let mut at = model.frame_of(frame).body.unwrap_or(WORLD);
    // From the DoF's reference point to the frame's.
    let mut arm = V3::zero();
    while at != WORLD {
        let body = &model.bodies[at];
        let own_arm = arm;
        if body.shifts_reference_point {
            arm += tree.screws.levers[body.point];
        }
        let (velocity, acceleration) = if body.parent == WORLD {
            (Force::zero(), Force::zero())
        } else {
            (
                shifted(&tree.screws.twist[body.parent], arm),
                shifted(&tree.screws.twist_rate[body.parent], arm),
            )
        };
        for dof in body.dof..body.dof + body.motion.nv() {
            let [s, turned] =
                [&tree.screws.column[dof], &tree.screws.column_rate[dof]].map(|s| shifted(s, own_arm));
            column(&Carrier { dof, s, turned, velocity, acceleration });
        }
        at = body.parent;
    }
}

#[inline(always)]
fn sum<S: Scalar>(a: &Screw<S>, b: &Screw<S>) -> Screw<S> {
    Screw { linear: a.linear + b.linear, angular: a.angular + b.angular }
}

/// ∂/∂q, 6×nv, of [`frame_velocity_in_frame`](crate::frame_velocity_in_frame). ∂/∂v is
/// [`frame_jacobian_in_frame`](crate::frame_jacobian_in_frame).
///
/// For a quaternion joint, column j is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::frame_bias_acceleration_in_frame;
/// use robot_dynamics::derivatives::frame_velocity_derivative_in_frame;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // At constant v, the velocity J v changes along the motion by (∂(J v)/∂q) v = J̇ v.
/// let (w, hand) = (&mut Workspace::new(&model), model.frame_named("link9")?);
/// let mut by_position = vec![0.0; 6 * model.nv()];
/// frame_velocity_derivative_in_frame(&model, w, &q, &v, hand, &mut by_position);
/// let rate = DMatrix::from_row_slice(6, model.nv(), &by_position) * DVector::from_column_slice(&v);
/// let bias = frame_bias_acceleration_in_frame(&model, w, &q, &v, hand);
/// assert!((0..3).all(|i| (rate[i] - bias.linear[i]).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[inline]
#[track_caller]
pub fn frame_velocity_derivative_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
    by_position: &mut [S],
) {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("the derivative of the velocity", by_position.len(), 6 * model.nv);
    let moving = Moving::moved(model, &mut workspace.tree, q, v, frame);
    by_position.fill(S::zero());
    for_each_carrier(model, &workspace.tree, frame, |Carrier { dof, s, velocity, .. }| {
        let carried = motion_cross(velocity, s);
        add_column(model, by_position, *dof, &moving.screw_in_frame(&carried));
    });
}

/// ∂/∂q, 6×nv, of [`frame_velocity_world_aligned`](crate::frame_velocity_world_aligned). ∂/∂v is
/// [`frame_jacobian_world_aligned`](crate::frame_jacobian_world_aligned).
///
/// For the frame's origin p, ṗ = u + ω × p gives
///
/// ∂ṗ/∂q_j = ∂u + ∂ω × p + ω × ∂p, ∂p = s_j + σ_j × p.
///
/// For a quaternion joint, column j is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use robot_dynamics::derivatives::frame_velocity_derivative_world_aligned;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // ṗ = l v (−sin q, 0, −cos q), and ω = v about y at every q.
/// let (w, tip, mut by_position) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?, [0.0; 6]);
/// frame_velocity_derivative_world_aligned(&model, w, &[0.3], &[3.0], tip, &mut by_position);
/// let expected = [-1.5 * 0.3_f64.cos(), 0.0, 1.5 * 0.3_f64.sin(), 0.0, 0.0, 0.0];
/// assert!(by_position.iter().zip(expected).all(|(slope, expected)| (slope - expected).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[inline]
#[track_caller]
pub fn frame_velocity_derivative_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
    by_position: &mut [S],
) {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("the derivative of the velocity", by_position.len(), 6 * model.nv);
    let moving = Moving::moved(model, &mut workspace.tree, q, v, frame);
    by_position.fill(S::zero());
    let point = moving.place.translation;
    for_each_carrier(model, &workspace.tree, frame, |Carrier { dof, s, velocity, .. }| {
        let mut change = motion_cross(s, &moving.twist);
        change.add(&motion_cross(velocity, s));
        let mut change = shifted(&change, point);
        change.linear += moving.twist.angular.cross(shifted(s, point).linear);
        add_column(model, by_position, *dof, &change);
    });
}

/// ∂/∂q and ∂/∂v, 6×nv each, of
/// [`frame_spatial_acceleration_in_frame`](crate::frame_spatial_acceleration_in_frame). ∂/∂a is
/// [`frame_jacobian_in_frame`](crate::frame_jacobian_in_frame).
///
/// For a quaternion joint, column j of ∂/∂q is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::frame_bias_acceleration_in_frame;
/// use robot_dynamics::derivatives::frame_acceleration_derivatives_in_frame;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // J̇ v is quadratic in v, so its derivative times v is twice J̇ v.
/// let (w, hand) = (&mut Workspace::new(&model), model.frame_named("link9")?);
/// let (mut by_position, mut by_velocity) = (vec![0.0; 6 * model.nv()], vec![0.0; 6 * model.nv()]);
/// frame_acceleration_derivatives_in_frame(&model, w, &q, &v, &a, hand, &mut by_position, &mut by_velocity);
/// let twice = DMatrix::from_row_slice(6, model.nv(), &by_velocity) * DVector::from_column_slice(&v);
/// let bias = frame_bias_acceleration_in_frame(&model, w, &q, &v, hand);
/// assert!((0..3).all(|i| (twice[i] - 2.0 * bias.linear[i]).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[allow(clippy::too_many_arguments)] // as the acceleration, with two results
#[inline]
#[track_caller]
pub fn frame_acceleration_derivatives_in_frame<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    frame: FrameId,
    by_position: &mut [S],
    by_velocity: &mut [S],
) {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("the derivative by q", by_position.len(), 6 * model.nv);
    check_length("the derivative by v", by_velocity.len(), 6 * model.nv);
    let moving = Moving::accelerated(model, &mut workspace.tree, q, v, Some(a), frame);
    by_position.fill(S::zero());
    by_velocity.fill(S::zero());
    for_each_carrier(model, &workspace.tree, frame, |Carrier { dof, s, turned, velocity, acceleration }| {
        let once = motion_cross(velocity, s);
        let mut change = motion_cross(&once, &moving.twist);
        change.add(&motion_cross(acceleration, s));
        change.add(&motion_cross(velocity, &once));
        add_column(model, by_position, *dof, &moving.screw_in_frame(&change));
        let mut change = sum(turned, &once);
        change.add(&motion_cross(s, &moving.twist));
        add_column(model, by_velocity, *dof, &moving.screw_in_frame(&change));
    });
}

/// ∂/∂q and ∂/∂v, 6×nv each, of
/// [`frame_classical_acceleration_world_aligned`](crate::frame_classical_acceleration_world_aligned). ∂/∂a is
/// [`frame_jacobian_world_aligned`](crate::frame_jacobian_world_aligned).
///
/// The frame's origin p has p̈ = u̇ + ω̇ × p + ω × ṗ. For a quaternion joint, column j of ∂/∂q is the rate
/// along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use robot_dynamics::derivatives::frame_acceleration_derivatives_world_aligned;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // At q = 0, p̈ = l (−v², 0, −a): it rotates with the rod, and ∂(−v²)/∂v = −2 v.
/// let (w, tip) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let (mut by_q, mut by_v) = ([0.0; 6], [0.0; 6]);
/// frame_acceleration_derivatives_world_aligned(&model, w, &[0.0], &[3.0], &[2.0], tip, &mut by_q, &mut by_v);
/// assert!((by_q[0] + 0.5 * 2.0).abs() < 1e-14 && (by_q[2] - 0.5 * 9.0).abs() < 1e-14);
/// assert!((by_v[0] + 0.5 * 2.0 * 3.0).abs() < 1e-14 && by_v[2].abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[allow(clippy::too_many_arguments)] // as the acceleration, with two results
#[inline]
#[track_caller]
pub fn frame_acceleration_derivatives_world_aligned<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    frame: FrameId,
    by_position: &mut [S],
    by_velocity: &mut [S],
) {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("the derivative by q", by_position.len(), 6 * model.nv);
    check_length("the derivative by v", by_velocity.len(), 6 * model.nv);
    let moving = Moving::accelerated(model, &mut workspace.tree, q, v, Some(a), frame);
    by_position.fill(S::zero());
    by_velocity.fill(S::zero());
    let (twist, rate) = (&moving.twist, &moving.rate);
    let point = moving.place.translation;
    let own = shifted(twist, point);
    for_each_carrier(model, &workspace.tree, frame, |Carrier { dof, s, turned, velocity, acceleration }| {
        let once = motion_cross(velocity, s);
        let moved = shifted(s, point).linear;
        // ∂V and ∂A at the inertial frame's origin, then the derivative of each factor of p̈.
        let twist_change = sum(&motion_cross(s, twist), &once);
        let mut change = motion_cross(s, rate);
        change.add(&motion_cross(&once, twist));
        change.add(&motion_cross(acceleration, s));
        change.add(&motion_cross(velocity, &once));
        let velocity_change = shifted(&twist_change, point).linear + twist.angular.cross(moved);
        let mut change = shifted(&change, point);
        change.linear += rate.angular.cross(moved)
            + twist_change.angular.cross(own.linear)
            + twist.angular.cross(velocity_change);
        add_column(model, by_position, *dof, &change);
        let mut change = sum(turned, &once);
        change.add(&motion_cross(s, twist));
        let mut change = shifted(&change, point);
        change.linear += s.angular.cross(own.linear) + twist.angular.cross(moved);
        add_column(model, by_velocity, *dof, &change);
    });
}
