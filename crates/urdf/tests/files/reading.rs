//! What is read is read right, and what is not is in the report.

use multibody::{Base, JointKind};
use nalgebra::{Matrix3, Rotation3};
use urdf::{Finding, Options, Robot, Treatment, UrdfError, parse};

fn read(text: &str) -> Robot {
    parse(text, &Options::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A joint `j` with this attribute and content between a massless root and a link with mass.
fn with_joint(joint_type: &str, content: &str) -> String {
    format!(
        r#"<robot name="r"><link name="a"/>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
<joint name="j" type="{joint_type}"><parent link="a"/><child link="b"/>
{content}</joint></robot>"#
    )
}

fn finding<'r>(robot: &'r Robot, message: &str) -> &'r Finding {
    robot
        .report
        .findings
        .iter()
        .find(|finding| finding.message().contains(message))
        .unwrap_or_else(|| panic!("no finding says {message:?}:\n{}", robot.report))
}

const PHYSICS: Treatment = Treatment::Ignored { physics: true };
const HARMLESS: Treatment = Treatment::Ignored { physics: false };

#[test]
fn inertia_is_turned_into_the_links_axes() {
    let robot = read(
        r#"<robot name="r"><link name="a"><inertial>
             <origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/>
             <mass value="2.5"/>
             <inertia ixx="0.02" ixy="0.001" ixz="-0.002" iyy="0.03" iyz="0.003" izz="0.04"/>
           </inertial></link></robot>"#,
    );
    let body = robot.description.links[0].mass_properties.expect("mass");
    assert_eq!(body.mass(), 2.5);
    assert_eq!(body.center_of_mass().as_slice(), [0.1, -0.2, 0.3]);
    // nalgebra's own roll-pitch-yaw is the oracle for R.
    let r = Rotation3::from_euler_angles(0.4, -0.5, 0.6);
    let given = Matrix3::new(0.02, 0.001, -0.002, 0.001, 0.03, 0.003, -0.002, 0.003, 0.04);
    let turned = r.matrix() * given * r.matrix().transpose();
    assert!((body.inertia_about_center_of_mass() - turned).amax() < 1e-17, "{body:?}");
}

#[test]
fn a_joint_is_read_with_everything_it_says() {
    let robot = read(&with_joint(
        "revolute",
        r#"<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
           <axis xyz="0 0.6 0.8"/>
           <limit lower="-1.5" upper="2" effort="30" velocity="4"/>
           <dynamics damping="0.1" friction="0.2" armature="0.3" spring_stiffness="5" spring_reference="0.5"/>"#,
    ));
    let joint = &robot.description.joints[0];
    assert_eq!(joint.kind, JointKind::Revolute { axis: [0.0, 0.6, 0.8] });
    assert_eq!((joint.parent.as_str(), joint.child.as_str()), ("a", "b"));
    assert_eq!(joint.parent_from_joint.translation, [1.0, 2.0, 3.0]);
    let turned = joint.parent_from_joint.rotate([1.0, 0.0, 0.0]);
    assert!((turned[1] - 1.0).abs() < 1e-15, "a quarter turn about z takes x to y, not to {turned:?}");
    let (limits, passive) = (joint.limits, joint.passive);
    assert_eq!([limits.lower, limits.upper, limits.effort, limits.velocity], [-1.5, 2.0, 30.0, 4.0]);
    let forces = [passive.damping, passive.friction, passive.armature, passive.stiffness, passive.rest];
    assert_eq!(forces, [0.1, 0.2, 0.3, 5.0, 0.5]);
    assert_eq!(robot.report.counts.ignored, 0, "{}", robot.report);
}

#[test]
fn every_joint_type_is_known() {
    for (name, freedom) in [
        ("fixed", 0),
        ("revolute", 1),
        ("continuous", 1),
        ("prismatic", 1),
        ("planar", 3),
        ("spherical", 3),
        ("ball", 3),
        ("floating", 6),
    ] {
        let robot = read(&with_joint(name, ""));
        assert_eq!(robot.report.counts.degrees_of_freedom, freedom, "{name}");
        assert_eq!(robot.description.joints[0].kind.nv(), freedom, "{name}");
    }
}

#[test]
fn defaults_are_taken_and_reported() {
    let robot = read(&with_joint("revolute", r#"<limit effort="1"/>"#));
    let joint = &robot.description.joints[0];
    assert_eq!(joint.kind, JointKind::Revolute { axis: [1.0, 0.0, 0.0] });
    assert_eq!((joint.limits.lower, joint.limits.upper), (0.0, 0.0));
    assert_eq!((joint.limits.effort, joint.limits.velocity), (1.0, f64::INFINITY));
    for message in
        ["no <axis>", "no <origin>", "no lower", "no upper", "no velocity", "no <dynamics>", "no ixy"]
    {
        assert_eq!(finding(&robot, message).treatment(), Treatment::Defaulted, "{message}");
    }
    assert_eq!(finding(&robot, "no velocity").line(), 4);
    assert_eq!(finding(&robot, "no velocity").place(), r#"joint "j"/limit"#);
}

#[test]
fn quaternions_are_read_in_the_order_x_y_z_w() {
    let robot = read(&with_joint("continuous", r#"<origin quat_xyzw="0 0 1 1"/>"#));
    let turned = robot.description.joints[0].parent_from_joint.rotate([1.0, 0.0, 0.0]);
    assert!((turned[1] - 1.0).abs() < 1e-15, "{turned:?}");
}

#[test]
fn a_floating_base_is_six_more_degrees_of_freedom() {
    let options = Options::default().with_floating_base();
    let robot = parse(&with_joint("continuous", ""), &options).expect("a robot");
    assert_eq!(robot.description.base, Base::Floating);
    assert_eq!(robot.report.counts.degrees_of_freedom, 7);
}

/// What the file holds, the treatment, and words of its entry.
#[rustfmt::skip]
const UNREAD: &[(&str, Treatment, &str)] = &[
    (r#"<transmission name="t"><type>Simple</type><joint name="j"/><actuator name="m"/></transmission>"#, HARMLESS, "couples motors"),
    (r#"<transmission name="t"><actuator name="m"><mechanicalReduction>100</mechanicalReduction></actuator></transmission>"#, PHYSICS, "mechanicalReduction = 100"),
    (r#"<transmission name="t"><actuator name="m"><mechanicalReduction>1</mechanicalReduction></actuator></transmission>"#, HARMLESS, "couples motors"),
    (r#"<transmission name="t"><actuator name="m"><rotor_inertia value="1e-4"/></actuator></transmission>"#, PHYSICS, "rotor_inertia = 1e-4"),
    (r#"<transmission name="t"><actuator name="m"><drake:gear_ratio value="50" xmlns:drake="d"/></actuator></transmission>"#, PHYSICS, "gear_ratio = 50"),
    (r#"<gazebo reference="b"><material>Gazebo/Red</material><mu1>0.5</mu1><kp>1e6</kp></gazebo>"#, HARMLESS, "Gazebo simulator (\"b\")"),
    (r#"<gazebo reference="j"><springStiffness>3</springStiffness></gazebo>"#, PHYSICS, "springStiffness = 3"),
    (r#"<gazebo reference="b"><turnGravityOff>true</turnGravityOff></gazebo>"#, PHYSICS, "turnGravityOff = true"),
    (r#"<gazebo reference="b"><turnGravityOff>false</turnGravityOff></gazebo>"#, HARMLESS, "Gazebo"),
    (r#"<gazebo><joint name="loop" type="revolute"><parent>a</parent><child>b</child></joint></gazebo>"#, PHYSICS, "joint is not in the model"),
    (r#"<ros2_control name="c" type="system"><joint name="j"><command_interface name="effort"/></joint></ros2_control>"#, HARMLESS, "controllers"),
    (r#"<loop_joint name="l" type="ball"/>"#, PHYSICS, "loop_joint is not in the model"),
    (r#"<x:thing xmlns:x="somewhere"/>"#, HARMLESS, "unknown element"),
    (r#"<group name="arm"/>"#, HARMLESS, "group of links"),
    ("stray words", HARMLESS, "loose text \"stray words\""),
];

#[test]
fn what_is_not_read_is_listed_and_judged() {
    for (text, treatment, message) in UNREAD {
        let file = with_joint("continuous", "").replace("</robot>", &format!("\n{text}\n</robot>"));
        let robot = read(&file);
        let found = finding(&robot, message);
        assert_eq!(found.treatment(), *treatment, "{text}:\n{}", robot.report);
        assert!(found.line() >= 5, "{text}: line {}", found.line());
        let physics = *treatment == PHYSICS;
        assert_eq!(robot.report.counts.ignored_physics > 0, physics, "{text}:\n{}", robot.report);
        let strict = parse(&file, &Options::default().with_strict());
        let refused = strict.as_ref().err().map(urdf::LoadError::errors);
        assert_eq!(matches!(refused, Some([UrdfError::Strict { .. }])), physics, "{text}: {strict:?}");
    }
}

/// What a joint or an inertial may hold beyond the standard.
#[test]
fn unknown_parts_of_joints_and_inertias_count_as_physics() {
    for (content, message, physics) in [
        (r#"<dynamics damping="0" friction="0" rotor="3"/>"#, "unknown attribute rotor", true),
        ("<flexibility/>", "perhaps physics", true),
        (r#"<axis xyz="0 0 1" expressed_in="world"/>"#, "unknown attribute expressed_in", true),
        (r#"<limit effort="1" velocity="1" acceleration="4"/>"#, "unknown attribute acceleration", false),
        (r#"<safety_controller k_velocity="1"/>"#, "soft limits", false),
        (r#"<calibration rising="0"/>"#, "reference positions", false),
    ] {
        let file = with_joint("continuous", content);
        let robot = read(&file);
        assert_eq!(finding(&robot, message).treatment(), Treatment::Ignored { physics }, "{content}");
        assert_eq!(parse(&file, &Options::default().with_strict()).is_err(), physics, "{content}");
    }
    let file = r#"<robot name="r"><link name="a"><inertial unit="lb"><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"#;
    assert_eq!(finding(&read(file), "unknown attribute unit").treatment(), PHYSICS);
    let error = parse(file, &Options::default().with_strict()).expect_err("strict");
    assert_eq!(
        error.to_string(),
        "line 1: link \"a\"/inertial: unknown attribute unit=\"lb\" (a warning, which strict reading refuses; \
         correct it or do not be strict)"
    );
}

#[test]
fn fixed_joints_need_no_axis_or_limit() {
    let content =
        r#"<axis xyz="0 0 0"/><limit lower="1" upper="0"/><dynamics damping="1"/><mimic joint="x"/>"#;
    let robot = read(&with_joint("fixed", content));
    for name in ["axis", "limit", "dynamics", "mimic"] {
        assert_eq!(finding(&robot, &format!("has no <{name}>")).treatment(), HARMLESS);
    }
}

#[test]
fn shapes_are_counted_and_no_mesh_is_opened() {
    let shape = r#"<visual><geometry><mesh filename="package://nowhere/hand.dae"/></geometry></visual>
        <collision><geometry><mesh filename="file:///nowhere.stl" scale="x y z"/></geometry></collision>"#;
    let file = with_joint("continuous", "").replace("<inertial>", &format!("{shape}<inertial>"));
    let robot = read(&file.replace("</robot>", r#"<material name="red"/></robot>"#));
    assert_eq!(robot.report.counts.not_dynamics, 3);
    // The second mesh's scale is none.
    let note = finding(&robot, "a shape that cannot be read");
    assert_eq!((robot.report.counts.ignored, note.treatment()), (1, HARMLESS), "{}", robot.report);
    assert_eq!(robot.description.shapes.len(), 1);
}

const BODY: &str = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#;

#[test]
fn links_without_mass_are_fine_where_others_carry_it() {
    // Between two joints, at the root, and with its mass on a fixed child; the fixed tip has none either.
    let robot = read(&format!(
        r#"<robot name="r"><link name="root"/><link name="cross"/><link name="shell"/>
           <link name="core">{BODY}</link><link name="tip"/>
           <joint name="j1" type="continuous"><parent link="root"/><child link="cross"/></joint>
           <joint name="j2" type="continuous"><parent link="cross"/><child link="shell"/><axis xyz="0 1 0"/></joint>
           <joint name="f1" type="fixed"><parent link="shell"/><child link="core"/></joint>
           <joint name="f2" type="fixed"><parent link="core"/><child link="tip"/></joint></robot>"#
    ));
    let noted: Vec<&str> = robot
        .report
        .findings
        .iter()
        .filter(|finding| finding.message().contains("no mass of its own"))
        .map(Finding::place)
        .collect();
    assert_eq!(noted, [r#"joint "j1""#]);
    let zeros = BODY.replace("\"1\"", "\"0\"");
    let robot = read(&format!(r#"<robot name="r"><link name="a">{zeros}</link></robot>"#));
    assert!(robot.description.links[0].mass_properties.is_none());
}

#[test]
fn a_leader_may_move_mass_through_its_follower_only() {
    let file = |mimic: &str| {
        format!(
            r#"<robot name="r"><link name="root"/><link name="wheel"/><link name="arm">{BODY}</link>
               <joint name="lead" type="continuous"><parent link="root"/><child link="wheel"/></joint>
               <joint name="follow" type="continuous"><parent link="root"/><child link="arm"/>{mimic}</joint></robot>"#
        )
    };
    let robot = read(&file(r#"<mimic joint="lead" multiplier="-2" offset="0.5"/>"#));
    let mimic = robot.description.joints[1].mimic.as_ref().expect("a mimic");
    assert_eq!((mimic.joint.as_str(), mimic.ratio, mimic.offset), ("lead", -2.0, 0.5));
    assert_eq!(robot.report.counts.degrees_of_freedom, 1);
    let alone = read(&file(""));
    assert_eq!(finding(&alone, "no link from there on has mass").place(), r#"joint "lead""#);
    assert!(robot.report.warnings().next().is_none(), "{}", robot.report);
}

#[test]
fn a_chain_of_followers_is_allowed() {
    let robot = read(&format!(
        r#"<robot name="r"><link name="a"/><link name="b">{BODY}</link><link name="c">{BODY}</link>
           <link name="d">{BODY}</link>
           <joint name="j1" type="continuous"><parent link="a"/><child link="b"/></joint>
           <joint name="j2" type="prismatic"><parent link="b"/><child link="c"/><mimic joint="j1"/></joint>
           <joint name="j3" type="revolute"><parent link="c"/><child link="d"/><mimic joint="j2"/></joint></robot>"#
    ));
    assert_eq!(robot.report.counts.degrees_of_freedom, 1);
}

#[test]
fn marks_of_other_systems_do_no_harm() {
    let plain = with_joint("continuous", r#"<axis xyz="0 0 1"/>"#);
    let expected = read(&plain).description;
    let windows = format!("\u{feff}<?xml version=\"1.0\"?>\r\n{}", plain.replace('\n', "\r\n"));
    assert_eq!(read(&windows).description, expected);
    let commented = plain.replace("<axis", "<!-- <axis xyz=\"1 1 1\"/> --><axis");
    assert_eq!(read(&commented).description, expected);
    let spaced = plain.replace("0 0 1", " 0\t+0.0e0\n 1. ");
    assert_eq!(read(&spaced).description, expected);
    let namespaced =
        plain.replace("<robot", r#"<robot xmlns="http://www.ros.org" xmlns:xacro="http://x/xacro""#);
    assert_eq!(read(&namespaced).description, expected);
}

#[test]
fn the_report_is_readable_and_survives_json() {
    let report = read(&with_joint("continuous", "<flexibility/>")).report;
    let listing = report.to_string();
    assert!(listing.starts_with("robot \"r\": 2 links, 1 joints, 1 degrees of freedom\n"), "{listing}");
    assert!(
        listing
            .contains("     4  IGNORED PHYSICS  joint \"j\"/flexibility: unknown element, perhaps physics\n"),
        "{listing}"
    );
    let json = serde_json::to_string(&report).expect("json");
    assert_eq!(serde_json::from_str::<urdf::LoadReport>(&json).expect("the same"), report);
    let lines: Vec<usize> = report.findings.iter().map(Finding::line).collect();
    assert!(lines.is_sorted(), "{lines:?}");
    assert_eq!(report.ignored_physics().count(), report.counts.ignored_physics);
}
