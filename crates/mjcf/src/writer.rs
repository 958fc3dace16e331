//! Writes a robot as the text of an MJCF file.

mod actuators;
mod bodies;
mod chain;
mod constraints;
mod controllers;
mod fluid;
mod joints;
mod poses;
mod sensors;
mod shapes;
mod spatial_tendons;

use core::cell::OnceCell;
use std::collections::HashMap;
use std::path::Path;

use robot_dynamics_core::Model;
use robot_dynamics_description::{
    EARTH_GRAVITY, FluidEllipsoid, FluidForm, JointKind, LinkShape, Medium, ModelError, Pose,
    RobotDescription, Shape, TendonSurface, UnsupportedFeature, WrittenFile,
};
use robot_dynamics_xml::{Writer, excerpt, is_name};

use crate::names::Names;

/// The largest number that readers of MJCF accept, written for infinity on the open side of a range.
const LARGEST_BOUND: f64 = 1e30;

/// Writes a robot as an MJCF file. `folder` is the folder of the new file: the names of meshes are relative
/// to it. Meshes whose files were not found, or that MuJoCo cannot read, are omitted.
///
/// Numbers keep all their digits. A root link named `world` becomes the world body. MuJoCo refuses to move
/// links without mass, so such links between joints become several joints of one body. Universal and planar
/// joints become hinges and slides, and mimic joints become equalities. Features that MJCF lacks are listed
/// in [`WrittenFile::left_out`].
///
/// ```
/// let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
/// robot.joints[0].limits.velocity = 3.0;
/// let file = robot_dynamics_mjcf::write(&robot, None)?;
/// assert!(file.lost_physics().count() == 0 && file.left_out[0].message.contains("velocity"));
/// let back = robot_dynamics_mjcf::parse(&file.text, &robot_dynamics_mjcf::LoadOptions::default())?.description;
/// let rod = back.links.iter().find(|link| link.name == "rod").expect("the rod");
/// assert_eq!(rod.mass_properties, robot.links[1].mass_properties);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ModelError`] for an invalid robot, for helical joints, for floating joints whose parent is not the
/// world, and for names that XML cannot represent.
pub fn write(robot: &RobotDescription, folder: Option<&Path>) -> Result<WrittenFile, ModelError> {
    Model::new(robot.clone())?;
    let mut writer = MjcfWriter::new(robot, folder);
    writer.check_names();
    writer.plan_sites();
    writer.plan_tendons();
    writer.xml.start("mujoco").attribute("model", if is_name(&robot.name) { &robot.name } else { "robot" });
    writer.write_settings();
    writer.write_assets();
    writer.write_bodies();
    writer.write_contact();
    writer.write_tendons();
    writer.write_equalities();
    writer.write_actuators();
    writer.write_sensors();
    writer.write_poses();
    writer.note_groups();
    writer.left_out.dedup();
    if writer.unwritable.is_empty() {
        Ok(WrittenFile::new(writer.xml.finish(), writer.left_out))
    } else {
        Err(ModelError::Unwritable(writer.unwritable))
    }
}

/// A geom that exists only for a tendon.
struct TendonGeom {
    name: String,
    surface: TendonSurface,
    radius: f64,
    link_from_surface: Pose,
}

struct MjcfWriter<'r> {
    robot: &'r RobotDescription,
    folder: Option<&'r Path>,
    xml: Writer,
    left_out: Vec<UnsupportedFeature>,
    unwritable: Vec<String>,
    /// The index of each link by name, and its child joints.
    link_index: HashMap<&'r str, usize>,
    below: Vec<Vec<usize>>,
    root: usize,
    /// The names of bodies, joints and sites in the file.
    body_names: Vec<String>,
    joint_names: Names,
    site_names: Names,
    /// The sites on each link.
    sites: HashMap<&'r str, Vec<(String, Pose)>>,
    /// The names of the two sites of each connection, and of the site of each link that an actuator acts on.
    connections: HashMap<usize, [String; 2]>,
    link_sites: HashMap<&'r str, String>,
    /// The geoms of each link that exist only for tendons, and the names of the geoms on each path.
    tendon_geoms: HashMap<&'r str, Vec<TendonGeom>>,
    tendon_geom_names: Vec<Vec<String>>,
    /// The lengths of spatial tendons in the pose of the file.
    path_lengths: OnceCell<Vec<f64>>,
    /// The shapes of the sites that are zones of sensors.
    zones: HashMap<String, &'r Shape>,
    /// The shapes of each link, with the name of their mesh or height field.
    shapes: HashMap<&'r str, Vec<(&'r LinkShape, Option<String>)>>,
    shape_names: Names,
    /// The ellipsoids in a fluid that are not written yet.
    ellipsoids: HashMap<&'r str, Vec<(Pose, FluidEllipsoid)>>,
    /// Whether there are visual shapes.
    has_looks: bool,
    /// The moving joints in the order of the file: index in the robot, or `None` for its floating base.
    order: Vec<Option<usize>>,
    /// The indices of the actuators in the file.
    written_actuators: Vec<usize>,
}

fn joint_place(name: &str) -> String {
    format!("joint {:?}", excerpt(name))
}

impl<'r> MjcfWriter<'r> {
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
            joint_names.reserve(&joint.name);
        }
        for frame in &robot.frames {
            site_names.reserve(&frame.name);
        }
        let mut ellipsoids: HashMap<_, Vec<_>> = HashMap::new();
        for shape in &robot.fluid_shapes {
            if let FluidForm::Ellipsoid(own) = shape.form {
                ellipsoids.entry(shape.link.as_str()).or_default().push((shape.link_from_shape, own));
            }
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
            tendon_geoms: HashMap::new(),
            tendon_geom_names: Vec::new(),
            path_lengths: OnceCell::new(),
            zones: HashMap::new(),
            shapes: HashMap::new(),
            shape_names: Names::default(),
            ellipsoids,
            has_looks: false,
            order: Vec::new(),
            written_actuators: Vec::new(),
        }
    }

    fn add_loss(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(UnsupportedFeature::new(place, message, true));
    }

    fn add_note(&mut self, place: &str, message: impl Into<String>) {
        self.left_out.push(UnsupportedFeature::new(place, message, false));
    }

    /// Refuses names that XML cannot represent, and joint types that MJCF lacks.
    fn check_names(&mut self) {
        let robot = self.robot;
        let named = |kind: &'static str, name: &'r String| (kind, name);
        let names = (robot.links.iter().map(|link| named("link", &link.name)))
            .chain(robot.joints.iter().map(|joint| named("joint", &joint.name)))
            .chain(robot.frames.iter().map(|frame| named("frame", &frame.name)))
            .chain(robot.tendons.iter().map(|tendon| named("tendon", &tendon.name)))
            .chain(robot.spatial_tendons.iter().map(|tendon| named("tendon", &tendon.name)))
            .chain(robot.equalities.iter().map(|equality| named("equality", &equality.name)))
            .chain(robot.actuators.iter().map(|actuator| named("actuator", &actuator.name)))
            .chain(robot.sensors.iter().map(|sensor| named("sensor", &sensor.name)))
            .chain(robot.poses.iter().map(|pose| named("pose", &pose.name)));
        for (kind, name) in names.filter(|(_, name)| !is_name(name)) {
            self.unwritable
                .push(format!("the {kind} name {:?} is invalid in a file: rename it", excerpt(name)));
        }
        for joint in &robot.joints {
            if let JointKind::Helical { .. } = joint.kind {
                self.unwritable.push(format!("{}: MJCF has no helical joints", joint_place(&joint.name)));
            }
        }
        // The name `world` is reserved in MJCF.
        let mut taken = Names::default();
        for link in &robot.links {
            taken.reserve(&link.name);
        }
        if let Some(&world) = self.link_index.get("world")
            && !self.root_is_world()
        {
            let name = taken.unique("world");
            self.add_note(
                "link \"world\"",
                format!("the name is reserved for the world: written as {name:?}"),
            );
            self.body_names[world] = name;
        }
    }

    fn note_groups(&mut self) {
        let robot = self.robot;
        let groups = robot.groups.iter().map(|group| format!("group {:?}", excerpt(&group.name)));
        let tools = robot.end_effectors.iter().map(|tool| format!("end effector {:?}", excerpt(&tool.name)));
        for place in groups.chain(tools) {
            self.add_note(&place, "it belongs to SRDF; MJCF has none");
        }
    }

    fn write_settings(&mut self) {
        self.xml.start("compiler").attribute("angle", "radian").attribute("autolimits", "true");
        self.xml.attribute("inertiafromgeom", "false").end();
        let RobotDescription { gravity, time_step, impratio, medium, .. } = self.robot;
        let magnetic = self.magnetic_field();
        let has_physics = *gravity != EARTH_GRAVITY || *medium != Medium::default() || magnetic.is_some();
        if has_physics || time_step.is_some() || impratio.is_some() {
            self.xml.start("option");
            if *gravity != EARTH_GRAVITY {
                self.xml.numbers("gravity", gravity);
            }
            self.write_medium();
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

    /// Writes a range. It is omitted if both sides are infinite, or if it is empty, which MuJoCo reads as no
    /// limit.
    fn write_range(&mut self, place: &str, name: &str, [lower, upper]: [f64; 2]) {
        if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
            return;
        }
        if lower < upper {
            self.xml.numbers(name, &[lower.max(-LARGEST_BOUND), upper.min(LARGEST_BOUND)]);
        } else {
            self.add_loss(
                place,
                format!("{name} from {lower} to {upper}: MJCF requires an upper end above the lower end"),
            );
        }
    }
}
