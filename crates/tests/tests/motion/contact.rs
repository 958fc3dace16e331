//! Contact with the ground against closed forms and laws: sticking, sliding, rolling, bouncing, resting, and
//! random robots that fall.

use std::f64::consts::FRAC_PI_6;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::Vector3;
use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::description::{
    Base, JointKinds, LinkShape, Pose, RandomRobotOptions, RobotDescription, Shape, ShapeRole, Surface,
    pendulum, random_robot,
};
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    IntegratorError, Run, RunOptions, StepForces, StepInfo, StepWorkspace, Stepper,
};
use robot_dynamics::{InputProblem, InvalidInput};

use crate::free_body::{body, implicit_on, run_on, stepper};

const G: f64 = 9.81;

fn brick() -> RobotDescription {
    body(2e-3, Shape::Box { size: [0.2, 0.2, 0.1] })
}

fn run_watched(
    robot: &RobotDescription,
    ground: Ground,
    state: (&[f64], &[f64]),
    steps: (f64, usize),
    watch: impl FnMut(&StepInfo<'_>),
) -> Run {
    let model = Model::new(robot.clone()).unwrap();
    let contacts = ContactSet::new(&model, &[ground]).unwrap();
    run_on(&model, contacts, state, steps, watch)
}

fn run(robot: &RobotDescription, ground: Ground, state: (&[f64], &[f64]), steps: (f64, usize)) -> Run {
    run_watched(robot, ground, state, steps, |_| {})
}

/// A pose at a height above a slope that rises along x by this angle.
fn on_slope(angle: f64, height: f64) -> [f64; 7] {
    let (sin, cos) = (-0.5 * angle).sin_cos();
    [-height * angle.sin(), 0.0, height * angle.cos(), 0.0, sin, 0.0, cos]
}

/// Below the friction angle a block sticks, to rounding; above it slides with g(sin − μ cos).
#[test]
fn block_on_slope_sticks_and_slides() {
    let angle: f64 = 0.4;
    for friction in [angle.tan() + 0.01, 2.0] {
        let ground = Ground::slope(angle).unwrap().with_friction(friction);
        let run = run(&brick(), ground, (&on_slope(angle, 0.05), &[0.0; 6]), (1e-3, 2000));
        assert!(run.v.iter().all(|v| v.abs() < 1e-12), "{:?}", run.v);
        let moved = run.q.iter().zip(on_slope(angle, 0.05)).map(|(q, q0)| (q - q0).abs()).fold(0.0, f64::max);
        assert!(moved < 1e-12, "{moved}");
        let [x, y, z] = run.contact_forces[0];
        assert!(x.abs() < 1e-9 && y.abs() < 1e-9 && (z - G).abs() < 1e-9, "{x} {y} {z}");
    }
    for friction in [0.0, 0.1, 0.3] {
        let ground = Ground::slope(angle).unwrap().with_friction(friction);
        let run = run(&brick(), ground, (&on_slope(angle, 0.05), &[0.0; 6]), (1e-3, 1000));
        let expected = -G * (angle.sin() - friction * angle.cos()); // downhill, along the block's x axis
        assert!((run.v[0] - expected).abs() < 1e-9, "{} for {expected}", run.v[0]);
        assert!(run.v[1..].iter().all(|v| v.abs() < 1e-9), "{:?}", run.v);
    }
}

/// A ball that slides at v₀ rolls from t = 2v₀/(7μg) on, with 5v₀/7. This is Coulomb's law; with the cone
/// alone bodies would rise.
#[test]
fn ball_slides_and_then_rolls() {
    let (radius, friction, speed) = (0.1, 0.3, 2.0);
    let ball = body(0.4 * radius * radius, Shape::Sphere { radius });
    let state = ([0.0, 0.0, radius, 0.0, 0.0, 0.0, 1.0], [speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let ground = Ground::level(0.0).with_friction(friction);
    let rolls_at = 2.0 * speed / (7.0 * friction * G);
    let mut highest = 0.0_f64;
    let run = run_watched(&ball, ground, (&state.0, &state.1), (1e-3, 800), |info| {
        highest = highest.max((info.q[2] - radius).abs());
        let along = (info.q[0], info.time);
        if info.time > rolls_at + 2e-3 {
            // v is in the axes of the ball, which turn.
            let (linear, spin) = (Vector3::from_row_slice(&info.v[..3]).norm(), info.v[4]);
            assert!((linear - 5.0 / 7.0 * speed).abs() < 3e-4, "{linear} at {along:?}");
            assert!((spin * radius - linear).abs() < 1e-9, "{spin}");
        }
    });
    // The error per step is h³ω²v/12, and it decays with a time constant of 0.1 s.
    assert!(highest < 1e-5, "{highest}");
    let slid = 12.0 / 49.0 * speed * speed / (friction * G);
    let rolled = 5.0 / 7.0 * speed * (0.8 - rolls_at);
    assert!((run.q[0] - slid - rolled).abs() < 5e-4, "{} for {}", run.q[0], slid + rolled);
    let losses = run.losses.unwrap();
    let lost = 0.5 * speed * speed * 2.0 / 7.0;
    assert!((losses.sliding - lost).abs() < 1e-3 * lost && losses.impacts.abs() < 1e-4, "{losses:?}");
}

/// A ball rolls down a slope with 5/7 g sin α as long as μ is at least 2/7 tan α. This holds to rounding, as
/// a step conserves momentum. Rolling loses only the error of the step, which lifts the ball by up to 0.4 µm
/// at 2 ms. The lift decays with a time constant of 0.1 s, 1e-5 J of 8.6 J.
#[test]
fn ball_rolls_down_slope() {
    let radius = 0.1;
    let ball = body(0.4 * radius * radius, Shape::Sphere { radius });
    let ground = Ground::slope(FRAC_PI_6).unwrap().with_friction(2.0 / 7.0 * FRAC_PI_6.tan() + 0.02);
    for steps in [(2e-3, 500), (1e-3, 1000)] {
        let run = run(&ball, ground, (&on_slope(FRAC_PI_6, radius), &[0.0; 6]), steps);
        let speed = Vector3::from_row_slice(&run.v[..3]).norm();
        assert!((speed - radius * run.v[4].abs()).abs() < 1e-9);
        let losses = run.losses.unwrap();
        assert!(losses.sliding.abs() < 1e-9 && losses.impacts.abs() < 2e-5, "{losses:?}");
        assert!((speed - 5.0 / 7.0 * G * FRAC_PI_6.sin()).abs() < 1e-12, "{speed}");
    }
}

/// Each bounce keeps e of the speed, so that the heights are h, e²h, e⁴h. Without restitution the ball does
/// not bounce.
#[test]
fn ball_bounces_by_restitution() {
    let (radius, restitution, height) = (0.1, 0.8, 0.5);
    let ball = body(0.4 * radius * radius, Shape::Sphere { radius });
    let state = ([0.0, 0.0, radius + height, 0.0, 0.0, 0.0, 1.0], [0.0; 6]);
    let ground = Ground::level(0.0).with_restitution(restitution);
    let (mut peaks, mut last) = (Vec::new(), [f64::INFINITY; 2]);
    run_watched(&ball, ground, (&state.0, &state.1), (1e-3, 1500), |info| {
        let z = info.q[2] - radius;
        if last[0] <= last[1] && last[1] > z && last[1].is_finite() {
            peaks.push(last[1]);
        }
        last = [last[1], z];
    });
    assert!(peaks.len() >= 2, "{peaks:?}");
    for (bounces, peak) in (1..=2).zip(&peaks) {
        let expected = height * restitution.powi(2 * bounces);
        assert!((peak / expected - 1.0).abs() < 2e-3, "{peak} for {expected}");
    }
    let dead = run(&ball, Ground::level(0.0), (&state.0, &state.1), (1e-3, 600));
    assert!((dead.q[2] - radius).abs() < 1e-12 && dead.v.iter().all(|v| v.abs() < 1e-12));
    let lost = dead.losses.unwrap().impacts;
    assert!((lost - G * height).abs() < 2e-3 * G * height, "{lost}");
}

/// A spinning ball with torsional friction stops after Iω/(μ_t N); without torsional friction it never stops.
#[test]
fn torsional_friction_stops_spin() {
    let (radius, spin, torsion) = (0.1, 5.0, 0.01);
    for condim in [3, 4] {
        let mut ball = body(0.4 * radius * radius, Shape::Sphere { radius });
        let mut surface = Surface::default();
        (surface.condim, surface.friction) = (condim, [0.8, torsion, 0.0]);
        ball.shapes[0].surface = surface;
        let state = ([0.0, 0.0, radius, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0, 0.0, spin]);
        let stops_at = 0.4 * radius * radius * spin / (torsion * G);
        let steps = 100;
        assert!((0.1..stops_at).contains(&0.1));
        let half_way = run(&ball, Ground::level(0.0), (&state.0, &state.1), (1e-3, steps));
        let expected = if condim == 3 { spin } else { spin * (1.0 - 0.1 / stops_at) };
        assert!((half_way.v[5] - expected).abs() < 1e-9, "{} for {expected}", half_way.v[5]);
        let later = run(&ball, Ground::level(0.0), (&state.0, &state.1), (1e-3, 400));
        let expected = if condim == 3 { spin } else { 0.0 };
        assert!((later.v[5] - expected).abs() < 1e-9, "{} for {expected}", later.v[5]);
    }
}

/// A resting ball is carried in every step. It remains in contact even if rounding separates its bounding
/// sphere, but not its lowest point, from the ground.
#[test]
fn resting_ball_is_carried_in_every_step() {
    for radius in [0.03, 0.07, 0.1, 0.11, 0.13, 0.17, 0.3] {
        let mut ball = body(0.4 * radius * radius, Shape::Sphere { radius });
        let mut surface = Surface::default();
        // Rolling friction holds it on a slope as long as its coefficient is above R tan α.
        (surface.condim, surface.friction) = (6, [2.0, 0.1, radius]);
        ball.shapes[0].surface = surface;
        for k in 0..10 {
            let (angle, height) = (0.03 * f64::from(k), 0.1 + 0.37 * f64::from(k));
            let level = (Ground::level(height), [0.0, 0.0, height + radius, 0.0, 0.0, 0.0, 1.0]);
            for (ground, q) in [level, (Ground::slope(angle).unwrap(), on_slope(angle, radius))] {
                let run = run_watched(&ball, ground, (&q, &[0.0; 6]), (1e-3, 200), |info| {
                    let force = Vector3::from(info.contact_forces[0]);
                    let (normal, step) = (Vector3::from(ground.normal), info.step);
                    // The force is accurate to 1e-11 of the weight; in a step without contact it would be 0.
                    let off = normal.dot(&force) - G * normal.z;
                    assert!(off.abs() < 1e-9 || step == 0, "R {radius}, {ground:?}, step {step}: {force:?}");
                });
                assert!(run.v.iter().all(|v| v.abs() < 1e-12), "R {radius}, {ground:?}: {:?}", run.v);
            }
        }
    }
}

/// Every shape comes to rest or rolls on its surface, whatever its orientation, and the energy account holds
/// the loss.
#[test]
fn shapes_fall_and_come_to_rest() {
    let shapes = [
        (Shape::Box { size: [0.3, 0.2, 0.1] }, true),
        (Shape::Capsule { radius: 0.05, length: 0.2 }, false),
        (Shape::Cylinder { radius: 0.1, length: 0.15 }, false),
        (Shape::Ellipsoid { half_axes: [0.1, 0.12, 0.2] }, false),
    ];
    for (shape, rests) in shapes {
        let robot = body(4e-3, shape.clone());
        let model = Model::new(robot.clone()).unwrap();
        let contacts = ContactSet::new(&model, &[Ground::level(0.1)]).unwrap();
        let mut workspace = Workspace::new(&model);
        for seed in 0..3 {
            let mut random = SplitMix64::new(seed);
            let mut q = [0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 1.0];
            (3..7).for_each(|k| q[k] = random.uniform(-1.0, 1.0));
            let norm = q[3..].iter().map(|q| q * q).sum::<f64>().sqrt();
            q[3..].iter_mut().for_each(|q| *q /= norm);
            let v: [f64; 6] = std::array::from_fn(|_| random.uniform(-2.0, 2.0));
            let (mut deepest, mut lost) = (0.0_f64, 0.0);
            let run = run_watched(&robot, Ground::level(0.1), (&q, &v), (1e-3, 4000), |info| {
                let gap = contacts.clearance(&model, &mut workspace, info.q).unwrap();
                deepest = deepest.min(gap);
                let dissipated = info.energy_account.dissipated();
                assert!(dissipated >= lost, "{shape:?} {seed}: {dissipated} after {lost}");
                lost = dissipated;
            });
            assert!(deepest > -1e-6, "{shape:?} {seed}: {deepest} below the ground");
            let gap = contacts.clearance(&model, &mut workspace, &run.q).unwrap();
            assert!(gap < 1e-6, "{shape:?} {seed}: {gap} above the ground");
            assert!(
                run.energy_account.max_imbalance() < 0.02 * run.energy_account.scale(),
                "{shape:?} {seed}: {:?}",
                run.energy_account
            );
            if rests {
                assert!(run.v.iter().all(|v| v.abs() < 1e-9), "{shape:?} {seed}: {:?}", run.v);
                let force = run.contact_forces[0];
                assert!((force[2] - G).abs() < 1e-6, "{force:?}");
            }
        }
    }
}

/// Random robots fall with shapes on every link: none penetrates the ground or gains energy, dissipation
/// never decreases, and the energy account closes.
#[test]
fn random_robots_fall_without_energy_gain() {
    for seed in 0..6 {
        let mut random = SplitMix64::new(seed);
        let options = RandomRobotOptions {
            joints: 5,
            kinds: JointKinds::All,
            base: Base::Floating,
            ..Default::default()
        };
        let mut robot = random_robot(seed, &options);
        for joint in &mut robot.joints {
            joint.passive = joint.passive.with_damping(0.05);
        }
        let links: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
        for link in links {
            let at = Pose::from_translation(std::array::from_fn(|_| random.uniform(-0.1, 0.1)));
            let shape = match random.next_u64() % 3 {
                0 => Shape::Sphere { radius: 0.1 },
                1 => Shape::Box { size: [0.2, 0.15, 0.1] },
                _ => Shape::Capsule { radius: 0.05, length: 0.2 },
            };
            robot.shapes.push(LinkShape::new(link, ShapeRole::Collision, at, shape));
        }
        let model = Model::new(robot.clone()).unwrap();
        let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap();
        let mut workspace = Workspace::new(&model);
        let mut q = neutral(&model);
        q[2] += 0.2 - contacts.clearance(&model, &mut workspace, &q).unwrap();
        let mut deepest = 0.0_f64;
        let run =
            run_watched(&robot, Ground::level(0.0), (&q, &vec![0.0; model.nv()]), (1e-3, 1500), |info| {
                deepest = deepest.min(contacts.clearance(&model, &mut workspace, info.q).unwrap());
            });
        assert!(deepest > -1e-4, "seed {seed}: {deepest}");
        assert!(
            run.energy_account.max_imbalance() < 0.05 * run.energy_account.scale(),
            "seed {seed}: {:?}",
            run.energy_account
        );
    }
}

/// A body that starts inside the ground comes out slowly and does not jump.
#[test]
fn body_in_ground_comes_out_slowly() {
    let q = [0.0, 0.0, 0.03, 0.0, 0.0, 0.0, 1.0]; // 2 cm deep
    let mut fastest = 0.0_f64;
    let run = run_watched(&brick(), Ground::level(0.0), (&q, &[0.0; 6]), (1e-3, 1000), |info| {
        fastest = fastest.max(info.v[2]);
    });
    let left = 0.05 - run.q[2];
    assert!((left - 0.02 * (-10.0_f64).exp()).abs() < 1e-9, "{left}");
    assert!(fastest < 1e-9, "{fastest}");
}

/// Each error of an invalid ground names its quantity.
#[test]
fn invalid_grounds_are_errors() {
    let model = Model::new(brick()).unwrap();
    let level = Ground::level(0.0);
    let out_of_range =
        |quantity, value, unit, requirement| InvalidInput::out_of_range(quantity, value, unit, requirement);
    let slope = out_of_range("a slope", 1.6, "rad", "between -π/2 and π/2, both excluded");
    assert_eq!(Ground::slope(1.6), Err(slope));
    let error = Ground::through([0.0; 3], [0.0; 3]).unwrap_err();
    assert!(error.quantity.starts_with("a ground's normal"), "{error}");
    let refused = |ground: Ground| ContactSet::new(&model, &[ground]).unwrap_err();
    assert_eq!(
        refused(level.with_friction(-1.0)),
        out_of_range("a coefficient of friction", -1.0, "", "finite and not negative")
    );
    let error = refused(level.with_friction(f64::NAN));
    assert_eq!(error.quantity, "a coefficient of friction");
    assert!(matches!(error.problem, InputProblem::OutOfRange { value, .. } if value.is_nan()), "{error}");
    assert_eq!(
        refused(level.with_restitution(1.5)),
        out_of_range("a coefficient of restitution", 1.5, "", "between 0 and 1")
    );
    let error = refused(Ground::level(f64::INFINITY));
    assert!(error.quantity.starts_with("a ground's normal"), "{error}");
}

/// A rod with its hinge below the ground: the end at the hinge stays, the other end rises onto the ground and
/// rests there.
#[test]
fn fixed_points_stay_below_ground() {
    let mut robot = pendulum(2.0, 0.5);
    let along = Pose::from_xyz_rpy([0.25, 0.0, 0.0], [0.0, 3.0 * FRAC_PI_6, 0.0]);
    let shape = Shape::Capsule { radius: 0.02, length: 0.5 };
    robot.shapes.push(LinkShape::new("rod", ShapeRole::Collision, along, shape));
    let model = Model::new(robot).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap();
    let run = run_on(&model, contacts, (&[-1.0], &[0.0]), (1e-3, 3000), |_| {});
    assert!((0.5 * run.q[0].sin() + 0.02).abs() < 1e-9 && run.v[0].abs() < 1e-9, "{:?} {:?}", run.q, run.v);
    let lost = 2.0 * G * (0.5 * 1.0_f64.sin() - 0.02);
    let impacts = run.losses.unwrap().impacts;
    // An impact is early or late by h/16.
    assert!((impacts - lost).abs() < 1e-3 * lost, "{impacts} for {lost}");
}

/// An interrupted step leaves q, v and the forces of the previous step unchanged and can be repeated. The
/// motion of a brick that slides and turns over is equal bit for bit.
#[test]
fn interrupted_step_can_be_repeated() {
    let model = Model::new(brick()).unwrap();
    let contacts = || ContactSet::new(&model, &[Ground::level(0.0).with_friction(0.3)]).unwrap();
    let flag = Arc::new(AtomicBool::new(false));
    let interrupted = implicit_on(&model, contacts()).interrupt(Arc::clone(&flag));
    let mut steppers = [implicit_on(&model, contacts()), interrupted].map(stepper);
    let start = (vec![0.0, 0.0, 0.07, 0.0, 0.0, 0.0, 1.0], vec![0.5, 0.1, 0.0, 1.0, 2.0, 0.0]);
    let (mut states, mut workspace) = ([start.clone(), start], StepWorkspace::new(&model));
    let none = StepForces::new(&[0.0; 6], true);
    let mut touched = 0;
    for step in 0..400 {
        let [(q, v), (other_q, other_v)] = &mut states;
        steppers[0].step(&model, &mut workspace, &none, 1e-3, q, v).unwrap();
        if step % 3 == 0 {
            let (before, forces) =
                ((other_q.clone(), other_v.clone()), steppers[1].contact_forces().to_vec());
            flag.store(true, Ordering::Relaxed);
            let stopped = steppers[1].step(&model, &mut workspace, &none, 1e-3, other_q, other_v);
            flag.store(false, Ordering::Relaxed);
            assert_eq!(stopped, Err(IntegratorError::Interrupted.into()));
            assert_eq!((&before.0, &before.1), (&*other_q, &*other_v));
            assert_eq!(forces, steppers[1].contact_forces());
        }
        steppers[1].step(&model, &mut workspace, &none, 1e-3, other_q, other_v).unwrap();
        touched += usize::from(!steppers[0].contacts().is_empty());
        assert_eq!(states[0], states[1], "step {step}");
    }
    assert!(touched > 200, "{touched}");
}

/// A flag that is set during a run ends it without an error, and the last sample is the state of the run.
#[test]
fn flag_ends_run() {
    let model = Model::new(brick()).unwrap();
    let contacts = ContactSet::new(&model, &[Ground::level(0.0)]).unwrap();
    let flag = Arc::new(AtomicBool::new(false));
    let mut simulation = implicit_on(&model, contacts).interrupt(Arc::clone(&flag)).build().unwrap();
    let q = [0.0, 0.0, 0.06, 0.0, 0.0, 0.0, 1.0];
    let run = simulation
        .run_steps_from(
            &q,
            &[0.0; 6],
            100,
            RunOptions::new().sample_ends().observer(&mut |info| {
                flag.store(info.step == 30, Ordering::Relaxed);
                ControlFlow::Continue(())
            }),
        )
        .unwrap();
    assert!(run.interrupted && run.steps == 30 && run.time == 0.03);
    let last = run.trajectory.sample(run.trajectory.len() - 1);
    assert_eq!((last.time, last.q), (0.03, &run.q[..]));
}
