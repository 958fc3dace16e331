//! Reads SRDF: pairs of links without collisions.

use std::collections::BTreeSet;
use std::path::Path;

use robot_dynamics_description::RobotDescription;
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Lines, excerpt};

use crate::{LoadError, UrdfError};

/// The deepest nesting of elements. An SRDF file has three levels.
const DEPTH_LIMIT: usize = 200;

/// The pairs of links for which an SRDF file disables collisions, each once. `links` are the robot's links.
///
/// They are the pairs of `<disable_collisions link1="…" link2="…"/>`, and all pairs of a link with
/// `<disable_default_collisions link="…"/>`, except those of `<enable_collisions link1="…" link2="…"/>`.
///
/// ```
/// let text = r#"<robot name="arm">
///   <disable_collisions link1="base" link2="shoulder" reason="Adjacent"/>
///   <disable_default_collisions link="cable"/>
///   <enable_collisions link1="cable" link2="hand"/>
/// </robot>"#;
/// let pairs = robot_dynamics_urdf::disabled_collisions(text, &["base", "shoulder", "hand", "cable"])?;
/// let names: Vec<_> = pairs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
/// assert_eq!(names, [("base", "shoulder"), ("cable", "base"), ("cable", "shoulder")]);
/// # Ok::<(), robot_dynamics_urdf::LoadError>(())
/// ```
///
/// # Errors
/// [`LoadError`] with one error if the text is not SRDF, or if a pair lacks a link. Names of unknown links
/// are returned as written.
#[doc(alias = "SrdfError")]
pub fn disabled_collisions(text: &str, links: &[&str]) -> Result<Vec<(String, String)>, LoadError> {
    let read = robot_dynamics_xml::parse(text, DEPTH_LIMIT, |document, _| {
        let lines = Lines::of(document.input_text());
        read_pairs(document.root_element(), &lines, links)
    });
    Ok(read.map_err(UrdfError::from)??)
}

/// Reads an SRDF file for a robot: see [`disabled_collisions`].
///
/// ```
/// let robot = robot_dynamics::description::RobotDescription::new("arm");
/// let missing = robot_dynamics_urdf::load_disabled_collisions("nowhere.srdf".as_ref(), &robot);
/// assert!(missing.unwrap_err().to_string().starts_with("cannot read"));
/// ```
///
/// # Errors
/// [`LoadError`] with one error if the file cannot be read, and as [`disabled_collisions`].
pub fn load_disabled_collisions(
    path: &Path,
    robot: &RobotDescription,
) -> Result<Vec<(String, String)>, LoadError> {
    let links: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    disabled_collisions(&robot_dynamics_xml::read_file(path).map_err(UrdfError::from)?, &links)
}

fn read_pairs(root: Node<'_, '_>, lines: &Lines, links: &[&str]) -> Result<Vec<(String, String)>, UrdfError> {
    let line = |node: Node<'_, '_>| lines.line(node.range().start);
    let found = |node: Node<'_, '_>| excerpt(node.tag_name().name());
    if root.tag_name().name() != "robot" {
        let advice = "this is not an SRDF file";
        return Err(UrdfError::NotARobot { line: line(root), found: found(root), advice });
    }
    let link = |node: Node<'_, '_>, attribute: &'static str| {
        let missing = || UrdfError::MissingAttribute {
            line: line(node),
            place: format!("<{}>", found(node)),
            attribute: attribute.into(),
            example: format!("{attribute}=\"…\", the name of a link"),
        };
        node.attribute(attribute).filter(|name| !name.is_empty()).map(str::to_owned).ok_or_else(missing)
    };
    let (mut pairs, mut enabled) = (Vec::new(), BTreeSet::new());
    for node in root.children().filter(Node::is_element) {
        match node.tag_name().name() {
            "disable_collisions" => pairs.push((link(node, "link1")?, link(node, "link2")?)),
            "enable_collisions" => {
                let (a, b) = (link(node, "link1")?, link(node, "link2")?);
                enabled.extend([(b.clone(), a.clone()), (a, b)]);
            }
            "disable_default_collisions" => {
                let own = link(node, "link")?;
                let others = links.iter().filter(|other| **other != own);
                pairs.extend(others.map(|other| (own.clone(), (*other).to_owned())));
            }
            "link" => return Err(UrdfError::NotSrdf { line: line(node), found: found(node) }),
            _ => {}
        }
    }
    let mut seen = BTreeSet::new();
    pairs.retain(|(a, b)| {
        let is_new = seen.insert((a.clone(), b.clone()));
        seen.insert((b.clone(), a.clone()));
        is_new && !enabled.contains(&(a.clone(), b.clone()))
    });
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_listed_once_whichever_way_round() {
        let text = r#"<robot name="r"><disable_collisions link1="a" link2="b"/>
            <disable_collisions link1="b" link2="a"/><group name="arm"><link name="a"/></group></robot>"#;
        assert_eq!(disabled_collisions(text, &[]).expect("SRDF"), [("a".to_owned(), "b".to_owned())]);
    }

    #[test]
    fn other_files_and_missing_names_are_refused_with_their_line() {
        let error = |text: &str| disabled_collisions(text, &[]).expect_err("an error");
        let missing = error("<robot name=\"r\">\n<disable_collisions link1=\"a\"/></robot>");
        assert!(
            matches!(missing.errors(), [UrdfError::MissingAttribute { line: 2, attribute, .. }] if attribute == "link2"),
            "{missing}"
        );
        let urdf = error("<robot name=\"r\">\n<link name=\"a\"/></robot>");
        assert!(matches!(urdf.errors(), [UrdfError::NotSrdf { line: 2, .. }]), "{urdf}");
        assert!(matches!(error("<mujoco/>").errors(), [UrdfError::NotARobot { line: 1, .. }]));
        assert!(matches!(error("").errors(), [UrdfError::Empty]));
    }
}
