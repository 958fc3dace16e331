//! Second derivatives of forward dynamics a = M⁻¹(τ + Σ Jᵀw − C v − g).

use super::contracted::{PositionBlock, hessian as contracted_hessian, multiply};
use super::lanes::{Map, Point, SecondOrderWorkspace};
use super::tensors::{Tensors, second_derivatives};
use crate::Model;
use crate::derivatives::pullback::ForwardPullbackInputs;
use crate::kinematics::wrench::FrameWrench;

/// Directions in (q, v, τ): rows of nv numbers each, one row for each direction.
#[derive(Clone, Copy, Debug)]
pub struct ForwardDirections<'a> {
    /// Displacements of q, as for [`integrate`](crate::integrate).
    pub position: &'a [f64],
    /// Changes of v.
    pub velocity: &'a [f64],
    /// Changes of τ.
    pub force: &'a [f64],
}

/// The outputs of [`forward_dynamics_hessian_product`]: rows of nv numbers, one row for each direction.
#[derive(Debug)]
pub struct ForwardHessianProductMut<'a> {
    /// The rows of H α for q.
    pub by_position: &'a mut [f64],
    /// The rows of H α for v.
    pub by_velocity: &'a mut [f64],
    /// The rows of H α for τ: (∂(M⁻¹ā)/∂q) α_q.
    pub by_force: &'a mut [f64],
}

/// H α of āᵀa(q, v, τ) for one or several directions α, without H. O(n) for each direction. No allocation.
///
/// H_αβ = ∂²/∂s∂t āᵀa at (q, v, τ) ⊕ (sα + tβ), with q ⊕ δ of [`integrate`](crate::integrate). H is symmetric,
/// also for joints with quaternions: βᵀH α = αᵀH β. Up to four directions cost as much as one. Damping
/// and friction are not included. If M is singular, the numbers are not finite. A robot with coupled branches
/// uses M and its factor, O(n depth²).
///
/// ```
/// use robot_dynamics::derivatives::{ForwardDirections, ForwardHessianProductMut, ForwardPullbackInputs};
/// use robot_dynamics::derivatives::{SecondOrderWorkspace, forward_dynamics_hessian_product};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // a = (τ + m g l cos q)/(m l²), so ∂²(3 a)/∂q² = −3 g/l cos q.
/// let workspace = &mut SecondOrderWorkspace::new(&model);
/// let inputs =
///     ForwardPullbackInputs { q: &[0.3], v: &[1.0], tau: &[0.7], wrenches: &[], cotangent: &[3.0] };
/// let directions = ForwardDirections { position: &[0.1], velocity: &[1.0], force: &[1.0] };
/// let (by_position, by_velocity, by_force) = (&mut [0.0], &mut [0.0], &mut [0.0]);
/// let results = ForwardHessianProductMut { by_position, by_velocity, by_force };
/// forward_dynamics_hessian_product(&model, workspace, inputs, directions, results);
/// assert!((by_position[0] + 3.0 * 9.81 / 0.5 * 0.3_f64.cos() * 0.1).abs() < 1e-12);
/// assert!(by_velocity[0].abs() < 1e-14 && by_force[0].abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[doc(alias = "HVP")]
#[doc(alias = "Hessian-vector product")]
#[track_caller]
pub fn forward_dynamics_hessian_product(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: ForwardPullbackInputs<'_, f64>,
    directions: ForwardDirections<'_>,
    results: ForwardHessianProductMut<'_>,
) {
    let ForwardDirections { position, velocity, force } = directions;
    let ForwardHessianProductMut { by_position, by_velocity, by_force } = results;
    let results = &mut [by_position, by_velocity, by_force];
    multiply(model, workspace, &point(inputs), [position, velocity, force], results);
}

/// H of āᵀa(q, v, τ), 3nv×3nv in the order q, v, τ, row-major.
///
/// It is symmetric bit for bit. O(n nv). No allocation. See [`forward_dynamics_hessian_product`] for its
/// definition. The blocks (v, τ) and (τ, τ) are zero.
///
/// ```
/// use robot_dynamics::derivatives::{ForwardPullbackInputs, SecondOrderWorkspace, forward_dynamics_hessian};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let (workspace, mut hessian) = (&mut SecondOrderWorkspace::new(&model), [0.0; 9]);
/// let inputs =
///     ForwardPullbackInputs { q: &[0.3], v: &[1.0], tau: &[0.7], wrenches: &[], cotangent: &[3.0] };
/// forward_dynamics_hessian(&model, workspace, inputs, &mut hessian);
/// assert!((hessian[0] + 3.0 * 9.81 / 0.5 * 0.3_f64.cos()).abs() < 1e-12);
/// assert!(hessian[1..].iter().all(|x| x.abs() < 1e-13));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn forward_dynamics_hessian(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: ForwardPullbackInputs<'_, f64>,
    hessian: &mut [f64],
) {
    contracted_hessian(model, workspace, &point(inputs), PositionBlock::Symmetric, hessian);
}

/// The derivative of the pullback g, 3nv×3nv: D_α g_β at (α, β). It differs from [`forward_dynamics_hessian`]
/// only in the block of two positions, which is not symmetric for joints with quaternions.
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[doc(hidden)]
#[track_caller]
pub fn forward_dynamics_pullback_derivative(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    inputs: ForwardPullbackInputs<'_, f64>,
    derivative: &mut [f64],
) {
    contracted_hessian(model, workspace, &point(inputs), PositionBlock::Ordered, derivative);
}

fn point(inputs: ForwardPullbackInputs<'_, f64>) -> Point<'_> {
    let ForwardPullbackInputs { q, v, tau, wrenches, cotangent } = inputs;
    Point { map: Map::Forward, q, v, input: tau, wrenches, cotangent }
}

/// The outputs of [`forward_dynamics_second_derivatives`]: nv×nv×nv numbers each, row-major.
#[derive(Debug)]
pub struct ForwardSecondDerivativesMut<'a> {
    /// ∂²aᵢ/∂qⱼ∂qₖ at (i, j, k), symmetric in j and k.
    pub position_position: &'a mut [f64],
    /// ∂²aᵢ/∂qⱼ∂vₖ at (i, j, k).
    pub position_velocity: &'a mut [f64],
    /// ∂²aᵢ/∂vⱼ∂vₖ at (i, j, k), symmetric in j and k.
    pub velocity_velocity: &'a mut [f64],
    /// ∂²aᵢ/∂qⱼ∂τₖ = ∂(M⁻¹)_ik/∂qⱼ at (i, j, k).
    pub position_force: &'a mut [f64],
}

/// The second derivatives of a(q, v, τ), nv×nv×nv numbers each. O(nv³ depth). The others are zero.
///
/// ∂²aᵢ/∂qⱼ∂qₖ is that of aᵢ(q ⊕ x) at x = 0, with q ⊕ x of [`integrate`](crate::integrate). So it is
/// symmetric for every joint. [`forward_dynamics_hessian`] is cheaper if only Σ āᵢ ∂²aᵢ is needed. `wrenches`
/// may be empty.
///
/// Damping and friction are not included. If M is singular, the numbers are not finite.
///
/// ```
/// use robot_dynamics::derivatives::{ForwardSecondDerivativesMut, SecondOrderWorkspace};
/// use robot_dynamics::derivatives::forward_dynamics_second_derivatives;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let workspace = &mut SecondOrderWorkspace::new(&model);
/// let [mut qq, mut qv, mut vv, mut qf] = [[0.0]; 4];
/// let results = ForwardSecondDerivativesMut {
///     position_position: &mut qq,
///     position_velocity: &mut qv,
///     velocity_velocity: &mut vv,
///     position_force: &mut qf,
/// };
/// forward_dynamics_second_derivatives(&model, workspace, &[0.3], &[1.0], &[0.7], &[], results);
/// assert!((qq[0] + 9.81 / 0.5 * 0.3_f64.cos()).abs() < 1e-12); // a = (τ + m g l cos q)/(m l²)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn forward_dynamics_second_derivatives(
    model: &Model,
    workspace: &mut SecondOrderWorkspace,
    q: &[f64],
    v: &[f64],
    tau: &[f64],
    wrenches: &[FrameWrench],
    results: ForwardSecondDerivativesMut<'_>,
) {
    let ForwardSecondDerivativesMut {
        position_position,
        position_velocity,
        velocity_velocity,
        position_force,
    } = results;
    let tensors =
        Tensors { position_position, position_velocity, velocity_velocity, position_input: position_force };
    let point = Point { map: Map::Forward, q, v, input: tau, wrenches, cotangent: &[] };
    second_derivatives(model, workspace, &point, tensors);
}
