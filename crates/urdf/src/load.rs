//! From a file to a robot.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use multibody::{Base, LinkDescription, RobotDescription};

use crate::element::Element;
use crate::error::excerpt;
use crate::reader::Reader;
use crate::report::LoadReport;
use crate::tree::{Places, Tree};
use crate::unread::Unknown;
use crate::{Options, UrdfError, following, moved_mass, scan};

/// The most bytes that [`load`] and [`parse`] take.
pub const SIZE_LIMIT: usize = 1 << 26;

/// A robot and the account of how it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Links and joints, as the file states them.
    pub description: RobotDescription,
    /// What was read, defaulted and ignored.
    pub report: LoadReport,
}

/// Reads a URDF file. Meshes and packages that it names are not opened.
///
/// # Errors
/// [`UrdfError`] says what is wrong, on which line, and what to do.
pub fn load(path: impl AsRef<Path>, options: &Options) -> Result<Robot, UrdfError> {
    let path = path.as_ref();
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(SIZE_LIMIT as u64 + 1).read_to_end(&mut bytes))
        .map_err(|source| UrdfError::Unreadable { path: path.to_owned(), source })?;
    if bytes.len() > SIZE_LIMIT {
        return Err(UrdfError::TooLarge { limit: SIZE_LIMIT });
    }
    let text =
        core::str::from_utf8(&bytes).map_err(|error| UrdfError::NotUtf8 { byte: error.valid_up_to() })?;
    parse(text, options)
}

/// Reads the text of a URDF file.
///
/// # Errors
/// [`UrdfError`] says what is wrong, on which line, and what to do.
pub fn parse(text: &str, options: &Options) -> Result<Robot, UrdfError> {
    if text.len() > SIZE_LIMIT {
        return Err(UrdfError::TooLarge { limit: SIZE_LIMIT });
    }
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        return Err(UrdfError::Empty);
    }
    scan::refuse_hostile(text)?;
    let document = roxmltree::Document::parse(text).map_err(|error| bad_xml(&error, text))?;
    let root = document.root_element();
    let mut reader = Reader::new(text, root, *options);
    let line = reader.line(root);
    let found = root.tag_name().name();
    if found != "robot" {
        let advice = match found {
            "sdf" | "world" | "model" => "SDF files are not read; export URDF",
            "mujoco" => "MJCF files are not read; export URDF",
            _ => "a URDF file holds one <robot name=\"…\"> element",
        };
        return Err(UrdfError::NotARobot { line, found: excerpt(found), advice });
    }
    robot(&mut reader, &Element { node: root, line, place: "robot".to_owned() })
}

/// The parser's complaint with its position given once; text that just stops is wrong at its end.
fn bad_xml(error: &roxmltree::Error, text: &str) -> UrdfError {
    use roxmltree::Error::{NoRootNode, UnclosedRootNode, UnexpectedEndOfStream, UnknownNamespace};
    let position = error.pos();
    let (line, column) = match error {
        NoRootNode | UnclosedRootNode | UnexpectedEndOfStream => {
            let last = text.lines().last().unwrap_or_default();
            (text.lines().count(), last.chars().count() + 1)
        }
        _ => (position.row as usize, position.col as usize),
    };
    let reason = match error {
        UnknownNamespace(prefix, _) => {
            let prefix = excerpt(prefix);
            format!("the prefix `{prefix}:` is not declared; add xmlns:{prefix}=\"…\" to <robot>")
        }
        error => excerpt(&error.to_string().replace(&format!(" at {position}"), "")),
    };
    UrdfError::BadXml { line, column, reason }
}

fn robot<'a>(reader: &mut Reader<'a>, element: &Element<'a>) -> Result<Robot, UrdfError> {
    reader.list_unread(element, &["name", "version"], &["link", "joint"], Unknown::IsHarmless)?;
    let name = element.text("name").unwrap_or_default();
    if name.is_empty() {
        reader.defaulted(element, "the robot has no name");
    }
    let mut robot = RobotDescription::new(name);
    robot.base = if reader.options.floating_base { Base::Floating } else { Base::Fixed };
    let mut lines = Places { robot: element.line, links: Vec::new(), joints: Vec::new() };
    for node in element.node.children() {
        if reader.is(node, "link") {
            let link = reader.named(node, "link");
            robot.links.push(read_link(reader, &link)?);
            lines.links.push(link.line);
        } else if reader.is(node, "joint") {
            let joint = reader.named(node, "joint");
            robot.joints.push(reader.joint(&joint)?);
            lines.joints.push(joint.line);
        }
    }
    let tree = Tree::of(&robot, &lines)?;
    let leaders = following::leaders(&robot, &lines)?;
    moved_mass::check(&robot, &tree, &leaders, &lines, reader)?;

    let mut report = core::mem::take(&mut reader.report);
    name.clone_into(&mut report.robot);
    report.counts.links = robot.links.len();
    report.counts.joints = robot.joints.len();
    let free = robot.joints.iter().filter(|joint| joint.mimic.is_none());
    report.counts.degrees_of_freedom =
        free.map(|joint| joint.kind.nv()).sum::<usize>() + if robot.base == Base::Floating { 6 } else { 0 };
    report.entries.sort_by_key(|entry| entry.line);
    Ok(Robot { description: robot, report })
}

fn read_link<'a>(reader: &mut Reader<'a>, link: &Element<'a>) -> Result<LinkDescription, UrdfError> {
    let name = link.required_name("name", "<link name=\"NAME\">")?;
    reader.list_unread(link, &["name"], &["inertial"], Unknown::IsHarmless)?;
    let mass_properties = reader.mass_properties(link, name)?;
    Ok(LinkDescription { name: name.to_owned(), mass_properties })
}
