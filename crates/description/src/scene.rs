//! A scene: robots and objects joined to one robot.
//!
//! Each part keeps its links, joints, shapes, actuators and sensors, with a prefix on every name. The result
//! is an ordinary [`RobotDescription`] with the root link `world`, for every algorithm and file format.

mod attach;
mod mount;
mod object;
mod prefix;

pub use self::mount::Mount;
pub use self::object::Object;

use self::mount::WORLD;
use crate::{JointKind, LinkDescription, ModelError, RobotDescription};

/// Robots and objects in one world.
///
/// ```
/// use robot_dynamics::description::{Mount, Object, Pose, Scene, Shape, pendulum};
/// use robot_dynamics::model::Model;
/// let mut scene = Scene::new("two pendulums and a ball");
/// scene.add(&pendulum(2.0, 0.5), &Mount::at(Pose::from_translation([0.0, 0.0, 1.0])).with_prefix("left_"))?;
/// scene.add(&pendulum(1.0, 0.5), &Mount::on("left_tip").with_prefix("right_"))?;
/// let ball = Object::of_mass("ball", Shape::Sphere { radius: 0.1 }, 0.4);
/// scene.add_object(&ball, Pose::from_translation([1.0, 0.0, 2.0]))?;
/// let model = Model::new(scene.into_description())?;
/// assert_eq!((model.nv(), model.mass()), (1 + 1 + 6, 3.4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    description: RobotDescription,
    notes: Vec<String>,
}

impl Scene {
    /// An empty world in Earth's gravity.
    pub fn new(name: impl Into<String>) -> Self {
        let mut description = RobotDescription::new(name);
        description.links.push(LinkDescription::new(WORLD, None));
        Self { description, notes: Vec::new() }
    }

    /// With this gravitational acceleration in the world \[m/s²\].
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Self {
        self.description.gravity = gravity;
        self
    }

    /// Adds a robot.
    ///
    /// Gravity is that of the scene. The step, `impratio` and the fluid are those of the first robot that
    /// states them.
    /// [`notes`](Self::notes) lists the robots that state other ones. Named poses keep the robot's own
    /// controls; the controls of other robots are 0 in them.
    ///
    /// A root link named `world`, as robots from MJCF files have, becomes the scene's `world` if the robot
    /// is fixed there with an identity pose and has no prefix. Otherwise its name gets the prefix, or the
    /// robot's name if the prefix is empty.
    ///
    /// # Errors
    /// [`ModelError`]: the parent is unknown, a name is already in the scene, or the robot does not have
    /// exactly one root. The scene is then unchanged.
    pub fn add(&mut self, robot: &RobotDescription, mount: &Mount) -> Result<(), ModelError> {
        let notes = self.description.attach(robot, mount)?;
        self.notes.extend(notes.iter().map(ToString::to_string));
        Ok(())
    }

    /// Adds an object at a pose in the world or by a [`Mount`], with this name for its link and shape. A free
    /// object has a floating joint `NAME_joint`, whose q is its pose relative to `world_from_object`. An
    /// object on a link or frame is fixed there, unless the mount has a joint.
    ///
    /// ```
    /// use robot_dynamics::description::{JointKind, Mount, Object, Pose, Scene, Shape};
    /// let mut scene = Scene::new("door");
    /// scene.add_object(&Object::ground(), Pose::IDENTITY)?;
    /// let leaf = Object::of_mass("leaf", Shape::Box { size: [0.8, 0.04, 2.0] }, 20.0);
    /// let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    /// scene.add_object(&leaf, Mount::at(Pose::from_translation([0.0, 0.0, 1.0])).with_joint(hinge))?;
    /// assert_eq!(scene.description().joints[1].kind, hinge);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`ModelError`]: the name is already in the scene, the mass is not positive and finite, or the shape of
    /// an object with mass has no volume, such as a plane, and no mass properties. The scene is then
    /// unchanged.
    pub fn add_object(&mut self, object: &Object, mount: impl Into<Mount>) -> Result<(), ModelError> {
        let mount = mount.into();
        let is_free = object.has_mass() && mount.parent == WORLD;
        let default = if is_free { JointKind::Floating } else { JointKind::Fixed };
        let kind = mount.joint.unwrap_or(default);
        self.add(&object.description()?, &mount.with_joint(kind))
    }

    /// The scene as one robot, so far.
    pub fn description(&self) -> &RobotDescription {
        &self.description
    }

    /// The scene as one robot.
    pub fn into_description(self) -> RobotDescription {
        self.description
    }

    /// Statements of robots that the scene does not take: other gravity, another step.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}
