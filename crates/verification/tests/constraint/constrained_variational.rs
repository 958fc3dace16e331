//! Variational steps with constraints: order, reversibility, symplecticity, energy, momenta.

use std::error::Error;
use std::ops::ControlFlow;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::{center_of_mass, centroidal_momentum, frame_pose};
use robot_dynamics::constraints::{
    Baumgarte, ConstraintError, ConstraintOptions, ConstraintSet, Coupling, DriftCorrection, FrameConstraint,
    LoopClosure, RedundantRows, RollingDisc, SpatialAxis, StepConstraints, constrained_step,
    constraint_drift, project_position, project_velocity,
};
use robot_dynamics::description::{
    Base, FrameDescription, JointKinds, LinkDescription, MassProperties, Pose, RandomRobotOptions,
    RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, Workspace, difference, neutral, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Effect, Integrator, Method, Run, RunError, RunOptions, Simulation, SimulationBuilder, StepError,
    StepForces, StepWorkspace, step,
};

use crate::closed_loop::{PIN, linkage, start};

type Tested = Result<(), Box<dyn Error>>;

const VARIATIONAL: [Integrator; 2] = [Integrator::VariationalMidpoint, Integrator::VariationalYoshida4];

#[derive(Clone, Debug)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
}

fn options(integrator: Integrator) -> ConstraintOptions {
    ConstraintOptions { integrator, ..Default::default() }
}

fn four_bar() -> Result<(Model, ConstraintSet, State), Box<dyn Error>> {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let (q, v) = start(&model, &set)?;
    Ok((model, set, State { q, v }))
}

/// Steps with gravity as the only force.
fn advance(
    model: &Model,
    set: &ConstraintSet,
    from: &State,
    h: f64,
    steps: usize,
    row: Integrator,
) -> Result<State, ConstraintError> {
    let tau = vec![0.0; model.nv()];
    let forces = StepForces::new(&tau, false);
    let correction = match row {
        row if row.is_explicit() => DriftCorrection::Position { tolerance: 1e-13 },
        _ => DriftCorrection::None,
    };
    let workspace = &mut Workspace::new(model);
    let State { mut q, mut v } = from.clone();
    for _ in 0..steps {
        constrained_step(
            model,
            workspace,
            StepConstraints { set, options: &options(row), correction },
            &forces,
            h,
            &mut q,
            &mut v,
        )?;
    }
    Ok(State { q, v })
}

/// The largest entry of q₁ ⊖ q₀ and v₁ − v₀.
fn distance(model: &Model, a: &State, b: &State) -> f64 {
    let mut d = vec![0.0; model.nv()];
    difference(model, &a.q, &b.q, &mut d);
    let v = a.v.iter().zip(&b.v).map(|(a, b)| a - b);
    d.iter().copied().chain(v).map(f64::abs).fold(0.0, f64::max)
}

/// A floating tree with six joints of all kinds and loops closed at random in its current pose; its velocity
/// keeps them closed.
fn random_loop(seed: u64) -> Result<(Model, ConstraintSet, State), Box<dyn Error>> {
    let random = &mut SplitMix64::new(seed);
    let shape = RandomRobotOptions {
        joints: 7,
        base: if seed.is_multiple_of(2) { Base::Floating } else { Base::Fixed },
        massless: 0.0,
        passive: 0.0,
        mass_ratio: 3.0,
        chain: 0.5,
        kinds: JointKinds::All,
        ..Default::default()
    };
    let model = Model::new(random_robot(seed, &shape))?;
    let workspace = &mut Workspace::new(&model);
    let state = random_state(&model, random);
    let names: Vec<&str> = model.frames().iter().map(|frame| frame.name.as_str()).collect();
    let mut pick = || model.frame(names[usize::from(random.next_u64().to_le_bytes()[7]) % names.len()]);
    let (a, b) = (pick().ok_or("no frame")?, pick().ok_or("no frame")?);
    // The anchor is at frame a: φ = 0 at this state.
    let place = frame_pose(&model, workspace, &state.q, a);
    let here = Pose { rotation: place.rotation, translation: place.translation };
    let hold = FrameConstraint::contact(a, here, &[SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Rz]);
    let place = frame_pose(&model, workspace, &state.q, b);
    let nail = FrameConstraint::contact(
        b,
        Pose { rotation: place.rotation, translation: place.translation },
        &[SpatialAxis::Z, SpatialAxis::X],
    );
    let set = ConstraintSet::new(&model, [("hold", hold.into()), ("nail", nail.into())])?;
    let mut v = state.v.clone();
    project_velocity(&model, workspace, &set, &ConstraintOptions::default(), &state.q, &mut v)?;
    Ok((model, set, State { q: state.q, v }))
}

/// A run of steps of h without dissipation, and the largest energy errors in its first and last tenth \[J\].
fn energy_errors(
    model: &Model,
    set: &ConstraintSet,
    state: &State,
    row: Integrator,
    (h, steps): (f64, usize),
) -> Result<(Simulation, Run, [f64; 2]), Box<dyn Error>> {
    let mut simulation = SimulationBuilder::new(model)
        .method(Method::Fixed(row))
        .constraints(set.clone())
        .dt(h)
        .without(Effect::Dissipation)
        .constraint_options(options(row), DriftCorrection::None)
        .build()?;
    let (mut first, mut last) = (0.0f64, 0.0f64);
    let run = simulation.run_steps_from(
        &state.q,
        &state.v,
        steps,
        RunOptions::new().sample_ends().observer(&mut |info| {
            let error = info.energy_account.imbalance().abs();
            if info.step <= steps / 10 {
                first = first.max(error);
            }
            if info.step > steps - steps / 10 {
                last = last.max(error);
            }
            ControlFlow::Continue(())
        }),
    )?;
    Ok((simulation, run, [first, last]))
}

/// The linkage: φ and A v at the end of every step are at rounding level. The energy does not drift in fifty
/// thousand steps, as the error in the last tenth is that of the first. Halving the step divides it by
/// 2^order.
///
/// φ is accurate to ε times the angle that the crank has turned, some thousand radians, times lengths below 1
/// m.
#[test]
fn four_bar_stays_closed_without_drift() -> Tested {
    let (model, set, state) = four_bar()?;
    for (row, h, steps) in [(VARIATIONAL[0], 4e-3, 50_000), (VARIATIONAL[1], 8e-3, 15_000)] {
        let run = |h: f64, steps: usize| -> Result<(f64, f64, f64), Box<dyn Error>> {
            let (simulation, run, [first, last]) = energy_errors(&model, &set, &state, row, (h, steps))?;
            let record = simulation.constraint_record().ok_or("no record")?;
            let turned = run.q.iter().fold(1.0, |most: f64, q| most.max(q.abs()));
            assert!(
                record.drift.position < 8.0 * f64::EPSILON * turned,
                "{row}: {:?}, {turned}",
                record.drift
            );
            assert!(record.drift.velocity < 1e-13, "{row}: {:?}", record.drift);
            assert!(record.energy_removed == 0.0 && record.smallest_rank == 2);
            Ok((first, last, run.energy_account.start()))
        };
        let (first, last, scale) = run(h, steps)?;
        let (halved, ..) = run(h / 2.0, steps / 10)?;
        let order = (first / halved).log2();
        println!(
            "{row:22} energy error {:.2e} first tenth, {:.2e} last; order {order:.2}",
            first / scale,
            last / scale
        );
        assert!(last < 1.2 * first, "{row}: {first:e} J, {last:e} J");
        assert!((order - f64::from(row.order())).abs() < 0.3, "{row}: order {order}");
    }
    Ok(())
}

/// Random trees with fixed random frames: φ and A v stay at rounding level. The motion matches the
/// constrained Runge–Kutta step with small steps, to the order of the method.
#[test]
fn random_loops_match_runge_kutta() -> Tested {
    for seed in 0..12 {
        let (model, set, state) = random_loop(seed)?;
        let time = 0.05;
        let reference = advance(&model, &set, &state, time / 400.0, 400, Integrator::RungeKutta4)?;
        for row in Integrator::ALL {
            let run = |steps: usize| -> Result<f64, Box<dyn Error>> {
                let end = advance(&model, &set, &state, time / steps as f64, steps, row)?;
                let drift = constraint_drift(&model, &mut Workspace::new(&model), &set, &end.q, &end.v);
                // Rounding of positions of some metres and velocities of about 10 m/s, times the condition of
                // A.
                assert!(drift.position < 1e-13 && drift.velocity < 1e-11, "seed {seed} {row}: {drift:?}");
                Ok(distance(&model, &end, &reference))
            };
            let (coarse, fine) = (run(10)?, run(20)?);
            let order = (coarse / fine).log2();
            println!("seed {seed} {row:22} K {} errors {coarse:.1e} {fine:.1e} order {order:.2}", set.len());
            // Below 1e-10 the remainder is the error of the reference.
            assert!(
                (order - f64::from(row.order())).abs() < 0.3 || fine < 1e-10,
                "seed {seed} {row}: order {order}, {fine:e}"
            );
        }
    }
    Ok(())
}

/// A step, the velocity reversed, a step, and reversed again: back at the start, to the rounding of the two
/// solves.
#[test]
fn constrained_steps_are_reversible() -> Tested {
    for seed in 0..12 {
        let (model, set, state) = random_loop(seed)?;
        for row in Integrator::ALL {
            let there = advance(&model, &set, &state, 4e-3, 1, row)?;
            let back = |v: &[f64]| v.iter().map(|v| -v).collect::<Vec<f64>>();
            let turned = State { q: there.q.clone(), v: back(&there.v) };
            let end = advance(&model, &set, &turned, 4e-3, 1, row)?;
            let off = distance(&model, &State { q: end.q.clone(), v: back(&end.v) }, &state);
            println!("seed {seed} {row:22} {off:.1e}");
            // Velocities of about 10; the rounding of φ, 1e-16 m over 4 ms, is 1e-13 of a velocity.
            assert!(off < 1e-11 || !row.reversible(), "seed {seed} {row}: {off:e}");
        }
    }
    Ok(())
}

/// Without constraints the step equals the free step.
#[test]
fn step_without_rows_is_free_step() -> Tested {
    for seed in 0..6 {
        let (model, _, state) = random_loop(seed)?;
        let none = ConstraintSet::default();
        for row in VARIATIONAL {
            let found = advance(&model, &none, &state, 2e-3, 5, row)?;
            let State { mut q, mut v } = state.clone();
            let tau = vec![0.0; model.nv()];
            let forces = StepForces::new(&tau, false);
            let workspace = &mut StepWorkspace::new(&model);
            for _ in 0..5 {
                step(&model, row, workspace, &forces, 2e-3, &mut q, &mut v)?;
            }
            let off = distance(&model, &found, &State { q, v });
            // Both solve the same equations to rounding, but may differ by one iteration.
            assert!(off < 1e-12, "seed {seed} {row}: {off:e}");
        }
    }
    Ok(())
}

/// The phase space of the linkage has the crank's angle s and the momentum P = tᵀM v along the tangent t with
/// t_crank = 1. The variational maps preserve its area; the Runge–Kutta map does not.
///
/// Five-point differences of 1e-3: an error of 1e-12 times fifth derivatives, and rounding 1e-15/1e-3.
#[test]
fn constrained_maps_preserve_area() -> Tested {
    let (model, set, state) = four_bar()?;
    let options_of_projection = ConstraintOptions::default();
    let tangent = |q: &[f64]| -> Result<Vec<f64>, ConstraintError> {
        let mut t = vec![1.0, 0.0, 0.0];
        project_velocity(&model, &mut Workspace::new(&model), &set, &options_of_projection, q, &mut t)?;
        let crank = t[0];
        Ok(t.iter().map(|t| t / crank).collect())
    };
    let along = |state: &State| -> Result<f64, ConstraintError> {
        let mass = model.mass_matrix(&state.q).expect("a configuration");
        let t = nalgebra::DVector::from_vec(tangent(&state.q)?);
        Ok(t.dot(&(mass * nalgebra::DVector::from_column_slice(&state.v))))
    };
    let (s0, p0) = (state.q[0], along(&state)?);
    // The state at (s₀ + x, P₀ + y): a coupling holds the crank at s while the loop is closed.
    let at = |x: f64, y: f64| -> Result<State, Box<dyn Error>> {
        let crank = Coupling::new(&model, &[("crank_joint", 1.0)], s0 + x)?;
        let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
        let pin = loops[0].resolve(&model)?;
        let held = ConstraintSet::new(&model, [("pin", pin.into()), ("crank", crank.into())])?;
        let mut q = state.q.clone();
        project_position(&model, &mut Workspace::new(&model), &held, &options_of_projection, 1e-15, &mut q)?;
        let t = tangent(&q)?;
        let unit = along(&State { q: q.clone(), v: t.clone() })?;
        Ok(State { q, v: t.iter().map(|t| t * (p0 + y) / unit).collect() })
    };
    for row in [VARIATIONAL[0], VARIATIONAL[1], Integrator::RungeKutta4] {
        let image = |x: f64, y: f64| -> Result<[f64; 2], Box<dyn Error>> {
            let end = advance(&model, &set, &at(x, y)?, 0.05, 1, row)?;
            Ok([end.q[0], along(&end)?])
        };
        let d = 1e-3;
        let slope = |x: f64, y: f64| -> Result<[f64; 2], Box<dyn Error>> {
            let (a, b) = (image(d * x, d * y)?, image(-d * x, -d * y)?);
            let (c, e) = (image(2.0 * d * x, 2.0 * d * y)?, image(-2.0 * d * x, -2.0 * d * y)?);
            Ok([0, 1].map(|i| (8.0 * (a[i] - b[i]) - (c[i] - e[i])) / (12.0 * d)))
        };
        let (by_s, by_p) = (slope(1.0, 0.0)?, slope(0.0, 1.0)?);
        let area = by_s[0] * by_p[1] - by_s[1] * by_p[0];
        println!("{row:22} area {:.2e} off", area - 1.0);
        if row == Integrator::RungeKutta4 {
            assert!((area - 1.0).abs() > 1e-6, "{row}: {area}");
        } else {
            assert!((area - 1.0).abs() < 1e-9, "{row}: {area}");
        }
    }
    Ok(())
}

/// A floating tree without gravity with pinned branches. The linear momentum and the angular momentum about
/// the world's origin are constant to rounding; with Runge–Kutta they drift.
#[test]
fn floating_loop_conserves_momenta() -> Tested {
    for seed in 0..6 {
        let shape = RandomRobotOptions {
            joints: 6,
            base: Base::Floating,
            massless: 0.0,
            passive: 0.0,
            mass_ratio: 3.0,
            chain: 1.0,
            ..Default::default()
        };
        let mut robot = random_robot(seed, &shape);
        robot.gravity = [0.0; 3];
        let model = Model::new(robot.clone())?;
        let state = random_state(&model, &mut SplitMix64::new(seed));
        // A frame of the root at the current origin of the last link: a loop through the longest branch.
        let names: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
        let (a, b) = (&names[names.len() - 1], &names[0]);
        let workspace = &mut Workspace::new(&model);
        let mut place = |name: &str| {
            let frame = frame_pose(&model, workspace, &state.q, model.frame(name).expect("a link"));
            let rotation = Matrix3::from_fn(|i, j| frame.rotation[i][j]);
            (rotation, Vector3::from(frame.translation))
        };
        let ((_, there), (rotation, origin)) = (place(a), place(b));
        let at = rotation.transpose() * (there - origin);
        robot.frames.push(FrameDescription::new("meeting", b.clone(), Pose::from_translation(at.into())));
        let model = Model::new(robot)?;
        let (a, b) = (model.frame(a).ok_or("no link")?, model.frame("meeting").ok_or("no frame")?);
        let set = ConstraintSet::new(
            &model,
            [("pin", FrameConstraint::between(a, b, &FrameConstraint::BALL).into())],
        )?;
        let workspace = &mut Workspace::new(&model);
        let mut state = State { q: state.q, v: state.v };
        project_velocity(&model, workspace, &set, &ConstraintOptions::default(), &state.q, &mut state.v)?;
        let mut momenta = |state: &State| {
            let h = centroidal_momentum(&model, workspace, &state.q, &state.v);
            let (linear, angular) = (Vector3::from(h.linear), Vector3::from(h.angular));
            let at = Vector3::from(center_of_mass(&model, workspace, &state.q));
            let about_origin = angular + at.cross(&linear);
            linear.iter().chain(about_origin.iter()).copied().collect::<Vec<f64>>()
        };
        let before = momenta(&state);
        for row in VARIATIONAL {
            let end = advance(&model, &set, &state, 2e-3, 200, row)?;
            let after = momenta(&end);
            let off = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("seed {seed} {row:22} momenta off by {off:.1e}");
            // Momenta of about 10 in 200 steps, each with a dozen roundings of numbers up to a hundred.
            assert!(off < 1e-11, "seed {seed} {row}: {off:e}, {before:?}");
        }
        let after = momenta(&advance(&model, &set, &state, 2e-3, 200, Integrator::RungeKutta4)?);
        let off = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off > 1e-10, "seed {seed}: Runge–Kutta keeps them to {off:e}");
    }
    Ok(())
}

/// A coin of radius r, 1 kg, axle y, that rolls and wobbles on the floor.
fn rolling_coin() -> Result<(Model, ConstraintSet, State), Box<dyn Error>> {
    let r = 0.25;
    let mut robot = RobotDescription::new("coin");
    robot.base = Base::Floating;
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.25, 0.5, 0.25)) * (r * r);
    let body = MassProperties::new(1.0, Vector3::zeros(), inertia)?;
    robot.links.push(LinkDescription::new("coin", body));
    let model = Model::new(robot)?;
    let disc = RollingDisc::on_floor(model.frame("coin").ok_or("no coin")?, [0.0, 1.0, 0.0], r);
    let set = ConstraintSet::new(&model, [("floor", disc.into())])?;
    let options = ConstraintOptions::default();
    let workspace = &mut Workspace::new(&model);
    let mut q = neutral(&model);
    q[2] = 0.3;
    let (s, c) = 0.175f64.sin_cos();
    q[3..].copy_from_slice(&[s, 0.0, 0.0, c]);
    project_position(&model, workspace, &set, &options, 1e-14, &mut q)?;
    let mut v = vec![0.0, 0.0, 0.0, 0.5, 12.0, 1.5];
    project_velocity(&model, workspace, &set, &options, &q, &mut v)?;
    Ok((model, set, State { q, v }))
}

/// Rows without a position, by the discrete Lagrange–d'Alembert principle. A wobbling coin satisfies its
/// rows, has the order of the method, is reversible, and its energy does not drift in a minute.
#[test]
fn rolling_coin_is_reversible_and_keeps_its_rows() -> Tested {
    let (model, set, state) = rolling_coin()?;
    let time = 0.25;
    let reference = advance(&model, &set, &state, time / 4000.0, 4000, Integrator::RungeKutta4)?;
    for row in VARIATIONAL {
        let error = |steps: usize| -> Result<f64, ConstraintError> {
            let end = advance(&model, &set, &state, time / steps as f64, steps, row)?;
            Ok(distance(&model, &end, &reference))
        };
        let (coarse, fine) = (error(100)?, error(200)?);
        let order = (coarse / fine).log2();
        let there = advance(&model, &set, &state, 4e-3, 1, row)?;
        let turned = State { q: there.q, v: there.v.iter().map(|v| -v).collect() };
        let back = advance(&model, &set, &turned, 4e-3, 1, row)?;
        let back = State { q: back.q, v: back.v.iter().map(|v| -v).collect() };
        let off = distance(&model, &back, &state);
        println!("{row:22} errors {coarse:.1e} {fine:.1e} order {order:.2}; reversible to {off:.1e}");
        assert!((order - f64::from(row.order())).abs() < 0.3, "{row}: order {order}");
        // Velocities of 12 rad/s, φ to 1e-16 m over 4 ms.
        assert!(off < 1e-12, "{row}: {off:e}");

        let steps = 15_000;
        let (simulation, run, [first, last]) = energy_errors(&model, &set, &state, row, (4e-3, steps))?;
        assert_eq!(run.steps, steps);
        let record = simulation.constraint_record().ok_or("no record")?;
        println!("{row:22} energy error {first:.2e} J first, {last:.2e} J last, {:?}", record.drift);
        assert!(record.drift.position < 1e-13 && record.drift.velocity < 1e-12, "{:?}", record.drift);
        assert!(last < 1.5 * first, "{row}: {first:e} {last:e}");
    }
    Ok(())
}

/// A pin of the planar linkage written as a hinge in space. Its three rows of zeros are left out, or are an
/// error that names them.
#[test]
fn dependent_rows_are_dropped_or_errors() -> Tested {
    let (model, _, state) = four_bar()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let hinge = LoopClosure { rows: FrameConstraint::HINGE.to_vec(), ..loops[0].clone() };
    let hinge = ConstraintSet::from_loops(&model, &[hinge])?;
    let plane = ConstraintSet::from_loops(&model, &loops)?;
    let found = advance(&model, &hinge, &state, 2e-3, 100, VARIATIONAL[0])?;
    let expected = advance(&model, &plane, &state, 2e-3, 100, VARIATIONAL[0])?;
    let off = distance(&model, &found, &expected);
    // Rounding, amplified by the motion over 0.2 s.
    assert!(off < 1e-10, "{off:e}");
    let refuse = ConstraintOptions { redundant: RedundantRows::Refuse, ..options(VARIATIONAL[0]) };
    let forces = StepForces::new(&[0.0; 3], false);
    let (mut q, mut v) = (state.q.clone(), state.v.clone());
    let workspace = &mut Workspace::new(&model);
    let none = DriftCorrection::None;
    let error = constrained_step(
        &model,
        workspace,
        StepConstraints { set: &hinge, options: &refuse, correction: none },
        &forces,
        1e-3,
        &mut q,
        &mut v,
    )
    .expect_err("dependent rows");
    let ConstraintError::DependentRows { rows, .. } = &error else { panic!("{error}") };
    assert!(rows[0].name == "pin.z" && rows[0].combination_of.is_empty(), "{error}");
    assert!(q == state.q && v == state.v, "{q:?} {v:?}");
    Ok(())
}

/// Errors of feedback, which would counteract the multipliers, and of a step that is too long.
#[test]
fn invalid_steps_are_errors() -> Tested {
    let (model, set, state) = four_bar()?;
    let attempt = |options: ConstraintOptions, h: f64| {
        let mut simulation = SimulationBuilder::new(&model)
            .method(Method::Fixed(options.integrator))
            .constraints(set.clone())
            .dt(h)
            .without(Effect::Dissipation)
            .constraint_options(options, DriftCorrection::None)
            .build()
            .unwrap();
        let run = simulation.run_steps_from(&state.q, &state.v, 200, RunOptions::new().sample_ends());
        run.expect_err("an invalid step").error
    };
    let fed_back =
        ConstraintOptions { stabilization: Some(Baumgarte { rate: 10.0 }), ..options(VARIATIONAL[0]) };
    let error = attempt(fed_back, 1e-3);
    let RunError::Step { source: StepError::Constraint(source), .. } = &error else { panic!("{error}") };
    assert_eq!(*source, ConstraintError::StabilizedVariationalStep);
    let error = attempt(options(VARIATIONAL[0]), 2.0);
    let RunError::Step { step: 0, source: StepError::Constraint(source), .. } = &error else {
        panic!("{error}")
    };
    let ConstraintError::StepNotConverged { step: 2.0, name, .. } = source else { panic!("{error}") };
    assert!(name.starts_with("pin."), "{error}");
    Ok(())
}
