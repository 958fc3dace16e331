//! Reads SDF models.
//!
//! 1. `model`, `link`, `joint`, `geometry` and `include` read elements and included files into `parts`.
//! 2. `poses` resolves the frames.
//! 3. `assembly` makes a tree of links and joints, whose root is the link `world`; `closure` adds the loops.

mod assembly;
mod closure;
mod geometry;
mod graph;
mod include;
mod joint;
mod link;
mod model;
mod parts;
mod poses;
mod values;

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use robot_dynamics_description::{LinkDescription, Pose, RobotDescription};
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Budget, Resource, excerpt};

use self::assembly::Assembly;
use self::model::Overrides;
use self::parts::{Attachment, Frame, Parts, Place, Scope, Target, WORLD};
use crate::element::Element;
use crate::mesh_file::{Search, note_missing_meshes};
use crate::reader::Reader;
use crate::robot::Robot;
use crate::tree::Tree;
use crate::unread_parts::UnknownPart;
use crate::{LoadError, UrdfError, mass_check, mimic_leaders, world};

pub(crate) use self::parts::FilesInMemory;

/// The gravity of a world that states none \[m/s²\].
const WORLD_GRAVITY: [f64; 3] = [0.0, 0.0, -9.8];

/// Reads the model of an SDF file.
pub(crate) fn read_sdf<'a>(
    mut reader: Reader<'a>,
    root: &Element<'a>,
    path: Option<&Path>,
    in_memory: Option<&FilesInMemory<'_>>,
) -> Result<Robot, LoadError> {
    let search = Search::from(path.filter(|_| in_memory.is_none()), &reader.options);
    let locates = in_memory.is_none() && (path.is_some() || !reader.options.package_path.is_empty());
    let world_frame = Frame {
        at: Place::default(),
        relative_to: Target::Id(WORLD),
        pose: Pose::IDENTITY,
        placement: None,
        attached_to: Attachment::World,
    };
    let mut parts = Parts {
        frames: vec![world_frame],
        names: HashMap::new(),
        links: Vec::new(),
        joints: Vec::new(),
        named_frames: Vec::new(),
        budget: Budget::default(),
        includes: 0,
        files: Vec::new(),
        gravity: None,
        file: String::new(),
        version: (1, 12),
        search,
        locates,
        in_memory,
        memory_path: path.map(Path::to_owned).unwrap_or_default(),
        missing_meshes: BTreeSet::new(),
    };
    let count = root.node.descendants().filter(Node::is_element).count();
    parts.charge(&mut reader, root, Resource::Elements, count);
    parts.read_version(&mut reader, root);
    let name = main_model(&mut parts, &mut reader, root);
    if parts.budget.is_exceeded() || name.is_none() {
        // The other findings would describe an incomplete robot.
        reader.errors.append(&mut reader.refused_warnings);
        return Err(LoadError::new(reader.errors, UrdfError::sorted_at, reader.report));
    }
    let name = name.filter(|name| !name.is_empty()).unwrap_or_else(|| "robot".to_owned());
    let mut robot = RobotDescription::new(&name);
    match parts.resolve() {
        Ok(resolved) if reader.errors.is_empty() => {
            let mut assembly = Assembly::new(&parts, &resolved, &name, root.line);
            for edge in assembly.run(&mut reader) {
                assembly.close_loop(&mut reader, &edge);
            }
            let lines = assembly.lines;
            robot = assembly.robot;
            check(&mut reader, &mut robot, &lines, root);
        }
        Ok(_) => {}
        Err(errors) => reader.errors.extend(errors),
    }
    if robot.links.is_empty() {
        robot.links.push(LinkDescription::new("world", None));
    }
    note_missing_meshes(&mut reader, root, &parts.missing_meshes, &parts.search);

    let main = path.filter(|_| in_memory.is_none());
    let files = main.into_iter().chain(parts.files.iter().map(PathBuf::as_path));
    Robot::finish(reader, robot, Vec::new(), files)
}

/// Checks the tree, the mimic joints and the masses.
fn check<'a>(
    reader: &mut Reader<'a>,
    robot: &mut RobotDescription,
    lines: &crate::tree::SourceLines,
    root: &Element<'a>,
) {
    let tree = Tree::of(robot, lines, &mut reader.errors);
    let leaders = mimic_leaders::find_leaders(robot, lines, &mut reader.errors);
    if let Some(tree) = tree
        && reader.errors.is_empty()
    {
        if reader.options.floating_base {
            world::add_floating_base(reader, robot, root);
        }
        mass_check::check(robot, &tree, &leaders, lines, reader);
    }
}

/// Reads the one model of a file, or of its world. Returns its name; `None` after an error.
fn main_model<'a>(parts: &mut Parts<'_>, reader: &mut Reader<'a>, root: &Element<'a>) -> Option<String> {
    let scope =
        Scope { prefix: String::new(), model: WORLD, is_static: false, self_collides: false, depth: 0 };
    reader.list_unread(root, &["version"], &["model", "world"], UnknownPart::Harmless);
    let children = |reader: &Reader<'a>, parent: Node<'a, 'a>, name: &str| -> Vec<Node<'a, 'a>> {
        parent.children().filter(|&child| reader.is(child, name)).collect()
    };
    let worlds = children(reader, root.node, "world");
    let mut models = children(reader, root.node, "model");
    let mut includes = Vec::new();
    for world in &worlds {
        models.extend(children(reader, *world, "model"));
        includes.extend(children(reader, *world, "include"));
    }
    if models.len() + includes.len() != 1 {
        let named = models.iter().map(|model| excerpt(model.attribute("name").unwrap_or_default()));
        let uris = includes.iter().map(|include| {
            let uri = include.children().find(|child| child.has_tag_name("uri"));
            excerpt(uri.and_then(|uri| uri.text()).unwrap_or_default().trim())
        });
        let names: Vec<String> = named.chain(uris).take(10).map(|name| format!("{name:?}")).collect();
        let reason = match names.len() {
            0 => "there is no <model>; give a file with one model".to_owned(),
            _ => format!(
                "there are {} models ({}); save one of them as a file of its own, and join several by a scene",
                models.len() + includes.len(),
                names.join(", ")
            ),
        };
        reader.refuse_sdf(root, reason);
        return None;
    }
    for world in worlds {
        let world = reader.named_element(world, "world");
        parts.gravity = Some(reader.child_numbers(&world, "gravity").unwrap_or(WORLD_GRAVITY));
        let ignored = [
            "light",
            "physics",
            "plugin",
            "scene",
            "gui",
            "atmosphere",
            "wind",
            "magnetic_field",
            "spherical_coordinates",
            "audio",
            "state",
            "road",
            "population",
        ];
        for node in world.node.children().filter(|&node| ignored.contains(&node.tag_name().name())) {
            let (line, tag) = (reader.line(node), node.tag_name().name());
            reader.report_ignored(
                line,
                format!("{}/{tag}", world.place),
                "a part of the world, not of the model",
            );
        }
        let known = [&ignored[..], &["gravity", "model", "include"]].concat();
        // Joints and frames of a world are physics.
        reader.list_unread(&world, &["name"], &known, UnknownPart::Physics);
    }
    if let Some(&model) = models.first() {
        let model = reader.named_element(model, "model");
        parts.model(reader, &model, &scope, true, &Overrides::default());
        return Some(model.text("name").unwrap_or_default().to_owned());
    }
    let include = *includes.first()?;
    let include = Element { node: include, line: reader.line(include), place: "include".into() };
    let before = parts.frames.len();
    parts.include(reader, &include, &scope, true);
    let name = reader.child_text(&include, "name").map(|(_, name)| name.to_owned());
    let stem = parts.files.first().and_then(|file| file.file_stem()?.to_str()).map(str::to_owned);
    (parts.frames.len() > before).then(|| name.or(stem).unwrap_or_default())
}
