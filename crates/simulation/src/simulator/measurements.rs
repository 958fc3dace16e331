//! Measurements at the end of a step: sensors, and the wrenches that joints transmit.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_core::{FrameId, FrameWrench, Model, Workspace, frame_pose, joint_reactions};

use robot_dynamics_core::ReferenceFrame;

use super::{AppliedWrench, Simulation};
use crate::{PointForce, SensorInputs, SensorSet, Stepper};

impl Simulation {
    /// The force and moment that each joint transmits to its child, as a force-torque sensor there measures.
    /// The order is that of [`Model::joints`](robot_dynamics_core::Model::joints), fixed joints included.
    /// Each entry holds the force \[N\] and the moment \[N·m\] along the axes of the child's frame and about
    /// its origin.
    ///
    /// They belong to the state at the end of the last step with its mean
    /// [`acceleration`](Self::acceleration), the contacts of that step and the held wrenches. Forces of
    /// equalities are not included: in a closed loop the joints of the loop show the sum of both sides.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut simulation = SimulationBuilder::new(&Model::new(pendulum(2.0, 0.5))?).build()?;
    /// simulation.set_torques(&[-2.0 * 9.81 * 0.5]); // holds the rod level
    /// simulation.run_for(0.1)?;
    /// let reactions = simulation.joint_reactions();
    /// assert!((reactions[0][2] - 2.0 * 9.81).abs() < 1e-9); // the hinge carries the weight
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn joint_reactions(&self) -> Vec<[f64; 6]> {
        let (model, workspace) = (&*self.model, &mut Workspace::new(&self.model));
        let wrenches: Vec<FrameWrench> = self
            .point_forces(workspace)
            .into_iter()
            .map(|force| in_frame(model, workspace, self.q(), &force))
            .collect();
        let mut numbers = vec![0.0; 6 * model.joints().len()];
        let (q, v, a) = (self.q(), self.v(), self.acceleration());
        joint_reactions(model, workspace, q, v, a, &wrenches, &mut numbers);
        numbers.as_chunks().0.to_vec()
    }

    /// The values of the description's sensors at the end of the last step, by name, in the file's order.
    /// They refer to the same motion and forces as [`joint_reactions`](Self::joint_reactions). Forces of
    /// limits are means over the last step, or over its last part if the step was divided.
    ///
    /// ```
    /// use robot_dynamics::description::{SensorDescription, SensorKind, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.sensors.push(SensorDescription::new("imu", SensorKind::Accelerometer, "tip"));
    /// let mut simulation = SimulationBuilder::new(&Model::new(robot)?).build()?;
    /// simulation.step()?;
    /// let sensors = simulation.sensors();
    /// // In free fall the acceleration of the tip across the rod reads zero.
    /// assert!(sensors[0].0 == "imu" && sensors[0].1[2].abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sensors(&self) -> Vec<(String, Vec<f64>)> {
        let model = &*self.model;
        // The sensors of a compiled description are valid.
        let Ok(set) = SensorSet::new(model) else { return Vec::new() };
        if set.is_empty() {
            return Vec::new();
        }
        let wrenches = self.point_forces(&mut Workspace::new(model));
        let forces = self.stepper.actuator_forces();
        let [joint_limits, tendon_limits] = self.stepper.limit_forces(model);
        let mut inputs = SensorInputs::new(self.q(), self.v(), self.acceleration());
        inputs.time = self.time();
        inputs.wrenches = &wrenches;
        (inputs.joint_limit_forces, inputs.tendon_limit_forces) = (&joint_limits, &tendon_limits);
        if forces.len() == model.description().actuators.len() {
            inputs.actuator_forces = forces;
        }
        let (mut memory, mut values) = (set.memory(model), vec![0.0; set.value_count()]);
        set.evaluate(model, &mut memory, &inputs, &mut values);
        set.names().enumerate().map(|(k, name)| (name.to_owned(), values[set.range(k)].to_vec())).collect()
    }

    /// The external forces on links: contacts (on both links) and wrenches.
    fn point_forces(&self, workspace: &mut Workspace) -> Vec<PointForce> {
        let model = &*self.model;
        let mut forces = Vec::new();
        for contact in self.contacts() {
            let sides = [(Some(contact.link), 1.0), (contact.other_link, -1.0)];
            for (link, sign) in sides {
                let Some(link) = link.and_then(|link| model.frame(link)) else { continue };
                let turned = |vector: [f64; 3]| vector.map(|x| sign * x);
                let force = PointForce::new(link, contact.point, turned(contact.force));
                forces.push(PointForce {
                    moment: turned(contact.moment),
                    normal: turned(contact.normal),
                    ..force
                });
            }
        }
        let q = self.q();
        forces.extend(self.wrenches().iter().map(|wrench| in_world(model, workspace, q, wrench)));
        forces
    }
}

fn placed(
    model: &Model,
    workspace: &mut Workspace,
    q: &[f64],
    frame: FrameId,
) -> (Matrix3<f64>, Vector3<f64>) {
    let pose = frame_pose(model, workspace, q, frame);
    (Matrix3::from_fn(|i, j| pose.rotation[i][j]), pose.translation.into())
}

/// The wrench along the world's axes at its point of application.
fn in_world(model: &Model, workspace: &mut Workspace, q: &[f64], wrench: &AppliedWrench) -> PointForce {
    let (rotation, origin) = placed(model, workspace, q, wrench.frame);
    let (turn, point) = match wrench.axes {
        ReferenceFrame::Local => (rotation, origin),
        ReferenceFrame::World => (Matrix3::identity(), Vector3::zeros()),
        ReferenceFrame::LocalWorldAligned => (Matrix3::identity(), origin),
    };
    let [force, moment] = [wrench.force, wrench.moment].map(|vector| turn * Vector3::from(vector));
    PointForce { moment: moment.into(), ..PointForce::new(wrench.frame, point.into(), force.into()) }
}

/// A force in the world, expressed along the frame's axes and about its origin.
fn in_frame(model: &Model, workspace: &mut Workspace, q: &[f64], given: &PointForce) -> FrameWrench {
    let (rotation, origin) = placed(model, workspace, q, given.link);
    let (force, moment) = (Vector3::from(given.force), Vector3::from(given.moment));
    let about_origin = moment + (Vector3::from(given.point) - origin).cross(&force);
    FrameWrench {
        frame: given.link,
        force_in_frame: rotation.tr_mul(&force).into(),
        moment_in_frame: rotation.tr_mul(&about_origin).into(),
    }
}
