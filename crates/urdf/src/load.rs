//! Loads a robot from a URDF file.

use std::collections::HashMap;
use std::path::Path;

use robot_dynamics_description::{Disposition, LinkDescription, RobotDescription};
use robot_dynamics_xml::excerpt;
use robot_dynamics_xml::roxmltree::Node;

use crate::drake::is_drake;
use crate::element::Element;
use crate::reader::Reader;
use crate::robot::Robot;
use crate::sdf::{FilesInMemory, read_sdf};
use crate::shapes::Appearance;
use crate::tree::{SourceLines, Tree};
use crate::unread_parts::UnknownPart;
use crate::xacro::refuse_unexpanded;
use crate::{LoadError, LoadOptions, UrdfError, mass_check, mesh_file, mimic_leaders, world};

/// The deepest nesting of elements. A URDF file has five levels: `robot/link/visual/geometry/mesh`.
const DEPTH_LIMIT: usize = 200;

/// Reads a URDF file. Mesh files are located, and not opened.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
/// let robot = robot_dynamics_urdf::load(file, &robot_dynamics_urdf::LoadOptions::default())?;
/// assert_eq!(robot.description.name, "panda");
/// assert_eq!(robot.report.counts.ignored_physics, 0); // no physics was ignored
/// let model = robot_dynamics::model::Model::new(robot.description)?;
/// assert_eq!((model.nq(), model.nv()), (7, 7)); // the arm without its hand
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all errors, each with its line and advice.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Robot, LoadError> {
    let path = path.as_ref();
    parse_as(&robot_dynamics_xml::read_file(path).map_err(UrdfError::from)?, path, options)
}

/// Reads a text as the content of the file at `path`, which is not opened. A robot without a name takes that
/// of the file, and relative mesh names start from the folder of `path`.
///
/// ```
/// # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
/// let text = std::fs::read_to_string(file)?;
/// let robot = robot_dynamics_urdf::parse_as(&text, file, &robot_dynamics_urdf::LoadOptions::default())?;
/// assert_eq!(robot, robot_dynamics_urdf::load(file, &robot_dynamics_urdf::LoadOptions::default())?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn parse_as(text: &str, path: impl AsRef<Path>, options: &LoadOptions) -> Result<Robot, LoadError> {
    read_text(text, options.clone(), Some(path.as_ref()), None)
}

/// Reads the text of a URDF file. Meshes of packages are located if the options have a package path.
///
/// ```
/// let text = r#"<robot name="pendulum">
///   <link name="ceiling"/>
///   <link name="bob"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/></inertial></link>
///   <joint name="hinge" type="revolt"><parent link="ceiling"/><child link="bob"/></joint>
/// </robot>"#;
/// let refused = robot_dynamics_urdf::parse(text, &robot_dynamics_urdf::LoadOptions::default()).unwrap_err();
/// assert!(refused.to_string().contains("revolt"));
/// assert_eq!(refused.errors()[0].line(), Some(4));
/// let robot = robot_dynamics_urdf::parse(&text.replace("revolt", "continuous"), &robot_dynamics_urdf::LoadOptions::default())?;
/// assert_eq!(robot.description.links[1].mass_properties.map(|rod| rod.mass()), Some(2.0));
/// # Ok::<(), robot_dynamics_urdf::LoadError>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all errors, each with its line and advice.
pub fn parse(text: &str, options: &LoadOptions) -> Result<Robot, LoadError> {
    read_text(text, options.clone(), None, None)
}

/// Reads a text as the content of the file at `path`, with files in memory, which SDF may include. `files`
/// gives the content of a file at a path.
///
/// ```
/// use robot_dynamics_urdf::{LoadOptions, parse_with_files};
/// let text = "<sdf version='1.9'><model name='cart'><include><uri>wheel.sdf</uri></include></model></sdf>";
/// let wheel = "<sdf version='1.9'><model name='wheel'><link name='rim'/></model></sdf>";
/// let files = |path: &std::path::Path| path.ends_with("wheel.sdf").then(|| wheel.as_bytes().to_vec());
/// let robot = parse_with_files(text, "cart.sdf", &files, &LoadOptions::default())?;
/// assert_eq!(robot.description.links[1].name, "wheel::rim");
/// # Ok::<(), robot_dynamics_urdf::LoadError>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn parse_with_files(
    text: &str,
    path: impl AsRef<Path>,
    files: &dyn Fn(&Path) -> Option<Vec<u8>>,
    options: &LoadOptions,
) -> Result<Robot, LoadError> {
    read_text(text, options.clone(), Some(path.as_ref()), Some(files))
}

fn read_text(
    text: &str,
    options: LoadOptions,
    path: Option<&Path>,
    files: Option<&FilesInMemory<'_>>,
) -> Result<Robot, LoadError> {
    robot_dynamics_xml::parse(text, DEPTH_LIMIT, |document, faults| {
        let root = document.root_element();
        let mut reader = Reader::new(document.input_text(), root, options);
        let line = reader.line(root);
        let found = root.tag_name().name();
        if found == "sdf" {
            for (line, message) in faults {
                reader.push(*line, "sdf".into(), Disposition::AsWritten, message.clone());
            }
            return read_sdf(reader, &Element { node: root, line, place: "sdf".to_owned() }, path, files);
        }
        // URDF names no file that is opened.
        let path = path.filter(|_| files.is_none());
        if found != "robot" {
            let advice = match found {
                "world" | "model" => "an SDF file has it inside <sdf version=\"1.9\">",
                "mujoco" => "this is MJCF; read it with `mjcf::load`",
                _ => "a URDF file has one <robot name=\"…\"> element",
            };
            return Err(UrdfError::NotARobot { line, found: excerpt(found), advice }.into());
        }
        if is_srdf(&reader, root) {
            let advice =
                "it adds groups and poses to a URDF file; load that file, with this one as its `srdf`";
            return Err(UrdfError::OtherFormat { format: "SRDF", advice }.into());
        }
        refuse_unexpanded(&reader, root, path)?;
        for (line, message) in faults {
            reader.push(*line, "robot".into(), Disposition::AsWritten, message.clone());
        }
        read_robot(reader, &Element { node: root, line, place: "robot".to_owned() }, path)
    })
    .map_err(UrdfError::from)?
}

/// Whether a `<robot>` has elements of SRDF and no link.
fn is_srdf<'a>(reader: &Reader<'a>, root: Node<'a, 'a>) -> bool {
    let words =
        ["group", "group_state", "end_effector", "virtual_joint", "passive_joint", "disable_collisions"];
    let has = |name| root.children().any(|child| reader.is(child, name));
    !has("link") && words.into_iter().any(has)
}

fn read_robot<'a>(
    mut reader: Reader<'a>,
    element: &Element<'a>,
    path: Option<&Path>,
) -> Result<Robot, LoadError> {
    let is_joint = |node: Node<'_, '_>| is_drake(node, "joint") && node.has_attribute("type");
    reader.understood.extend(element.node.children().filter(|&node| is_joint(node)).map(|node| node.id()));
    let reflected = reader.reflected_inertias(element);
    reader.list_unread(element, &["name", "version"], &["link", "joint"], UnknownPart::Harmless);
    let name = path.and_then(Path::file_stem).map(|name| name.to_string_lossy());
    let mut robot = RobotDescription::new(robot_name(&mut reader, element, name.as_deref()));
    let mut lines = SourceLines { robot: element.line, links: Vec::new(), joints: Vec::new() };
    let mut inertials = Vec::new();
    for node in element.node.children() {
        if reader.is(node, "link") {
            let link = reader.named_element(node, "link");
            lines.links.push(link.line);
            let name = reader.required_name(&link, "name", "<link name=\"NAME\">");
            reader.list_unread(&link, &["name"], &["inertial"], UnknownPart::Harmless);
            inertials.push(reader.inertial(&link));
            robot.links.push(LinkDescription::new(name, None));
        } else if reader.is(node, "joint") || is_joint(node) {
            let joint = reader.named_element(node, "joint");
            lines.joints.push(joint.line);
            robot.joints.push(reader.joint(&joint));
        }
    }
    reader.add_reflected_inertias(&mut robot, &reflected);
    world::add_missing_world(&mut reader, &mut robot, &mut lines);
    let extents = extents(&robot);
    for ((link, inertial), extent) in robot.links.iter_mut().zip(&inertials).zip(extents) {
        link.mass_properties =
            inertial.as_ref().and_then(|inertial| reader.mass_properties(inertial, extent));
    }
    let mut tree = Tree::of(&robot, &lines, &mut reader.errors);
    if let Some(forest) = tree.take_if(|tree| tree.roots.len() > 1) {
        world::fix_roots(&mut reader, &mut robot, &mut lines, &forest.roots);
        tree = Tree::of(&robot, &lines, &mut reader.errors);
    }
    let leaders = mimic_leaders::find_leaders(&robot, &lines, &mut reader.errors);
    if let Some(tree) = tree
        && reader.errors.is_empty()
    {
        if reader.options.floating_base {
            world::add_floating_base(&mut reader, &mut robot, element);
        }
        mass_check::check(&robot, &tree, &leaders, &lines, &mut reader);
    }

    let Appearance { mut shapes, angles } = reader.appearance(element);
    if path.is_some() || !reader.options.package_path.is_empty() {
        mesh_file::locate_meshes(&mut reader, element, &mut shapes, path);
    }
    robot.shapes = shapes;

    Robot::finish(reader, robot, angles, path)
}

/// The name of the robot, or that of the file.
fn robot_name<'a>(reader: &mut Reader<'a>, element: &Element<'a>, file: Option<&str>) -> String {
    if let Some(name) = element.text("name").filter(|name| !name.trim().is_empty()) {
        return name.to_owned();
    }
    let name = file.unwrap_or("robot");
    let origin = if file.is_some() { ", the name of the file" } else { "" };
    let message = format!("no name: taken as {:?}{origin}; write <robot name=\"NAME\">", excerpt(name));
    reader.warn(element, message);
    name.to_owned()
}

/// For each link the largest `<origin>` distance among its joints \[m\].
fn extents(robot: &RobotDescription) -> Vec<f64> {
    let index: HashMap<&str, usize> =
        robot.links.iter().enumerate().map(|(at, link)| (link.name.as_str(), at)).collect();
    let mut extents = vec![0.0_f64; robot.links.len()];
    for joint in &robot.joints {
        let distance = joint.parent_from_joint.translation.iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
        for end in [&joint.parent, &joint.child] {
            if let Some(&link) = index.get(end.as_str()) {
                extents[link] = extents[link].max(distance);
            }
        }
    }
    extents
}
