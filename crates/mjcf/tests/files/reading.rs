//! Tests the conversion of elements for which MuJoCo has no number to compare with.

use robot_dynamics::description::{Base, JointKind, ShapeRole};
use robot_dynamics::model::Model;
use robot_dynamics_mjcf::{Disposition, LoadOptions, MjcfError, Robot, parse};

pub(crate) fn read(text: &str) -> Robot {
    parse(text, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

pub(crate) fn in_world(text: &str) -> Robot {
    read(&format!("<mujoco><worldbody>{text}</worldbody></mujoco>"))
}

const BALL: &str = "<geom size=\"0.1\"/>";

#[test]
fn several_bodies_are_one_tree_under_the_world() {
    let robot = in_world(&format!(
        "<body name='a'><joint name='x'/>{BALL}</body><body name='b'>{BALL}<body name='c'><joint name='y'/>{BALL}</body></body>"
    ));
    let links: Vec<&str> = robot.description.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(links, ["world", "a", "b", "c"]);
    assert!(robot.description.links[0].mass_properties.is_none());
    let joints: Vec<(&str, &str, &str)> = robot
        .description
        .joints
        .iter()
        .map(|joint| (joint.name.as_str(), joint.parent.as_str(), joint.child.as_str()))
        .collect();
    assert_eq!(joints, [("x", "world", "a"), ("b_fixed", "world", "b"), ("y", "b", "c")]);
    assert_eq!(robot.report.counts.degrees_of_freedom, 2);
    assert!(Model::new(robot.description).is_ok());
}

#[test]
fn a_free_joint_is_a_floating_one_from_the_world() {
    let robot = in_world(&format!("<body name='trunk' pos='1 2 3'><freejoint name='root'/>{BALL}</body>"));
    let joint = &robot.description.joints[0];
    assert_eq!(
        (joint.name.as_str(), joint.kind, joint.parent.as_str()),
        ("root", JointKind::Floating, "world")
    );
    // Its q is the pose in the world, independent of the placement in the file.
    assert_eq!(joint.parent_from_joint.translation, [0.0; 3]);
    let model = Model::new(robot.description.clone()).expect("a robot");
    assert_eq!(model.named_pose("qpos0").expect("its own pose").0, [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]);
    assert!(robot.description.root_floats());
}

#[test]
fn a_floating_base_is_added_where_nothing_floats() {
    let options = LoadOptions::default().with_floating_base();
    let fixed = format!("<mujoco><worldbody><body name='a'><joint/>{BALL}</body></worldbody></mujoco>");
    let robot = parse(&fixed, &options).expect("a robot");
    assert_eq!((robot.description.base, robot.report.counts.degrees_of_freedom), (Base::Floating, 7));
    let free = fixed.replace("<joint/>", "<freejoint/>");
    let robot = parse(&free, &options).expect("a robot");
    assert_eq!((robot.description.base, robot.report.counts.degrees_of_freedom), (Base::Fixed, 6));
}

/// A world with a floor, a table, and these bodies.
pub(crate) fn scene(bodies: &str) -> String {
    let floor = "<geom name='floor' type='plane' size='1 1 1'/>";
    format!(
        "<mujoco><worldbody>{floor}{bodies}<body name='table'><geom type='box' size='1 1 .1'/></body></worldbody></mujoco>"
    )
}

/// The treatments of findings about the whole file.
fn notes_on_base(robot: &Robot) -> Vec<Disposition> {
    let findings = robot.report.findings.iter().filter(|finding| finding.place() == "mujoco");
    findings.map(robot_dynamics::description::Finding::disposition).collect()
}

/// In a scene the robot floats, and not the world with table and floor: 6 + 1 degrees of freedom, and the
/// base moves the mass of the robot.
#[test]
fn the_robot_of_a_scene_floats() {
    let options = LoadOptions::default().with_floating_base();
    let robot = |name: &str| {
        format!(
            "<body name='{name}' pos='0 0 1'>{BALL}<body name='{name} arm'><joint name='{name} elbow' axis='0 1 0'/>{BALL}</body></body>"
        )
    };
    let read = parse(&scene(&robot("r2d2")), &options).expect("a scene");
    let table = read.description.links.iter().find(|link| link.name == "table").expect("the table");
    let table = table.mass_properties.expect("a box of water").mass();
    let model = Model::new(read.description.clone()).expect("a robot");
    assert_eq!(
        (read.description.base, model.nv(), read.report.counts.degrees_of_freedom),
        (Base::Fixed, 7, 7)
    );
    let q = robot_dynamics::model::neutral(&model);
    let mass = model.mass_matrix(&q).expect("M");
    assert!((mass[(0, 0)] - (model.total_mass() - table)).abs() < 1e-9 * mass[(0, 0)]);
    let place = |name: &str, q: &[f64]| {
        model.frame_pose(q, model.frame_named(name).expect("a link")).expect("a pose").translation
    };
    assert_eq!(place("r2d2", &q), [0.0, 0.0, 1.0]);
    let base = model.joint("floating_base").expect("the base's joint");
    let mut moved = q.clone();
    moved[base.q_index] = 3.0;
    assert_eq!((place("r2d2", &moved), place("table", &moved)), ([3.0, 0.0, 1.0], [0.0; 3]));
    assert_eq!(notes_on_base(&read), [Disposition::Defaulted], "{}", read.report);

    // With two robots the choice is ambiguous, and a robot that a joint connects to the world has no base.
    for bodies in
        [robot("r2d2") + &robot("c3po"), format!("<body name='door'><joint name='hinge'/>{BALL}</body>")]
    {
        let refused = parse(&scene(&bodies), &options).expect_err("no robot is meant");
        assert!(matches!(refused.errors(), [MjcfError::Misplaced { .. }]), "{refused}");
    }
    // A robot that floats in the file.
    let free = robot("r2d2").replacen("<geom", "<freejoint/><geom", 1);
    let read = parse(&scene(&free), &options).expect("a scene");
    assert_eq!(read.report.counts.degrees_of_freedom, 7, "{}", read.report);
    assert_eq!(notes_on_base(&read), [Disposition::Ignored { physics: false }], "{}", read.report);
}

#[test]
fn elements_without_a_name_get_unique_names() {
    let robot = in_world(&format!(
        "<body><joint/><joint axis='1 0 0'/>{BALL}</body><body name='body_1'><joint name='body_1_hinge'/>{BALL}</body>"
    ));
    let links: Vec<&str> = robot.description.links.iter().map(|link| link.name.as_str()).collect();
    // The names of the file take precedence.
    assert_eq!(links, ["world", "body_1_2/body_1_2_hinge", "body_1_2", "body_1"]);
    let joints: Vec<&str> = robot.description.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(joints, ["body_1_2_hinge", "body_1_2_hinge_2", "body_1_hinge"]);
    assert_eq!(robot.report.counts.defaulted, 3, "{}", robot.report);
}

#[test]
fn a_site_named_as_a_body_is_a_frame_of_another_name() {
    let robot = in_world(&format!(
        "<body name='a'><joint/>{BALL}<site name='a' pos='1 0 0'/><site pos='0 1 0'/></body>"
    ));
    let frames: Vec<(&str, [f64; 3])> = robot
        .description
        .frames
        .iter()
        .map(|frame| (frame.name.as_str(), frame.link_from_frame.translation))
        .collect();
    assert_eq!(frames, [("a_2", [1.0, 0.0, 0.0])]);
}

#[test]
fn flags_switch_forces_off() {
    let text = |flag: &str| {
        format!(
            "<mujoco><option><flag {flag}/></option><worldbody><body><joint stiffness='3' damping='2' frictionloss='1'/>{BALL}\
             </body></worldbody></mujoco>"
        )
    };
    let passive = |flag: &str| {
        let joint = read(&text(flag)).description.joints[0].passive;
        [joint.stiffness, joint.damping, joint.friction]
    };
    assert_eq!(passive("spring='enable'"), [3.0, 2.0, 1.0]);
    assert_eq!(passive("spring='disable'"), [0.0, 2.0, 1.0]);
    assert_eq!(passive("damper='disable'"), [3.0, 0.0, 1.0]);
    assert_eq!(passive("frictionloss='disable'"), [3.0, 2.0, 0.0]);
    assert_eq!(passive("constraint='disable'"), [3.0, 2.0, 0.0]);
}

/// As in MuJoCo, a disabled constraint does not act, and `constraint` disables all of them.
#[test]
fn flags_switch_constraints_off() {
    let left = |flag: &str| {
        let text = format!(
            "<mujoco><option><flag {flag}/></option><worldbody><body><joint name='j' range='0 90'/>{BALL}</body></worldbody>\
             <tendon><fixed name='t' range='0 1'><joint joint='j' coef='1'/></fixed></tendon>
             <equality><joint joint1='j'/></equality></mujoco>"
        );
        let robot = read(&text);
        assert_eq!(robot.report.warnings().count(), 0, "{flag}: {}", robot.report);
        let robot = robot.description;
        let [joint, tendon] = [robot.joints[0].limits, robot.tendons[0].limits];
        let is_limited = joint.upper.is_finite() && tendon.lower.is_finite();
        assert_eq!(is_limited, joint.lower.is_finite() || tendon.upper.is_finite());
        let touches = robot.shapes.iter().any(|shape| shape.surface.contype != 0);
        assert_eq!(touches, robot.shapes.iter().any(|shape| shape.role == ShapeRole::Collision));
        [is_limited, touches, !robot.equalities.is_empty()]
    };
    assert_eq!(left("constraint='enable'"), [true; 3]);
    assert_eq!(left("limit='disable'"), [false, true, true]);
    assert_eq!(left("contact='disable'"), [true, false, true]);
    assert_eq!(left("equality='disable'"), [true, true, false]);
    assert_eq!(left("constraint='disable'"), [false; 3]);
}

/// As in MuJoCo, `spring` and `damper` together also disable the compensation of gravity. `passive`, which
/// earlier versions have, disables both.
#[test]
fn flags_switch_gravity_compensation_off() {
    for (flag, compensation) in [
        ("spring='disable'", 1.0),
        ("damper='disable'", 1.0),
        ("spring='disable' damper='disable'", 0.0),
        ("passive='disable'", 0.0),
    ] {
        let text = format!(
            "<mujoco><option><flag {flag}/></option><worldbody><body gravcomp='1'><joint stiffness='1'/>{BALL}</body></worldbody></mujoco>"
        );
        let robot = read(&text);
        assert_eq!(robot.report.warnings().count(), 0, "{flag}: {}", robot.report);
        assert_eq!(robot.description.links[1].gravity_compensation, compensation, "{flag}");
        assert_eq!(
            robot.description.joints[0].passive.stiffness,
            f64::from(flag == "damper='disable'"),
            "{flag}"
        );
    }
}

/// An element that refers to a part of a deformable body is left out with a warning, like the body. Other
/// unknown names are errors.
#[test]
fn parts_of_deformable_bodies_can_be_referred_to() {
    let text = |body: &str| {
        format!(
            "<mujoco><worldbody><body name='pin'>{BALL}<flexcomp type='grid' count='3 3 1' name='flag'/></body>
             <body><composite prefix='rope' type='cable' count='4 1 1'/></body></worldbody>
             <equality><connect body1='{body}' anchor='0 0 0'/></equality></mujoco>"
        )
    };
    for body in ["flag_0", "flag_12", "ropeB_first", "ropeB_last", "ropeB3"] {
        let robot = read(&text(body));
        assert_eq!(robot.report.counts.ignored_physics, 3, "{body}: {}", robot.report);
        assert!(robot.description.equalities.is_empty());
    }
    for body in ["flag_", "flag_x", "flags_0", "ropeB", "rope_x", "ropeX1"] {
        assert!(parse(&text(body), &LoadOptions::default()).is_err(), "{body}");
    }
}

/// As in MuJoCo, a bound of a range can be infinite, but no other number.
#[test]
fn bounds_can_be_infinite() {
    let text = |joint: &str, motor: &str| {
        format!(
            "<mujoco><worldbody><body><joint name='j' {joint}/>{BALL}</body></worldbody>
             <actuator><motor joint='j' {motor}/></actuator></mujoco>"
        )
    };
    let of = |joint: &str, motor: &str| read(&text(joint, motor)).description;
    let limits = |joint: &str| {
        let limits = of(joint, "").joints[0].limits;
        [limits.lower, limits.upper]
    };
    let infinite = [f64::NEG_INFINITY, f64::INFINITY];
    assert_eq!(limits("range='-inf inf'"), infinite);
    assert_eq!(limits("limited='true' range='-Infinity INF'"), infinite);
    assert_eq!(limits("range='-inf 180'"), [f64::NEG_INFINITY, std::f64::consts::PI]);
    assert_eq!(of("", "ctrlrange='-inf inf'").actuators[0].control_range, infinite);
    assert_eq!(of("", "forcerange='-3 inf'").actuators[0].force_range, [-3.0, f64::INFINITY]);
    for (joint, motor) in [
        ("range='-1e400 1'", ""),
        ("range='nan 1'", ""),
        ("range='inf'", ""),
        ("range='0 1 inf'", ""),
        ("range='0 inf' armature='inf'", ""),
        ("range='0 inf'", "ctrlrange='0 x'"),
    ] {
        assert!(
            robot_dynamics_mjcf::parse(&text(joint, motor), &LoadOptions::default()).is_err(),
            "{joint} {motor}"
        );
    }
}

#[test]
fn the_robot_has_its_models_name_or_its_files() {
    assert_eq!(read("<mujoco model='m'/>").description.name, "m");
    let folder = std::env::temp_dir().join(format!("mjcf-name-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("walker.xml");
    std::fs::write(&file, "<mujoco/>").expect("a file");
    assert_eq!(
        robot_dynamics_mjcf::load(&file, &LoadOptions::default()).expect("a robot").description.name,
        "walker"
    );
    std::fs::remove_dir_all(&folder).expect("the folder");
}

#[test]
fn inertias_are_repaired_on_request() {
    let text = "<mujoco><worldbody><body name='a'><joint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/></body></worldbody></mujoco>";
    let written = read(text);
    assert_eq!(written.report.counts.as_written, 1, "{}", written.report);
    let repaired = parse(text, &LoadOptions::default().with_repaired_inertia()).expect("a robot");
    assert_eq!(repaired.report.counts.repaired, 1, "{}", repaired.report);
    let body = repaired.description.links[1].mass_properties.expect("a body");
    assert!(body.flaw().is_none(), "{body:?}");
}

/// As in versions of MuJoCo in which `shellinertia` was an attribute of mesh geoms.
#[test]
fn a_mesh_geom_with_shell_inertia_has_its_mass_in_its_surface() {
    let text = |geom: &str, mesh: &str| {
        format!(
            "<mujoco><asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 0 3 2 1 2 3' {mesh}/></asset>\
             <worldbody><body><joint/><geom type='mesh' mesh='m' {geom}/></body></worldbody></mujoco>"
        )
    };
    let old = read(&text("shellinertia='true'", ""));
    let new = read(&text("", "inertia='shell'"));
    assert_eq!(old.description.links[1].mass_properties, new.description.links[1].mass_properties);
    assert_eq!((old.report.counts.as_written, new.report.counts.as_written), (1, 0));
    // Three faces of ½ m², and one of ½√3 m².
    let mass = new.description.links[1].mass_properties.expect("a body").mass();
    assert!((mass - 1000.0 * (1.5 + 0.75_f64.sqrt())).abs() < 1e-10, "{mass}");
}

/// Ninety radians are implausible, and the plausibility check suspects the unit.
#[test]
fn angles_in_a_wrong_unit_are_suspected() {
    let suspected = |unit: &str| {
        let robot = read(&format!(
            "<mujoco><compiler angle='{unit}'/><worldbody><body name='a' euler='90 0 0'><joint/>{BALL}</body></worldbody></mujoco>"
        ));
        robot_dynamics::plausibility::suspicions(&robot.description, &robot.angles).len()
    };
    assert_eq!((suspected("degree"), suspected("radian")), (0, 1));
}

/// Springs of ball and free joints are written and read back, with their rest poses and all numbers.
#[test]
fn springs_of_ball_and_free_joints_are_written() {
    let file = crate::golden::root().join("testdata/mjcf/placement_springs.xml");
    let robot = robot_dynamics_mjcf::load(file, &LoadOptions::default()).expect("a robot").description;
    let written = robot_dynamics_mjcf::write(&robot, None).expect("a file");
    assert!(written.left_out.iter().all(|left| !left.place.contains("joint")), "{:?}", written.left_out);
    let back = parse(&written.text, &LoadOptions::default()).expect("a robot").description;
    let mut springs = 0;
    for (own, joint) in robot.joints.iter().zip(&back.joints) {
        assert_eq!((&own.name, own.higher_terms), (&joint.name, joint.higher_terms));
        let (Some(own), Some(spring)) = (own.spring, joint.spring) else {
            assert_eq!(own.spring, joint.spring);
            continue;
        };
        assert_eq!(own.stiffness, spring.stiffness);
        let off = own.rest.inverse().compose(&spring.rest);
        assert!(off.translation.iter().all(|x| x.abs() < 1e-14), "{off:?}");
        assert!((0..3).all(|k| (off.rotation[k][k] - 1.0).abs() < 1e-14), "{off:?}");
        springs += 1;
    }
    assert_eq!(springs, 6);
}

/// As in MuJoCo 4, a keyframe that was written for a part of the scene is completed by the pose of the file.
#[test]
fn short_keyframes_are_completed() {
    let text = "<mujoco><worldbody><body><joint name='hinge'/><geom size='1'/></body>
          <body pos='1 2 3'><freejoint name='free'/><geom size='1'/></body></worldbody>
        <actuator><motor joint='hinge'/><motor joint='hinge'/></actuator>
        <keyframe><key name='home' qpos='0.5' qvel='0.1' ctrl='1'/></keyframe></mujoco>";
    let robot = robot_dynamics_mjcf::parse(text, &LoadOptions::default()).expect("a robot");
    let home = &robot.description.poses[0];
    let free = vec![1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(home.positions, [("hinge".to_owned(), vec![0.5]), ("free".to_owned(), free)]);
    assert_eq!(home.velocities, [("hinge".to_owned(), vec![0.1])]);
    assert_eq!(home.controls, [1.0, 0.0]);
    let long = text.replace("ctrl='1'", "ctrl='1 2 3'");
    let refused = robot_dynamics_mjcf::parse(&long, &LoadOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("ctrl"), "{refused}");
}

#[test]
fn states_of_keyframes_are_named_if_they_act() {
    for (attributes, count) in [("act='0' plastic='0'", 0), ("act='0.5'", 1), ("act='0.5' plastic='0.1'", 2)]
    {
        let text = format!(
            "<mujoco><worldbody><body><joint name='j' stiffness='1' springyield='1'/><geom size='0.1'/></body></worldbody>
             <actuator><general joint='j' dyntype='filter' dynprm='1'/></actuator>
             <keyframe><key {attributes}/></keyframe></mujoco>"
        );
        let report = parse(&text, &LoadOptions::default()).expect("a robot").report;
        assert_eq!(report.counts.ignored_physics, count, "{attributes}: {report}");
    }
}

#[test]
fn replicates_have_a_prefix_without_effect() {
    let text = "<mujoco><worldbody><replicate count='2' offset='1 0 0' prefix='a'><body name='b'><joint/>
        <geom size='0.1'/></body></replicate></worldbody></mujoco>";
    let robot = parse(text, &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.report.warnings().count(), 0, "{}", robot.report);
    assert!(robot.description.links.iter().any(|link| link.name == "b1"));
}
