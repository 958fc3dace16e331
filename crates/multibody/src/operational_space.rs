//! The robot as its hand feels it, and controls that make it follow a motion.
//!
//! Source of the operational-space quantities: Khatib, *A unified approach for motion and force control of
//! robot manipulators*, IEEE J. Robotics and Automation 3 (1987).

mod computed_torque;
mod task;

pub use computed_torque::{ComputedTorque, Reference};
pub use task::{TaskControl, TaskReference};

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use crate::constraint::ClosureRow;
use crate::motion_error::check_vector;
use crate::place::check_length;
use crate::{
    FrameId, Model, MotionError, Workspace, bias, check_configuration, frame_bias_acceleration_world_aligned,
    frame_jacobian_world_aligned, inverse_mass_matrix, sparse_cholesky,
};

/// The dynamics of a frame: Λ ẍ + μ + p = F, x the chosen directions of its world-aligned velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationalSpace {
    /// Λ = (J M⁻¹Jᵀ)⁻¹, K×K: the inertia a force at the frame meets \[kg, kg·m, kg·m²\].
    pub inertia: DMatrix<f64>,
    /// J, K×nv: the chosen rows of the world-aligned frame Jacobian.
    pub jacobian: DMatrix<f64>,
    /// J̄ = M⁻¹JᵀΛ, nv×K: J J̄ = 1, and τ ↦ J̄ᵀτ is the force at the frame that τ amounts to.
    pub consistent_inverse: DMatrix<f64>,
    /// J̇ v, K.
    pub bias_acceleration: DVector<f64>,
    /// μ + p = J̄ᵀ(C v + g) − Λ J̇ v, K: what it takes to keep ẍ = 0.
    pub bias_force: DVector<f64>,
}

/// Why a frame has no operational space.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OperationalSpaceError {
    /// q or v is wrong.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A pose from which the frame cannot accelerate in every chosen direction.
    #[error(
        "the frame cannot accelerate in every chosen direction: beside the later ones, `{row}` has the \
         mobility {pivot:e}; choose fewer rows, or leave the singular pose"
    )]
    Singular {
        /// The row at which the factorisation broke down.
        row: &'static str,
        /// What is left of its mobility (J M⁻¹Jᵀ) \[1/kg or 1/(kg·m²)\].
        pivot: f64,
    },
}

/// Λ, J̄ and μ + p of a frame, for the rows chosen of x, y, z, rx, ry, rz along the world's axes.
///
/// F = Λ ẍ + μ + p with τ = JᵀF; forces (1 − JᵀJ̄ᵀ) τ₀ move the robot without moving the frame.
///
/// # Errors
/// [`OperationalSpaceError`]: q is no configuration, v is not finite, or J M⁻¹Jᵀ is singular.
///
/// # Panics
/// If no row is chosen, or the frame is another model's.
pub fn operational_space(
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    v: &[f64],
    frame: FrameId,
    rows: &[ClosureRow],
) -> Result<OperationalSpace, OperationalSpaceError> {
    assert!(!rows.is_empty(), "an operational space needs at least one row");
    check_configuration(model, q).map_err(MotionError::from)?;
    check_vector(model, "v", v)?;
    let nv = model.nv();
    let indices: Vec<usize> = rows.iter().map(|row| *row as usize).collect();
    let mut full = vec![0.0; 6 * nv];
    frame_jacobian_world_aligned(model, workspace, q, frame, &mut full);
    let jacobian = DMatrix::from_row_slice(6, nv, &full).select_rows(&indices);
    let rate = frame_bias_acceleration_world_aligned(model, workspace, q, v, frame);
    let rate = DVector::from_vec([rate.linear, rate.angular].concat()).select_rows(&indices);
    let mut inverse_mass = DMatrix::zeros(nv, nv);
    inverse_mass_matrix(model, workspace, q, inverse_mass.as_mut_slice());
    let mut force = DVector::zeros(nv);
    bias(model, workspace, q, v, force.as_mut_slice());

    let response = &inverse_mass * jacobian.transpose();
    let mobility = &jacobian * &response;
    // Factored from the last row on, as λ(k) = k − 1 leaves the dense factorisation.
    let carrier: Vec<usize> =
        (0..rows.len()).map(|k| k.checked_sub(1).unwrap_or(sparse_cholesky::NONE)).collect();
    let mut pivots: Vec<f64> = mobility.as_slice().to_vec();
    if let Some((row, pivot)) = sparse_cholesky::singular_pivot(&carrier, &mut pivots) {
        return Err(OperationalSpaceError::Singular { row: rows[row].name(), pivot });
    }
    let inertia = mobility.cholesky().map(|factor| factor.inverse()).unwrap_or_default();
    let inertia = (&inertia + inertia.transpose()) * 0.5;
    let consistent_inverse = response * &inertia;
    let bias_force = consistent_inverse.tr_mul(&force) - &inertia * &rate;
    Ok(OperationalSpace { inertia, jacobian, consistent_inverse, bias_acceleration: rate, bias_force })
}

impl OperationalSpace {
    /// τ = JᵀF with F = Λ ẍ + μ + p: the torque that gives the frame this acceleration.
    ///
    /// # Panics
    /// If ẍ has the wrong length.
    pub fn torque(&self, acceleration: &[f64]) -> DVector<f64> {
        check_length("the acceleration", acceleration.len(), self.inertia.nrows());
        let force = &self.inertia * DVector::from_column_slice(acceleration) + &self.bias_force;
        self.jacobian.tr_mul(&force)
    }

    /// (1 − JᵀJ̄ᵀ) τ₀: what is left of a torque when its force at the frame is taken out.
    ///
    /// # Panics
    /// If τ₀ has the wrong length.
    pub fn null_torque(&self, tau: &[f64]) -> DVector<f64> {
        check_length("tau", tau.len(), self.jacobian.ncols());
        let tau = DVector::from_column_slice(tau);
        let force = self.consistent_inverse.tr_mul(&tau);
        tau - self.jacobian.tr_mul(&force)
    }
}
