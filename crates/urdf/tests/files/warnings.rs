//! Suspicious files: loaded exactly as written, each with a warning that says what, by how much, and what to do;
//! refused only by a strict reading.

use multibody::{Base, Model};
use nalgebra::{Matrix3, Rotation3, Vector3};
use urdf::{Options, Robot, Severity, Treatment, UrdfError, parse};

fn read(text: &str) -> Robot {
    parse(text, &Options::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The text stands in the inertial of link `a`, from line 2.
fn in_inertial(text: &str) -> String {
    format!("<robot name=\"r\"><link name=\"a\"><inertial>\n{text}\n</inertial></link></robot>")
}

/// The text stands in a revolute joint `j` between two bodies, from line 2.
fn in_joint(text: &str) -> String {
    let body = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    format!(
        "<robot name=\"r\"><link name=\"a\">{body}</link><link name=\"b\">{body}</link>\
         <joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/>\n{text}\n</joint></robot>"
    )
}

fn whole(text: &str) -> String {
    text.to_owned()
}

type Frame = fn(&str) -> String;

/// How the text is framed, the text, line, place and message of its warning.
#[rustfmt::skip]
const WARNINGS: &[(Frame, &str, usize, &str, &str)] = &[
    (in_inertial, r#"<mass value="1"/><inertia ixx="1" iyy="1" izz="3"/>"#, 1, r#"link "a"/inertial"#,
     "the principal moments 1, 1, 3 kg·m² break the triangle inequality: the largest exceeds the sum of the others by 1; check the units and whether the inertia is about the centre of mass; taken as written: correct it, or repair it on loading"),
    (in_inertial, r#"<mass value="1"/><inertia ixx="-1" iyy="1" izz="1"/>"#, 1, r#"link "a"/inertial"#,
     "a principal moment is negative: -1, 1, 1 kg·m²; no mass distribution has it; taken as written: correct it, or repair it on loading"),
    (in_inertial, r#"<mass value="0"/><inertia ixx="1" iyy="1" izz="1"/>"#, 1, r#"link "a"/inertial"#,
     "the mass is 0 but the inertia is not: moments 1, 1, 1; taken as written: give the mass, or zero both, or repair it on loading"),
    (in_inertial, r#"<mass value="2"/>"#, 1, r#"link "a"/inertial"#,
     "no <inertia>: taken as a point mass of 2 kg; give its moments, all zero if it is meant so"),
    (in_inertial, r#"<mass value="1"/><inertia ixx="1" iyy="1" izz="1"/><mass value="2"/>"#, 2, r#"link "a"/inertial/mass"#,
     "a second <mass>; the first, on line 2, counts; delete one of them"),
    (in_inertial, r#"<origin xyz="1 0 0"/><origin xyz="2 0 0"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#, 2, r#"link "a"/inertial/origin"#,
     "a second <origin>; the first, on line 2, counts; delete one of them"),
    (in_inertial, "<mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>\n<inertial>", 3, r#"link "a"/inertial"#,
     "a second <inertial>; the first, on line 1, counts; delete one of them"),
    (in_joint, "<axis xyz=\"0 0 1\"/>\n<axis xyz=\"0 1 0\"/>", 3, r#"joint "j"/axis"#,
     "a second <axis>; the first, on line 2, counts; delete one of them"),
    (in_joint, "<limit upper=\"1\"/>\n<limit upper=\"2\"/>", 3, r#"joint "j"/limit"#,
     "a second <limit>; the first, on line 2, counts; delete one of them"),
    (in_joint, r#"<limit lower="1" upper="-1"/>"#, 2, r#"joint "j"/limit"#,
     "the lower limit 1 is above the upper limit -1: taken as written, no position is within them; exchange or correct them"),
    (in_joint, r#"<limit lower="1"/>"#, 2, r#"joint "j"/limit"#,
     "the lower limit 1 is above the upper limit 0 (upper is missing, and URDF takes 0 for it): taken as written, no position is within them; exchange or correct them"),
    (in_joint, r#"<limit effort="0"/>"#, 2, r#"joint "j"/limit"#,
     r#"effort="0": taken as written, the motor can give no force; leave it out if there is no bound"#),
    (in_joint, r#"<limit velocity="0"/>"#, 2, r#"joint "j"/limit"#,
     r#"velocity="0": taken as written, the joint may not move; leave it out if there is no bound"#),
    (in_joint, r#"<limit effort="-3"/>"#, 2, r#"joint "j"/limit"#,
     "effort=-3 is negative, but bounds an absolute value: taken as 3; correct it"),
    (in_joint, r#"<dynamics damping="-0.1"/>"#, 2, r#"joint "j"/dynamics"#,
     "damping=-0.1 is negative: taken as written, it adds energy to the motion; correct its sign"),
    (in_joint, r#"<dynamics stiffness="-5"/>"#, 2, r#"joint "j"/dynamics"#,
     "stiffness=-5 is negative: taken as written, this spring pushes away from its rest; correct its sign"),
    (whole, r#"<robot><link name="a"/></robot>"#, 1, "robot",
     r#"no name: taken as "robot"; write <robot name="NAME">"#),
    (whole, "<robot name=\"r\"><link name=\"a\"/>\n<drake:joint name=\"x\"/></robot>", 2, "robot",
     r#"the prefix `drake:` is not declared: taken as one of another program; add xmlns:drake="…" to <robot>"#),
    (whole, "<?xml version=\"1.0\"?><!-- <a> -->\n<ns0:robot name=\"r\"><ns0:link name=\"a\"/></ns0:robot>", 2, "robot",
     r#"the prefix `ns0:` is not declared: taken as one of another program; add xmlns:ns0="…" to <robot>"#),
    (whole, "\n<!-- made by hand --><?xml version=\"1.0\"?>\n<robot name=\"r\"><link name=\"a\"/></robot>", 2, "robot",
     "<?xml … ?> is not at the start of the file: not read; move it to the first byte, or delete it"),
    (whole, "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link><joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint>\n<xacro:wheel side=\"left\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"/></robot>", 2, "robot/wheel",
     "an unprocessed xacro instruction: what it would add is missing; run `xacro FILE > robot.urdf` and load that"),
    (whole, "<robot name=\"r\"><link name=\"world\"/>\n<link name=\"stray\"/></robot>", 2, r#"link "stray""#,
     "one of 2 links that no joint carries: each is fixed to the world where its frame is; connect them by joints if they belong together"),
    (whole, "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/>\n<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint></robot>", 2, r#"joint "j""#,
     r#"moves link "b", but no link from there on has mass: any force means infinite acceleration, and whatever needs the inverse of the mass matrix is refused; give "b" an <inertial>, or lock the joint"#),
];

#[test]
fn every_suspicious_file_loads_with_its_warning_alone() {
    for (frame, text, line, place, message) in WARNINGS {
        let file = frame(text);
        let robot = read(&file);
        let found: Vec<_> =
            robot.report.warnings().map(|w| (w.line(), w.place(), w.severity(), w.message())).collect();
        assert_eq!(found, [(*line, *place, Severity::Warning, *message)], "{text}");
        assert_eq!(robot.report.counts.warnings, 1, "{text}");
        let refused = parse(&file, &Options::default().with_strict()).expect_err("a warning");
        let strict = format!(
            "line {line}: {place}: {message} (a warning, which strict reading refuses; correct it or do not be strict)"
        );
        assert_eq!(refused.to_string(), strict, "{text}");
        assert!(matches!(refused.errors(), [UrdfError::Strict { .. }]));
    }
}

/// Taken as written means: the numbers of the file are the numbers of the model.
#[test]
fn suspicious_values_reach_the_model_as_they_are() {
    let mass_properties = |text: &str| read(&in_inertial(text)).description.links[0].mass_properties;
    let moments = |text: &str| {
        mass_properties(text).expect("inertia").inertia_about_center_of_mass().diagonal().as_slice().to_vec()
    };
    assert_eq!(moments(r#"<mass value="1"/><inertia ixx="1" iyy="1" izz="3"/>"#), [1.0, 1.0, 3.0]);
    assert_eq!(moments(r#"<mass value="1"/><inertia ixx="-1" iyy="1" izz="1"/>"#), [-1.0, 1.0, 1.0]);
    assert_eq!(moments(r#"<mass value="0"/><inertia ixx="1" iyy="2" izz="2"/>"#), [1.0, 2.0, 2.0]);
    assert_eq!(moments(r#"<inertia ixx="1" iyy="2" izz="2"/>"#), [1.0, 2.0, 2.0]);
    let point = mass_properties(r#"<origin xyz="1 2 3"/><mass value="2"/>"#).expect("mass");
    assert_eq!((point.mass(), point.center_of_mass()), (2.0, Vector3::new(1.0, 2.0, 3.0)));
    assert_eq!(point.inertia_about_center_of_mass(), Matrix3::zeros());
    let first = mass_properties(
        r#"<origin xyz="1 0 0"/><origin xyz="2 0 0"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/><mass value="9"/>"#,
    );
    assert_eq!(first.map(|body| (body.mass(), body.center_of_mass().x)), Some((1.0, 1.0)));

    let joint = |text: &str| read(&in_joint(text)).description.joints[0].clone();
    let reversed = joint(r#"<limit lower="1" upper="-1" effort="0"/><dynamics damping="-0.1"/>"#);
    assert_eq!((reversed.limits.lower, reversed.limits.upper, reversed.limits.effort), (1.0, -1.0, 0.0));
    assert_eq!(reversed.passive.damping, -0.1);
    // Infinite bounds are bounds, and no reason for a warning.
    let unbounded = read(&in_joint(r#"<limit lower="-inf" upper="inf" effort="INF" velocity="1e400"/>"#));
    let limits = unbounded.description.joints[0].limits;
    assert_eq!((limits.lower, limits.upper), (f64::NEG_INFINITY, f64::INFINITY));
    assert_eq!((limits.effort, limits.velocity), (f64::INFINITY, f64::INFINITY));
    assert_eq!(unbounded.report.counts.warnings, 0, "{}", unbounded.report);
    // Every one of them compiles to a model.
    for (frame, text, ..) in WARNINGS {
        if !text.contains("\"continuous\"") {
            Model::new(read(&frame(text)).description).unwrap_or_else(|error| panic!("{error}: {text}"));
        }
    }
}

/// Moments that miss the laws by what rounding leaves are no finding, and repair leaves them alone.
#[test]
fn noise_is_not_reported() {
    for inertia in [
        r#"ixx="-5.42e-20" iyy="-5.42e-20" izz="0""#,
        r#"ixx="2.71e-20" ixy="-1.69e-21" ixz="1.36e-20" iyy="5.42e-20" iyz="3.39e-21" izz="1.36e-20""#,
        r#"ixx="1" iyy="1" izz="2.0000005""#,
    ] {
        let text =
            in_inertial(&format!(r#"<origin xyz="0 0 0.03"/><mass value="0.5"/><inertia {inertia}/>"#));
        let robot = read(&text);
        assert_eq!(robot.report.counts.warnings, 0, "{}", robot.report);
        let repaired = parse(&text, &Options::default().with_repaired_inertia()).expect("a robot");
        assert_eq!(repaired, robot);
    }
    // 1e-9 of m·size² is the border; size is the distance of the centre of mass here.
    for (moment, warnings) in [("-1.1e-9", 1), ("-0.9e-9", 0)] {
        let text = in_inertial(&format!(
            r#"<origin xyz="1 0 0"/><mass value="1"/><inertia ixx="{moment}" iyy="0" izz="0"/>"#
        ));
        assert_eq!(read(&text).report.counts.warnings, warnings, "{moment}");
    }
}

/// The moment at fault is moved, the others stay, and the report shows both.
#[test]
fn repair_changes_what_is_wrong_and_shows_it() {
    let file = |mass: f64, [x, y, z]: [f64; 3]| {
        in_inertial(&format!(
            r#"<origin rpy="0.3 0.2 0.1"/><mass value="{mass}"/><inertia ixx="{x}" iyy="{y}" izz="{z}"/>"#
        ))
    };
    let repair = Options::default().with_repaired_inertia();
    let r = Rotation3::from_euler_angles(0.3, 0.2, 0.1);
    for (given, mended, shown) in [
        (
            [4.766, 0.0041, 0.0037],
            [0.0078, 0.0041, 0.0037],
            "0.0037, 0.0041, 4.766 → 0.0037, 0.0041, 0.0078 kg·m²",
        ),
        ([-1.0, 1.0, 1.0], [0.0, 1.0, 1.0], "-1, 1, 1 → 0, 1, 1 kg·m²"),
    ] {
        let text = file(1.0, given);
        let robot = parse(&text, &repair).expect("repaired");
        let found: Vec<_> = robot.report.warnings().collect();
        assert_eq!((found.len(), found[0].treatment()), (1, Treatment::Repaired));
        assert!(found[0].message().contains(shown), "{}", found[0].message());
        let entry = format!("ixx={}", mended[0]);
        assert!(found[0].message().contains(&entry), "{} lacks {entry}", found[0].message());
        let inertia =
            robot.description.links[0].mass_properties.expect("mass").inertia_about_center_of_mass();
        let expected = r.matrix() * Matrix3::from_diagonal(&mended.into()) * r.matrix().transpose();
        // Rounding of an eigendecomposition of numbers up to 5.
        assert!((inertia - expected).amax() < 1e-14, "{inertia}");
        assert!(parse(&text, &repair.clone().with_strict()).is_err());
    }
    let robot = parse(&file(0.0, [1.0, 1.0, 1.0]), &repair).expect("repaired");
    assert!(robot.description.links[0].mass_properties.is_none());
    assert!(robot.report.warnings().next().expect("a warning").message().contains("1, 1, 1 → 0, 0, 0 kg·m²"));
    // A sound inertia is left exactly alone, and a negative mass is beyond repair.
    let sound = file(1.0, [1.0, 2.0, 2.5]);
    assert_eq!(parse(&sound, &repair).expect("sound").description, read(&sound).description);
    assert!(parse(&file(-1.0, [1.0; 3]), &repair).is_err());
}

#[test]
fn a_root_that_floats_is_not_freed_again() {
    let body = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    let file = |name: &str, kind: &str, root: &str| {
        format!(
            "<robot name=\"r\"><link name=\"odom\">{root}</link><link name=\"mount\"/><link name=\"trunk\">{body}</link>\
             <joint name=\"m\" type=\"fixed\"><parent link=\"odom\"/><child link=\"mount\"/></joint>\
             <joint name=\"{name}\" type=\"{kind}\"><parent link=\"mount\"/><child link=\"trunk\"/></joint></robot>"
        )
    };
    let free = Options::default().with_floating_base();
    let floats = parse(&file("base", "floating", ""), &free).expect("a robot");
    assert_eq!((floats.description.base, floats.report.counts.degrees_of_freedom), (Base::Fixed, 6));
    assert_eq!(floats.description, read(&file("base", "floating", "")).description);
    let said = floats
        .report
        .findings
        .iter()
        .find(|finding| finding.message().contains("floats by a joint of its own"));
    assert_eq!(said.map(urdf::Finding::severity), Some(Severity::Note), "{}", floats.report);
    // A root with mass, or one that something else hangs on, is freed as asked.
    for text in [file("base", "floating", body), file("base", "continuous", "")] {
        assert_eq!(parse(&text, &free).expect("a robot").description.base, Base::Floating);
    }
    // A joint of the base's name gives way to nobody: the base takes another.
    let named = parse(&file("floating_base", "continuous", ""), &free).expect("a robot");
    let model = Model::new(named.description).expect("a model");
    assert_eq!((model.nv(), model.joint("floating_base").map(|joint| joint.nv)), (7, Some(1)));
    assert_eq!(model.joint("floating_base_2").map(|joint| joint.nv), Some(6));
}

#[test]
fn a_missing_world_is_the_world() {
    let body = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    let file = |parent: &str| {
        format!(
            "<robot name=\"r\"><link name=\"a\">{body}</link><link name=\"b\">{body}</link>\
             <joint name=\"j\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"a\"/></joint>\
             <joint name=\"k\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint></robot>"
        )
    };
    let robot = read(&file("world"));
    assert_eq!((robot.description.links.len(), robot.report.counts.degrees_of_freedom), (3, 2));
    assert!(robot.report.findings.iter().any(|finding| finding.message().contains("taken as the world")));
    assert_eq!(robot.report.counts.warnings, 0, "{}", robot.report);
    assert!(parse(&file("ground"), &Options::default()).is_err());
}

#[test]
fn several_roots_all_stand_in_the_world() {
    let body = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    let links: String =
        ["a", "b", "c", "d"].map(|name| format!("<link name=\"{name}\">{body}</link>")).concat();
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
        )
    };
    let robot = read(&format!(
        "<robot name=\"r\">{links}{}{}</robot>",
        joint("j", "a", "b"),
        joint("world_to_a", "c", "d")
    ));
    let places: Vec<&str> = robot.report.warnings().map(urdf::Finding::place).collect();
    assert_eq!(places, [r#"link "a""#, r#"link "c""#]);
    let model = Model::new(robot.description).expect("one tree");
    assert_eq!((model.nv(), model.total_mass()), (2, 4.0));
    assert!(model.joint("world_to_a_").is_some() && model.joint("world_to_c").is_some());
}

/// What a fixed joint cannot use is a note.
#[test]
fn fixed_joints_with_limits_are_no_reason_to_worry() {
    let content = r#"<axis xyz="0 0 0"/><limit lower="1" upper="0" effort="0"/><dynamics damping="-1"/><mimic joint="x"/>"#;
    let robot = read(&in_joint(content).replace("\"revolute\"", "\"fixed\""));
    assert_eq!((robot.report.counts.warnings, robot.report.counts.errors), (0, 0), "{}", robot.report);
}

#[test]
fn a_robot_without_a_name_has_the_files() {
    let folder = std::env::temp_dir().join(format!("urdf-names-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("walker.urdf");
    std::fs::write(&file, "<robot><link name=\"a\"/></robot>").expect("a file");
    let robot = urdf::load(&file, &Options::default()).expect("a robot");
    assert_eq!((robot.description.name.as_str(), robot.report.robot.as_str()), ("walker", "walker"));
    // Latin-1 is read where it is declared.
    let latin =
        b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><robot name=\"B\xe4r\"><link name=\"a\"/></robot>";
    std::fs::write(&file, latin).expect("a file");
    assert_eq!(urdf::load(&file, &Options::default()).expect("a robot").description.name, "Bär");
    std::fs::write(&file, &latin[43..]).expect("a file");
    let refused = urdf::load(&file, &Options::default()).expect_err("not declared");
    assert!(matches!(refused.errors(), [UrdfError::NotUtf8 { byte: 14 }]), "{refused}");
    std::fs::remove_dir_all(&folder).expect("the folder");
}
