//! Inputs from outside in the next steps.

use super::{AppliedWrench, Simulation};
use crate::model::length::check_length;

impl Simulation {
    /// The torques of the next steps, nv entries \[N·m or N\].
    ///
    /// # Panics
    /// If their number is wrong.
    #[track_caller]
    pub fn set_torques(&mut self, torques: &[f64]) {
        check_length("the torques", torques.len(), self.inputs.torques.len());
        self.inputs.torques.copy_from_slice(torques);
    }

    /// The controls of the actuators in the next steps, in the order of [`control_names`](Self::control_names).
    ///
    /// ```
    /// use multibody::{ActuatorDescription, Model, Transmission, pendulum};
    /// use multibody::simulator::{Method, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(1e6, 1e5);
    /// robot.actuators.push(servo);
    /// let mut simulation = SimulationBuilder::new(&Model::new(robot)?).step(1e-2).build()?;
    /// assert_eq!(simulation.method(), Method::Implicit); // no explicit step of 10 ms survives these gains
    /// simulation.set_controls(&[0.4]);
    /// simulation.run_for(2.0)?;
    /// assert!((simulation.q()[0] - 0.4).abs() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If their number is wrong.
    #[track_caller]
    pub fn set_controls(&mut self, controls: &[f64]) {
        check_length("the controls", controls.len(), self.inputs.controls.len());
        self.inputs.controls.copy_from_slice(controls);
    }

    /// The wrenches on frames in the next steps, instead of those before.
    ///
    /// ```
    /// use multibody::{Model, pendulum, simulator::{AppliedWrench, SimulationBuilder}};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).build()?;
    /// // The weight of the mass at its tip holds the rod level.
    /// let lift = AppliedWrench::force(model.frame_named("tip")?, [0.0, 0.0, 2.0 * 9.81]);
    /// simulation.set_wrenches(&[lift]);
    /// simulation.run_for(0.1)?;
    /// assert!(simulation.q()[0].abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If a frame is another robot's.
    #[track_caller]
    pub fn set_wrenches(&mut self, wrenches: &[AppliedWrench]) {
        for wrench in wrenches {
            self.model.frame_of(wrench.frame);
        }
        self.inputs.wrenches.clear();
        self.inputs.wrenches.extend_from_slice(wrenches);
    }
}
