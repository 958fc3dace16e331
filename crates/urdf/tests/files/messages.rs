//! Snapshots of all messages, each with the input that gives it.
//!
//! After a change of wording, run the tests with `INSTA_UPDATE=always` and review the difference of the
//! snapshots.

#![allow(clippy::format_collect)] // short inputs, made once

use std::fmt::Write as _;

use insta::assert_snapshot;
use robot_dynamics::description::{
    ContactPairDescription, Equality, EqualityDescription, JointKind, LinkShape, Pose, RobotDescription,
    SensorDescription, SensorKind, Shape, ShapeRole, pendulum,
};
use robot_dynamics_urdf::{
    Disposition, Finding, LoadError, LoadOptions, UrdfError, disabled_collisions, parse, write,
};

use crate::malformed::CASES;
use crate::reading::{UNKNOWN_PARTS, UNREAD, with_joint, with_unread};
use crate::shapes::{BAD_SHAPES, with_shapes};
use crate::warnings::WARNINGS;

/// Adds an input and its message.
fn add(out: &mut String, input: &str, message: impl std::fmt::Display) {
    let input = input.trim().replace('\u{feff}', "(byte order mark)");
    let input = if input.is_empty() { "(empty)" } else { &input };
    writeln!(out, "{input}\n=> {message}\n").expect("to a string");
}

fn refused(text: &str, options: &LoadOptions) -> LoadError {
    parse(text, options).expect_err(text)
}

fn with_place(finding: &Finding) -> String {
    format!("line {}: {}: {}", finding.line(), finding.place(), finding.message())
}

/// The findings of a file, except for defaults.
fn list_findings(text: &str) -> String {
    let report = parse(text, &LoadOptions::default()).expect(text).report;
    let is_relevant =
        |finding: &&Finding| !matches!(finding.disposition(), Disposition::Read | Disposition::Defaulted);
    report.findings.iter().filter(is_relevant).map(with_place).collect::<Vec<_>>().join("\n=> ")
}

#[test]
fn errors() {
    let mut out = String::new();
    for (frame, text, _) in CASES {
        add(&mut out, text, refused(&frame(text), &LoadOptions::default()));
    }
    add(&mut out, "several errors", refused(crate::collected::FILE, &LoadOptions::default()));
    let nameless = format!("<robot name='r'>{}</robot>", "<link/>".repeat(1500));
    let many = refused(&nameless, &LoadOptions::default()).to_string();
    add(&mut out, "1500 links without a name", many.lines().last().unwrap_or_default());
    for (input, text) in [
        ("201 nested elements", format!("<robot name='r'>{}", "<a>".repeat(201))),
        ("201 attributes", format!("<robot{}/>", (0..201).map(|k| format!(" a{k}=''")).collect::<String>())),
        (
            "101 namespaces",
            format!("<robot>{}", (0..101).map(|k| format!("<a xmlns:n{k}='u'/>")).collect::<String>()),
        ),
        ("a ring of 12 followers", ring("<mimic joint=\"j{}\"/>")),
        ("a cycle of 12 joints", cycle()),
    ] {
        add(&mut out, input, refused(&text, &LoadOptions::default()));
    }
    for error in [
        UrdfError::NotText { byte: 2, encoding: "UTF-8".into() },
        UrdfError::TooLarge { limit: robot_dynamics_urdf::SIZE_LIMIT },
        UrdfError::Unreadable { path: "robot.urdf".into(), source: std::io::ErrorKind::NotFound.into() },
    ] {
        add(&mut out, &format!("{error:?}"), &error);
    }
    let strict = refused(&with_joint("continuous", "<flexibility/>"), &LoadOptions::default().with_strict());
    add(&mut out, "<flexibility/>, strict", strict);
    assert_snapshot!(out);
}

/// Twelve joints, each of which mimics the one before it.
fn ring(mimic: &str) -> String {
    let joints: String = (0..12)
        .map(|k| {
            let (next, mimic) = (k + 1, mimic.replace("{}", &((k + 11) % 12).to_string()));
            format!(
                "<link name='l{next}'/><joint name='j{k}' type='continuous'><parent link='l{k}'/><child link='l{next}'/>{mimic}</joint>"
            )
        })
        .collect();
    format!("<robot name='r'><link name='l0'/>{joints}</robot>")
}

/// Twelve joints, the last of which ends at the first link.
fn cycle() -> String {
    ring("").replace("<link name='l12'/>", "").replace("'l12'", "'l0'")
}

#[test]
fn warnings() {
    let mut out = String::new();
    for (frame, text, ..) in WARNINGS {
        add(&mut out, text, list_findings(&frame(text)));
    }
    let body = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";
    let massless = "<robot name='r'><link name='a'/></robot>";
    let floating = LoadOptions::default().with_floating_base();
    let report = parse(massless, &floating).expect("a robot").report;
    let findings: Vec<String> = report.warnings().map(with_place).collect();
    add(&mut out, &format!("{massless}, floating"), findings.join("\n=> "));
    let root_floats = format!(
        "<robot name='r'><link name='odom'/><link name='trunk'>{body}</link><joint name='base' type='floating'><parent link='odom'/><child link='trunk'/></joint></robot>"
    );
    let named = root_floats.replace("floating", "continuous").replace("'base'", "'floating_base'");
    for text in [root_floats, named] {
        let report = parse(&text, &floating).expect("a robot").report;
        let findings: Vec<String> =
            report.findings.iter().filter(|finding| finding.place() == "robot").map(with_place).collect();
        add(&mut out, &format!("{text}, floating"), findings.join("\n=> "));
    }
    let repair = LoadOptions::default().with_repaired_inertia();
    for (mass, moments) in [(1, [4.766, 0.0041, 0.0037]), (1, [-1.0, 1.0, 1.0]), (0, [1.0, 1.0, 1.0])] {
        let [x, y, z] = moments;
        let text = format!(
            r#"<robot name="r"><link name="a"><inertial><origin rpy="0.3 0.2 0.1"/><mass value="{mass}"/><inertia ixx="{x}" iyy="{y}" izz="{z}"/></inertial></link></robot>"#
        );
        let report = parse(&text, &repair).expect("a robot").report;
        add(
            &mut out,
            &format!("m = {mass}, moments {moments:?}, repaired"),
            report.warnings().map(with_place).collect::<String>(),
        );
    }
    assert_snapshot!(out);
}

#[test]
fn parts_that_are_not_read() {
    let mut out = String::new();
    for (text, _) in UNREAD {
        add(&mut out, text, list_findings(&with_unread(text)));
    }
    for (content, _) in UNKNOWN_PARTS {
        add(&mut out, content, list_findings(&with_joint("continuous", content)));
    }
    let fixed = r#"<axis xyz="0 0 0"/><limit lower="1" upper="0"/><dynamics damping="1"/><mimic joint="x"/>"#;
    add(&mut out, &format!("{fixed}, fixed"), list_findings(&with_joint("fixed", fixed)));
    let bounds = r#"<limit lower="1" upper="2"/>"#;
    add(&mut out, &format!("{bounds}, continuous"), list_findings(&with_joint("continuous", bounds)));
    let spring = r#"<dynamics stiffness="1"/>"#;
    add(&mut out, &format!("{spring}, spherical"), list_findings(&with_joint("spherical", spring)));
    let setting = r#"<robot name="r"><link name="a" dont_collapse="true" x:y="z" xmlns:x="x"/></robot>"#;
    add(&mut out, setting, list_findings(setting));
    for inside in BAD_SHAPES {
        let report = with_shapes(&format!("<visual>{inside}</visual>")).report;
        let findings = report
            .findings
            .iter()
            .filter(|finding| matches!(finding.disposition(), Disposition::Ignored { .. }));
        add(&mut out, inside, findings.map(with_place).collect::<String>());
    }
    assert_snapshot!(out);
}

/// All findings of files with complete, incomplete and empty elements.
#[test]
fn reports() {
    let full = with_joint(
        "revolute",
        r#"<origin xyz="1 2 3" rpy="0 0 1"/><axis xyz="0 0.6 0.8"/><limit lower="-1.5" upper="2" effort="30" velocity="4"/>
           <dynamics damping="0.1" friction="0.2" armature="0.3" stiffness="5" rest="0.5"/>"#,
    );
    let bare = with_joint("revolute", r#"<limit effort="1"/>"#);
    let dynamics = with_joint("revolute", "<origin/><dynamics/>");
    let world = r#"<robot name="r"><link name="a"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>
<joint name="j" type="fixed"><parent link="world"/><child link="a"/></joint></robot>"#;
    let mimic = format!(
        r#"<robot name="r"><link name="a"/><link name="b"/><link name="c">{}</link>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="continuous"><parent link="b"/><child link="c"/><mimic joint="j"/></joint></robot>"#,
        r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#
    );
    let reports: Vec<String> = [full.as_str(), &bare, &dynamics, world, &mimic]
        .iter()
        .map(|text| format!("{text}\n=>\n{}", parse(text, &LoadOptions::default()).expect(text).report))
        .collect();
    assert_snapshot!(reports.join("\n"));
}

#[test]
fn pairs_of_links() {
    let mut out = String::new();
    for text in [
        "<robot name=\"r\">\n<disable_collisions link1=\"a\"/></robot>",
        "<robot name=\"r\">\n<link name=\"a\"/></robot>",
        "<mujoco/>",
        "",
    ] {
        add(&mut out, text, disabled_collisions(text, &[]).expect_err("an error"));
    }
    assert_snapshot!(out);
}

/// A robot with features that URDF lacks.
fn robot_with_losses() -> RobotDescription {
    let mut robot = pendulum(2.0, 0.5);
    robot.gravity = [0.0, 0.0, -1.62];
    robot.links[1].gravity_compensation = 0.5;
    robot.time_step = Some(0.002);
    robot.impratio = Some(2.0);
    robot.contact_exclusions.push((robot.links[0].name.clone(), robot.links[1].name.clone()));
    for (name, shape) in
        [("ball", Shape::Ellipsoid { half_axes: [1.0; 3] }), ("floor", Shape::Plane { half_size: [1.0; 2] })]
    {
        let link = robot.links[1].name.clone();
        robot.shapes.push(LinkShape::new(link, ShapeRole::Collision, Pose::IDENTITY, shape).with_name(name));
    }
    robot.contact_pairs.push(ContactPairDescription::new(["ball", "floor"]));
    robot.sensors.push(SensorDescription::new("position", SensorKind::JointPosition, "hinge"));
    let polynomial = [0.0, 1.0, 1.0, 0.0, 0.0];
    let kind = Equality::Joints { joint: ("hinge".into(), 0.0), leader: None, polynomial };
    robot.equalities.push(EqualityDescription::new("bent", kind));
    robot.joints[0].higher_terms.stiffness = [1.0, 0.0];
    robot.joints[0].passive.armature = 0.1;
    robot.joints[0].limits.lower = -1.0;
    robot.joints[0].actuator_force_range = [-1.0, 2.0];
    robot.base = robot_dynamics::description::Base::Floating;
    robot
}

#[test]
fn losses_of_written_files() {
    let mut out = String::new();
    let mut spherical = pendulum(2.0, 0.5);
    spherical.joints[0].kind = JointKind::Spherical;
    let mut universal = pendulum(2.0, 0.5);
    universal.joints[0].kind = JointKind::Universal { first: [1.0, 0.0, 0.0], second: [0.0, 1.0, 0.0] };
    for (input, robot) in
        [("a robot with everything", robot_with_losses()), ("spherical", spherical), ("universal", universal)]
    {
        let written = write(&robot, None).expect("a file");
        let lines = written.left_out.iter().map(|lost| {
            format!("{}{}: {}", if lost.physics { "lost physics: " } else { "" }, lost.place, lost.message)
        });
        add(&mut out, input, lines.collect::<Vec<_>>().join("\n=> "));
    }
    let mut helical = pendulum(2.0, 0.5);
    helical.joints[0].kind = JointKind::Helical { axis: [0.0, 0.0, 1.0], pitch: 0.1 };
    let mut nameless = pendulum(2.0, 0.5);
    nameless.joints[0].name = "bell\u{7}".into();
    for (input, robot) in [("a helical joint", helical), ("a name with a control character", nameless)] {
        add(&mut out, input, write(&robot, None).expect_err("no file"));
    }
    assert_snapshot!(out);
}
