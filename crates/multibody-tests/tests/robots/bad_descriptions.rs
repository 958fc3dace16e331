//! What is wrong with a description is said in one sentence: what, where, what to do.

use dynamics::MassProperties;
use multibody::{
    Base, FrameDescription, JointDescription, JointKind, LinkDescription, Mimic, Model, ModelError, Pose,
    RobotDescription,
};
use nalgebra::{Matrix3, Vector3};

const Z: JointKind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };

fn link(name: &str) -> LinkDescription {
    let body = MassProperties::new(1.0, Vector3::new(0.1, 0.0, 0.0), Matrix3::identity()).unwrap();
    LinkDescription::new(name, body)
}

fn joint(name: &str, kind: JointKind, parent: &str, child: &str) -> JointDescription {
    JointDescription::new(name, kind, parent, child, Pose::from_translation([0.5, 0.0, 0.0]))
}

/// base –shoulder– arm –elbow– hand: a robot with nothing wrong.
fn good() -> RobotDescription {
    let mut robot = RobotDescription::new("good");
    robot.links = ["base", "arm", "hand"].map(link).into();
    robot.joints = vec![joint("shoulder", Z, "base", "arm"), joint("elbow", Z, "arm", "hand")];
    robot
}

/// The message for the good robot with one thing spoilt.
fn message(spoil: impl FnOnce(&mut RobotDescription)) -> String {
    let mut robot = good();
    spoil(&mut robot);
    Model::new(robot).expect_err("this description is wrong").to_string()
}

fn following(joint: &str) -> Mimic {
    Mimic::new(joint, 1.0, 0.0)
}

#[test]
fn the_good_robot_is_good() {
    assert_eq!(Model::new(good()).unwrap().nv(), 2);
}

#[test]
fn names() {
    assert_eq!(message(|r| r.links.clear()), "the robot has no links; add at least one");
    assert_eq!(message(|r| r.links[2].name = "arm".into()), "two links are named `arm`; rename one");
    assert_eq!(
        message(|r| r.joints[1].name = "shoulder".into()),
        "two joints are named `shoulder`; rename one"
    );
    let frame = |name: &str, link: &str| FrameDescription::new(name, link, Pose::IDENTITY);
    assert_eq!(
        message(|r| r.frames = vec![frame("tool", "hand"), frame("tool", "arm")]),
        "two frames are named `tool`; rename one"
    );
    // A link is a frame, too.
    assert_eq!(message(|r| r.frames = vec![frame("arm", "hand")]), "two frames are named `arm`; rename one");
    assert_eq!(
        message(|r| r.frames = vec![frame("tool", "finger")]),
        "frame `tool` refers to link `finger`, which does not exist"
    );
    assert_eq!(
        message(|r| r.joints[1].parent = "forearm".into()),
        "joint `elbow` refers to link `forearm`, which does not exist"
    );
}

#[test]
fn trees() {
    assert_eq!(
        message(|r| r.joints.push(joint("weld", JointKind::Fixed, "base", "hand"))),
        "link `hand` is the child of both joint `elbow` and joint `weld`; a tree allows one"
    );
    assert_eq!(
        message(|r| {
            r.joints.pop();
        }),
        "links base, hand are all roots; connect them with joints"
    );
    assert_eq!(
        message(|r| r.joints.push(joint("back", Z, "hand", "base"))),
        "links base, arm, hand form a loop of joints that the root does not reach"
    );
    assert_eq!(
        message(|r| r.joints[1].parent = "hand".into()),
        "links hand form a loop of joints that the root does not reach"
    );
}

#[test]
fn joints() {
    assert_eq!(
        message(|r| r.joints[1].kind = JointKind::Revolute { axis: [0.0; 3] }),
        "joint `elbow`: the axis [0.0, 0.0, 0.0] has no direction; give a finite, non-zero vector"
    );
    assert_eq!(
        message(|r| r.joints[1].kind = JointKind::Universal { first: [1.0, 0.0, 0.0], second: [f64::NAN; 3] }),
        "joint `elbow`: the axis [NaN, NaN, NaN] has no direction; give a finite, non-zero vector"
    );
    assert_eq!(
        message(|r| r.joints[1].kind = JointKind::Helical { axis: [1.0, 0.0, 0.0], pitch: f64::INFINITY }),
        "joint `elbow`: pitch = inf is not finite"
    );
    assert_eq!(
        message(|r| r.joints[0].passive.damping = f64::INFINITY),
        "joint `shoulder`: damping = inf is not finite"
    );
    assert_eq!(
        message(|r| r.joints[0].passive.armature = f64::NAN),
        "joint `shoulder`: armature = NaN is not finite"
    );
    assert_eq!(
        message(|r| {
            r.joints[0].kind = JointKind::Spherical;
            r.joints[0].passive.stiffness = 2.0;
        }),
        "joint `shoulder`: stiffness = 2 is not zero, as a quaternion joint needs; give it a placement's spring"
    );
    assert_eq!(
        message(|r| r.joints[0].limits.lower = f64::NAN),
        "joint `shoulder`: lower limit = NaN is not a number"
    );
    assert_eq!(
        message(|r| r.joints[0].limits.effort = -1.0),
        "joint `shoulder`: effort limit = -1 is not zero or positive"
    );
}

#[test]
fn placements_and_gravity() {
    assert_eq!(
        message(|r| r.joints[0].parent_from_joint.rotation[2][2] = -1.0),
        "joint `shoulder`: the rotation matrix is not orthonormal with determinant 1 (off by 2e0)"
    );
    assert_eq!(
        message(|r| r.joints[0].parent_from_joint.rotation[0][0] = f64::NAN),
        "joint `shoulder`: the rotation matrix is not orthonormal with determinant 1 (off by NaN)"
    );
    assert_eq!(
        message(|r| r.joints[0].parent_from_joint.translation[1] = f64::NAN),
        "joint `shoulder`: translation = NaN is not finite"
    );
    assert_eq!(message(|r| r.gravity[2] = f64::NEG_INFINITY), "gravity: z = -inf is not finite");
}

#[test]
fn followers() {
    assert_eq!(
        message(|r| r.joints[1].mimic = Some(following("knee"))),
        "the mimic of joint `elbow` refers to joint `knee`, which does not exist"
    );
    assert_eq!(
        message(|r| r.joints[1].mimic = Some(following("elbow"))),
        "joint `elbow` cannot follow joint `elbow`: the chain of followers closes on itself"
    );
    assert_eq!(
        message(|r| (r.joints[0].mimic, r.joints[1].mimic) =
            (Some(following("elbow")), Some(following("shoulder")))),
        "joint `shoulder` cannot follow joint `elbow`: the chain of followers closes on itself"
    );
    assert_eq!(
        message(|r| {
            r.joints[0].kind = JointKind::Spherical;
            r.joints[1].mimic = Some(following("shoulder"));
        }),
        "joint `elbow` cannot follow joint `shoulder`: only revolute, continuous, prismatic and helical joints \
         can lead"
    );
    assert_eq!(
        message(|r| {
            r.joints[1].kind = JointKind::Fixed;
            r.joints[1].mimic = Some(following("shoulder"));
        }),
        "joint `elbow` cannot follow joint `shoulder`: only revolute, continuous, prismatic and helical joints \
         can follow"
    );
    assert_eq!(
        message(|r| {
            r.joints[1].mimic = Some(Mimic::new("shoulder", f64::NAN, 0.0));
        }),
        "joint `elbow` cannot follow joint `shoulder`: its ratio and offset must be finite"
    );
}

/// They are no error: the model names them.
#[test]
fn freedoms_without_inertia() {
    let found = |spoil: &dyn Fn(&mut RobotDescription)| -> Vec<String> {
        let mut robot = good();
        spoil(&mut robot);
        Model::new(robot).unwrap().massless_joints().map(Into::into).collect()
    };
    let massless = |r: &mut RobotDescription| r.links[2].mass_properties = None;
    assert!(found(&|_| {}).is_empty());
    assert_eq!(found(&massless), ["elbow"]);
    // A point mass on the axis itself: turning it costs nothing.
    let point = |at: Vector3<f64>| MassProperties::new(1.0, at, Matrix3::zeros()).ok();
    assert_eq!(found(&|r| r.links[2].mass_properties = point(Vector3::new(0.0, 0.0, 0.3))), ["elbow"]);
    // About the line to a point mass, no turn costs anything.
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
    // Armature is inertia enough; so is a point mass off the axis.
    let armature = |r: &mut RobotDescription| {
        massless(r);
        r.joints[1].passive.armature = 0.01;
    };
    assert!(found(&armature).is_empty());
    assert!(found(&|r| r.links[2].mass_properties = point(Vector3::new(0.1, 0.0, 0.0))).is_empty());
    // A follower needs none of its own: its leader moves the arm.
    assert!(
        found(&|r| {
            massless(r);
            r.joints[1].mimic = Some(following("shoulder"));
        })
        .is_empty()
    );
    // A leader may live on its follower's inertia, but not on one that stands still.
    let led = |ratio: f64| {
        found(&move |r| {
            massless(r);
            r.joints[0].mimic = Some(Mimic::new("elbow", ratio, 0.0));
        })
    };
    assert!(led(1.0).is_empty());
    assert_eq!(led(0.0), ["elbow"]);
}

/// The errors carry fields for programs, not only sentences for people.
#[test]
fn errors_have_fields() {
    let mut robot = good();
    robot.links.remove(2);
    let error = Model::new(robot).unwrap_err();
    let ModelError::UnknownName { user, sort, name } = &error else { panic!("{error}") };
    assert_eq!((user.as_str(), *sort, name.as_str()), ("joint `elbow`", "link", "hand"));
}
