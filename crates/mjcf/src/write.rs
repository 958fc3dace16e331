//! From a robot to the text of an MJCF file.

mod actuators;
mod beside;
mod bodies;
mod chain;
mod joints;
mod poses;
mod sensors;
mod shapes;

use std::collections::HashMap;
use std::path::Path;

use multibody::{
    EARTH_GRAVITY, JointKind, LeftOut, LinkShape, Model, Pose, RobotDescription, Shape, WriteError,
    WrittenFile,
};
use robot_xml::{Writer, excerpt, is_name};

use crate::names::Names;

/// The largest number that the format's readers take: stands for infinity on the open side of a range.
const ENDLESS: f64 = 1e30;

/// Writes a robot as an MJCF file. `folder` is where the file will lie: meshes are named from there, and those whose files
/// were not found, or are of a kind that MuJoCo does not read, are left out.
///
/// Numbers keep all their digits. A root link named `world` is the world's body; links without mass between joints become
/// several joints of one body, as MuJoCo refuses to move what has no mass. Universal and planar joints become their hinges
/// and slides, followers become equalities of joints, and what the format has no words for is listed in
/// [`WrittenFile::left_out`].
///
/// ```
/// let mut robot = multibody::pendulum(2.0, 0.5);
/// robot.joints[0].limits.velocity = 3.0;
/// let file = mjcf::write(&robot, None)?;
/// assert!(file.lost_physics().count() == 0 && file.left_out[0].message.contains("velocity"));
/// let back = mjcf::parse(&file.text, &mjcf::Options::default())?.description;
/// let rod = back.links.iter().find(|link| link.name == "rod").expect("the rod");
/// assert_eq!(rod.mass_properties, robot.links[1].mass_properties);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`WriteError`] for what is no robot, for helical joints, for floating ones that do not hang on the world, and for names
/// that XML cannot hold.
pub fn write(robot: &RobotDescription, folder: Option<&Path>) -> Result<WrittenFile, WriteError> {
    Model::new(robot.clone())?;
    let mut writing = Writing::new(robot, folder);
    writing.check();
    writing.plan_sites();
    writing.xml.start("mujoco").attribute("model", if is_name(&robot.name) { &robot.name } else { "robot" });
    writing.settings();
    writing.assets();
    writing.bodies();
    writing.contact();
    writing.tendons();
    writing.equalities();
    writing.actuators();
    writing.sensors();
    writing.poses();
    writing.left_out.dedup();
    if writing.unwritable.is_empty() {
        Ok(WrittenFile::new(writing.xml.finish(), writing.left_out))
    } else {
        Err(WriteError::Unwritable(writing.unwritable))
    }
}

struct Writing<'r> {
    robot: &'r RobotDescription,
    folder: Option<&'r Path>,
    xml: Writer,
    left_out: Vec<LeftOut>,
    unwritable: Vec<String>,
    /// Which link has which name, and the joints below each.
    link_index: HashMap<&'r str, usize>,
    below: Vec<Vec<usize>>,
    root: usize,
    /// Names of bodies, of joints and of sites in the file.
    body_names: Vec<String>,
    joint_names: Names,
    site_names: Names,
    /// The sites on each link.
    sites: HashMap<&'r str, Vec<(String, Pose)>>,
    /// Of each connection, the names of its sites; of each link that an actuator acts on, its site.
    connections: HashMap<usize, [String; 2]>,
    link_sites: HashMap<&'r str, String>,
    /// The forms of the sites that are zones of sensors.
    zones: HashMap<String, &'r Shape>,
    /// The shapes on each link, with the name of the mesh or height field of those that have one.
    shapes: HashMap<&'r str, Vec<(&'r LinkShape, Option<String>)>>,
    shape_names: Names,
    /// Whether any shape is there for its looks alone.
    has_looks: bool,
    /// The moving joints as they are written: the robot's index, or `None` for its floating base.
    order: Vec<Option<usize>>,
    /// The robot's actuators that are written.
    written_actuators: Vec<usize>,
}

fn joint_place(name: &str) -> String {
    format!("joint {:?}", excerpt(name))
}

impl<'r> Writing<'r> {
    fn new(robot: &'r RobotDescription, folder: Option<&'r Path>) -> Self {
        let link_index: HashMap<&str, usize> =
            robot.links.iter().enumerate().map(|(index, link)| (link.name.as_str(), index)).collect();
        let mut below = vec![Vec::new(); robot.links.len()];
        let mut is_child = vec![false; robot.links.len()];
        for (index, joint) in robot.joints.iter().enumerate() {
            below[link_index[joint.parent.as_str()]].push(index);
            is_child[link_index[joint.child.as_str()]] = true;
        }
        let root = is_child.iter().position(|is_child| !is_child).unwrap_or(0);
        let (mut joint_names, mut site_names) = (Names::default(), Names::default());
        for joint in &robot.joints {
            joint_names.take(&joint.name);
        }
        for frame in &robot.frames {
            site_names.take(&frame.name);
        }
        Self {
            robot,
            folder,
            xml: Writer::new(),
            left_out: Vec::new(),
            unwritable: Vec::new(),
            link_index,
            below,
            root,
            body_names: robot.links.iter().map(|link| link.name.clone()).collect(),
            joint_names,
            site_names,
            sites: HashMap::new(),
            connections: HashMap::new(),
            link_sites: HashMap::new(),
            zones: HashMap::new(),
            shapes: HashMap::new(),
            shape_names: Names::default(),
            has_looks: false,
            order: Vec::new(),
            written_actuators: Vec::new(),
        }
    }

    fn lost(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(LeftOut::new(place, message, true));
    }

    fn note(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(LeftOut::new(place, message, false));
    }

    /// Refuses names that no file can hold and joints that the format has not.
    fn check(&mut self) {
        let robot = self.robot;
        let named = |sort: &'static str, name: &'r String| (sort, name);
        let names = (robot.links.iter().map(|link| named("link", &link.name)))
            .chain(robot.joints.iter().map(|joint| named("joint", &joint.name)))
            .chain(robot.frames.iter().map(|frame| named("frame", &frame.name)))
            .chain(robot.tendons.iter().map(|tendon| named("tendon", &tendon.name)))
            .chain(robot.equalities.iter().map(|equality| named("equality", &equality.name)))
            .chain(robot.actuators.iter().map(|actuator| named("actuator", &actuator.name)))
            .chain(robot.sensors.iter().map(|sensor| named("sensor", &sensor.name)))
            .chain(robot.poses.iter().map(|pose| named("pose", &pose.name)));
        for (sort, name) in names.filter(|(_, name)| !is_name(name)) {
            self.unwritable.push(format!("the {sort} name {:?} is none in a file: rename it", excerpt(name)));
        }
        for joint in &robot.joints {
            if let JointKind::Helical { .. } = joint.kind {
                self.unwritable
                    .push(format!("{}: the format has no helical joints", joint_place(&joint.name)));
            }
        }
        // The format has a world of its own.
        let mut taken = Names::default();
        for link in &robot.links {
            taken.take(&link.name);
        }
        if let Some(&world) = self.link_index.get("world")
            && !self.root_is_world()
        {
            let name = taken.free("world");
            self.note("link \"world\"", format!("the name is the world's own: written as {name:?}"));
            self.body_names[world] = name;
        }
    }

    fn settings(&mut self) {
        self.xml.start("compiler").attribute("angle", "radian").attribute("autolimits", "true");
        self.xml.attribute("inertiafromgeom", "false").end();
        let RobotDescription { gravity, time_step, impratio, .. } = self.robot;
        let magnetic = self.magnetic_field();
        if *gravity != EARTH_GRAVITY || time_step.is_some() || impratio.is_some() || magnetic.is_some() {
            self.xml.start("option");
            if *gravity != EARTH_GRAVITY {
                self.xml.numbers("gravity", gravity);
            }
            if let Some(step) = time_step {
                self.xml.numbers("timestep", &[*step]);
            }
            if let Some(ratio) = impratio {
                self.xml.numbers("impratio", &[*ratio]);
            }
            if let Some(field) = magnetic {
                self.xml.numbers("magnetic", &field);
            }
            self.xml.end();
        }
    }

    /// A range that limits; none where both sides are open, or where MuJoCo takes it for none.
    fn range(&mut self, place: &str, name: &str, [lower, upper]: [f64; 2]) {
        if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
            return;
        }
        if lower < upper {
            self.xml.numbers(name, &[lower.max(-ENDLESS), upper.min(ENDLESS)]);
        } else {
            self.lost(
                place,
                format!("{name} from {lower} to {upper}: in the format the upper end is the larger"),
            );
        }
    }
}
