//! Results of the last step, beside the state.

use dynamics::EnergyLedger;

use super::Simulation;
use crate::motion::simulate::Losses;
use crate::{ConstraintRecord, ContactLaws, ContactPoint, ContactProblem, Run, Stepper};

impl Simulation {
    /// The mean acceleration of the last step, (v₁ − v₀)/h, zero before the first \[rad/s² or m/s²\]; of adaptive steps that at the end.
    pub fn acceleration(&self) -> &[f64] {
        self.mean_acceleration()
    }

    /// The torques that acted in the last step, within their limits \[N·m or N\].
    pub fn applied_torques(&self) -> &[f64] {
        self.limited_torques()
    }

    /// The force of each actuator before its gear, the mean over the last step \[N·m or N\]; empty where actuators do not act.
    pub fn actuator_forces(&self) -> &[f64] {
        self.stepper.actuator_forces()
    }

    /// The generalised forces of all actuators together, the mean over the last step, nv entries \[N·m or N\]; empty where actuators do not act.
    pub fn actuator_torques(&self) -> &[f64] {
        self.stepper.actuator_torques()
    }

    /// The number of steps in which each coordinate's requested torque was cut off at its effort limit.
    ///
    /// ```
    /// use multibody::{Limits, Model, pendulum, simulator::SimulationBuilder};
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

    /// The record of the last run, with the state now.
    pub fn record(&self) -> &Run {
        &self.run
    }

    /// The energy account since the last reset.
    pub fn ledger(&self) -> &EnergyLedger {
        &self.run.ledger
    }

    /// The energy that was taken out, by cause, where the method tells the causes apart.
    pub fn losses(&self) -> Option<Losses> {
        self.run.losses
    }

    /// How well the laws of rigid contact were kept since the last reset, where the method solves for them.
    pub fn contact_laws(&self) -> Option<ContactLaws> {
        self.run.contact_laws
    }

    /// The contacts at the end of the last step, with their forces: under rigid contact those of its last part. A step with an impact is divided, so that they
    /// lack the impulse of the impact; [`ground_forces`](Self::ground_forces) is the mean over the whole step.
    ///
    /// ```
    /// use multibody::{Base, Ground, LinkDescription, LinkShape, Model, Pose, RobotDescription, Shape, ShapeRole};
    /// use multibody::simulator::SimulationBuilder;
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = dynamics::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let mut simulation = SimulationBuilder::new(&model).ground(Ground::level(0.0)).build()?;
    /// simulation.reset(&[0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], &[0.0; 6])?;
    /// simulation.run_for(0.5)?;
    /// let up: f64 = simulation.contacts().iter().map(|contact| contact.force[2]).sum();
    /// assert!((up - 6.0 * 9.81).abs() < 1e-6); // the corners carry the weight
    /// let [x, y, _] = simulation.center_of_pressure().expect("it stands");
    /// assert!(x.abs() < 1e-6 && y.abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contacts(&self) -> Vec<ContactPoint<'_>> {
        self.stepper.contacts()
    }

    /// The last step's contacts as one complementarity problem: [`SimulationStepper::contact_problem`](super::SimulationStepper::contact_problem).
    pub fn contact_problem(&self) -> Option<ContactProblem> {
        self.stepper.contact_problem()
    }

    /// The force of the ground on each link that can touch it, along the world's axes, the mean over the last step \[N\].
    pub fn ground_forces(&self) -> &[[f64; 3]] {
        self.stepper.contact_forces()
    }

    /// The links that can touch a ground, in the order of [`ground_forces`](Self::ground_forces).
    pub fn ground_links(&self) -> &[String] {
        self.stepper.ground_links()
    }

    /// The record of the equalities since the last reset, where an explicit or variational row holds them.
    pub fn constraint_record(&self) -> Option<&ConstraintRecord> {
        self.stepper.constraint_record()
    }

    /// The point about which the normal forces of all contacts with grounds have no moment, their mean weighted by the forces; `None` where nothing presses on a
    /// ground \[m\].
    pub fn center_of_pressure(&self) -> Option<[f64; 3]> {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for contact in self.contacts().iter().filter(|contact| contact.ground.is_some()) {
            let normal: f64 = contact.force.iter().zip(&contact.normal).map(|(f, n)| f * n).sum();
            total += normal;
            (0..3).for_each(|k| sum[k] += normal * contact.point[k]);
        }
        (total > 0.0).then(|| sum.map(|sum| sum / total))
    }

    /// The multiplier of each row of the equalities by its name, the mean over the last step \[N, or N·m of a turn\], where the method has them: the force of row k is
    /// Aₖᵀλₖ. If rows depend on each other, as those of the corners of a sole, they share their forces: λ has the least norm.
    ///
    /// ```
    /// use multibody::{Base, Closure, ConstraintSet, LinkDescription, Model, RobotDescription};
    /// use multibody::simulator::{Method, SimulationBuilder};
    /// // A bead of 2 kg on a floating base, held at the world's origin: the hold carries its weight.
    /// let mut robot = RobotDescription::new("bead");
    /// robot.base = Base::Floating;
    /// let ball = dynamics::MassProperties::new(2.0, nalgebra::Vector3::zeros(), nalgebra::Matrix3::identity());
    /// robot.links.push(LinkDescription::new("bead", ball.ok()));
    /// let model = Model::new(robot)?;
    /// let hold = Closure::point_contact(model.frame_named("bead")?, [0.0; 3]);
    /// let set = ConstraintSet::new(&model, [("hold", hold.into())])?;
    /// let mut simulation = SimulationBuilder::new(&model).method(Method::Implicit).constraints(set).build()?;
    /// simulation.step()?;
    /// let (name, force) = simulation.constraint_forces()[2];
    /// assert!(name == "hold.z" && (force - 2.0 * 9.81).abs() < 1e-8); // a row yields by 1e-10 in the first step
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn constraint_forces(&self) -> Vec<(&str, f64)> {
        self.stepper.constraint_forces()
    }
}
