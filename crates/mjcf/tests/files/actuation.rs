//! Compares tendons, equalities, actuators, poses and shapes with MuJoCo.

use robot_dynamics::conventions::{configuration_from_mujoco, force_from_mujoco, velocity_from_mujoco};
use robot_dynamics::description::{
    Activation, Equality, JointKind, Limits, PassiveForces, RobotDescription, Shape, ShapeRole, Transmission,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::Actuation;
use robot_dynamics_mjcf::{LoadOptions, parse};
use serde_json::Value;

use crate::golden::{Golden, assert_near, goldens, numbers, root};

const SUMMED: f64 = 1e-12;
const UNBOUNDED: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn rows<'a>(golden: &'a Golden, name: &str) -> &'a [Value] {
    golden.value[name].as_array().expect("a list")
}

fn range(row: &Value, limited: &str, range: &str) -> [f64; 2] {
    let bounds = numbers(&row[range]);
    if row[limited] == true { [bounds[0], bounds[1]] } else { UNBOUNDED }
}

/// The properties of a tendon that both kinds have.
struct Tendon<'a> {
    name: &'a str,
    passive: PassiveForces,
    dead_band: f64,
    limits: Limits,
}

/// The robot's tendons by name.
fn tendons(robot: &RobotDescription) -> Vec<Tendon<'_>> {
    let over_joints = robot.tendons.iter().map(|tendon| Tendon {
        name: &tendon.name,
        passive: tendon.passive,
        dead_band: tendon.dead_band,
        limits: tendon.limits,
    });
    let along_paths = robot.spatial_tendons.iter().map(|tendon| Tendon {
        name: &tendon.name,
        passive: tendon.passive,
        dead_band: tendon.dead_band,
        limits: tendon.limits,
    });
    over_joints.chain(along_paths).collect()
}

#[test]
fn tendons_are_mujocos() {
    let mut compared = 0;
    for golden in goldens() {
        let robot = &golden.robot.description;
        let model = Model::new(robot.clone()).expect("a robot");
        let actuation = Actuation::new(&model).expect("actuation");
        let all = tendons(robot);
        assert_eq!(all.len(), rows(&golden, "tendons").len(), "{}", golden.file);
        for (index, theirs) in rows(&golden, "tendons").iter().enumerate() {
            let name = theirs["name"].as_str().expect("a name");
            let own = all.iter().position(|tendon| tendon.name == name).unwrap_or(index);
            let Tendon { name, passive, dead_band, limits } = &all[own];
            let what = format!("{}: tendon {name}", golden.file);
            let numbers_of = [passive.stiffness, passive.damping, passive.armature, passive.friction];
            let expected =
                ["stiffness", "damping", "armature", "friction"].map(|name| numbers(&theirs[name])[0]);
            assert_near(&what, &numbers_of, &expected, SUMMED);
            let spring = [passive.rest, passive.rest + dead_band];
            assert_near(&what, &spring, &numbers(&theirs["spring"]), SUMMED);
            assert_eq!([limits.lower, limits.upper], range(theirs, "limited", "range"), "{what}");
            for state in rows(&golden, "states") {
                let (q, _) = Golden::state(&model, state);
                let (mut lengths, mut rows) = (vec![0.0; all.len()], vec![0.0; all.len() * model.nv()]);
                actuation.tendon_lengths(&model, &mut actuation.workspace(), &q, &mut lengths, &mut rows);
                let expected = numbers(&state["tendon_lengths"])[index];
                assert_near(&what, &[lengths[own]], &[expected], SUMMED);
                compared += 1;
            }
        }
    }
    assert!(compared >= 36, "{compared}");
}

/// Compares actuator forces at random states. They follow from this library's force law and MuJoCo's lengths
/// and velocities; the lengths are compared with q and gear.
#[test]
fn actuators_are_mujocos() {
    let mut compared = 0;
    for golden in goldens() {
        let robot = &golden.robot.description;
        let model = Model::new(robot.clone()).expect("a robot");
        assert_eq!(robot.actuators.len(), rows(&golden, "actuators").len(), "{}", golden.file);
        for (index, (actuator, theirs)) in robot.actuators.iter().zip(rows(&golden, "actuators")).enumerate()
        {
            let what = format!("{}: actuator {}", golden.file, actuator.name);
            let has_several_inputs = actuator.adds_to.is_some()
                || robot.actuators.iter().any(|other| other.adds_to.as_ref() == Some(&actuator.name));
            if ["face", "turned"].contains(&actuator.name.as_str()) || has_several_inputs {
                // Its setpoint is more than half a turn away, or it has others.
                // `torques_of_actuators_are_mujocos` compares it.
                continue;
            }
            let name = theirs["name"].as_str().expect("a name");
            assert!(name.is_empty() || name == actuator.name, "{what}");
            let control = range(theirs, "control_limited", "control_range");
            let near = |a: f64, b: f64| a == b || (a - b).abs() < 1e-14;
            assert!(
                near(actuator.control_range[0], control[0]) && near(actuator.control_range[1], control[1]),
                "{what}"
            );
            assert_eq!(actuator.force_range, range(theirs, "force_limited", "force_range"), "{what}");
            // The index of its activation: the number of earlier actuators that have one.
            let stateful = |actuator: &robot_dynamics::description::ActuatorDescription| {
                actuator.activation != Activation::None
            };
            let place = robot.actuators[..index].iter().filter(|other| stateful(other)).count();
            for state in rows(&golden, "states") {
                let (q, v) = Golden::state(&model, state);
                let of = |name: &str| numbers(&state[name])[index];
                let (length, velocity) = (of("actuator_lengths"), of("actuator_velocities"));
                let control = of("ctrl").max(actuator.control_range[0]).min(actuator.control_range[1]);
                let u = if stateful(actuator) { numbers(&state["act"])[place] } else { control };
                let force = actuator.force(u, length, velocity);
                assert_near(&what, &[force], &[of("actuator_forces")], SUMMED);
                if let Transmission::Joint { joint, gear } = &actuator.transmission {
                    let joint = model.joints().iter().find(|own| own.name == *joint).expect("a joint");
                    if joint.nv == 1 {
                        let expected = [gear[0] * q[joint.q_index], gear[0] * v[joint.v_index]];
                        assert_near(&what, &expected, &[length, velocity], SUMMED);
                    }
                }
                compared += 1;
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

/// Compares the forces of actuators and their torques on the joints at random states. Lengths and velocities
/// of their transmissions are this library's. A cylinder of a muscle or a crank near its dead center
/// amplifies rounding, hence the tolerance.
#[test]
fn torques_of_actuators_are_mujocos() {
    const ALLOWED: f64 = 1e-11;
    let mut compared = 0;
    for golden in goldens() {
        let robot = &golden.robot.description;
        if robot.actuators.is_empty() {
            continue;
        }
        let model = Model::new(robot.clone()).expect("a robot");
        let actuation = Actuation::new(&model).expect("actuation");
        let mut memory = actuation.workspace();
        for state in rows(&golden, "states") {
            let (q, v) = Golden::state(&model, state);
            let (mut u, mut act) = (numbers(&state["ctrl"]), numbers(&state["act"]).into_iter());
            for (u, actuator) in u.iter_mut().zip(&robot.actuators) {
                if actuator.activation != Activation::None {
                    *u = act.next().expect("an activation");
                }
            }
            let (mut forces, mut tau) = (vec![0.0; u.len()], vec![0.0; model.nv()]);
            actuation.actuator_forces(&model, &mut memory, &u, &q, &v, &mut forces);
            let what = format!("{}: forces", golden.file);
            let allowed = ALLOWED.max(golden.tolerance());
            assert_near(&what, &forces, &numbers(&state["actuator_forces"]), allowed);
            actuation.actuator_torques(&model, &mut memory, &u, &q, &v, &mut tau);
            let mut expected = vec![0.0; model.nv()];
            force_from_mujoco(&model, &q, &numbers(&state["actuator_torques"]), &mut expected);
            assert_near(&format!("{}: torques", golden.file), &tau, &expected, allowed);
            compared += 1;
        }
    }
    assert!(compared >= 20, "{compared}");
}

#[test]
fn equalities_hold_where_the_file_places_the_bodies() {
    let golden =
        goldens().into_iter().find(|golden| golden.file.ends_with("equalities.xml")).expect("the file");
    let robot = &golden.robot.description;
    let model = Model::new(robot.clone()).expect("a robot");
    let mut q = vec![0.0; model.nq()];
    configuration_from_mujoco(&model, &numbers(&golden.value["qpos0"]), &mut q);
    let pose = |link: &str| model.frame_pose(&q, model.frame(link).expect("a link")).expect("finite");
    assert_eq!(robot.equalities.len(), rows(&golden, "equalities").len());
    for (equality, theirs) in robot.equalities.iter().zip(rows(&golden, "equalities")) {
        let name = theirs["name"].as_str().expect("a name");
        assert!(name.is_empty() || name == equality.name);
        assert_eq!(theirs["active"], equality.active, "{name}");
        assert_near(name, &equality.solref, &numbers(&theirs["solref"]), 0.0);
        match &equality.kind {
            Equality::Joints { joint, leader, polynomial } => match &leader {
                Some(leader) => {
                    assert_eq!((joint, leader), (&("c".to_owned(), 0.0), &("a".to_owned(), 0.3)));
                    assert_eq!(polynomial, &[0.1, -2.0, 0.5, 0.0, 0.25]);
                }
                None => assert_eq!((joint.0.as_str(), polynomial), ("b", &[0.0, 1.0, 0.0, 0.0, 0.0])),
            },
            Equality::Tendons { .. } => panic!("{name}: the file has no equalities of tendons"),
            // Sites keep their positions on the bodies, so the two points need not coincide in the pose of
            // the file.
            Equality::Connect { a, b } if equality.name == "ends" => {
                assert_eq!((a, b), (&("a".to_owned(), [0.3, 0.0, 0.1]), &("c".to_owned(), [0.1, 0.0, 0.0])));
            }
            Equality::Connect { a, b } => {
                let (a, b) = (pose(&a.0).apply(a.1), pose(&b.0).apply(b.1));
                assert_near(name, &a, &b, 1e-14);
            }
            Equality::Weld { a, b, a_from_b, .. } => {
                let expected = match name {
                    "stuck" => pose(a).inverse().compose(&pose(b)),
                    "held" => robot_dynamics::description::Pose::from_translation_quaternion_wxyz(
                        [0.1, 0.2, 0.3],
                        [0.9, 0.1, 0.0, 0.2],
                    ),
                    // Both sites coincide: the pose of the site in a, times the inverse of the pose of the
                    // other site in b.
                    _ => robot_dynamics::description::Pose::from_translation([0.3, 0.0, 0.1]).compose(
                        &robot_dynamics::description::Pose::from_xyz_rpy([0.1, 0.0, 0.0], [0.0, 0.2, 0.0])
                            .inverse(),
                    ),
                };
                assert_near(name, a_from_b.rotation.as_flattened(), expected.rotation.as_flattened(), 1e-14);
                assert_near(name, &a_from_b.translation, &expected.translation, 1e-14);
            }
        }
    }
}

#[test]
fn keyframes_are_poses() {
    let mut compared = 0;
    for golden in goldens() {
        let robot = &golden.robot.description;
        let model = Model::new(robot.clone()).expect("a robot");
        for key in rows(&golden, "keys") {
            let name = key["name"].as_str().expect("a name");
            let (q, v) = model.named_pose(name).expect("a pose");
            let (mut expected, mut rate) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
            configuration_from_mujoco(&model, &numbers(&key["qpos"]), &mut expected);
            velocity_from_mujoco(&model, &expected, &numbers(&key["qvel"]), &mut rate);
            let what = format!("{}: {name}", golden.file);
            assert_near(&what, &q, &expected, SUMMED);
            assert_near(&what, &v, &rate, SUMMED);
            let pose = robot.poses.iter().find(|pose| pose.name == name).expect("a pose");
            if !pose.controls.is_empty() {
                assert_eq!(pose.controls, numbers(&key["ctrl"]), "{what}");
            }
            compared += 1;
        }
        // The pose of the file has a name if it is not neutral.
        let mut initial = vec![0.0; model.nq()];
        configuration_from_mujoco(&model, &numbers(&golden.value["qpos0"]), &mut initial);
        match model.named_pose("qpos0") {
            Some((q, _)) => assert_near(&golden.file, &q, &initial, SUMMED),
            None => assert_near(&golden.file, &robot_dynamics::model::neutral(&model), &initial, SUMMED),
        }
    }
    assert!(compared >= 7, "{compared}");
}

#[test]
fn shapes_are_kept_with_place_colour_and_surface() {
    let text = r#"<mujoco><compiler angle="radian"/>
      <asset><material name="red" rgba="1 0 0 1"/><mesh name="arm" file="x/arm.stl" scale="2 2 2" refpos="1 0 0"/></asset>
      <default><geom friction="0.5"/><default class="see"><geom contype="0" conaffinity="0" material="red"/></default></default>
      <worldbody>
        <geom name="floor" type="plane" size="3 4 0.1"/>
        <body name="a"><joint/>
          <geom name="foot" size="0.1" pos="1 2 3" solref="0.01" condim="6" priority="2" margin="0.001"/>
          <geom class="see" type="box" size="1 2 3" euler="0 0 0.5"/>
          <geom class="see" type="mesh" mesh="arm" mass="0" rgba="0 1 0 0.5"/>
          <geom class="see" type="ellipsoid" size="1 2 3"/>
          <geom class="see" type="cylinder" size="1 2"/>
          <geom class="see" type="capsule" fromto="0 0 0 0 0 2" size="1"/>
        </body>
      </worldbody></mujoco>"#;
    let robot = parse(text, &LoadOptions::default()).expect("a robot").description;
    let forms: Vec<Shape> = robot.shapes.iter().map(|shape| shape.shape.clone()).collect();
    assert_eq!(
        forms,
        [
            Shape::Plane { half_size: [3.0, 4.0] },
            Shape::Sphere { radius: 0.1 },
            Shape::Box { size: [2.0, 4.0, 6.0] },
            Shape::Mesh { name: "x/arm.stl".into(), file: None, scale: [2.0; 3] },
            Shape::Ellipsoid { half_axes: [1.0, 2.0, 3.0] },
            Shape::Cylinder { radius: 1.0, length: 4.0 },
            Shape::Capsule { radius: 1.0, length: 2.0 },
        ]
    );
    let links: Vec<&str> = robot.shapes.iter().map(|shape| shape.link.as_str()).collect();
    assert_eq!(links, ["world", "a", "a", "a", "a", "a", "a"]);
    let foot = &robot.shapes[1];
    assert_eq!((foot.name.as_str(), foot.role, foot.color), ("foot", ShapeRole::Collision, None));
    assert_eq!(foot.link_from_shape.translation, [1.0, 2.0, 3.0]);
    let surface = foot.surface;
    assert_eq!((surface.friction, surface.solref), ([0.5, 0.005, 0.0001], [0.01, 1.0]));
    assert_eq!((surface.condim, surface.priority, surface.margin), (6, 2, 0.001));
    let (brick, mesh) = (&robot.shapes[2], &robot.shapes[3]);
    assert_eq!((brick.role, brick.color), (ShapeRole::Visual, Some([1.0, 0.0, 0.0, 1.0])));
    assert_eq!(mesh.color, Some([0.0, 1.0, 0.0, 0.5]));
    // A point x of the mesh file is at 2 (x − (1, 0, 0)).
    assert_near("mesh", &mesh.link_from_shape.translation, &[-2.0, 0.0, 0.0], 1e-15);
}

#[test]
fn excluded_pairs_are_read() {
    let golden = goldens().into_iter().find(|golden| golden.file.ends_with("world.xml")).expect("the file");
    let pairs = &golden.robot.description.contact_exclusions;
    let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
    assert_eq!(pairs, &[pair("pole", "table"), pair("wheel", "world")]);
}

/// Meshes of shapes are located by the settings of the file, and not opened.
#[test]
fn mesh_files_are_found_beside_the_robot() {
    let robot = robot_dynamics_mjcf::load(root().join("testdata/mjcf/meshes.xml"), &LoadOptions::default())
        .expect("a robot");
    let wedge = robot.description.shapes.iter().find(|shape| shape.link == "wedge").expect("a shape");
    let (name, file) = wedge.shape.file().expect("a mesh");
    assert_eq!(name, "wedge.stl");
    assert!(file.is_some_and(|file| file.ends_with("testdata/mjcf/meshes/wedge.stl")), "{file:?}");
    let kinds = robot.description.joints.iter().map(|joint| joint.kind);
    assert!(kinds.clone().all(|kind| matches!(kind, JointKind::Continuous { .. })), "{kinds:?}");
}

/// The armature of a tendon over one joint, and of an actuator on it, is added to the joint: 0.1·3² and
/// 0.1·(2·3)², as in MuJoCo's M.
#[test]
fn armature_of_a_tendon_over_one_joint_is_the_joints() {
    let text = "<mujoco><worldbody><body><joint name='b' armature='0.5'/><geom size='0.1'/></body></worldbody>\
        <tendon><fixed name='t' armature='0.1'><joint joint='b' coef='1'/><joint joint='b' coef='2'/></fixed></tendon>\
        <actuator><motor tendon='t' gear='2' armature='0.1'/></actuator></mujoco>";
    let robot = parse(text, &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.report.counts.ignored_physics, 0, "{}", robot.report);
    let armature = robot.description.joints[0].passive.armature;
    assert!((armature - (0.5 + 0.9 + 3.6)).abs() < 1e-14, "{armature}");
    assert_eq!(robot.description.tendons[0].passive.armature, 0.0);
}

/// MuJoCo: the forces are 0, 0 and 4 at q = 0.5 with the controls 1, 2 and 4. Controls of disabled actuators
/// stay.
#[test]
fn disabled_groups_of_actuators_exert_no_force() {
    let text = "<mujoco><option actuatorgroupdisable='0 3'/><worldbody>
          <body><joint name='j'/><geom size='.1'/></body></worldbody>
        <actuator><motor joint='j'/><position joint='j' kp='3' group='3'/><motor joint='j' group='2'/></actuator>
      </mujoco>";
    let read = parse(text, &LoadOptions::default()).expect("a robot");
    assert_eq!(read.report.counts.ignored_physics, 0, "{}", read.report);
    let model = Model::new(read.description).expect("a robot");
    let actuation = Actuation::new(&model).expect("actuation");
    let mut forces = [1.0; 3];
    actuation.actuator_forces(
        &model,
        &mut actuation.workspace(),
        &[1.0, 2.0, 4.0],
        &[0.5],
        &[0.0],
        &mut forces,
    );
    assert_eq!(forces, [0.0, 0.0, 4.0]);
}

/// A motor beyond the range of its control, on a joint through which gravity compensation acts.
fn compensated(flag: &str) -> (RobotDescription, [f64; 1]) {
    let text = format!(
        "<mujoco><option><flag {flag}/></option><worldbody><body gravcomp='1'>
          <joint name='j' axis='0 1 0' actuatorgravcomp='true'/><geom size='.1' pos='.3 0 0'/></body></worldbody>
        <actuator><motor joint='j' damping='2' armature='.5' ctrlrange='-1 1'/></actuator></mujoco>"
    );
    let read = parse(&text, &LoadOptions::default()).expect("a robot");
    assert_eq!(read.report.counts.ignored_physics, 0, "{}", read.report);
    let model = Model::new(read.description.clone()).expect("a robot");
    let actuation = Actuation::new(&model).expect("actuation");
    let mut forces = [f64::NAN];
    actuation.forces(&model, &mut actuation.workspace(), &[3.0], &[0.2], &[1.0], &mut forces);
    (read.description, forces)
}

/// MuJoCo: `qfrc_actuator` is −11.08187813, and −9.08187813 if `clampctrl` is disabled.
#[test]
fn controls_exceed_their_range_if_clamping_is_disabled() {
    for (flag, force) in [("clampctrl='enable'", -11.08187813), ("clampctrl='disable'", -9.08187813)] {
        let (_, [found]) = compensated(flag);
        // MuJoCo's numbers have 8 decimals.
        assert!((found - force).abs() < 1e-8, "{flag}: {found}");
    }
}

/// MuJoCo: `qfrc_actuator` is 0 without the gravity compensation through the actuator; the damping and the
/// armature of the motor remain.
#[test]
fn disabled_actuators_exert_no_force() {
    let (robot, forces) = compensated("actuation='disable'");
    assert_eq!(forces, [0.0]);
    let PassiveForces { armature, damping, .. } = robot.joints[0].passive;
    assert_eq!([armature, damping], [0.5, 2.0]);
}
