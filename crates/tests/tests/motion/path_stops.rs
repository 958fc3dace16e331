//! Limits of the length of spatial tendons, against closed forms.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    FrameDescription, JointDescription, JointKind, Limits, LinkDescription, LinkShape, MassProperties, Pose,
    RobotDescription, Shape, ShapeRole, SpatialTendonDescription, TendonPathElement, TendonSurface,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Run, StepInfo};

use crate::free_body::{implicit_over, run_watched};

const G: f64 = 9.81;
const FAR_BELOW: fn() -> Ground = || Ground::level(-100.0);

/// Adds a ball of this mass, whose origin is its centre.
fn add_ball(robot: &mut RobotDescription, name: &str, mass: f64, joint: JointKind, at: [f64; 3]) {
    let radius: f64 = 0.05;
    let moment = Matrix3::identity() * (0.4 * mass * radius * radius);
    let mass = MassProperties::new(mass, Vector3::zeros(), moment).unwrap();
    robot.links.push(LinkDescription::new(name, mass));
    let at = Pose::from_translation(at);
    robot.joints.push(JointDescription::new(format!("{name}_joint"), joint, "world", name, at));
    robot.shapes.push(LinkShape::new(name, ShapeRole::Collision, Pose::IDENTITY, Shape::Sphere { radius }));
}

fn point(frame: &str) -> TendonPathElement {
    TendonPathElement::Point { frame: frame.into() }
}

/// A free ball at a place, on a rope of 1 m from the origin.
fn ball_on_rope(at: [f64; 3]) -> (RobotDescription, Vec<f64>) {
    let mut robot = RobotDescription::new("ball on a rope");
    robot.links.push(LinkDescription::new("world", None));
    robot.frames.push(FrameDescription::new("hook", "world", Pose::IDENTITY));
    add_ball(&mut robot, "ball", 2.0, JointKind::Floating, [0.0; 3]);
    let mut rope = SpatialTendonDescription::new("rope", vec![point("hook"), point("ball")]);
    rope.limits = Limits::new(f64::NEG_INFINITY, 1.0);
    robot.spatial_tendons.push(rope);
    let q = [at[0], at[1], at[2], 0.0, 0.0, 0.0, 1.0].to_vec();
    (robot, q)
}

fn run(
    robot: &RobotDescription,
    ground: Option<Ground>,
    (q, v): (&[f64], &[f64]),
    steps: (f64, usize),
    watch: impl FnMut(&StepInfo<'_>),
) -> Run {
    let model = Model::new(robot.clone()).unwrap();
    run_watched(implicit_over(&model, ground), (q, v), steps, watch)
}

/// The angle of a pendulum of 1 m and its rate after a time, by the classical method in steps of 0.1 ms.
fn pendulum([mut angle, mut rate]: [f64; 2], time: f64) -> [f64; 2] {
    let h = 1e-4;
    let slope = |[angle, rate]: [f64; 2]| [rate, -G * angle.sin()];
    let steps = (0..1_000_000).take_while(|k| f64::from(*k) * h < time - 0.5 * h).count();
    for _ in 0..steps {
        let x = [angle, rate];
        let along = |s: [f64; 2], c: f64| [x[0] + c * s[0], x[1] + c * s[1]];
        let a = slope(x);
        let b = slope(along(a, 0.5 * h));
        let c = slope(along(b, 0.5 * h));
        let d = slope(along(c, h));
        angle += h / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0]);
        rate += h / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1]);
    }
    [angle, rate]
}

/// A ball that starts on the taut rope swings as a pendulum. All errors decrease with h².
#[test]
fn ball_on_taut_rope_is_a_pendulum() {
    let start = 1.0_f64;
    let (robot, q) = ball_on_rope([start.sin(), 0.0, -start.cos()]);
    let [angle, rate] = pendulum([start, 0.0], 1.0);
    let energy = 2.0 * G * (1.0 - start.cos());
    for ground in [None, Some(FAR_BELOW())] {
        let errors = [1000, 2000].map(|steps| {
            let mut longest = 0.0_f64;
            let run = run(&robot, ground, (&q, &[0.0; 6]), (1.0 / steps as f64, steps), |info| {
                longest = longest.max(Vector3::new(info.q[0], info.q[1], info.q[2]).norm());
            });
            assert!(longest < 1.0 + 1e-12, "{longest}");
            let at = Vector3::new(angle.sin(), 0.0, -angle.cos());
            let velocity = Vector3::new(angle.cos(), 0.0, angle.sin()) * rate;
            let off = Vector3::new(run.q[0], run.q[1], run.q[2]) - at;
            let too_fast = Vector3::new(run.v[0], run.v[1], run.v[2]) - velocity;
            let (imbalance, losses) = (run.energy_account.max_imbalance(), run.losses.unwrap());
            [off.norm(), too_fast.norm(), imbalance / energy, losses.stops / energy]
        });
        for (long, short) in errors[0].into_iter().zip(errors[1]) {
            assert!(long < 5e-5 && short < long / 3.9, "{errors:?}");
        }
    }
}

/// A ball falls freely until the rope is taut. The velocity along the rope is then lost, and it swings.
#[test]
fn rope_stops_falling_ball() {
    let (robot, q) = ball_on_rope([0.6, 0.0, 0.0]);
    let taut = (2.0 * 0.8 / G).sqrt();
    let speed = G * taut;
    let lost = 2.0 * 0.5 * (0.8 * speed).powi(2);
    // The ball is at the angle atan(0.6/0.8), and 0.6 of its velocity is across the rope, towards the middle.
    let [angle, _] = pendulum([0.6_f64.atan2(0.8), -0.6 * speed], 0.7 - taut);
    for ground in [None, Some(FAR_BELOW())] {
        let mut longest = 0.0_f64;
        let run = run(&robot, ground, (&q, &[0.0; 6]), (1e-3, 700), |info| {
            longest = longest.max(Vector3::new(info.q[0], info.q[1], info.q[2]).norm());
        });
        assert!(longest < 1.0 + 1e-9, "{longest}");
        let losses = run.losses.unwrap();
        assert!((losses.stops - lost).abs() < 1e-2 * lost, "{losses:?} for {lost}");
        assert!(run.energy_account.max_imbalance() < 1e-3 * lost, "{:?}", run.energy_account);
        // The impact is early or late by a sixteenth of a step.
        let off = Vector3::new(run.q[0] - angle.sin(), run.q[1], run.q[2] + angle.cos()).norm();
        assert!(off < 1e-3, "{off}: {:?} for {angle}", run.q);
    }
}

/// Atwood's machine: a rope over a fixed cylinder, with a weight at each end, moves with
/// (m₁ − m₂)/(m₁ + m₂) g.
#[test]
fn weights_on_rope_around_pulley_move_as_atwoods_machine() {
    let masses = [1.0, 2.0];
    let mut robot = RobotDescription::new("pulley");
    robot.links.push(LinkDescription::new("world", None));
    for (k, mass) in masses.into_iter().enumerate() {
        let at = [[-0.2, 0.2][k], 0.0, -1.0];
        let slide = JointKind::Prismatic { axis: [0.0, 0.0, 1.0] };
        add_ball(&mut robot, &format!("weight{k}"), mass, slide, at);
    }
    robot.frames.push(FrameDescription::new("top", "world", Pose::from_translation([0.0, 0.0, 0.5])));
    let drum = TendonPathElement::Surface {
        link: "world".into(),
        link_from_surface: Pose::from_xyz_rpy([0.0; 3], [core::f64::consts::FRAC_PI_2, 0.0, 0.0]),
        surface: TendonSurface::Cylinder,
        radius: 0.2,
        side: Some("top".into()),
    };
    let mut rope = SpatialTendonDescription::new("rope", vec![point("weight0"), drum, point("weight1")]);
    rope.limits = Limits::new(f64::NEG_INFINITY, 2.0 + 0.2 * core::f64::consts::PI);
    robot.spatial_tendons.push(rope);
    let expected = (masses[1] - masses[0]) / (masses[0] + masses[1]) * G;
    for ground in [None, Some(FAR_BELOW())] {
        let run = run(&robot, ground, (&[0.0; 2], &[0.0; 2]), (1e-3, 500), |info| {
            assert!((info.q[0] + info.q[1]).abs() < 1e-8, "{:?}", info.q);
        });
        let (v, q) = (expected * 0.5, 0.5 * expected * 0.25);
        assert!((run.v[0] - v).abs() < 1e-7 && (run.v[1] + v).abs() < 1e-7, "{:?} for {v}", run.v);
        assert!((run.q[0] - q).abs() < 1e-7, "{:?} for {q}", run.q);
        assert!(run.losses.unwrap().stops.abs() < 1e-6, "{:?}", run.losses);
        assert!(run.energy_account.max_imbalance() < 1e-6, "{:?}", run.energy_account);
    }
}
