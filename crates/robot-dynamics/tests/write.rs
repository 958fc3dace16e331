//! Robots that are written as URDF and MJCF and read back are the same, except for reported losses.
//!
//! Tolerance: 1e-12 of the largest entry. Numbers lose no digits in a file. Rotations are written as angles
//! or quaternions with rounding errors, which sums over bodies propagate.

use std::path::{Path, PathBuf};

use robot_dynamics::description::{
    Base, ContactPairDescription, Equality, JointKind, ModelError, Pose, RandomRobotOptions,
    RobotDescription, ShapeRole, WrittenFile, pendulum, random_robot,
};
use robot_dynamics::model::{Model, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::Actuation;
use robot_dynamics::{Format, LoadOptions, load_description, load_description_from_text, write};

const ROUNDING: f64 = 1e-12;
const FORMATS: [Format; 2] = [Format::Urdf, Format::Mjcf];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn files(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).expect("the folder");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|path| Format::of(path).is_some());
    files.sort();
    files
}

fn read(path: &Path) -> RobotDescription {
    load_description(path, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .description
}

fn read_back(written: &WrittenFile, what: &str) -> RobotDescription {
    let back = load_description_from_text(&written.text, &LoadOptions::default());
    back.unwrap_or_else(|error| panic!("{what}: {error}\n{}", written.text)).description
}

fn assert_near(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1e-3_f64, |most, x| most.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= ROUNDING * scale, "{what}: {found} for {expected}");
    }
}

/// Compares M, forces, dissipation and names at random states, with couplings converted to mimic joints in
/// both robots.
fn assert_same(what: &str, one: &RobotDescription, other: &RobotDescription) {
    let [one, other] = [one, other].map(|robot| {
        let mut robot = robot.clone();
        robot.couplings_to_followers();
        Model::new(robot).unwrap_or_else(|error| panic!("{what}: {error}"))
    });
    let moving = |model: &Model| -> Vec<String> {
        model.joints().iter().filter(|joint| joint.nv > 0).map(|joint| joint.name.clone()).collect()
    };
    if moving(&one).len() == moving(&other).len() {
        assert_eq!(moving(&one), moving(&other), "{what}");
    }
    assert_eq!((one.nq(), one.nv()), (other.nq(), other.nv()), "{what}");
    let mut random = SplitMix64::new(5);
    for _ in 0..3 {
        let state = random_state(&one, &mut random);
        let (q, v, a) = (&state.q, &state.v, &state.a);
        let mass = |model: &Model| model.mass_matrix(q).expect("a state");
        assert_near(&format!("{what}: M"), mass(&other).as_slice(), mass(&one).as_slice());
        let tau = |model: &Model| model.inverse_dynamics(q, v, a).expect("a state");
        assert_near(&format!("{what}: forces"), tau(&other).as_slice(), tau(&one).as_slice());
        let loss = |model: &Model| {
            let mut loss = vec![0.0; model.nv()];
            robot_dynamics::algorithms::dissipation(model, v, &mut loss);
            loss
        };
        assert_near(&format!("{what}: dissipation"), &loss(&other), &loss(&one));
    }
}

/// Compares limits and passive forces of joints.
fn assert_same_joints(what: &str, one: &RobotDescription, other: &RobotDescription, has_velocity: bool) {
    for joint in one.joints.iter().filter(|joint| joint.kind.nv() > 0) {
        let found = other.joints.iter().find(|other| other.name == joint.name);
        let found = found.unwrap_or_else(|| panic!("{what}: no joint {:?}", joint.name));
        let what = format!("{what}: joint {:?}", joint.name);
        assert_eq!(found.passive, joint.passive, "{what}");
        let (limits, own) = (joint.limits, found.limits);
        assert!(has_velocity || own.turn == limits.turn, "{what}: {}", own.turn);
        assert_eq!((own.lower, own.upper, own.effort), (limits.lower, limits.upper, limits.effort), "{what}");
        assert!(!has_velocity || own.velocity == limits.velocity, "{what}: {}", own.velocity);
    }
}

/// Writes every robot of this repository in both formats, and back.
#[test]
fn written_robots_read_back_the_same() {
    for path in files("robots").into_iter().chain(files("testdata/mjcf")).chain(files("testdata/mjcf/soft")) {
        // Readers of the other format assume Earth's gravity and no compensation.
        let mut robot = read(&path);
        robot.gravity = robot_dynamics::description::EARTH_GRAVITY;
        for link in &mut robot.links {
            link.gravity_compensation = 0.0;
        }
        let what = path.display().to_string();
        for format in FORMATS {
            let what = format!("{what} as {format:?}");
            let there =
                read_back(&write(&robot, format, None).unwrap_or_else(|e| panic!("{what}: {e}")), &what);
            // URDF has no tendons, and reports the loss. The armature of a tendon over several joints is lost
            // with it.
            let mut in_urdf = robot.clone();
            in_urdf.tendons.iter_mut().for_each(|tendon| tendon.passive.armature = 0.0);
            // A spring that yields becomes an elastic one.
            in_urdf.joints.iter_mut().for_each(|joint| joint.spring_yield = 0.0);
            assert_same(&what, if format == Format::Urdf { &in_urdf } else { &robot }, &there);
            let other = FORMATS[usize::from(format == Format::Urdf)];
            let again = read_back(&write(&there, other, None).expect("a robot"), &what);
            assert_same(&format!("{what} and back"), &in_urdf, &again);
            assert_same_joints(&what, &robot, &there, format == Format::Urdf);
        }
    }
}

/// From MJCF to MJCF actuators, tendons, gravity compensation, equalities, poses and shapes are preserved,
/// too.
#[test]
fn actuators_tendons_equalities_poses_and_shapes_read_back() {
    let mut counts = [0; 4];
    for path in files("robots").into_iter().chain(files("testdata/mjcf")).chain(files("testdata/mjcf/soft")) {
        let robot = read(&path);
        let what = path.display().to_string();
        let written = write(&robot, Format::Mjcf, path.parent()).expect("a robot");
        let back = read_back(&written, &what);
        let lost: Vec<_> = written.lost_physics().collect();
        assert!(lost.is_empty(), "{what}: {lost:?}");
        assert_eq!(back.gravity, robot.gravity, "{what}");
        assert_eq!(back.time_step, robot.time_step, "{what}");
        assert_eq!(back.impratio, robot.impratio, "{what}");

        let models = [&robot, &back].map(|robot| Model::new(robot.clone()).expect("a robot"));
        let actuations = [0, 1].map(|k| Actuation::new(&models[k]).expect("a robot"));
        counts[0] += actuations[0].control_count();
        assert_eq!(
            actuations[0].control_names().collect::<Vec<_>>(),
            actuations[1].control_names().collect::<Vec<_>>(),
            "{what}"
        );
        let mut random = SplitMix64::new(9);
        // In MJCF mimic joints are free joints with equalities.
        let follows = robot.joints.iter().filter(|joint| joint.mimic.is_some()).count();
        if follows == 0 {
            let state = random_state(&models[0], &mut random);
            let u: Vec<f64> = (0..actuations[0].control_count()).map(|_| random.uniform(-1.0, 1.0)).collect();
            let tau = [0, 1].map(|k| {
                let (mut memory, mut tau) = (actuations[k].workspace(), vec![0.0; models[k].nv()]);
                actuations[k].forces(&models[k], &mut memory, &u, &state.q, &state.v, &mut tau);
                tau
            });
            assert_near(&format!("{what}: actuation"), &tau[1], &tau[0]);
        }
        assert_eq!(back.equalities.len(), robot.equalities.len() + follows, "{what}");
        for (own, back) in robot.equalities.iter().zip(&back.equalities) {
            assert_eq!(
                (own.active, own.solref, own.solimp),
                (back.active, back.solref, back.solimp),
                "{what}"
            );
            same_equality(&what, &own.kind, &back.kind);
            counts[1] += 1;
        }
        assert_eq!(back.contact_exclusions, robot.contact_exclusions, "{what}");
        assert_eq!(back.contact_pairs, robot.contact_pairs, "{what}");
        for pose in &robot.poses {
            let own = models[0].named_pose(&pose.name).expect("the pose");
            let other = models[1].named_pose(&pose.name).expect("the pose");
            assert_near(&format!("{what}: pose {}", pose.name), &other.0, &own.0);
            assert_near(&format!("{what}: pose {}", pose.name), &other.1, &own.1);
            counts[2] += 1;
        }
        // Shapes with files are omitted, because the text is read without a folder.
        let shapes = |robot: &RobotDescription| -> Vec<_> {
            let all = robot.shapes.iter().filter(|shape| shape.shape.file().is_none());
            all.map(|shape| (shape.role, shape.color, shape.surface)).collect()
        };
        let (own, other) = (shapes(&robot), shapes(&back));
        assert_eq!(own.len(), other.len(), "{what}");
        for (own, other) in own.iter().zip(&other) {
            assert_eq!((own.0, own.1), (other.0, other.1), "{what}");
            // Visual shapes have no collision bits in MJCF.
            assert!(own.0 == ShapeRole::Visual || own.2 == other.2, "{what}: {:?} for {:?}", other.2, own.2);
            counts[3] += 1;
        }
    }
    assert!(counts[0] > 30 && counts[1] > 5 && counts[2] > 5 && counts[3] > 50, "{counts:?}");
}

/// Compares polynomials by their values, because the coefficients change with the reference positions.
fn same_equality(what: &str, one: &Equality, other: &Equality) {
    match (one, other) {
        (
            Equality::Joints { joint, leader, polynomial },
            Equality::Joints { joint: other, leader: other_leader, polynomial: moved },
        )
        | (
            Equality::Tendons { tendon: joint, leader, polynomial },
            Equality::Tendons { tendon: other, leader: other_leader, polynomial: moved },
        ) => {
            assert_eq!(
                (&joint.0, leader.as_ref().map(|l| &l.0)),
                (&other.0, other_leader.as_ref().map(|l| &l.0))
            );
            let value = |y0: f64, x0: f64, c: &[f64; 5], x: f64| {
                y0 + c.iter().rev().fold(0.0, |sum, c| sum * (x - x0) + c)
            };
            for x in [-0.7, 0.4, 1.3] {
                let own = value(joint.1, leader.as_ref().map_or(0.0, |l| l.1), polynomial, x);
                let found = value(other.1, other_leader.as_ref().map_or(0.0, |l| l.1), moved, x);
                assert_near(what, &[found], &[own]);
            }
        }
        (Equality::Connect { a, b }, Equality::Connect { a: c, b: d }) => {
            assert_eq!((&a.0, &b.0), (&c.0, &d.0), "{what}");
            assert_near(what, &[c.1, d.1].concat(), &[a.1, b.1].concat());
        }
        (
            Equality::Weld { a, b, a_from_b, anchor, torque_scale },
            Equality::Weld { a: c, b: d, a_from_b: other, anchor: other_anchor, torque_scale: other_scale },
        ) => {
            assert_eq!((a, b), (c, d), "{what}");
            assert_near(what, &other.translation, &a_from_b.translation);
            assert_near(
                what,
                &[&other_anchor[..], &[*other_scale]].concat(),
                &[&anchor[..], &[*torque_scale]].concat(),
            );
            assert_near(what, other.rotation.as_flattened(), a_from_b.rotation.as_flattened());
        }
        _ => panic!("{what}: {other:?} for {one:?}"),
    }
}

/// All joint kinds that the formats support, anywhere in a tree, with mimic joints and links without mass.
#[test]
fn random_trees_read_back_the_same() {
    for seed in 0..60 {
        let base = if seed % 3 == 0 { Base::Floating } else { Base::Fixed };
        let options = RandomRobotOptions { base, massless: 0.3, mimic: 0.1, ..Default::default() };
        let mut robot = random_robot(seed, &options);
        robot.gravity = robot_dynamics::description::EARTH_GRAVITY;
        for joint in &mut robot.joints {
            joint.kind = match joint.kind {
                JointKind::Helical { axis, .. } => JointKind::Revolute { axis },
                JointKind::Floating => JointKind::Spherical,
                kind => kind,
            };
        }
        for format in FORMATS {
            let what = format!("seed {seed} as {format:?}");
            let written = write(&robot, format, None).unwrap_or_else(|error| panic!("{what}: {error}"));
            assert_same(&what, &robot, &read_back(&written, &what));
        }
    }
}

/// Names that XML must escape, reserved names, and names that collide with generated ones.
#[test]
fn names_read_back_or_are_refused() {
    let wild = "a\"> <b c='&amp;\n\t é 手";
    let mut robot = pendulum(2.0, 0.5);
    robot.frames.clear();
    robot.name = wild.into();
    robot.links[1].name = wild.into();
    robot.joints[0].child = wild.into();
    robot.joints[0].name = format!("{wild} joint");
    for format in FORMATS {
        let back = read_back(&write(&robot, format, None).expect("names"), "wild");
        assert_eq!(back.name, wild, "{format:?}");
        assert!(back.links.iter().any(|link| link.name == wild), "{format:?}");
        assert_eq!(back.joints.last().map(|joint| joint.name.clone()), Some(format!("{wild} joint")));
    }
    // A link named `world` that is not the root.
    let mut robot = pendulum(2.0, 0.5);
    robot.frames.clear();
    robot.links[1].name = "world".into();
    robot.joints[0].child = "world".into();
    for format in FORMATS {
        let written = write(&robot, format, None).expect("names");
        assert_same("world", &robot, &read_back(&written, "world"));
    }
    for name in ["", " ", "bell\u{7}"] {
        let mut robot = pendulum(2.0, 0.5);
        robot.joints[0].name = name.into();
        for format in FORMATS {
            let refused = write(&robot, format, None).expect_err("a name");
            assert!(matches!(&refused, ModelError::Unwritable(reasons) if reasons.len() == 1), "{refused}");
        }
    }
}

/// Features that a format cannot represent are refused by name. Invalid robots are refused.
#[test]
fn unsupported_features_are_refused() {
    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].kind = JointKind::Helical { axis: [0.0, 0.0, 1.0], pitch: 0.1 };
    for format in FORMATS {
        let refused = write(&robot, format, None).expect_err("a screw");
        assert!(matches!(&refused, ModelError::Unwritable(reasons) if reasons.len() == 1), "{refused}");
    }
    let mut robot =
        random_robot(3, &RandomRobotOptions { joints: 4, chain: 1.0, passive: 0.0, ..Default::default() });
    for joint in &mut robot.joints {
        joint.kind = JointKind::Spherical;
    }
    let last = robot.joints.len() - 1;
    robot.joints[last].kind = JointKind::Floating;
    let refused = write(&robot, Format::Mjcf, None).expect_err("a free joint inside");
    assert!(matches!(&refused, ModelError::Unwritable(reasons) if reasons.len() == 1), "{refused}");
    assert!(write(&robot, Format::Urdf, None).is_ok());

    let mut robot = pendulum(2.0, 0.5);
    robot.joints[0].parent = "nowhere".into();
    for format in FORMATS {
        assert!(
            matches!(write(&robot, format, None), Err(ref error) if !matches!(error, ModelError::Unwritable(_))),
            "{format:?}"
        );
    }
}

/// Ten thousand links: the size of the text is linear in their number, and MJCF refuses the nesting.
#[test]
fn a_long_chain_is_written_or_refused() {
    let mut robot = pendulum(2.0, 0.5);
    robot.frames.clear();
    for k in 0..10_000 {
        let mut link = robot.links[1].clone();
        link.name = format!("link{k}");
        let mut joint = robot.joints[0].clone();
        joint.name = format!("joint{k}");
        joint.parent = robot.links[robot.links.len() - 1].name.clone();
        joint.child = link.name.clone();
        joint.parent_from_joint = Pose::from_translation([0.1, 0.0, 0.0]);
        robot.links.push(link);
        robot.joints.push(joint);
    }
    let written = write(&robot, Format::Urdf, None).expect("a chain");
    assert!(written.text.len() < 10_000 * 800, "{}", written.text.len());
    assert_eq!(read_back(&written, "chain").links.len(), robot.links.len());
    let refused = write(&robot, Format::Mjcf, None).expect_err("too deep");
    assert!(matches!(&refused, ModelError::Unwritable(reasons) if reasons.len() == 1), "{refused}");
}

/// Losses are reported by name, and by whether they affect the motion.
#[test]
fn losses_are_reported() {
    let path = root().join("robots/hand.xml");
    let mut robot = read(&path);
    robot.contact_pairs.push(ContactPairDescription::new(["thumb", "palm"]));
    let written = write(&robot, Format::Urdf, None).expect("a hand");
    let lost: Vec<&str> = written.lost_physics().map(|lost| lost.place.as_str()).collect();
    assert!(lost.contains(&"tendon \"first\"") && lost.contains(&"actuator \"wrist\""), "{lost:?}");
    let notes: Vec<&str> =
        written.left_out.iter().filter(|one| !one.physics).map(|one| one.place.as_str()).collect();
    assert!(notes.contains(&"contact"), "{notes:?}");
    assert!(notes.contains(&"pose \"open\"") && notes.contains(&"joint \"second_root\""), "{notes:?}");
}

/// The names of meshes are relative to the folder of the new file.
#[test]
fn mesh_names_are_relative_to_the_new_folder() {
    let folder = std::env::temp_dir().join(format!("meshes_of_a_written_robot_{}", std::process::id()));
    let path = root().join("testdata/mjcf/meshes.xml");
    let robot = read(&path);
    std::fs::create_dir_all(&folder).expect("a folder");
    for (format, name) in [(Format::Urdf, "robot.urdf"), (Format::Mjcf, "robot.xml")] {
        let written = write(&robot, format, Some(&folder)).expect("a robot");
        std::fs::write(folder.join(name), &written.text).expect("a file");
        let back = read(&folder.join(name));
        let found = |robot: &RobotDescription| -> Vec<PathBuf> {
            let files = robot.shapes.iter().filter_map(|shape| shape.shape.file()?.1.map(Path::to_owned));
            files.map(|file| file.canonicalize().expect("a file")).collect()
        };
        assert!(found(&robot).len() > 3 && found(&back) == found(&robot), "{:?}", found(&back));
    }
    std::fs::remove_dir_all(&folder).expect("the folder");
}
