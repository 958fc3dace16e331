//! A scene: robots and objects joined to one robot.
//!
//! Each part keeps its links, joints, shapes, actuators and sensors, with a prefix on every name. The result
//! is an ordinary [`RobotDescription`] with the root link `world`, for every algorithm and file format.

mod mount;
mod object;
mod prefix;

pub use self::mount::Mount;
pub use self::object::Object;

use std::collections::HashSet;

use self::mount::WORLD;
use self::prefix::Renaming;
use crate::{Base, JointDescription, JointKind, LinkDescription, ModelError, Pose, RobotDescription};

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
    /// Gravity is that of the scene. The step and `impratio` are those of the first robot that states them.
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
        let (parent, parent_from_frame) = self.parent(mount)?;
        let root = root_of(robot)?.to_owned();
        let kind = mount.joint.unwrap_or(match robot.base {
            Base::Fixed => JointKind::Fixed,
            Base::Floating => JointKind::Floating,
        });
        let pose = parent_from_frame.compose(&mount.parent_from_robot);
        let shares_world = root == WORLD
            && parent == WORLD
            && kind == JointKind::Fixed
            && mount.prefix.is_empty()
            && pose == Pose::IDENTITY
            && robot.links.iter().all(|link| link.name != root || link.mass_properties.is_none());
        let new_root = match (root.as_str(), mount.prefix.as_str()) {
            (WORLD, "") if shares_world => WORLD.to_owned(),
            (WORLD, "") => format!("{}_{WORLD}", robot.name),
            (root, prefix) => format!("{prefix}{root}"),
        };
        let mut part = robot.clone();
        let base_joint = robot.floating_base_name();
        Renaming { prefix: &mount.prefix, root: (&root, &new_root) }.apply(&mut part);
        let base_joint = format!("{}{base_joint}", mount.prefix);
        part.base = Base::Fixed;
        if shares_world {
            part.links.retain(|link| link.name != new_root);
        } else {
            let name = if kind == JointKind::Floating && robot.base == Base::Floating && mount.joint.is_none()
            {
                self.free_joint_name(&base_joint, &new_root)
            } else {
                format!("{new_root}_joint")
            };
            rename_base(&mut part, &base_joint, (kind == JointKind::Floating).then_some(name.as_str()));
            part.joints.insert(0, JointDescription::new(name, kind, parent, new_root, pose));
        }
        self.check_names(&part)?;
        self.note_differences(robot);
        self.merge(part, robot.actuated_joints.is_some());
        Ok(())
    }

    /// Adds an object at a pose in the world, with this name for its link and shape. A free object has a
    /// floating joint `NAME_joint`, whose q is its pose relative to `world_from_object`.
    ///
    /// # Errors
    /// [`ModelError`]: the name is already in the scene, the mass is not positive and finite, or the shape of
    /// a free object has no volume, such as a plane. The scene is then unchanged.
    pub fn add_object(&mut self, object: &Object, world_from_object: Pose) -> Result<(), ModelError> {
        let kind = if object.mass.is_some() { JointKind::Floating } else { JointKind::Fixed };
        self.add(&object.description()?, &Mount::at(world_from_object).with_joint(kind))
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

    /// The link of a mount's parent, with `link_from_parent`.
    fn parent(&self, mount: &Mount) -> Result<(String, Pose), ModelError> {
        let RobotDescription { links, frames, .. } = &self.description;
        if links.iter().any(|link| link.name == mount.parent) {
            return Ok((mount.parent.clone(), Pose::IDENTITY));
        }
        let frame = frames.iter().find(|frame| frame.name == mount.parent);
        let frame = frame.ok_or_else(|| ModelError::UnknownName {
            user: "a mount".into(),
            sort: "link or frame",
            name: mount.parent.clone(),
        })?;
        Ok((frame.link.clone(), frame.link_from_frame))
    }

    /// The name of a floating base in the scene: its own, or one by the root link if that is taken.
    fn free_joint_name(&self, base_joint: &str, root: &str) -> String {
        let is_taken = self.description.joints.iter().any(|joint| joint.name == base_joint);
        if is_taken { format!("{root}_joint") } else { base_joint.to_owned() }
    }

    fn check_names(&self, part: &RobotDescription) -> Result<(), ModelError> {
        for ((sort, own), (_, added)) in names(&self.description).into_iter().zip(names(part)) {
            let own: HashSet<&str> = own.into_iter().collect();
            if let Some(name) = added.into_iter().find(|name| !name.is_empty() && own.contains(name)) {
                return Err(ModelError::NameInScene { sort, name: name.to_owned() });
            }
        }
        Ok(())
    }

    fn note_differences(&mut self, robot: &RobotDescription) {
        let own = &self.description;
        if robot.gravity != own.gravity {
            let note = format!(
                "robot `{}` states gravity {:?} m/s²; the scene keeps {:?} m/s²",
                robot.name, robot.gravity, own.gravity
            );
            self.notes.push(note);
        }
        for (quantity, own, stated) in
            [("a time step of", own.time_step, robot.time_step), ("impratio", own.impratio, robot.impratio)]
        {
            if let (Some(own), Some(stated)) = (own, stated)
                && own != stated
            {
                self.notes.push(format!(
                    "robot `{}` states {quantity} {stated}; the scene keeps {own}",
                    robot.name
                ));
            }
        }
    }

    fn merge(&mut self, part: RobotDescription, states_actuated: bool) {
        let own = &mut self.description;
        // `None` means every joint except floating ones.
        if own.actuated_joints.is_some() || states_actuated {
            let motorized = |robot: &RobotDescription| {
                let moves = |joint: &&JointDescription| {
                    joint.kind.nv() > 0 && joint.kind != JointKind::Floating && joint.mimic.is_none()
                };
                let all = || robot.joints.iter().filter(moves).map(|joint| joint.name.clone()).collect();
                robot.actuated_joints.clone().unwrap_or_else(all)
            };
            own.actuated_joints = Some([motorized(own), motorized(&part)].concat());
        }
        let (own_controls, part_controls) = (own.actuators.len(), part.actuators.len());
        for pose in own.poses.iter_mut().filter(|pose| !pose.controls.is_empty()) {
            pose.controls.resize(own_controls + part_controls, 0.0);
        }
        let mut poses = part.poses;
        for pose in poses.iter_mut().filter(|pose| !pose.controls.is_empty()) {
            pose.controls.splice(0..0, core::iter::repeat_n(0.0, own_controls));
        }
        own.time_step = own.time_step.or(part.time_step);
        own.impratio = own.impratio.or(part.impratio);
        own.links.extend(part.links);
        own.joints.extend(part.joints);
        own.frames.extend(part.frames);
        own.shapes.extend(part.shapes);
        own.contact_exclusions.extend(part.contact_exclusions);
        own.contact_pairs.extend(part.contact_pairs);
        own.tendons.extend(part.tendons);
        own.equalities.extend(part.equalities);
        own.actuators.extend(part.actuators);
        own.sensors.extend(part.sensors);
        own.poses.extend(poses);
    }
}

/// The link that is not the child of a joint.
fn root_of(robot: &RobotDescription) -> Result<&str, ModelError> {
    let roots: Vec<&str> = robot.roots().map(|link| link.name.as_str()).collect();
    match roots[..] {
        [root] => Ok(root),
        [] if robot.links.is_empty() => Err(ModelError::NoLinks),
        [] => Err(ModelError::Cycle { links: robot.links.iter().map(|link| link.name.clone()).collect() }),
        _ => Err(ModelError::SeveralRoots { links: roots.into_iter().map(str::to_owned).collect() }),
    }
}

/// Replaces the name of the floating base in poses and in the list of actuated joints, or removes it there.
fn rename_base(part: &mut RobotDescription, base_joint: &str, new: Option<&str>) {
    if part.joints.iter().any(|joint| joint.name == base_joint) {
        return;
    }
    for pose in &mut part.poses {
        for values in [&mut pose.positions, &mut pose.velocities] {
            match new {
                Some(new) => values
                    .iter_mut()
                    .filter(|(joint, _)| joint == base_joint)
                    .for_each(|(joint, _)| new.clone_into(joint)),
                None => values.retain(|(joint, _)| joint != base_joint),
            }
        }
    }
    if let Some(joints) = &mut part.actuated_joints {
        match new {
            Some(new) => {
                joints
                    .iter_mut()
                    .filter(|joint| *joint == base_joint)
                    .for_each(|joint| new.clone_into(joint));
            }
            None => joints.retain(|joint| joint != base_joint),
        }
    }
}

/// The names of each sort that a scene keeps apart.
fn names(robot: &RobotDescription) -> [(&'static str, Vec<&str>); 7] {
    fn of<T>(items: &[T], name: impl Fn(&T) -> &str) -> Vec<&str> {
        items.iter().map(name).collect()
    }
    let places = [of(&robot.links, |link| &link.name), of(&robot.frames, |frame| &frame.name)];
    [
        ("link or frame", places.concat()),
        ("joint", of(&robot.joints, |joint| &joint.name)),
        ("tendon", of(&robot.tendons, |tendon| &tendon.name)),
        ("equality", of(&robot.equalities, |equality| &equality.name)),
        ("actuator", of(&robot.actuators, |actuator| &actuator.name)),
        ("sensor", of(&robot.sensors, |sensor| &sensor.name)),
        ("pose", of(&robot.poses, |pose| &pose.name)),
    ]
}
