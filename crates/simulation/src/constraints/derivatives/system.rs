//! The linear system of the derivatives, and the derivatives of its parts.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{
    InverseDynamicsDerivativesMut, InversePullbackInputs, InversePullbackMut, Model, Workspace,
    inverse_dynamics_derivatives, inverse_dynamics_pullback_with_parameters,
};

use super::super::row_factor::{MassFactor, RowFactor};
use crate::equality::row_derivatives::{MovingRows, RowWeights};

/// X and Y of M X − Aᵀ Y = F, A X = C, on the independent rows; Y is 0 on the others.
///
/// With A = T E and R = E M⁻¹: W = T⁻¹C − R F, X = M⁻¹F + Rᵀ W, Y = T⁻ᵀ W.
pub(super) fn solve_system(
    mass: &MassFactor,
    factor: &RowFactor,
    forces: DMatrix<f64>,
    rates: &DMatrix<f64>,
) -> [DMatrix<f64>; 2] {
    let mut along = factor.solve_triangle_columns(rates);
    along.gemm(-1.0, &factor.responses, &forces, 1.0);
    let mut x = mass.solve_columns(forces);
    x.gemm_tr(1.0, &factor.responses, &along, 1.0);
    [x, factor.solve_transposed_columns(&along)]
}

/// ∂ID/∂q and ∂ID/∂v.
pub(super) fn inverse_derivatives(
    model: &Model,
    workspace: &mut Workspace,
    [q, v, a]: [&[f64]; 3],
) -> [DMatrix<f64>; 2] {
    let nv = model.nv();
    // The functions write rows; a matrix of nalgebra has columns.
    let [mut by_position, mut by_velocity] = [(); 2].map(|()| DMatrix::zeros(nv, nv));
    let derivatives = InverseDynamicsDerivativesMut {
        by_position: by_position.as_mut_slice(),
        by_velocity: by_velocity.as_mut_slice(),
    };
    inverse_dynamics_derivatives(model, workspace, q, v, a, derivatives);
    by_position.transpose_mut();
    by_velocity.transpose_mut();
    [by_position, by_velocity]
}

/// uᵀ∂ID/∂q and uᵀ∂ID/∂v, and adds uᵀ∂ID/∂ of the parameters.
pub(super) fn pull_inverse_dynamics(
    model: &Model,
    workspace: &mut Workspace,
    [q, v, a]: [&[f64]; 3],
    cotangent: &DVector<f64>,
    parameters: &mut [f64],
) -> [DVector<f64>; 3] {
    let [mut by_position, mut by_velocity, mut by_acceleration] =
        [(); 3].map(|()| DVector::zeros(model.nv()));
    let results = InversePullbackMut {
        by_position: by_position.as_mut_slice(),
        by_velocity: by_velocity.as_mut_slice(),
        by_acceleration: by_acceleration.as_mut_slice(),
        parameters,
    };
    let inputs = InversePullbackInputs { q, v, a, wrenches: &[], cotangent: cotangent.as_slice() };
    inverse_dynamics_pullback_with_parameters(model, workspace, inputs, results);
    [by_position, by_velocity, by_acceleration]
}

/// ∂(A v)/∂q of the rows in a motion, K×nv.
pub(super) fn rate_derivative(moving: &MovingRows<'_>, count: usize, nv: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(count, nv);
    moving.each_entry(RowWeights { acceleration: 0.0, rate: 1.0 }, |row, at, [entry, _]| {
        matrix[(row, at)] += entry;
    });
    matrix
}

/// ∂(Aᵀλ)/∂q, nv×nv.
pub(super) fn force_derivative(moving: &MovingRows<'_>, multipliers: &[f64], nv: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(nv, nv);
    moving.force_derivative(multipliers, |i, j, entry| matrix[(i, j)] += entry);
    matrix
}
