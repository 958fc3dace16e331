//! A step of a simulation, with contact, stops and friction.

use std::sync::Arc;

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::simulator::{Simulation, SimulationStepper};
use robot_dynamics_simulation::{
    LinearizedStep, RobotState, StepError, StepForces, StepWorkspace, Stepper, linearize_stepper,
};

use super::{ActuationMatrix, DiscreteDynamics, LinearizedDynamics};
use crate::optimal::StateSpace;

/// One step of a simulation: x = (q, v), τ = S u constant over the step, with everything that acts in the
/// simulation: contact, stops, friction, actuators at the simulation's controls.
///
/// A and B are those of [`linearize_stepper`]. They are analytic for the method `implicit`, also through
/// impacts. x′ is a function of x and u alone: each step starts without the contact forces of
/// an earlier step, so they are of first order in the step. A contact that sticks or is open has no slope in
/// the directions that it blocks or does not reach. The initial controls should therefore move the robot.
///
/// ```
/// use robot_dynamics::control::optimal::{DiscreteDynamics, SimulationStep};
/// use robot_dynamics::description::{Limits, pendulum};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::{Method, SimulationBuilder};
/// let mut robot = pendulum(1.0, 1.0);
/// robot.joints[0].limits = Limits::new(-1.0, 0.0);
/// let model = Model::new(robot)?;
/// let simulation = SimulationBuilder::new(&model).method(Method::Implicit).dt(0.01).build()?;
/// let (mut swing, mut next) = (SimulationStep::new(&simulation), [0.0; 2]);
/// swing.step(&[0.0, 0.0], &[0.0], &mut next)?; // its weight pulls it against the stop
/// assert_eq!(next, [0.0, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SimulationStep {
    space: StateSpace,
    model: Arc<Model>,
    fresh: SimulationStepper,
    stepper: SimulationStepper,
    step: f64,
    dissipation: bool,
    actuation: ActuationMatrix,
    workspace: StepWorkspace,
    tau: Vec<f64>,
    /// ∂x′/∂τ.
    by_force: Vec<f64>,
}

impl SimulationStep {
    /// A step of this simulation, with one control for each coordinate.
    pub fn new(simulation: &Simulation) -> Self {
        let model = Arc::clone(simulation.shared_model());
        let nv = model.nv();
        let fresh = simulation.stepper();
        Self {
            space: StateSpace::robot(model.clone()),
            stepper: fresh.clone(),
            fresh,
            step: simulation.dt(),
            dissipation: simulation.dissipates(),
            actuation: ActuationMatrix::identity(&model),
            workspace: StepWorkspace::new(&model),
            tau: vec![0.0; nv],
            by_force: vec![0.0; 2 * nv * nv],
            model,
        }
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
}

impl DiscreteDynamics for SimulationStep {
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
        self.stepper.clone_from(&self.fresh);
        self.stepper.step(&self.model, &mut self.workspace, &forces, self.step, q, v)
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
        self.stepper.clone_from(&self.fresh);
        let (stepper, workspace) = (&mut self.stepper, &mut self.workspace);
        linearize_stepper(&self.model, stepper, workspace, &forces, self.step, RobotState { q, v }, out)?;
        self.actuation.multiply(&self.by_force, by_control);
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics> {
        Box::new(self.clone())
    }
}
