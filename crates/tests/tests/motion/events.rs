//! Events of runs with fixed steps: times against closed forms, directions, ends, errors.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::constraints::{ConstraintOptions, ConstraintSet, Coupling, DriftCorrection};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, LinkDescription, MassProperties, PassiveForces, Pose, RobotDescription,
};
use robot_dynamics::model::{Model, difference, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Event, Integrator, Method, Run, RunError, RunOptions, Simulation, SimulationBuilder, StepForces,
    StepInfo, StepWorkspace, step,
};

use crate::common::{damped_tree, max_difference};

/// An observer that ends the run at a step.
fn until(end: f64) -> impl Fn(&StepInfo<'_>) -> ControlFlow<()> {
    move |info| if info.time < end { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}

fn simulation(model: &Model, integrator: Integrator, step: f64) -> Simulation {
    SimulationBuilder::new(model).method(Method::Fixed(integrator)).dt(step).build().unwrap()
}

fn brick() -> Model {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    robot.links.push(LinkDescription::new("brick", brick));
    Model::new(robot).unwrap()
}

fn one_joint(kind: JointKind, bob: MassProperties, damping: f64) -> Model {
    let mut robot = RobotDescription::new("one joint");
    robot.links.push(LinkDescription::new("ceiling", None));
    robot.links.push(LinkDescription::new("body", bob));
    let joint = JointDescription::new("joint", kind, "ceiling", "body", Pose::IDENTITY);
    let passive = PassiveForces::default().with_damping(damping);
    robot.joints.push(joint.with_passive(passive));
    Model::new(robot).unwrap()
}

/// 1 kg on a rod of 1 m along x, turning about y: q̈ = g cos q, hanging at π/2.
fn pendulum() -> Model {
    let bob = MassProperties::new(1.0, Vector3::new(1.0, 0.0, 0.0), Matrix3::zeros()).unwrap();
    one_joint(JointKind::Revolute { axis: [0.0, 1.0, 0.0] }, bob, 0.0)
}

/// 1 kg on a vertical rail with a damper of 2 N·s/m, and its z(t), v(t) from (1 m, 3 m/s).
fn damped_fall() -> (Model, impl Fn(f64) -> (f64, f64)) {
    let bob = MassProperties::new(1.0, Vector3::zeros(), Matrix3::zeros()).unwrap();
    let model = one_joint(JointKind::Prismatic { axis: [0.0, 0.0, 1.0] }, bob, 2.0);
    let (rate, terminal) = (2.0, 9.81 / 2.0);
    let motion = move |t: f64| {
        let (fading, v) = ((-rate * t).exp(), 3.0 + terminal);
        (1.0 + v * (1.0 - fading) / rate - terminal * t, v * fading - terminal)
    };
    (model, motion)
}

/// Top and floor of a damped fall with each method. The top is an event of v inside a step, accurate to the
/// order of the method or to order 3. The floor ends the run by a shortened step, accurate to the order of
/// the method. A fifth of an order is allowed for the next term of the series. Where a method is limited by
/// rounding, the tolerance is 1e-12.
#[test]
fn event_times_have_order_of_method() {
    let (model, motion) = damped_fall();
    let top = 0.5 * ((3.0 + 4.905) / 4.905f64).ln();
    let mut floor: f64 = 1.0;
    for _ in 0..50 {
        let (z, v) = motion(floor);
        floor -= z / v;
    }
    for row in Integrator::ALL {
        // The relative position of the top in its step is fixed, as the error of the polynomial is
        // proportional to a function of it.
        let run = |count: f64| -> [f64; 3] {
            let h = top / (count + 0.3);
            let mut events = [
                Event::new("top", |_, _: &[f64], v: &[f64]| v[0]).falling(),
                Event::new("floor", |_, q: &[f64], _: &[f64]| q[0]).falling().terminal(),
            ];
            let run = simulation(&model, row, h)
                .run_steps_from(&[1.0], &[3.0], 10_000, RunOptions::new().sample_ends().events(&mut events))
                .unwrap();
            assert_eq!((run.events.len(), run.ended_by_event, run.interrupted), (2, true, false), "{row}");
            assert_eq!((run.time, &run.q, &run.v), (run.events[1].time, &run.events[1].q, &run.events[1].v));
            // Newton's step leaves the square of the error that it found; the polynomial of a first-order
            // method is as inaccurate as the method.
            let left = if row.order() == 1 { 1e-4 } else { 1e-9 };
            assert!(run.q[0].abs() < left, "{row}: {} m above the floor", run.q[0]);
            [run.events[0].time - top, run.time - floor, run.v[0] - motion(floor).1]
        };
        let (coarse, fine) = (run(17.0), run(34.0));
        for (what, k, order) in
            [("top", 0, row.order().min(3)), ("floor", 1, row.order()), ("speed", 2, row.order())]
        {
            let found = (coarse[k] / fine[k]).abs().ln() / (34.3f64 / 17.3).ln();
            println!("{row} {what}: off by {:.1e}, {:.1e}, order {found:.2}", coarse[k], fine[k]);
            assert!(
                found > f64::from(order) - 0.2 || fine[k].abs() < 1e-12,
                "{row} {what}: {coarse:?} {fine:?}"
            );
        }
    }
}

/// A brick in free fall: q is a parabola, which the polynomial of the step and Runge–Kutta represent exactly.
/// Each run ends at a bounce and the next one throws the brick up again. The bounces agree with the closed
/// form to the rounding of some hundred steps.
#[test]
fn brick_bounces_at_times_of_closed_form() {
    let model = brick();
    let (mut q, mut v) = (neutral(&model), vec![0.0, 0.0, 0.0, 0.0, 0.0, 2.0]);
    q[2] = 0.7;
    let frame = model.frame("brick").unwrap();
    let mut fall = (2.0 * 0.7 / 9.81f64).sqrt();
    for bounce in 0..4 {
        let mut floor = [Event::touchdown("floor", &model, frame, 0.0).terminal()];
        let run = simulation(&model, Integrator::RungeKutta4, 0.01)
            .run_steps_from(&q, &v, 1000, RunOptions::new().sample_ends().events(&mut floor))
            .unwrap();
        let expected = if bounce == 0 { fall } else { 2.0 * fall };
        assert!((run.time - expected).abs() < 1e-12, "bounce {bounce}: {} {expected}", run.time);
        assert!(run.q[2].abs() < 1e-13 && (run.v[2] + 9.81 * fall).abs() < 1e-11, "bounce {bounce}: {run:?}");
        // Each bounce loses a fifth of the speed.
        (q, v) = (run.q, run.v);
        v[2] *= -0.8;
        fall *= 0.8;
    }
}

/// The end of a run at a terminal event is one step of the method from the end of the previous step, bit for
/// bit. The energy account and the samples count it as one step.
#[test]
fn terminal_event_ends_with_one_step() {
    let model = damped_tree(3);
    let state = random_state(&model, &mut SplitMix64::new(3));
    for row in Integrator::ALL {
        let mut simulation = simulation(&model, row, 2e-3);
        let mut turned = [Event::new("turned", |t, _: &[f64], _: &[f64]| t - 0.0313).terminal()];
        let run = simulation
            .run_steps_from(&state.q, &state.v, 100, RunOptions::new().events(&mut turned))
            .unwrap();
        // The bracket has a width of 4 ulp of time.
        assert!((run.time - 0.0313).abs() < 1e-16 && run.steps == 16, "{row}: {} {}", run.time, run.steps);
        let samples: Vec<_> = run.trajectory.iter().collect();
        assert_eq!((samples.len(), samples[16].time), (17, run.time));
        let (mut q, mut v) = (samples[15].q.to_vec(), samples[15].v.to_vec());
        let tau = vec![0.0; model.nv()];
        let forces = StepForces::new(&tau, true);
        let mut workspace = StepWorkspace::new(&model);
        let h = run.time - 15.0 * 2e-3;
        step(&model, row, &mut workspace, &forces, h, &mut q, &mut v).unwrap();
        // The length of the step is known to the rounding of the time.
        let off = max_difference(&q, &run.q).max(max_difference(&v, &run.v));
        assert!(off < 1e-13, "{row}: {off:e}");
        let imbalance = run.energy_account.max_imbalance() / run.energy_account.scale();
        assert!(imbalance < 1e-2, "{row}: the energy account is off by {imbalance:e}");
    }
}

/// The run ends at the event however close it is to the start or the end of a step, with every method.
#[test]
fn terminal_event_may_be_anywhere_in_step() {
    let model = damped_tree(2);
    let state = random_state(&model, &mut SplitMix64::new(2));
    for row in Integrator::ALL {
        for part in [0.0, 1e-15, 1e-11, 1e-6, 0.5, 1.0 - 1e-11, 1.0] {
            let when = 1e-3 * (3.0 + part);
            let mut events = [Event::new("when", |t, _: &[f64], _: &[f64]| t - when).terminal()];
            let run = simulation(&model, row, 1e-3)
                .run_steps_from(&state.q, &state.v, 100, RunOptions::new().sample_ends().events(&mut events))
                .unwrap_or_else(|failure| panic!("{row} {part}: {failure}"));
            // A billionth of the step is the shortest distance.
            assert!(run.ended_by_event && (run.time - when).abs() < 1.1e-12, "{row} {part}: {}", run.time);
        }
    }
}

/// A pendulum that swings over ±1 rad about hanging: directions, order of crossings, and the state at each.
#[test]
fn directions_apply_and_times_ascend() {
    let model = pendulum();
    let mut events = [
        Event::new("both", |_, q: &[f64], _: &[f64]| q[0] - FRAC_PI_2),
        Event::new("rising", |_, q: &[f64], _: &[f64]| q[0] - FRAC_PI_2).rising(),
        Event::new("falling", |_, q: &[f64], _: &[f64]| q[0] - FRAC_PI_2).falling(),
        Event::new("turn", |_, _: &[f64], v: &[f64]| v[0]),
    ];
    let run = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_steps_from(&[FRAC_PI_2 - 1.0], &[0.0], 300, RunOptions::new().sample_ends().events(&mut events))
        .unwrap();
    let names: Vec<&str> = run.events.iter().map(|event| event.name.as_str()).collect();
    // From the left end, where v = 0 at the start is not an event.
    let (up, down) = (["both", "rising", "turn"], ["both", "falling", "turn"]);
    assert_eq!(names, [up, down].concat().repeat(2)[..names.len()], "{names:?}");
    assert!(names.len() >= 8 && !run.ended_by_event && run.steps == 300);
    for pair in run.events.windows(2) {
        assert!(pair[0].time <= pair[1].time, "{pair:?}");
    }
    for event in &run.events {
        let expected_rising = event.v[0] > 0.0;
        match event.name.as_str() {
            "turn" => assert!(event.v[0].abs() < 1e-12, "{event:?}"),
            _ => assert!((event.q[0] - FRAC_PI_2).abs() < 1e-12 && event.rising == expected_rising),
        }
    }
}

/// Two events in one step are reported in order of time, whatever their order in the list; events after a
/// terminal one are not reported.
#[test]
fn two_events_in_one_step_are_in_order() {
    let model = brick();
    let mut v = vec![0.0; 6];
    v[2] = -1.0;
    let run = |ends: bool| -> Run {
        let at = |name: &str, z: f64| Event::new(name, move |_, q: &[f64], _: &[f64]| q[2] - z);
        let middle = at("middle", -0.05);
        let mut events = [at("low", -0.08), if ends { middle.terminal() } else { middle }, at("high", -0.02)];
        simulation(&model, Integrator::RungeKutta4, 0.2)
            .run_steps_from(&neutral(&model), &v, 1, RunOptions::new().sample_ends().events(&mut events))
            .unwrap()
    };
    // z = −t − ½ g t².
    let time = |z: f64| ((1.0f64 - 2.0 * 9.81 * z).sqrt() - 1.0) / 9.81;
    for (ends, expected) in
        [(false, vec![(2, -0.02), (1, -0.05), (0, -0.08)]), (true, vec![(2, -0.02), (1, -0.05)])]
    {
        let run = run(ends);
        assert_eq!(run.events.len(), expected.len());
        assert_eq!((run.ended_by_event, run.steps), (ends, 1));
        for (found, (event, z)) in run.events.iter().zip(expected) {
            assert_eq!(found.event, event);
            // The cubic represents the parabola exactly.
            assert!((found.time - time(z)).abs() < 1e-14 && (found.q[2] - z).abs() < 1e-14, "{found:?}");
        }
        let end = if ends { time(-0.05) } else { 0.2 };
        assert!((run.time - end).abs() < 1e-14);
    }
}

/// An error or a NaN of an event's function ends the run with the time and the name; the steps before it are
/// kept.
#[test]
fn failing_event_function_ends_run() {
    let model = brick();
    let (q, v) = (neutral(&model), vec![0.0; 6]);
    let mut simulation = simulation(&model, Integrator::RungeKutta4, 0.01);
    let fails = |t: f64, _: &[f64], _: &[f64]| if t < 0.1049 { Ok(1.0) } else { Err("the camera is blind") };
    let mut events = [Event::new("seen", fails)];
    let failure = simulation
        .run_steps_from(&q, &v, 100, RunOptions::new().sample_ends().events(&mut events))
        .unwrap_err();
    let RunError::Event { name, time, source } = &failure.error else { panic!("{failure}") };
    assert_eq!((name.as_str(), source.to_string().as_str()), ("seen", "the camera is blind"));
    assert!((0.1049..0.1063).contains(time), "the first of eight looks after it: {time}");
    assert_eq!((failure.until.steps, failure.until.time), (10, 0.1));
    assert!((failure.until.q[2] + 0.5 * 9.81 * 0.01).abs() < 1e-14);

    let mut events = [Event::new("depth", |_, q: &[f64], _: &[f64]| (q[2] + 0.1).sqrt())];
    let failure = simulation
        .run_steps_from(&q, &v, 100, RunOptions::new().sample_ends().events(&mut events))
        .unwrap_err();
    let RunError::EventNotFinite { name, value, .. } = &failure.error else { panic!("{failure}") };
    assert!(name == "depth" && value.is_nan() && failure.until.steps == 14, "{failure}");

    // The same at the start.
    let mut events = [Event::new("never", |_, _: &[f64], _: &[f64]| f64::INFINITY)];
    let failure = simulation
        .run_steps_from(&q, &v, 100, RunOptions::new().sample_ends().events(&mut events))
        .unwrap_err();
    assert!(matches!(failure.error, RunError::EventNotFinite { time: 0.0, .. }), "{failure}");
    assert_eq!((failure.until.steps, failure.until.trajectory.len()), (0, 0));
}

/// A brick that turns about its axis at 3 rad/s while it moves sideways: quarter turns at (2k + 1) π/6 s. On
/// the manifold the turn is a straight line, and the state at the event is rotated by a right angle.
#[test]
fn events_of_turning_brick_are_found_on_manifold() {
    let model = brick();
    let v = [1.0, 0.0, 0.0, 0.0, 0.0, 3.0];
    // cos of the angle about z: 1 − 2z² of the quaternion.
    let mut events = [Event::new("right angle", |_, q: &[f64], _: &[f64]| 1.0 - 2.0 * q[5] * q[5])];
    let run = simulation(&model, Integrator::RungeKutta4, 0.05)
        .run_steps_from(&neutral(&model), &v, 60, RunOptions::new().sample_ends().events(&mut events))
        .unwrap();
    assert_eq!(run.events.len(), 3);
    for (k, event) in run.events.iter().enumerate() {
        let time = (2 * k + 1) as f64 * PI / 6.0;
        assert!((event.time - time).abs() < 1e-12, "{event:?} {time}");
        let length: f64 = event.q[3..7].iter().map(|x| x * x).sum();
        // The velocity in body axes turns by ωh = 0.15 a step; the method follows it to (ωh)⁴/24 = 2e-5 a
        // radian.
        assert!((length - 1.0).abs() < 1e-14 && (event.q[0] - time).abs() < 1e-4, "{event:?}");
        let speed = event.v[0].hypot(event.v[1]);
        // v has order 3: (ωh)³/36 = 1e-4.
        assert!((speed - 1.0).abs() < 1e-4 && (event.v[5] - 3.0).abs() < 1e-12, "{event:?}");
    }
}

/// On floating trees with ball joints the time and the state of an event of q have order 4. Against steps
/// sixteen times shorter, halved steps reduce the error to a sixteenth, less half an order.
#[test]
fn states_inside_steps_have_order_four() {
    for seed in 0..4 {
        let model = damped_tree(seed);
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let far = |q: &[f64]| {
            let mut d = vec![0.0; model.nv()];
            difference(&model, &state.q, q, &mut d);
            d.iter().map(|d| d * d).sum::<f64>()
        };
        let met = |h: f64| {
            let mut events = [Event::new("far", |_, q: &[f64], _: &[f64]| far(q) - 1e-2)];
            let run = simulation(&model, Integrator::RungeKutta4, h)
                .run_steps_from(
                    &state.q,
                    &state.v,
                    usize::MAX,
                    RunOptions::new().sample_ends().events(&mut events).observer(&mut until(0.2)),
                )
                .unwrap();
            run.events[0].clone()
        };
        // The relative position in the step must stay: half of it, a quarter, ….
        let exact = met(1e-4);
        let h = exact.time / 1.5;
        let errors = [h, h / 3.0, h / 9.0].map(|h| {
            let found = met(h);
            let mut d = vec![0.0; model.nv()];
            difference(&model, &exact.q, &found.q, &mut d);
            ((found.time - exact.time).abs(), crate::common::size(&d), max_difference(&found.v, &exact.v))
        });
        println!("robot {seed}, h = {h:.1e}: {errors:?}");
        let order = |a: f64, b: f64| (a / b).ln() / 3f64.ln();
        assert!(order(errors[1].0, errors[2].0) > 3.5, "robot {seed}, time: {errors:?}");
        assert!(order(errors[1].1, errors[2].1) > 3.5, "robot {seed}, q: {errors:?}");
        assert!(order(errors[1].2, errors[2].2) > 2.5, "robot {seed}, v: {errors:?}");
    }
}

/// The crossings of a pendulum against an adaptive run with tolerance 1e-12: lowest points to order 4,
/// turning points to order 3.
#[cfg(feature = "adaptive")]
#[test]
fn crossings_match_adaptive_run() {
    let model = pendulum();
    let events = || {
        [
            Event::new("bottom", |_, q: &[f64], _: &[f64]| q[0] - FRAC_PI_2),
            Event::new("turn", |_, _: &[f64], v: &[f64]| v[0]),
        ]
    };
    let options = robot_dynamics::simulation::AdaptiveOptions {
        tolerance: 1e-12,
        ..robot_dynamics::simulation::AdaptiveOptions::default()
    };
    let exact = SimulationBuilder::new(&model)
        .without(robot_dynamics::simulation::Effect::Dissipation)
        .adaptive(options)
        .dt(5.0)
        .build()
        .unwrap()
        .run_steps_from(&[-0.5], &[0.0], 1, RunOptions::new().events(&mut events()))
        .unwrap();
    assert!(exact.events.len() >= 6);
    let worst = |h: f64| -> [f64; 2] {
        let run = simulation(&model, Integrator::RungeKutta4, h)
            .run_steps_from(
                &[-0.5],
                &[0.0],
                usize::MAX,
                RunOptions::new().sample_ends().events(&mut events()).observer(&mut until(4.999)),
            )
            .unwrap();
        assert_eq!(run.events.len(), exact.events.len());
        let mut worst = [0.0f64; 2];
        for (found, exact) in run.events.iter().zip(&exact.events) {
            assert_eq!((found.event, found.rising), (exact.event, exact.rising));
            worst[found.event] = worst[found.event].max((found.time - exact.time).abs());
        }
        worst
    };
    let (coarse, fine) = (worst(0.02), worst(0.005));
    println!("bottoms and turns off by {coarse:?}, {fine:?} s");
    // Two halvings give 2⁸ and 2⁶, less half an order each for the positions of the events in their steps.
    assert!(fine[0] < coarse[0] / 128.0 && fine[0] < 1e-7, "{coarse:?} {fine:?}");
    assert!(fine[1] < coarse[1] / 32.0 && fine[1] < 1e-6, "{coarse:?} {fine:?}");
}

/// Constrained runs have the same events. With a joint that a constraint locks they equal those of the plain
/// run, to the rounding of the two ways to compute an acceleration.
#[test]
fn constrained_runs_have_events() {
    let model = pendulum();
    let mut robot = model.description().clone();
    let other = robot.links.last().unwrap().mass_properties;
    robot.links.push(LinkDescription::new("other", other));
    let mut locked = robot.joints[0].clone();
    (locked.name, locked.child) = ("locked".into(), "other".into());
    robot.joints.push(locked);
    let two = Model::new(robot).unwrap();
    let lock = Coupling::new(&two, &[(&two.coordinate_names()[1], 1.0)], 0.3).unwrap();
    let constraints = ConstraintSet::new(&two, [("lock", lock.into())]).unwrap();
    let options = ConstraintOptions { integrator: Integrator::RungeKutta4, ..ConstraintOptions::default() };
    let mut constrained = SimulationBuilder::new(&two)
        .method(Method::Fixed(options.integrator))
        .constraints(constraints)
        .constraint_options(options, DriftCorrection::None)
        .dt(0.01)
        .build()
        .unwrap();
    let events = || {
        [
            Event::new("level", |_, q: &[f64], _: &[f64]| q[0]),
            Event::new("bottom", |_, q: &[f64], _: &[f64]| q[0] - FRAC_PI_2).terminal(),
        ]
    };
    let found = constrained
        .run_steps_from(&[-0.5, 0.3], &[0.0; 2], 1000, RunOptions::new().sample_ends().events(&mut events()))
        .unwrap();
    assert!(constrained.constraint_record().is_some() && (found.q[1] - 0.3).abs() < 1e-12);
    let plain = simulation(&model, Integrator::RungeKutta4, 0.01)
        .run_steps_from(&[-0.5], &[0.0], 1000, RunOptions::new().sample_ends().events(&mut events()))
        .unwrap();
    assert_eq!((found.events.len(), found.ended_by_event, found.steps), (2, true, plain.steps));
    for (a, b) in found.events.iter().zip(&plain.events) {
        assert!((a.time - b.time).abs() < 1e-12 && max_difference(&a.q[..1], &b.q) < 1e-12, "{a:?} {b:?}");
    }
}
