//! External inputs of the next steps.

use robot_dynamics_description::check_length;

use super::{AppliedWrench, Simulation};

impl Simulation {
    /// Sets the torques of the next steps, nv entries \[N·m or N\].
    ///
    /// # Panics
    /// Panics if the number of torques is not nv.
    #[track_caller]
    pub fn set_torques(&mut self, torques: &[f64]) {
        check_length("the torques", torques.len(), self.inputs.torques.len());
        self.inputs.torques.copy_from_slice(torques);
    }

    /// Sets the controls of the actuators for the next steps, in the order of
    /// [`control_names`](Self::control_names).
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Method, SimulationBuilder};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(1e6, 1e5);
    /// robot.actuators.push(servo);
    /// let mut simulation = SimulationBuilder::new(&Model::new(robot)?).dt(1e-2).build()?;
    /// assert_eq!(simulation.method(), Method::Implicit); // explicit steps of 10 ms diverge with these gains
    /// simulation.set_controls(&[0.4]);
    /// simulation.run_for(2.0)?;
    /// assert!((simulation.q()[0] - 0.4).abs() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if the number of controls is wrong.
    #[track_caller]
    pub fn set_controls(&mut self, controls: &[f64]) {
        check_length("the controls", controls.len(), self.inputs.controls.len());
        self.inputs.controls.copy_from_slice(controls);
    }

    /// Sets the wrenches on frames for the next steps; replaces earlier ones.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{AppliedWrench, SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let mut simulation = SimulationBuilder::new(&model).build()?;
    /// // A force equal to the weight of the tip mass holds the rod level.
    /// let lift = AppliedWrench::force(model.frame_named("tip")?, [0.0, 0.0, 2.0 * 9.81]);
    /// simulation.set_wrenches(&[lift]);
    /// simulation.run_for(0.1)?;
    /// assert!(simulation.q()[0].abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if a frame belongs to another model.
    #[track_caller]
    pub fn set_wrenches(&mut self, wrenches: &[AppliedWrench]) {
        for wrench in wrenches {
            self.model.frame_of(wrench.frame);
        }
        self.inputs.wrenches.clear();
        self.inputs.wrenches.extend_from_slice(wrenches);
    }
}
