//! The pullback of inverse dynamics.

use robot_dynamics_description::check_length;
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use super::parameters::check_parameters;
use super::sweeps::{Results, sweep_in, sweep_out, weigh_bodies};
use crate::derivatives::columns::subtract_carried;
use crate::kinematics::placement::spread;
use crate::kinematics::world_frame::compute_columns;
use crate::kinematics::wrench::FrameWrench;
use crate::model::native::NativeFunction;
use crate::workspace::compiled_once::{compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::{TreeMemory, TreeStorage};
use crate::{Model, Workspace};

/// The arguments.
pub struct NewtonEulerPullback<'a, S> {
    pub model: &'a Model,
    pub q: &'a [S],
    pub v: &'a [S],
    pub a: &'a [S],
    pub wrenches: &'a [FrameWrench<S>],
    pub cotangent: &'a [S],
    pub by_position: &'a mut [S],
    pub by_velocity: &'a mut [S],
    /// Empty if not requested.
    pub by_acceleration: &'a mut [S],
    /// The cotangents are added; empty if not requested.
    pub parameters: &'a mut [S],
}

compiled_once!(NewtonEulerPullback);

impl<S: Scalar> Kernel<TreeStorage, S> for NewtonEulerPullback<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, a, wrenches, cotangent, .. } = self;
        compute_columns(model, tree, N::view(q));
        spread(model, N::view(v), &mut tree.dofs.v);
        spread(model, N::view(a), &mut tree.dofs.a);
        spread(model, N::view(cotangent), &mut tree.dofs.tau);
        sweep_out(model, tree);
        weigh_bodies(model, tree);
        subtract_carried(model, tree, wrenches);
        let mut results = Results {
            by_position: N::view_mut(self.by_position),
            by_velocity: N::view_mut(self.by_velocity),
            by_acceleration: N::view_mut(self.by_acceleration),
            parameters: N::view_mut(self.parameters),
        };
        sweep_in(model, tree, &mut results);
    }
}

/// The inputs of [`inverse_dynamics_pullback_with_parameters`].
#[derive(Clone, Copy, Debug)]
pub struct InversePullbackInputs<'a, S> {
    /// The configuration, nq numbers.
    pub q: &'a [S],
    /// The velocity, nv numbers \[rad/s, m/s\].
    pub v: &'a [S],
    /// The acceleration, nv numbers \[rad/s², m/s²\].
    pub a: &'a [S],
    /// The wrenches on frames, with components in the frames.
    pub wrenches: &'a [FrameWrench<S>],
    /// The cotangent λ of τ, nv numbers.
    pub cotangent: &'a [S],
}

/// The outputs of [`inverse_dynamics_pullback`]. Batches have one row per state.
#[derive(Debug)]
pub struct InversePullbackMut<'a, S> {
    /// λᵀ∂τ/∂q, nv numbers.
    pub by_position: &'a mut [S],
    /// λᵀ∂τ/∂v, nv numbers.
    pub by_velocity: &'a mut [S],
    /// λᵀ∂τ/∂a = (M λ)ᵀ, nv numbers.
    pub by_acceleration: &'a mut [S],
    /// The cotangents of the description's parameters, in the layout of
    /// [`ParameterCotangents`](crate::ParameterCotangents), which are added and in batches
    /// overwritten; empty if they are not needed.
    pub parameters: &'a mut [S],
}

/// λᵀ∂τ/∂q, λᵀ∂τ/∂v and λᵀ∂τ/∂a = (M λ)ᵀ of τ = M(q) a + C(q,v) v + g(q), nv numbers each, for a cotangent λ
/// of τ. O(n), without Jacobians.
///
/// For a spherical or floating joint, entry j of λᵀ∂τ/∂q is the rate along [`integrate`](crate::integrate)(q,
/// δ eⱼ), the directions of v. [`cotangent_to_coordinates`](crate::cotangent_to_coordinates) converts it to
/// the numbers of q. Springs and armature are included, dissipation is not; see
/// [`dissipation_pullback`](crate::dissipation_pullback). Over dual numbers this function gives
/// Hessian-vector products.
///
/// ```
/// use robot_dynamics::derivatives::{InversePullbackMut, inverse_dynamics_pullback};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // τ = m l² a − m g l cos q, so 3 τ has the derivatives 3 m g l sin q, 0 and 3 m l².
/// let (w, mut by_q, mut by_v, mut by_a) = (&mut Workspace::<f64>::new(&model), [0.0], [0.0], [0.0]);
/// let outputs = InversePullbackMut {
///     by_position: &mut by_q,
///     by_velocity: &mut by_v,
///     by_acceleration: &mut by_a,
///     parameters: &mut [],
/// };
/// inverse_dynamics_pullback(&model, w, &[0.3], &[1.0], &[2.0], &[3.0], outputs);
/// assert!((by_q[0] - 3.0 * 2.0 * 9.81 * 0.5 * 0.3_f64.sin()).abs() < 1e-13);
/// assert!(by_v[0].abs() < 1e-13 && (by_a[0] - 3.0 * 2.0 * 0.25).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[doc(alias = "vector-Jacobian product")]
#[doc(alias = "VJP")]
#[inline]
#[track_caller]
pub fn inverse_dynamics_pullback<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    cotangent: &[S],
    results: InversePullbackMut<'_, S>,
) {
    inverse_dynamics_pullback_with_parameters(
        model,
        workspace,
        InversePullbackInputs { q, v, a, wrenches: &[], cotangent },
        results,
    );
}

/// [`inverse_dynamics_pullback`] of τ = M a + C v + g − Σ Jᵀw, and the cotangents of the description's
/// parameters. The wrenches w on frames keep their components in their frames.
///
/// `parameters` is empty or has [`parameter_count`](crate::parameter_count) numbers in the layout of
/// [`ParameterCotangents`](crate::ParameterCotangents). The cotangents are **added**, so that calls along a
/// trajectory accumulate. The inertial ones are λᵀY of the
/// [`joint_torque_regressor`](crate::joint_torque_regressor). The cotangent of a wrench is −J λ: the
/// [`frame_velocity`](crate::frame_velocity) in `ReferenceFrame::Local` at v = −λ.
///
/// ```
/// use robot_dynamics::derivatives::ParameterCotangents;
/// use robot_dynamics::derivatives::{InversePullbackInputs, InversePullbackMut, parameter_count};
/// use robot_dynamics::derivatives::inverse_dynamics_pullback_with_parameters;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (w, mut parameters) = (&mut Workspace::<f64>::new(&model), vec![0.0; parameter_count(&model)]);
/// let (x, y, z) = (&mut [0.0], &mut [0.0], &mut [0.0]);
/// let outputs = InversePullbackMut {
///     by_position: x,
///     by_velocity: y,
///     by_acceleration: z,
///     parameters: &mut parameters,
/// };
/// let inputs =
///     InversePullbackInputs { q: &[0.3], v: &[1.0], a: &[2.0], wrenches: &[], cotangent: &[1.0] };
/// inverse_dynamics_pullback_with_parameters(&model, w, inputs, outputs);
/// // The derivative of −m g l cos q by the field's z component, which is −g: m l cos q.
/// let by = ParameterCotangents::of(&model, &parameters);
/// assert!((by.gravity[2] - 2.0 * 0.5 * 0.3_f64.cos()).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn inverse_dynamics_pullback_with_parameters<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    inputs: InversePullbackInputs<'_, S>,
    results: InversePullbackMut<'_, S>,
) {
    let InversePullbackInputs { q, v, a, wrenches, cotangent } = inputs;
    let InversePullbackMut { by_position, by_velocity, by_acceleration, parameters } = results;
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("the cotangent", cotangent.len(), model.nv);
    check_length("the cotangent of q", by_position.len(), model.nv);
    check_length("the cotangent of v", by_velocity.len(), model.nv);
    check_length("the cotangent of a", by_acceleration.len(), model.nv);
    check_parameters(model, parameters);
    if wrenches.is_empty() && parameters.is_empty() {
        let (arguments, results) =
            (&[q, v, a, cotangent], &mut [&mut *by_position, &mut *by_velocity, &mut *by_acceleration]);
        let (native, function) = (&mut workspace.tree.native, NativeFunction::InverseDynamicsPullback);
        if computed_natively(model, native, function, arguments, results) {
            return;
        }
    }
    run(
        &mut workspace.tree,
        NewtonEulerPullback {
            model,
            q,
            v,
            a,
            wrenches,
            cotangent,
            by_position,
            by_velocity,
            by_acceleration,
            parameters,
        },
    );
}
