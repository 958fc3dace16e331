//! From a robot to the text of a URDF file.

mod joints;
mod shapes;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use multibody::{
    Base, EARTH_GRAVITY, JointDescription, JointKind, LeftOut, LinkDescription, LinkShape, Model, Pose,
    RobotDescription, WriteError, WrittenFile,
};
use robot_xml::{Writer, excerpt, is_name};

/// Writes a robot as a URDF file. `folder` is where the file will lie: meshes whose files were found are named from there,
/// others, and all without it, as they were.
///
/// Numbers keep all their digits. A floating base becomes a joint of type `floating` from a link without mass; frames
/// become links without mass; linear equalities between joints become `<mimic>`. Armature and springs are written as
/// attributes of `<dynamics>` that [`parse`](crate::parse) reads and other programs do not. What the format has no words
/// for is listed in [`WrittenFile::left_out`].
///
/// ```
/// let mut robot = multibody::pendulum(2.0, 0.5);
/// robot.gravity = [0.0, 0.0, -1.62];
/// let file = urdf::write(&robot, None)?;
/// assert_eq!(file.lost_physics().map(|lost| lost.place.as_str()).collect::<Vec<_>>(), ["gravity"]);
/// let back = urdf::parse(&file.text, &urdf::Options::default())?.description;
/// assert_eq!(back.links[1].mass_properties, robot.links[1].mass_properties);
/// assert_eq!(back.joints[0], robot.joints[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`WriteError`] for what is no robot, for a helical joint, and for names that XML cannot hold.
pub fn write(robot: &RobotDescription, folder: Option<&Path>) -> Result<WrittenFile, WriteError> {
    Model::new(robot.clone())?;
    let mut robot = robot.clone();
    let followers = robot.couplings_to_followers();
    let names = robot.links.iter().map(|link| &link.name).chain(robot.frames.iter().map(|frame| &frame.name));
    let mut writing = Writing {
        links: names.cloned().collect(),
        joints: robot.joints.iter().map(|joint| joint.name.clone()).collect(),
        folder,
        xml: Writer::new(),
        left_out: Vec::new(),
        unwritable: Vec::new(),
        colors: Vec::new(),
    };
    for follower in followers {
        let message = "an equality becomes a <mimic>: M is that of the joints without followers";
        writing.note(&joint_place(&follower), message);
    }
    writing.free_base(&mut robot);
    writing.frames_to_links(&mut robot);
    writing.universal_to_revolute(&mut robot);
    writing.check(&robot);
    writing.robot(&robot);
    writing.beside(&robot);
    if writing.unwritable.is_empty() {
        Ok(WrittenFile::new(writing.xml.finish(), writing.left_out))
    } else {
        Err(WriteError::Unwritable(writing.unwritable))
    }
}

struct Writing<'f> {
    /// Names that are taken.
    links: HashSet<String>,
    joints: HashSet<String>,
    folder: Option<&'f Path>,
    xml: Writer,
    left_out: Vec<LeftOut>,
    unwritable: Vec<String>,
    /// Those written so far, each a material.
    colors: Vec<[f64; 4]>,
}

fn joint_place(name: &str) -> String {
    format!("joint {:?}", excerpt(name))
}

/// This name, or the first free one of `name_2`, `name_3` and so on.
fn free(taken: &mut HashSet<String>, name: &str) -> String {
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    let mut names = core::iter::once(name.to_owned()).chain(numbered);
    names.find(|name| taken.insert(name.clone())).unwrap_or_default()
}

impl Writing<'_> {
    fn lost(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(LeftOut::new(place, message, true));
    }

    fn note(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(LeftOut::new(place, message, false));
    }

    /// The format's files leave it to their readers whether the base floats: here a joint says it.
    fn free_base(&mut self, robot: &mut RobotDescription) {
        if robot.base == Base::Fixed {
            return;
        }
        let children: HashSet<&str> = robot.joints.iter().map(|joint| joint.child.as_str()).collect();
        let root = robot.links.iter().find(|link| !children.contains(link.name.as_str()));
        let Some(root) = root.map(|root| root.name.clone()) else { return };
        let (world, joint) =
            (free(&mut self.links, "world"), free(&mut self.joints, &robot.floating_base_name()));
        let message =
            format!("the base floats: written as a floating joint from a link {world:?} without mass");
        self.note("base", message);
        robot.links.insert(0, LinkDescription::new(&world, None));
        robot
            .joints
            .insert(0, JointDescription::new(joint, JointKind::Floating, world, root, Pose::IDENTITY));
        robot.base = Base::Fixed;
    }

    fn frames_to_links(&mut self, robot: &mut RobotDescription) {
        for frame in core::mem::take(&mut robot.frames) {
            let joint = free(&mut self.joints, &format!("{}_fixed", frame.name));
            robot.links.push(LinkDescription::new(&frame.name, None));
            let joint =
                JointDescription::new(joint, JointKind::Fixed, frame.link, frame.name, frame.link_from_frame);
            robot.joints.push(joint);
        }
    }

    /// Two turns in series, with a link without mass between them.
    fn universal_to_revolute(&mut self, robot: &mut RobotDescription) {
        let mut joints = Vec::with_capacity(robot.joints.len());
        for joint in core::mem::take(&mut robot.joints) {
            let JointKind::Universal { first, second } = joint.kind else {
                joints.push(joint);
                continue;
            };
            let between = free(&mut self.links, &format!("{}_between", joint.name));
            let names = [1, 2].map(|number| free(&mut self.joints, &format!("{}_{number}", joint.name)));
            let message =
                format!("a universal joint becomes the two joints {:?} and {:?}", names[0], names[1]);
            self.note(&joint_place(&joint.name), message);
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

    fn check(&mut self, robot: &RobotDescription) {
        let names = robot
            .links
            .iter()
            .map(|link| ("link", &link.name))
            .chain(robot.joints.iter().map(|joint| ("joint", &joint.name)));
        for (sort, name) in names.filter(|(_, name)| !is_name(name)) {
            self.unwritable.push(format!("the {sort} name {:?} is none in a file: rename it", excerpt(name)));
        }
    }

    fn robot(&mut self, robot: &RobotDescription) {
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
                self.shape(shape);
            }
            self.xml.end();
        }
        for joint in &robot.joints {
            self.joint(joint);
        }
    }

    /// What stands beside the tree, of which the format has nothing.
    fn beside(&mut self, robot: &RobotDescription) {
        if robot.gravity != EARTH_GRAVITY {
            let message = format!(
                "{:?} m/s²: the format has no gravity, and its readers take {EARTH_GRAVITY:?}",
                robot.gravity
            );
            self.lost("gravity", message);
        }
        for link in robot.links.iter().filter(|link| link.gravity_compensation != 0.0) {
            let message =
                format!("{} of its weight is carried: the format cannot say it", link.gravity_compensation);
            self.lost(&format!("link {:?}", excerpt(&link.name)), message);
        }
        let none = "the format has none";
        for tendon in &robot.tendons {
            self.lost(
                &format!("tendon {:?}", excerpt(&tendon.name)),
                format!("a tendon over joints: {none}"),
            );
        }
        for equality in &robot.equalities {
            let message = format!("an equality that is no linear one of two joints: {none}");
            self.lost(&format!("equality {:?}", excerpt(&equality.name)), message);
        }
        for actuator in &robot.actuators {
            self.lost(&format!("actuator {:?}", excerpt(&actuator.name)), format!("an actuator: {none}"));
        }
        for sensor in &robot.sensors {
            self.note(&format!("sensor {:?}", excerpt(&sensor.name)), format!("a sensor: {none}"));
        }
        for pose in &robot.poses {
            self.note(&format!("pose {:?}", excerpt(&pose.name)), format!("a named pose: {none}"));
        }
        if let Some(step) = robot.time_step {
            self.note("time step", format!("{step} s: {none}"));
        }
        if let Some(ratio) = robot.impratio {
            self.note("impratio", format!("{ratio}: {none}"));
        }
        if !robot.contact_exclusions.is_empty() {
            let message =
                format!("{} pairs of links that never touch: {none}", robot.contact_exclusions.len());
            self.note("contact", message);
        }
        if !robot.contact_pairs.is_empty() {
            let message =
                format!("{} pairs of shapes that touch in any case: {none}", robot.contact_pairs.len());
            self.note("contact", message);
        }
    }
}
