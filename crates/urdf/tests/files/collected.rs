//! All errors of a file at once: twenty mistakes, twenty complaints, none of them made up.

use urdf::{Options, Severity, parse};

/// One mistake a line, from line 2 on; lines without one say so.
const FILE: &str = r#"<robot name="r">
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

/// Line and a word of each error, in order.
#[rustfmt::skip]
const ERRORS: &[(usize, &str)] = &[
    (2, r#"value="one" is not a number"#),
    (3, r#"link "a" is already defined on line 2"#),
    (4, "the attribute `name` is missing"),
    (5, "holds 2 numbers, not 3"),
    (5, "value=-1 is negative"),
    (6, r#"ixx="nan" is not a finite number"#),
    (6, "the attribute `izz` is missing"),
    (7, r#"rpy="0 0,5 0" is not a number; it has a comma"#),
    (7, "beyond 1e30"),
    (9, r#"the type "hinge" is unknown"#),
    (10, r#"joint "j1" is already defined on line 9"#),
    (11, "the axis is zero"),
    (11, r#"its parent link "nowhere" does not exist"#),
    (12, r#"damping="inf" is not a finite number"#),
    (12, r#"joins link "e" to itself"#),
    (13, r#"link "c" is the child of joint "j4", but already of joint "j1""#),
    (13, r#"mimics "nobody", which does not exist"#),
    (14, r#"the joints "j5" → "j6" form a cycle"#),
    (14, r#"the joints "j5" → "j5" mimic each other in a ring"#),
    (15, r#"upper="high" is not a number"#),
    (16, "the attribute `name` is missing"),
    (16, "the element <parent> is missing"),
];

#[test]
fn every_error_is_found_in_one_pass() {
    let refused = parse(FILE, &Options::default()).expect_err("errors");
    let found: Vec<String> = refused.errors().iter().map(ToString::to_string).collect();
    let listing = found.join("\n");
    assert_eq!(found.len(), ERRORS.len(), "{listing}");
    for ((line, words), error) in ERRORS.iter().zip(refused.errors()) {
        assert_eq!(error.line(), Some(*line), "{words}:\n{listing}");
        assert_eq!(error.severity(), Severity::Error);
        assert!(error.place().is_some_and(|place| !place.is_empty()), "{error}");
        assert!(error.to_string().contains(words), "expected {words:?} on line {line}:\n{listing}");
        assert!(error.to_string().starts_with(&format!("line {line}: ")), "{error}");
    }
    let text = refused.to_string();
    assert_eq!(text.lines().next(), Some(format!("{} errors", ERRORS.len()).as_str()));
    assert_eq!(text.lines().count(), ERRORS.len() + 1);
}

/// Each mistake mended in turn takes its own complaint away and brings no other.
#[test]
fn no_error_is_made_up_by_another() {
    let refused = parse(FILE, &Options::default()).expect_err("errors").errors().len();
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
        let left = parse(&text, &Options::default()).expect_err("the others").errors().len();
        assert_eq!(left, refused - fewer, "{wrong} -> {right}");
    }
}

#[test]
fn masses_of_errors_are_counted_and_the_first_thousand_listed() {
    let text = format!("<robot name=\"r\">{}</robot>", "<link/>".repeat(1500));
    let refused = parse(&text, &Options::default()).expect_err("errors");
    assert_eq!((refused.errors().len(), refused.unlisted()), (1000, 500));
    assert!(refused.to_string().ends_with("and 500 more"));
}

/// A strict reading lists warnings among the errors.
#[test]
fn strict_reading_collects_warnings_too() {
    let text =
        r#"<robot><link name="a"><inertial><mass value="1"/></inertial></link><link name="a"/></robot>"#;
    let refused = parse(text, &Options::default().with_strict()).expect_err("errors");
    // No name, no inertia, and a name twice.
    assert_eq!(refused.errors().len(), 3, "{refused}");
}
