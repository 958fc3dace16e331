//! The centre of mass.

use std::sync::Arc;

use robot_dynamics_core::{Model, Workspace, center_of_mass, center_of_mass_jacobian};
use robot_dynamics_number::{InvalidInput, check_finite};
use robot_dynamics_simulation::StepError;

use super::{Residual, ResidualInputs, ResidualJacobian};

/// r = c − c\*: the centre of mass of the moving bodies relative to a target, in the world \[m\].
#[derive(Clone, Debug)]
pub struct CenterOfMassResidual {
    model: Arc<Model>,
    workspace: Workspace,
    target: [f64; 3],
    jacobian: Vec<f64>,
}

impl CenterOfMassResidual {
    /// The centre of mass relative to `target` \[m\].
    ///
    /// # Errors
    /// [`InvalidInput`] if the target is not finite, or the robot has no mass.
    pub fn new(model: impl Into<Arc<Model>>, target: [f64; 3]) -> Result<Self, InvalidInput> {
        check_finite("the target of the centre of mass", &target)?;
        let model = model.into();
        if model.moving_mass() <= 0.0 {
            return Err(InvalidInput::unmet("the robot", "has no moving mass, and no centre of mass"));
        }
        let jacobian = vec![0.0; 3 * model.nv()];
        Ok(Self { workspace: Workspace::new(&model), model, target, jacobian })
    }
}

impl Residual for CenterOfMassResidual {
    fn dimension(&self) -> usize {
        3
    }

    fn expects(&self) -> ResidualInputs {
        ResidualInputs { coordinates: Some(self.model.nq() + self.model.nv()), controls: None }
    }

    fn evaluate(&mut self, x: &[f64], _u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        let c = center_of_mass(&self.model, &mut self.workspace, &x[..self.model.nq()]);
        for ((r, c), target) in residual.iter_mut().zip(c).zip(self.target) {
            *r = c - target;
        }
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        let (nq, nv) = (self.model.nq(), self.model.nv());
        center_of_mass_jacobian(&self.model, &mut self.workspace, &x[..nq], &mut self.jacobian);
        for (row, own) in jacobian.by_state.chunks_exact_mut(2 * nv).zip(self.jacobian.chunks_exact(nv)) {
            row[..nv].copy_from_slice(own);
        }
        self.evaluate(x, u, residual)
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}
