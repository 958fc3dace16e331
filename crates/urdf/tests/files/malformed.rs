//! Malformed files: each is refused with a message that says what is wrong, where, and what to do.

use urdf::{Options, parse};

type Frame = fn(&str) -> String;

/// The text is the whole file.
fn whole(text: &str) -> String {
    text.to_owned()
}

/// The text stands inside the robot, from line 2.
fn in_robot(text: &str) -> String {
    format!("<robot name=\"r\">\n{text}\n</robot>")
}

/// The text stands from line 4, after two links with mass: a, b.
fn between_links(text: &str) -> String {
    let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    in_robot(&format!("<link name=\"a\">{inertial}</link>\n<link name=\"b\">{inertial}</link>\n{text}"))
}

/// The text stands from line 4, inside the inertial of the only link.
fn in_inertial(text: &str) -> String {
    in_robot(&format!("<link name=\"a\">\n<inertial>\n{text}\n</inertial></link>"))
}

/// How the text is framed, the text, the message.
#[rustfmt::skip]
const CASES: &[(Frame, &str, &str)] = &[
    // empty
    (whole, "",
     "the file is empty; a URDF file holds one <robot> element"),
    // blank with a byte order mark
    (whole, "\u{feff} \n",
     "the file is empty; a URDF file holds one <robot> element"),
    // not xml
    (whole, "solid stl facet",
     "line 1, column 1: not well-formed XML: unknown token"),
    // unclosed robot
    (whole, r#"<robot name="r">
<link name="a"/>
"#,
     "line 2, column 17: not well-formed XML: the root node was opened but never closed"),
    // wrong closing tag
    (whole, r#"<robot name="r">
  <link name="a"></joint>
</robot>"#,
     "line 2, column 18: not well-formed XML: expected 'link' tag, not 'joint'"),
    // repeated attribute
    (whole, r#"<robot name="r">
  <link name="a" name="b"/>
</robot>"#,
     "line 2, column 18: not well-formed XML: attribute 'name' is already defined"),
    // unknown entity
    (whole, r#"<robot name="&who;"/>"#,
     "line 1, column 14: not well-formed XML: unknown entity reference 'who'"),
    // document type
    (whole, r#"<?xml version="1.0"?>
<!DOCTYPE robot [<!ENTITY a "aaaa">]>
<robot name="&a;"/>"#,
     "line 2: a URDF file needs no <!DOCTYPE …>, and its entities are not expanded; delete it"),
    // sdf file
    (whole, r#"<sdf version="1.9"/>"#,
     "line 1: the outermost element is <sdf>, not <robot>; SDF files are not read; export URDF"),
    // other xml
    (whole, "<html/>",
     r#"line 1: the outermost element is <html>, not <robot>; a URDF file holds one <robot name="…"> element"#),
    // xacro that is yet to be expanded
    (whole, "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:property name=\"m\" value=\"1\"/>\n<xacro:include filename=\"arm.xacro\"/><xacro:arm/></robot>",
     "line 2: this is a xacro file, and `xacro:include` (2 such) is not expanded: run `xacro FILE > robot.urdf`, with the arguments that the robot takes, and load robot.urdf; xacro is part of ROS, and without ROS `pip install xacrodoc` brings `xacrodoc FILE -o robot.urdf`"),
    // no links
    (in_robot, "",
     r#"line 1: robot "r" has no links; a robot has at least one <link name="…"/>"#),
    // link without a name
    (in_robot, "<link/>",
     r#"line 2: link: the attribute `name` is missing; write <link name="NAME">"#),
    // link with a blank name
    (in_robot, r#"<link name=" "/>"#,
     r#"line 2: link " ": the attribute `name` is empty; give a name"#),
    // two links of one name
    (in_robot, r#"<link name="a"/>
<link name="a"/>"#,
     r#"line 3: link "a" is already defined on line 2; give each its own name"#),
    // mass as text
    (in_inertial, r#"<mass>2</mass><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/mass: the attribute `value` is missing; write value="NUMBER""#),
    // inertia without izz
    (in_inertial, r#"<mass value="1"/>
<inertia ixx="1" iyy="1"/>"#,
     r#"line 5: link "a"/inertial/inertia: the attribute `izz` is missing; write izz="NUMBER""#),
    // mass is not a number
    (in_inertial, r#"<mass value="two"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/mass: value="two" is not a number"#),
    // mass is nan
    (in_inertial, r#"<mass value="NaN"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/mass: value="NaN" is not a finite number; write an ordinary number in SI units"#),
    // mass overflows
    (in_inertial, r#"<mass value="1e400"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/mass: value="1e400" is not a finite number; write an ordinary number in SI units"#),
    // mass beyond physics
    (in_inertial, r#"<mass value="1e40"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/mass: value="1e40" is beyond 1e30; give SI units (m, kg, s, rad)"#),
    // mass from xacro
    (in_inertial, r#"<mass value="${m}"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/mass: value="${m}" is not a number; it looks like xacro, so run xacro on the file first"#),
    // negative mass
    (in_inertial, r#"<mass value="-1"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/mass: value=-1 is negative; a mass is zero or positive; correct its sign"#),
    // decimal comma
    (in_inertial, r#"<origin xyz="0 0 0,5"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/origin: xyz="0 0 0,5" is not a number; it has a comma: write a decimal point, and white space between numbers"#),
    // two numbers for three
    (in_inertial, r#"<origin xyz="0 1"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/origin: xyz="0 1" holds 2 numbers, not 3"#),
    // infinite rotation
    (in_inertial, r#"<origin rpy="0 0 inf"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/origin: rpy="0 0 inf" is not a finite number; write an ordinary number in SI units"#),
    // zero quaternion
    (in_inertial, r#"<origin quat_xyzw="0 0 0 0"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/origin: quat_xyzw is zero and no rotation; write "0 0 0 1" for none"#),
    // rotation twice
    (in_inertial, r#"<origin rpy="0 0 0" quat_xyzw="0 0 0 1"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#,
     r#"line 4: link "a"/inertial/origin: both `rpy` and `quat_xyzw` are given; keep one of them"#),
    // joint without a name
    (between_links, r#"<joint type="fixed"><parent link="a"/><child link="b"/></joint>"#,
     r#"line 4: joint: the attribute `name` is missing; write <joint name="NAME" type="TYPE">"#),
    // joint without a type
    (between_links, r#"<joint name="j"><parent link="a"/><child link="b"/></joint>"#,
     r#"line 4: joint "j": the attribute `type` is missing; write type="revolute" or another joint type"#),
    // unknown joint type
    (between_links, r#"<joint name="j" type="hinge"><parent link="a"/><child link="b"/></joint>"#,
     r#"line 4: joint "j": the type "hinge" is unknown; use revolute, continuous, prismatic, fixed, floating, planar or spherical"#),
    // no parent
    (between_links, r#"<joint name="j" type="fixed"><child link="b"/></joint>"#,
     r#"line 4: joint "j": the element <parent> is missing; write <parent link="NAME"/> and <child link="NAME"/>"#),
    // child without a link
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child/></joint>"#,
     r#"line 4: joint "j"/child: the attribute `link` is missing; write link="NAME""#),
    // unknown parent
    (between_links, r#"<joint name="j" type="fixed"><parent link="x"/><child link="b"/></joint>"#,
     r#"line 4: joint "j": its parent link "x" does not exist; add it or correct the name"#),
    // unknown child
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="x"/></joint>"#,
     r#"line 4: joint "j": its child link "x" does not exist; add it or correct the name"#),
    // link joined to itself
    (between_links, r#"<joint name="j" type="fixed"><parent link="b"/><child link="b"/></joint>"#,
     r#"line 4: joint "j" joins link "b" to itself; parent and child must differ"#),
    // two joints of one name
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>"#,
     "2 errors
  line 5: joint \"j\" is already defined on line 4; give each its own name
  line 5: link \"b\" is the child of joint \"j\", but already of joint \"j\" (line 4); a tree has one, and loops are not URDF"),
    // two parents
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="fixed"><parent link="a"/><child link="b"/></joint>"#,
     r#"line 5: link "b" is the child of joint "k", but already of joint "j" (line 4); a tree has one, and loops are not URDF"#),
    // cycle of everything
    (between_links, r#"<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>"#,
     r#"line 4: the joints "j" → "k" form a cycle; remove one of them, so that a root link remains"#),
    // cycle beside the root
    (between_links, r#"<link name="c"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>"#,
     r#"line 4: the joints "j" → "k" form a cycle; remove one of them, so that a root link remains"#),
    // zero axis
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<axis xyz="0 0 0"/></joint>"#,
     r#"line 5: joint "j": the axis is zero; give a direction such as xyz="0 0 1""#),
    // axis without xyz
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis/></joint>"#,
     r#"line 4: joint "j"/axis: the attribute `xyz` is missing; write xyz="0 0 1" or another direction"#),
    // axis of four numbers
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 0 1"/></joint>"#,
     r#"line 4: joint "j"/axis: xyz="0 0 0 1" holds 4 numbers, not 3"#),
    // spring twice
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><dynamics stiffness="1" spring_stiffness="1"/></joint>"#,
     r#"line 4: joint "j"/dynamics: both `stiffness` and `spring_stiffness` are given; keep one of them"#),
    // mimic of nobody
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic/></joint>"#,
     r#"line 4: joint "j"/mimic: the attribute `joint` is missing; write joint="NAME", the joint to follow"#),
    // mimic of the unknown
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic joint="x"/></joint>"#,
     r#"line 4: joint "j" mimics "x", which does not exist; add it or correct the name"#),
    // mimic of itself
    (between_links, r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic joint="j"/></joint>"#,
     r#"line 4: the joints "j" → "j" mimic each other in a ring; let one of them be free"#),
    // mimic of a fixed joint
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#,
     r#"line 5: joint "k" mimics "j", but "j" is fixed; both must be revolute, continuous or prismatic"#),
    // planar mimic
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="planar"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#,
     r#"line 5: joint "k" mimics "j", but "k" is planar; both must be revolute, continuous or prismatic"#),
    // mimic of a planar joint
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="planar"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#,
     r#"line 5: joint "k" mimics "j", but "j" is planar; both must be revolute, continuous or prismatic"#),
    // mimic in a ring
    (between_links, r#"<link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/><mimic joint="k"/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/></joint>"#,
     r#"line 4: the joints "j" → "k" → "j" mimic each other in a ring; let one of them be free"#),
];

#[test]
fn every_malformed_file_is_refused_with_its_message() {
    assert!(CASES.len() >= 30);
    let mut wrong = Vec::new();
    for (frame, text, expected) in CASES {
        let message = match parse(&frame(text), &Options::default()) {
            Ok(robot) => format!("accepted:\n{}", robot.report),
            Err(error) => error.to_string(),
        };
        if message != *expected {
            wrong.push(format!("{text}\n  expected: {expected}\n  found:    {message}"));
        }
    }
    assert!(wrong.is_empty(), "{} wrong messages:\n\n{}", wrong.len(), wrong.join("\n\n"));
}
