//! Second derivatives of inverse dynamics τ = M a + C v + g − Σ Jᵀw.

use super::contracted::{PositionBlock, hessian as contracted_hessian, multiply};
use super::lanes::{Map, Point, SecondOrderWorkspace};
use super::tensors::{Tensors, second_derivatives};
use crate::Model;
use crate::derivatives::pullback::InversePullbackInputs;
use crate::kinematics::wrench::FrameWrench;

/// Directions in (q, v, a): rows of nv numbers each, one row for each direction.
#[derive(Clone, Copy, Debug)]
pub struct InverseDirections<'a> {
    /// Displacements of q, as for [`integrate`](crate::integrate).
    pub position: &'a [f64],
    /// Changes of v.
    pub velocity: &'a [f64],
    /// Changes of a.
    pub acceleration: &'a [f64],
}

/// The outputs of [`inverse_dynamics_hessian_product`]: rows of nv numbers, one row for each direction.
#[derive(Debug)]
pub struct InverseHessianProductMut<'a> {
    /// The rows of H α for q.
    pub by_position: &'a mut [f64],
    /// The rows of H α for v.
    pub by_velocity: &'a mut [f64],
    /// The rows of H α for a: (∂(M λ)/∂q) α_q.
    pub by_acceleration: &'a mut [f64],
}

/// H α of λᵀτ(q, v, a) for one or several directions α, without H. O(n) for each direction. No allocation.
///
/// H_αβ = ∂²/∂s∂t λᵀτ at (q, v, a) ⊕ (sα + tβ), with q ⊕ δ of [`integrate`](crate::integrate). H is symmetric,
/// also for joints with quaternions: βᵀH α = αᵀH β. Up to four directions cost as much as one. Springs and
/// armature are included, dissipation is not: its second derivatives are zero.
///
/// ```
/// use robot_dynamics::derivatives::{InverseDirections, InverseHessianProductMut, InversePullbackInputs};
/// use robot_dynamics::derivatives::{SecondOrderWorkspace, inverse_dynamics_hessian_product};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // τ = m l² a − m g l cos q, so ∂²(3 τ)/∂q² = 3 m g l cos q.
/// let workspace = &mut SecondOrderWorkspace::new(&model);
/// let inputs = InversePullbackInputs { q: &[0.3], v: &[1.0], a: &[2.0], wrenches: &[], cotangent: &[3.0] };
/// let directions = InverseDirections { position: &[0.1], velocity: &[1.0], acceleration: &[1.0] };
/// let (by_position, by_velocity, by_acceleration) = (&mut [0.0], &mut [0.0], &mut [0.0]);
/// let results = InverseHessianProductMut { by_position, by_velocity, by_acceleration };
/// inverse_dynamics_hessian_product(&model, workspace, inputs, directions, results);
/// assert!((by_position[0] - 3.0 * 2.0 * 9.81 * 0.5 * 0.3_f64.cos() * 0.1).abs() < 1e-13);
/// assert!(by_velocity[0].abs() < 1e-14 && by_acceleration[0].abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[doc(alias = "HVP")]
#[doc(alias = "Hessian-vector product")]
#[track_caller]
pub fn inverse_dynamics_hessian_product(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: InversePullbackInputs<'_, f64>,
    directions: InverseDirections<'_>,
    results: InverseHessianProductMut<'_>,
) {
    let InverseDirections { position, velocity, acceleration } = directions;
    let InverseHessianProductMut { by_position, by_velocity, by_acceleration } = results;
    let results = &mut [by_position, by_velocity, by_acceleration];
    multiply(model, workspace, &point(inputs), [position, velocity, acceleration], results);
}

/// H of λᵀτ(q, v, a), 3nv×3nv in the order q, v, a, row-major.
///
/// It is symmetric bit for bit. O(n nv). No allocation. See [`inverse_dynamics_hessian_product`] for its
/// definition. The blocks (v, a) and (a, a) are zero.
///
/// ```
/// use robot_dynamics::derivatives::{InversePullbackInputs, SecondOrderWorkspace, inverse_dynamics_hessian};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (workspace, mut hessian) = (&mut SecondOrderWorkspace::new(&model), [0.0; 9]);
/// let inputs = InversePullbackInputs { q: &[0.3], v: &[1.0], a: &[2.0], wrenches: &[], cotangent: &[3.0] };
/// inverse_dynamics_hessian(&model, workspace, inputs, &mut hessian);
/// assert!((hessian[0] - 3.0 * 2.0 * 9.81 * 0.5 * 0.3_f64.cos()).abs() < 1e-13);
/// assert!(hessian[1..].iter().all(|x| x.abs() < 1e-13));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn inverse_dynamics_hessian(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: InversePullbackInputs<'_, f64>,
    hessian: &mut [f64],
) {
    contracted_hessian(model, workspace, &point(inputs), PositionBlock::Symmetric, hessian);
}

/// The derivative of the pullback g, 3nv×3nv: D_α g_β at (α, β). It differs from [`inverse_dynamics_hessian`]
/// only in the block of two positions, which is not symmetric for joints with quaternions.
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[doc(hidden)]
#[track_caller]
pub fn inverse_dynamics_pullback_derivative(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: InversePullbackInputs<'_, f64>,
    derivative: &mut [f64],
) {
    contracted_hessian(model, workspace, &point(inputs), PositionBlock::Ordered, derivative);
}

fn point(inputs: InversePullbackInputs<'_, f64>) -> Point<'_> {
    let InversePullbackInputs { q, v, a, wrenches, cotangent } = inputs;
    Point { map: Map::Inverse, q, v, input: a, wrenches, cotangent }
}

/// The outputs of [`inverse_dynamics_second_derivatives`]: nv×nv×nv numbers each, row-major.
#[derive(Debug)]
pub struct InverseSecondDerivativesMut<'a> {
    /// ∂²τᵢ/∂qⱼ∂qₖ at (i, j, k), symmetric in j and k.
    pub position_position: &'a mut [f64],
    /// ∂²τᵢ/∂qⱼ∂vₖ at (i, j, k).
    pub position_velocity: &'a mut [f64],
    /// ∂²τᵢ/∂vⱼ∂vₖ at (i, j, k), symmetric in j and k.
    pub velocity_velocity: &'a mut [f64],
    /// ∂²τᵢ/∂qⱼ∂aₖ = ∂M_ik/∂qⱼ at (i, j, k).
    pub position_acceleration: &'a mut [f64],
}

/// The second derivatives of τ(q, v, a), nv×nv×nv numbers each. O(n nv depth). The others are zero.
///
/// ∂²τᵢ/∂qⱼ∂qₖ is that of τᵢ(q ⊕ x) at x = 0, with q ⊕ x of [`integrate`](crate::integrate). So it is
/// symmetric for every joint. [`inverse_dynamics_hessian`] is cheaper if only Σ λᵢ ∂²τᵢ is needed. `wrenches`
/// may be empty.
///
/// For joints with one degree of freedom the tensors are those of Pinocchio's
/// `ComputeRNEASecondOrderDerivatives`. For joints with quaternions its ∂²τ/∂q² is not symmetric.
///
/// ```
/// use robot_dynamics::derivatives::{InverseSecondDerivativesMut, SecondOrderWorkspace};
/// use robot_dynamics::derivatives::inverse_dynamics_second_derivatives;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let workspace = &mut SecondOrderWorkspace::new(&model);
/// let [mut qq, mut qv, mut vv, mut qa] = [[0.0]; 4];
/// let results = InverseSecondDerivativesMut {
///     position_position: &mut qq,
///     position_velocity: &mut qv,
///     velocity_velocity: &mut vv,
///     position_acceleration: &mut qa,
/// };
/// inverse_dynamics_second_derivatives(&model, workspace, &[0.3], &[1.0], &[2.0], &[], results);
/// assert!((qq[0] - 2.0 * 9.81 * 0.5 * 0.3_f64.cos()).abs() < 1e-13); // τ = m l² a − m g l cos q
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[doc(alias = "ComputeRNEASecondOrderDerivatives")]
#[track_caller]
pub fn inverse_dynamics_second_derivatives(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    wrenches: &[FrameWrench],
    results: InverseSecondDerivativesMut<'_>,
) {
    let InverseSecondDerivativesMut {
        position_position,
        position_velocity,
        velocity_velocity,
        position_acceleration,
    } = results;
    let tensors = Tensors {
        position_position,
        position_velocity,
        velocity_velocity,
        position_input: position_acceleration,
    };
    let point = Point { map: Map::Inverse, q, v, input: a, wrenches, cotangent: &[] };
    second_derivatives(model, workspace, &point, tensors);
}
