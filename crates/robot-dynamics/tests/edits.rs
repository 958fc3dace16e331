//! Edits of descriptions: laws that tie the edited robot to the original one.

use std::collections::BTreeSet;

use robot_dynamics::algorithms::{
    ReferenceFrame, forward_dynamics, frame_acceleration, frame_pose, frame_velocity, kinetic_energy,
    potential_energy,
};
use robot_dynamics::description::{
    ActuatorDescription, Base, JointKind, Mimic, ModelError, Mount, NamedPose, Pose, Quaternion,
    RandomRobotOptions, RobotDescription, SensorDescription, SensorKind, Transmission, pendulum,
    random_robot,
};
use robot_dynamics::model::{Joint, Model, Workspace, neutral, random_state};
use robot_dynamics::nalgebra::{Rotation3, Vector3};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{LoadOptions, load_description_from_text};

type Motion = [Vector3<f64>; 2];

/// The pose and the velocity of a link, along its own axes, in another link or in the world (`None`).
fn relative(model: &Model, q: &[f64], v: &[f64], link: &str, to: Option<(&str, Pose)>) -> (Pose, Motion) {
    let w = &mut Workspace::new(model);
    let mut of = |name: &str| {
        let frame = model.frame(name).expect("a link");
        let twist = frame_velocity(model, w, q, v, frame, ReferenceFrame::Local);
        let twist = [Vector3::from(twist.linear), Vector3::from(twist.angular)];
        (frame_pose(model, w, q, frame), twist)
    };
    let (world_from_link, twist) = of(link);
    let Some((parent, parent_from_joint)) = to else { return (world_from_link, twist) };
    let (world_from_parent, parent_twist) = of(parent);
    let parent_from_link = world_from_parent.inverse().compose(&world_from_link);
    let turn = |v: Vector3<f64>| {
        let back = Pose { translation: [0.0; 3], ..parent_from_link }.inverse();
        Vector3::from(back.rotate(v.into()))
    };
    let at = Vector3::from(parent_from_link.translation);
    let [linear, angular] = parent_twist;
    let twist = [twist[0] - turn(linear + angular.cross(&at)), twist[1] - turn(angular)];
    (parent_from_joint.inverse().compose(&parent_from_link), twist)
}

/// q and v of a joint of the new robot, from the motion of the links of the old robot.
fn joint_state(old: &Model, new: &Model, joint: &Joint, q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let same = old.joints().iter().find(|own| own.name == joint.name).expect("joints keep their names");
    let (own_q, own_v) = (q[same.q()].to_vec(), v[same.v()].to_vec());
    let described = new.description().joints.iter().find(|own| own.name == joint.name);
    let kind = joint.kind;
    if kind == JointKind::Floating {
        let parent = described.map(|joint| (joint.parent.as_str(), joint.parent_from_joint));
        let (pose, [linear, angular]) = relative(old, q, v, &joint.child_link, parent);
        let turn = Quaternion::from_rotation(&pose.rotation).to_xyzw();
        let v = [<[f64; 3]>::from(linear), <[f64; 3]>::from(angular)].concat();
        return ([&pose.translation[..], &turn[..]].concat(), v);
    }
    if same.kind == kind && same.child_link == joint.child_link {
        return (own_q, own_v);
    }
    match kind {
        JointKind::Universal { .. } => (vec![own_q[1], own_q[0]], vec![own_v[1], own_v[0]]),
        JointKind::Spherical => {
            let turn = Quaternion::from_xyzw([own_q[0], own_q[1], own_q[2], own_q[3]]);
            let v = turn.rotate([own_v[0], own_v[1], own_v[2]]).map(|x| -x);
            (turn.conjugate().to_xyzw().to_vec(), v.to_vec())
        }
        JointKind::Planar { .. } => {
            let back = Rotation3::from_axis_angle(&Vector3::z_axis(), -own_q[2]);
            let p = -(back * Vector3::new(own_q[0], own_q[1], 0.0));
            let turning = Vector3::new(0.0, 0.0, -own_v[2]);
            let rate = -(back * Vector3::new(own_v[0], own_v[1], 0.0)) + turning.cross(&p);
            (vec![p.x, p.y, -own_q[2]], vec![rate.x, rate.y, -own_v[2]])
        }
        _ => (own_q, own_v),
    }
}

/// A floating robot with another root has the same energies, the same poses of its links and, without
/// torques, the same accelerations of its links. Tolerances: some hundred roundings through a chain of links;
/// an acceleration is also multiplied by the condition of M, below 1e5 for these robots.
#[test]
fn a_floating_robot_moves_alike_from_any_root() {
    let mut reversed_kinds = BTreeSet::new();
    for seed in 0..150 {
        let passive = if seed % 3 == 0 { 0.4 } else { 0.0 };
        let options =
            RandomRobotOptions { base: Base::Floating, passive, mimic: 0.1, ..RandomRobotOptions::default() };
        let mut description = random_robot(seed, &options);
        if seed % 2 == 0 {
            // Frames that agree with those of joints, and joints that differ by a rotation only.
            for joint in description.joints.iter_mut().step_by(2) {
                joint.parent_from_joint = Pose::IDENTITY;
            }
            for joint in description.joints.iter_mut().step_by(3) {
                joint.parent_from_joint.translation = [0.0; 3];
            }
        }
        let old = Model::new(description.clone()).expect("random robots compile");
        let mut random = SplitMix64::new(seed);
        let root = &description.links
            [1 + usize::try_from(seed).expect("small") % (description.links.len() - 1)]
            .name;
        let mut edited = description.clone();
        match edited.set_root(root) {
            Ok(_) => {}
            Err(ModelError::Irreversible { .. }) if passive > 0.0 => {
                assert_eq!(edited, description, "a refused edit changes nothing");
                continue;
            }
            Err(error) => panic!("seed {seed}: {error}"),
        }
        let new = Model::new(edited.clone()).expect("a robot");
        for joint in &description.joints {
            let own = edited.joints.iter().find(|own| own.name == joint.name).expect("a joint");
            if own.parent != joint.parent && joint.kind != JointKind::Floating {
                reversed_kinds.insert(joint.kind.name());
            }
        }
        let state = random_state(&old, &mut random);
        let (mut q, mut v) = (neutral(&new), vec![0.0; new.nv()]);
        for joint in new.joints().iter().filter(|joint| joint.nv > 0) {
            let (own_q, own_v) = joint_state(&old, &new, joint, &state.q, &state.v);
            q[joint.q()].copy_from_slice(&own_q);
            v[joint.v()].copy_from_slice(&own_v);
        }
        let (ow, nw) = (&mut Workspace::new(&old), &mut Workspace::new(&new));
        let kinetic = [kinetic_energy(&old, ow, &state.q, &state.v), kinetic_energy(&new, nw, &q, &v)];
        assert!(
            (kinetic[0] - kinetic[1]).abs() < 1e-11 * kinetic[0],
            "seed {seed}, root {root}: {kinetic:?}"
        );
        let potential = [potential_energy(&old, ow, &state.q), potential_energy(&new, nw, &q)];
        assert!((potential[0] - potential[1]).abs() < 1e-10, "seed {seed}, root {root}: {potential:?}");
        let (mut a, mut b) = (vec![0.0; old.nv()], vec![0.0; new.nv()]);
        forward_dynamics(&old, ow, &state.q, &state.v, &vec![0.0; old.nv()], &mut a);
        forward_dynamics(&new, nw, &q, &v, &vec![0.0; new.nv()], &mut b);
        let size = a.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for link in &description.links {
            let [one, two] = [&old, &new].map(|model| model.frame(&link.name).expect("a link"));
            let poses = [frame_pose(&old, ow, &state.q, one), frame_pose(&new, nw, &q, two)];
            let apart = poses[0].inverse().compose(&poses[1]);
            let off = apart.translation.into_iter().chain([apart.rotation[0][1], apart.rotation[1][2]]);
            assert!(off.fold(0.0_f64, |most, x| most.max(x.abs())) < 1e-12, "seed {seed}: {}", link.name);
            let world = ReferenceFrame::LocalWorldAligned;
            let found = frame_acceleration(&new, nw, &q, &v, &b, two, world);
            let expected = frame_acceleration(&old, ow, &state.q, &state.v, &a, one, world);
            let pairs =
                found.linear.iter().zip(expected.linear).chain(found.angular.iter().zip(expected.angular));
            let off = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            assert!(off < 1e-9 * size, "seed {seed}, link {}: {off:e} of {size:e}", link.name);
        }
    }
    let all = ["continuous", "fixed", "helical", "planar", "prismatic", "revolute", "spherical", "universal"];
    assert_eq!(reversed_kinds.into_iter().collect::<Vec<_>>(), all);
}

/// A named pose gives the same pose of every link after a change of the root.
#[test]
fn named_poses_keep_their_places() {
    for seed in 0..60 {
        let options = RandomRobotOptions { base: Base::Floating, passive: 0.0, ..Default::default() };
        let mut description = random_robot(seed, &options);
        let old = Model::new(description.clone()).expect("random robots compile");
        let state = random_state(&old, &mut SplitMix64::new(seed));
        let of = |values: &[f64], of_q: bool| {
            let moving = old.joints().iter().filter(|joint| joint.nv > 0);
            moving
                .map(|joint| (joint.name.clone(), values[if of_q { joint.q() } else { joint.v() }].to_vec()))
                .collect::<Vec<_>>()
        };
        let mut pose = NamedPose::new("start", of(&state.q, true));
        pose.velocities = of(&state.v, false);
        description.poses.push(pose);
        description.poses.push(NamedPose::new("neutral", []));
        let mut edited = description.clone();
        let root = description.links[description.links.len() - 1 - usize::try_from(seed % 3).expect("small")]
            .name
            .clone();
        edited.set_root(&root).expect("joints without forces");
        let new = Model::new(edited).expect("a robot");
        let old = Model::new(description).expect("a robot");
        for name in ["start", "neutral"] {
            let [(q, v), (new_q, new_v)] = [&old, &new].map(|model| model.named_pose(name).expect("a pose"));
            for link in old.links() {
                let (one, twist) = relative(&old, &q, &v, &link.name, None);
                let (two, new_twist) = relative(&new, &new_q, &new_v, &link.name, None);
                let apart = one.inverse().compose(&two);
                assert!(Vector3::from(apart.translation).amax() < 1e-12, "seed {seed}, {}", link.name);
                assert!(apart.rotation[0][1].abs() + apart.rotation[1][2].abs() < 1e-12);
                let off = (twist[0] - new_twist[0]).amax().max((twist[1] - new_twist[1]).amax());
                assert!(off < 1e-11, "seed {seed}, {name}, {}: {off:e}", link.name);
            }
        }
    }
}

/// A robot held at its other end: M and g of a two-link arm that hangs from its tip link.
#[test]
fn a_fixed_base_holds_the_new_root() {
    let mut robot = pendulum(2.0, 0.5);
    robot.attach(&pendulum(1.0, 0.4), &Mount::on("tip").with_prefix("b_")).expect("other names");
    let notes = robot.set_root("b_rod").expect("hinges");
    assert_eq!(notes[0].to_string(), "base: link `b_rod` is fixed to the world, instead of link `ceiling`");
    let model = Model::new(robot).expect("a robot");
    // The first rod, m = 2 kg at 0.5 m from its hinge, now turns about the hinge at b_rod's origin, where its
    // mass is: only the ceiling without mass moves.
    let mass = model.mass_matrix(&[0.3, -0.2]).expect("M");
    assert!(mass.amax() < 1e-14, "{mass}");
    assert_eq!(model.coordinate_names().len(), 2);
}

/// A gripper and everything that refers to it is removed; the rest moves as the arm alone.
#[test]
fn removed_parts_take_their_references_with_them() {
    let text = r#"<mujoco><worldbody>
        <body name="arm"><joint name="lift" type="slide" axis="0 0 1"/><geom name="beam" size="0.1"/>
          <body name="palm" pos="0.3 0 0"><joint name="turn"/><geom name="pad" size="0.05"/>
            <site name="grip"/>
            <body name="finger" pos="0.1 0 0"><joint name="close" type="slide"/><geom size="0.02"/></body>
          </body>
          <body name="other" pos="-0.3 0 0"><joint name="swing"/><geom name="weight" size="0.05"/><site name="mark"/></body>
        </body></worldbody>
        <contact><pair geom1="beam" geom2="pad"/><exclude body1="arm" body2="finger"/></contact>
        <tendon><fixed name="cord"><joint joint="close" coef="1"/><joint joint="swing" coef="1"/></fixed></tendon>
        <equality><joint name="gear" joint1="swing" joint2="turn"/>
          <connect name="pin" body1="other" body2="palm" anchor="0 0 0"/></equality>
        <actuator><motor name="lifter" joint="lift"/><motor name="closer" joint="close"/>
          <motor name="puller" tendon="cord"/><motor name="swinger" joint="swing"/></actuator>
        <sensor><jointpos name="s_close" joint="close"/><jointpos name="s_swing" joint="swing"/>
          <framepos name="s_grip" objtype="site" objname="grip"/>
          <framepos name="s_rel" objtype="site" objname="mark" reftype="site" refname="grip"/>
          <actuatorfrc name="s_puller" actuator="puller"/><tendonpos name="s_cord" tendon="cord"/></sensor>
        <keyframe><key name="home" qpos="0.1 0.2 0.3 0.4" ctrl="1 2 3 4"/></keyframe></mujoco>"#;
    let mut robot = load_description_from_text(text, &LoadOptions::default()).expect("a robot").description;
    let notes = robot.remove_joint("turn").expect("a joint");
    let listed: Vec<String> = notes.iter().map(ToString::to_string).collect();
    let expected = [
        "contact exclusion of `arm` and `finger`: removed with link `finger`",
        "contact pair of `beam` and `pad`: removed with shape `pad`",
        "tendon `cord`: removed with joint `close`",
        "equality `gear`: removed with joint `turn`",
        "equality `pin`: removed with link `palm`",
        "actuator `closer`: removed with joint `close`",
        "actuator `puller`: removed with tendon `cord`",
        "sensor `s_close`: removed with joint `close`",
        "sensor `s_grip`: removed with frame `grip`",
        "sensor `s_rel`: removed with frame `grip`",
        "sensor `s_puller`: removed with actuator `puller`",
        "sensor `s_cord`: removed with tendon `cord`",
        "pose `home`: the values of turn, close were removed",
    ];
    assert_eq!(listed, expected);
    assert_eq!(robot.poses[0].controls, [1.0, 4.0]);
    let model = Model::new(robot.clone()).expect("no reference is left");
    assert_eq!(model.named_pose("home"), Some((vec![0.1, 0.4], vec![0.0; 2])));
    run_alone(&robot);
}

/// A link with two parents closes a loop. Without one of its joints the robot is a tree, and all else stays.
#[test]
fn removing_a_joint_cuts_a_loop() {
    let mut robot = pendulum(2.0, 0.5);
    let tree = robot.clone();
    let mut second = robot.joints[0].clone();
    second.name = "second".into();
    robot.joints.push(second);
    robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("second", 1.0)));
    Model::new(robot.clone()).expect_err("two parents");
    let notes = robot.remove_joint("second").expect("a joint");
    assert_eq!(notes.iter().map(|note| note.place.as_str()).collect::<Vec<_>>(), ["actuator `motor`"]);
    assert_eq!(robot, tree);
}

/// A robot whose description a simulation takes.
fn run_alone(robot: &RobotDescription) {
    let model = Model::new(robot.clone()).expect("a robot");
    let mut simulation = robot_dynamics::simulation(&model).build().expect("a simulation");
    simulation.run_for(0.05).expect("a run");
}

#[test]
fn mimic_joints_of_a_removed_leader_move_by_themselves() {
    let mut robot = pendulum(2.0, 0.5);
    for prefix in ["a_", "b_"] {
        robot.attach(&pendulum(1.0, 0.2), &Mount::on("tip").with_prefix(prefix)).expect("other names");
    }
    let follower = robot.joints.iter_mut().find(|joint| joint.name == "b_hinge").expect("a joint");
    follower.mimic = Some(Mimic::new("a_hinge", 2.0, 0.0));
    let notes = robot.remove_joint("a_hinge").expect("a joint");
    assert_eq!(notes[0].to_string(), "joint `b_hinge`: it followed joint `a_hinge`, and now moves by itself");
    assert_eq!(Model::new(robot).expect("a robot").nv(), 2);
}

fn pose(name: &str, hinge: f64, controls: &[f64]) -> NamedPose {
    let mut pose = NamedPose::new(name, [("hinge".to_owned(), vec![hinge])]);
    pose.controls = controls.to_vec();
    pose
}

/// An arm with another gripper is the arm to which that gripper is attached.
#[test]
fn a_replaced_gripper_is_attached_at_the_same_place() {
    let arm = pendulum(2.0, 0.5);
    let mut gripper = pendulum(1.0, 0.2);
    gripper.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 3.0)));
    gripper.poses.push(pose("open", 0.1, &[0.5]));
    gripper.sensors.push(SensorDescription::new("encoder", SensorKind::JointPosition, "hinge"));
    let at = Pose::from_xyz_rpy([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]);
    let mount = |prefix: &str| Mount::on("rod").with_pose(at).with_prefix(prefix);
    let mut first = arm.clone();
    first.actuators.push(ActuatorDescription::new("shoulder", Transmission::joint("hinge", 1.0)));
    let mut expected = first.clone();
    first.attach(&gripper, &mount("old_")).expect("other names");
    first.poses.push(pose("home", 0.2, &[0.7, 0.9]));
    let mut other = gripper.clone();
    other.scale_masses(2.5).expect("a factor");
    let notes = first.replace_subtree("old_ceiling_joint", &other, "new_").expect("other names");
    let listed: Vec<_> = notes.iter().map(|note| note.place.as_str()).collect();
    assert_eq!(listed, ["actuator `old_motor`", "sensor `old_encoder`", "pose `old_open`"]);
    expected.poses.push(pose("home", 0.2, &[0.7]));
    expected.attach(&other, &mount("new_")).expect("other names");
    first.poses.sort_by_key(|pose| pose.name.clone());
    expected.poses.sort_by_key(|pose| pose.name.clone());
    // The old gripper's own pose has lost its values.
    first.poses.retain(|pose| pose.name != "old_open");
    assert_eq!(first, expected);
    let before = first.clone();
    let missing = first.replace_subtree("new_ceiling_jiont", &other, "c_").unwrap_err();
    assert!(missing.to_string().ends_with("did you mean `new_ceiling_joint`?"), "{missing}");
    first.replace_subtree("new_ceiling_joint", &other, "").expect_err("the names of the arm");
    assert_eq!(first, before);
}

#[test]
fn wrong_names_and_numbers_change_nothing() {
    let mut robot = pendulum(2.0, 0.5);
    let before = robot.clone();
    let near = |error: ModelError, name: &str| {
        let text = error.to_string();
        assert!(text.ends_with(&format!("did you mean `{name}`?")), "{text}");
    };
    near(robot.set_root("rodd").unwrap_err(), "rod");
    near(robot.remove_joint("hing").unwrap_err(), "hinge");
    near(robot.scale_mass("rodd", 2.0).unwrap_err(), "rod");
    near(robot.set_mass_properties("rodd", None).unwrap_err(), "rod");
    near(robot.add_frame("camera", "tipp", Pose::IDENTITY).unwrap_err(), "tip");
    robot.add_frame("tip", "rod", Pose::IDENTITY).expect_err("a frame has this name");
    let none = robot.remove_equality("pin").unwrap_err().to_string();
    assert_eq!(none, "the robot has no equality `pin`, nor any other equality");
    for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        robot.scale_masses(factor).expect_err("a factor that is not positive and finite");
    }
    robot.scale_mass("rod", 1e308).expect_err("a mass that is not finite");
    assert_eq!(robot, before);
}

/// The robots of the repository's files, with all their tendons, actuators, sensors and poses.
fn robots_of_files() -> Vec<RobotDescription> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folders =
        ["robots", "testdata/mjcf", "testdata/mjcf/sensors", "testdata/mjcf/soft", "testdata/mjcf/fluid"];
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(root.join(folder)).expect("a folder"));
    let mut paths: Vec<_> = files.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let read = |path| robot_dynamics::load_description(path, &LoadOptions::default()).ok();
    paths.iter().filter_map(read).map(|loaded| loaded.description).collect()
}

/// No reference to a removed part is left, whichever joint of whichever robot is removed, and the robots with
/// every other root are valid.
#[test]
fn edits_of_every_file_leave_valid_robots() {
    let robots = robots_of_files();
    assert!(robots.len() > 40, "{}", robots.len());
    let (mut notes, mut roots) = (0, 0);
    for robot in &robots {
        for joint in robot.joints.iter().take(12) {
            let mut edited = robot.clone();
            notes += edited.remove_joint(&joint.name).expect("a joint").len();
            let model = Model::new(edited);
            assert!(model.is_ok(), "{} without {}: {:?}", robot.name, joint.name, model.err());
        }
        for link in robot.links.iter().take(12) {
            let mut edited = robot.clone();
            match edited.set_root(&link.name) {
                Ok(_) => {
                    roots += 1;
                    let model = Model::new(edited);
                    assert!(model.is_ok(), "{} from {}: {:?}", robot.name, link.name, model.err());
                }
                Err(ModelError::Irreversible { .. }) => assert_eq!(&edited, robot),
                Err(error) => panic!("{} from {}: {error}", robot.name, link.name),
            }
        }
    }
    assert!(notes > 100 && roots > 200, "{notes} notes, {roots} roots");
}
