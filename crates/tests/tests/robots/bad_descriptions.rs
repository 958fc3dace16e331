//! Errors of invalid descriptions: each variant and its fields.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::description::{
    Base, FrameDescription, JointDescription, JointKind, LinkDescription, MassProperties, Mimic, ModelError,
    Pose, RobotDescription,
};
use robot_dynamics::model::Model;

const Z: JointKind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };

fn link(name: &str) -> LinkDescription {
    let body = MassProperties::new(1.0, Vector3::new(0.1, 0.0, 0.0), Matrix3::identity()).unwrap();
    LinkDescription::new(name, body)
}

fn joint(name: &str, kind: JointKind, parent: &str, child: &str) -> JointDescription {
    JointDescription::new(name, kind, parent, child, Pose::from_translation([0.5, 0.0, 0.0]))
}

/// base –shoulder– arm –elbow– hand: a valid robot.
fn good() -> RobotDescription {
    let mut robot = RobotDescription::new("good");
    robot.links = ["base", "arm", "hand"].map(link).into();
    robot.joints = vec![joint("shoulder", Z, "base", "arm"), joint("elbow", Z, "arm", "hand")];
    robot
}

/// The error of the valid robot after one change.
fn error(spoil: impl FnOnce(&mut RobotDescription)) -> ModelError {
    let mut robot = good();
    spoil(&mut robot);
    Model::new(robot).expect_err("this description is invalid")
}

fn following(joint: &str) -> Mimic {
    Mimic::new(joint, 1.0, 0.0)
}

fn names(all: &[&str]) -> Vec<String> {
    all.iter().map(|name| (*name).to_owned()).collect()
}

#[test]
fn valid_robot_compiles() {
    assert_eq!(Model::new(good()).unwrap().nv(), 2);
}

#[test]
fn invalid_names_are_errors() {
    let twice = |sort, name: &str| ModelError::DuplicateName { sort, name: name.into() };
    assert_eq!(error(|r| r.links.clear()), ModelError::NoLinks);
    assert_eq!(error(|r| r.links[2].name = "arm".into()), twice("link", "arm"));
    assert_eq!(error(|r| r.joints[1].name = "shoulder".into()), twice("joint", "shoulder"));
    let frame = |name: &str, link: &str| FrameDescription::new(name, link, Pose::IDENTITY);
    assert_eq!(
        error(|r| r.frames = vec![frame("tool", "hand"), frame("tool", "arm")]),
        twice("frame", "tool")
    );
    // A link is a frame, too.
    assert_eq!(error(|r| r.frames = vec![frame("arm", "hand")]), twice("frame", "arm"));
    let unknown = |error: ModelError| match error {
        ModelError::UnknownName { sort: "link", name, .. } => name,
        other => panic!("{other}"),
    };
    assert_eq!(unknown(error(|r| r.frames = vec![frame("tool", "finger")])), "finger");
    assert_eq!(unknown(error(|r| r.joints[1].parent = "forearm".into())), "forearm");
}

#[test]
fn invalid_trees_are_errors() {
    assert_eq!(
        error(|r| r.joints.push(joint("weld", JointKind::Fixed, "base", "hand"))),
        ModelError::TwoParents { link: "hand".into(), first: "elbow".into(), second: "weld".into() }
    );
    assert_eq!(error(|r| r.joints.truncate(1)), ModelError::SeveralRoots { links: names(&["base", "hand"]) });
    assert_eq!(
        error(|r| r.joints.push(joint("back", Z, "hand", "base"))),
        ModelError::Cycle { links: names(&["base", "arm", "hand"]) }
    );
    assert_eq!(error(|r| r.joints[1].parent = "hand".into()), ModelError::Cycle { links: names(&["hand"]) });
}

/// Asserts that the error names this joint, quantity and value.
#[track_caller]
fn assert_bad_number(
    spoil: impl FnOnce(&mut RobotDescription),
    name: &str,
    expected: &'static str,
    bad: f64,
) {
    match error(spoil) {
        ModelError::BadNumber { owner, quantity, value, .. } => {
            assert!(owner.contains(name) && quantity == expected, "{owner} {quantity}");
            assert!(value == bad || (value.is_nan() && bad.is_nan()), "{value}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn invalid_joints_are_errors() {
    for kind in [
        JointKind::Revolute { axis: [0.0; 3] },
        JointKind::Universal { first: [1.0, 0.0, 0.0], second: [f64::NAN; 3] },
    ] {
        let error = error(|r| r.joints[1].kind = kind);
        assert!(matches!(&error, ModelError::ZeroAxis { joint, .. } if joint == "elbow"), "{error}");
    }
    let screw = JointKind::Helical { axis: [1.0, 0.0, 0.0], pitch: f64::INFINITY };
    assert_bad_number(|r| r.joints[1].kind = screw, "elbow", "pitch", f64::INFINITY);
    assert_bad_number(|r| r.joints[0].passive.damping = f64::INFINITY, "shoulder", "damping", f64::INFINITY);
    assert_bad_number(|r| r.joints[0].passive.armature = f64::NAN, "shoulder", "armature", f64::NAN);
    let spring_of_ball = |r: &mut RobotDescription| {
        r.joints[0].kind = JointKind::Spherical;
        r.joints[0].passive.stiffness = 2.0;
    };
    assert_bad_number(spring_of_ball, "shoulder", "stiffness", 2.0);
    assert_bad_number(|r| r.joints[0].limits.lower = f64::NAN, "shoulder", "lower limit", f64::NAN);
    assert_bad_number(|r| r.joints[0].limits.effort = -1.0, "shoulder", "effort limit", -1.0);
}

#[test]
fn invalid_poses_and_gravity_are_errors() {
    let rotation = |entry: usize, value: f64| match error(|r| {
        r.joints[0].parent_from_joint.rotation[entry][entry] = value;
    }) {
        ModelError::NotARotation { owner, defect } if owner.contains("shoulder") => defect,
        other => panic!("{other}"),
    };
    assert_eq!(rotation(2, -1.0), 2.0);
    assert!(rotation(0, f64::NAN).is_nan());
    let spoil = |r: &mut RobotDescription| r.joints[0].parent_from_joint.translation[1] = f64::NAN;
    assert_bad_number(spoil, "shoulder", "translation", f64::NAN);
    assert_bad_number(|r| r.gravity[2] = f64::NEG_INFINITY, "gravity", "z", f64::NEG_INFINITY);
}

#[test]
fn invalid_mimic_joints_are_errors() {
    let error_of_elbow = error(|r| r.joints[1].mimic = Some(following("knee")));
    let ModelError::UnknownName { sort: "joint", name, .. } = &error_of_elbow else {
        panic!("{error_of_elbow}")
    };
    assert_eq!(name, "knee");
    let pair = |error: ModelError| match error {
        ModelError::BadMimic { joint, leader, .. } => (joint, leader),
        other => panic!("{other}"),
    };
    let elbow_of_shoulder = ("elbow".to_owned(), "shoulder".to_owned());
    assert_eq!(
        pair(error(|r| r.joints[1].mimic = Some(following("elbow")))),
        ("elbow".to_owned(), "elbow".to_owned())
    );
    assert_eq!(
        pair(error(|r| (r.joints[0].mimic, r.joints[1].mimic) =
            (Some(following("elbow")), Some(following("shoulder"))))),
        ("shoulder".to_owned(), "elbow".to_owned())
    );
    let ball_leads = |r: &mut RobotDescription| {
        r.joints[0].kind = JointKind::Spherical;
        r.joints[1].mimic = Some(following("shoulder"));
    };
    assert_eq!(pair(error(ball_leads)), elbow_of_shoulder);
    let fixed_follows = |r: &mut RobotDescription| {
        r.joints[1].kind = JointKind::Fixed;
        r.joints[1].mimic = Some(following("shoulder"));
    };
    assert_eq!(pair(error(fixed_follows)), elbow_of_shoulder);
    let ratio_of_nan =
        |r: &mut RobotDescription| r.joints[1].mimic = Some(Mimic::new("shoulder", f64::NAN, 0.0));
    assert_eq!(pair(error(ratio_of_nan)), elbow_of_shoulder);
}

/// Massless degrees of freedom are not an error: the model lists their joints.
#[test]
fn massless_joints_are_listed() {
    let found = |spoil: &dyn Fn(&mut RobotDescription)| -> Vec<String> {
        let mut robot = good();
        spoil(&mut robot);
        Model::new(robot).unwrap().massless_joints().map(Into::into).collect()
    };
    let massless = |r: &mut RobotDescription| r.links[2].mass_properties = None;
    assert!(found(&|_| {}).is_empty());
    assert_eq!(found(&massless), ["elbow"]);
    // A point mass on the axis: turning about it moves no inertia.
    let point = |at: Vector3<f64>| MassProperties::new(1.0, at, Matrix3::zeros()).ok();
    assert_eq!(found(&|r| r.links[2].mass_properties = point(Vector3::new(0.0, 0.0, 0.3))), ["elbow"]);
    // A turn about the line to a point mass moves no inertia.
    assert_eq!(
        found(&|r| {
            r.joints[1].kind = JointKind::Spherical;
            r.links[2].mass_properties = point(Vector3::new(0.1, 0.2, 0.3));
        }),
        ["elbow"]
    );
    assert_eq!(
        found(&|r| {
            r.base = Base::Floating;
            r.links.truncate(1);
            r.joints.clear();
            r.links[0].mass_properties = None;
        }),
        ["floating_base"]
    );
    // Armature is sufficient inertia; so is a point mass off the axis.
    let armature = |r: &mut RobotDescription| {
        massless(r);
        r.joints[1].passive.armature = 0.01;
    };
    assert!(found(&armature).is_empty());
    assert!(found(&|r| r.links[2].mass_properties = point(Vector3::new(0.1, 0.0, 0.0))).is_empty());
    // A mimic joint needs no inertia of its own: its leader moves the arm.
    assert!(
        found(&|r| {
            massless(r);
            r.joints[1].mimic = Some(following("shoulder"));
        })
        .is_empty()
    );
    // A leader may rely on the inertia of its mimic joint, unless the ratio is zero.
    let led = |ratio: f64| {
        found(&move |r| {
            massless(r);
            r.joints[0].mimic = Some(Mimic::new("elbow", ratio, 0.0));
        })
    };
    assert!(led(1.0).is_empty());
    assert_eq!(led(0.0), ["elbow"]);
}

/// Errors have fields for programs to read.
#[test]
fn errors_have_fields() {
    let mut robot = good();
    robot.links.remove(2);
    let error = Model::new(robot).unwrap_err();
    let ModelError::UnknownName { user, sort, name } = &error else { panic!("{error}") };
    assert_eq!((user.as_str(), *sort, name.as_str()), ("joint `elbow`", "link", "hand"));
}
