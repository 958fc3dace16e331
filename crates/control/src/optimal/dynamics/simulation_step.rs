//! A step of a simulation, with contact, stops and friction.

use std::sync::Arc;

use robot_dynamics_core::{Model, difference};
use robot_dynamics_description::{Activation, ActuatorDescription};
use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::simulator::{Simulation, SimulationStepper};
use robot_dynamics_simulation::{
    LinearizedStep, LinearizedStepWithParameters, RobotState, StepError, StepForces, StepWorkspace, Stepper,
    linearize_stepper, linearize_stepper_with_parameters,
};

use super::{ActuationMatrix, DiscreteDynamics, LinearizedDynamics};
use crate::optimal::StateSpace;

/// One step of a simulation: x = (q, v), τ = S u constant over the step, with everything that acts in the
/// simulation: contact, stops, friction, actuators at the simulation's controls. With
/// [`with_actuators`](Self::with_actuators), u holds the controls of the actuators instead.
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
    input: Input,
    workspace: StepWorkspace,
    tau: Vec<f64>,
    /// ∂x′/∂τ.
    by_force: Vec<f64>,
}

/// The meaning of u.
#[derive(Clone, Debug)]
enum Input {
    /// τ = S u.
    Torques(ActuationMatrix),
    /// The controls of this many actuators.
    Controls(usize),
}

/// The step of a difference by a control, relative to 1 + |u|.
const DIFFERENCE: f64 = 6e-6; // the cube root of the unit of rounding

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
            input: Input::Torques(ActuationMatrix::identity(&model)),
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
        self.input = Input::Torques(actuation);
        Ok(self)
    }

    /// The same with the controls of the robot's actuators as u, in their order: motors with gears, servos
    /// and tendons within their ranges. A force at its bound has no slope, so bounds of the controls help the
    /// solver.
    ///
    /// ```
    /// use robot_dynamics::control::optimal::{DiscreteDynamics, SimulationStep};
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Method, SimulationBuilder};
    /// let mut robot = pendulum(1.0, 1.0);
    /// robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 50.0)));
    /// let model = Model::new(robot)?;
    /// let simulation = SimulationBuilder::new(&model).method(Method::Implicit).dt(0.01).build()?;
    /// let (mut swing, mut next) = (SimulationStep::new(&simulation).with_actuators()?, [0.0; 2]);
    /// let weight = model.gravity_forces(&[0.0])?[0];
    /// swing.step(&[0.0, 0.0], &[weight / 50.0], &mut next)?; // the motor holds the rod level
    /// assert!(next.iter().all(|x| x.abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] if the method evaluates no actuator, or an actuator has states: activation dynamics,
    /// an integral term or a motor with states.
    pub fn with_actuators(mut self) -> Result<Self, InvalidInput> {
        let count = self.fresh.control_count();
        if count == 0 {
            let requirement = "evaluates no actuator; take a robot with actuators and the method `implicit`";
            return Err(InvalidInput::unmet("the simulation", requirement));
        }
        let actuators = &self.model.description().actuators;
        let is_static = |own: &ActuatorDescription| {
            let motor = own.motor.as_ref();
            let has_state = motor.is_some_and(|motor| {
                motor.current.is_some() || motor.winding.is_some() || motor.friction.is_some()
            });
            own.activation == Activation::None && own.integral.is_none() && !has_state
        };
        if let Some(own) = actuators.iter().find(|own| !is_static(own)) {
            let requirement = "has states, which are not part of x";
            return Err(InvalidInput::unmet(format!("actuator `{}`", own.name), requirement));
        }
        self.input = Input::Controls(count);
        Ok(self)
    }

    /// Starts a step with u.
    fn start(&mut self, u: &[f64]) {
        self.stepper.clone_from(&self.fresh);
        match &self.input {
            Input::Torques(actuation) => actuation.forces(u, &mut self.tau),
            Input::Controls(_) => self.stepper.hold_controls(u),
        }
    }

    /// Writes ∂x′/∂u by central differences, where the step has no analytic derivative by controls.
    fn difference_controls(&mut self, x: &[f64], u: &[f64], by_control: &mut [f64]) -> Result<(), StepError> {
        let (nv, width) = (self.model.nv(), u.len());
        let mut changed = u.to_vec();
        let [mut before, mut after] = [vec![0.0; x.len()], vec![0.0; x.len()]];
        let mut change = vec![0.0; 2 * nv];
        for k in 0..width {
            let by = DIFFERENCE * (1.0 + u[k].abs());
            for (end, next) in [(-by, &mut before), (by, &mut after)] {
                changed[k] = u[k] + end;
                self.step(x, &changed, next)?;
            }
            changed[k] = u[k];
            let (position, velocity) = change.split_at_mut(nv);
            let nq = self.model.nq();
            difference(&self.model, &before[..nq], &after[..nq], position);
            for (entry, (after, before)) in velocity.iter_mut().zip(after[nq..].iter().zip(&before[nq..])) {
                *entry = after - before;
            }
            for (row, entry) in change.iter().enumerate() {
                by_control[row * width + k] = entry / (2.0 * by);
            }
        }
        Ok(())
    }
}

impl DiscreteDynamics for SimulationStep {
    fn state_space(&self) -> &StateSpace {
        &self.space
    }

    fn controls(&self) -> usize {
        match &self.input {
            Input::Torques(actuation) => actuation.controls(),
            Input::Controls(count) => *count,
        }
    }

    fn step(&mut self, x: &[f64], u: &[f64], next: &mut [f64]) -> Result<(), StepError> {
        self.start(u);
        next.copy_from_slice(x);
        let (q, v) = next.split_at_mut(self.model.nq());
        let forces = StepForces::new(&self.tau, self.dissipation);
        self.stepper.step(&self.model, &mut self.workspace, &forces, self.step, q, v)
    }

    fn linearize(
        &mut self,
        x: &[f64],
        u: &[f64],
        derivatives: LinearizedDynamics<'_>,
    ) -> Result<(), StepError> {
        let LinearizedDynamics { by_state, by_control } = derivatives;
        self.start(u);
        let (q, v) = x.split_at(self.model.nq());
        let (forces, state) = (StepForces::new(&self.tau, self.dissipation), RobotState { q, v });
        let step = LinearizedStep { by_state, by_force: &mut self.by_force };
        let (stepper, workspace) = (&mut self.stepper, &mut self.workspace);
        if let Input::Torques(actuation) = &self.input {
            linearize_stepper(&self.model, stepper, workspace, &forces, self.step, state, step)?;
            actuation.multiply(&self.by_force, by_control);
            return Ok(());
        }
        let (by_inertial, by_friction) = (&mut [][..], &mut [][..]);
        let out = LinearizedStepWithParameters { step, by_control, by_inertial, by_friction };
        let (model, h) = (&self.model, self.step);
        match linearize_stepper_with_parameters(model, stepper, workspace, &forces, h, state, out) {
            Err(StepError::ParametersNotDifferentiable { .. }) => {}
            done => return done.map(drop),
        }
        // The step is taken from its start again.
        self.start(u);
        let (stepper, workspace) = (&mut self.stepper, &mut self.workspace);
        let forces = StepForces::new(&self.tau, self.dissipation);
        let step = LinearizedStep { by_state, by_force: &mut self.by_force };
        linearize_stepper(&self.model, stepper, workspace, &forces, h, state, step)?;
        self.difference_controls(x, u, by_control)
    }

    fn boxed_clone(&self) -> Box<dyn DiscreteDynamics> {
        Box::new(self.clone())
    }
}
