//! Single quantities of the equation of motion M(q) v̇ + C(q, v) v + g(q) = τ, for programs.

use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;
use crate::LabError;

#[wasm_bindgen]
impl Robot {
    /// M(q), nv × nv numbers in row-major order \[kg, kg·m or kg·m²\].
    ///
    /// # Errors
    /// Fails if q has the wrong length or is not finite.
    #[wasm_bindgen(js_name = massMatrix)]
    pub fn mass_matrix(&self, q: &[f64]) -> Result<Vec<f64>, LabError> {
        // M is symmetric, so columns are rows.
        Ok(self.model.mass_matrix(q)?.as_slice().to_vec())
    }

    /// g(q): the torques that hold the robot at q \[N·m or N\].
    ///
    /// # Errors
    /// Fails if q has the wrong length or is not finite.
    #[wasm_bindgen(js_name = gravityForces)]
    pub fn gravity_forces(&self, q: &[f64]) -> Result<Vec<f64>, LabError> {
        Ok(self.model.gravity_forces(q)?.as_slice().to_vec())
    }

    /// τ = M v̇ + C v + g for a given acceleration \[N·m or N\].
    ///
    /// # Errors
    /// Fails if q, v or the acceleration has the wrong length or is not finite.
    #[wasm_bindgen(js_name = inverseDynamics)]
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], acceleration: &[f64]) -> Result<Vec<f64>, LabError> {
        Ok(self.model.inverse_dynamics(q, v, acceleration)?.as_slice().to_vec())
    }

    /// v̇ = M⁻¹ (τ − C v − g) \[rad/s² or m/s²\].
    ///
    /// # Errors
    /// Fails if q, v or τ has the wrong length or is not finite, or if M is singular.
    #[wasm_bindgen(js_name = forwardDynamics)]
    pub fn forward_dynamics(&self, q: &[f64], v: &[f64], torques: &[f64]) -> Result<Vec<f64>, LabError> {
        Ok(self.model.forward_dynamics(q, v, torques)?.as_slice().to_vec())
    }
}
