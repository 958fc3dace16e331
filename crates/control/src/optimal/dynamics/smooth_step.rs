//! A step by an explicit integrator without contact.

use std::sync::Arc;

use robot_dynamics_core::Model;
use robot_dynamics_integrators::{Integrator, StepScheme};
use robot_dynamics_number::{InvalidInput, check_positive};
use robot_dynamics_simulation::{
    LinearizeStepWorkspace, LinearizedStep, RobotState, StepError, StepForces, StepWorkspace, linearize_step,
    step,
};

use super::{ActuationMatrix, DiscreteDynamics, LinearizedDynamics};
use crate::optimal::StateSpace;

/// One step of a robot by an explicit integrator: x = (q, v), τ = S u constant over the step.
///
/// A and B are the exact derivatives of [`linearize_step`]. Only the joints' own springs, damping and
/// friction act; there are no contacts, stops or actuator dynamics.
///
/// ```
/// use robot_dynamics::control::optimal::{DiscreteDynamics, SmoothStep};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Integrator;
/// let mut swing = SmoothStep::new(Model::new(pendulum(1.0, 1.0))?, Integrator::SemiImplicitEuler, 0.01)?;
/// let mut next = [0.0; 2];
/// swing.step(&[0.0, 0.0], &[0.0], &mut next)?; // horizontal, at rest: it falls
/// assert!((next[1] - 0.01 * 9.81).abs() < 1e-14 && (next[0] - 0.01 * next[1]).abs() < 1e-16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SmoothStep {
    space: StateSpace,
    model: Arc<Model>,
    integrator: Integrator,
    step: f64,
    dissipation: bool,
    actuation: ActuationMatrix,
    workspace: StepWorkspace,
    linearization: LinearizeStepWorkspace,
    tau: Vec<f64>,
    /// ∂x′/∂τ.
    by_force: Vec<f64>,
}

impl SmoothStep {
    /// A step of `step` seconds with one control for each coordinate, and with damping and friction.
    ///
    /// # Errors
    /// [`StepError`] if the step is not positive and finite, or the integrator is not explicit.
    pub fn new(model: impl Into<Arc<Model>>, integrator: Integrator, step: f64) -> Result<Self, StepError> {
        check_positive("the step", step, "s")?;
        if !matches!(integrator.scheme(), StepScheme::Explicit(_)) {
            return Err(StepError::NotDifferentiable { integrator });
        }
        let model = model.into();
        let nv = model.nv();
        Ok(Self {
            space: StateSpace::robot(model.clone()),
            integrator,
            step,
            dissipation: true,
            actuation: ActuationMatrix::identity(&model),
            workspace: StepWorkspace::new(&model),
            linearization: LinearizeStepWorkspace::new(&model),
            tau: vec![0.0; nv],
            by_force: vec![0.0; 2 * nv * nv],
            model,
        })
    }

    /// The same with other actuation: τ = S u.
    ///
    /// # Errors
    /// [`InvalidInput`] if S does not have nv rows, or has no column.
    pub fn with_actuation(mut self, actuation: ActuationMatrix) -> Result<Self, InvalidInput> {
        actuation.check(&self.model)?;
        self.actuation = actuation;
        Ok(self)
    }

    /// The same with or without the joints' damping and friction. The sign of friction is held constant in A.
    pub fn with_dissipation(mut self, dissipation: bool) -> Self {
        self.dissipation = dissipation;
        self
    }
}

impl DiscreteDynamics for SmoothStep {
    fn state_space(&self) -> &StateSpace {
        &self.space
    }

    fn controls(&self) -> usize {
        self.actuation.controls()
    }

    fn step(&mut self, x: &[f64], u: &[f64], next: &mut [f64]) -> Result<(), StepError> {
        self.actuation.forces(u, &mut self.tau);
        next.copy_from_slice(x);
        let (q, v) = next.split_at_mut(self.model.nq());
        let forces = StepForces::new(&self.tau, self.dissipation);
        step(&self.model, self.integrator, &mut self.workspace, &forces, self.step, q, v)?;
        Ok(())
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        derivatives: LinearizedDynamics<'_>,
    ) -> Result<(), StepError> {
        let LinearizedDynamics { by_state, by_control } = derivatives;
        self.actuation.forces(u, &mut self.tau);
        let (q, v) = x.split_at(self.model.nq());
        let forces = StepForces::new(&self.tau, self.dissipation);
        let out = LinearizedStep { by_state, by_force: &mut self.by_force };
        let (scratch, state) = (&mut self.linearization, RobotState { q, v });
        linearize_step(&self.model, self.integrator, scratch, &forces, self.step, state, out)?;
        self.actuation.multiply(&self.by_force, by_control);
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics> {
        Box::new(self.clone())
    }
}
