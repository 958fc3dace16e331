//! Adaptive runs: accuracy against the tolerance, dense output, events, energy accounts, errors.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::InvalidInput;
use robot_dynamics::description::{
    Base, JointDescription, JointKind, Limits, LinkDescription, MassProperties, PassiveForces, Pose,
    RobotDescription,
};
use robot_dynamics::model::{Model, difference, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    AdaptiveMethod, AdaptiveOptions, ConstantTorque, ControlTiming, Controller, Effect, Event,
    GravityCompensatedPd, Integrator, Method, Run, RunError, RunFailure, RunOptions, Simulation,
    SimulationBuilder, SimulationError, StepError, StepInfo, StepStatistics, ZeroTorque,
};

use crate::common::damped_tree;

/// Adaptive steps to a tolerance.
fn to(tolerance: f64) -> AdaptiveOptions {
    AdaptiveOptions { tolerance, ..AdaptiveOptions::default() }
}

/// Without damping.
fn free(model: &Model, options: AdaptiveOptions, step: f64) -> Simulation {
    let builder = SimulationBuilder::new(model).without(Effect::Dissipation).adaptive(options);
    builder.dt(step).build().unwrap()
}

fn statistics(simulation: &Simulation) -> StepStatistics {
    simulation.adaptive_record().unwrap().statistics
}

/// 1 kg on a rod of 1 m along x, turning about y: q̈ = g cos q, hanging at π/2.
fn pendulum() -> Model {
    let mut robot = RobotDescription::new("pendulum");
    let bob = MassProperties::new(1.0, Vector3::new(1.0, 0.0, 0.0), Matrix3::zeros()).unwrap();
    robot.links.push(LinkDescription::new("ceiling", None));
    robot.links.push(LinkDescription::new("rod", bob));
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    let joint = JointDescription::new("hinge", hinge, "ceiling", "rod", Pose::IDENTITY);
    let limits = Limits::new(0.2, 3.0);
    robot.joints.push(joint.with_limits(limits));
    Model::new(robot).unwrap()
}

/// The period of a swing by the arithmetic-geometric mean: T = 2π √(l/g) / agm(1, cos ½φ).
fn period(amplitude: f64) -> f64 {
    let (mut a, mut g) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..8 {
        (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
    }
    2.0 * PI * (1.0 / 9.81f64).sqrt() / a
}

/// The largest entry of q₁ ⊖ q₀ and v₁ − v₀.
fn distance(model: &Model, a: (&[f64], &[f64]), b: (&[f64], &[f64])) -> f64 {
    let mut d = vec![0.0; model.nv()];
    difference(model, a.0, b.0, &mut d);
    let v = a.1.iter().zip(b.1).map(|(a, b)| a - b);
    d.iter().copied().chain(v).map(f64::abs).fold(0.0, f64::max)
}

/// Quarter, half and full periods of swings of 0.5, 1.5 and 3 rad against the elliptic integral. They agree
/// to 1e-9 s at a tolerance of 1e-12, as errors add up over the 20 to 100 steps of a swing.
#[test]
fn swings_take_the_time_of_the_elliptic_integral() {
    let model = pendulum();
    for amplitude in [0.5, 1.5, 3.0] {
        let t = period(amplitude);
        let mut events = [
            Event::new("bottom", |_, q: &[f64], _: &[f64]| q[0] - FRAC_PI_2),
            Event::new("turn", |_, _: &[f64], v: &[f64]| v[0]),
            Event::new("back", |_, _: &[f64], v: &[f64]| v[0]).rising().terminal(),
        ];
        let run = free(&model, to(1e-12), 100.0)
            .run_steps_from(&[FRAC_PI_2 - amplitude], &[0.0], 1, RunOptions::new().events(&mut events))
            .unwrap();
        let names: Vec<&str> = run.events.iter().map(|event| event.name.as_str()).collect();
        // At the start v = 0 is not an event.
        assert_eq!(names, ["bottom", "turn", "bottom", "turn", "back"], "amplitude {amplitude}");
        let fractions = [0.25, 0.5, 0.75, 1.0, 1.0];
        for (event, expected) in run.events.iter().zip(fractions.map(|fraction| fraction * t)) {
            println!("amplitude {amplitude} {} off by {:.1e}", event.name, event.time - expected);
            assert!((event.time - expected).abs() < 1e-9, "{event:?} {expected}");
        }
        assert_eq!((run.ended_by_event, run.time), (true, run.events[4].time));
        assert!((run.q[0] - (FRAC_PI_2 - amplitude)).abs() < 1e-9 && run.v[0].abs() < 1e-9);
    }
}

/// On floating trees with motors and dampers the end state matches Runge–Kutta with tiny steps. Its error
/// decreases with the tolerance, and the energy account closes to the tolerance.
#[test]
fn error_follows_tolerance() {
    for seed in 0..4 {
        let model = damped_tree(seed);
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let mut torque = ConstantTorque(state.tau.iter().map(|tau| 0.1 * tau).collect());
        let end = 0.4;
        let rows = SimulationBuilder::new(&model).method(Method::Fixed(Integrator::RungeKutta4));
        let reference = rows
            .dt(end / 8000.0)
            .build()
            .unwrap()
            .run_steps_from(&state.q, &state.v, 8000, RunOptions::new().sample_ends().controller(&mut torque))
            .unwrap();
        let mut errors = Vec::new();
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let damped = SimulationBuilder::new(&model).adaptive(to(tolerance)).dt(end / 100.0);
            let mut simulation = damped.build().unwrap();
            let options = RunOptions::new().controller(&mut torque);
            let run = simulation.run_steps_from(&state.q, &state.v, 100, options).unwrap();
            let record = simulation.adaptive_record().unwrap();
            let error = distance(&model, (&run.q, &run.v), (&reference.q, &reference.v));
            let imbalance = run.energy_account.max_imbalance() / (1.0 + run.energy_account.kinetic());
            let work = (run.energy_account.work() - reference.energy_account.work()).abs();
            println!(
                "robot {seed} {tolerance:.0e}: error {error:.1e}, imbalance {imbalance:.1e}, work {work:.1e}, quaternions \
                 {:.1e}, {:?}",
                record.quaternion_error, record.statistics
            );
            // About ten steps, each within the tolerance; this motion hardly amplifies errors in 0.4 s.
            let allowed = 10.0 * tolerance;
            assert!(error < allowed, "robot {seed}, {tolerance:e}: {error:e}");
            assert!(
                imbalance < allowed && record.quaternion_error < allowed,
                "robot {seed}, {tolerance:e}: {imbalance:e}"
            );
            assert!(work < allowed * (1.0 + run.energy_account.work().abs()), "robot {seed}: {work:e}");
            assert!(run.energy_account.dissipated() > 0.01, "damping acts");
            assert_eq!(run.trajectory.len(), 101);
            errors.push(error);
        }
        // Six orders of magnitude in the tolerance reduce the error by at least four.
        assert!(errors[3] < 1e-4 * errors[0], "robot {seed}: {errors:?}");
    }
}

/// Samples inside steps are as accurate as the ends of steps: against a run with tolerance 1e-13, five
/// hundred samples, several in each step.
#[test]
fn dense_output_is_as_accurate_as_the_steps() {
    let model = damped_tree(2);
    let state = random_state(&model, &mut SplitMix64::new(2));
    let run = |tolerance: f64, count: u32| -> (Run, StepStatistics) {
        let mut simulation = free(&model, to(tolerance), 0.5 / f64::from(count));
        let run = simulation.run_steps_from(&state.q, &state.v, count as usize, RunOptions::new()).unwrap();
        (run, statistics(&simulation))
    };
    let (exact, _) = run(1e-13, 500);
    for tolerance in [1e-5, 1e-8, 1e-11] {
        let (found, steps) = run(tolerance, 500);
        let (_, alone) = run(tolerance, 1);
        assert_eq!(steps, alone, "samples must not shorten steps");
        let worst = found
            .trajectory
            .iter()
            .zip(exact.trajectory.iter())
            .map(|(a, b)| distance(&model, (a.q, a.v), (b.q, b.v)))
            .fold(0.0, f64::max);
        let end = distance(&model, (&found.q, &found.v), (&exact.q, &exact.v));
        println!("{tolerance:.0e}: worst sample {worst:.1e}, end {end:.1e}, {steps:?}");
        assert!(steps.accepted < 250, "several samples a step");
        // The interpolating polynomial has the order of the step: its error is within the tolerance of one
        // step.
        assert!(worst < tolerance, "{tolerance:e}: {worst:e} inside, {end:e} at the end");
    }
}

/// A held controller acts at the same times as in a run of fixed steps. Motion and peak torques agree to the
/// error of Runge–Kutta with steps of a millisecond.
#[test]
fn held_control_matches_fixed_steps() {
    let model = pendulum();
    let target = [0.9];
    let control = || GravityCompensatedPd::new(&model, &target, &[80.0], &[9.0]).unwrap();
    let fixed: Run = SimulationBuilder::new(&model)
        .without(Effect::Dissipation)
        .method(Method::Fixed(Integrator::RungeKutta4))
        .build()
        .unwrap()
        .run_steps_from(&[1.5], &[0.0], 1000, RunOptions::new().sample_every(100).controller(&mut control()))
        .unwrap();
    let options = AdaptiveOptions { control: ControlTiming::Held { period: 1e-3 }, ..to(1e-11) };
    let mut simulation = free(&model, options, 0.1);
    let run =
        simulation.run_steps_from(&[1.5], &[0.0], 10, RunOptions::new().controller(&mut control())).unwrap();
    let steps = statistics(&simulation);
    for (a, b) in run.trajectory.iter().zip(fixed.trajectory.iter()) {
        // h⁴ = 1e-12 times derivatives of some hundreds.
        assert!((a.q[0] - b.q[0]).abs() < 1e-9 && (a.v[0] - b.v[0]).abs() < 1e-8, "{a:?} {b:?}");
    }
    assert!(steps.longest < 1e-3 + 1e-15 && steps.accepted >= 1000, "{steps:?}");
    assert!(
        run.energy_account.work().abs() > 1.0 && run.energy_account.max_imbalance() < 1e-9,
        "{:?}",
        run.energy_account
    );

    // A continuous law is the limit of short periods, and it needs few steps.
    let mut continuous = free(&model, to(1e-11), 0.1);
    let smooth =
        continuous.run_steps_from(&[1.5], &[0.0], 10, RunOptions::new().controller(&mut control())).unwrap();
    let steps = statistics(&continuous);
    let off = (smooth.q[0] - run.q[0]).abs();
    println!("{off:.1e} between continuous and held, {steps:?}");
    // A delay of half a period in a loop with rates of about ten per second, at rest by then up to e⁻⁵.
    assert!(off < 1e-3 && steps.accepted < 200, "{off:e} {steps:?}");
}

/// Outward crossings of limits by name, directions, a start at a crossing, and a restart from a terminal
/// event.
#[test]
fn events_are_found_by_name_and_direction() {
    let model = pendulum();
    let start = [FRAC_PI_2 - 1.5];
    let mut limits = Event::joint_limits(&model);
    assert_eq!(limits.len(), 2);
    let run = free(&model, to(1e-10), 0.9 * period(1.5))
        .run_steps_from(&start, &[0.0], 1, RunOptions::new().events(&mut limits))
        .unwrap();
    // The swing starts at 0.07, below the lower limit, passes 0.2 inward and 3.0 outward, and passes 3.0
    // inward on its return.
    let names: Vec<&str> = run.events.iter().map(|event| event.name.as_str()).collect();
    assert_eq!(names, ["`hinge` at its upper limit"]);
    assert!((run.events[0].q[0] - 3.0).abs() < 1e-12 && run.events[0].rising);

    // A ball bounces without loss: it reaches the floor after t₁, then every 2 t₁. Each bounce is a new run.
    let mut robot = RobotDescription::new("ball");
    robot.base = Base::Floating;
    let ball = MassProperties::solid_box(1000.0, Vector3::new(0.1, 0.1, 0.1)).unwrap();
    robot.links.push(LinkDescription::new("ball", ball));
    let model = Model::new(robot).unwrap();
    let floor = || Event::touchdown("floor", &model, model.frame("ball").expect("a link"), 0.0).terminal();
    let (mut q, mut v) = (neutral(&model), vec![0.0; 6]);
    q[2] = 1.0;
    let mut simulation = free(&model, to(1e-12), 100.0);
    for bounce in 0..5 {
        simulation.set_state(&q, &v).unwrap(); // at the same time
        let run = simulation.run_steps(1, RunOptions::new().events(&mut [floor()])).unwrap();
        let expected = f64::from(2 * bounce + 1) * (2.0 / 9.81f64).sqrt();
        assert!((run.time - expected).abs() < 1e-11, "bounce {bounce} at {} not {expected}", run.time);
        assert!(run.ended_by_event);
        (q, v) = (run.q, run.v);
        v[2] = -v[2];
    }
}

/// Two crossings within one long step are both found, in order.
#[test]
fn crossings_within_a_step_are_found() {
    let mut robot = RobotDescription::new("brick");
    robot.base = Base::Floating;
    let brick = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    robot.links.push(LinkDescription::new("brick", brick));
    let model = Model::new(robot).unwrap();
    // Free fall is a parabola, so the steps grow to their maximum length.
    let height = |z: f64| Event::new(format!("at {z}"), move |_, q: &[f64], _: &[f64]| q[2] - z);
    let mut events = [height(0.3), height(0.4), height(-2.0).falling()];
    let v = [0.0, 0.0, 3.0, 0.0, 0.0, 0.0];
    let mut simulation = free(&model, to(1e-6), 2.0);
    let run =
        simulation.run_steps_from(&neutral(&model), &v, 1, RunOptions::new().events(&mut events)).unwrap();
    let names: Vec<&str> = run.events.iter().map(|event| event.name.as_str()).collect();
    assert_eq!(names, ["at 0.3", "at 0.4", "at 0.4", "at 0.3", "at -2"], "{:?}", statistics(&simulation));
    for event in &run.events {
        let z = 3.0 * event.time - 0.5 * 9.81 * event.time * event.time;
        // A parabola has rounding errors only. The coefficients of the interpolant reach 2e4, and their
        // roundings 4e-12 of the distance of a step of one second.
        assert!((z - event.q[2]).abs() < 1e-11, "{event:?}");
    }
}

/// If an observer breaks off, the run up to that step is kept.
#[test]
fn interrupted_run_keeps_its_steps() {
    let model = pendulum();
    let mut stop = |info: &StepInfo<'_>| {
        if info.step == 7 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let run = free(&model, to(1e-9), 0.1)
        .run_steps_from(&[0.3], &[0.0], 100, RunOptions::new().observer(&mut stop))
        .unwrap();
    assert_eq!((run.interrupted, run.time, run.trajectory.len()), (true, 7.0 * 0.1, 8));
}

/// A flag ends the run between two samples, at the end of a step, which is kept. Here a controller sets the
/// flag at its first call after half a second.
#[test]
fn flag_interrupts_between_samples() {
    let model = pendulum();
    let flag = Arc::new(AtomicBool::new(false));
    let builder = SimulationBuilder::new(&model).adaptive(to(1e-9)).interrupt(Arc::clone(&flag));
    let mut simulation = builder.dt(100.0).build().unwrap();
    let mut late = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau[0] = 0.0;
        if t > 0.5 {
            flag.store(true, Ordering::Relaxed);
        }
    };
    let run = simulation.run_steps_from(&[0.3], &[0.0], 1, RunOptions::new().controller(&mut late)).unwrap();
    assert_eq!((run.interrupted, run.trajectory.len()), (true, 2), "{run:?}");
    assert!(run.time > 0.4 && run.time < 2.0, "{}", run.time);
    let last = run.trajectory.sample(1);
    assert_eq!((last.time, last.q, last.v), (run.time, &run.q[..], &run.v[..]));
    assert!(
        run.energy_account.drift() < 1e-8,
        "the energy account is that of this time: {:e}",
        run.energy_account.drift()
    );
    // The flag is set at the start: no step is taken.
    let run = simulation.run_steps_from(&[0.3], &[0.0], 1, RunOptions::new().controller(&mut late)).unwrap();
    assert_eq!((run.interrupted, run.time, statistics(&simulation).accepted), (true, 0.0, 0));
}

/// The error names the faster of two pendulums on one rod, in either order; its frequency is a hundred times
/// the other's.
#[test]
fn error_names_joint_that_needs_short_steps() {
    for fast in [0, 1] {
        let mut robot = RobotDescription::new("two");
        robot.links.push(LinkDescription::new("ceiling", None));
        for k in 0..2 {
            let stiffness = if k == fast { 1e8 } else { 1.0 };
            let bob = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity()).unwrap();
            robot.links.push(LinkDescription::new(format!("bob{k}"), bob));
            let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
            let joint = JointDescription::new(
                format!("spring{k}"),
                hinge,
                "ceiling",
                format!("bob{k}"),
                Pose::IDENTITY,
            );
            let passive = PassiveForces::default().with_spring(stiffness, 0.0);
            robot.joints.push(joint.with_passive(passive));
        }
        let model = Model::new(robot).unwrap();
        let mut bounded = free(&model, AdaptiveOptions { max_steps: 100, ..to(1e-9) }, 9.0);
        let failure = bounded.run_steps_from(&[0.3, 0.3], &[0.0; 2], 1, RunOptions::new()).unwrap_err();
        let RunError::Step { ref source, .. } = failure.error else { panic!("{failure}") };
        let StepError::TooManySteps { steps, step, coordinate } = source else { panic!("{failure}") };
        // ω = 1e4 1/s: steps of about 1/ω.
        assert!(*steps == 100 && *step > 1e-6 && *step < 1e-3, "{failure}");
        assert_eq!(*coordinate, format!("spring{fast}"), "{failure}");
    }
}

/// The same trees with a damper of 3e4/s at one joint, which the explicit method can still integrate. The
/// automatic choice is the implicit method. It reaches the same end state with far fewer steps, its error
/// decreases with the tolerance, and the energy account closes.
#[test]
fn stiff_damping_is_integrated_implicitly() {
    for seed in 0..4 {
        let mut robot = damped_tree(seed).description().clone();
        let soft = Model::new(robot.clone()).unwrap();
        let state = random_state(&soft, &mut SplitMix64::new(seed));
        let stiff = robot.joints.iter().position(|joint| joint.kind != JointKind::Fixed).unwrap();
        let coordinate = soft.joints().iter().find(|joint| joint.name == robot.joints[stiff].name).unwrap();
        let inverse = soft.inverse_mass_matrix(&state.q).unwrap();
        let k = coordinate.v_index;
        robot.joints[stiff].passive.damping = 3e4 / inverse[(k, k)];
        let model = Model::new(robot).unwrap();
        let run = |method, tolerance| {
            let options = AdaptiveOptions { method, ..to(tolerance) };
            let mut simulation = SimulationBuilder::new(&model).adaptive(options).dt(0.03).build().unwrap();
            let run = simulation.run_steps_from(&state.q, &state.v, 10, RunOptions::new()).unwrap();
            (run, *simulation.adaptive_record().unwrap())
        };
        let (exact, most) = run(AdaptiveMethod::Explicit, 1e-12);
        let mut errors = Vec::new();
        for tolerance in [1e-4, 1e-6, 1e-8] {
            let (found, record) = run(AdaptiveMethod::Automatic, tolerance);
            assert_eq!(record.method, AdaptiveMethod::Implicit);
            let steps = record.statistics;
            let error = distance(&model, (&found.q, &found.v), (&exact.q, &exact.v));
            let imbalance = found.energy_account.max_imbalance() / (1.0 + found.energy_account.start().abs());
            println!("robot {seed} {tolerance:.0e}: error {error:.1e}, imbalance {imbalance:.1e}, {steps:?}");
            // Each step is within the tolerance. In the energy account W and D have that error. K has the
            // error of the velocities times the momentum, which has the size of the energy here.
            let allowed = steps.accepted as f64 * tolerance;
            assert!(
                error < allowed && imbalance < 3.0 * allowed,
                "robot {seed}, {tolerance:e}: {error:e}, {imbalance:e}"
            );
            assert!(steps.accepted < most.statistics.accepted / 5, "{most:?}");
            errors.push(error);
        }
        assert!(errors[2] < 1e-2 * errors[0], "robot {seed}: {errors:?}");
    }
}

/// A wheel with a damper of 1e8/s on a spring: x = x₀ (λ₂ e^{λ₁t} − λ₁ e^{λ₂t})/(λ₂ − λ₁), to the tolerance.
/// The explicit method needs 10⁸ steps and gives up. The damper dissipates the energy of the spring.
#[test]
fn stiff_damper_follows_closed_form() {
    let (damping, stiffness) = (1e8, 1e8);
    let mut robot = RobotDescription::new("wheel");
    let wheel = MassProperties::new(1.0, Vector3::zeros(), Matrix3::identity()).unwrap();
    robot.links.push(LinkDescription::new("wall", None));
    robot.links.push(LinkDescription::new("wheel", wheel));
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    let joint = JointDescription::new("hinge", hinge, "wall", "wheel", Pose::IDENTITY);
    let passive = PassiveForces::default().with_damping(damping).with_spring(stiffness, 0.0);
    robot.joints.push(joint.with_passive(passive));
    let model = Model::new(robot).unwrap();
    let run = |method| {
        let options = AdaptiveOptions { method, max_steps: 10_000, ..to(1e-9) };
        let mut simulation = SimulationBuilder::new(&model).adaptive(options).dt(0.5).build().unwrap();
        let run = simulation.run_steps_from(&[0.5], &[0.0], 4, RunOptions::new());
        println!("{:?}", simulation.adaptive_record());
        run
    };
    let found = run(AdaptiveMethod::Automatic).unwrap();
    let fast = -0.5 * (damping + (damping * damping - 4.0 * stiffness).sqrt());
    let slow = stiffness / fast; // λ₁λ₂ = k
    for (sample, t) in [0, 1, 4].map(|k| found.trajectory.sample(k)).into_iter().zip([0.0f64, 0.5, 2.0]) {
        assert_eq!(sample.time, t);
        let exact = 0.5 * (fast * (slow * t).exp() - slow * (fast * t).exp()) / (fast - slow);
        println!("t = {t}: off by {:.1e}", sample.q[0] - exact);
        assert!((sample.q[0] - exact).abs() < 1e-8, "{t}: {} {exact}", sample.q[0]);
    }
    let stored = 0.5 * stiffness * 0.25;
    let left = 0.5 * stiffness * found.q[0] * found.q[0];
    assert!((found.energy_account.dissipated() - (stored - left)).abs() < 1e-7 * stored);
    let failure = run(AdaptiveMethod::Explicit).unwrap_err();
    let RunError::Step { ref source, .. } = failure.error else { panic!("{failure}") };
    assert!(matches!(source, StepError::TooManySteps { .. }), "{failure}");
    // The default is the automatic choice.
    assert_eq!(AdaptiveOptions::default().method, AdaptiveMethod::Automatic);
}

/// A velocity with a finite square for which no step is short enough: the error names the coordinate, and the
/// start is kept.
#[test]
fn start_too_fast_for_any_step_is_an_error() {
    let model = &damped_tree(7);
    let v = vec![1e120; model.nv()];
    let failure =
        free(model, to(1e-9), 1.0).run_steps_from(&neutral(model), &v, 1, RunOptions::new()).unwrap_err();
    assert_eq!((failure.until.time, failure.until.trajectory.len()), (0.0, 1), "{failure}");
    let (RunError::NotFinite { coordinate, .. }
    | RunError::Diverged { coordinate, .. }
    | RunError::Step {
        source:
            StepError::StepTooSmall { coordinate, .. }
            | StepError::TooManySteps { coordinate, .. }
            | StepError::Diverged { coordinate, .. },
        ..
    }) = &failure.error
    else {
        panic!("{failure}")
    };
    assert!(model.coordinate_names().contains(coordinate), "{failure}");
}

/// Errors have the time and the name, and what was computed is kept.
#[test]
fn errors_keep_the_run_until_then() {
    let model = pendulum();
    let attempt = |options, step, steps, controller: &mut dyn Controller| -> Box<RunFailure> {
        let controlled = RunOptions::new().controller(controller);
        free(&model, options, step).run_steps_from(&[0.3], &[0.0], steps, controlled).unwrap_err()
    };
    let good = to(1e-9);
    let refused = SimulationBuilder::new(&model).adaptive(to(1e-20)).build().unwrap_err();
    let bad = InvalidInput::out_of_range("the tolerance", 1e-20, "", "between 1e-13 and 1e-2");
    assert_eq!(refused, SimulationError::Input(bad));
    let bounded = AdaptiveOptions { max_steps: 5, ..good };
    let failure = attempt(bounded, 9.0, 1, &mut ZeroTorque);
    let RunError::Step { source, .. } = &failure.error else { panic!("{failure}") };
    let StepError::TooManySteps { steps: 5, coordinate, .. } = source else { panic!("{failure}") };
    assert_eq!(coordinate, "hinge");
    // The end of the fifth step is the last sample.
    assert!(failure.until.time > 0.0 && failure.until.trajectory.len() == 2, "{failure}");
    // The maximum counts the steps between samples: ten samples are closer than that.
    let mut often = free(&model, bounded, 0.1);
    let run = often.run_steps_from(&[0.3], &[0.0], 10, RunOptions::new()).unwrap();
    assert!(statistics(&often).accepted > 5 && run.time == 1.0, "{:?}", statistics(&often));

    // A torque that becomes NaN at 0.5 s: the samples before it are kept.
    let mut broken =
        |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| tau[0] = if t > 0.5 { f64::NAN } else { 0.1 };
    let failure = attempt(good, 0.01, 100, &mut broken);
    let RunError::StepInput { time, ref source, .. } = failure.error else { panic!("{failure}") };
    let named = "torque[0] (coordinate `hinge`) is NaN; every number must be finite";
    assert_eq!(source.to_string(), named);
    assert!((0.49..=0.5).contains(&time) && failure.until.trajectory.len() >= 45, "{failure}");
    let held = AdaptiveOptions { control: ControlTiming::Held { period: 0.1 }, ..good };
    let failure = attempt(held, 0.01, 100, &mut broken);
    let RunError::StepInput { time, ref source, .. } = failure.error else { panic!("{failure}") };
    assert!(source.to_string() == named && (0.6..0.7).contains(&time), "{failure}");

    // A controller that fails from 0.5 s on, with continuous control and with a control period.
    let mut lost = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau[0] = 0.1;
        if t > 0.5 { Err("no contact to the encoder") } else { Ok(()) }
    };
    let failure = attempt(good, 0.01, 100, &mut lost);
    let RunError::Controller { time, ref source, .. } = failure.error else { panic!("{failure}") };
    assert!((0.49..=0.5).contains(&time) && failure.until.trajectory.len() >= 45, "{failure}");
    assert_eq!(source.to_string(), "no contact to the encoder");
    let failure = attempt(held, 0.01, 100, &mut lost);
    let RunError::Controller { time, ref source, .. } = failure.error else { panic!("{failure}") };
    assert_eq!(source.to_string(), "no contact to the encoder");
    assert!((0.6..0.7).contains(&time) && failure.until.trajectory.len() >= 60, "{failure}");
    for period in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let held = AdaptiveOptions { control: ControlTiming::Held { period }, ..good };
        let refused = SimulationBuilder::new(&model).adaptive(held).build().unwrap_err();
        let SimulationError::Input(error) = refused else { panic!("{refused}") };
        assert_eq!(error.quantity, "the control period");
    }

    // A motor whose torque grows with the speed squared: q grows without bound in finite time.
    let mut runaway = |_: f64, _: &[f64], v: &[f64], tau: &mut [f64]| tau[0] = 10.0 * v[0] * v[0] + 1.0;
    let failure = attempt(good, 0.01, 100, &mut runaway);
    assert!(failure.until.time < 1.0, "{failure}");
    assert!(failure.until.trajectory.iter().all(|s| s.q[0].is_finite() && s.v[0].is_finite()));

    // Coulomb friction is left out, and damping with it.
    let mut robot = pendulum().description().clone();
    robot.joints[0].passive = PassiveForces::default().with_friction(0.1).with_damping(0.1);
    let rough = SimulationBuilder::new(&Model::new(robot).unwrap()).adaptive(good).build().unwrap();
    assert_eq!(rough.left_out().len(), 2, "friction with damping, and position limits: {rough:?}");
    assert!(!rough.dissipates() && rough.acting().is_empty());

    let watched = |event: Event<'_>, step, steps| {
        let events = &mut [event];
        let options = RunOptions::new().events(events);
        free(&model, good, step).run_steps_from(&[0.3], &[0.0], steps, options).unwrap_err()
    };
    let nothing = Event::new("root", |_, q: &[f64], _: &[f64]| (q[0] - 0.5).sqrt());
    let failure = watched(nothing, 1.0, 1);
    let RunError::EventNotFinite { name, time: 0.0, value } = &failure.error else { panic!("{failure}") };
    assert!(name == "root" && value.is_nan(), "{failure}");
    let far = Event::new("pole", |t, _: &[f64], _: &[f64]| if t < 0.3 { -1.0 } else { f64::INFINITY });
    let failure = watched(far, 1.0, 1);
    let RunError::EventNotFinite { name, value: f64::INFINITY, .. } = &failure.error else {
        panic!("{failure}")
    };
    assert_eq!(name, "pole");
    // The function fails near the crossing only, where the event search evaluates it.
    let blind =
        Event::new(
            "seen",
            |_, q: &[f64], _: &[f64]| {
                if (q[0] - 0.6).abs() < 1e-3 { Err("the light is off") } else { Ok(q[0] - 0.6) }
            },
        );
    let failure = watched(blind, 0.01, 100);
    let RunError::Event { name, time, source } = &failure.error else { panic!("{failure}") };
    assert_eq!((name.as_str(), source.to_string().as_str()), ("seen", "the light is off"));
    assert!(*time < 1.0 && failure.until.trajectory.len() > 2, "{failure}");
}
