//! Hostile and very large input gives an answer quickly, and never a panic.

use std::fmt::Write as _;
use std::time::Duration;

use robot_dynamics::urdf::{LoadError, LoadOptions, Robot, UrdfError, load, parse};

/// The processor time of this thread, which does not depend on the load of the machine; zero if the system
/// does not provide it.
fn processor_time() -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    Duration::from_nanos(text.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or(0))
}

/// Parses a text and bounds the time. Each case takes well under a second; quadratic work would take minutes
/// at these sizes.
fn quickly(what: &str, text: &str) -> Result<Robot, LoadError> {
    let start = processor_time();
    let answer = parse(text, &LoadOptions::default());
    let took = processor_time().saturating_sub(start);
    assert!(took < Duration::from_secs(10), "{what} took {took:?}");
    answer
}

/// The only error.
fn only(error: &LoadError) -> &UrdfError {
    let [only] = error.errors() else { panic!("{error}") };
    only
}

const BODY: &str = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#;

/// A chain of revolute joints, in reverse order if `backwards`; `inside` is the content of joint i.
fn chain(joints: usize, backwards: bool, inside: impl Fn(usize) -> String) -> String {
    let mut text = String::from("<robot name=\"chain\">\n<link name=\"l0\"/>\n");
    for i in 0..joints {
        let i = if backwards { joints - 1 - i } else { i };
        let child = i + 1;
        let inside = inside(i);
        writeln!(
            text,
            r#"<link name="l{child}">{BODY}</link><joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{child}"/>{inside}</joint>"#
        )
        .expect("to a string");
    }
    text + "</robot>"
}

/// No content in a joint.
fn bare(_: usize) -> String {
    String::new()
}

#[test]
fn a_chain_of_a_hundred_thousand_joints_loads() {
    for backwards in [false, true] {
        let robot = quickly("a long chain", &chain(100_000, backwards, bare)).expect("a robot");
        assert_eq!(robot.report.counts.degrees_of_freedom, 100_000);
    }
}

#[test]
fn a_hundred_thousand_mimic_joints_load_unless_they_form_a_cycle() {
    for backwards in [false, true] {
        let follow = |i: usize| if i == 0 { String::new() } else { format!("<mimic joint=\"j{}\"/>", i - 1) };
        let robot = quickly("many followers", &chain(100_000, backwards, follow)).expect("a robot");
        assert_eq!(robot.report.counts.degrees_of_freedom, 1);
        let ring = |i: usize| format!("<mimic joint=\"j{}\"/>", (i + 99_999) % 100_000);
        let error = quickly("a ring of followers", &chain(100_000, backwards, ring)).expect_err("a ring");
        // Ten names, and the number of the others.
        assert!(
            matches!(only(&error), UrdfError::MimicCycle { joints, .. } if joints.len() == 11),
            "{error}"
        );
    }
}

#[test]
fn a_cycle_of_a_hundred_thousand_joints_is_refused() {
    let text = chain(100_000, false, bare).replace(
        "</robot>",
        r#"<joint name="back" type="fixed"><parent link="l100000"/><child link="l0"/></joint></robot>"#,
    );
    let error = quickly("a ring", &text).expect_err("a cycle");
    assert!(matches!(only(&error), UrdfError::Cycle { joints, .. } if joints.len() == 11), "{error}");
}

#[test]
fn an_ordinary_megabyte_loads() {
    let text = chain(5_500, false, bare);
    assert!(text.len() > 1_000_000, "{} bytes", text.len());
    quickly("a megabyte", &text).expect("a robot");
}

#[test]
fn a_hundred_thousand_nested_elements_are_refused() {
    for inner in ["<a>", "<link name='x'>", "<a b='>'>", "<a b=\"</a>\">"] {
        let text = format!("<robot name='r'>\n{}", inner.repeat(100_000));
        let error = quickly("nested elements", &text).expect_err("too deep");
        assert!(matches!(only(&error), UrdfError::TooDeep { line: 2, .. }), "{error}");
    }
    // Comments and CDATA are not nesting levels.
    let text =
        format!("<robot name='r'><link name='a'/>{}</robot>", "<!--<a>--><![CDATA[<b>]]>".repeat(1000));
    quickly("comments", &text).expect("a robot");
}

#[test]
fn many_attributes_and_namespaces_are_refused() {
    let attributes: String = (0..100_000).fold(String::new(), |text, i| text + &format!(" a{i}=''"));
    let error = quickly("attributes", &format!("<robot{attributes}/>")).expect_err("too many");
    assert!(matches!(only(&error), UrdfError::TooMany { .. }), "{error}");
    let namespaces: String =
        (0..20_000).fold(String::new(), |text, i| text + &format!("<a xmlns:n{i}  = 'u{i}'>"));
    let error = quickly("namespaces", &format!("<robot name='r'>{namespaces}")).expect_err("too many");
    assert!(matches!(only(&error), UrdfError::TooMany { .. }), "{error}");
}

#[test]
fn entities_do_not_expand() {
    let mut bomb = String::from("<!DOCTYPE robot [<!ENTITY e0 \"ha\">");
    for i in 0..30 {
        write!(bomb, "<!ENTITY e{} \"&e{i};&e{i};\">", i + 1).expect("to a string");
    }
    let error = quickly("an entity bomb", &(bomb + "]><robot name=\"&e30;\"/>")).expect_err("a bomb");
    assert!(matches!(only(&error), UrdfError::DocumentType { line: 1 }), "{error}");
    let error = quickly("an external entity", "<!DOCTYPE r SYSTEM \"file:///etc/passwd\"><robot/>")
        .expect_err("a DTD");
    assert!(matches!(only(&error), UrdfError::DocumentType { line: 1 }), "{error}");
}

#[test]
fn long_texts_make_short_messages() {
    let long = "x".repeat(1_000_000);
    for text in [
        format!("<robot name='r'><link name='a'><inertial><mass value='{long}'/></inertial></link></robot>"),
        format!("<robot name='r'><joint name='{long}' type='hinge'/></robot>"),
        format!("<robot name='r'><link name='{long}'/><link name='{long}'/></robot>"),
        format!("<{long}/>"),
        format!("<robot name='&{long};'/>"),
        format!(
            "<robot name='r'><link name='a'/><joint name='j' type='{long}'><parent link='a'/><child link='{long}'/></joint></robot>"
        ),
    ] {
        let error = quickly("a long text", &text).expect_err("wrong").to_string();
        assert!(error.chars().count() < 1000, "a message of {} characters", error.chars().count());
    }
}

#[test]
fn many_unknown_elements_are_listed() {
    let text = format!("<robot name='r'><link name='a'/>{}</robot>", "<a/>".repeat(250_000));
    assert_eq!(quickly("unknown elements", &text).expect("a robot").report.counts.ignored, 250_000);
}

#[test]
fn extreme_numbers_are_refused_or_read() {
    for number in ["1e30", "-1e30", "1e-320", "-0", "1e29", "5e-324", "123456789012345678901234567890"] {
        for (attribute, file) in [
            ("ixx", format!(r#"<mass value="1"/><inertia ixx="{number}" iyy="1" izz="1"/>"#)),
            ("ixy", format!(r#"<mass value="1"/><inertia ixx="1" ixy="{number}" iyy="1" izz="1"/>"#)),
            (
                "all",
                format!(r#"<mass value="{number}"/><inertia ixx="{number}" iyy="{number}" izz="{number}"/>"#),
            ),
            (
                "rpy",
                format!(r#"<origin rpy="{number} 1 2"/><mass value="1"/><inertia ixx="1" iyy="2" izz="2"/>"#),
            ),
        ] {
            let text = format!("<robot name='r'><link name='a'><inertial>{file}</inertial></link></robot>");
            if let Ok(robot) = quickly(&format!("{attribute} = {number}"), &text) {
                for body in robot.description.links.iter().filter_map(|link| link.mass_properties) {
                    let inertia = body.inertia_about_center_of_mass();
                    assert!(inertia.iter().all(|x| x.is_finite()), "{attribute} = {number}: {inertia}");
                }
            }
        }
    }
}

#[test]
fn missing_and_binary_files_are_refused() {
    let folder = std::env::temp_dir().join(format!("urdf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let options = LoadOptions::default();
    assert!(matches!(
        only(&load(folder.join("missing.urdf"), &options).expect_err("no robot")),
        UrdfError::Unreadable { .. }
    ));
    assert!(matches!(only(&load(&folder, &options).expect_err("no robot")), UrdfError::Unreadable { .. }));
    let binary = folder.join("binary.urdf");
    std::fs::write(&binary, [b'<', b'r', 0xff, 0x00, 0x80]).expect("a file");
    assert!(matches!(
        only(&load(&binary, &options).expect_err("no robot")),
        UrdfError::NotText { byte: 2, .. }
    ));
    let large = folder.join("large.urdf");
    std::fs::write(&large, " ".repeat(robot_dynamics::urdf::SIZE_LIMIT + 1)).expect("a file");
    assert!(matches!(only(&load(&large, &options).expect_err("no robot")), UrdfError::TooLarge { .. }));
    std::fs::remove_dir_all(&folder).expect("the folder");
}
