//! A function for each quantity of the table.

use robot_dynamics::quantity::Quantity;

use crate::Status;
use crate::calls::call;
use crate::workspace::WorkspaceHandle;

use super::{InputsC, ResultsC, compute};

/// A quantity of q alone with one result.
#[inline(always)]
unsafe fn of_q(
    workspace: WorkspaceHandle,
    quantity: Quantity,
    (q, q_len): (*const f64, usize),
    (first, first_len): (*mut f64, usize),
) -> Status {
    let inputs = InputsC { q, q_len, ..InputsC::default() };
    call(|| compute(workspace, quantity, &inputs, &ResultsC { first, first_len, ..ResultsC::default() }))
}

/// A quantity of q and v with one result.
#[inline(always)]
unsafe fn of_q_v(
    workspace: WorkspaceHandle,
    quantity: Quantity,
    (q, q_len): (*const f64, usize),
    (v, v_len): (*const f64, usize),
    (first, first_len): (*mut f64, usize),
) -> Status {
    let inputs = InputsC { q, q_len, v, v_len, ..InputsC::default() };
    call(|| compute(workspace, quantity, &inputs, &ResultsC { first, first_len, ..ResultsC::default() }))
}

/// M(q), nv × nv, row-major. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_mass_matrix(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    mass: *mut f64,
    mass_len: usize,
) -> Status {
    of_q(workspace, Quantity::MassMatrix, (q, nq), (mass, mass_len))
}

/// The inverse of M(q), nv × nv, row-major. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_inverse_mass_matrix(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    inverse: *mut f64,
    inverse_len: usize,
) -> Status {
    of_q(workspace, Quantity::InverseMassMatrix, (q, nq), (inverse, inverse_len))
}

/// L and D of M(q) = LᵀDL, nv × nv, row-major: D on the diagonal, L below it. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_mass_matrix_factor(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    factor: *mut f64,
    factor_len: usize,
) -> Status {
    of_q(workspace, Quantity::MassMatrixFactor, (q, nq), (factor, factor_len))
}

/// g(q), nv numbers, springs included. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_gravity(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    g: *mut f64,
    g_len: usize,
) -> Status {
    of_q(workspace, Quantity::Gravity, (q, nq), (g, g_len))
}

/// ∂g/∂q, nv × nv, row-major. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_gravity_derivative(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    derivative: *mut f64,
    derivative_len: usize,
) -> Status {
    of_q(workspace, Quantity::GravityDerivative, (q, nq), (derivative, derivative_len))
}

/// C(q, v) v + g(q), nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_bias(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    bias: *mut f64,
    bias_len: usize,
) -> Status {
    of_q_v(workspace, Quantity::Bias, (q, nq), (v, nv), (bias, bias_len))
}

/// C(q, v) of the Christoffel symbols, nv × nv, row-major. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_coriolis_matrix(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    coriolis: *mut f64,
    coriolis_len: usize,
) -> Status {
    of_q_v(workspace, Quantity::CoriolisMatrix, (q, nq), (v, nv), (coriolis, coriolis_len))
}

/// C(q, v) v, nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_velocity_product(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    product: *mut f64,
    product_len: usize,
) -> Status {
    of_q_v(workspace, Quantity::VelocityProduct, (q, nq), (v, nv), (product, product_len))
}

/// M(q) v, nv numbers. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_momentum(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    momentum: *mut f64,
    momentum_len: usize,
) -> Status {
    of_q_v(workspace, Quantity::Momentum, (q, nq), (v, nv), (momentum, momentum_len))
}

/// K(q, v) \[J\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_kinetic_energy(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    energy: *mut f64,
) -> Status {
    of_q_v(workspace, Quantity::KineticEnergy, (q, nq), (v, nv), (energy, 1))
}

/// V(q) \[J\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_potential_energy(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    energy: *mut f64,
) -> Status {
    of_q(workspace, Quantity::PotentialEnergy, (q, nq), (energy, 1))
}

/// tau = M(q) a + C(q, v) v + g(q), nv numbers \[N m or N\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_inverse_dynamics(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    a: *const f64,
    a_len: usize,
    tau: *mut f64,
    tau_len: usize,
) -> Status {
    let inputs = InputsC { q, q_len: nq, v, v_len: nv, a, a_len, ..InputsC::default() };
    let results = ResultsC { first: tau, first_len: tau_len, ..ResultsC::default() };
    call(|| compute(workspace, Quantity::InverseDynamics, &inputs, &results))
}

/// a = M(q)⁻¹(tau − C(q, v) v − g(q)), nv numbers \[rad/s² or m/s²\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_forward_dynamics(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    tau: *const f64,
    tau_len: usize,
    a: *mut f64,
    a_len: usize,
) -> Status {
    let inputs = InputsC { q, q_len: nq, v, v_len: nv, tau, tau_len, ..InputsC::default() };
    let results = ResultsC { first: a, first_len: a_len, ..ResultsC::default() };
    call(|| compute(workspace, Quantity::ForwardDynamics, &inputs, &results))
}

/// ∂tau/∂q and ∂tau/∂v of tau(q, v, a), nv × nv each, row-major. Derivatives by q are along
/// `rd_integrate`. ∂tau/∂a is `rd_mass_matrix`. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_inverse_dynamics_derivatives(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    a: *const f64,
    a_len: usize,
    by_position: *mut f64,
    by_position_len: usize,
    by_velocity: *mut f64,
    by_velocity_len: usize,
) -> Status {
    let inputs = InputsC { q, q_len: nq, v, v_len: nv, a, a_len, ..InputsC::default() };
    let (first, first_len, second, second_len) = (by_position, by_position_len, by_velocity, by_velocity_len);
    let results = ResultsC { first, first_len, second, second_len, ..ResultsC::default() };
    call(|| compute(workspace, Quantity::InverseDynamicsDerivatives, &inputs, &results))
}

/// ∂a/∂q, ∂a/∂v and ∂a/∂tau of a(q, v, tau), nv × nv each, row-major. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_forward_dynamics_derivatives(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
    tau: *const f64,
    tau_len: usize,
    by_position: *mut f64,
    by_position_len: usize,
    by_velocity: *mut f64,
    by_velocity_len: usize,
    by_force: *mut f64,
    by_force_len: usize,
) -> Status {
    let inputs = InputsC { q, q_len: nq, v, v_len: nv, tau, tau_len, ..InputsC::default() };
    let results = ResultsC {
        first: by_position,
        first_len: by_position_len,
        second: by_velocity,
        second_len: by_velocity_len,
        third: by_force,
        third_len: by_force_len,
    };
    call(|| compute(workspace, Quantity::ForwardDynamicsDerivatives, &inputs, &results))
}

/// The centre of mass in the world, 3 numbers \[m\]. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_center_of_mass(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    center: *mut f64,
    center_len: usize,
) -> Status {
    of_q(workspace, Quantity::CenterOfMass, (q, nq), (center, center_len))
}

/// The Jacobian of the centre of mass, 3 × nv, row-major. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_center_of_mass_jacobian(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    jacobian: *mut f64,
    jacobian_len: usize,
) -> Status {
    of_q(workspace, Quantity::CenterOfMassJacobian, (q, nq), (jacobian, jacobian_len))
}

/// The centroidal momentum matrix, 6 × nv, row-major: linear rows, then angular ones. Does not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_centroidal_momentum_matrix(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    matrix: *mut f64,
    matrix_len: usize,
) -> Status {
    of_q(workspace, Quantity::CentroidalMomentumMatrix, (q, nq), (matrix, matrix_len))
}

/// The poses of all frames in the world, 12 numbers each: the rotation by rows, then the translation. Does
/// not allocate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rd_frame_poses(
    workspace: WorkspaceHandle,
    q: *const f64,
    nq: usize,
    poses: *mut f64,
    poses_len: usize,
) -> Status {
    of_q(workspace, Quantity::FramePoses, (q, nq), (poses, poses_len))
}
