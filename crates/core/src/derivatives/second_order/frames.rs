//! Second derivatives of the poses and velocities of frames.
//!
//! Column j of a Jacobian is the motion S_j of the DoF j at the frame. A displacement along the DoF k changes
//! it by
//!
//! D_k J_j = S_k × S_j if j moves with k (`World`, `LocalWorldAligned`), −S_k × S_j if k only moves the frame
//! (`Local`), and zero otherwise; `LocalWorldAligned` adds σ_j × D_k p for the frame's origin p.
//!
//! Source: Haviland, Corke, *Manipulator differential kinematics, part 2*, IEEE Robotics and Automation
//! Magazine (2023), for the columns at one frame.

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use super::contracted::check_rows;
use super::lanes::{LANES, Map, Point, SecondOrderWorkspace, Tangent};
use crate::algorithms::frame_motion::MovingFrame;
use crate::configuration::retraction_pullback::subtract_half_bracket;
use crate::derivatives::frames::{AncestorDof, for_each_ancestor, frame_velocity_derivative};
use crate::kinematics::world_frame::{compute_columns, motion_cross, shifted};
use crate::spatial::motion::MotionVector;
use crate::{FrameId, Model, ReferenceFrame, Workspace, frame_jacobian};

/// Calls `entry` with j, k and D_k J_j for the DoFs j and k between the root and the frame.
#[inline(always)]
fn for_each_pair<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    (q, frame, reference_frame): (&[S], FrameId, ReferenceFrame),
    mut entry: impl FnMut(usize, usize, &MotionVector<S>),
) {
    let tree = &mut workspace.tree;
    compute_columns(model, tree, q);
    let (tree, body) = (&*tree, |dof: usize| model.dofs[dof].body);
    let moving = MovingFrame::of_frame(model, tree, model.frame_of(frame));
    let point = moving.place.translation;
    for_each_ancestor(model, tree, frame, |&AncestorDof { dof: j, s: column, .. }| {
        for_each_ancestor(model, tree, frame, |&AncestorDof { dof: k, s, .. }| {
            let cross = motion_cross(&s, &column);
            // A body's index is greater than those of its ancestors.
            let moves_column = body(k) <= body(j);
            let change = match reference_frame {
                ReferenceFrame::World if moves_column => moving.motion_in_world(&cross),
                ReferenceFrame::Local if !moves_column => {
                    moving.motion_in_frame(&MotionVector { linear: -cross.linear, angular: -cross.angular })
                }
                ReferenceFrame::World | ReferenceFrame::Local => return,
                ReferenceFrame::LocalWorldAligned => {
                    let mut change = if moves_column { shifted(&cross, point) } else { MotionVector::zero() };
                    change.linear += column.angular.cross(shifted(&s, point).linear);
                    change
                }
            };
            entry(j, k, &change);
        });
    });
}

/// ∂J/∂q of [`frame_jacobian`] in the same reference frame, 6×nv×nv row-major: at (r, j, k) the derivative of
/// J_rj by q_k. O(depth²).
///
/// The derivative is the rate along [`integrate`](crate::integrate)(q, δ e_k). It is ∂²V/∂q∂v of the frame's
/// velocity V = J v. For its symmetric part see [`frame_pose_hessian`].
///
/// ```
/// use robot_dynamics::algorithms::ReferenceFrame;
/// use robot_dynamics::derivatives::frame_jacobian_derivative;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, tip) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let mut derivative = [0.0; 6];
/// frame_jacobian_derivative(&model, w, &[0.3], tip, ReferenceFrame::LocalWorldAligned, &mut derivative);
/// // J = (−l sin q, 0, −l cos q; 0, 1, 0)
/// assert!((derivative[0] + 0.5 * 0.3_f64.cos()).abs() < 1e-15);
/// assert!((derivative[2] - 0.5 * 0.3_f64.sin()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[doc(alias = "kinematic Hessian")]
#[doc(alias = "getJointKinematicHessian")]
#[track_caller]
pub fn frame_jacobian_derivative<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    frame: FrameId,
    reference_frame: ReferenceFrame,
    derivative: &mut [S],
) {
    workspace.check_inputs(model, q);
    model.frame_of(frame);
    let nv = model.nv;
    check_length("the derivative of the Jacobian", derivative.len(), 6 * nv * nv);
    derivative.fill(S::zero());
    for_each_pair(model, workspace, (q, frame, reference_frame), |j, k, change| {
        let (by, along) = (&model.dofs[j], &model.dofs[k]);
        let entries = change.linear.array().into_iter().chain(change.angular.array());
        for (matrix, entry) in derivative.chunks_exact_mut(nv * nv).zip(entries) {
            matrix[by.coordinate * nv + along.coordinate] += entry.scale(by.ratio * along.ratio);
        }
    });
}

/// The inputs of [`frame_pose_hessian`].
#[derive(Clone, Copy, Debug)]
pub struct FramePoseInputs<'a, S> {
    /// The configuration, nq numbers.
    pub q: &'a [S],
    /// The frame.
    pub frame: FrameId,
    /// The axes and the point of the motion.
    pub reference_frame: ReferenceFrame,
    /// The multipliers λ of the motion: linear, then angular.
    pub cotangent: [S; 6],
}

/// Σ λᵣ ∂²ξᵣ/∂q² of a frame's pose, nv×nv, symmetric. O(depth²).
///
/// ξ(x) is the displacement of the frame that q ⊕ x causes, with ∂ξ/∂x = J of [`frame_jacobian`] at x = 0:
///
/// | reference frame | linear part | angular part |
/// | --- | --- | --- |
/// | `Local` | log(T⁻¹ T(x)), twist coordinates | the same |
/// | `World` | log(T(x) T⁻¹), twist coordinates | the same |
/// | `LocalWorldAligned` | p(x) − p | log(R(x) Rᵀ) |
///
/// At x = 0 the second derivative of ξ is the symmetric part of [`frame_jacobian_derivative`], for joints
/// with quaternions too.
///
/// ```
/// use robot_dynamics::algorithms::ReferenceFrame;
/// use robot_dynamics::derivatives::{FramePoseInputs, frame_pose_hessian};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, frame) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let reference_frame = ReferenceFrame::LocalWorldAligned;
/// let cotangent = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; // x = l cos q
/// let mut hessian = [0.0];
/// let inputs = FramePoseInputs { q: &[0.3], frame, reference_frame, cotangent };
/// frame_pose_hessian(&model, w, inputs, &mut hessian);
/// assert!((hessian[0] + 0.5 * 0.3_f64.cos()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[track_caller]
pub fn frame_pose_hessian<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    inputs: FramePoseInputs<'_, S>,
    hessian: &mut [S],
) {
    workspace.check_inputs(model, inputs.q);
    model.frame_of(inputs.frame);
    let nv = model.nv;
    check_length("the Hessian", hessian.len(), nv * nv);
    hessian.fill(S::zero());
    for_each_contracted_pair(model, workspace, inputs, |j, k, half| {
        hessian[j * nv + k] += half;
        hessian[k * nv + j] += half;
    });
}

/// The product of [`frame_pose_hessian`] and a displacement of q, nv numbers. O(depth²). No allocation.
///
/// ```
/// use robot_dynamics::algorithms::ReferenceFrame;
/// use robot_dynamics::derivatives::{FramePoseInputs, frame_pose_hessian_product};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, frame) = (&mut Workspace::<f64>::new(&model), model.frame_named("tip")?);
/// let reference_frame = ReferenceFrame::LocalWorldAligned;
/// let cotangent = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; // x = l cos q
/// let mut product = [0.0];
/// let inputs = FramePoseInputs { q: &[0.3], frame, reference_frame, cotangent };
/// frame_pose_hessian_product(&model, w, inputs, &[2.0], &mut product);
/// assert!((product[0] + 2.0 * 0.5 * 0.3_f64.cos()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the frame belongs to another model.
#[track_caller]
pub fn frame_pose_hessian_product<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    inputs: FramePoseInputs<'_, S>,
    displacement: &[S],
    product: &mut [S],
) {
    workspace.check_inputs(model, inputs.q);
    model.frame_of(inputs.frame);
    check_length("the displacement", displacement.len(), model.nv);
    check_length("the product", product.len(), model.nv);
    product.fill(S::zero());
    for_each_contracted_pair(model, workspace, inputs, |j, k, half| {
        product[j] += half * displacement[k];
        product[k] += half * displacement[j];
    });
}

/// Calls `entry` with the coordinates j and k and ½ λᵀD_k J_j.
#[inline(always)]
fn for_each_contracted_pair<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    inputs: FramePoseInputs<'_, S>,
    mut entry: impl FnMut(usize, usize, S),
) {
    let FramePoseInputs { q, frame, reference_frame, cotangent } = inputs;
    for_each_pair(model, workspace, (q, frame, reference_frame), |j, k, change| {
        let (by, along) = (&model.dofs[j], &model.dofs[k]);
        let mut sum = S::zero();
        for (x, lambda) in change.linear.array().into_iter().chain(change.angular.array()).zip(cotangent) {
            sum += x * lambda;
        }
        entry(by.coordinate, along.coordinate, sum.scale(0.5 * by.ratio * along.ratio));
    });
}

/// The inputs of [`frame_velocity_hessian_product`].
#[derive(Clone, Copy, Debug)]
pub struct FrameVelocityInputs<'a> {
    /// The configuration, nq numbers.
    pub q: &'a [f64],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [f64],
    /// The frame.
    pub frame: FrameId,
    /// The axes and the point of the velocity.
    pub reference_frame: ReferenceFrame,
    /// The multipliers λ of the velocity: linear, then angular.
    pub cotangent: [f64; 6],
}

impl FrameVelocityInputs<'_> {
    #[track_caller]
    fn load(&self, model: &Model, workspace: &mut SecondOrderWorkspace) {
        let Self { q, v, frame, .. } = *self;
        let point = Point { map: Map::Inverse, q, v, input: v, wrenches: &[], cotangent: &[] };
        point.check(model, workspace);
        model.frame_of(frame);
        workspace.load(&point);
    }
}

/// The outputs of [`frame_velocity_hessian_product`]: rows of nv numbers, one row for each direction.
#[derive(Debug)]
pub struct FrameVelocityHessianProductMut<'a> {
    /// The rows of H α for q.
    pub by_position: &'a mut [f64],
    /// The rows of H α for v: (∂(Jᵀλ)/∂q) α_q.
    pub by_velocity: &'a mut [f64],
}

/// H α of λᵀV for the velocity V = J(q) v of [`frame_velocity`](crate::frame_velocity) in the same reference
/// frame, and rows α = (δq, δv) of nv numbers each. O(n) for four directions. No allocation.
///
/// H_αβ = ∂²/∂s∂t λᵀV at (q, v) ⊕ (sα + tβ), with q ⊕ δ of [`integrate`](crate::integrate): H is symmetric.
///
/// ```
/// use robot_dynamics::algorithms::ReferenceFrame;
/// use robot_dynamics::derivatives::{FrameVelocityHessianProductMut, FrameVelocityInputs};
/// use robot_dynamics::derivatives::{SecondOrderWorkspace, frame_velocity_hessian_product};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (workspace, frame) = (&mut SecondOrderWorkspace::new(&model), model.frame_named("tip")?);
/// let reference_frame = ReferenceFrame::LocalWorldAligned;
/// let cotangent = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; // ẋ = −l v sin q
/// let inputs = FrameVelocityInputs { q: &[0.3], v: &[3.0], frame, reference_frame, cotangent };
/// let (mut x, mut y) = ([0.0], [0.0]);
/// let results = FrameVelocityHessianProductMut { by_position: &mut x, by_velocity: &mut y };
/// frame_velocity_hessian_product(&model, workspace, inputs, [&[1.0], &[0.0]], results);
/// assert!((x[0] - 0.5 * 3.0 * 0.3_f64.sin()).abs() < 1e-14);
/// assert!((y[0] + 0.5 * 0.3_f64.cos()).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace or the frame belongs to another model.
#[track_caller]
pub fn frame_velocity_hessian_product(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: FrameVelocityInputs<'_>,
    [position, velocity]: [&[f64]; 2],
    results: FrameVelocityHessianProductMut<'_>,
) {
    inputs.load(model, workspace);
    let FrameVelocityHessianProductMut { by_position, by_velocity } = results;
    let nv = model.nv;
    let rows = check_rows(nv, [position, velocity], [by_position, by_velocity]);
    for first in (0..rows).step_by(LANES) {
        let count = LANES.min(rows - first);
        for lane in 0..LANES {
            let row = (first + lane.min(count - 1)) * nv;
            let direction = [&position[row..row + nv], &velocity[row..row + nv], &[]];
            workspace.set_lane(model, inputs.q, lane, direction);
        }
        workspace.pull_frame_velocity(model, &inputs);
        let SecondOrderWorkspace { gradient, vector, .. } = &mut *workspace;
        for (value, gradient) in vector.iter_mut().zip(&gradient[0]) {
            *value = gradient.value;
        }
        for lane in 0..count {
            let row = (first + lane) * nv..(first + lane + 1) * nv;
            for (to, gradient) in [&mut *by_position, &mut *by_velocity].into_iter().zip(&*gradient) {
                for (to, gradient) in to[row.clone()].iter_mut().zip(gradient) {
                    *to = gradient.gradient[lane];
                }
            }
            subtract_half_bracket(model, &position[row.clone()], vector, &mut by_position[row]);
        }
    }
}

/// H of [`frame_velocity_hessian_product`], 2nv×2nv in the order q, v, row-major.
///
/// It is symmetric bit for bit, and the block (v, v) is zero. O(n nv). No allocation.
///
/// ```
/// use robot_dynamics::algorithms::ReferenceFrame;
/// use robot_dynamics::derivatives::{FrameVelocityInputs, SecondOrderWorkspace, frame_velocity_hessian};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (workspace, frame) = (&mut SecondOrderWorkspace::new(&model), model.frame_named("tip")?);
/// let reference_frame = ReferenceFrame::LocalWorldAligned;
/// let cotangent = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; // ẋ = −l v sin q
/// let inputs = FrameVelocityInputs { q: &[0.3], v: &[3.0], frame, reference_frame, cotangent };
/// let mut hessian = [0.0; 4];
/// frame_velocity_hessian(&model, workspace, inputs, &mut hessian);
/// let expected = [0.5 * 3.0 * 0.3_f64.sin(), -0.5 * 0.3_f64.cos(), -0.5 * 0.3_f64.cos(), 0.0];
/// assert!(hessian.iter().zip(expected).all(|(x, expected)| (x - expected).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace or the frame belongs to another model.
#[track_caller]
pub fn frame_velocity_hessian(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: FrameVelocityInputs<'_>,
    hessian: &mut [f64],
) {
    inputs.load(model, workspace);
    let (nv, width) = (model.nv, 2 * model.nv);
    check_length("the Hessian", hessian.len(), width * width);
    hessian.fill(0.0);
    for first in (0..nv).step_by(LANES) {
        let count = workspace.set_position_lanes(model, inputs.q, first);
        workspace.pull_frame_velocity(model, &inputs);
        let [by_position, by_velocity, _] = &workspace.gradient;
        for lane in 0..count {
            let row = first + lane;
            for k in 0..nv {
                let half = 0.5 * by_position[k].gradient[lane];
                hessian[row * width + k] += half;
                hessian[k * width + row] += half;
                hessian[row * width + nv + k] = by_velocity[k].gradient[lane];
                hessian[(nv + k) * width + row] = by_velocity[k].gradient[lane];
            }
        }
    }
}

impl SecondOrderWorkspace {
    /// λᵀ∂V/∂q and Jᵀλ along the lanes.
    fn pull_frame_velocity(&mut self, model: &Model, inputs: &FrameVelocityInputs<'_>) {
        let FrameVelocityInputs { frame, reference_frame, cotangent, .. } = *inputs;
        let (nv, Self { lanes, q, v, matrices: [derivative, jacobian, _], gradient, .. }) = (model.nv, self);
        let (derivative, jacobian) = (&mut derivative[..6 * nv], &mut jacobian[..6 * nv]);
        frame_velocity_derivative(model, lanes, q, v, frame, reference_frame, derivative);
        frame_jacobian(model, lanes, q, frame, reference_frame, jacobian);
        for (result, matrix) in gradient.iter_mut().zip([derivative, jacobian]) {
            for (k, result) in result.iter_mut().enumerate() {
                *result = Tangent::zero();
                for (row, lambda) in cotangent.iter().enumerate() {
                    *result += matrix[row * nv + k].scale(*lambda);
                }
            }
        }
    }
}
