//! The derivatives of frame velocities and accelerations by configuration and velocity.
//!
//! With ψ and ψ′ of [`derivatives`](super), for the DoFs j from the root to the frame:
//!
//! ∂V/∂q_j = S_j × V + ψ_j, ∂A/∂q_j = S_j × A + ψ_j × V + ψ′_j,
//! ∂V/∂v_j = ∂A/∂a_j = S_j, ∂A/∂v_j = Ṡ_j + ψ_j + S_j × V.
//!
//! Along axes that rotate with the frame (`ReferenceFrame::Local`), the products with S_j vanish. Cost: O(n).

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::V3;

use crate::algorithms::frame_motion::MovingFrame;
use crate::algorithms::jacobian::add_column;
use crate::kinematics::world_frame::{motion_cross, shifted};
use crate::model::WORLD;
use crate::spatial::motion::MotionVector;
use crate::workspace::tree::TreeMemory;
use crate::{FrameId, Model, ReferenceFrame, Workspace};

/// A DoF between the root and a frame, about the reference point of the frame's body.
pub(super) struct AncestorDof<S: Scalar> {
    pub dof: usize,
    /// S and Ṡ.
    pub s: MotionVector<S>,
    turned: MotionVector<S>,
    /// V and A of the parent.
    velocity: MotionVector<S>,
    acceleration: MotionVector<S>,
}

/// Calls `column` with each DoF between the root and the frame.
#[inline(always)]
pub(super) fn for_each_ancestor<S: Scalar>(
    model: &Model,
    tree: &TreeMemory<S>,
    frame: FrameId,
    mut column: impl FnMut(&AncestorDof<S>),
) {
    let mut at = model.frame_of(frame).body.unwrap_or(WORLD);
    // From the DoF's reference point to the frame's.
    let mut arm = V3::zero();
    while at != WORLD {
        let body = &model.bodies[at];
        let own_arm = arm;
        if body.shifts_reference_point {
            arm += tree.world.levers[body.point];
        }
        let (velocity, acceleration) = if body.parent == WORLD {
            (MotionVector::zero(), MotionVector::zero())
        } else {
            (shifted(&tree.world.twist[body.parent], arm), shifted(&tree.world.twist_rate[body.parent], arm))
        };
        for dof in body.dof..body.dof + body.motion.nv() {
            let [s, turned] =
                [&tree.world.column[dof], &tree.world.column_rate[dof]].map(|s| shifted(s, own_arm));
            column(&AncestorDof { dof, s, turned, velocity, acceleration });
        }
        at = body.parent;
    }
}

#[inline(always)]
fn sum<S: Scalar>(a: &MotionVector<S>, b: &MotionVector<S>) -> MotionVector<S> {
    MotionVector { linear: a.linear + b.linear, angular: a.angular + b.angular }
}

/// ∂/∂q, 6×nv, of [`frame_velocity`](crate::frame_velocity) in the same reference frame. ∂/∂v is
/// [`frame_jacobian`](crate::frame_jacobian).
///
/// For a quaternion joint, column j is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::{ReferenceFrame, frame_bias_acceleration};
/// use robot_dynamics::derivatives::frame_velocity_derivative;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // At constant v, the velocity J v changes along the motion by (∂(J v)/∂q) v = J̇ v.
/// let (w, hand) = (&mut Workspace::new(&model), model.frame_named("link9")?);
/// let mut by_position = vec![0.0; 6 * model.nv()];
/// for seen in ReferenceFrame::ALL {
///     frame_velocity_derivative(&model, w, &q, &v, hand, seen, &mut by_position);
///     let rate = DMatrix::from_row_slice(6, model.nv(), &by_position) * DVector::from_column_slice(&v);
///     let bias = frame_bias_acceleration(&model, w, &q, &v, hand, seen);
///     assert!((0..3).all(|i| (rate[i] - bias.linear[i]).abs() < 1e-11));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "frame_velocity_derivative_in_frame")]
#[doc(alias = "frame_velocity_derivative_world_aligned")]
#[inline]
#[track_caller]
pub fn frame_velocity_derivative<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    frame: FrameId,
    reference_frame: ReferenceFrame,
    by_position: &mut [S],
) {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("the derivative of the velocity", by_position.len(), 6 * model.nv);
    let moving = MovingFrame::moved(model, &mut workspace.tree, q, v, frame);
    by_position.fill(S::zero());
    let (tree, twist, point) = (&workspace.tree, &moving.twist, moving.place.translation);
    match reference_frame {
        ReferenceFrame::Local => {
            for_each_ancestor(model, tree, frame, |AncestorDof { dof, s, velocity, .. }| {
                let carried = motion_cross(velocity, s);
                add_column(model, by_position, *dof, &moving.motion_in_frame(&carried));
            });
        }
        ReferenceFrame::World => {
            for_each_ancestor(model, tree, frame, |AncestorDof { dof, s, velocity, .. }| {
                let change = sum(&motion_cross(s, twist), &motion_cross(velocity, s));
                add_column(model, by_position, *dof, &moving.motion_in_world(&change));
            });
        }
        // ∂ṗ = ∂u + ∂ω × p + ω × ∂p with ∂p = s + σ × p.
        ReferenceFrame::LocalWorldAligned => {
            for_each_ancestor(model, tree, frame, |AncestorDof { dof, s, velocity, .. }| {
                let change = sum(&motion_cross(s, twist), &motion_cross(velocity, s));
                let mut change = shifted(&change, point);
                change.linear += twist.angular.cross(shifted(s, point).linear);
                add_column(model, by_position, *dof, &change);
            });
        }
    }
}

/// The inputs of [`frame_acceleration_derivatives`].
#[derive(Clone, Copy, Debug)]
pub struct FrameAccelerationInputs<'a, S> {
    /// The configuration, nq numbers.
    pub q: &'a [S],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [S],
    /// The acceleration, nv numbers \[rad/s², m/s²\].
    pub a: &'a [S],
    /// The frame.
    pub frame: FrameId,
    /// The axes and the point of the acceleration.
    pub reference_frame: ReferenceFrame,
}

/// The outputs of [`frame_acceleration_derivatives`], 6×nv by rows.
#[derive(Debug)]
pub struct FrameAccelerationDerivativesMut<'a, S> {
    /// ∂/∂q, along the directions of v.
    pub by_position: &'a mut [S],
    /// ∂/∂v.
    pub by_velocity: &'a mut [S],
}

/// ∂/∂q and ∂/∂v, 6×nv each, of [`frame_acceleration`](crate::frame_acceleration) in the same reference frame.
/// ∂/∂a is [`frame_jacobian`](crate::frame_jacobian).
///
/// For a quaternion joint, column j of ∂/∂q is the rate along [`integrate`](crate::integrate)(q, δ eⱼ).
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use robot_dynamics::algorithms::{ReferenceFrame, frame_bias_acceleration};
/// use robot_dynamics::derivatives::{FrameAccelerationDerivativesMut, FrameAccelerationInputs};
/// use robot_dynamics::derivatives::frame_acceleration_derivatives;
/// use robot_dynamics::model::Workspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // J̇ v is quadratic in v, so its derivative times v is twice J̇ v.
/// let (w, hand) = (&mut Workspace::new(&model), model.frame_named("link9")?);
/// let (mut by_q, mut by_v) = (vec![0.0; 6 * model.nv()], vec![0.0; 6 * model.nv()]);
/// for seen in ReferenceFrame::ALL {
///     let inputs = FrameAccelerationInputs { q: &q, v: &v, a: &a, frame: hand, reference_frame: seen };
///     let outputs = FrameAccelerationDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
///     frame_acceleration_derivatives(&model, w, inputs, outputs);
///     let twice = DMatrix::from_row_slice(6, model.nv(), &by_v) * DVector::from_column_slice(&v);
///     let bias = frame_bias_acceleration(&model, w, &q, &v, hand, seen);
///     assert!((0..3).all(|i| (twice[i] - 2.0 * bias.linear[i]).abs() < 1e-11));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "frame_acceleration_derivatives_in_frame")]
#[doc(alias = "frame_acceleration_derivatives_world_aligned")]
#[inline]
#[track_caller]
pub fn frame_acceleration_derivatives<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    inputs: FrameAccelerationInputs<'_, S>,
    results: FrameAccelerationDerivativesMut<'_, S>,
) {
    let FrameAccelerationInputs { q, v, a, frame, reference_frame } = inputs;
    let FrameAccelerationDerivativesMut { by_position, by_velocity } = results;
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("the derivative by q", by_position.len(), 6 * model.nv);
    check_length("the derivative by v", by_velocity.len(), 6 * model.nv);
    let moving = MovingFrame::accelerated(model, &mut workspace.tree, q, v, Some(a), frame);
    by_position.fill(S::zero());
    by_velocity.fill(S::zero());
    let (tree, derivatives) = (&workspace.tree, FrameAccelerationDerivatives { model, moving: &moving });
    match reference_frame {
        ReferenceFrame::Local => for_each_ancestor(model, tree, frame, |ancestor| {
            derivatives.add_local(ancestor, by_position, by_velocity);
        }),
        ReferenceFrame::World => for_each_ancestor(model, tree, frame, |ancestor| {
            derivatives.add_world(ancestor, by_position, by_velocity);
        }),
        ReferenceFrame::LocalWorldAligned => {
            let own = shifted(&moving.twist, moving.place.translation);
            for_each_ancestor(model, tree, frame, |ancestor| {
                derivatives.add_local_world_aligned(ancestor, &own, by_position, by_velocity);
            });
        }
    }
}

/// The columns of [`frame_acceleration_derivatives`] for one DoF.
struct FrameAccelerationDerivatives<'a, S: Scalar> {
    model: &'a Model,
    moving: &'a MovingFrame<S>,
}

impl<S: Scalar> FrameAccelerationDerivatives<'_, S> {
    #[inline(always)]
    fn add_local(&self, ancestor: &AncestorDof<S>, by_position: &mut [S], by_velocity: &mut [S]) {
        let (Self { model, moving }, AncestorDof { dof, s, velocity, acceleration, .. }) = (self, ancestor);
        let once = motion_cross(velocity, s);
        let mut change = motion_cross(&once, &moving.twist);
        change.add(&motion_cross(acceleration, s));
        change.add(&motion_cross(velocity, &once));
        add_column(model, by_position, *dof, &moving.motion_in_frame(&change));
        let by_v = self.spatial_by_velocity(ancestor, &once);
        add_column(model, by_velocity, *dof, &moving.motion_in_frame(&by_v));
    }

    #[inline(always)]
    fn add_world(&self, ancestor: &AncestorDof<S>, by_position: &mut [S], by_velocity: &mut [S]) {
        let (Self { model, moving }, dof) = (self, ancestor.dof);
        let [by_q, by_v] = self.spatial(ancestor, &motion_cross(&ancestor.velocity, &ancestor.s));
        add_column(model, by_position, dof, &moving.motion_in_world(&by_q));
        add_column(model, by_velocity, dof, &moving.motion_in_world(&by_v));
    }

    /// The derivative of each factor of p̈ = u̇ + ω̇ × p + ω × ṗ; `own` is ṗ and ω.
    #[inline(always)]
    fn add_local_world_aligned(
        &self,
        ancestor: &AncestorDof<S>,
        own: &MotionVector<S>,
        by_position: &mut [S],
        by_velocity: &mut [S],
    ) {
        let (Self { model, moving }, AncestorDof { dof, s, velocity, .. }) = (self, ancestor);
        let (twist, rate, point) = (&moving.twist, &moving.rate, moving.place.translation);
        let once = motion_cross(velocity, s);
        let moved = shifted(s, point).linear;
        let twist_change = sum(&motion_cross(s, twist), &once);
        let velocity_change = shifted(&twist_change, point).linear + twist.angular.cross(moved);
        let [by_q, by_v] = self.spatial(ancestor, &once);
        let mut change = shifted(&by_q, point);
        change.linear += rate.angular.cross(moved)
            + twist_change.angular.cross(own.linear)
            + twist.angular.cross(velocity_change);
        add_column(model, by_position, *dof, &change);
        let mut change = shifted(&by_v, point);
        change.linear += s.angular.cross(own.linear) + twist.angular.cross(moved);
        add_column(model, by_velocity, *dof, &change);
    }

    /// ∂A/∂q and ∂A/∂v at the inertial frame's origin, along the world's axes; `once` is ψ.
    #[inline(always)]
    fn spatial(&self, ancestor: &AncestorDof<S>, once: &MotionVector<S>) -> [MotionVector<S>; 2] {
        let (twist, AncestorDof { s, velocity, acceleration, .. }) = (&self.moving.twist, ancestor);
        let mut by_q = motion_cross(s, &self.moving.rate);
        by_q.add(&motion_cross(once, twist));
        by_q.add(&motion_cross(acceleration, s));
        by_q.add(&motion_cross(velocity, once));
        [by_q, self.spatial_by_velocity(ancestor, once)]
    }

    /// ∂A/∂v_j = Ṡ_j + ψ_j + S_j × V, in the inertial frame.
    #[inline(always)]
    fn spatial_by_velocity(&self, ancestor: &AncestorDof<S>, once: &MotionVector<S>) -> MotionVector<S> {
        let mut by_v = sum(&ancestor.turned, once);
        by_v.add(&motion_cross(&ancestor.s, &self.moving.twist));
        by_v
    }
}
