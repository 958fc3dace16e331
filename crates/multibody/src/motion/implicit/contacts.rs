//! Implicit steps on the ground.

use super::Implicit;
use crate::contact::ContactImpulses;
use crate::{ContactPoint, ContactProblem, ContactSet, Model, Touch};

impl Implicit {
    /// With the ground: contacts that neither sink nor creep, with Coulomb's friction.
    ///
    /// ```
    /// use multibody::{ContactSet, Ground, Implicit, LinkShape, Model, Pose, Shape, ShapeRole, Simulation, ZeroTorque};
    /// use multibody::{Base, LinkDescription, RobotDescription};
    /// use dynamics::MassProperties;
    /// use std::ops::ControlFlow;
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let ground = ContactSet::new(&model, &[Ground::level(0.0)])?;
    /// let simulation = Simulation::new(&model, Implicit::new(&model).with_contacts(&model, ground), 1e-3);
    /// // Dropped from 20 cm, turning.
    /// let (q, v) = ([0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0], [0.3, 0.0, 0.0, 1.0, 2.0, 0.0]);
    /// let run = simulation.run(&q, &v, 2000, &mut ZeroTorque, |_| ControlFlow::Continue(()))?;
    /// assert!((run.q[2] - 0.05).abs() < 1e-9 && run.v.iter().all(|v| v.abs() < 1e-9)); // it lies on its face
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If the set is another robot's.
    #[track_caller]
    pub fn with_contacts(mut self, model: &Model, contacts: ContactSet) -> Self {
        let mut contacts = ContactImpulses::new(model, contacts);
        contacts.watch(&self.interrupt);
        self.kept.contacts = Some(contacts.memory().anew());
        self.contacts = Some(contacts);
        self
    }

    /// The contacts at the end of the last step, with their forces.
    pub(crate) fn contact_points(&self) -> impl Iterator<Item = ContactPoint<'_>> {
        self.contacts.iter().flat_map(ContactImpulses::contact_points)
    }

    /// The links that can touch a ground.
    pub(crate) fn ground_links(&self) -> &[String] {
        self.contacts.as_ref().map_or(&[], ContactImpulses::ground_links)
    }

    /// Where the last step left the robot in contact, with the forces there.
    pub fn touches(&self) -> impl Iterator<Item = Touch> + '_ {
        self.contacts.iter().flat_map(ContactImpulses::touches_at)
    }

    /// The last step's contacts as one complementarity problem, with the answer that was taken: for comparison with other methods.
    /// `None` where nothing touched; of a step that was divided, its last part.
    ///
    /// ```
    /// use multibody::{Base, ContactSet, Ground, Implicit, LinkDescription, LinkShape, Model, Pose, RobotDescription, Shape};
    /// use multibody::{ShapeRole, StepForces, StepWorkspace, Stepper, admm};
    /// let mut robot = RobotDescription::new("brick");
    /// robot.base = Base::Floating;
    /// let brick = dynamics::MassProperties::solid_box(1000.0, nalgebra::Vector3::new(0.3, 0.2, 0.1))?;
    /// robot.links.push(LinkDescription::new("brick", brick));
    /// let shape = Shape::Box { size: [0.3, 0.2, 0.1] };
    /// robot.shapes.push(LinkShape::new("brick", ShapeRole::Collision, Pose::IDENTITY, shape));
    /// let model = Model::new(robot)?;
    /// let ground = ContactSet::new(&model, &[Ground::level(0.0)])?;
    /// let mut implicit = Implicit::new(&model).with_contacts(&model, ground);
    /// // It lies flat and slides along y.
    /// let (mut q, mut v) = ([0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], [0.0, 0.5, 0.0, 0.0, 0.0, 0.0]);
    /// let none = StepForces::new(&[0.0; 6], true);
    /// implicit.step(&model, &mut StepWorkspace::new(&model), &none, 1e-3, &mut q, &mut v)?;
    /// let problem = implicit.contact_problem().unwrap();
    /// let other = admm::solve(&problem, &admm::Options::default());
    /// assert!((problem.velocity - other.velocity).amax() < 1e-9); // two methods, one motion
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contact_problem(&self) -> Option<ContactProblem> {
        self.contacts.as_ref()?.last_problem()
    }
}
