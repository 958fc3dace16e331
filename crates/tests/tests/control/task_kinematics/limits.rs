//! Limits of positions, velocities, accelerations and distances, over many steps.

use nalgebra::Matrix3;
use robot_dynamics::contact::ContactSet;
use robot_dynamics::control::InverseKinematicsOptions;
use robot_dynamics::control::task_kinematics::{
    CollisionAvoidance, KinematicLimit, KinematicLimits, KinematicObjective, KinematicTask, TaskKinematics,
    TaskKinematicsError,
};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription,
    Shape, ShapeRole,
};
use robot_dynamics::model::Model;

use super::{load, with_objective};

const DT: f64 = 0.01;

/// A target out of reach: every step of the way satisfies all limits.
#[test]
fn motions_stay_within_all_limits() {
    let model = load("panda.urdf", Base::Fixed);
    let hand = model.frame_named("panda_link8").expect("a frame");
    let mut kinematics = TaskKinematics::new(&model);
    // A gain of 3 1/s is slow enough for the acceleration limits.
    let task = KinematicTask::new(KinematicObjective::pose(hand, [2.0, 1.0, 0.2])).with_gain(0.03);
    kinematics.add_task(task).expect("a task");
    let mut limits = KinematicLimits::of(&model);
    limits.acceleration.fill(8.0);
    limits.position[1] = [-0.5, 0.1];
    limits.velocity.fill(0.8);
    kinematics.set_limits(limits.clone()).expect("valid limits");
    // The arm stretches towards the target; there J is singular.
    kinematics.set_damping(0.1).expect("a valid damping");
    let (mut q, mut v) = (vec![0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8], vec![0.0; 7]);
    let mut at_limit = [0; 3];
    for _ in 0..3000 {
        let step = kinematics.step(&q, &v, DT).expect("a step");
        for i in 0..7 {
            let [low, high] = limits.position[i];
            let (next, rate) = (step.q[i], step.velocity[i]);
            assert!(next >= low - 1e-12 && next <= high + 1e-12, "position {i}: {next}");
            assert!(rate.abs() <= limits.velocity[i] + 1e-12, "velocity {i}: {rate}");
            assert!((rate - v[i]).abs() <= 8.0 * DT + 1e-12, "acceleration {i}");
            at_limit[0] += usize::from(next - low < 1e-3 || high - next < 1e-3);
            at_limit[1] += usize::from(rate.abs() > limits.velocity[i] - 1e-9);
            at_limit[2] += usize::from((rate - v[i]).abs() > 8.0 * DT - 1e-9);
        }
        (q, v) = (step.q.clone(), step.velocity.clone());
    }
    assert!(at_limit.iter().all(|count| *count > 0), "each limit is reached: {at_limit:?}");
    assert!(v.iter().all(|v| v.abs() < 1e-3), "the arm comes to rest: {v:?}");
}

/// Two balls of 0.1 m on slides along x, from −0.5 and 0.5.
fn two_balls() -> Model {
    let mut robot = RobotDescription::new("two balls");
    robot.links.push(LinkDescription::new("base", None));
    for (name, x) in [("left", -0.5), ("right", 0.5)] {
        let mass = MassProperties::new(1.0, [0.0; 3].into(), Matrix3::identity()).ok();
        robot.links.push(LinkDescription::new(name, mass));
        let slide = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
        let mut joint = JointDescription::new(
            format!("{name} slide"),
            slide,
            "base",
            name,
            Pose::from_translation([x, 0.0, 0.0]),
        );
        (joint.limits.lower, joint.limits.upper) = (-2.0, 2.0);
        robot.joints.push(joint);
        let ball = Shape::Sphere { radius: 0.1 };
        robot.shapes.push(LinkShape::new(name, ShapeRole::Collision, Pose::IDENTITY, ball));
    }
    Model::new(robot).expect("a valid robot")
}

fn apart(model: &Model, least: f64) -> TaskKinematics<&Model> {
    let left = model.frame_named("left").expect("a link");
    let mut kinematics = with_objective(model, KinematicObjective::pose(left, [1.0, 0.0, 0.0]));
    let contacts = ContactSet::new(model, &[]).expect("shapes").with_links(model);
    kinematics.avoid_collisions(contacts, CollisionAvoidance::new(least)).expect("a valid law");
    kinematics
}

/// The left ball pushes the right one ahead of it, at the least distance and nowhere nearer.
#[test]
fn links_keep_their_distance() {
    let model = two_balls();
    let mut kinematics = apart(&model, 0.05);
    let right = model.frame_named("right").expect("a link");
    // The right ball resists, but its task is at a later level.
    let stay = KinematicObjective::pose(right, [0.5, 0.0, 0.0]);
    kinematics.add_task(KinematicTask::new(stay).with_level(1)).expect("a task");
    let mut limits = KinematicLimits::of(&model);
    limits.velocity.fill(1.0);
    kinematics.set_limits(limits).expect("limits");
    let (mut q, v, mut nearest) = (vec![0.0; 2], vec![0.0; 2], f64::INFINITY);
    for _ in 0..400 {
        let step = kinematics.step(&q, &v, DT).expect("a step");
        q.clone_from(&step.q);
        nearest = nearest.min(q[1] + 0.5 - (q[0] - 0.5) - 0.2);
    }
    // The linear rows are exact for slides.
    assert!(nearest >= 0.05 - 1e-12, "{nearest}");
    assert!((q[0] - 0.5 - 1.0).abs() < 1e-9, "the left ball arrives: {q:?}");
    assert!((q[1] + 0.5 - 1.25).abs() < 1e-6, "the right ball makes way: {q:?}");
}

/// Links that are too near move apart; the global solution keeps them apart, too.
#[test]
fn links_move_apart() {
    let model = two_balls();
    let mut kinematics = apart(&model, 0.05);
    let mut limits = KinematicLimits::of(&model);
    limits.velocity.fill(1.0);
    kinematics.set_limits(limits).expect("limits");
    let (mut q, v) = (vec![0.4, -0.39], vec![0.0; 2]);
    for _ in 0..100 {
        let step = kinematics.step(&q, &v, DT).expect("a step");
        q.clone_from(&step.q);
    }
    assert!(q[1] - q[0] + 1.0 - 0.2 >= 0.05 - 1e-9, "{q:?}");
    let found = kinematics.solve(&[0.0, 0.0], &InverseKinematicsOptions::default()).expect("a solution");
    assert!((found.q[0] - 1.5).abs() < 1e-8 && found.q[1] - found.q[0] + 0.8 >= 0.05, "{:?}", found.q);
}

/// A ball that must move apart faster than its limits allow: the error names the limit.
#[test]
fn contradictions_name_a_limit() {
    let model = two_balls();
    let mut kinematics = apart(&model, 0.05);
    let mut limits = KinematicLimits::of(&model);
    limits.acceleration.fill(1.0);
    kinematics.set_limits(limits).expect("limits");
    // Both move towards each other at 10 m/s, 1 mm before the least distance.
    match kinematics.step(&[0.374, -0.375], &[10.0, -10.0], DT) {
        Err(TaskKinematicsError::Infeasible { limit }) => {
            let named =
                matches!(&limit, KinematicLimit::Distance { links } if links.contains(&"left".to_owned()));
            assert!(named || matches!(limit, KinematicLimit::Acceleration { .. }), "{limit}");
        }
        other => panic!("{other:?}"),
    }
}
