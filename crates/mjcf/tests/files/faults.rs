//! Files without a meaning are refused with exactly the error of their fault, at its line.
//!
//! `messages.rs` has the text of each message.

use robot_dynamics_mjcf::{LoadOptions, MjcfError, parse};

/// The text is in a body `a` with a shape, from line 2.
pub(crate) fn in_body(text: &str) -> String {
    format!("<mujoco><worldbody><body name='a'><geom size='0.1'/>\n{text}\n</body></worldbody></mujoco>")
}

/// The text is in `<mujoco>` from line 2, after a body `a` with its joint `j` and its site `s`.
pub(crate) fn in_file(text: &str) -> String {
    format!(
        "<mujoco><worldbody><body name='a'><joint name='j'/><geom name='g' size='0.1'/><site name='s'/></body></worldbody>\n{text}\n</mujoco>"
    )
}

fn whole(text: &str) -> String {
    text.to_owned()
}

pub(crate) type Frame = fn(&str) -> String;

/// A file with three errors.
pub(crate) const THREE: &str = "<mujoco><worldbody>\n<body name='a' pos='x 0 0'>\n<joint type='y'/>\n<geom size='z'/></body></worldbody></mujoco>";

/// The name of the error's variant.
pub(crate) fn variant(error: &MjcfError) -> String {
    format!("{error:?}").chars().take_while(|letter| letter.is_alphanumeric()).collect()
}

/// The frame around the text, the text, and the line and variant of the error.
#[rustfmt::skip]
pub(crate) const FAULTS: &[(Frame, &str, Option<usize>, &str)] = &[
    (whole, "", None, "Xml"),
    (whole, "<robot/>", Some(1), "NotMjcf"),
    (whole, "<mujoco>", Some(1), "Xml"),
    (whole, "<!DOCTYPE x><mujoco/>", Some(1), "Xml"),
    (in_body, "<joint name='j' type='hing'/>", Some(2), "UnknownWord"),
    (in_body, "<joint axis='0 0 0'/>", Some(2), "Zero"),
    (in_body, "<joint axis='0 0'/>", Some(2), "WrongCount"),
    (in_body, "<joint damping='1,5'/>", Some(2), "NotANumber"),
    (in_body, "<joint ref='nan'/>", Some(2), "NotFinite"),
    (in_body, "<joint ref='1e40'/>", Some(2), "TooBig"),
    (in_body, "<joint class='x'/>", Some(2), "UnknownName"),
    (in_body, "<joint/><freejoint name='f'/>", Some(2), "Misplaced"),
    (in_body, "<body name='b'><freejoint/></body>", Some(2), "Misplaced"),
    (in_body, "<body name='a'/>", Some(2), "DuplicateName"),
    (in_body, "<body name='world'/>", Some(2), "DuplicateName"),
    (in_body, "<joint name='j'/><joint name='j'/>", Some(2), "DuplicateName"),
    (in_body, "<body euler='1 0 0' quat='1 0 0 0'/>", Some(2), "Both"),
    (in_body, "<body quat='0 0 0 0'/>", Some(2), "Zero"),
    (in_body, "<body zaxis='0 0 0'/>", Some(2), "Zero"),
    (in_body, "<inertial mass='1'/>", Some(2), "MissingAttribute"),
    (in_body, "<inertial pos='0 0 0' mass='-1'/>", Some(2), "Negative"),
    (in_body, "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1' fullinertia='1 1 1 0 0 0'/>", Some(2), "Both"),
    (in_body, "<geom type='box' size='1 0 1'/>", Some(2), "Zero"),
    (in_body, "<geom size='-1'/>", Some(2), "Negative"),
    (in_body, "<geom type='sphere' fromto='0 0 0 0 0 1' size='1'/>", Some(2), "Misplaced"),
    (in_body, "<geom type='capsule' fromto='0 0 1 0 0 1' size='1'/>", Some(2), "Zero"),
    (in_body, "<geom type='mesh' mesh='m'/>", Some(2), "UnknownName"),
    (in_body, "<replicate count='1.5'/>", Some(2), "Misplaced"),
    (whole, "<mujoco><worldbody>\n<joint name='j'/></worldbody></mujoco>", Some(2), "Misplaced"),
    (whole, "<mujoco>\n<compiler coordinate='global'/></mujoco>", Some(2), "Misplaced"),
    (whole, "<mujoco>\n<compiler eulerseq='xyw'/></mujoco>", Some(2), "Misplaced"),
    (whole, "<mujoco><default>\n<default/></default></mujoco>", Some(2), "MissingAttribute"),
    (in_file, "<contact><exclude body1='a' body2='b'/></contact>", Some(2), "UnknownName"),
    (in_file, "<contact><pair geom1='a' geom2='g'/></contact>", Some(2), "UnknownName"),
    (in_file, "<contact><pair geom1='g'/></contact>", Some(2), "MissingAttribute"),
    (in_file, "<contact><pair geom1='g' geom2='g' condim='2'/></contact>", Some(2), "Misplaced"),
    (in_file, "<equality><joint joint1='k'/></equality>", Some(2), "UnknownName"),
    (in_file, "<equality><connect body1='a'/></equality>", Some(2), "MissingAttribute"),
    (in_file, "<tendon><fixed name='t'><joint joint='k' coef='1'/></fixed></tendon>", Some(2), "UnknownName"),
    (in_file, "<tendon><spatial name='t'><site site='s'/></spatial></tendon>", Some(2), "Misplaced"),
    (in_file, "<tendon><spatial><site site='s'/><geom geom='g'/></spatial></tendon>", Some(2), "Misplaced"),
    (in_file, "<tendon><spatial><site site='s'/><geom geom='h'/><site site='s'/></spatial></tendon>", Some(2), "UnknownName"),
    (in_file, "<tendon><spatial><site site='s'/><site site='t'/></spatial></tendon>", Some(2), "UnknownName"),
    (in_file, "<tendon><spatial><site site='s'/><geom geom='g' sidesite='t'/><site site='s'/></spatial></tendon>", Some(2), "UnknownName"),
    (in_file, "<tendon><spatial><pulley divisor='0'/><site site='s'/><site site='s'/></spatial></tendon>", Some(2), "Misplaced"),
    (in_file, "<actuator><motor name='m'/></actuator>", Some(2), "Misplaced"),
    (in_file, "<actuator><motor name='m' tendon='t'/></actuator>", Some(2), "UnknownName"),
    (in_file, "<actuator><position joint='j' inheritrange='1'/></actuator>", Some(2), "Misplaced"),
    (in_file, "<keyframe><key name='k' qpos='1 2'/></keyframe>", Some(2), "WrongCount"),
];

#[test]
fn every_fault_is_refused_with_its_error_alone() {
    for (frame, text, line, name) in FAULTS {
        let refused = parse(&frame(text), &LoadOptions::default()).expect_err(text);
        let [error] = refused.errors() else { panic!("{text}: {refused}") };
        assert_eq!((error.line(), &*variant(error)), (*line, *name), "{text}: {error}");
    }
}

#[test]
fn all_errors_of_a_file_come_at_once_in_the_order_of_lines() {
    let error = parse(THREE, &LoadOptions::default()).expect_err("three");
    let lines: Vec<_> = error.errors().iter().map(robot_dynamics_mjcf::MjcfError::line).collect();
    assert_eq!(lines, [Some(2), Some(3), Some(4)]);
}
