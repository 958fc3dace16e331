//! Limits of the length of tendons, against closed forms.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::contact::Ground;
use robot_dynamics::description::{
    JointDescription, JointKind, Limits, LinkDescription, LinkShape, MassProperties, PassiveForces, Pose,
    RobotDescription, Shape, ShapeRole, TendonDescription,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Run, StepInfo};

use crate::free_body::{implicit_over, run_watched};

const G: f64 = 9.81;

/// Two bodies on slides along this axis, each with a ball, and a tendon over both with a maximal length.
fn pair(
    axis: [f64; 3],
    masses: [f64; 2],
    factors: [f64; 2],
    bound: f64,
    limits: [Limits; 2],
) -> RobotDescription {
    let mut robot = RobotDescription::new("pair");
    robot.links.push(LinkDescription::new("world", None));
    for k in 0..2 {
        let (link, joint) = (format!("body{k}"), format!("slide{k}"));
        let mass = MassProperties::new(masses[k], Vector3::zeros(), Matrix3::identity()).unwrap();
        robot.links.push(LinkDescription::new(&link, mass));
        let at = Pose::from_translation([0.0, k as f64, 0.0]);
        let slide = JointDescription::new(&joint, JointKind::Prismatic { axis }, "world", &link, at);
        robot.joints.push(slide.with_limits(limits[k]));
        let ball = Shape::Sphere { radius: 0.1 };
        robot.shapes.push(LinkShape::new(link, ShapeRole::Collision, Pose::IDENTITY, ball));
    }
    let terms = [0, 1].map(|k| (format!("slide{k}"), factors[k]));
    let mut tendon = TendonDescription::new("cable", terms);
    tendon.limits.upper = bound;
    robot.tendons.push(tendon);
    robot
}

fn run(
    robot: &RobotDescription,
    ground: Option<Ground>,
    v: [f64; 2],
    steps: (f64, usize),
    watch: impl FnMut(&StepInfo<'_>),
) -> Run {
    let model = Model::new(robot.clone()).unwrap();
    run_watched(implicit_over(&model, ground), (&[0.0; 2], &v), steps, watch)
}

const FAR_BELOW: fn() -> Ground = || Ground::level(-100.0);

/// The bodies slide freely until the cable is taut at t = L/ℓ̇. They continue with v − p c/m, p = ℓ̇/Σc²/m: ℓ
/// stays at its limit, and the account of the limit is ½pℓ̇.
#[test]
fn cable_stops_bodies_at_its_limit() {
    let (masses, factors, bound, v) = ([1.0, 2.0], [1.0, 0.5], 0.3, [1.0, 0.5]);
    let robot = pair([1.0, 0.0, 0.0], masses, factors, bound, [Limits::default(); 2]);
    let rate = factors[0] * v[0] + factors[1] * v[1];
    let impulse = rate / (0..2).map(|k| factors[k] * factors[k] / masses[k]).sum::<f64>();
    let taut = bound / rate;
    for ground in [None, Some(FAR_BELOW())] {
        let mut longest = 0.0_f64;
        let run = run(&robot, ground, v, (1e-3, 1000), |info| {
            longest = longest.max(factors[0] * info.q[0] + factors[1] * info.q[1]);
        });
        assert!(longest < bound + 1e-9, "{longest}");
        for k in 0..2 {
            let after = v[k] - impulse * factors[k] / masses[k];
            assert!((run.v[k] - after).abs() < 1e-9, "{:?} for {after}", run.v);
            // The impact is early or late by a sixteenth of a step.
            let end = v[k] * taut + after * (1.0 - taut);
            assert!((run.q[k] - end).abs() < 1e-3 / 16.0, "{:?} for {end}", run.q);
        }
        let losses = run.losses.unwrap();
        assert!((losses.stops - 0.5 * impulse * rate).abs() < 1e-9, "{losses:?}");
        assert!(run.energy_account.max_imbalance() < 1e-9, "{:?}", run.energy_account);
    }
}

/// Atwood's machine: two weights on one cable move with (m₁ − m₂)/(m₁ + m₂) g, with and without contacts.
#[test]
fn weights_on_cable_move_as_atwoods_machine() {
    let masses = [1.0, 2.0];
    let robot = pair([0.0, 0.0, -1.0], masses, [1.0, 1.0], 0.0, [Limits::default(); 2]);
    let expected = (masses[0] - masses[1]) / (masses[0] + masses[1]) * G;
    for ground in [None, Some(FAR_BELOW())] {
        let run = run(&robot, ground, [0.0; 2], (1e-3, 1000), |info| {
            assert!((info.q[0] + info.q[1]).abs() < 1e-9, "{:?}", info.q);
        });
        assert!((run.v[0] - expected).abs() < 1e-8 && (run.v[1] + expected).abs() < 1e-8, "{:?}", run.v);
        assert!((run.q[0] - 0.5 * expected).abs() < 1e-8, "{:?}", run.q);
        assert!(
            run.losses.unwrap().stops.abs() < 1e-8 && run.energy_account.max_imbalance() < 1e-8,
            "{:?}",
            run.energy_account
        );
    }
}

/// The limits of both slides and of the cable are redundant. All come to rest, the heavier weight at its
/// limit, the lighter one held by its limit and by the cable.
#[test]
fn redundant_limits_hold() {
    for lower in [-0.5, -0.6] {
        let limits = [Limits::new(lower, 1.0), Limits::new(-1.0, 0.5)];
        let robot = pair([0.0, 0.0, -1.0], [1.0, 2.0], [1.0, 1.0], 0.0, limits);
        for ground in [None, Some(FAR_BELOW())] {
            let run = run(&robot, ground, [0.0; 2], (1e-3, 2500), |_| {});
            let off = (run.q[0] + 0.5).abs().max((run.q[1] - 0.5).abs());
            assert!(off < 1e-9 && run.v.iter().all(|v| v.abs() < 1e-9), "{lower}: {:?}, {:?}", run.q, run.v);
            let expected = (2.0 - 1.0) * G * 0.5; // the loss of height of the weights
            let lost = run.losses.unwrap().stops;
            assert!((lost - expected).abs() < 2e-2, "{lost} for {expected}");
        }
    }
}

/// The heavier weight comes to rest on the ground, which carries the difference of the weights.
#[test]
fn cable_takes_weight_from_ground() {
    let robot = pair([0.0, 0.0, -1.0], [1.0, 2.0], [1.0, 1.0], 0.0, [Limits::default(); 2]);
    let run = run(&robot, Some(Ground::level(-0.4)), [0.0; 2], (1e-3, 6000), |info| {
        assert!(info.q[0] + info.q[1] < 1e-6, "{:?}", info.q);
    });
    assert!((run.q[1] - 0.3).abs() < 1e-8 && (run.q[0] + 0.3).abs() < 1e-8, "{:?}", run.q);
    assert!(run.v.iter().all(|v| v.abs() < 1e-8), "{:?}", run.v);
    let force = run.contact_forces[1][2];
    assert!((force - (2.0 - 1.0) * G).abs() < 1e-6, "{force}");
}

/// Dry friction of a cable over two falling bodies. If it can carry both, it sticks, and they move as on
/// Atwood's machine. Otherwise c f brakes each of them, and f·ℓ is lost. With and without contacts.
#[test]
fn friction_of_cable_brakes_bodies() {
    let masses = [1.0, 2.0];
    let carries = 2.0 * masses[0] * masses[1] / (masses[0] + masses[1]) * G;
    for ground in [None, Some(FAR_BELOW())] {
        let run = |friction: f64| {
            let mut robot = pair([0.0, 0.0, -1.0], masses, [1.0, 1.0], f64::INFINITY, [Limits::default(); 2]);
            robot.tendons[0].passive = PassiveForces::default().with_friction(friction);
            let model = Model::new(robot).unwrap();
            run_watched(implicit_over(&model, ground), (&[0.0; 2], &[0.0; 2]), (1e-3, 1000), |_| {})
        };
        let sticks = run(1.001 * carries);
        let expected = (masses[0] - masses[1]) / (masses[0] + masses[1]) * G;
        assert!((sticks.q[0] + sticks.q[1]).abs() < 1e-9, "{:?}", sticks.q);
        assert!(
            (sticks.v[0] - expected).abs() < 1e-8 && (sticks.v[1] + expected).abs() < 1e-8,
            "{:?}",
            sticks.v
        );
        assert!(
            sticks.losses.unwrap().friction < 1e-8 && sticks.energy_account.max_imbalance() < 1e-8,
            "{:?}",
            sticks.energy_account
        );
        let friction = 0.4 * carries;
        let slides = run(friction);
        for k in 0..2 {
            let a = G - friction / masses[k];
            assert!((slides.v[k] - a).abs() < 1e-9 && (slides.q[k] - 0.5 * a).abs() < 1e-9, "{:?}", slides.v);
        }
        let lost = friction * (slides.q[0] + slides.q[1]);
        assert!((slides.losses.unwrap().friction - lost).abs() < 1e-8, "{:?} for {lost}", slides.losses);
        assert!(slides.energy_account.max_imbalance() < 1e-8, "{:?}", slides.energy_account);
    }
}
