//! Xacro files, which a program of ROS turns into URDF: told apart, with what to run first.

use std::path::Path;

use robot_xml::excerpt;
use robot_xml::roxmltree::Node;

use crate::UrdfError;
use crate::reader::Reader;

/// Instructions that leave nothing behind in the file that comes of them.
const SILENT: [&str; 3] = ["property", "arg", "macro"];

/// Whether the element is one that xacro replaces.
pub(crate) fn is_instruction(node: Node<'_, '_>) -> bool {
    node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"))
}

/// A file that is not expanded: it is named so, or has no joint that moves, and holds instructions that would add to it. Where a
/// robot is all there, a stray one is a warning.
pub(crate) fn refuse_unexpanded<'a>(
    reader: &Reader<'a>,
    robot: Node<'a, 'a>,
    path: Option<&Path>,
) -> Result<(), UrdfError> {
    let adds = |node: &Node<'a, 'a>| is_instruction(*node) && !SILENT.contains(&node.tag_name().name());
    let Some(first) = robot.descendants().find(adds) else { return Ok(()) };
    let is_named = path.and_then(Path::extension).is_some_and(|ending| ending.eq_ignore_ascii_case("xacro"));
    let moves = |node: Node<'a, 'a>| {
        reader.is(node, "joint") && node.attribute("type").is_some_and(|kind| kind != "fixed")
    };
    if !is_named && robot.children().any(moves) {
        return Ok(());
    }
    let file = path.and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    Err(UrdfError::Unexpanded {
        line: reader.line(first),
        instruction: excerpt(first.tag_name().name()),
        count: robot.descendants().filter(adds).count(),
        file: file.unwrap_or_else(|| "FILE".into()),
    })
}
