//! The state of a simulation: access, reset, snapshot and restore.

use std::sync::Arc;

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;
use robot_dynamics_number::InvalidInput;

use super::method::SimulationStepper;
use super::stepping::Inputs;
use super::{AppliedWrench, Simulation};
use crate::{Actuation, Run, RunError};

/// The complete changing state of a simulation.
#[derive(Clone, Debug)]
pub struct Snapshot {
    model: Arc<Model>,
    run: Run,
    stepper: SimulationStepper,
    inputs: Inputs,
    base: (usize, f64),
    is_checked: bool,
    activations: Vec<f64>,
    limited: Vec<usize>,
    /// The results of the last step.
    acceleration: Vec<f64>,
    applied_torques: Vec<f64>,
}

impl Simulation {
    /// The robot, shared between copies of the simulation.
    pub fn shared_model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The time \[s\].
    pub fn time(&self) -> f64 {
        self.run.time
    }

    /// The number of steps since the last reset.
    pub fn steps(&self) -> usize {
        self.run.steps
    }

    /// The configuration.
    pub fn q(&self) -> &[f64] {
        &self.run.q
    }

    /// The velocity.
    pub fn v(&self) -> &[f64] {
        &self.run.v
    }

    /// The names of the actuators, in the order of the controls; empty if actuators do not act.
    pub fn control_names(&self) -> impl Iterator<Item = &str> {
        self.actuation.iter().flat_map(Actuation::control_names)
    }

    /// The held torques \[N·m or N\].
    pub fn torques(&self) -> &[f64] {
        &self.inputs.torques
    }

    /// The held controls.
    pub fn controls(&self) -> &[f64] {
        &self.inputs.controls
    }

    /// The stepper, if springs yield, whose rest positions are part of its state.
    pub(super) fn with_yielded_springs(&self) -> Option<SimulationStepper> {
        let yields = self.actuation.as_ref().is_some_and(Actuation::has_yielding_springs);
        yields.then(|| self.stepper.clone())
    }

    /// The activations of the actuators: equal to the controls, except for actuators with a filter, an
    /// integrator or another dynamics. Then the states of controllers and motors follow:
    /// [`Actuation::activation_count`].
    pub fn activations(&self) -> &[f64] {
        &self.activations
    }

    /// Sets the activations and the states of controllers and motors. Activations without dynamics become the
    /// controls at the next step.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, IntegralAction, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let mut servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(50.0, 9.0);
    /// servo.integral = Some(IntegralAction { gain: 100.0, limit: f64::INFINITY });
    /// robot.actuators.push(servo);
    /// let mut simulation = SimulationBuilder::new(&Model::new(robot)?).build()?;
    /// // The integral carries the weight of 2 kg, so the level rod does not sink.
    /// simulation.set_activations(&[0.0, -2.0 * 9.81 * 0.5 / 100.0]);
    /// simulation.run_for(1.0)?;
    /// assert!(simulation.q()[0].abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If the number of activations is wrong.
    #[track_caller]
    pub fn set_activations(&mut self, activations: &[f64]) {
        check_length("the activations", activations.len(), self.activations.len());
        self.activations.copy_from_slice(activations);
    }

    /// The held wrenches.
    pub fn wrenches(&self) -> &[AppliedWrench] {
        &self.inputs.wrenches
    }

    /// Resets the state to a pose of the file, a keyframe with its velocity and its controls, at time 0.
    ///
    /// ```
    /// use robot_dynamics::description::{NamedPose, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.poses.push(NamedPose::new("up", [("hinge".to_owned(), vec![1.5])]));
    /// let mut simulation = SimulationBuilder::new(&Model::new(robot)?).build()?;
    /// simulation.reset_to("up")?;
    /// assert_eq!(simulation.q(), [1.5]);
    /// assert!(simulation.reset_to("down").is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The pose is missing, or as [`reset`](Self::reset).
    #[doc(alias = "PoseError")]
    pub fn reset_to(&mut self, pose: &str) -> Result<(), RunError> {
        let Some((q, v)) = self.model.named_pose(pose) else {
            let names = self.model.description().poses.iter().map(|pose| pose.name.as_str());
            let owner = format!("robot `{}`", self.model.name());
            return Err(InvalidInput::unknown_name("pose", pose, owner, names).into());
        };
        let own = self.model.description().poses.iter().find(|own| own.name == pose);
        let controls = own.map_or(Vec::new(), |own| own.controls.clone());
        self.reset(&q, &v)?;
        for (control, given) in self.inputs.controls.iter_mut().zip(controls) {
            *control = given;
        }
        Ok(())
    }

    /// Copies the complete changing state, for [`restore`](Self::restore).
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// simulation.run_for(0.1)?;
    /// let snapshot = simulation.snapshot();
    /// simulation.run_for(0.1)?;
    /// let first = simulation.q().to_vec();
    /// simulation.restore(&snapshot);
    /// simulation.run_for(0.1)?;
    /// assert_eq!(simulation.q(), first); // bit for bit
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            model: Arc::clone(&self.model),
            run: self.run.clone(),
            stepper: self.stepper.clone(),
            inputs: self.inputs.clone(),
            base: self.base,
            is_checked: self.is_checked,
            activations: self.activations.clone(),
            limited: self.limited.clone(),
            acceleration: self.memory.acceleration.clone(),
            applied_torques: self.memory.tau.clone(),
        }
    }

    /// Whether a snapshot belongs to this simulation or to a clone of it.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let (one, other) = (SimulationBuilder::new(&model).build()?, SimulationBuilder::new(&model).build()?);
    /// assert!(one.clone().fits(&one.snapshot()) && !other.fits(&one.snapshot()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fits(&self, snapshot: &Snapshot) -> bool {
        Arc::ptr_eq(&self.model, &snapshot.model)
    }

    /// Restores a snapshot of this simulation or of a clone of it, bit for bit.
    ///
    /// # Panics
    /// Panics if the snapshot belongs to a simulation that was built differently.
    #[track_caller]
    pub fn restore(&mut self, snapshot: &Snapshot) {
        assert!(
            self.fits(snapshot),
            "the snapshot is of another simulation than this one of robot `{}`",
            self.model.name()
        );
        let Snapshot { run, stepper, inputs, base, is_checked, activations, limited, .. } = snapshot;
        self.run.clone_from(run);
        self.stepper.clone_from(stepper);
        self.inputs.clone_from(inputs);
        (self.base, self.is_checked) = (*base, *is_checked);
        self.activations.clone_from(activations);
        self.limited.clone_from(limited);
        self.memory.acceleration.clone_from(&snapshot.acceleration);
        self.memory.tau.clone_from(&snapshot.applied_torques);
    }
}
