//! Records of measured motions.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::{
    Model, PARAMETERS_PER_LINK, Workspace, check_configuration, check_vector, dissipation,
    inertial_parameters, inverse_dynamics, joint_torque_regressor,
};
use robot_dynamics_number::{InvalidInput, check_result};

/// Samples (q, v, a, τ) of one robot, as equations W π = τ.
///
/// Forces of the model's armature and springs, and optionally of damping and friction, do not depend on the
/// inertial parameters and are subtracted from τ.
#[derive(Clone, Debug)]
pub struct MotionRecord<'a> {
    pub(super) model: &'a Model,
    workspace: Workspace,
    /// Whether τ includes the joints' damping and friction.
    with_dissipation: bool,
    nominal: DVector<f64>,
    pub(super) rows: Vec<f64>,
    pub(super) torques: Vec<f64>,
}

impl<'a> MotionRecord<'a> {
    /// Creates an empty record. `with_dissipation` states whether the torques include the damping and
    /// friction of the model's joints.
    pub fn new(model: &'a Model, with_dissipation: bool) -> Self {
        let nominal = DVector::from_vec(inertial_parameters(model));
        let workspace = Workspace::new(model);
        Self { model, workspace, with_dissipation, nominal, rows: Vec::new(), torques: Vec::new() }
    }

    /// Adds a state with its acceleration and the torque measured there.
    ///
    /// # Errors
    /// [`InvalidInput`] with the number of the sample.
    pub fn push(&mut self, q: &[f64], v: &[f64], a: &[f64], tau: &[f64]) -> Result<(), InvalidInput> {
        let nv = self.model.nv();
        let sample = self.len();
        let bad_sample = |error: InvalidInput| {
            let quantity = format!("sample {sample}: {}", error.quantity);
            error.of(quantity)
        };
        check_configuration(self.model, q).map_err(bad_sample)?;
        for (name, values) in [("v", v), ("a", a), ("tau", tau)] {
            check_vector(self.model, name, values).map_err(bad_sample)?;
        }
        let regressor = self.regressor(q, v, a);
        // τ − (ID − Y π): the passive forces of the joints are the difference of inverse dynamics and Y π.
        let mut passive = DVector::zeros(nv);
        inverse_dynamics(self.model, &mut self.workspace, q, v, a, passive.as_mut_slice());
        passive -= &regressor * &self.nominal;
        if self.with_dissipation {
            let mut friction = DVector::zeros(nv);
            dissipation(self.model, v, friction.as_mut_slice());
            passive += friction;
        }
        let torques = DVector::from_column_slice(tau) - passive;
        check_result("Y π − τ", regressor.iter().chain(torques.iter())).map_err(bad_sample)?;
        self.torques.extend(torques.iter());
        self.rows.extend(regressor.transpose().iter());
        Ok(())
    }

    /// The number of samples.
    pub fn len(&self) -> usize {
        self.torques.len().checked_div(self.model.nv()).unwrap_or(0)
    }

    /// Whether the record is empty.
    pub fn is_empty(&self) -> bool {
        self.torques.is_empty()
    }

    /// Y(q,v,a), nv × 10·links.
    fn regressor(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> DMatrix<f64> {
        let (nv, columns) = (self.model.nv(), self.nominal.len());
        debug_assert_eq!(columns % PARAMETERS_PER_LINK, 0);
        let mut regressor = vec![0.0; nv * columns];
        joint_torque_regressor(self.model, &mut self.workspace, q, v, a, &mut regressor);
        DMatrix::from_row_slice(nv, columns, &regressor)
    }

    /// W, with one block of nv rows per sample.
    pub(super) fn stacked(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.torques.len(), self.nominal.len(), &self.rows)
    }
}
