//! The account of a file: physics that is not read is named with line and severity, looks are counted, nothing is lost.

use mjcf::{Options, Severity, parse};

use crate::reading::read;

/// Inside `<mujoco>`, with a body `a`, its joint `j`, its geom `g` and its site `s`, from line 2.
fn in_file(text: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='a'><joint name='j'/><geom name='g' size='0.1'/><site name='s'/></body></worldbody>\n{text}\n</mujoco>"
    )
}

/// Inside the body `a`, which has a shape and a joint, from line 2.
fn in_body(text: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='a'><joint/><geom size='0.1'/>\n{text}\n</body></worldbody></mujoco>"
    )
}

fn whole(text: &str) -> String {
    text.to_owned()
}

type Frame = fn(&str) -> String;

/// How the text is framed, the text, place and message of its warning, on line 2.
#[rustfmt::skip]
const WARNINGS: &[(Frame, &str, &str, &str)] = &[
    (in_file, "<option density='1.2'/>", "option", r#"density="1.2" is not in the model"#),
    (in_file, "<option viscosity='1e-5'/>", "option", r#"viscosity="1e-5" is not in the model"#),
    (in_file, "<option><flag equality='disable'/></option>", "flag", r#"equality="disable" is not in the model"#),
    (in_file, "<tendon><spatial name='t'><site site='s'/></spatial></tendon>", r#"spatial "t""#, "a tendon through space is not in the model"),
    (in_file, "<actuator><muscle name='m' joint='j'/></actuator>", r#"muscle "m""#, "an actuator of this kind is not in the model"),
    (in_file, "<actuator><general name='m' joint='j' gaintype='user'/></actuator>", r#"general "m""#, r#"gaintype="user": an actuator of this kind is not in the model"#),
    (in_file, "<actuator><motor name='m' site='s' refsite='s'/></actuator>", r#"motor "m""#, "refsite: an actuator between two sites is not in the model"),
    (in_file, "<actuator><motor name='m' joint='j' delay='1'/></actuator>", r#"motor "m""#, r#"delay="1" is not in the model"#),
    (in_file, "<deformable><flex name='f'/></deformable>", "deformable", "bodies that bend are not in the model"),
    (in_file, "<gravity/>", "gravity", "an element that <mujoco> of the format does not have: not read, perhaps physics"),
    (in_body, "<geom name='wing' size='1' mass='0' fluidshape='ellipsoid'/>", r#"geom "wing""#, r#"fluidshape="ellipsoid" is not in the model"#),
    (in_body, "<plugin plugin='p'/>", "plugin", "the forces of a plugin are not in the model"),
    (in_body, "<composite type='cable'/>", "composite", "bodies that bend are not in the model"),
    (in_file, "<worldbody><body><joint name='k' type='free' frictionloss='1'/><geom size='1'/></body></worldbody>", r#"joint "k""#, "frictionloss=1 of a free joint: in the model it resists along the body's axes, in MuJoCo along the world's"),
    (in_body, "<joint name='k' mood='good'/>", r#"joint "k""#, r#"mood="good": an attribute that the format does not have here: not read, perhaps physics"#),
    (in_body, "<body name='b'><joint/></body>", r#"body "b""#, "it moves, but neither it nor what is fixed to it has mass, which MuJoCo refuses: the mass matrix may be singular; give it an <inertial> or a geom"),
    (in_body, "<inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/>", r#"body "a"/inertial"#, "the principal moments 1, 1, 3 kg·m² break the triangle inequality: the largest exceeds the sum of the others by 1; check the units and whether the inertia is about the centre of mass; taken as written: correct it, or repair it on loading"),
    (whole, "<mujoco><compiler autolimits='false'/><worldbody><body name='a'><geom size='0.1'/>\n<joint name='k' range='0 1'/></body></worldbody></mujoco>", r#"joint "k""#, "range without limited, and autolimits is off: no limit; give limited=\"true\" or \"false\""),
];

#[test]
fn physics_that_is_not_read_is_named_with_its_line() {
    for (frame, text, place, message) in WARNINGS {
        let file = frame(text);
        let robot = read(&file);
        let found: Vec<_> =
            robot.report.warnings().map(|w| (w.line(), w.place(), w.severity(), w.message())).collect();
        assert_eq!(found, [(2, *place, Severity::Warning, *message)], "{text}");
        let strict = parse(&file, &Options::default().with_strict()).expect_err("a warning").to_string();
        assert!(strict.contains(message) && strict.contains("strict reading refuses"), "{strict}");
    }
}

#[test]
fn what_does_nothing_is_a_note() {
    let text = in_file(
        "<option density='0' wind='0 0 0'/><actuator><motor joint='j' delay='0'/></actuator><option><flag contact='enable'/></option>",
    );
    let robot = read(&text);
    assert_eq!((robot.report.counts.warnings, robot.report.counts.ignored), (0, 4), "{}", robot.report);
    assert!(parse(&text, &Options::default().with_strict()).is_ok());
}

#[test]
fn looks_are_counted() {
    let robot = read(&in_file(
        "<visual><global/><headlight/></visual><asset><texture name='t'/></asset><statistic extent='1'/>",
    ));
    // visual with two elements in it, texture, statistic.
    assert_eq!((robot.report.counts.not_dynamics, robot.report.counts.ignored), (5, 0), "{}", robot.report);
}

#[test]
fn sizes_and_data_for_others_are_notes() {
    let robot = read(&in_file("<size memory='1M'/><custom/>"));
    let messages: Vec<&str> =
        robot.report.findings.iter().filter(|f| f.line() == 2).map(multibody::Finding::message).collect();
    assert_eq!(messages, ["sizes of MuJoCo's memory", "data for other programs"]);
}

#[test]
fn loose_text_and_unclean_xml_are_told() {
    let robot = read("<mujoco>\nhello<worldbody/><x:y/></mujoco>");
    let messages: Vec<&str> = robot.report.findings.iter().map(multibody::Finding::message).collect();
    assert!(messages.contains(&"loose text \"hello\""), "{messages:?}");
    assert!(
        messages.iter().any(|message| message.starts_with("the prefix `x:` is not declared")),
        "{messages:?}"
    );
}

/// An actuator that is not read takes its control with it.
#[test]
fn controls_of_a_keyframe_follow_the_actuators_that_are_read() {
    let robot = read(&in_file(
        "<actuator><motor joint='j'/><muscle joint='j'/><motor joint='j' gear='2'/></actuator><keyframe><key name='k' ctrl='1 2 3'/></keyframe>",
    ));
    let pose = robot.description.poses.iter().find(|pose| pose.name == "k").expect("a pose");
    assert_eq!(pose.controls, [1.0, 3.0]);
}
