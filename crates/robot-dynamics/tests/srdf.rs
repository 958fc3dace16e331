//! SRDF files beside robot files: groups, poses, passive joints, the joint to the world, excluded pairs.

use robot_dynamics::description::{GroupDescription, JointKind, RobotDescription};
use robot_dynamics::model::Model;
use robot_dynamics::urdf::UrdfError;
use robot_dynamics::{
    FileError, FileSet, LoadOptions, load_description_from_files, load_description_from_text,
};

/// A trunk with two arms of two links each. The finger follows the elbow of the left arm.
const URDF: &str = r#"<robot name="twins">
  <link name="trunk"><inertial><mass value="3"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="left_upper"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="left_lower"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right_upper"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right_lower"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="finger"/>
  <joint name="left_shoulder" type="revolute"><parent link="trunk"/><child link="left_upper"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
  <joint name="left_elbow" type="revolute"><parent link="left_upper"/><child link="left_lower"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
  <joint name="left_finger" type="prismatic"><parent link="left_lower"/><child link="finger"/><limit lower="-2" upper="2"/><mimic joint="left_elbow"/></joint>
  <joint name="right_shoulder" type="continuous"><parent link="trunk"/><child link="right_upper"/><axis xyz="0 1 0"/></joint>
  <joint name="right_elbow" type="spherical"><parent link="right_upper"/><child link="right_lower"/></joint>
</robot>"#;

const SRDF: &str = r#"<?xml version="1.0"?>
<robot name="twins">
  <virtual_joint name="to_ground" type="fixed" parent_frame="ground" child_link="trunk"/>
  <group name="both"><group name="left"/><group name="right"/></group>
  <group name="left"><chain base_link="trunk" tip_link="left_lower"/></group>
  <group name="right"><joint name="right_shoulder"/><link name="right_lower"/></group>
  <group name="across"><chain base_link="left_lower" tip_link="right_upper"/></group>
  <group name="hand"><link name="finger"/></group>
  <group_state name="home" group="left"><joint name="left_shoulder" value="0.5"/><joint name="left_elbow" value="-1"/></group_state>
  <group_state name="home" group="right"><joint name="right_shoulder" value="0.25"/></group_state>
  <group_state name="turned" group="right"><joint name="right_elbow" value="0 0 2 0"/></group_state>
  <end_effector name="gripper" group="hand" parent_link="left_lower" parent_group="left"/>
  <passive_joint name="right_shoulder"/>
  <disable_collisions link1="trunk" link2="left_upper" reason="Adjacent"/>
  <disable_default_collisions link="finger"/>
  <enable_collisions link1="finger" link2="right_lower"/>
</robot>"#;

fn options(srdf: &str) -> LoadOptions {
    LoadOptions::default().with_srdf_text(srdf)
}

fn read(srdf: &str) -> RobotDescription {
    load_description_from_text(URDF, &options(srdf)).unwrap_or_else(|error| panic!("{error}")).description
}

/// The refusal of a file, which changes nothing.
fn refused(srdf: &str) -> robot_dynamics::urdf::LoadError {
    let mut robot = load_description_from_text(URDF, &LoadOptions::default()).expect("a robot").description;
    let before = robot.clone();
    let refused = robot_dynamics::urdf::add_srdf(&mut robot, srdf, &LoadOptions::default()).expect_err(srdf);
    assert_eq!(robot, before);
    let loaded = load_description_from_text(URDF, &options(srdf)).expect_err("the same errors");
    assert!(matches!(&loaded, FileError::Srdf { .. }) && loaded.messages().len() == refused.errors().len());
    refused
}

fn with(elements: &str) -> String {
    format!("<robot name=\"twins\">\n{elements}\n</robot>")
}

fn names(group: &GroupDescription) -> (Vec<&str>, Vec<&str>) {
    fn of(list: &[String]) -> Vec<&str> {
        list.iter().map(String::as_str).collect()
    }
    (of(&group.links), of(&group.joints))
}

#[test]
fn groups_have_the_members_of_their_parts() {
    let robot = read(SRDF);
    let group = |name: &str| robot.groups.iter().find(|group| group.name == name).expect(name);
    let left = (vec!["left_upper", "left_lower"], vec!["left_shoulder", "left_elbow"]);
    assert_eq!(names(group("left")), left);
    let right = (vec!["right_upper", "right_lower"], vec!["right_shoulder", "right_elbow"]);
    assert_eq!(names(group("right")), right);
    assert_eq!(names(group("both")), ([left.0, right.0].concat(), [left.1, right.1].concat()));
    assert_eq!(group("both").subgroups, ["left", "right"]);
    // A chain goes over the link above both ends.
    let across = vec!["left_shoulder", "left_elbow", "right_shoulder"];
    assert_eq!(names(group("across")).1, across);
    assert_eq!(group("across").chains, [("left_lower".to_owned(), "right_upper".to_owned())]);
    assert_eq!(names(group("hand")), (vec!["finger"], vec!["left_finger"]));
    let tool = &robot.end_effectors[0];
    assert_eq!((tool.parent_link.as_str(), tool.parent_group.as_deref()), ("left_lower", Some("left")));
}

#[test]
fn states_are_poses_of_the_model() {
    let robot = read(SRDF);
    let poses: Vec<_> = robot.poses.iter().map(|pose| (pose.name.as_str(), pose.group.as_deref())).collect();
    let (left, right) = (Some("left"), Some("right"));
    assert_eq!(poses, [("left/home", left), ("right/home", right), ("turned", right)]);
    let model = Model::new(robot).expect("a robot");
    let q = |name: &str| model.named_pose(name).expect(name).0;
    assert_eq!(q("left/home"), [0.5, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    // The quaternion is normalized.
    assert_eq!(q("turned"), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn passive_joints_are_not_actuated() {
    let model = Model::new(read(SRDF)).expect("a robot");
    assert_eq!(model.actuated_dofs(), [true, true, false, true, true, true]);
    let without = Model::new(read(&with(""))).expect("a robot");
    assert!(
        without.actuated_dofs().iter().all(|actuated| *actuated) && without.description().groups.is_empty()
    );
}

#[test]
fn excluded_pairs_are_those_of_the_file() {
    let robot = read(SRDF);
    let finger = ["trunk", "left_upper", "left_lower", "right_upper"].map(|link| ("finger", link));
    let expected = [[("trunk", "left_upper")].as_slice(), &finger].concat();
    let pairs: Vec<_> = robot.contact_exclusions.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    assert_eq!(pairs, expected);
}

/// A floating virtual joint gives the dynamics of a floating base; a planar one has no motor.
#[test]
fn virtual_joints_move_the_root() {
    let joint = |kind: &str| {
        with(&format!(
            r#"<virtual_joint name="to_ground" type="{kind}" parent_frame="ground" child_link="trunk"/>
            <group name="base"><joint name="to_ground"/></group>"#
        ))
    };
    let floating = read(&joint("floating"));
    assert_eq!((floating.links[0].name.as_str(), floating.joints[0].kind), ("ground", JointKind::Floating));
    assert_eq!(names(&floating.groups[0]), (vec!["trunk"], vec!["to_ground"]));
    let model = Model::new(floating).expect("a robot");
    let base = LoadOptions::default().with_floating_base();
    let base = load_description_from_text(URDF, &base).expect("a robot").description;
    let base = Model::new(base).expect("a robot");
    let q: Vec<f64> = [0.1, 0.2, 0.3, 0.0, 0.6, 0.0, 0.8, 0.4, 0.5, 0.6, 0.0, 0.0, 0.0, 1.0].into();
    let [one, other] = [&model, &base].map(|model| model.mass_matrix(&q).expect("M"));
    assert_eq!(one, other);
    assert_eq!(model.actuated_dofs(), base.actuated_dofs());
    let planar = Model::new(read(&joint("planar"))).expect("a robot");
    assert_eq!(planar.actuated_dofs()[..4], [false, false, false, true]);
    // A base that floats already keeps its joint, also in states.
    let state = r#"<group_state name="up" group="base"><joint name="to_ground" value="0 0 1 0 0 0 1"/></group_state>"#;
    let text = joint("floating").replace("</robot>", &format!("{state}</robot>"));
    let loaded = load_description_from_text(URDF, &options(&text).with_floating_base()).expect("a robot");
    let model = Model::new(loaded.description).expect("a robot");
    assert_eq!(model.named_pose("up").expect("up").0[..7], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
}

/// Pinocchio's `loadRotorParameters` gives the armature 0.4 kg m² for these numbers.
#[test]
fn rotors_add_their_reflected_inertia() {
    let rotors =
        with(r#"<rotor_params><joint name="left_elbow" mass="1e-3" gear_ratio="20"/></rotor_params>"#);
    let robot = read(&rotors);
    let elbow = robot.joints.iter().find(|joint| joint.name == "left_elbow").expect("the elbow");
    assert!((elbow.passive.armature - 0.4).abs() < 1e-15);
}

#[test]
fn errors_name_the_line_and_the_nearest_name() {
    for (elements, line) in [
        (r#"<passive_joint name="left_elbo"/>"#, 2),
        (r#"<group name="a"><link name="left_lowe"/></group>"#, 2),
        ("<group name=\"left\"/>\n<group_state name=\"s\" group=\"lef\"/>", 3),
        (r#"<end_effector name="e" group="none" parent_link="trunk"/>"#, 2),
        (r#"<disable_collisions link1="trunk" link2="left_upp"/>"#, 2),
    ] {
        let refused = refused(&with(elements));
        let [error] = refused.errors() else { panic!("{refused}") };
        assert!(matches!(error, UrdfError::UnknownName { line: at, .. } if *at == line), "{refused}");
    }
    let refused_for = |elements: &str| refused(&with(elements)).errors().len();
    // A cycle of groups, two groups of one name, a virtual joint on a link that is not the root.
    assert_eq!(
        refused_for(r#"<group name="a"><group name="b"/></group><group name="b"><group name="a"/></group>"#),
        1
    );
    assert_eq!(refused_for(r#"<group name="a"/><group name="a"/>"#), 1);
    assert_eq!(
        refused_for(r#"<virtual_joint name="v" type="floating" parent_frame="w" child_link="finger"/>"#),
        1
    );
    // Counts and numbers.
    let state = |joint: &str, value: &str| {
        format!(
            r#"<group name="g"/><group_state name="s" group="g"><joint name="{joint}" value="{value}"/></group_state>"#
        )
    };
    for (joint, value) in
        [("left_elbow", "0 0"), ("left_elbow", "x"), ("right_elbow", "0 0 0 0"), ("left_elbow", "nan")]
    {
        assert_eq!(refused_for(&state(joint, value)), 1, "{joint} {value}");
    }
    assert!(refused("<robot name='r'><link name='a'/></robot>").to_string().contains("belongs to URDF"));
}

#[test]
fn findings_name_the_file() {
    let text = with("<link_sphere_approximation link=\"trunk\"/>");
    let report = load_description_from_text(URDF, &options(&text)).expect("a robot").report;
    let of_srdf: Vec<_> =
        report.findings.iter().filter(|finding| finding.place().starts_with("SRDF: ")).collect();
    assert!(of_srdf.len() == 1 && of_srdf[0].line() == 2, "{report}");
    // A strict reading refuses a warning: a state of a joint outside its group.
    let text = with(
        r#"<group name="g"/><group_state name="s" group="g"><joint name="left_elbow" value="0"/></group_state>"#,
    );
    let loaded = load_description_from_text(URDF, &options(&text)).expect("a robot");
    assert_eq!(loaded.report.counts.warnings, 1);
    assert!(load_description_from_text(URDF, &options(&text).with_strict()).is_err());
}

/// An SRDF file works for MJCF, and comes from files in memory.
#[test]
fn robots_of_all_formats_take_it() {
    let ball = r#"<mujoco><worldbody><body name="ball"><joint name="slide" type="slide"/><geom size="0.1"/></body></worldbody></mujoco>"#;
    let srdf = with(r#"<group name="all"><joint name="slide"/></group>"#);
    let files = FileSet::new([("ball.xml", ball), ("ball.srdf", srdf.as_str())]);
    let options = LoadOptions::default().with_srdf("ball.srdf");
    let robot = load_description_from_files(&files, "ball.xml", &options).expect("a robot").description;
    assert_eq!(names(&robot.groups[0]), (vec!["ball"], vec!["slide"]));
    let missing = LoadOptions::default().with_srdf("none.srdf");
    assert!(matches!(load_description_from_files(&files, "ball.xml", &missing), Err(FileError::Srdf { .. })));
}

/// Memory and time stay in proportion to the file.
#[test]
fn hostile_files_are_refused_or_read() {
    use std::fmt::Write;
    let mut text = String::new();
    for link in 0..3000 {
        let _ = write!(text, "<disable_default_collisions link=\"l{link}\"/>");
    }
    let many =
        (0..3000).map(|link| robot_dynamics::description::LinkDescription::new(format!("l{link}"), None));
    let mut robot = RobotDescription::new("many");
    robot.links = many.collect();
    let refused = robot_dynamics::urdf::add_srdf(&mut robot, &with(&text), &LoadOptions::default());
    let refused = refused.expect_err("nine million pairs");
    assert!(matches!(refused.errors(), [UrdfError::TooMany { .. }]), "{refused}");
    // A long chain of groups, each a part of the next.
    let mut text = String::from("<group name=\"g0\"><joint name=\"left_elbow\"/></group>");
    for group in 1..50_000 {
        let _ = write!(text, "<group name=\"g{group}\"><group name=\"g{}\"/></group>", group - 1);
    }
    assert_eq!(read(&with(&text)).groups[49_999].joints, ["left_elbow"]);
}
