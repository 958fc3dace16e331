//! SRDF: pairs of links that never touch.

use std::collections::BTreeSet;
use std::path::Path;

use multibody::RobotDescription;
use robot_xml::roxmltree::Node;
use robot_xml::{Lines, XmlError, excerpt};
use thiserror::Error;

/// Deepest nesting; an SRDF file has three levels.
const DEPTH_LIMIT: usize = 200;

/// Why an SRDF file was refused.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The fields are the nouns of each variant's sentence.
pub enum SrdfError {
    /// The file cannot be read, or its text is not XML.
    #[error(transparent)]
    Xml(#[from] XmlError),
    /// Well-formed XML of another kind.
    #[error("line {line}: the outermost element is <{found}>, not <robot>; this is not an SRDF file")]
    NotSrdf { line: usize, found: String },
    /// A robot's own file.
    #[error("line {line}: <{found}> belongs to URDF; give the SRDF file, which has <disable_collisions>")]
    Urdf { line: usize, found: String },
    /// A link is not named.
    #[error("line {line}: <{element}> lacks the attribute `{attribute}`, the name of a link")]
    MissingAttribute { line: usize, element: String, attribute: &'static str },
}

/// The pairs of links that an SRDF file keeps from touching, each once, of the robot with these links.
///
/// They are the pairs of `<disable_collisions link1="…" link2="…"/>`, and all pairs of a link with
/// `<disable_default_collisions link="…"/>`, but for those of `<enable_collisions link1="…" link2="…"/>`.
///
/// ```
/// let text = r#"<robot name="arm">
///   <disable_collisions link1="base" link2="shoulder" reason="Adjacent"/>
///   <disable_default_collisions link="cable"/>
///   <enable_collisions link1="cable" link2="hand"/>
/// </robot>"#;
/// let pairs = urdf::disabled_collisions(text, &["base", "shoulder", "hand", "cable"])?;
/// let names: Vec<_> = pairs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
/// assert_eq!(names, [("base", "shoulder"), ("cable", "base"), ("cable", "shoulder")]);
/// # Ok::<(), urdf::SrdfError>(())
/// ```
///
/// # Errors
/// [`SrdfError`]: the text is no SRDF, or a pair lacks a link. Names of links that the robot has not are returned as they are.
pub fn disabled_collisions(text: &str, links: &[&str]) -> Result<Vec<(String, String)>, SrdfError> {
    robot_xml::parse(text, DEPTH_LIMIT, |document, _| {
        let lines = Lines::of(document.input_text());
        read(document.root_element(), &lines, links)
    })?
}

/// [`disabled_collisions`] of an SRDF file, of this robot.
///
/// ```
/// let robot = multibody::RobotDescription::new("arm");
/// let missing = urdf::load_disabled_collisions("nowhere.srdf".as_ref(), &robot);
/// assert!(missing.unwrap_err().to_string().starts_with("cannot read"));
/// ```
///
/// # Errors
/// [`SrdfError`]: the file cannot be read, or as `disabled_collisions`.
pub fn load_disabled_collisions(
    path: &Path,
    robot: &RobotDescription,
) -> Result<Vec<(String, String)>, SrdfError> {
    let links: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    disabled_collisions(&robot_xml::read_file(path)?, &links)
}

fn read(root: Node<'_, '_>, lines: &Lines, links: &[&str]) -> Result<Vec<(String, String)>, SrdfError> {
    let line = |node: Node<'_, '_>| lines.line(node.range().start);
    let found = |node: Node<'_, '_>| excerpt(node.tag_name().name());
    if root.tag_name().name() != "robot" {
        return Err(SrdfError::NotSrdf { line: line(root), found: found(root) });
    }
    let link = |node: Node<'_, '_>, attribute: &'static str| {
        let missing = || SrdfError::MissingAttribute { line: line(node), element: found(node), attribute };
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
            "link" => return Err(SrdfError::Urdf { line: line(node), found: found(node) }),
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
        let said = |text: &str| disabled_collisions(text, &[]).expect_err("an error").to_string();
        let missing = said("<robot name=\"r\">\n<disable_collisions link1=\"a\"/></robot>");
        assert!(missing.starts_with("line 2:") && missing.contains("`link2`"), "{missing}");
        assert!(said("<robot name=\"r\">\n<link name=\"a\"/></robot>").contains("belongs to URDF"));
        assert!(said("<mujoco/>").contains("<mujoco>"));
        assert!(said("").contains("empty"));
    }
}
