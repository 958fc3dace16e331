//! One pass lists all errors of a file, without errors that only follow from others.

use robot_dynamics::urdf::{LoadOptions, Severity, parse};

use crate::malformed::variant;

/// A file with errors, from line 2 on.
pub(crate) const FILE: &str = r#"<robot name="r">
  <link name="a"><inertial><mass value="one"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="a"/>
  <link/>
  <link name="b"><inertial><origin xyz="0 0"/><mass value="-1"/>
    <inertia ixx="nan" iyy="1"/></inertial></link>
  <link name="c"><inertial><origin rpy="0 0,5 0"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1e40"/></inertial></link>
  <link name="d"/><link name="e"/><link name="f"/>
  <joint name="j1" type="hinge"><parent link="a"/><child link="b"/></joint>
  <joint name="j1" type="fixed"><parent link="a"/><child link="c"/></joint>
  <joint name="j2" type="revolute"><parent link="nowhere"/><child link="d"/><axis xyz="0 0 0"/></joint>
  <joint name="j3" type="continuous"><parent link="e"/><child link="e"/><dynamics damping="inf"/></joint>
  <joint name="j4" type="continuous"><parent link="a"/><child link="c"/><mimic joint="nobody"/></joint>
  <joint name="j5" type="continuous"><parent link="e"/><child link="f"/><mimic joint="j5"/></joint>
  <joint name="j6" type="revolute"><parent link="f"/><child link="e"/><limit lower="0" upper="high"/></joint>
  <joint type="fixed"><child link="f"/></joint>
</robot>"#;

/// Line and variant of each error, in order.
#[rustfmt::skip]
const ERRORS: &[(usize, &str)] = &[
    (2, "NotANumber"),
    (3, "DuplicateName"),
    (4, "MissingAttribute"),
    (5, "WrongCount"),
    (5, "Negative"),
    (6, "NotFinite"),
    (6, "MissingAttribute"),
    (7, "NotANumber"),
    (7, "TooBig"),
    (9, "UnknownJointType"),
    (10, "DuplicateName"),
    (11, "ZeroAxis"),
    (11, "UnknownLink"),
    (12, "NotFinite"),
    (12, "SelfParent"),
    (13, "TwoParents"),
    (13, "UnknownMimic"),
    (14, "Cycle"),
    (14, "MimicCycle"),
    (15, "NotANumber"),
    (16, "MissingAttribute"),
    (16, "MissingElement"),
];

#[test]
fn every_error_is_found_in_one_pass() {
    let refused = parse(FILE, &LoadOptions::default()).expect_err("errors");
    let found: Vec<String> = refused.errors().iter().map(ToString::to_string).collect();
    let listing = found.join("\n");
    assert_eq!(found.len(), ERRORS.len(), "{listing}");
    for ((line, name), error) in ERRORS.iter().zip(refused.errors()) {
        assert_eq!((error.line(), &*variant(error)), (Some(*line), *name), "{listing}");
        assert_eq!(error.severity(), Severity::Error);
        assert!(error.place().is_some_and(|place| !place.is_empty()), "{error}");
    }
    assert_eq!(refused.to_string().lines().count(), ERRORS.len() + 1);
}

/// Each correction removes its own error and adds no other.
#[test]
fn errors_are_independent() {
    let refused = parse(FILE, &LoadOptions::default()).expect_err("errors").errors().len();
    for (wrong, right, fewer) in [
        ("value=\"one\"", "value=\"1\"", 1),
        ("hinge", "fixed", 1),
        ("nowhere", "c", 1),
        ("value=\"-1\"", "value=\"1\"", 1),
        ("0 0,5 0", "0 0.5 0", 1),
        ("high", "1", 1),
        ("<axis xyz=\"0 0 0\"/>", "", 1),
    ] {
        let text = FILE.replace(wrong, right);
        assert_ne!(text, FILE);
        let left = parse(&text, &LoadOptions::default()).expect_err("the others").errors().len();
        assert_eq!(left, refused - fewer, "{wrong} -> {right}");
    }
}

#[test]
fn the_first_thousand_errors_are_listed() {
    let text = format!("<robot name=\"r\">{}</robot>", "<link/>".repeat(1500));
    let refused = parse(&text, &LoadOptions::default()).expect_err("errors");
    assert_eq!((refused.errors().len(), refused.unlisted()), (1000, 500));
}

/// A strict reading lists warnings with the errors.
#[test]
fn strict_reading_collects_warnings_too() {
    let text =
        r#"<robot><link name="a"><inertial><mass value="1"/></inertial></link><link name="a"/></robot>"#;
    let refused = parse(text, &LoadOptions::default().with_strict()).expect_err("errors");
    // A missing name, a missing inertia, and a repeated name.
    assert_eq!(refused.errors().len(), 3, "{refused}");
}
