//! Writes a robot as the text of a URDF file.

mod joints;
mod shapes;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use robot_dynamics_core::Model;
use robot_dynamics_description::{
    Base, EARTH_GRAVITY, JointDescription, JointKind, LinkDescription, LinkShape, ModelError, Pose,
    RobotDescription, UnsupportedFeature, WrittenFile,
};
use robot_dynamics_xml::{Writer, excerpt, is_name};

/// Writes a robot as a URDF file. `folder` is the folder of the new file: the names of meshes that were
/// located are relative to it. Other names, and all names without a folder, stay as they are.
///
/// Numbers keep all their digits. A floating base becomes a joint of type `floating` from a link without
/// mass. Frames become links without mass, and linear equalities between joints become `<mimic>`. Armature
/// and springs are written as attributes of `<dynamics>` that [`parse`](crate::parse) reads and other
/// programs ignore. Features that URDF lacks are listed in [`WrittenFile::left_out`].
///
/// ```
/// let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
/// robot.gravity = [0.0, 0.0, -1.62];
/// let file = robot_dynamics_urdf::write(&robot, None)?;
/// assert_eq!(file.lost_physics().map(|lost| lost.place.as_str()).collect::<Vec<_>>(), ["gravity"]);
/// let back = robot_dynamics_urdf::parse(&file.text, &robot_dynamics_urdf::LoadOptions::default())?.description;
/// assert_eq!(back.links[1].mass_properties, robot.links[1].mass_properties);
/// assert_eq!(back.joints[0], robot.joints[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ModelError`] for an invalid robot, for a helical joint, and for names that XML cannot represent.
pub fn write(robot: &RobotDescription, folder: Option<&Path>) -> Result<WrittenFile, ModelError> {
    Model::new(robot.clone())?;
    let mut robot = robot.clone();
    let mimic_joints = robot.couplings_to_followers();
    let names = robot.links.iter().map(|link| &link.name).chain(robot.frames.iter().map(|frame| &frame.name));
    let mut writer = UrdfWriter {
        links: names.cloned().collect(),
        joints: robot.joints.iter().map(|joint| joint.name.clone()).collect(),
        folder,
        xml: Writer::new(),
        left_out: Vec::new(),
        unwritable: Vec::new(),
        colors: Vec::new(),
    };
    for joint in mimic_joints {
        let message = "an equality becomes a <mimic>: M refers to the independent joints";
        writer.add_note(&joint_place(&joint), message);
    }
    writer.base_to_joint(&mut robot);
    writer.frames_to_links(&mut robot);
    writer.universal_to_revolute(&mut robot);
    writer.check_names(&robot);
    writer.write_robot(&robot);
    writer.list_unsupported(&robot);
    if writer.unwritable.is_empty() {
        Ok(WrittenFile::new(writer.xml.finish(), writer.left_out))
    } else {
        Err(ModelError::Unwritable(writer.unwritable))
    }
}

struct UrdfWriter<'f> {
    /// Names in use.
    links: HashSet<String>,
    joints: HashSet<String>,
    folder: Option<&'f Path>,
    xml: Writer,
    left_out: Vec<UnsupportedFeature>,
    unwritable: Vec<String>,
    /// The colours so far; each is a material.
    colors: Vec<[f64; 4]>,
}

fn joint_place(name: &str) -> String {
    format!("joint {:?}", excerpt(name))
}

/// This name, or the first unused one of `name_2`, `name_3` and so on.
fn unique_name(used: &mut HashSet<String>, name: &str) -> String {
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    let mut names = core::iter::once(name.to_owned()).chain(numbered);
    names.find(|name| used.insert(name.clone())).unwrap_or_default()
}

impl UrdfWriter<'_> {
    fn add_loss(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(UnsupportedFeature::new(place, message, true));
    }

    fn add_note(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(UnsupportedFeature::new(place, message, false));
    }

    /// Writes a floating base as a joint, because URDF leaves the choice of the base to its reader.
    fn base_to_joint(&mut self, robot: &mut RobotDescription) {
        if robot.base == Base::Fixed {
            return;
        }
        let children: HashSet<&str> = robot.joints.iter().map(|joint| joint.child.as_str()).collect();
        let root = robot.links.iter().find(|link| !children.contains(link.name.as_str()));
        let Some(root) = root.map(|root| root.name.clone()) else { return };
        let (world, joint) = (
            unique_name(&mut self.links, "world"),
            unique_name(&mut self.joints, &robot.floating_base_name()),
        );
        let message =
            format!("the base floats: written as a floating joint from a link {world:?} without mass");
        self.add_note("base", message);
        robot.links.insert(0, LinkDescription::new(&world, None));
        robot
            .joints
            .insert(0, JointDescription::new(joint, JointKind::Floating, world, root, Pose::IDENTITY));
        robot.base = Base::Fixed;
    }

    fn frames_to_links(&mut self, robot: &mut RobotDescription) {
        for frame in core::mem::take(&mut robot.frames) {
            let joint = unique_name(&mut self.joints, &format!("{}_fixed", frame.name));
            robot.links.push(LinkDescription::new(&frame.name, None));
            let joint =
                JointDescription::new(joint, JointKind::Fixed, frame.link, frame.name, frame.link_from_frame);
            robot.joints.push(joint);
        }
    }

    /// Replaces universal joints by two revolute joints with a link without mass between them.
    fn universal_to_revolute(&mut self, robot: &mut RobotDescription) {
        let mut joints = Vec::with_capacity(robot.joints.len());
        for joint in core::mem::take(&mut robot.joints) {
            let JointKind::Universal { first, second } = joint.kind else {
                joints.push(joint);
                continue;
            };
            let between = unique_name(&mut self.links, &format!("{}_between", joint.name));
            let names =
                [1, 2].map(|number| unique_name(&mut self.joints, &format!("{}_{number}", joint.name)));
            let message =
                format!("a universal joint becomes the two joints {:?} and {:?}", names[0], names[1]);
            self.add_note(&joint_place(&joint.name), message);
            robot.links.push(LinkDescription::new(&between, None));
            let (mut one, mut two) = (joint.clone(), joint);
            [one.name, two.name] = names;
            (one.kind, two.kind) =
                (JointKind::Revolute { axis: first }, JointKind::Revolute { axis: second });
            one.child.clone_from(&between);
            two.parent = between;
            two.parent_from_joint = Pose::IDENTITY;
            joints.extend([one, two]);
        }
        robot.joints = joints;
    }

    fn check_names(&mut self, robot: &RobotDescription) {
        let names = robot
            .links
            .iter()
            .map(|link| ("link", &link.name))
            .chain(robot.joints.iter().map(|joint| ("joint", &joint.name)));
        for (sort, name) in names.filter(|(_, name)| !is_name(name)) {
            self.unwritable
                .push(format!("the {sort} name {:?} is invalid in a file: rename it", excerpt(name)));
        }
    }

    fn write_robot(&mut self, robot: &RobotDescription) {
        let name = if is_name(&robot.name) { &robot.name } else { "robot" };
        self.xml.start("robot").attribute("name", name);
        let mut shapes = HashMap::<&str, Vec<&LinkShape>>::new();
        for shape in &robot.shapes {
            shapes.entry(&shape.link).or_default().push(shape);
        }
        for link in &robot.links {
            self.xml.start("link").attribute("name", &link.name);
            if let Some(body) = &link.mass_properties {
                let (center, i) = (body.center_of_mass(), body.inertia_about_center_of_mass());
                self.xml.start("inertial");
                self.xml.start("origin").numbers("xyz", center.as_slice()).end();
                self.xml.start("mass").numbers("value", &[body.mass()]).end();
                self.xml.start("inertia");
                for (name, row, column) in
                    [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)]
                {
                    self.xml.numbers(name, &[i[(row, column)]]);
                }
                self.xml.end().end();
            }
            for shape in shapes.remove(link.name.as_str()).unwrap_or_default() {
                self.write_shape(shape);
            }
            self.xml.end();
        }
        for joint in &robot.joints {
            self.write_joint(joint);
        }
    }

    /// Lists the features of the robot that URDF lacks.
    fn list_unsupported(&mut self, robot: &RobotDescription) {
        if robot.gravity != EARTH_GRAVITY {
            let message = format!(
                "{:?} m/s²: URDF has no gravity, and its readers assume {EARTH_GRAVITY:?}",
                robot.gravity
            );
            self.add_loss("gravity", message);
        }
        for link in robot.links.iter().filter(|link| link.gravity_compensation != 0.0) {
            let message = format!(
                "gravity compensation of {} of its weight: not supported by URDF",
                link.gravity_compensation
            );
            self.add_loss(&format!("link {:?}", excerpt(&link.name)), message);
        }
        let none = "not supported by URDF";
        if robot.medium.acts() {
            self.add_loss("fluid", format!("the forces of a fluid: {none}"));
        }
        for tendon in &robot.tendons {
            self.add_loss(
                &format!("tendon {:?}", excerpt(&tendon.name)),
                format!("a tendon over joints: {none}"),
            );
        }
        for tendon in &robot.spatial_tendons {
            self.add_loss(
                &format!("tendon {:?}", excerpt(&tendon.name)),
                format!("a tendon along a path: {none}"),
            );
        }
        for equality in &robot.equalities {
            let message = format!("an equality that is not linear between two joints: {none}");
            self.add_loss(&format!("equality {:?}", excerpt(&equality.name)), message);
        }
        for actuator in &robot.actuators {
            self.add_loss(&format!("actuator {:?}", excerpt(&actuator.name)), format!("an actuator: {none}"));
        }
        for sensor in &robot.sensors {
            self.add_note(&format!("sensor {:?}", excerpt(&sensor.name)), format!("a sensor: {none}"));
        }
        for pose in &robot.poses {
            self.add_note(&format!("pose {:?}", excerpt(&pose.name)), format!("a named pose: {none}"));
        }
        for group in &robot.groups {
            let message = format!("a group of links and joints, which belongs to SRDF: {none}");
            self.add_note(&format!("group {:?}", excerpt(&group.name)), message);
        }
        for tool in &robot.end_effectors {
            let message = format!("an end effector, which belongs to SRDF: {none}");
            self.add_note(&format!("end effector {:?}", excerpt(&tool.name)), message);
        }
        if let Some(step) = robot.time_step {
            self.add_note("time step", format!("{step} s: {none}"));
        }
        if let Some(ratio) = robot.impratio {
            self.add_note("impratio", format!("{ratio}: {none}"));
        }
        if !robot.contact_exclusions.is_empty() {
            let message = format!("{} excluded pairs of links: {none}", robot.contact_exclusions.len());
            self.add_note("contact", message);
        }
        if !robot.contact_pairs.is_empty() {
            let message = format!("{} explicit contact pairs of shapes: {none}", robot.contact_pairs.len());
            self.add_note("contact", message);
        }
    }
}
