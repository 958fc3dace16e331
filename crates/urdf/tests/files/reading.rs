//! Elements are read correctly, and parts that are not read are in the report.

use nalgebra::{Matrix3, Rotation3};
use robot_dynamics::description::{Base, JointKind};
use robot_dynamics::urdf::{Disposition, Finding, LoadOptions, Robot, UrdfError, parse};

fn read(text: &str) -> Robot {
    parse(text, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A joint `j` of this type and content between a massless root and a link with mass.
pub(crate) fn with_joint(joint_type: &str, content: &str) -> String {
    format!(
        r#"<robot name="r"><link name="a"/>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
<joint name="j" type="{joint_type}"><parent link="a"/><child link="b"/>
{content}</joint></robot>"#
    )
}

/// The places of all findings of a disposition, in order.
fn places(robot: &Robot, disposition: Disposition) -> Vec<(usize, &str)> {
    let findings = robot.report.findings.iter().filter(|finding| finding.disposition() == disposition);
    findings.map(|finding| (finding.line(), finding.place())).collect()
}

const PHYSICS: Disposition = Disposition::Ignored { physics: true };
const HARMLESS: Disposition = Disposition::Ignored { physics: false };

#[test]
fn inertia_is_rotated_to_the_axes_of_the_link() {
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
    // nalgebra's roll-pitch-yaw is the reference for R.
    let r = Rotation3::from_euler_angles(0.4, -0.5, 0.6);
    let given = Matrix3::new(0.02, 0.001, -0.002, 0.001, 0.03, 0.003, -0.002, 0.003, 0.04);
    let turned = r.matrix() * given * r.matrix().transpose();
    assert!((body.inertia_about_center_of_mass() - turned).amax() < 1e-17, "{body:?}");
}

#[test]
fn all_parts_of_a_joint_are_read() {
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
    let [link, inertial, inertia] =
        ["", "/inertial", "/inertial/inertia"].map(|part| format!("link \"b\"{part}"));
    let defaulted = places(&robot, Disposition::Defaulted);
    let count = |line, place: &str| defaulted.iter().filter(|found| **found == (line, place)).count();
    assert_eq!(count(1, r#"link "a""#), 1); // no <inertial>
    // No <origin>; no ixy, ixz, iyz.
    assert_eq!((count(2, &link), count(2, &inertial), count(2, &inertia)), (0, 1, 3));
    assert_eq!(count(3, r#"joint "j""#), 3); // no <origin>, <axis>, <dynamics>
    assert_eq!(count(4, r#"joint "j"/limit"#), 3); // no lower, upper, velocity
    assert_eq!(defaulted.len(), 11, "{}", robot.report);
}

#[test]
fn quaternions_are_read_in_the_order_x_y_z_w() {
    let robot = read(&with_joint("continuous", r#"<origin quat_xyzw="0 0 1 1"/>"#));
    let turned = robot.description.joints[0].parent_from_joint.rotate([1.0, 0.0, 0.0]);
    assert!((turned[1] - 1.0).abs() < 1e-15, "{turned:?}");
}

#[test]
fn a_floating_base_is_six_more_degrees_of_freedom() {
    let options = LoadOptions::default().with_floating_base();
    let robot = parse(&with_joint("continuous", ""), &options).expect("a robot");
    assert_eq!(robot.description.base, Base::Floating);
    assert_eq!(robot.report.counts.degrees_of_freedom, 7);
}

/// Content of a file that is not read, with its disposition.
#[rustfmt::skip]
pub(crate) const UNREAD: &[(&str, Disposition)] = &[
    (r#"<transmission name="t"><type>Simple</type><joint name="j"/><actuator name="m"/></transmission>"#, HARMLESS),
    (r#"<transmission name="t"><actuator name="m"><mechanicalReduction>100</mechanicalReduction></actuator></transmission>"#, PHYSICS),
    (r#"<transmission name="t"><actuator name="m"><mechanicalReduction>1</mechanicalReduction></actuator></transmission>"#, HARMLESS),
    (r#"<transmission name="t"><actuator name="m"><rotor_inertia value="1e-4"/></actuator></transmission>"#, PHYSICS),
    (r#"<transmission name="t"><actuator name="m"><drake:gear_ratio value="50" xmlns:drake="d"/></actuator></transmission>"#, PHYSICS),
    (r#"<gazebo reference="b"><material>Gazebo/Red</material><mu1>0.5</mu1><kp>1e6</kp></gazebo>"#, HARMLESS),
    (r#"<gazebo reference="j"><springStiffness>3</springStiffness></gazebo>"#, PHYSICS),
    (r#"<gazebo reference="j"><implicitSpringDamper>1</implicitSpringDamper></gazebo>"#, HARMLESS),
    (r#"<gazebo reference="b"><turnGravityOff>true</turnGravityOff></gazebo>"#, PHYSICS),
    (r#"<gazebo reference="b"><turnGravityOff>false</turnGravityOff></gazebo>"#, HARMLESS),
    (r#"<gazebo><joint name="loop" type="revolute"><parent>a</parent><child>b</child></joint></gazebo>"#, PHYSICS),
    (r#"<ros2_control name="c" type="system"><joint name="j"><command_interface name="effort"/></joint></ros2_control>"#, HARMLESS),
    (r#"<loop_joint name="l" type="ball"/>"#, PHYSICS),
    (r#"<x:thing xmlns:x="somewhere"/>"#, HARMLESS),
    (r#"<group name="arm"/>"#, HARMLESS),
    ("stray words", HARMLESS),
];

/// The text is at line 5.
pub(crate) fn with_unread(text: &str) -> String {
    with_joint("continuous", "").replace("</robot>", &format!("\n{text}\n</robot>"))
}

#[test]
fn parts_that_are_not_read_are_reported() {
    for (text, disposition) in UNREAD {
        let file = with_unread(text);
        let robot = read(&file);
        let found = places(&robot, *disposition);
        assert!(!found.is_empty() && found.iter().all(|(line, _)| *line >= 5), "{text}:\n{}", robot.report);
        let physics = *disposition == PHYSICS;
        assert_eq!(robot.report.counts.ignored_physics > 0, physics, "{text}:\n{}", robot.report);
        let strict = parse(&file, &LoadOptions::default().with_strict());
        let refused = strict.as_ref().err().map(robot_dynamics::urdf::LoadError::errors);
        assert_eq!(matches!(refused, Some([UrdfError::Strict { .. }])), physics, "{text}: {strict:?}");
    }
}

/// Contents of a joint beyond the standard, and whether they count as physics.
#[rustfmt::skip]
pub(crate) const UNKNOWN_PARTS: &[(&str, bool)] = &[
    (r#"<dynamics damping="0" friction="0" rotor="3"/>"#, true),
    ("<flexibility/>", true),
    (r#"<axis xyz="0 0 1" expressed_in="world"/>"#, true),
    (r#"<axis xyz="0 0 1" rpy="0 0 0"/>"#, false),
    (r#"<axis xyz="0 0 1" rpy="0 0 1"/>"#, true),
    (r#"<limit effort="1" velocity="1" acceleration="4"/>"#, false),
    (r#"<safety_controller k_velocity="1"/>"#, false),
    (r#"<calibration rising="0"/>"#, false),
];

#[test]
fn unknown_parts_of_joints_and_inertias_count_as_physics() {
    for &(content, physics) in UNKNOWN_PARTS {
        let file = with_joint("continuous", content);
        let robot = read(&file);
        assert_eq!(places(&robot, Disposition::Ignored { physics }).len(), 1, "{content}:\n{}", robot.report);
        assert_eq!(parse(&file, &LoadOptions::default().with_strict()).is_err(), physics, "{content}");
    }
    for (iyx, physics) in [("0.1", false), ("0.2", true)] {
        let file = format!(
            r#"<robot name="r"><link name="a"><inertial><mass value="1"/>
            <inertia ixx="1" ixy="0.1" iyx="{iyx}" izy="0" iyy="1" izz="1"/></inertial></link></robot>"#
        );
        let robot = read(&file);
        assert_eq!(robot.report.counts.ignored_physics > 0, physics, "{}", robot.report);
    }
    let file = r#"<robot name="r"><link name="a"><inertial unit="lb"><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"#;
    assert_eq!(places(&read(file), PHYSICS), [(1, r#"link "a"/inertial"#)]);
    let refused = parse(file, &LoadOptions::default().with_strict()).expect_err("strict");
    assert!(matches!(refused.errors(), [UrdfError::Strict { line: 1, .. }]), "{refused}");
}

#[test]
fn fixed_joints_need_no_axis_or_limit() {
    let content =
        r#"<axis xyz="0 0 0"/><limit lower="1" upper="0"/><dynamics damping="1"/><mimic joint="x"/>"#;
    let robot = read(&with_joint("fixed", content));
    let parts = ["axis", "limit", "dynamics", "mimic"].map(|name| format!("joint \"j\"/{name}"));
    assert_eq!(places(&robot, HARMLESS), parts.each_ref().map(|part| (4, part.as_str())));
}

#[test]
fn shapes_are_counted_and_no_mesh_is_opened() {
    let shape = r#"<visual><geometry><mesh filename="package://nowhere/hand.dae"/></geometry></visual>
        <collision><geometry><mesh filename="file:///nowhere.stl" scale="x y z"/></geometry></collision>"#;
    let file = with_joint("continuous", "").replace("<inertial>", &format!("{shape}<inertial>"));
    let robot = read(&file.replace("</robot>", r#"<material name="red"/></robot>"#));
    assert_eq!(robot.report.counts.not_dynamics, 3);
    // The scale of the second mesh is invalid.
    assert_eq!(places(&robot, HARMLESS).len(), 1, "{}", robot.report);
    assert_eq!(robot.report.counts.ignored, 1, "{}", robot.report);
    assert_eq!(robot.description.shapes.len(), 1);
}

const BODY: &str = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#;

#[test]
fn links_without_mass_are_accepted_if_every_joint_moves_mass() {
    // The links between two joints and at the root have no mass, and one link has its mass in a fixed child.
    // The fixed tip has none.
    let robot = read(&format!(
        r#"<robot name="r"><link name="root"/><link name="cross"/><link name="shell"/>
           <link name="core">{BODY}</link><link name="tip"/>
           <joint name="j1" type="continuous"><parent link="root"/><child link="cross"/></joint>
           <joint name="j2" type="continuous"><parent link="cross"/><child link="shell"/><axis xyz="0 1 0"/></joint>
           <joint name="f1" type="fixed"><parent link="shell"/><child link="core"/></joint>
           <joint name="f2" type="fixed"><parent link="core"/><child link="tip"/></joint></robot>"#
    ));
    // Both joints lack <origin>, <limit> and <dynamics>, and j1 lacks <axis>. The fifth note of j1 is about
    // the mass of its link.
    let noted = places(&robot, Disposition::Defaulted);
    let count = |joint: &str| noted.iter().filter(|(_, place)| *place == joint).count();
    assert_eq!((count(r#"joint "j1""#), count(r#"joint "j2""#)), (5, 3), "{}", robot.report);
    let zeros = BODY.replace("\"1\"", "\"0\"");
    let robot = read(&format!(r#"<robot name="r"><link name="a">{zeros}</link></robot>"#));
    assert!(robot.description.links[0].mass_properties.is_none());
}

#[test]
fn a_leader_may_move_mass_only_by_its_mimic_joint() {
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
    assert_eq!(places(&alone, Disposition::AsWritten), [(2, r#"joint "lead""#)], "{}", alone.report);
    assert!(robot.report.warnings().next().is_none(), "{}", robot.report);
}

#[test]
fn a_chain_of_mimic_joints_is_allowed() {
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
fn byte_order_marks_line_ends_and_comments_are_accepted() {
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
fn the_report_survives_json() {
    let report = read(&with_joint("continuous", "<flexibility/>")).report;
    let json = serde_json::to_string(&report).expect("json");
    assert_eq!(serde_json::from_str::<robot_dynamics::urdf::LoadReport>(&json).expect("the same"), report);
    let lines: Vec<usize> = report.findings.iter().map(Finding::line).collect();
    assert!(lines.is_sorted(), "{lines:?}");
    assert_eq!(report.ignored_physics().count(), report.counts.ignored_physics);
}
