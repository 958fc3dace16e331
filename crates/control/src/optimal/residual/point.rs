//! Differences from a state, and from controls.

use robot_dynamics_number::{InvalidInput, check_finite};
use robot_dynamics_simulation::StepError;

use super::{Residual, ResidualInputs, ResidualJacobian};
use crate::optimal::StateSpace;

/// r = x ⊖ x\*, with `tangent` numbers: (q ⊖ q\*, v − v\*) for a robot.
#[derive(Clone, Debug)]
pub struct StateResidual {
    space: StateSpace,
    reference: Vec<f64>,
}

impl StateResidual {
    /// The difference from `reference`, a state of the space.
    ///
    /// # Errors
    /// [`InvalidInput`] if the reference is not a state of the space.
    pub fn new(space: &StateSpace, reference: &[f64]) -> Result<Self, InvalidInput> {
        space.check("the reference state", reference)?;
        Ok(Self { space: space.clone(), reference: reference.to_vec() })
    }
}

impl Residual for StateResidual {
    fn dimension(&self) -> usize {
        self.space.tangent()
    }

    fn expects(&self) -> ResidualInputs {
        ResidualInputs { coordinates: Some(self.space.coordinates()), controls: None }
    }

    fn evaluate(&mut self, x: &[f64], _u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        self.space.difference(&self.reference, x, residual);
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        _u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        self.space.difference(&self.reference, x, residual);
        self.space.difference_derivative(&self.reference, x, jacobian.by_state);
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}

/// r = u − u\*.
#[derive(Clone, Debug)]
pub struct ControlResidual {
    reference: Vec<f64>,
}

impl ControlResidual {
    /// The difference from `reference`, one number a control.
    ///
    /// # Errors
    /// [`InvalidInput`] if a number is not finite.
    pub fn new(reference: &[f64]) -> Result<Self, InvalidInput> {
        check_finite("the reference controls", reference)?;
        Ok(Self { reference: reference.to_vec() })
    }
}

impl Residual for ControlResidual {
    fn dimension(&self) -> usize {
        self.reference.len()
    }

    fn expects(&self) -> ResidualInputs {
        ResidualInputs { coordinates: None, controls: Some(self.reference.len()) }
    }

    fn evaluate(&mut self, _x: &[f64], u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        for ((r, u), reference) in residual.iter_mut().zip(u).zip(&self.reference) {
            *r = u - reference;
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
        let m = self.reference.len();
        for i in 0..m {
            jacobian.by_control[i * m + i] = 1.0;
        }
        self.evaluate(x, u, residual)
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        Box::new(self.clone())
    }
}
