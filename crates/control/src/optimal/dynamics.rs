//! The dynamics x′ = f(x, u) of a node.

mod actuation_matrix;
mod contact_forces;
mod held_contact_step;
mod impact_step;
mod linear;
mod simulation_step;
mod smooth_step;

pub use actuation_matrix::ActuationMatrix;
pub use contact_forces::ContactForces;
pub use held_contact_step::HeldContactStep;
pub use impact_step::ImpactStep;
pub use linear::LinearDynamics;
pub use simulation_step::SimulationStep;
pub use smooth_step::SmoothStep;

use robot_dynamics_simulation::StepError;

use super::StateSpace;

/// Discrete dynamics x′ = f(x, u) on a manifold, with derivatives: δx′ = A δx + B δu.
///
/// A node calls it with states of the space and `controls` numbers u. An implementation owns its scratch
/// memory; each thread of a solver works on a clone.
#[doc(alias = "ActionModel")]
pub trait DiscreteDynamics: Send {
    /// The space of x and of x′.
    fn state_space(&self) -> &StateSpace;

    /// The number of controls u.
    fn controls(&self) -> usize;

    /// Writes x′ = f(x, u) to `next`.
    ///
    /// # Errors
    /// [`StepError`] if the next state cannot be computed; a line search then takes a shorter step.
    fn step(&mut self, x: &[f64], u: &[f64], next: &mut [f64]) -> Result<(), StepError>;

    /// Writes A and B at (x, u).
    ///
    /// # Errors
    /// [`StepError`] if the derivatives do not exist or are not finite.
    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        derivatives: LinearizedDynamics<'_>,
    ) -> Result<(), StepError>;

    /// The forces of held contacts at the last evaluation; `None` for dynamics without such contacts.
    fn contact_forces(&self) -> Option<ContactForces<'_>> {
        None
    }

    /// A clone in a box.
    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics>;
}

/// The derivatives of x′ = f(x, u), as the outputs of [`DiscreteDynamics::linearize`].
///
/// δx is a displacement at x and δx′ one at x′, as of [`StateSpace::integrate`].
#[derive(Debug)]
pub struct LinearizedDynamics<'a> {
    /// A = ∂x′/∂x, n×n with n = `tangent`, row-major.
    pub by_state: &'a mut [f64],
    /// B = ∂x′/∂u, n×m with m = `controls`, row-major.
    pub by_control: &'a mut [f64],
}

impl Clone for Box<dyn DiscreteDynamics> {
    fn clone(&self) -> Self {
        (**self).boxed_clone()
    }
}

impl DiscreteDynamics for Box<dyn DiscreteDynamics> {
    fn state_space(&self) -> &StateSpace {
        (**self).state_space()
    }

    fn controls(&self) -> usize {
        (**self).controls()
    }

    fn step(&mut self, x: &[f64], u: &[f64], next: &mut [f64]) -> Result<(), StepError> {
        (**self).step(x, u, next)
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        derivatives: LinearizedDynamics<'_>,
    ) -> Result<(), StepError> {
        (**self).linearize(x, u, derivatives)
    }

    fn contact_forces(&self) -> Option<ContactForces<'_>> {
        (**self).contact_forces()
    }

    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics> {
        (**self).boxed_clone()
    }
}
