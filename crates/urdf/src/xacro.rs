//! Recognizes xacro files, which a program of ROS expands to URDF.

use std::path::Path;

use robot_dynamics_xml::excerpt;
use robot_dynamics_xml::roxmltree::Node;

use crate::UrdfError;
use crate::reader::Reader;

/// Instructions that add nothing to the expanded file.
const DEFINITIONS: [&str; 3] = ["property", "arg", "macro"];

/// Whether the element is a xacro instruction.
pub(crate) fn is_instruction(node: Node<'_, '_>) -> bool {
    node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"))
}

/// Refuses a xacro file that is not expanded: it has instructions that would add elements, and its name ends
/// in `.xacro` or no joint moves. In a complete robot a single instruction is only a warning.
pub(crate) fn refuse_unexpanded<'a>(
    reader: &Reader<'a>,
    robot: Node<'a, 'a>,
    path: Option<&Path>,
) -> Result<(), UrdfError> {
    let adds = |node: &Node<'a, 'a>| is_instruction(*node) && !DEFINITIONS.contains(&node.tag_name().name());
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
