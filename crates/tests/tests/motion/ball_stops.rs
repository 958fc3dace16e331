//! Limits of the angle of ball joints, against closed forms.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    Base, JointDescription, JointKind, Limits, LinkDescription, LinkShape, MassProperties, Pose,
    RobotDescription, Shape, ShapeRole,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{StepForces, StepWorkspace, Stepper};

use crate::free_body::{implicit_over, run_watched, stepper};

const G: f64 = 9.81;

/// A body with a mass at a position, a moment of inertia about each axis there, and a ball joint with a
/// maximal angle.
fn hanging(mass: f64, at: [f64; 3], moment: f64, most: f64) -> RobotDescription {
    let mut robot = RobotDescription::new("hanging");
    let body = MassProperties::new(mass, Vector3::from(at), Matrix3::identity() * moment).unwrap();
    robot.links.push(LinkDescription::new("world", None));
    robot.links.push(LinkDescription::new("body", body));
    let mut limits = Limits::default();
    limits.turn = most;
    let ball = JointDescription::new("ball", JointKind::Spherical, "world", "body", Pose::IDENTITY);
    robot.joints.push(ball.with_limits(limits));
    let shape = Shape::Sphere { radius: 0.01 };
    robot.shapes.push(LinkShape::new("body", ShapeRole::Collision, Pose::from_translation(at), shape));
    robot
}

fn angle(q: &[f64]) -> f64 {
    2.0 * q[..3].iter().map(|x| x * x).sum::<f64>().sqrt().atan2(q[3])
}

/// A pendulum on a ball joint starts at its limit on one side and swings to the limit on the other side. It
/// comes to rest there, at the same height if no energy is lost. From above it falls onto that limit, which
/// dissipates all of its energy.
#[test]
fn pendulum_comes_to_rest_at_its_limit() {
    let (mass, length, most) = (2.0, 0.5, 0.4_f64);
    let model = Model::new(hanging(mass, [0.0, 0.0, length], 1e-3, most)).unwrap();
    // The pendulum is upright at the angle 0 and falls sideways.
    let start = 0.05_f64;
    let q = [0.6 * (0.5 * start).sin(), 0.8 * (0.5 * start).sin(), 0.0, (0.5 * start).cos()];
    for ground in [None, Some(Ground::level(-10.0))] {
        let run = run_watched(implicit_over(&model, ground), (&q, &[0.0; 3]), (1e-3, 3000), |info| {
            assert!(angle(info.q) < most + 1e-8, "{}", angle(info.q) - most);
        });
        assert!((angle(&run.q) - most).abs() < 1e-8, "{}", angle(&run.q) - most);
        assert!(run.v.iter().all(|v| v.abs() < 1e-9), "{:?}", run.v);
        // It falls in a plane: its axis does not change.
        assert!((run.q[0] * 0.8 - run.q[1] * 0.6).abs() < 1e-9 && run.q[2].abs() < 1e-9, "{:?}", run.q);
        let lost = mass * G * length * (start.cos() - most.cos());
        let losses = run.losses.unwrap();
        // The impact is early or late by a sixteenth of a step: m g ℓ sin θ times the distance in that time.
        let late = mass * G * length * most.sin() * 1.5e-3 / 16.0;
        assert!(
            (losses.stops - lost).abs() < late && run.energy_account.max_imbalance() < late,
            "{losses:?} for {lost}"
        );
    }
}

/// A body with the same moment of inertia I about every axis glides along its limit θ at constant speed, with
/// an error of order 2. q moves on a circle with ψ̇ = ω/(2 sin ½θ), and the limit exerts ½Iω² cot ½θ.
#[test]
fn body_glides_along_its_limit() {
    let (moment, most, speed, time) = (0.02, 1.2_f64, 3.0, 1.0);
    let mut robot = hanging(1.0, [0.0; 3], moment, most);
    robot.gravity = [0.0; 3];
    let model = Model::new(robot).unwrap();
    let (sin, cos) = (0.5 * most).sin_cos();
    let rate = 0.5 * speed / sin;
    // n = (1, 0, 0), ṅ = ψ̇(0, 1, 0): ω of the body is 2 sin cos ṅ − 2 sin² n × ṅ.
    let v = [0.0, 2.0 * sin * cos * rate, -2.0 * sin * sin * rate];
    let q = [sin, 0.0, 0.0, cos];
    let end = [sin * (rate * time).cos(), sin * (rate * time).sin(), 0.0, cos];
    let off = [(2e-3, 500), (1e-3, 1000)].map(|(h, steps)| {
        let run = run_watched(implicit_over(&model, None), (&q, &v), (h, steps), |_| {});
        let norm = run.v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let way = run.q.iter().zip(&end).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        println!(
            "h = {h}: way off {way:e}, speed off {:e}, limit off {:e}",
            norm - speed,
            angle(&run.q) - most
        );
        assert!((angle(&run.q) - most).abs() < 1e-8, "{}", angle(&run.q) - most);
        way
    });
    assert!(off[1] < 1e-4 && off[0] > 3.5 * off[1], "{off:?}");
}

/// A free body with a hand on a ball joint at its limit: momentum is conserved.
#[test]
fn limit_between_free_bodies_conserves_momentum() {
    let mut robot = hanging(1.0, [0.0, 0.0, -0.3], 0.01, 0.5);
    robot.base = Base::Floating;
    robot.gravity = [0.0; 3];
    robot.links[0] = LinkDescription::new(
        "world",
        MassProperties::new(3.0, Vector3::zeros(), Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.3)))
            .unwrap(),
    );
    let model = Model::new(robot).unwrap();
    let (mut q, mut v) =
        (robot_dynamics::model::neutral(&model), vec![0.1, 0.2, 0.3, 0.5, -0.4, 0.3, 2.0, 1.0, -0.5]);
    let mut workspace = StepWorkspace::new(&model);
    let momentum = |q: &[f64], v: &[f64]| {
        robot_dynamics::algorithms::centroidal_momentum(
            &model,
            &mut robot_dynamics::model::Workspace::new(&model),
            q,
            v,
        )
    };
    let start = momentum(&q, &v);
    let mut implicit = stepper(implicit_over(&model, None));
    for _ in 0..1000 {
        implicit
            .step(&model, &mut workspace, &StepForces::new(&[0.0; 9], true), 1e-3, &mut q, &mut v)
            .unwrap();
        assert!(angle(&q[7..]) < 0.5 + 1e-7, "{}", angle(&q[7..]));
    }
    let end = momentum(&q, &v);
    // The error of the integration scheme.
    let off = (0..3)
        .map(|k| (start.linear[k] - end.linear[k]).abs().max((start.angular[k] - end.angular[k]).abs()));
    let off = off.fold(0.0, f64::max);
    assert!(off < 1e-3, "{off:e}: {start:?}, {end:?}");
}
