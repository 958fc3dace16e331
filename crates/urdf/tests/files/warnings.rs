//! Suspicious files are loaded as written, each with a warning. Only a strict reading refuses them.
//!
//! `messages.rs` has the text of each warning.

use nalgebra::{Matrix3, Rotation3, Vector3};
use robot_dynamics::description::{Base, JointKind};
use robot_dynamics::model::Model;
use robot_dynamics_urdf::{Disposition, LoadOptions, Robot, Severity, UrdfError, parse};

use crate::malformed::Frame;

fn read(text: &str) -> Robot {
    parse(text, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The text is in the inertial of link `a`, from line 2.
fn in_inertial(text: &str) -> String {
    format!("<robot name=\"r\"><link name=\"a\"><inertial>\n{text}\n</inertial></link></robot>")
}

/// The text is in a revolute joint `j` between two bodies, from line 2.
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

/// The frame around the text, the text, and the line and place of its warning.
#[rustfmt::skip]
pub(crate) const WARNINGS: &[(Frame, &str, usize, &str)] = &[
    (in_inertial, r#"<mass value="1"/><inertia ixx="1" iyy="1" izz="3"/>"#, 1, r#"link "a"/inertial"#),
    (in_inertial, r#"<mass value="1"/><inertia ixx="-1" iyy="1" izz="1"/>"#, 1, r#"link "a"/inertial"#),
    (in_inertial, r#"<mass value="0"/><inertia ixx="1" iyy="1" izz="1"/>"#, 1, r#"link "a"/inertial"#),
    (in_inertial, r#"<mass value="2"/>"#, 1, r#"link "a"/inertial"#),
    (in_inertial, r#"<mass value="1"/><inertia ixx="1" iyy="1" izz="1"/><mass value="2"/>"#, 2, r#"link "a"/inertial/mass"#),
    (in_inertial, r#"<origin xyz="1 0 0"/><origin xyz="2 0 0"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>"#, 2, r#"link "a"/inertial/origin"#),
    (in_inertial, "<mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>\n<inertial>", 3, r#"link "a"/inertial"#),
    (in_joint, "<axis xyz=\"0 0 1\"/>\n<axis xyz=\"0 1 0\"/>", 3, r#"joint "j"/axis"#),
    (in_joint, "<limit upper=\"1\"/>\n<limit upper=\"2\"/>", 3, r#"joint "j"/limit"#),
    (in_joint, r#"<limit lower="1" upper="-1"/>"#, 2, r#"joint "j"/limit"#),
    (in_joint, r#"<limit lower="1"/>"#, 2, r#"joint "j"/limit"#),
    (in_joint, r#"<limit effort="0"/>"#, 2, r#"joint "j"/limit"#),
    (in_joint, r#"<limit velocity="0"/>"#, 2, r#"joint "j"/limit"#),
    (in_joint, r#"<limit effort="-3"/>"#, 2, r#"joint "j"/limit"#),
    (in_joint, r#"<dynamics damping="-0.1"/>"#, 2, r#"joint "j"/dynamics"#),
    (in_joint, r#"<dynamics stiffness="-5"/>"#, 2, r#"joint "j"/dynamics"#),
    (whole, r#"<robot><link name="a"/></robot>"#, 1, "robot"),
    (whole, "<robot name=\"r\"><link name=\"a\"/>\n<drake:joint name=\"x\"/></robot>", 2, "robot"),
    (whole, "<?xml version=\"1.0\"?><!-- <a> -->\n<ns0:robot name=\"r\"><ns0:link name=\"a\"/></ns0:robot>", 2, "robot"),
    (whole, "\n<!-- made by hand --><?xml version=\"1.0\"?>\n<robot name=\"r\"><link name=\"a\"/></robot>", 2, "robot"),
    (whole, "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link><joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint>\n<xacro:wheel side=\"left\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"/></robot>", 2, "robot/wheel"),
    (whole, "<robot name=\"r\"><link name=\"world\"/>\n<link name=\"stray\"/></robot>", 2, r#"link "stray""#),
    (whole, "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/>\n<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint></robot>", 2, r#"joint "j""#),
];

#[test]
fn every_suspicious_file_loads_with_its_warning_alone() {
    for (frame, text, line, place) in WARNINGS {
        let file = frame(text);
        let robot = read(&file);
        let found: Vec<_> = robot.report.warnings().map(|w| (w.line(), w.place(), w.severity())).collect();
        assert_eq!(found, [(*line, *place, Severity::Warning)], "{text}");
        assert_eq!(robot.report.counts.warnings, 1, "{text}");
        let refused = parse(&file, &LoadOptions::default().with_strict()).expect_err("a warning");
        let [UrdfError::Strict { line: strict_line, place: strict_place, .. }] = refused.errors() else {
            panic!("{refused}")
        };
        assert_eq!((*strict_line, strict_place.as_str()), (*line, *place), "{text}");
    }
}

/// Values that are taken as written are equal in the file and in the model.
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
    // Infinite bounds are valid and give no warning.
    let unbounded = read(&in_joint(r#"<limit lower="-inf" upper="inf" effort="INF" velocity="1e400"/>"#));
    let limits = unbounded.description.joints[0].limits;
    assert_eq!((limits.lower, limits.upper), (f64::NEG_INFINITY, f64::INFINITY));
    assert_eq!((limits.effort, limits.velocity), (f64::INFINITY, f64::INFINITY));
    assert_eq!(unbounded.report.counts.warnings, 0, "{}", unbounded.report);
    // All of them compile to a model.
    for (frame, text, ..) in WARNINGS {
        if !text.contains("\"continuous\"") {
            Model::new(read(&frame(text)).description).unwrap_or_else(|error| panic!("{error}: {text}"));
        }
    }
}

/// Moments that violate the laws by rounding are not reported, and repair does not change them.
#[test]
fn rounding_is_not_reported() {
    for inertia in [
        r#"ixx="-5.42e-20" iyy="-5.42e-20" izz="0""#,
        r#"ixx="2.71e-20" ixy="-1.69e-21" ixz="1.36e-20" iyy="5.42e-20" iyz="3.39e-21" izz="1.36e-20""#,
        r#"ixx="1" iyy="1" izz="2.0000005""#,
    ] {
        let text =
            in_inertial(&format!(r#"<origin xyz="0 0 0.03"/><mass value="0.5"/><inertia {inertia}/>"#));
        let robot = read(&text);
        assert_eq!(robot.report.counts.warnings, 0, "{}", robot.report);
        let repaired = parse(&text, &LoadOptions::default().with_repaired_inertia()).expect("a robot");
        assert_eq!(repaired, robot);
    }
    // The tolerance is 1e-9 of m·size²; the size here is the distance of the centre of mass.
    for (moment, warnings) in [("-1.1e-9", 1), ("-0.9e-9", 0)] {
        let text = in_inertial(&format!(
            r#"<origin xyz="1 0 0"/><mass value="1"/><inertia ixx="{moment}" iyy="0" izz="0"/>"#
        ));
        assert_eq!(read(&text).report.counts.warnings, warnings, "{moment}");
    }
}

/// Repair moves only the wrong moment, and the report has both values.
#[test]
fn repair_changes_only_the_wrong_moment_and_reports_it() {
    let file = |mass: f64, [x, y, z]: [f64; 3]| {
        in_inertial(&format!(
            r#"<origin rpy="0.3 0.2 0.1"/><mass value="{mass}"/><inertia ixx="{x}" iyy="{y}" izz="{z}"/>"#
        ))
    };
    let repair = LoadOptions::default().with_repaired_inertia();
    let r = Rotation3::from_euler_angles(0.3, 0.2, 0.1);
    for (given, mended) in
        [([4.766, 0.0041, 0.0037], [0.0078, 0.0041, 0.0037]), ([-1.0, 1.0, 1.0], [0.0, 1.0, 1.0])]
    {
        let text = file(1.0, given);
        let robot = parse(&text, &repair).expect("repaired");
        let found: Vec<_> = robot.report.warnings().collect();
        assert_eq!((found.len(), found[0].disposition()), (1, Disposition::Repaired));
        let inertia =
            robot.description.links[0].mass_properties.expect("mass").inertia_about_center_of_mass();
        let expected = r.matrix() * Matrix3::from_diagonal(&mended.into()) * r.matrix().transpose();
        // Rounding of an eigendecomposition of numbers up to 5.
        assert!((inertia - expected).amax() < 1e-14, "{inertia}");
        assert!(parse(&text, &repair.clone().with_strict()).is_err());
    }
    let robot = parse(&file(0.0, [1.0, 1.0, 1.0]), &repair).expect("repaired");
    assert!(robot.description.links[0].mass_properties.is_none());
    let dispositions: Vec<Disposition> =
        robot.report.warnings().map(robot_dynamics_urdf::Finding::disposition).collect();
    assert_eq!(dispositions, [Disposition::Repaired]);
    // A valid inertia is unchanged, and a negative mass cannot be repaired.
    let sound = file(1.0, [1.0, 2.0, 2.5]);
    assert_eq!(parse(&sound, &repair).expect("sound").description, read(&sound).description);
    assert!(parse(&file(-1.0, [1.0; 3]), &repair).is_err());
}

#[test]
fn a_floating_root_gets_no_floating_base() {
    let body = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    let file = |name: &str, kind: &str, root: &str| {
        format!(
            "<robot name=\"r\"><link name=\"odom\">{root}</link><link name=\"mount\"/><link name=\"trunk\">{body}</link>\
             <joint name=\"m\" type=\"fixed\"><parent link=\"odom\"/><child link=\"mount\"/></joint>\
             <joint name=\"{name}\" type=\"{kind}\"><parent link=\"mount\"/><child link=\"trunk\"/></joint></robot>"
        )
    };
    let free = LoadOptions::default().with_floating_base();
    let floats = parse(&file("base", "floating", ""), &free).expect("a robot");
    assert_eq!((floats.description.base, floats.report.counts.degrees_of_freedom), (Base::Fixed, 6));
    assert_eq!(floats.description, read(&file("base", "floating", "")).description);
    let noted = floats.report.findings.iter().filter(|finding| finding.place() == "robot");
    let dispositions: Vec<Disposition> = noted.map(robot_dynamics_urdf::Finding::disposition).collect();
    assert_eq!(dispositions, [Disposition::Ignored { physics: false }], "{}", floats.report);
    // A root with mass, or with another joint, becomes a floating base.
    for text in [file("base", "floating", body), file("base", "continuous", "")] {
        assert_eq!(parse(&text, &free).expect("a robot").description.base, Base::Floating);
    }
    // If a joint has the name of the base, the base gets another name.
    let named = parse(&file("floating_base", "continuous", ""), &free).expect("a robot");
    let model = Model::new(named.description).expect("a model");
    assert_eq!((model.nv(), model.joint("floating_base").map(|joint| joint.nv)), (7, Some(1)));
    assert_eq!(model.joint("floating_base_2").map(|joint| joint.nv), Some(6));
}

#[test]
fn a_missing_parent_world_is_added() {
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
    // Both joints lack the same elements. Joint `j` has one more note, about its parent.
    let [of_j, of_k] = [r#"joint "j""#, r#"joint "k""#].map(|place| {
        let notes = robot.report.findings.iter().filter(|finding| finding.place() == place);
        notes.filter(|finding| finding.disposition() == Disposition::Defaulted).count()
    });
    assert_eq!(of_j, of_k + 1, "{}", robot.report);
    assert_eq!(robot.report.counts.warnings, 0, "{}", robot.report);
    assert!(parse(&file("ground"), &LoadOptions::default()).is_err());
}

#[test]
fn several_roots_are_fixed_to_the_world() {
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
    let places: Vec<&str> = robot.report.warnings().map(robot_dynamics_urdf::Finding::place).collect();
    assert_eq!(places, [r#"link "a""#, r#"link "c""#]);
    let model = Model::new(robot.description).expect("one tree");
    assert_eq!((model.nv(), model.total_mass()), (2, 4.0));
    assert!(model.joint("world_to_a_").is_some() && model.joint("world_to_c").is_some());
}

/// Elements without meaning for a fixed joint give notes.
#[test]
fn limits_of_fixed_joints_give_notes() {
    let content = r#"<axis xyz="0 0 0"/><limit lower="1" upper="0" effort="0"/><dynamics damping="-1"/><mimic joint="x"/>"#;
    let robot = read(&in_joint(content).replace("\"revolute\"", "\"fixed\""));
    assert_eq!((robot.report.counts.warnings, robot.report.counts.errors), (0, 0), "{}", robot.report);
}

/// `<joint_properties>` was the name of `<dynamics>`. In another unknown element, known quantities that have
/// no effect are no physics.
#[test]
fn old_and_unknown_elements_of_joints_are_physics_if_they_act() {
    let joint = |content: &str| {
        let robot = read(&in_joint(content));
        let joint = robot.description.joints.iter().find(|joint| joint.name == "j").expect("the joint");
        ((joint.passive.damping, joint.passive.friction), robot.report.counts.warnings)
    };
    assert_eq!(joint(r#"<joint_properties damping="1.5" friction="0.2"/>"#), ((1.5, 0.2), 0));
    assert_eq!(joint(r#"<joint_properties friction="0.0"/>"#), ((0.0, 0.0), 0));
    // Both elements: the new name counts, and the numbers of the other are reported.
    let both = r#"<dynamics damping="1"/><joint_properties damping="2"/>"#;
    let (passive, warnings) = joint(both);
    assert_eq!(passive, (1.0, 0.0));
    assert!(warnings > 0);
    assert_eq!(joint(r#"<motor rotor_inertia="0" gear_ratio="1"/>"#).1, 0);
    assert!(joint(r#"<motor rotor_inertia="0.1" gear_ratio="1"/>"#).1 > 0);
    assert!(joint(r#"<motor curvature="0"/>"#).1 > 0);
}

/// Joints and reflected inertias of Drake, by its definitions: a screw advances by its pitch per turn, and
/// the inertia of a rotor counts ratio² times.
#[test]
fn extensions_of_drake_are_read() {
    let body = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#;
    let joint = |name: &str, kind: &str, parent: &str, content: &str| {
        format!(
            r#"<link name="{name}">{body}</link><drake:joint name="j{name}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>{content}</drake:joint>"#
        )
    };
    let text = |screw: &str, motor: &str| {
        format!(
            r#"<robot name="r" xmlns:drake="http://drake.mit.edu"><link name="a"/>{}{}{}{}{motor}</robot>"#,
            joint("b", "universal", "a", ""),
            joint("c", "ball", "b", ""),
            joint("d", "planar", "c", ""),
            joint("e", "screw", "d", screw),
        )
    };
    let motor = |joint: &str| {
        format!(
            r#"<transmission name="t"><type>SimpleTransmission</type><joint name="{joint}"/><actuator name="m">
               <drake:gear_ratio value="50"/><drake:rotor_inertia value="1e-4"/></actuator></transmission>"#
        )
    };
    let screw = r#"<axis xyz="0 0 1"/><drake:screw_thread_pitch value="0.004"/>"#;
    let robot = read(&text(screw, &motor("je")));
    let kinds: Vec<JointKind> = robot.description.joints.iter().map(|joint| joint.kind).collect();
    let pitch = 0.004 / core::f64::consts::TAU;
    assert_eq!(
        kinds,
        [
            JointKind::Universal { first: [1.0, 0.0, 0.0], second: [0.0, 1.0, 0.0] },
            JointKind::Spherical,
            JointKind::Planar { normal: [0.0, 0.0, 1.0] },
            JointKind::Helical { axis: [0.0, 0.0, 1.0], pitch },
        ]
    );
    let armature = robot.description.joints[3].passive.armature;
    assert!((armature - 0.25).abs() < 1e-15, "{armature}");
    assert_eq!(robot.report.counts.warnings, 0, "{}", robot.report);
    // Without its joint a rotor is reported, and a screw needs its pitch.
    assert!(read(&text(screw, &motor("none"))).report.counts.warnings > 0);
    let refused = parse(&text("", ""), &LoadOptions::default()).expect_err("a pitch is missing");
    assert!(matches!(refused.errors(), [UrdfError::MissingElement { .. }]), "{refused}");
}

/// Drake writes the damping of a planar joint as three numbers. The model has one for all directions.
#[test]
fn planar_damping_of_drake_is_read_if_its_numbers_are_equal() {
    let body = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#;
    for (damping, expected, warnings) in [("0.5", 0.5, 0), ("0.5 0.5 0.5", 0.5, 0), ("0.5 0.5 0.1", 0.0, 1)] {
        let robot = read(&format!(
            r#"<robot name="r" xmlns:drake="http://drake.mit.edu"><link name="a"/><link name="b">{body}</link>
               <drake:joint name="j" type="planar"><parent link="a"/><child link="b"/>
               <dynamics damping="{damping}"/></drake:joint></robot>"#
        ));
        assert_eq!(robot.description.joints[0].passive.damping, expected, "{damping}");
        assert_eq!(robot.report.counts.ignored_physics, warnings, "{damping}: {}", robot.report);
    }
}

/// Programs in C end their text with this byte, and some write it to the file.
#[test]
fn zero_byte_behind_the_robot_is_read_as_a_space() {
    let robot = read("<robot name='r'><link name='a'/><link name='b'/></robot>\r\n\0");
    let lines: Vec<usize> = robot
        .report
        .warnings()
        .filter(|finding| finding.message().contains("control characters"))
        .map(robot_dynamics_urdf::Finding::line)
        .collect();
    assert_eq!(lines, [2], "{}", robot.report);
}

/// Markup that other readers take is taken, with a warning that a strict reading refuses.
#[test]
fn loose_markup_is_read_with_warnings() {
    let text = "<!-- a -- b --><robot name='r'>\n<gazebo><topic>a&b</topic></gazebo>\n<link name='a'/>
        <!------><link name='b'/><joint name='j'type='continuous'><parent link='a'/><child link='b'/></joint></robot>";
    let robot = read(text);
    assert_eq!((robot.description.links.len(), robot.description.joints.len()), (2, 1));
    let lines: Vec<usize> = robot
        .report
        .warnings()
        .filter(|finding| finding.place() == "robot")
        .map(robot_dynamics_urdf::Finding::line)
        .collect();
    assert_eq!(lines, [1, 2, 4], "{}", robot.report);
    assert!(parse(text, &LoadOptions::default().with_strict()).is_err());
    // Hostile text behind a repaired fault is still refused.
    let hostile = format!("<!-- -- --><robot name='r'>{}", "<a>".repeat(100_000));
    let refused = parse(&hostile, &LoadOptions::default()).expect_err("deep");
    assert!(matches!(refused.errors(), [UrdfError::TooDeep { .. }]), "{refused}");
}

#[test]
fn files_of_other_kinds_are_named() {
    let srdf = "<robot name='r'><group name='arm'/><disable_collisions link1='a' link2='b'/></robot>";
    for (text, format) in [(srdf, "SRDF"), ("#usda 1.0\n", "USD"), ("PK\u{3}\u{4}", "a ZIP archive")] {
        let refused = parse(text, &LoadOptions::default()).expect_err(format);
        assert!(
            matches!(refused.errors(), [UrdfError::OtherFormat { format: found, .. }] if *found == format),
            "{refused}"
        );
    }
}

#[test]
fn a_robot_without_a_name_has_that_of_the_file() {
    let folder = std::env::temp_dir().join(format!("urdf-names-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("walker.urdf");
    std::fs::write(&file, "<robot><link name=\"a\"/></robot>").expect("a file");
    let robot = robot_dynamics_urdf::load(&file, &LoadOptions::default()).expect("a robot");
    assert_eq!((robot.description.name.as_str(), robot.report.robot.as_str()), ("walker", "walker"));
    // Latin-1 is read if it is declared.
    let latin =
        b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><robot name=\"B\xe4r\"><link name=\"a\"/></robot>";
    std::fs::write(&file, latin).expect("a file");
    assert_eq!(
        robot_dynamics_urdf::load(&file, &LoadOptions::default()).expect("a robot").description.name,
        "Bär"
    );
    std::fs::write(&file, &latin[43..]).expect("a file");
    let refused = robot_dynamics_urdf::load(&file, &LoadOptions::default()).expect_err("not declared");
    assert!(matches!(refused.errors(), [UrdfError::NotText { byte: 14, .. }]), "{refused}");
    std::fs::remove_dir_all(&folder).expect("the folder");
}
