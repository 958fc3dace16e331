//! Contacts with moving surfaces, as of conveyor belts and turntables: against closed forms, and against the
//! same motion seen from the belt.

use std::f64::consts::FRAC_PI_2;

use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::description::{
    Elevation, JointDescription, JointKind, LinkDescription, LinkShape, Pose, RobotDescription, Shape,
    ShapeRole, SurfaceVelocity,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Method, Run, RunOptions, SimulationBuilder};

use crate::free_body::body;

const G: f64 = 9.81;

fn belt(speed: f64) -> SurfaceVelocity {
    SurfaceVelocity { linear: [speed, 0.0, 0.0], angular: [0.0; 3] }
}

fn run(
    robot: &RobotDescription,
    method: Method,
    ground: Option<Ground>,
    (q, v): (&[f64], &[f64]),
    (h, steps): (f64, usize),
) -> Run {
    let model = Model::new(robot.clone()).unwrap();
    let mut builder = SimulationBuilder::new(&model).method(method).dt(h);
    if let Some(ground) = ground {
        builder = builder.contacts(ContactSet::new(&model, &[ground]).unwrap());
    }
    builder.build().unwrap().run_steps_from(q, v, steps, RunOptions::new().sample_ends()).unwrap()
}

/// A block on a belt gains v = μ g t until it moves with the belt. The belt's work shows as a negative loss:
/// the energy account closes.
#[test]
fn block_is_carried_by_belt() {
    let (friction, speed, time) = (0.3, 0.5, 0.4);
    let brick = body(2e-3, Shape::Box { size: [0.2, 0.2, 0.1] });
    let ground = Ground::level(0.0).with_friction(friction).with_surface_velocity(belt(speed));
    let start: (&[f64], &[f64]) = (&[0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0], &[0.0; 6]);
    let early = run(&brick, Method::Implicit, Some(ground), start, (1e-3, 100));
    assert!((early.v[0] - friction * G * 0.1).abs() < 1e-9, "{:?}", early.v);
    let late = run(&brick, Method::Implicit, Some(ground), start, (1e-3, 400));
    assert!((late.v[0] - speed).abs() < 1e-9 && late.v[1..].iter().all(|v| v.abs() < 1e-9), "{:?}", late.v);
    let way = speed * time - speed * speed / (2.0 * friction * G);
    assert!((late.q[0] - way).abs() < 5e-4, "{} for {way}", late.q[0]);
    let account = &late.energy_account;
    assert!(account.max_imbalance() < 1e-9, "{account:?}");
    let sliding = late.losses.unwrap().sliding;
    assert!((sliding + 0.5 * speed * speed).abs() < 1e-9, "{sliding}");
}

/// On a turntable torsional friction, a moment of at most 0.02 m·N, turns a ball until it spins with the
/// table.
#[test]
fn ball_is_spun_by_turntable() {
    let (radius, spin, torsion) = (0.1, 3.0, 0.02);
    let moment = 0.4 * radius * radius;
    let mut ball = body(moment, Shape::Sphere { radius });
    ball.shapes[0].surface.condim = 4;
    ball.shapes[0].surface.friction[1] = torsion;
    let table = SurfaceVelocity { linear: [0.0; 3], angular: [0.0, 0.0, spin] };
    let ground = Ground::level(0.0).with_surface_velocity(table);
    let start: (&[f64], &[f64]) = (&[0.0, 0.0, radius, 0.0, 0.0, 0.0, 1.0], &[0.0; 6]);
    let early = run(&ball, Method::Implicit, Some(ground), start, (1e-4, 500));
    let expected = torsion * G / moment * 0.05;
    assert!(expected < spin && (early.v[5] - expected).abs() < 1e-6, "{} for {expected}", early.v[5]);
    let late = run(&ball, Method::Implicit, Some(ground), start, (1e-3, 200));
    assert!((late.v[5] - spin).abs() < 1e-9, "{:?}", late.v);
}

/// A free body over a table, which is fixed to the world.
fn over(table: LinkShape, body: &RobotDescription) -> RobotDescription {
    let mut robot = RobotDescription::new("body_and_table");
    robot.links.push(LinkDescription::new("world", None));
    robot.links.push(body.links[0].clone());
    robot.joints.push(JointDescription::new("free", JointKind::Floating, "world", "body", Pose::IDENTITY));
    robot.shapes.extend(body.shapes.iter().cloned().chain([table]));
    robot
}

/// Seen from a belt, the ground is at rest and the body has the opposite velocity in addition. A brick falls
/// and tumbles; a ball falls and rolls. The belt is a plane, a turned box, and a turned height field.
#[test]
fn belt_is_ground_at_rest_seen_from_belt() {
    let speed = 0.7;
    let brick = body(2e-3, Shape::Box { size: [0.2, 0.16, 0.1] });
    let mut ball = body(4e-3, Shape::Sphere { radius: 0.1 });
    ball.shapes[0].surface.condim = 6;
    let q = [0.1, -0.2, 0.2, 0.0, 0.0, 0.0, 1.0];
    let (rest, moved) = ([0.2, 0.1, 0.0, 0.5, -0.3, 1.0], [0.2 - speed, 0.1, 0.0, 0.5, -0.3, 1.0]);
    // −y of a shape that is turned by π/2 about z is x of the world.
    let turned = Pose::from_xyz_rpy([0.0, 0.0, -0.5], [0.0, 0.0, FRAC_PI_2]);
    let across = SurfaceVelocity { linear: [0.0, -speed, 0.0], angular: [0.0; 3] };
    let elevation = Some(Elevation::stretched(2, 2, &[1.0; 4], 0.5));
    let size = [4.0, 4.0, 0.5, 0.1];
    let field = Shape::HeightField { name: "flat".into(), file: None, size, elevation };
    let tables = [
        (Shape::Plane { half_size: [0.0; 2] }, Pose::IDENTITY, belt(speed)),
        (Shape::Box { size: [9.0, 9.0, 1.0] }, turned, across),
        (field, turned, across),
    ];
    for (shape, place, motion) in tables {
        let mut table = LinkShape::new("world", ShapeRole::Collision, place, shape);
        for (body, steps) in [(&brick, 250), (&ball, 500)] {
            for method in [Method::Implicit, Method::Mujoco] {
                let steps = (1e-3, steps);
                table.surface_velocity = SurfaceVelocity::default();
                let still = run(&over(table.clone(), body), method, None, (&q, &moved), steps);
                table.surface_velocity = motion;
                let carried = run(&over(table.clone(), body), method, None, (&q, &rest), steps);
                assert!(still.q[2] < 0.15, "it has landed: {:?}", still.q);
                let way = |k: usize| if k == 0 { speed * steps.0 * steps.1 as f64 } else { 0.0 };
                let off = |k: usize| (carried.q[k] - still.q[k] - way(k)).abs();
                let worst = (0..7).map(off).fold(0.0, f64::max);
                // An implicit step turns the velocities with the axes of the body, with an error of its
                // order.
                let allowed = if method == Method::Mujoco { 1e-9 } else { 1e-6 };
                assert!(worst < allowed, "{method:?}, {:?}: {worst:e}", table.shape);
            }
        }
    }
}
