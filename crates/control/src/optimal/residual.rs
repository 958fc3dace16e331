//! Residuals r(x, u): the vectors of which costs and constraints are made.

mod center_of_mass;
mod contact_force;
mod differentiated;
mod frame;
mod frame_velocity;
mod point;

pub use center_of_mass::CenterOfMassResidual;
pub use contact_force::ContactForceResidual;
pub use differentiated::{DifferentiatedResidual, ResidualFunction};
pub use frame::{FramePlacementResidual, FrameRotationResidual, FrameTranslationResidual};
pub use frame_velocity::FrameVelocityResidual;
pub use point::{ControlResidual, StateResidual};

use robot_dynamics_simulation::StepError;

use super::dynamics::ContactForces;

/// A vector r(x, u) of a node with its derivatives.
///
/// At the terminal node u is empty. An implementation owns its scratch memory; each thread of a solver works
/// on a clone.
pub trait Residual: Send {
    /// The number of entries of r.
    fn dimension(&self) -> usize;

    /// The number of coordinates of x, of entries of δx, and of controls that it expects; `None` for a part
    /// on which it does not depend.
    fn expects(&self) -> ResidualInputs;

    /// Writes r(x, u).
    ///
    /// # Errors
    /// [`StepError`] if r cannot be computed.
    fn evaluate(&mut self, x: &[f64], u: &[f64], residual: &mut [f64]) -> Result<(), StepError>;

    /// Writes r and its derivatives. `jacobian` holds zeros at the call.
    ///
    /// # Errors
    /// [`StepError`] if r or a derivative cannot be computed.
    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError>;

    /// Takes the forces that the node's dynamics computed, for a residual that reads forces.
    fn reuse(&mut self, _forces: &ContactForces<'_>) {}

    /// A clone in a box.
    fn boxed_clone(&self) -> Box<dyn Residual>;
}

/// The sizes that a [`Residual`] expects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResidualInputs {
    /// Coordinates of x.
    pub coordinates: Option<usize>,
    /// Controls u.
    pub controls: Option<usize>,
}

/// The derivatives of r(x, u), as the outputs of [`Residual::linearize`].
#[derive(Debug)]
pub struct ResidualJacobian<'a> {
    /// ∂r/∂x along displacements δx, `dimension` × `tangent`, row-major.
    pub by_state: &'a mut [f64],
    /// ∂r/∂u, `dimension` × `controls`, row-major.
    pub by_control: &'a mut [f64],
}

impl Clone for Box<dyn Residual> {
    fn clone(&self) -> Self {
        (**self).boxed_clone()
    }
}

impl Residual for Box<dyn Residual> {
    fn dimension(&self) -> usize {
        (**self).dimension()
    }

    fn expects(&self) -> ResidualInputs {
        (**self).expects()
    }

    fn evaluate(&mut self, x: &[f64], u: &[f64], residual: &mut [f64]) -> Result<(), StepError> {
        (**self).evaluate(x, u, residual)
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        residual: &mut [f64],
        jacobian: ResidualJacobian<'_>,
    ) -> Result<(), StepError> {
        (**self).linearize(x, u, residual, jacobian)
    }

    fn reuse(&mut self, forces: &ContactForces<'_>) {
        (**self).reuse(forces);
    }

    fn boxed_clone(&self) -> Box<dyn Residual> {
        (**self).boxed_clone()
    }
}
