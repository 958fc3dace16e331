//! Reads SRDF, which adds groups, poses, passive joints, the joint to the world, and pairs of links without
//! collisions to a robot.

mod groups;
mod joints;
mod pairs;
mod semantics;
mod states;

use std::path::Path;

use robot_dynamics_description::{LoadReport, RobotDescription};
use robot_dynamics_xml::roxmltree::Node;
use robot_dynamics_xml::{Budget, excerpt};

use self::pairs::collision_pairs;
use self::semantics::Semantics;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;
use crate::{LoadError, LoadOptions, UrdfError};

/// The deepest nesting of elements. An SRDF file has three levels.
const DEPTH_LIMIT: usize = 200;

/// Adds the content of an SRDF file to a robot of any format.
///
/// - `<group>`: its links and joints, with those of its chains and subgroups. A link brings the joint above
///   it, and a joint its child link, as in MoveIt.
/// - `<group_state>`: a named pose. If several groups have states of one name, the names are `GROUP/NAME`.
/// - `<passive_joint>`: not among the [actuated joints](RobotDescription::actuated_joints).
/// - `<virtual_joint>` of the type `floating` or `planar`: a joint of this name to the root link, from a new
///   root link named by `parent_frame`. The type `fixed` changes nothing.
/// - `<end_effector>`, and the pairs of [`disabled_collisions`].
/// - `<rotor_params>`, as in Pinocchio: gear_ratio²·mass is added to the armature of its joint.
///
/// Returns the report of the file. Only the option `strict` is used.
///
/// ```
/// use robot_dynamics_urdf::{LoadOptions, add_srdf};
/// let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
/// let text = r#"<robot name="pendulum">
///   <group name="arm"><joint name="hinge"/></group>
///   <group_state name="down" group="arm"><joint name="hinge" value="-1.57"/></group_state>
/// </robot>"#;
/// let report = add_srdf(&mut robot, text, &LoadOptions::default())?;
/// assert_eq!((robot.groups[0].links.as_slice(), report.counts.warnings), (&["rod".to_owned()][..], 0));
/// assert_eq!(robot.poses[0].positions, [("hinge".to_owned(), vec![-1.57])]);
/// let unknown = add_srdf(&mut robot, &text.replace("\"hinge\"/", "\"hing\"/"), &LoadOptions::default());
/// assert!(unknown.unwrap_err().to_string().contains("did you mean `hinge`?"));
/// # Ok::<(), robot_dynamics_urdf::LoadError>(())
/// ```
///
/// # Errors
/// [`LoadError`] lists all errors, such as names that the robot does not have, each with its line. The robot
/// is then unchanged.
pub fn add_srdf(
    robot: &mut RobotDescription,
    text: &str,
    options: &LoadOptions,
) -> Result<LoadReport, LoadError> {
    let mut changed = robot.clone();
    let read = robot_dynamics_xml::parse(text, DEPTH_LIMIT, |document, faults| {
        let root = document.root_element();
        let mut reader = Reader::new(document.input_text(), root, options.clone());
        let element = root_element(&reader, root)?;
        for (line, message) in faults {
            reader.push_fault(*line, message);
        }
        add(Semantics::new(reader, &mut changed), &element)
    });
    let report = read.map_err(UrdfError::from)??;
    *robot = changed;
    Ok(report)
}

fn add<'a>(mut semantics: Semantics<'a, '_>, root: &Element<'a>) -> Result<LoadReport, LoadError> {
    let known = [
        "group",
        "group_state",
        "end_effector",
        "virtual_joint",
        "passive_joint",
        "disable_collisions",
        "enable_collisions",
        "disable_default_collisions",
        "rotor_params",
    ];
    semantics.reader.list_unread(root, &["name", "version"], &known, UnknownPart::Harmless);
    semantics.note_name(root);
    semantics.virtual_joints(root);
    semantics.groups(root);
    semantics.group_states(root);
    semantics.passive_joints(root);
    semantics.end_effectors(root);
    semantics.rotors(root);
    semantics.collisions(root);
    semantics.finish()
}

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
/// [`LoadError`] if the text is not SRDF, or if a pair lacks a link. Names of unknown links are returned as
/// written.
#[doc(alias = "SrdfError")]
pub fn disabled_collisions(text: &str, links: &[&str]) -> Result<Vec<(String, String)>, LoadError> {
    let read = robot_dynamics_xml::parse(text, DEPTH_LIMIT, |document, _| {
        let root = document.root_element();
        let mut reader = Reader::new(document.input_text(), root, LoadOptions::default());
        let element = root_element(&reader, root)?;
        let found = collision_pairs(&mut reader, &mut Budget::default(), &element, links);
        if reader.errors.is_empty() {
            Ok(found.pairs)
        } else {
            Err(LoadError::new(reader.errors, UrdfError::sorted_at, reader.report))
        }
    });
    read.map_err(UrdfError::from)?
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

/// The outermost element of an SRDF file.
fn root_element<'a>(reader: &Reader<'a>, root: Node<'a, 'a>) -> Result<Element<'a>, LoadError> {
    let (line, found) = (reader.line(root), excerpt(root.tag_name().name()));
    if found != "robot" {
        let advice = "this is not an SRDF file";
        return Err(UrdfError::NotARobot { line, found, advice }.into());
    }
    if let Some(link) = root.children().find(|&child| reader.is(child, "link")) {
        return Err(UrdfError::NotSrdf { line: reader.line(link), found: "link".into() }.into());
    }
    Ok(Element { node: root, line, place: "robot".into() })
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
