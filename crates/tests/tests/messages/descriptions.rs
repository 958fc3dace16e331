use robot_dynamics::derivatives::{parameter_values, with_parameters};
use robot_dynamics::description::{
    Base, FrameDescription, JointKind, LinkDescription, MassProperties, Mimic, Pose, RobotDescription,
    SensorDescription, SensorKind, SensorObject, pendulum,
};
use robot_dynamics::model::{JointMap, Model, neutral};

use crate::Section;
use crate::robots::{Z, arm, floating_arm, joint};

#[allow(clippy::unnecessary_wraps)] // as the field takes it
fn following(joint: &str) -> Option<Mimic> {
    Some(Mimic::new(joint, 1.0, 0.0))
}

/// The messages for an arm with one thing wrong.
pub(crate) fn model_error() -> Section {
    let mut section = Section::new("ModelError");
    let mut row = |input: &str, spoil: &dyn Fn(&mut RobotDescription)| {
        let mut robot = arm();
        spoil(&mut robot);
        section.row(input, Model::new(robot).expect_err(input));
    };
    row("no links", &|r| r.links.clear());
    row("two links of one name", &|r| r.links[2].name = "arm".into());
    row("two joints of one name", &|r| r.joints[1].name = "shoulder".into());
    let frame = |name: &str, link: &str| FrameDescription::new(name, link, Pose::IDENTITY);
    row("two frames of one name", &|r| r.frames = vec![frame("tool", "hand"), frame("tool", "arm")]);
    row("a frame with a link's name", &|r| r.frames = vec![frame("arm", "hand")]);
    row("a frame on an unknown link", &|r| r.frames = vec![frame("tool", "finger")]);
    row("a joint on an unknown link", &|r| r.joints[1].parent = "forearm".into());
    row("an unknown actuated joint", &|r| r.actuated_joints = Some(vec!["tail".into()]));
    row("a link with two parents", &|r| r.joints.push(joint("weld", JointKind::Fixed, "base", "hand")));
    row("two roots", &|r| r.joints.truncate(1));
    row("a loop with the root", &|r| r.joints.push(joint("back", Z, "hand", "base")));
    row("a loop beside the root", &|r| r.joints[1].parent = "hand".into());
    row("an axis of zeros", &|r| r.joints[1].kind = JointKind::Revolute { axis: [0.0; 3] });
    row("an axis of NaN", &|r| {
        r.joints[1].kind = JointKind::Universal { first: [1.0, 0.0, 0.0], second: [f64::NAN; 3] };
    });
    row("an infinite pitch", &|r| {
        r.joints[1].kind = JointKind::Helical { axis: [1.0, 0.0, 0.0], pitch: f64::INFINITY };
    });
    row("infinite damping", &|r| r.joints[0].passive.damping = f64::INFINITY);
    row("an armature of NaN", &|r| r.joints[0].passive.armature = f64::NAN);
    row("a spring on a ball joint", &|r| {
        r.joints[0].kind = JointKind::Spherical;
        r.joints[0].passive.stiffness = 2.0;
    });
    row("a limit of NaN", &|r| r.joints[0].limits.lower = f64::NAN);
    row("a negative limit of effort", &|r| r.joints[0].limits.effort = -1.0);
    row("a reflection", &|r| r.joints[0].parent_from_joint.rotation[2][2] = -1.0);
    row("a rotation with NaN", &|r| r.joints[0].parent_from_joint.rotation[0][0] = f64::NAN);
    row("a translation with NaN", &|r| r.joints[0].parent_from_joint.translation[1] = f64::NAN);
    row("infinite gravity", &|r| r.gravity[2] = f64::NEG_INFINITY);
    row("a mimic joint of an unknown joint", &|r| r.joints[1].mimic = following("knee"));
    row("a mimic joint of itself", &|r| r.joints[1].mimic = following("elbow"));
    row("two mimic joints of each other", &|r| {
        (r.joints[0].mimic, r.joints[1].mimic) = (following("elbow"), following("shoulder"));
    });
    row("a mimic joint of a ball joint", &|r| {
        r.joints[0].kind = JointKind::Spherical;
        r.joints[1].mimic = following("shoulder");
    });
    row("a fixed mimic joint", &|r| {
        r.joints[1].kind = JointKind::Fixed;
        r.joints[1].mimic = following("shoulder");
    });
    row("a ratio of NaN", &|r| r.joints[1].mimic = Some(Mimic::new("shoulder", f64::NAN, 0.0)));
    section
}

pub(crate) fn sensors() -> Section {
    let mut section = Section::new("ModelError of sensors");
    let mut row = |input: &str, sensor: SensorDescription| {
        let mut robot = pendulum(2.0, 0.5);
        robot.sensors.push(sensor);
        section.row(input, Model::new(robot).expect_err(input));
    };
    let gyro = |object: &str| SensorDescription::new("s", SensorKind::Gyro, object);
    row("an unknown frame", gyro("nose"));
    row("a gyroscope with a reference", gyro("tip").relative_to("rod"));
    row("a gyroscope of the robot", SensorDescription::new("s", SensorKind::Gyro, SensorObject::Robot));
    row("a quaternion of a hinge", SensorDescription::new("s", SensorKind::BallQuaternion, "hinge"));
    row("the clock of a link", SensorDescription::new("s", SensorKind::Clock, "rod"));
    row("a negative cutoff", gyro("tip").with_cutoff(-1.0));
    row("inside of nothing", SensorDescription::new("s", SensorKind::InsideSite, "tip"));
    section
}

pub(crate) fn surgery_error() -> Section {
    let mut section = Section::new("ModelError of edits");
    let mut robot = arm();
    section.row("lock an unknown joint", robot.lock_joint("nowhere", &[0.0]).expect_err("no joint"));
    section.row("lock a hinge at two numbers", robot.lock_joint("elbow", &[0.0, 1.0]).expect_err("length"));
    section.row("lock a hinge at NaN", robot.lock_joint("elbow", &[f64::NAN]).expect_err("NaN"));
    section.row("scale gravity by infinity", robot.scale_gravity(f64::INFINITY).expect_err("infinite"));
    section
}

pub(crate) fn fixed_size_error() -> Section {
    let mut section = Section::new("FixedSizeError");
    let model = |robot| Model::new(robot).expect("a robot");
    let error = dynamics::FixedSize::<6>::new(model(arm())).expect_err("another size");
    section.row("2 degrees of freedom for 6", error);
    let error = dynamics::FixedSize::<8>::new(model(floating_arm())).expect_err("a quaternion");
    section.row("a floating base", error);
    section
}

pub(crate) fn parameter_error() -> Section {
    let mut section = Section::new("ModelError of parameters");
    let mut robot = pendulum(2.0, 0.5);
    let model = Model::new(robot.clone()).expect("a robot");
    let values = parameter_values(&model);
    section.row("one too few", with_parameters(&model, &values[1..]).expect_err("one too few"));
    let gas = MassProperties::point(0.1, nalgebra::Vector3::zeros()).expect("a body");
    let mut balloon = LinkDescription::new("balloon", gas);
    balloon.gravity_compensation = 1.0;
    let rod = robot.links[1].name.clone();
    robot.links.push(balloon);
    robot.joints.push(joint("tie", JointKind::Fixed, &rod, "balloon"));
    let model = Model::new(robot).expect("a robot");
    let error = with_parameters(&model, &parameter_values(&model)).expect_err("two parts");
    section.row("a part of the weight of one body is carried", error);
    section
}

pub(crate) fn joint_map_error() -> Section {
    let mut section = Section::new("ModelError of a joint map");
    let full = Model::new(arm()).expect("a robot");
    let mut row = |input: &str, full: &Model, reference: &[f64], change: &dyn Fn(&mut RobotDescription)| {
        let mut reduced = full.description().clone();
        reduced.name = "reduced".into();
        change(&mut reduced);
        let reduced = Model::new(reduced).expect("a robot");
        section.row(input, JointMap::new(full, &reduced, reference).expect_err(input));
    };
    row("another name", &full, &[0.0; 2], &|r| r.joints[1].name = "elbow_b".into());
    row("another kind", &full, &[0.0; 2], &|r| r.joints[1].kind = JointKind::Spherical);
    row("coupled in the reduced robot", &full, &[0.0; 2], &|r| r.joints[1].mimic = following("shoulder"));
    row("a reference with NaN", &full, &[0.0, f64::NAN], &|r| {
        r.lock_joint("elbow", &[0.3]).expect("a hinge");
    });
    let mut coupled = arm();
    coupled.joints[1].mimic = following("shoulder");
    let coupled = Model::new(coupled).expect("a robot");
    row("fixed in the reduced robot, coupled in the full one", &coupled, &neutral(&coupled), &|r| {
        (r.joints[1].mimic, r.joints[1].kind) = (None, JointKind::Fixed);
    });
    let floating = Model::new(floating_arm()).expect("a robot");
    let mut reference = neutral(&floating);
    reference[2] = 0.5;
    row("a base fixed 0.5 m above the origin", &floating, &reference, &|r| r.base = Base::Fixed);
    section
}
