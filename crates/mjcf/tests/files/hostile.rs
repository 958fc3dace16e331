//! Hostile and very large input gives an answer quickly, and never a panic.

use std::fmt::Write as _;
use std::time::Duration;

use robot_dynamics::model::Model;
use robot_dynamics_mjcf::{LoadError, LoadOptions, MjcfError, Robot, parse};

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
    assert!(took < Duration::from_secs(20), "{what} took {took:?}");
    answer
}

/// The only error.
fn only(error: &LoadError) -> &MjcfError {
    let [only] = error.errors() else { panic!("{error}") };
    only
}

/// The only error, which must be one of XML.
fn source(error: &LoadError) -> &robot_dynamics_xml::XmlError {
    let MjcfError::Xml { source, .. } = only(error) else { panic!("{error}") };
    source
}

fn is_too_deep(error: &LoadError) -> bool {
    matches!(source(error), robot_dynamics_xml::XmlError::TooDeep { .. })
}

const BODY: &str = "<joint axis='0 1 0'/><geom size='0.1'/>";

#[test]
fn a_hundred_thousand_nested_bodies_are_refused_and_four_hundred_load() {
    let nested = |count: usize| {
        let open = format!("<body pos='0 0 1'>{BODY}").repeat(count);
        format!("<mujoco><worldbody>{open}{}</worldbody></mujoco>", "</body>".repeat(count))
    };
    let error = quickly("nested bodies", &nested(100_000)).expect_err("too deep");
    assert!(is_too_deep(&error), "{error}");
    let robot = quickly("nested bodies", &nested(400)).expect("a robot");
    assert_eq!(Model::new(robot.description).expect("a model").nv(), 400);
    let frames = format!("<mujoco><worldbody>{}", "<frame>".repeat(100_000));
    assert!(is_too_deep(&quickly("nested frames", &frames).expect_err("too deep")));
    let classes = format!("<mujoco>{}", "<default class='x'>".repeat(100_000));
    assert!(is_too_deep(&quickly("nested classes", &classes).expect_err("too deep")));
}

#[test]
fn a_hundred_thousand_bodies_side_by_side_load() {
    let bodies = format!("<body>{BODY}</body>").repeat(100_000);
    let robot = quickly("many bodies", &format!("<mujoco><worldbody>{bodies}</worldbody></mujoco>"))
        .expect("a robot");
    assert_eq!(robot.report.counts.degrees_of_freedom, 100_000);
}

#[test]
fn many_actuators_equalities_and_keys_take_no_quadratic_work() {
    let count = 20_000;
    let mut text = String::from("<mujoco><worldbody>");
    for i in 0..count {
        let inside = format!("<geom name='g{i}' size='0.1'/><site name='s{i}'/>");
        write!(text, "<body name='b{i}'><joint name='j{i}' range='-1 1'/>{inside}</body>")
            .expect("to a string");
    }
    text += "</worldbody><tendon>";
    for i in 0..count {
        write!(
            text,
            "<spatial><site site='s{i}'/><geom geom='g{i}' sidesite='s0'/><site site='s1'/></spatial>"
        )
        .expect("to a string");
    }
    text += "</tendon><actuator>";
    for i in 0..count {
        write!(text, "<position joint='j{i}'/>").expect("to a string");
    }
    text += "</actuator><equality>";
    for i in 1..count {
        write!(text, "<joint joint1='j{i}' joint2='j0'/>").expect("to a string");
    }
    text += "</equality><contact>";
    for i in 1..count {
        write!(text, "<exclude body1='b{i}' body2='b0'/>").expect("to a string");
    }
    text += "</contact></mujoco>";
    let robot = quickly("many of everything", &text).expect("a robot");
    let description = robot.description;
    assert_eq!((description.actuators.len(), description.equalities.len()), (count, count - 1));
    assert_eq!(description.spatial_tendons.len(), count);
}

#[test]
fn replicates_of_replicates_are_bounded() {
    let open = "<replicate count='1000'>".repeat(10);
    let text = format!("<mujoco><worldbody>{open}<body/>{}</worldbody></mujoco>", "</replicate>".repeat(10));
    let error = quickly("replicates", &text).expect_err("too many");
    assert!(matches!(only(&error), MjcfError::TooMany { .. }), "{error}");
    let empty = format!("<mujoco><worldbody>{open}{}</worldbody></mujoco>", "</replicate>".repeat(10));
    let error = quickly("empty replicates", &empty).expect_err("too many");
    assert!(matches!(only(&error), MjcfError::TooMany { .. }), "{error}");
    // Elements at any depth of a copy are counted.
    let geoms = "<geom size='.1'/>".repeat(10);
    let deep = format!(
        "<mujoco><worldbody><replicate count='500000'><body><freejoint/>{geoms}</body></replicate></worldbody></mujoco>"
    );
    let error = quickly("replicates of many geoms", &deep).expect_err("too many");
    assert!(matches!(only(&error), MjcfError::TooMany { .. }), "{error}");
    for count in ["1e9", "-1", "nan", "1e400", ""] {
        let text =
            format!("<mujoco><worldbody><replicate count='{count}'><body/></replicate></worldbody></mujoco>");
        assert!(quickly(count, &text).is_err(), "{count}");
    }
}

#[test]
fn many_defaults_and_equal_names_take_no_quadratic_work() {
    let geoms = "<geom/>".repeat(100_000);
    let body = "<body><joint/><geom size='0.1'/></body>";
    let text = format!("<mujoco><default>{geoms}</default><worldbody>{body}</worldbody></mujoco>");
    let robot = quickly("defaults of one class", &text).expect("a robot");
    assert_eq!(robot.report.counts.as_written, 99_999);
    let sections = "<default><geom/></default>".repeat(100_000);
    let error =
        quickly("sections of defaults", &format!("<mujoco>{sections}</mujoco>")).expect_err("too many");
    assert!(matches!(error.errors()[0], MjcfError::TooMany { .. }), "{error}");
    let sites = "<site name='s'/>".repeat(100_000);
    let text =
        format!("<mujoco><worldbody><body><joint/><geom size='0.1'/>{sites}</body></worldbody></mujoco>");
    assert_eq!(quickly("sites", &text).expect("a robot").description.frames.len(), 100_000);
}

/// A limit is the first error, although more errors than are listed precede it in the file.
#[test]
fn an_exceeded_limit_is_not_hidden_by_other_errors() {
    let invalid = "<body><joint type='x'/></body>\n".repeat(2000);
    let text = format!(
        "<mujoco><asset><hfield name='h' nrow='10000' ncol='10000' size='1 1 1 1'/></asset>
         <worldbody>\n{invalid}<geom type='hfield' hfield='h'/></worldbody></mujoco>"
    );
    let error = quickly("many errors", &text).expect_err("too many");
    assert!(error.unlisted() > 0);
    assert!(matches!(error.errors()[0], MjcfError::TooMany { .. }), "{error}");
}

#[test]
fn entities_do_not_expand() {
    let mut bomb = String::from("<!DOCTYPE mujoco [<!ENTITY e0 \"ha\">");
    for i in 0..30 {
        write!(bomb, "<!ENTITY e{} \"&e{i};&e{i};\">", i + 1).expect("to a string");
    }
    let error = quickly("an entity bomb", &(bomb + "]><mujoco model=\"&e30;\"/>")).expect_err("a bomb");
    assert!(matches!(source(&error), robot_dynamics_xml::XmlError::DocumentType { line: 1 }), "{error}");
}

#[test]
fn many_attributes_are_refused() {
    let attributes: String = (0..100_000).fold(String::new(), |text, i| text + &format!(" a{i}=''"));
    let error = quickly("attributes", &format!("<mujoco{attributes}/>")).expect_err("too many");
    assert!(matches!(source(&error), robot_dynamics_xml::XmlError::TooMany { .. }), "{error}");
}

#[test]
fn long_texts_make_short_messages() {
    let long = "x".repeat(1_000_000);
    for text in [
        format!("<mujoco><worldbody><body name='{long}'/><body name='{long}'/></worldbody></mujoco>"),
        format!("<mujoco><worldbody><body name='{long}'><joint type='{long}'/></body></worldbody></mujoco>"),
        format!("<mujoco><worldbody><body pos='{long}'/></worldbody></mujoco>"),
        format!("<mujoco><worldbody><body childclass='{long}'/></worldbody></mujoco>"),
        format!("<mujoco><contact><exclude body1='{long}' body2='world'/></contact></mujoco>"),
        format!("<mujoco><include file='{long}'/></mujoco>"),
        format!("<{long}/>"),
    ] {
        let error = quickly("a long text", &text).expect_err("wrong").to_string();
        assert!(error.chars().count() < 1000, "a message of {} characters", error.chars().count());
    }
}

#[test]
fn many_unknown_elements_are_listed() {
    let text = format!("<mujoco>{}</mujoco>", "<a/>".repeat(250_000));
    assert_eq!(quickly("unknown elements", &text).expect("a robot").report.counts.ignored_physics, 250_000);
}

#[test]
fn extreme_numbers_are_refused_or_read() {
    for number in ["1e30", "-1e30", "1e-320", "-0", "1e29", "5e-324", "1e200", "inf", "nan"] {
        for body in [
            format!("<inertial pos='{number} 0 0' mass='1' diaginertia='1 1 1'/>"),
            format!("<inertial pos='0 0 0' mass='{number}' diaginertia='1 1 1'/>"),
            format!("<inertial pos='0 0 0' mass='1' fullinertia='1 1 1 {number} 0 0'/>"),
            format!("<geom size='{number}'/>"),
            format!("<geom type='box' size='1 {number} 1'/>"),
            format!("<geom type='ellipsoid' shellinertia='true' size='1 {number} 1'/>"),
            format!("<geom size='1' mass='{number}'/>"),
            format!("<geom size='1' density='{number}' pos='{number} 0 0'/>"),
            format!("<geom type='capsule' size='1' fromto='0 0 {number} 0 0 1'/>"),
            format!(
                "<geom size='1'/><joint name='k' axis='{number} 0 1' pos='{number} 0 0' ref='{number}'/>"
            ),
            format!(
                "<geom size='1'/><body euler='{number} 0 0' pos='0 {number} 0'><joint/><geom size='1'/></body>"
            ),
            format!("<geom size='1'/><joint springdamper='{number} 1'/>"),
        ] {
            let text = format!("<mujoco><worldbody><body><joint/>{body}</body></worldbody></mujoco>");
            if let Ok(robot) = quickly(&body, &text) {
                for body in robot.description.links.iter().filter_map(|link| link.mass_properties) {
                    let inertia = body.inertia_about_center_of_mass();
                    assert!(
                        inertia.iter().all(|x| x.is_finite()) && body.mass().is_finite(),
                        "{text}: {inertia}"
                    );
                }
                let _ = Model::new(robot.description);
            }
        }
    }
}

/// Meshes in the file with too few points, or with faces of missing points.
#[test]
fn broken_meshes_are_refused() {
    for mesh in [
        "vertex='0 0 0'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 4'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 -1'",
        "vertex='0 0 0 1 0 0 0 1 0 1 1 0'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 2 0 3 1 0 2 3 1 3 2' inertia='exact'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' refquat='0 0 0 0'",
        "vertex='0 0 0 1 0 0 0 1 0 0 0 1' scale='0 1 1'",
        "builtin='sphere' params='7'",
        "file='x.stl'",
        "",
    ] {
        let text = format!(
            "<mujoco><asset><mesh name='m' {mesh}/></asset><worldbody><body><joint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
        );
        let error = quickly(mesh, &text).expect_err(mesh);
        assert!(
            error.errors().iter().any(|error| matches!(error, MjcfError::Mesh { .. })),
            "{mesh}: {error}"
        );
    }
}

/// The limit that was exceeded.
fn exceeded(error: &LoadError) -> &'static str {
    let found = error.errors().iter().find_map(|error| match error {
        MjcfError::TooMany { what, .. } => Some(*what),
        _ => None,
    });
    found.unwrap_or_else(|| panic!("{error}"))
}

/// All steps of reading charge the same limits, so that a small file cannot fill the memory.
#[test]
fn small_files_that_grow_are_refused_by_the_limit_that_they_exceed() {
    let long = "x".repeat(20_000);
    let world = |content: &str| format!("<mujoco><worldbody>{content}</worldbody></mujoco>");
    let nested = |depth: usize, content: &str| {
        let open = "<replicate count='10'>".repeat(depth);
        format!("{open}{content}{}", "</replicate>".repeat(depth))
    };
    let attached: Vec<String> = (0..300).map(|k| format!("<attach body='b' prefix='{k}_{long}'/>")).collect();
    let attached = attached.concat();
    let parts: Vec<String> = (0..100).map(|k| format!("<site name='s{k}'/>")).collect();
    let parts = parts.concat();
    let joints = "<body><joint/><geom size='0.1'/></body>".repeat(5000);
    let list = "1 ".repeat(50_000);
    let geoms = "<geom size='0.1'/>".repeat(5000);
    let pole = "<body><freejoint/><geom size='0.1'/></body>";
    for (what, text, limit) in [
        ("nested replicates", world(&nested(8, pole)), "elements"),
        ("a long name", world(&format!("<replicate count='50000'><body name='{long}'/></replicate>")), "characters"),
        ("a long separator", world(&format!("<replicate count='50000' sep='{long}'><body/></replicate>")), "characters"),
        (
            "a long name of a tendon",
            format!(
                "<mujoco><worldbody><replicate count='50000'><body><joint name='j'/></body></replicate></worldbody>
                   <tendon><fixed name='{long}'><joint joint='j' coef='1'/></fixed></tendon></mujoco>"
            ),
            "characters",
        ),
        ("long prefixes", world(&format!("<body name='b'>{parts}</body>{attached}")), "characters"),
        (
            "a large height field",
            "<mujoco><asset><hfield name='h' size='1 1 1 1' nrow='100000' ncol='100000'/></asset>
               <worldbody><geom type='hfield' hfield='h'/></worldbody></mujoco>"
                .to_owned(),
            "numbers",
        ),
        (
            "many geoms with a height field",
            "<mujoco><asset><hfield name='h' size='1 1 1 1' nrow='1000' ncol='1000'/></asset>
               <worldbody><replicate count='1000'><geom type='hfield' hfield='h'/></replicate></worldbody></mujoco>"
                .to_owned(),
            "numbers",
        ),
        (
            "empty keys",
            format!("<mujoco><worldbody>{joints}</worldbody><keyframe>{}</keyframe></mujoco>", "<key/>".repeat(20_000)),
            "numbers",
        ),
        (
            "a long list in a default",
            format!("<mujoco><default><geom friction='{list}'/></default><worldbody>{geoms}</worldbody></mujoco>"),
            "numbers",
        ),
        ("many written elements", world(&"<a/>".repeat(1_000_001)), "elements"),
    ] {
        let error = quickly(what, &text).expect_err(what);
        if what == "many written elements" {
            let robot_dynamics_xml::XmlError::TooMany { what: found, .. } = source(&error) else { panic!("{error}") };
            assert!(found.starts_with(limit), "{what}: {found}");
        } else {
            assert!(exceeded(&error).starts_with(limit), "{what}: {error}");
        }
    }
}

/// The limits admit 10⁵ bodies, whether they are written or replicated.
#[test]
fn a_hundred_thousand_replicated_bodies_load() {
    let body = "<body name='a'><joint name='j'/><geom name='g' size='0.1'/><site name='s'/></body>";
    let text =
        format!("<mujoco><worldbody><replicate count='100000'>{body}</replicate></worldbody></mujoco>");
    let robot = quickly("replicated bodies", &text).expect("a robot");
    assert_eq!(robot.report.counts.degrees_of_freedom, 100_000);
}
