//! Contact between links, against closed forms and laws.

use std::ops::ControlFlow;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::centroidal_momentum;
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, LinkShape, MassProperties, Pose, RobotDescription, Shape,
    ShapeRole,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Run, RunOptions, StepForces, StepInfo, StepWorkspace, Stepper};
use robot_dynamics::verification::admm;

use crate::free_body::{implicit_on, stepper};

const G: f64 = 9.81;

/// Free bodies in a world: mass, moment of inertia about each axis, shape.
fn bodies(all: &[(f64, f64, Shape)]) -> RobotDescription {
    let mut robot = RobotDescription::new("bodies");
    robot.links.push(LinkDescription::new("world", None));
    for (k, (mass, moment, shape)) in all.iter().enumerate() {
        let name = format!("body{k}");
        let mass = MassProperties::new(*mass, Vector3::zeros(), Matrix3::identity() * *moment).unwrap();
        robot.links.push(LinkDescription::new(&name, mass));
        // Placed side by side in the neutral configuration.
        let at = Pose::from_translation([10.0 * k as f64, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(format!("free{k}"), JointKind::Floating, "world", &name, at));
        robot.shapes.push(LinkShape::new(&name, ShapeRole::Collision, Pose::IDENTITY, shape.clone()));
    }
    robot
}

fn ball(mass: f64, radius: f64) -> (f64, f64, Shape) {
    (mass, 0.4 * mass * radius * radius, Shape::Sphere { radius })
}

/// q with the centres of the bodies at these positions.
fn placed(at: &[[f64; 3]]) -> Vec<f64> {
    let each = at.iter().enumerate();
    each.flat_map(|(k, [x, y, z])| [x - 10.0 * k as f64, *y, *z, 0.0, 0.0, 0.0, 1.0]).collect()
}

fn with_friction(mut robot: RobotDescription, friction: f64) -> RobotDescription {
    robot.shapes.iter_mut().for_each(|shape| shape.surface.friction[0] = friction);
    robot
}

fn run_watched(
    model: &Model,
    contacts: &ContactSet,
    (q, v): (&[f64], &[f64]),
    (h, steps): (f64, usize),
    mut watch: impl FnMut(&StepInfo<'_>) -> bool,
) -> Run {
    let mut observer = |info: &StepInfo<'_>| {
        if watch(info) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    implicit_on(model, contacts.clone())
        .dt(h)
        .build()
        .unwrap()
        .run_steps_from(q, v, steps, RunOptions::new().sample_ends().observer(&mut observer))
        .unwrap()
}

/// Two balls that collide without restitution continue together according to their momentum, for any masses,
/// and lose ½ m₁m₂/(m₁ + m₂) v².
#[test]
fn colliding_balls_continue_together() {
    for heavy in [1.0, 3.0, 1e6] {
        let mut robot = bodies(&[ball(1.0, 0.1), ball(heavy, 0.2)]);
        robot.gravity = [0.0; 3];
        let model = Model::new(robot).unwrap();
        let contacts = ContactSet::new(&model, &[]).unwrap().with_links(&model);
        let mut v = [0.0; 12];
        v[0] = 2.0;
        let q = placed(&[[0.0; 3], [0.5, 0.0, 0.0]]);
        let run = run_watched(&model, &contacts, (&q, &v), (1e-3, 500), |_| true);
        let expected = 2.0 / (1.0 + heavy);
        for k in [0, 6] {
            assert!((run.v[k] - expected).abs() < 1e-9, "{heavy}: {:?}", run.v);
        }
        let lost = 0.5 * heavy / (1.0 + heavy) * 4.0;
        assert!((run.losses.unwrap().impacts - lost).abs() < 1e-6 * lost, "{heavy}: {:?}", run.losses);
        let apart = run.q[7] + 10.0 - run.q[0];
        assert!((apart - 0.3).abs() < 1e-9, "{apart}");
    }
}

/// Balls that bounce: v₁⁺ − v₂⁺ = −e(v₁ − v₂), and the momentum is conserved.
#[test]
fn colliding_balls_bounce() {
    for (heavy, e) in [(1.0, 1.0), (3.0, 1.0), (1e6, 0.5), (2.0, 0.3)] {
        let mut robot = bodies(&[ball(1.0, 0.1), ball(heavy, 0.2)]);
        robot.gravity = [0.0; 3];
        let model = Model::new(robot).unwrap();
        let contacts = ContactSet::new(&model, &[]).unwrap().with_links(&model);
        let contacts = contacts.with_link_restitution(e).unwrap();
        let mut v = [0.0; 12];
        v[0] = 2.0;
        let q = placed(&[[0.0; 3], [0.5, 0.0, 0.0]]);
        let run = run_watched(&model, &contacts, (&q, &v), (1e-3, 500), |_| true);
        let (first, second) = (2.0 * (1.0 - e * heavy) / (1.0 + heavy), 2.0 * (1.0 + e) / (1.0 + heavy));
        assert!(
            (run.v[0] - first).abs() < 1e-9 && (run.v[6] - second).abs() < 1e-9,
            "{heavy} {e}: {:?}",
            run.v
        );
        let lost = 0.5 * heavy / (1.0 + heavy) * 4.0 * (1.0 - e * e);
        assert!((run.losses.unwrap().impacts - lost).abs() < 1e-6, "{heavy} {e}: {:?}", run.losses);
    }
}

/// A ball on a fixed ball: without friction it leaves at cos θ = ⅔. With high friction it rolls with
/// v² = 10/7 g (R + r)(1 − cos θ), to order 2.
#[test]
fn ball_leaves_fixed_ball() {
    let (big, small) = (0.5, 0.1);
    let reach = big + small;
    let make = |friction: f64| {
        let mut robot = with_friction(bodies(&[ball(1.0, small)]), friction);
        let fixed = Shape::Sphere { radius: big };
        let at = Pose::from_translation([0.0, 0.0, -reach]);
        robot.shapes.push(
            LinkShape::new("world", ShapeRole::Collision, at, fixed).with_surface(robot.shapes[0].surface),
        );
        let model = Model::new(robot).unwrap();
        let contacts = ContactSet::new(&model, &[]).unwrap().with_links(&model);
        assert_eq!(contacts.pairs().count(), 1, "{:?}", contacts.left_out_pairs());
        (model, contacts)
    };
    let start: f64 = 0.05;
    let q = placed(&[[reach * start.sin(), 0.0, reach * (start.cos() - 1.0)]]);
    let height = |q: &[f64]| (q[2] + reach) / q[0].hypot(q[2] + reach);

    let (model, contacts) = make(0.0);
    let mut left_at = None;
    run_watched(&model, &contacts, (&q, &[0.0; 6]), (1e-3, 3000), |info| {
        let gap = info.q[0].hypot(info.q[2] + reach) - reach;
        assert!(gap > -1e-6, "{gap}");
        left_at = (gap > 1e-5).then(|| height(info.q));
        left_at.is_none()
    });
    // v² = 2 g reach (cos θ₀ − cos θ) = g reach cos θ; a little later it is 0.01 mm away.
    let expected = 2.0 / 3.0 * start.cos();
    let left_at = left_at.unwrap();
    assert!(left_at < expected && expected - left_at < 0.03, "{left_at} for {expected}");

    let (model, contacts) = make(5.0);
    let [coarse, fine] = [4e-3, 2e-3].map(|h| {
        let mut off = f64::NAN;
        let run = run_watched(&model, &contacts, (&q, &[0.0; 6]), (h, 3000), |info| {
            let cos = height(info.q);
            let square = info.v[..3].iter().map(|v| v * v).sum::<f64>();
            off = (square - 10.0 / 7.0 * G * reach * (start.cos() - cos)).abs();
            cos > 0.9
        });
        assert!(run.losses.unwrap().sliding < 1e-6, "{:?}", run.losses);
        off
    });
    assert!(fine < 1e-3 && coarse > 2.5 * fine, "{coarse}, {fine}");
}

/// Capsules lie across each other, and one lies along another in two points; all are at rest, and the ground
/// carries their weight.
#[test]
fn capsules_lie_on_capsules() {
    let capsule = || (1.0, 4e-3, Shape::Capsule { radius: 0.05, length: 0.4 });
    let robot = bodies(&[capsule(), capsule(), capsule()]);
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap().with_links(&model);
    assert_eq!(contacts.pairs().count(), 3);
    // Two lie on the ground along x, the third across both.
    let mut q = placed(&[[0.0, -0.1, 0.05], [0.0, 0.1, 0.05], [0.0, 0.0, 0.16]]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for (body, turn) in
        [(0, [0.0, half, 0.0, half]), (1, [0.0, half, 0.0, half]), (2, [half, 0.0, 0.0, half])]
    {
        q[7 * body + 3..7 * body + 7].copy_from_slice(&turn);
    }
    let run = run_watched(&model, &contacts, (&q, &[0.0; 18]), (1e-3, 2000), |_| true);
    assert!(run.v.iter().all(|v| v.abs() < 1e-8), "{:?}", run.v);
    assert!((run.q[16] - 0.15).abs() < 1e-6, "{}", run.q[16]);
    let carried: f64 = run.contact_forces.iter().map(|force| force[2]).sum();
    assert!((carried - 3.0 * G).abs() < 1e-6, "{carried}");
    assert!(run.contact_laws.unwrap().violation.worst() < 1e-6, "{:?}", run.contact_laws);
}

/// A free tree without gravity whose motors press its hands against each other. Momentum and angular momentum
/// are conserved, and the velocities of each step match the alternating direction method.
#[test]
fn momentum_is_conserved() {
    let mut robot = RobotDescription::new("flail");
    robot.gravity = [0.0; 3];
    let mass = |k: f64| MassProperties::new(k, Vector3::zeros(), Matrix3::identity() * 0.01).unwrap();
    robot.links.push(LinkDescription::new("trunk", mass(2.0)));
    robot.base = robot_dynamics::description::Base::Floating;
    for (k, y) in [(0, -0.15), (1, 0.15), (2, 0.45)] {
        let (arm, hand) = (format!("arm{k}"), format!("hand{k}"));
        let axis = |axis: [f64; 3]| JointKind::Revolute { axis };
        robot.links.push(LinkDescription::new(&arm, mass(0.5)));
        robot.links.push(LinkDescription::new(&hand, mass(0.3)));
        let at = [[0.2, y, 0.0], [0.4, 0.0, 0.0]].map(Pose::from_translation);
        robot.joints.push(JointDescription::new(
            format!("shoulder{k}"),
            axis([0.0, 0.0, 1.0]),
            "trunk",
            &arm,
            at[0],
        ));
        robot.joints.push(JointDescription::new(
            format!("wrist{k}"),
            axis([0.0, 1.0, 0.0]),
            &arm,
            &hand,
            at[1],
        ));
        let ball = Shape::Sphere { radius: 0.1 };
        robot.shapes.push(LinkShape::new(
            &hand,
            ShapeRole::Collision,
            Pose::from_translation([0.1, 0.0, 0.0]),
            ball,
        ));
        let rod = Shape::Capsule { radius: 0.03, length: 0.2 };
        robot.shapes.push(LinkShape::new(
            &hand,
            ShapeRole::Collision,
            Pose::from_translation([0.1, 0.0, 0.2]),
            rod,
        ));
    }
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::new(&model, &[]).unwrap().with_links(&model);
    assert_eq!(contacts.pairs().count(), 12, "{:?}", contacts.left_out_pairs());
    let mut implicit = stepper(implicit_on(&model, contacts));
    let (mut workspace, mut dynamics) = (StepWorkspace::new(&model), Workspace::new(&model));
    let mut q = robot_dynamics::model::neutral(&model);
    let mut v = vec![0.0; model.nv()];
    for (k, rate) in [(6, 3.0), (8, -1.0), (10, -4.0), (7, 0.5), (3, 0.3)] {
        v[k] = rate;
    }
    // About the centre of mass: L = L_c there, which no internal force changes.
    let momentum = |q: &[f64], v: &[f64], workspace: &mut Workspace| {
        let momentum = centroidal_momentum(&model, workspace, q, v);
        [momentum.linear, momentum.angular].concat()
    };
    let before = momentum(&q, &v, &mut dynamics);
    let mut tau = [0.0; 12];
    for (joint, torque) in [("shoulder0", 0.5), ("shoulder2", -0.5)] {
        tau[model.joints().iter().find(|own| own.name == joint).unwrap().v_index] = torque;
    }
    let (mut touched, mut compared) = (0, 0);
    for step in 0..600 {
        let forces = StepForces::new(&tau, true);
        implicit.step(&model, &mut workspace, &forces, 1e-3, &mut q, &mut v).unwrap();
        let Some(problem) = implicit.contact_problem() else { continue };
        touched += 1;
        let other = admm::solve(&problem, &admm::Options::default());
        if problem.is_solved && other.is_settled {
            compared += 1;
            let off = (&problem.velocity - &other.velocity).amax();
            assert!(off < 1e-5 * problem.free_velocity.amax().max(0.1), "step {step}: {off}");
        }
    }
    assert!(touched > 50 && compared * 10 >= 9 * touched, "{compared} of {touched}");
    for (now, before) in momentum(&q, &v, &mut dynamics).iter().zip(&before) {
        // The error of the scheme, of order 2.
        assert!((now - before).abs() < 1e-3, "{now} for {before}");
    }
}

/// A ball of a ton rests on a ball of a gram on the ground, and the reverse. Both are at rest, and the forces
/// are the weights.
#[test]
fn mass_ratio_of_a_million_rests() {
    for (low, high) in [(1e-3, 1e3), (1e3, 1e-3)] {
        let model = Model::new(bodies(&[ball(low, 0.1), ball(high, 0.1)])).unwrap();
        let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap().with_links(&model);
        let q = placed(&[[0.0, 0.0, 0.1], [0.0, 0.0, 0.3]]);
        let run = run_watched(&model, &contacts, (&q, &[0.0; 12]), (1e-3, 500), |_| true);
        assert!(run.v.iter().all(|v| v.abs() < 1e-6), "{low} {high}: {:?}", run.v);
        assert!((run.q[9] - 0.3).abs() < 1e-6, "{low} {high}: {}", run.q[9]);
        let weight = (low + high) * G;
        assert!((run.contact_forces[0][2] / weight - 1.0).abs() < 1e-6, "{:?}", run.contact_forces);
    }
}

/// Balls fall into a box of five planes and come to rest in it; none escapes, none penetrates another.
#[test]
fn balls_come_to_rest_in_box() {
    let model = Model::new(with_friction(bodies(&vec![ball(1.0, 0.1); 8]), 0.3)).unwrap();
    let wall = |at: [f64; 3], normal: [f64; 3]| Ground::through(at, normal).unwrap();
    let walls = [
        Ground::level(0.0),
        wall([-0.25, 0.0, 0.0], [1.0, 0.0, 0.0]),
        wall([0.25, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        wall([0.0, -0.25, 0.0], [0.0, 1.0, 0.0]),
        wall([0.0, 0.25, 0.0], [0.0, -1.0, 0.0]),
    ];
    let contacts = ContactSet::new(&model, &walls).unwrap().with_links(&model);
    assert_eq!(contacts.pairs().count(), 28);
    let at: Vec<[f64; 3]> = (0..8)
        .map(|k| {
            let layer = f64::from(k / 4);
            let [x, y] = [k % 2, k / 2 % 2].map(|side| 0.22 * f64::from(side) - 0.11);
            [x + 0.01 * layer, y - 0.013 * layer, 0.11 + 0.23 * layer]
        })
        .collect();
    let mut deepest = 0.0_f64;
    let run = run_watched(&model, &contacts, (&placed(&at), &vec![0.0; model.nv()]), (2e-3, 600), |info| {
        let center =
            |k: usize| Vector3::new(info.q[7 * k] + 10.0 * k as f64, info.q[7 * k + 1], info.q[7 * k + 2]);
        for one in 0..8 {
            deepest =
                deepest.min(center(one).z - 0.1).min(0.15 - center(one).x.abs().max(center(one).y.abs()));
            for two in 0..one {
                deepest = deepest.min((center(one) - center(two)).norm() - 0.2);
            }
        }
        true
    });
    assert!(deepest > -1e-4, "{deepest}");
    assert!(
        run.energy_account.max_imbalance() < 0.02 * run.energy_account.scale(),
        "{:?}",
        run.energy_account
    );
    let fastest = run.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!(fastest < 2.0, "{fastest}");
}

/// Boxes, a mesh, a cylinder and a ball rest on each other, with the feature `convex`: nothing moves, and the
/// lowest body carries all. The end of the cylinder is a square whose corners rotate.
#[cfg(feature = "convex")]
#[test]
fn convex_shapes_rest_on_each_other() {
    let wedge = || (1.0, 4e-3, Shape::mesh("wedge.stl"));
    let corners = |_: &LinkShape| {
        let base = [[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
        let top = base.map(|[x, y, _]| [0.5 * x, 0.5 * y, 0.1]);
        Ok([base, top].concat())
    };
    let brick = || (1.0, 4e-3, Shape::Box { size: [0.3, 0.2, 0.1] });
    let can = || (1.0, 4e-3, Shape::Cylinder { radius: 0.08, length: 0.2 });
    // Each pile: bodies and the heights of their centres. The lowest is on the ground, the next 1 mm above
    // it.
    let piles = [
        (vec![brick(), brick(), brick()], vec![0.05, 0.151, 0.252]),
        (vec![brick(), can()], vec![0.05, 0.201]),
        (vec![can(), brick()], vec![0.1, 0.251]),
        (vec![brick(), wedge(), brick()], vec![0.05, 0.101, 0.252]),
        (vec![brick(), ball(1.0, 0.1)], vec![0.05, 0.201]),
    ];
    for (pile, (all, heights)) in piles.into_iter().enumerate() {
        let model = Model::new(bodies(&all)).unwrap();
        let contacts =
            ContactSet::with_meshes(&model, &[Ground::level(0.0)], corners).unwrap().with_links(&model);
        assert!(contacts.left_out_pairs().is_empty(), "{:?}", contacts.left_out_pairs());
        let at: Vec<[f64; 3]> = heights.iter().map(|z| [0.0, 0.0, *z]).collect();
        let rest = vec![0.0; model.nv()];
        let run = run_watched(&model, &contacts, (&placed(&at), &rest), (1e-3, 1500), |_| true);
        let has_can = pile == 1 || pile == 2;
        let (most, off_by) = if has_can { (1e-6, 1e-5) } else { (1e-12, 1e-12) };
        assert!(run.v.iter().all(|v| v.abs() < most), "pile {pile}: {:?}", run.v);
        let mut drop = 0.0;
        for (k, height) in heights.iter().enumerate() {
            let off = run.q[7 * k + 2] - (height - drop);
            assert!(off.abs() < off_by, "pile {pile}, body {k}: {off}");
            drop += 1e-3;
        }
        let carried: f64 = run.contact_forces.iter().map(|force| force[2]).sum();
        let weight = all.len() as f64 * G;
        assert!((carried - weight).abs() < if has_can { 1e-3 } else { 1e-9 }, "pile {pile}: {carried}");
    }
}

/// Bricks are thrown onto each other with rotation. None enters the ground or flies off, and dissipation
/// never decreases. The energy account has a gap where a normal jumps from face to face, 13 % of the energy
/// here (docs/explanation/contact.md). A larger gap would have another cause.
#[cfg(feature = "convex")]
#[test]
fn bricks_fall_on_each_other_without_energy_gain() {
    let brick = || (1.0, 4e-3, Shape::Box { size: [0.3, 0.2, 0.1] });
    let model = Model::new(bodies(&[brick(), brick(), brick()])).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap().with_links(&model);
    let q = placed(&[[0.0, 0.0, 0.06], [0.05, 0.0, 0.3], [-0.02, 0.03, 0.6]]);
    let mut v = vec![0.0; model.nv()];
    for (k, rate) in [(9, 1.0), (10, -2.0), (16, 3.0), (17, 1.0)] {
        v[k] = rate;
    }
    let (mut lost, mut fastest) = (0.0, 0.0_f64);
    let run = run_watched(&model, &contacts, (&q, &v), (1e-3, 3000), |info| {
        assert!(info.energy_account.dissipated() >= lost);
        lost = info.energy_account.dissipated();
        fastest = info.v.iter().fold(fastest, |most, v| most.max(v.abs()));
        true
    });
    assert!(fastest < 60.0, "{fastest}");
    // The energy account has a gap where a normal jumps from face to face.
    assert!(
        run.energy_account.max_imbalance() < 0.15 * run.energy_account.scale(),
        "{:?}",
        run.energy_account
    );
    let heights: Vec<f64> = (0..3).map(|k| run.q[7 * k + 2]).collect();
    assert!(heights.iter().all(|z| *z > 0.049), "{heights:?}");
}

/// Piles that do not touch each other are solved separately: two of them move as one of them alone, to the
/// last digits. Ten balls on each other are one component whose bodies are reordered: they stay at rest, and
/// the ground carries all.
#[test]
fn distant_piles_move_as_single_pile() {
    let alone = [[0.0, 0.0, 0.12], [0.05, 0.0, 0.33]];
    let far = alone.map(|[x, y, z]| [x + 10.0, y, z]);
    let mut ends = Vec::new();
    for at in [alone.to_vec(), [alone, far].concat()] {
        let model = Model::new(bodies(&vec![ball(1.0, 0.1); at.len()])).unwrap();
        let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap().with_links(&model);
        let rest = vec![0.0; model.nv()];
        ends.push(run_watched(&model, &contacts, (&placed(&at), &rest), (1e-3, 400), |_| true).v);
    }
    for (k, v) in ends[1].iter().enumerate() {
        assert!((v - ends[0][k % 12]).abs() < 1e-9, "{k}: {v} for {}", ends[0][k % 12]);
    }
    assert!(ends[0].iter().any(|v| v.abs() > 0.1));

    let model = Model::new(bodies(&vec![ball(1.0, 0.1); 10])).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap().with_links(&model);
    let at: Vec<[f64; 3]> = (0..10).map(|k| [0.0, 0.0, 0.1 + 0.2 * f64::from(k)]).collect();
    let rest = vec![0.0; model.nv()];
    let run = run_watched(&model, &contacts, (&placed(&at), &rest), (1e-3, 100), |_| true);
    assert!(run.v.iter().all(|v| v.abs() < 1e-8), "{:?}", run.v);
    let carried: f64 = run.contact_forces.iter().map(|force| force[2]).sum();
    assert!((carried - 10.0 * G).abs() < 1e-6, "{carried}");
}

/// Each error of a pair that cannot touch names its links.
#[test]
fn invalid_pairs_are_errors() {
    let model =
        Model::new(bodies(&[ball(1.0, 0.1), (1.0, 0.1, Shape::Ellipsoid { half_axes: [0.1; 3] })])).unwrap();
    let contacts = ContactSet::new(&model, &[]).unwrap().with_links(&model);
    assert_eq!(contacts.left_out_pairs().len(), 1);
    let error = contacts.clone().with_pair(&model, ["body0", "body1"], 0.5).unwrap_err();
    assert_eq!(error.quantity, "links `body0` and `body1`");
    let error = contacts.with_pair(&model, ["body0", "body0"], f64::NAN).unwrap_err();
    assert_eq!(error.quantity, "a coefficient of friction");
}
