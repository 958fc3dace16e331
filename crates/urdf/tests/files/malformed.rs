//! Malformed files are refused with exactly the errors of their faults, at their lines.
//!
//! `messages.rs` has the text of each message.

use robot_dynamics_urdf::{LoadOptions, UrdfError, parse};

pub(crate) type Frame = fn(&str) -> String;

/// The text is the whole file.
fn whole(text: &str) -> String {
    text.to_owned()
}

/// The text is inside the robot, from line 2.
fn in_robot(text: &str) -> String {
    format!("<robot name=\"r\">\n{text}\n</robot>")
}

/// The text is at line 4, after two links `a` and `b` with mass.
fn between_links(text: &str) -> String {
    let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    in_robot(&format!("<link name=\"a\">{inertial}</link>\n<link name=\"b\">{inertial}</link>\n{text}"))
}

/// The text is at line 4, inside the inertial of the only link.
fn in_inertial(text: &str) -> String {
    in_robot(&format!("<link name=\"a\">\n<inertial>\n{text}\n</inertial></link>"))
}

/// The frame around the text, the text, and the line and variant of each error.
#[rustfmt::skip]
#[allow(clippy::type_complexity)] // a table of tests
pub(crate) const CASES: &[(Frame, &str, &[(Option<usize>, &str)])] = &[
    // empty
    (whole, "", &[(None, "Empty")]),
    // blank with a byte order mark
    (whole, "\u{feff} \n", &[(None, "Empty")]),
    // not xml
    (whole, "a robot", &[(Some(1), "BadXml")]),
    // a mesh
    (whole, "solid stl facet", &[(None, "OtherFormat")]),
    // unclosed robot
    (whole, r#"<robot name="r">
<link name="a"/>
"#, &[(Some(2), "BadXml")]),
    // wrong closing tag
    (whole, r#"<robot name="r">
  <link name="a"></joint>
</robot>"#, &[(Some(2), "BadXml")]),
    // repeated attribute
    (whole, r#"<robot name="r">
  <link name="a" name="b"/>
</robot>"#, &[(Some(2), "BadXml")]),
    // unknown entity in a name, which is read as its characters
    (whole, r#"<robot name="&who;"/>"#, &[(Some(1), "NoLinks")]),
    // unknown entity in the place of a number
    (whole, r#"<robot name="r"><link name="a"><inertial><mass value="&m;"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"#, &[(Some(1), "NotANumber")]),
    // document type
    (whole, r#"<?xml version="1.0"?>
<!DOCTYPE robot [<!ENTITY a "aaaa">]>
<robot name="&a;"/>"#, &[(Some(2), "DocumentType")]),
    // sdf file
    (whole, r#"<sdf version="1.9"/>"#, &[(Some(1), "BadSemantics")]),
    // other xml
    (whole, "<html/>", &[(Some(1), "NotARobot")]),
    // xacro that is not expanded
    (whole, "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:property name=\"m\" value=\"1\"/>\n<xacro:include filename=\"arm.xacro\"/><xacro:arm/></robot>", &[(Some(2), "Unexpanded")]),
    // no links
    (in_robot, "", &[(Some(1), "NoLinks")]),
    // link without a name
    (in_robot, "<link/>", &[(Some(2), "MissingAttribute")]),
    // link with a blank name
    (in_robot, r#"<link name=" "/>"#, &[(Some(2), "EmptyName")]),
    // two links of one name
    (in_robot, r#"<link name="a"/>
<link name="a"/>"#, &[(Some(3), "DuplicateName")]),
    // mass as text
    (in_inertial, r#"<mass>2</mass><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "MissingAttribute")]),
    // inertia without izz
    (in_inertial, r#"<mass value="1"/>
<inertia ixx="1" iyy="1"/>"#, &[(Some(5), "MissingAttribute")]),
    // mass is not a number
    (in_inertial, r#"<mass value="two"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "NotANumber")]),
    // mass is nan
    (in_inertial, r#"<mass value="NaN"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "NotFinite")]),
    // mass overflows
    (in_inertial, r#"<mass value="1e400"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "NotFinite")]),
    // mass beyond physics
    (in_inertial, r#"<mass value="1e40"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "TooBig")]),
    // mass from xacro
    (in_inertial, r#"<mass value="${m}"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "NotANumber")]),
    // negative mass
    (in_inertial, r#"<mass value="-1"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "Negative")]),
    // decimal comma
    (in_inertial, r#"<origin xyz="0 0 0,5"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "NotANumber")]),
    // two numbers for three
    (in_inertial, r#"<origin xyz="0 1"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "WrongCount")]),
    // infinite rotation
    (in_inertial, r#"<origin rpy="0 0 inf"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "NotFinite")]),
    // zero quaternion
    (in_inertial, r#"<origin quat_xyzw="0 0 0 0"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "ZeroQuaternion")]),
    // rotation twice
    (in_inertial, r#"<origin rpy="0 0 0" quat_xyzw="0 0 0 1"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#, &[(Some(4), "Both")]),
    // joint without a name
    (between_links, r#"<joint type="fixed"><parent link="a"/><child link="b"/></joint>"#, &[(Some(4), "MissingAttribute")]),
    // joint without a type
    (between_links, r#"<joint name="j"><parent link="a"/><child link="b"/></joint>"#, &[(Some(4), "MissingAttribute")]),
    // unknown joint type
    (between_links, r#"<joint name="j" type="hinge"><parent link="a"/><child link="b"/></joint>"#, &[(Some(4), "UnknownJointType")]),
    // no parent
    (between_links, r#"<joint name="j" type="fixed"><child link="b"/></joint>"#, &[(Some(4), "MissingElement")]),
    // child without a link
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child/></joint>"#, &[(Some(4), "MissingAttribute")]),
    // unknown parent
    (between_links, r#"<joint name="j" type="fixed"><parent link="x"/><child link="b"/></joint>"#, &[(Some(4), "UnknownLink")]),
    // unknown child
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="x"/></joint>"#, &[(Some(4), "UnknownLink")]),
    // link joined to itself
    (between_links, r#"<joint name="j" type="fixed"><parent link="b"/><child link="b"/></joint>"#, &[(Some(4), "SelfParent")]),
    // two joints of one name
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>"#, &[(Some(5), "DuplicateName"), (Some(5), "TwoParents")]),
    // two parents
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="fixed"><parent link="a"/><child link="b"/></joint>"#, &[(Some(5), "TwoParents")]),
    // cycle of all links
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>"#, &[(Some(4), "Cycle")]),
    // cycle beside the root
    (between_links, r#"<link name="c"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>"#, &[(Some(4), "Cycle")]),
    // zero axis
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<axis xyz="0 0 0"/></joint>"#, &[(Some(5), "ZeroAxis")]),
    // axis without xyz
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis/></joint>"#, &[(Some(4), "MissingAttribute")]),
    // axis of four numbers
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 0 1"/></joint>"#, &[(Some(4), "WrongCount")]),
    // spring twice
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><dynamics stiffness="1" spring_stiffness="1"/></joint>"#, &[(Some(4), "Both")]),
    // mimic without a joint
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic/></joint>"#, &[(Some(4), "MissingAttribute")]),
    // mimic of an unknown joint
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic joint="x"/></joint>"#, &[(Some(4), "UnknownMimic")]),
    // mimic of itself
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic joint="j"/></joint>"#, &[(Some(4), "MimicCycle")]),
    // mimic of a fixed joint
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#, &[(Some(5), "MimicKind")]),
    // planar mimic
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="planar"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#, &[(Some(5), "MimicKind")]),
    // mimic of a planar joint
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="planar"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#, &[(Some(5), "MimicKind")]),
    // mimic cycle
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic joint="k"/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#, &[(Some(4), "MimicCycle")]),
];

/// The name of the error's variant.
pub(crate) fn variant(error: &UrdfError) -> String {
    format!("{error:?}").chars().take_while(|letter| letter.is_alphanumeric()).collect()
}

#[test]
fn every_malformed_file_is_refused_with_its_errors() {
    assert!(CASES.len() >= 30);
    let mut wrong = Vec::new();
    for (frame, text, expected) in CASES {
        let found: Vec<(Option<usize>, String)> = match parse(&frame(text), &LoadOptions::default()) {
            Ok(robot) => vec![(None, format!("accepted:\n{}", robot.report))],
            Err(error) => error.errors().iter().map(|error| (error.line(), variant(error))).collect(),
        };
        let is_expected =
            found.iter().map(|(line, name)| (*line, name.as_str())).eq(expected.iter().copied());
        if !is_expected {
            wrong.push(format!("{text}\n  expected: {expected:?}\n  found:    {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{} wrong answers:\n\n{}", wrong.len(), wrong.join("\n\n"));
}
