//! Results of the last step in addition to the state.

use robot_dynamics_integrators::EnergyAccount;

use super::Simulation;
use crate::motion::simulate::Losses;
use crate::{ConstraintRecord, ContactLaws, ContactPoint, ContactProblem, Run, Stepper};

impl Simulation {
    /// The mean acceleration of the last step, (v₁ − v₀)/h \[rad/s² or m/s²\]; zero before the first step.
    /// Adaptive steps give the acceleration at the end of the step.
    pub fn acceleration(&self) -> &[f64] {
        self.mean_acceleration()
    }

    /// The torques of the last step after effort limits \[N·m or N\].
    pub fn applied_torques(&self) -> &[f64] {
        self.limited_torques()
    }

    /// The force of each actuator before its gear, as the mean over the last step \[N·m or N\]; empty if
    /// actuators do not act.
    pub fn actuator_forces(&self) -> &[f64] {
        self.stepper.actuator_forces()
    }

    /// The generalized force of all actuators together, as the mean over the last step, nv entries \[N·m or
    /// N\]; empty if actuators do not act.
    pub fn actuator_torques(&self) -> &[f64] {
        self.stepper.actuator_torques()
    }

    /// The number of steps in which the effort limit clipped the requested torque, for each coordinate.
    ///
    /// ```
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::default().with_effort(3.0);
    /// let mut simulation = SimulationBuilder::new(&Model::new(robot)?).build()?;
    /// simulation.set_torques(&[-10.0]);
    /// simulation.run_for(0.01)?;
    /// assert_eq!((simulation.applied_torques(), simulation.steps_at_effort_limits()), (&[-3.0][..], &[10][..]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn steps_at_effort_limits(&self) -> &[usize] {
        &self.limited
    }

    /// The record of the last run, with the current state.
    pub fn record(&self) -> &Run {
        &self.run
    }

    /// The energy account since the last reset.
    pub fn energy_account(&self) -> &EnergyAccount {
        &self.run.energy_account
    }

    /// The energy that was dissipated, by cause; `None` if the method does not separate the causes.
    pub fn losses(&self) -> Option<Losses> {
        self.run.losses
    }

    /// The accuracy of the solutions of rigid contact since the last reset; `None` if the method does not
    /// solve for them.
    pub fn contact_laws(&self) -> Option<ContactLaws> {
        self.run.contact_laws
    }

    /// The contacts at the end of the last step, with their forces; under rigid contact, the forces of its
    /// last part. A step with an impact is divided, and these forces do not include the impulse of the
    /// impact. [`ground_forces`](Self::ground_forces) is the mean over the whole step.
    ///
    /// ```
    /// use robot_dynamics::contact::Ground;
    /// use robot_dynamics::description::{Base, LinkDescription, LinkShape, Pose, RobotDescription};
    /// use robot_dynamics::description::{Shape, ShapeRole};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = robot_dynamics::description::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let mut simulation = SimulationBuilder::new(&model).ground(Ground::level(0.0)).build()?;
    /// simulation.reset(&[0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], &[0.0; 6])?;
    /// simulation.run_for(0.5)?;
    /// let up: f64 = simulation.contacts().iter().map(|contact| contact.force[2]).sum();
    /// assert!((up - 6.0 * 9.81).abs() < 1e-6); // the contacts at the corners carry the weight
    /// let [x, y, _] = simulation.center_of_pressure().expect("it stands");
    /// assert!(x.abs() < 1e-6 && y.abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contacts(&self) -> Vec<ContactPoint<'_>> {
        self.stepper.contacts()
    }

    /// The contacts of the last step as one complementarity problem; see
    /// [`SimulationStepper::contact_problem`](super::SimulationStepper::contact_problem).
    pub fn contact_problem(&self) -> Option<ContactProblem> {
        self.stepper.contact_problem()
    }

    /// The force of the ground on each link that can touch it, along the world's axes, as the mean over the
    /// last step \[N\].
    pub fn ground_forces(&self) -> &[[f64; 3]] {
        self.stepper.contact_forces()
    }

    /// The links that can touch a ground, in the order of [`ground_forces`](Self::ground_forces).
    pub fn ground_links(&self) -> &[String] {
        self.stepper.ground_links()
    }

    /// The record of the equalities since the last reset; `None` unless an explicit or variational row holds
    /// them.
    pub fn constraint_record(&self) -> Option<&ConstraintRecord> {
        self.stepper.constraint_record()
    }

    /// The center of pressure \[m\]: the point about which the mean normal forces of all contacts with
    /// grounds have no moment. Several grounds are averaged with their forces as weights. `None` if no force
    /// presses on a ground.
    pub fn center_of_pressure(&self) -> Option<[f64; 3]> {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for contact in self.contacts().iter().filter(|contact| contact.ground.is_some()) {
            let normal: f64 = contact.force.iter().zip(&contact.normal).map(|(f, n)| f * n).sum();
            total += normal;
            (0..3).for_each(|k| sum[k] += normal * contact.point[k]);
        }
        (total > 0.0).then(|| sum.map(|sum| sum / total))
    }

    /// The multiplier of each row of the equalities by name, as the mean over the last step \[N, or N·m for a
    /// rotation\]. Empty if the method does not compute them. Row k exerts the force Aₖᵀλₖ. Dependent rows,
    /// as those of the corners of a foot, share their force: λ has the least norm.
    ///
    /// ```
    /// use robot_dynamics::constraints::{FrameConstraint, ConstraintSet};
    /// use robot_dynamics::description::{Base, LinkDescription, RobotDescription};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Method, SimulationBuilder};
    /// // A weld holds a bead of 2 kg on a floating base at the world's origin: its force equals the weight.
    /// let mut robot = RobotDescription::new("bead");
    /// robot.base = Base::Floating;
    /// let ball = robot_dynamics::description::MassProperties::new(2.0, nalgebra::Vector3::zeros(), nalgebra::Matrix3::identity());
    /// robot.links.push(LinkDescription::new("bead", ball.ok()));
    /// let model = Model::new(robot)?;
    /// let hold = FrameConstraint::point_contact(model.frame_named("bead")?, [0.0; 3]);
    /// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
    /// let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).constraints(set).build()?;
    /// simulation.step()?;
    /// let (name, force) = simulation.constraint_forces()[2];
    /// assert!(name == "hold.z" && (force - 2.0 * 9.81).abs() < 1e-8); // the row's error after the first step is 1e-10
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn constraint_forces(&self) -> Vec<(&str, f64)> {
        self.stepper.constraint_forces()
    }
}
