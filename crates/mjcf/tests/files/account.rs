//! The report of a file names physics that is not read, with line and severity, and counts elements of
//! appearance.

use robot_dynamics_mjcf::{Disposition, LoadOptions, MjcfError, Severity, parse};

use crate::faults::Frame;
use crate::reading::read;

/// The text is in `<mujoco>` from line 2, after a body `a` with its joint `j`, geom `g` and site `s`.
fn in_file(text: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='a'><joint name='j'/><geom name='g' size='0.1'/><site name='s'/></body></worldbody>\n{text}\n</mujoco>"
    )
}

/// The text is in the body `a` from line 2, after a shape and a joint.
fn in_body(text: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='a'><joint/><geom size='0.1'/>\n{text}\n</body></worldbody></mujoco>"
    )
}

fn whole(text: &str) -> String {
    text.to_owned()
}

/// The frame around the text, the text, and the place of its warning, on line 2.
#[rustfmt::skip]
pub(crate) const WARNINGS: &[(Frame, &str, &str)] = &[
    (in_file, "<option><flag override='enable'/></option>", "flag"),
    (in_file, "<tendon><spatial name='t' armature='1'><site site='s'/><site site='s'/></spatial></tendon>", r#"spatial "t""#),
    (in_file, "<actuator><muscle name='m' joint='j'/></actuator>", r#"muscle "m""#),
    (in_file, "<actuator><general name='m' joint='j' gaintype='user'/></actuator>", r#"general "m""#),
    (in_file, "<actuator><motor name='m' site='s' refsite='s' delay='1'/></actuator>", r#"motor "m""#),
    (in_file, "<actuator><motor name='m' joint='j' delay='1'/></actuator>", r#"motor "m""#),
    (in_file, "<actuator><pid name='m' joint='j' ki='1' input='vel'/></actuator>", r#"pid "m""#),
    (in_file, "<deformable><flex name='f'/></deformable>", "deformable"),
    (in_file, "<gravity/>", "gravity"),
    (in_body, "<geom name='wing' type='plane' size='1 1 1' fluidshape='ellipsoid'/>", r#"geom "wing""#),
    (in_body, "<plugin plugin='p'/>", "plugin"),
    (in_body, "<composite type='cable'/>", "composite"),
    (in_file, "<worldbody><body><joint name='k' type='free' frictionloss='1'/><geom size='1'/></body></worldbody>", r#"joint "k""#),
    (in_body, "<joint name='k' mood='good'/>", r#"joint "k""#),
    (in_body, "<body name='b'><joint/></body>", r#"body "b""#),
    (in_body, "<inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/>", r#"body "a"/inertial"#),
    (whole, "<mujoco><compiler autolimits='false'/><worldbody><body name='a'><geom size='0.1'/>\n<joint name='k' range='0 1'/></body></worldbody></mujoco>", r#"joint "k""#),
];

#[test]
fn physics_that_is_not_read_is_named_with_its_line() {
    for (frame, text, place) in WARNINGS {
        let file = frame(text);
        let robot = read(&file);
        let found: Vec<_> = robot.report.warnings().map(|w| (w.line(), w.place(), w.severity())).collect();
        assert_eq!(found, [(2, *place, Severity::Warning)], "{text}");
        let refused = parse(&file, &LoadOptions::default().with_strict()).expect_err("a warning");
        let [MjcfError::Strict { line: 2, place: strict_place, .. }] = refused.errors() else {
            panic!("{refused}")
        };
        assert_eq!(strict_place, place, "{text}");
    }
}

#[test]
fn attributes_without_effect_give_notes() {
    let text = in_file(
        "<worldbody><body name='b'><joint name='k'/><geom size='1' adhesion='0'/></body></worldbody><actuator><motor joint='j' delay='0'/></actuator><option><flag override='disable'/></option>",
    );
    let robot = read(&text);
    assert_eq!((robot.report.counts.warnings, robot.report.counts.ignored), (0, 3), "{}", robot.report);
    assert!(parse(&text, &LoadOptions::default().with_strict()).is_ok());
}

#[test]
fn elements_of_appearance_are_counted() {
    let robot = read(&in_file(
        "<visual><global/><headlight/></visual><asset><texture name='t'/></asset><statistic extent='1'/>",
    ));
    // `visual` with two elements in it, `texture`, `statistic`.
    assert_eq!((robot.report.counts.not_dynamics, robot.report.counts.ignored), (5, 0), "{}", robot.report);
}

#[test]
fn memory_sizes_and_custom_data_give_notes() {
    let robot = read(&in_file("<size memory='1M'/><custom/>"));
    let found: Vec<_> = robot.report.findings.iter().filter(|f| f.line() == 2).collect();
    assert_eq!(found.iter().map(|f| f.place()).collect::<Vec<_>>(), ["size", "custom"]);
    assert!(
        found.iter().all(|f| f.disposition() == Disposition::Ignored { physics: false }),
        "{}",
        robot.report
    );
}

#[test]
fn stray_text_and_undeclared_prefixes_are_reported() {
    let robot = read("<mujoco>\nhello<worldbody/><x:y/></mujoco>");
    let found: Vec<_> = robot.report.findings.iter().map(|f| (f.place(), f.disposition())).collect();
    assert!(found.contains(&("text", Disposition::Ignored { physics: false })), "{}", robot.report);
    assert!(found.contains(&("mujoco", Disposition::AsWritten)), "{}", robot.report);
}

/// The control of an actuator that is not read is omitted, too.
#[test]
fn controls_of_a_keyframe_follow_the_actuators_that_are_read() {
    let robot = read(&in_file(
        "<actuator><motor joint='j'/><muscle joint='j'/><motor joint='j' gear='2'/></actuator><keyframe><key name='k' ctrl='1 2 3'/></keyframe>",
    ));
    let pose = robot.description.poses.iter().find(|pose| pose.name == "k").expect("a pose");
    assert_eq!(pose.controls, [1.0, 3.0]);
}
