//! ∂τ/∂q and ∂τ/∂v of inverse dynamics τ = M a + C v + g. Cost: O(n depth).
//!
//! ∂τ/∂a is M. The equations and sources are those of the module `derivatives`. Columns of ∂τ/∂q are rates
//! along q ⊕ δ eⱼ, so the matrix is symmetric only at rest and without quaternions.

use robot_dynamics_description::check_length;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use super::columns::{bend, subtract_carried, sweep_in, sweep_out};
use super::entries::{DerivativeMatrices, write_derivatives};
use crate::kinematics::placement::spread;
use crate::kinematics::world_frame::compute_columns;
use crate::kinematics::wrench::FrameWrench;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

/// The arguments.
pub struct InverseDynamicsDerivativesKernel<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub v: &'a [S],
    pub a: &'a [S],
    pub wrenches: &'a [FrameWrench<S>],
    pub by_position: &'a mut [S],
    pub by_velocity: &'a mut [S],
}

compiled_once!(InverseDynamicsDerivativesKernel);

impl<S: Scalar> Kernel<TreeStorage, S> for InverseDynamicsDerivativesKernel<'_, S> {
    const GAINS_BY_AVX512: bool = true;

    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, a, wrenches, by_position, by_velocity } = self;
        let (q, v, a) = (N::view(q), N::view(v), N::view(a));
        let (by_position, by_velocity) = (N::view_mut(by_position), N::view_mut(by_velocity));
        compute_columns(model, tree, q);
        spread(model, v, &mut tree.dofs.v);
        spread(model, a, &mut tree.dofs.a);
        sweep_out(model, tree, model.gravity().map(|g| -g));
        subtract_carried(model, tree, wrenches);
        sweep_in(model, tree);
        bend(model, tree);
        by_position.fill(N::zero());
        by_velocity.fill(N::zero());
        let mut derivatives = DerivativeMatrices { by_position, by_velocity, stride: model.nv };
        write_derivatives(model, &tree.derivatives.paths.blocks, &mut derivatives);
    }
}

/// The outputs of [`inverse_dynamics_derivatives`]: nv×nv matrices, row-major. Batches have one per state.
#[derive(Debug)]
pub struct InverseDynamicsDerivativesMut<'a, S> {
    /// ∂τ/∂q.
    pub by_position: &'a mut [S],
    /// ∂τ/∂v.
    pub by_velocity: &'a mut [S],
}

/// ∂τ/∂q and ∂τ/∂v of τ = M(q) a + C(q,v) v + g(q), each nv×nv, row-major. ∂τ/∂a is
/// [`mass_matrix`](crate::mass_matrix). O(n depth).
///
/// For a spherical or floating joint, column j of ∂τ/∂q is the rate along [`integrate`](crate::integrate)(q,
/// δ eⱼ), the directions of v. ∂τ/∂q includes springs. It is symmetric only at v = a = 0 and without
/// quaternions, where it is the Hessian of V. Over dual numbers this function gives second derivatives.
///
/// ```
/// use robot_dynamics::derivatives::{InverseDynamicsDerivativesMut, inverse_dynamics_derivatives};
/// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose};
/// use robot_dynamics::description::RobotDescription;
/// use robot_dynamics::model::{Model, Workspace};
/// // A pendulum of 2 kg on a 0.5 m rod, about y: τ = m l² a − m g l cos q.
/// # let mass = robot_dynamics::description::MassProperties::new(2.0, [0.5, 0.0, 0.0].into(), nalgebra::Matrix3::zeros()).ok();
/// let mut robot = RobotDescription::new("pendulum");
/// robot.links.push(LinkDescription::new("ceiling", None));
/// robot.links.push(LinkDescription::new("rod", mass));
/// let about_y = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
/// robot.joints.push(JointDescription::new("hinge", about_y, "ceiling", "rod", Pose::IDENTITY));
/// let model = Model::new(robot)?;
/// let (mut by_q, mut by_v) = ([0.0], [0.0]);
/// let mut workspace = Workspace::new(&model);
/// let outputs = InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
/// inverse_dynamics_derivatives(&model, &mut workspace, &[0.3], &[1.0], &[2.0], outputs);
/// assert!((by_q[0] - 2.0 * 9.81 * 0.5 * 0.3_f64.sin()).abs() < 1e-14);
/// assert!(by_v[0].abs() < 1e-14);
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "computeRNEADerivatives")]
#[inline]
#[track_caller]
pub fn inverse_dynamics_derivatives<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    derivatives: InverseDynamicsDerivativesMut<'_, S>,
) {
    inverse_dynamics_derivatives_with_wrenches(model, workspace, q, v, a, &[], derivatives);
}

/// ∂τ/∂q and ∂τ/∂v of τ = M a + C v + g − Σ Jᵀw. The wrenches w keep their components in their frames.
///
/// ```
/// use robot_dynamics::algorithms::FrameWrench;
/// use robot_dynamics::derivatives::InverseDynamicsDerivativesMut;
/// use robot_dynamics::derivatives::inverse_dynamics_derivatives_with_wrenches;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // A thruster turns with the rod, so its torque does not depend on the angle; only the weight's does.
/// let (frame, w) = (model.frame_named("tip")?, &mut Workspace::<f64>::new(&model));
/// let thrust = FrameWrench { frame, force_in_frame: [0.0, 0.0, 30.0], moment_in_frame: [0.0; 3] };
/// let (mut by_q, mut by_v) = ([0.0], [0.0]);
/// let outputs = InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
/// inverse_dynamics_derivatives_with_wrenches(&model, w, &[0.3], &[1.0], &[2.0], &[thrust], outputs);
/// assert!((by_q[0] - 2.0 * 9.81 * 0.5 * 0.3_f64.sin()).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn inverse_dynamics_derivatives_with_wrenches<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    wrenches: &[FrameWrench<S>],
    derivatives: InverseDynamicsDerivativesMut<'_, S>,
) {
    let InverseDynamicsDerivativesMut { by_position, by_velocity } = derivatives;
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("the derivative by q", by_position.len(), model.nv * model.nv);
    check_length("the derivative by v", by_velocity.len(), model.nv * model.nv);
    run(
        &mut workspace.tree,
        InverseDynamicsDerivativesKernel { model, q, v, a, wrenches, by_position, by_velocity },
    );
}
