//! Constrained motions against derivations by hand: pendulum, knife edge, four-bar linkage, rolling disc,
//! robot on wheels.

use std::error::Error;

use dynamics::{KnifeEdge, PlanarBody};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, matrix, vector};
use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::constraints::{
    Baumgarte, ConstrainedStepReport, ConstraintDrift, ConstraintError, ConstraintOptions, ConstraintSet,
    DriftCorrection, FrameConstraint, LoopClosure, NoSlip, Plane, RedundantRows, RollingDisc, RollingRow,
    StepConstraints, constrained_forward_dynamics, constrained_inverse_dynamics, constrained_step,
    constraint_drift, project_position, project_velocity,
};
use robot_dynamics::description::{
    Base, FrameDescription, JointDescription, JointKind, LinkDescription, MassProperties, Pose,
    RobotDescription,
};
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Effect, Method, RunError, RunOptions, SimulationBuilder, StepError, StepForces,
};
use robot_dynamics::{Classified, ErrorKind, InputProblem};

use crate::closed_loop::{GROUND, LENGTHS, MASSES, PIN, linkage, start};

type Tested = Result<(), Box<dyn Error>>;

/// A planar body of mass m and inertia i in the x-y plane with gravity along −y, and a frame `tip` at (l, 0).
fn planar_body(m: f64, i: f64, l: f64, gravity: f64) -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("plate");
    robot.gravity = [0.0, -gravity, 0.0];
    let body = MassProperties::new(m, Vector3::zeros(), Matrix3::from_diagonal_element(i))?;
    robot.links.push(LinkDescription::new("table", None));
    robot.links.push(LinkDescription::new("plate", body));
    let kind = JointKind::Planar { normal: [0.0, 0.0, 1.0] };
    robot.joints.push(JointDescription::new("plane", kind, "table", "plate", Pose::IDENTITY));
    robot.frames.push(FrameDescription::new("tip", "plate", Pose::from_translation([l, 0.0, 0.0])));
    Ok(Model::new(robot)?)
}

/// A pendulum as a free plate with one fixed point: θ̈ = −m g l sin φ/(I + m l²), and the pivot carries
/// m(p̈ − g).
///
/// The centre is at l (sin φ, −cos φ) from the pivot. Tolerance 1e-12: a dozen roundings of numbers below
/// 100.
#[test]
fn pendulum_as_constraint() -> Tested {
    let (m, i, l, g) = (2.0, 0.3, 0.5, 9.81);
    let model = planar_body(m, i, l, g)?;
    let tip = model.frame("tip").ok_or("no tip")?;
    let hold = FrameConstraint {
        rows: FrameConstraint::BALL[..2].to_vec(),
        ..FrameConstraint::point_contact(tip, [0.0; 3])
    };
    let set = ConstraintSet::new(&model, [("pivot", hold.into())])?;
    for (phi, rate) in [(0.0, 0.0f64), (0.7, -1.3), (-2.0, 3.0), (3.0, 0.5)] {
        let (s, c) = f64::sin_cos(phi);
        // At φ = 0 the tip points up from the centre: θ = φ + π/2.
        let q = [l * s, -l * c, phi + std::f64::consts::FRAC_PI_2];
        let v = [l * c * rate, l * s * rate, rate];
        let options = ConstraintOptions::default();
        let motion = constrained_forward_dynamics(
            &model,
            &mut Workspace::new(&model),
            &set,
            &options,
            &q,
            &v,
            &[0.0; 3],
        )?;
        let angular = -m * g * l * s / (i + m * l * l);
        let acceleration = vector![c * angular - s * rate * rate, s * angular + c * rate * rate] * l;
        let reaction = (acceleration + vector![0.0, g]) * m;
        assert!((motion.acceleration[2] - angular).abs() < 1e-12, "φ = {phi}: {motion:?}, {angular}");
        assert!((motion.acceleration.rows(0, 2) - acceleration).amax() < 1e-12, "φ = {phi}");
        assert!(
            (motion.multipliers.rows(0, 2) - reaction).amax() < 1e-12,
            "φ = {phi}: {motion:?} {reaction}"
        );
    }
    Ok(())
}

/// The knife edge of the chapter: row y of the frame is −A of [`KnifeEdge`], so λ changes sign.
#[test]
fn knife_edge_matches_chapter() -> Tested {
    let (m, i_zz, slope) = (2.0, 0.5, 1.5);
    let model = planar_body(m, i_zz, 0.3, slope)?;
    let plate = model.frame("plate").ok_or("no plate")?;
    let set = ConstraintSet::new(&model, [("blade", NoSlip::sideways(plate).into())])?;
    let closed = KnifeEdge { body: PlanarBody { m, i_zz, a_g: slope } };
    let random = &mut SplitMix64::new(5);
    for state in 0..30 {
        let q = SVector::<f64, 3>::from_fn(|_, _| random.uniform(-3.0, 3.0));
        let qd = KnifeEdge::velocity(&q, random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0));
        let u = SVector::<f64, 3>::from_fn(|_, _| random.uniform(-10.0, 10.0));
        let options = ConstraintOptions::default();
        let w = &mut Workspace::new(&model);
        let (q, qd, u) = (&q, &qd, &u);
        let motion = constrained_forward_dynamics(
            &model,
            w,
            &set,
            &options,
            q.as_slice(),
            qd.as_slice(),
            u.as_slice(),
        )?;
        let expected = closed.acceleration(q, qd, u);
        // A dozen roundings of numbers below 100.
        assert!((motion.acceleration.rows(0, 3) - expected).amax() < 1e-12, "state {state}");
        assert!((motion.multipliers[0] + closed.side_force(q, qd, u)).abs() < 1e-12, "state {state}");
    }
    Ok(())
}

/// The linkage by Newton and Euler, body by body: nine accelerations and the forces at four pins.
///
/// The unknowns are (ẍ, ÿ, θ̈) of crank, coupler and rocker, and the forces on the outer body at the pins
/// ground–crank, crank–coupler, ground–rocker, coupler–rocker. Returns θ̈ and the force on the rocker at the
/// last pin.
fn newton_euler(angles: [f64; 3], rates: [f64; 3]) -> ([f64; 3], [f64; 2]) {
    let mut matrix = SMatrix::<f64, 17, 17>::zeros();
    let mut right = SVector::<f64, 17>::zeros();
    let half = |i: usize, side: f64| vector![angles[i].cos(), angles[i].sin()] * (side * LENGTHS[i] / 2.0);
    // (pin, body of the point, end of the body, sign of the force on it)
    let pins = [
        (0, 0, -1.0, 1.0),
        (1, 0, 1.0, -1.0),
        (1, 1, -1.0, 1.0),
        (2, 2, -1.0, 1.0),
        (3, 1, 1.0, -1.0),
        (3, 2, 1.0, 1.0),
    ];
    for i in 0..3 {
        let inertia = MASSES[i] * LENGTHS[i] * LENGTHS[i] / 12.0;
        for (k, m) in [MASSES[i], MASSES[i], inertia].into_iter().enumerate() {
            matrix[(3 * i + k, 3 * i + k)] = m;
        }
        right[3 * i + 1] = -9.81 * MASSES[i];
    }
    for (pin, i, side, sign) in pins {
        let (r, column, row) = (half(i, side), 9 + 2 * pin, 9 + 2 * pin);
        for k in 0..2 {
            matrix[(3 * i + k, column + k)] -= sign;
            // The acceleration of the point at the pin: p̈ + θ̈ × r − θ̇² r, equal on both sides.
            matrix[(row + k, 3 * i + k)] += sign;
            right[row + k] += sign * rates[i] * rates[i] * r[k];
        }
        matrix[(3 * i + 2, column)] += sign * r[1];
        matrix[(3 * i + 2, column + 1)] -= sign * r[0];
        matrix[(row, 3 * i + 2)] -= sign * r[1];
        matrix[(row + 1, 3 * i + 2)] += sign * r[0];
    }
    let x = matrix.full_piv_lu().solve(&right).expect("a movable linkage");
    ([x[2], x[5], x[8]], [x[15], x[16]])
}

#[test]
fn four_bar_matches_newton_and_euler() -> Tested {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let w = &mut Workspace::new(&model);
    let (mut q, mut v) = start(&model, &set)?;
    let options = ConstraintOptions::default();
    let forces = StepForces::new(&[0.0; 3], false);
    let correction = DriftCorrection::Position { tolerance: 1e-13 };
    for state in 0..50 {
        let motion = constrained_forward_dynamics(&model, w, &set, &options, &q, &v, &[0.0; 3])?;
        let angles = [q[0], q[0] + q[1], q[2]];
        let (angular, on_rocker) = newton_euler(angles, [v[0], v[0] + v[1], v[2]]);
        let a = &motion.acceleration;
        let found = [a[0], a[0] + a[1], a[2]];
        let (s, c) = angles[1].sin_cos();
        let lambda = &motion.multipliers;
        let force = [c * lambda[0] - s * lambda[1], s * lambda[0] + c * lambda[1]];
        for (found, expected) in found.iter().chain(&force).zip(angular.iter().chain(&on_rocker)) {
            // κ of the 17 equations is about 1e4.
            let off = (found - expected).abs();
            assert!(
                off < 1e-10 * (1.0 + expected.abs()),
                "state {state}: {found} {expected}, q {q:?}, v {v:?}"
            );
        }
        for _ in 0..20 {
            constrained_step(
                &model,
                w,
                StepConstraints { set: &set, options: &options, correction },
                &forces,
                1e-3,
                &mut q,
                &mut v,
            )?;
        }
    }
    Ok(())
}

/// The numbers that the example prints: the energy account of ten seconds.
#[test]
fn four_bar_keeps_its_energy() -> Tested {
    let numbers = crate::closed_loop::numbers()?;
    println!("drift {:e}, gap {:?}, {} turns", numbers.energy_drift, numbers.gap, numbers.turns);
    assert!(numbers.energy_drift < 1e-8, "{}", numbers.energy_drift);
    assert!(numbers.gap.position <= 1e-12 && numbers.gap.velocity < 1e-12, "{:?}", numbers.gap);
    assert!(numbers.turns > 3.0, "{}", numbers.turns);
    Ok(())
}

/// A planar pin written as a hinge in space adds three rows of zeros. The motion is unchanged, their λ are 0,
/// and they are named.
#[test]
fn hinge_of_planar_linkage_is_redundant() -> Tested {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let plane = ConstraintSet::from_loops(&model, &loops)?;
    let hinge = LoopClosure { rows: FrameConstraint::HINGE.to_vec(), ..loops[0].clone() };
    let hinge = ConstraintSet::from_loops(&model, &[hinge])?;
    let w = &mut Workspace::new(&model);
    let (q, v) = start(&model, &plane)?;
    for redundant in [RedundantRows::Drop, RedundantRows::Proximal { damping: 1e-6 }] {
        let options = ConstraintOptions { redundant, ..Default::default() };
        let expected = constrained_forward_dynamics(&model, w, &plane, &options, &q, &v, &[0.0; 3])?;
        let found = constrained_forward_dynamics(&model, w, &hinge, &options, &q, &v, &[0.0; 3])?;
        assert_eq!(found.rank, 2);
        let names: Vec<&str> = found.dependent.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["pin.z", "pin.rx", "pin.ry"]);
        assert!(found.dependent.iter().all(|row| row.combination_of.is_empty()));
        assert!((found.acceleration - expected.acceleration).amax() < 1e-10);
        assert!((found.multipliers.rows(0, 2) - expected.multipliers.rows(0, 2)).amax() < 1e-7);
        assert_eq!(found.multipliers.rows(2, 3).amax(), 0.0);
    }
    let options = ConstraintOptions { redundant: RedundantRows::Refuse, ..Default::default() };
    let error = constrained_forward_dynamics(&model, w, &hinge, &options, &q, &v, &[0.0; 3]).unwrap_err();
    let ConstraintError::DependentRows { rank: 2, rows } = &error else { panic!("{error}") };
    let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["pin.z", "pin.rx", "pin.ry"]);
    Ok(())
}

/// With a motor only at the crank, inverse dynamics returns the torque and the pin force of the motion.
#[test]
fn inverse_dynamics_returns_crank_torque() -> Tested {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let w = &mut Workspace::new(&model);
    let (q, v) = start(&model, &set)?;
    let options = ConstraintOptions::default();
    let motion = constrained_forward_dynamics(&model, w, &set, &options, &q, &v, &[7.0, 0.0, 0.0])?;
    let a = motion.acceleration.as_slice();
    let found = constrained_inverse_dynamics(&model, w, &set, &q, &v, a, &[true, false, false])?;
    // κ(A) is below 100 here.
    assert!((found.tau[0] - 7.0).abs() < 1e-11, "{found:?}");
    assert!((&found.multipliers - &motion.multipliers).amax() < 1e-11, "{found:?} {motion:?}");
    assert!(found.residual < 1e-11);
    // Without a motor this motion is impossible.
    let none = constrained_inverse_dynamics(&model, w, &set, &q, &v, a, &[false; 3])?;
    assert!(none.residual > 1.0, "{none:?}");
    Ok(())
}

/// Drift over ten seconds: it grows without correction, stays bounded with Baumgarte's feedback, and vanishes
/// with projection.
#[test]
fn drift_is_corrected_by_feedback_and_projection() -> Tested {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let (q, v) = start(&model, &set)?;
    let run = |correction, stabilization| -> Result<ConstraintDrift, Box<dyn Error>> {
        let options = ConstraintOptions { stabilization, ..Default::default() };
        let mut simulation = SimulationBuilder::new(&model)
            .method(Method::Fixed(options.integrator))
            .constraints(set.clone())
            .dt(5e-3)
            .without(Effect::Dissipation)
            .constraint_options(options, correction)
            .build()
            .unwrap();
        simulation.run_steps_from(&q, &v, 2000, RunOptions::new().sample_ends())?;
        simulation.constraint_record().map(|record| record.drift).ok_or_else(|| "no record".into())
    };
    let free = run(DriftCorrection::None, None)?;
    let pulled = run(DriftCorrection::None, Some(Baumgarte { rate: 50.0 }))?;
    let velocity = run(DriftCorrection::Velocity, None)?;
    let position = run(DriftCorrection::Position { tolerance: 1e-12 }, None)?;
    println!("none {free:?}\nBaumgarte {pulled:?}\nvelocity {velocity:?}\nposition {position:?}");
    assert!(free.position > 10.0 * pulled.position, "{free:?} {pulled:?}");
    assert!(velocity.velocity < 1e-12 && velocity.position < free.position, "{velocity:?}");
    assert!(position.position <= 1e-12 && position.velocity < 1e-12, "{position:?}");
    Ok(())
}

/// A controller that fails, or whose torque is not finite, ends the run with the time, the cause and the
/// joint. The steps before it are kept.
#[test]
fn failing_controller_ends_constrained_run() -> Tested {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let (q, v) = start(&model, &set)?;
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(ConstraintOptions::default().integrator))
        .constraints(set.clone())
        .dt(1e-3)
        .without(Effect::Dissipation)
        .constraint_options(ConstraintOptions::default(), DriftCorrection::Position { tolerance: 1e-12 })
        .build()
        .unwrap();
    let mut stop = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau.fill(0.0);
        if t < 0.0195 { Ok(()) } else { Err("the brake is on") }
    };
    let failure = simulation
        .run_steps_from(&q, &v, 100, RunOptions::new().sample_ends().controller(&mut stop))
        .unwrap_err();
    let RunError::Controller { step: 20, time, source } = &failure.error else { panic!("{failure}") };
    assert!((time - 0.02).abs() < 1e-15 && source.to_string() == "the brake is on", "{failure}");
    assert!(failure.until.steps == 20 && failure.until.q != q, "{:?}", failure.until);
    assert!(failure.until.q.iter().chain(&failure.until.v).all(|x| x.is_finite()));
    let record = simulation.constraint_record().ok_or("no record")?;
    assert!(record.drift.position <= 1e-12 && failure.until.energy_account.kinetic() > 0.0);

    let mut broken = |t: f64, _: &[f64], _: &[f64], tau: &mut [f64]| {
        tau.fill(0.0);
        tau[1] = if t < 0.0015 { 0.0 } else { f64::NEG_INFINITY };
    };
    let failure = simulation
        .run_steps_from(&q, &v, 100, RunOptions::new().sample_ends().controller(&mut broken))
        .unwrap_err();
    let RunError::StepInput { step: 2, source, .. } = &failure.error else { panic!("{failure}") };
    let InputProblem::NotFinite { index: Some(1), coordinate, .. } = &source.problem else {
        panic!("{failure}")
    };
    assert_eq!(coordinate.as_ref(), Some(&model.coordinate_names()[1]));
    assert_eq!(failure.until.steps, 2);
    Ok(())
}

/// A start off the constraint is an error that names the row.
#[test]
fn start_off_constraint_is_an_error() -> Tested {
    let model = linkage()?;
    let loops: Vec<LoopClosure> = serde_json::from_str(PIN)?;
    let set = ConstraintSet::from_loops(&model, &loops)?;
    let error = SimulationBuilder::new(&model)
        .method(Method::Fixed(ConstraintOptions::default().integrator))
        .constraints(set.clone())
        .dt(1e-3)
        .without(Effect::Dissipation)
        .constraint_options(ConstraintOptions::default(), DriftCorrection::Velocity)
        .build()
        .unwrap()
        .run_steps_from(&[0.0; 3], &[0.0; 3], 1, RunOptions::new().sample_ends())
        .unwrap_err();
    let RunError::Step { source: StepError::Constraint(source), .. } = &error.error else {
        panic!("{error}")
    };
    let ConstraintError::OffConstraint { quantity: "the position error", name, .. } = source else {
        panic!("{error}")
    };
    assert_eq!(name, "pin.x");
    // For a linkage that cannot be assembled the error names a row, and q is unchanged.
    let far = FrameConstraint::point_contact(model.frame("rocker_end").ok_or("no frame")?, [5.0, 0.0, 0.0]);
    let set = ConstraintSet::new(&model, [("nail", far.into())])?;
    let mut q = [0.3, 0.4, 0.5];
    let w = &mut Workspace::new(&model);
    let error = project_position(&model, w, &set, &ConstraintOptions::default(), 1e-9, &mut q).unwrap_err();
    let ConstraintError::NotConverged { name, .. } = &error else { panic!("{error}") };
    assert!(name == "nail.x" && q == [0.3, 0.4, 0.5], "{error}");
    let wrong = LoopClosure { frame_a: "elbow".into(), ..loops[0].clone() };
    let error = ConstraintSet::from_loops(&model, &[wrong]).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::UnknownName);
    assert!(error.to_string().starts_with("constraint `pin`: robot `four_bar` has no link or frame `elbow`"));
    assert_eq!(GROUND, 0.9);
    Ok(())
}

/// A coin of radius r: 1 kg, axle y.
fn coin(r: f64) -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("coin");
    robot.base = Base::Floating;
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.25, 0.5, 0.25)) * (r * r);
    let body = MassProperties::new(1.0, Vector3::zeros(), inertia)?;
    robot.links.push(LinkDescription::new("coin", body));
    Ok(Model::new(robot)?)
}

/// A tilted coin on the floor with this roll, and a velocity that rolls.
fn rolling_start(
    model: &Model,
    set: &ConstraintSet,
    roll: f64,
    spin: [f64; 3],
) -> Result<(Vec<f64>, Vec<f64>), Box<dyn Error>> {
    let w = &mut Workspace::new(model);
    let options = ConstraintOptions::default();
    let mut q = neutral(model);
    q[2] = 0.3;
    let (s, c) = (roll / 2.0).sin_cos();
    q[3..].copy_from_slice(&[s, 0.0, 0.0, c]);
    project_position(model, w, set, &options, 1e-14, &mut q)?;
    let mut v = vec![0.0, 0.0, 0.0, spin[0], spin[1], spin[2]];
    project_velocity(model, w, set, &options, &q, &mut v)?;
    Ok((q, v))
}

/// The coin by Newton and Euler about its centre: I ω̇ + ω × Iω = −r u × F, F = m(p̈ − g), p̈ = r
/// d(ω × u)/dt.
///
/// u̇ comes from central differences along ṡ = ω × s, accurate to 1e-9 of the rates.
#[test]
fn rolling_coin_matches_newton_and_euler() -> Tested {
    let r = 0.25;
    let model = coin(r)?;
    let frame = model.frame("coin").ok_or("no coin")?;
    let disc = RollingDisc::on_floor(frame, [0.0, 1.0, 0.0], r);
    let set = ConstraintSet::new(&model, [("floor", disc.into())])?;
    let w = &mut Workspace::new(&model);
    let options = ConstraintOptions::default();
    let random = &mut SplitMix64::new(11);
    for state in 0..20 {
        let spin = [random.uniform(-2.0, 2.0), random.uniform(-9.0, 9.0), random.uniform(-3.0, 3.0)];
        let (q, v) = rolling_start(&model, &set, random.uniform(-1.0, 1.0), spin)?;
        let motion = constrained_forward_dynamics(&model, w, &set, &options, &q, &v, &[0.0; 6])?;

        let place = frame_pose(&model, w, &q, frame);
        let rotation = Matrix3::from_fn(|i, j| place.rotation[i][j]);
        let omega = rotation * Vector3::new(v[3], v[4], v[5]);
        let s: Vector3<f64> = rotation.column(1).into();
        let up = |s: Vector3<f64>| (Vector3::z() - s * s.z).normalize();
        let t = 1e-5;
        let s_rate = omega.cross(&s);
        let turned = |t: f64| (s * (1.0 - 0.5 * t * t * s_rate.norm_squared()) + s_rate * t).normalize();
        let u_rate = (up(turned(t)) - up(turned(-t))) / (2.0 * t);
        let u = up(s);
        let inertia = rotation
            * Matrix3::from_diagonal(&Vector3::new(0.25, 0.5, 0.25))
            * rotation.transpose()
            * (r * r);
        // (I + r² [u]×[u]×ᵀ) ω̇ = −ω × Iω − r u × (r ω × u̇ − g)
        let cross = u.cross_matrix();
        let left = inertia + cross * cross.transpose() * (r * r);
        let known = omega.cross(&u_rate) * r + Vector3::z() * 9.81;
        let right = -omega.cross(&(inertia * omega)) - u.cross(&known) * r;
        let omega_rate = left.lu().solve(&right).ok_or("singular")?;
        let force = omega_rate.cross(&u) * r + known;

        let found =
            rotation * Vector3::new(motion.acceleration[3], motion.acceleration[4], motion.acceleration[5]);
        assert!((found - omega_rate).amax() < 1e-6, "state {state}: {found} {omega_rate}");
        let h = s.cross(&Vector3::z()).normalize();
        let side = Vector3::z().cross(&h);
        let expected = vector![force.dot(&h), force.dot(&side), force.z];
        assert!(
            (motion.multipliers.rows(0, 3) - expected).amax() < 1e-6,
            "state {state}: {motion:?} {expected}"
        );
    }
    Ok(())
}

/// A wobbling coin rolls for a minute: the slip stays below 1e-10, and the energy is constant.
#[test]
fn coin_rolls_for_a_minute() -> Tested {
    let r = 0.25;
    let model = coin(r)?;
    let disc = RollingDisc::on_floor(model.frame("coin").ok_or("no coin")?, [0.0, 1.0, 0.0], r);
    let set = ConstraintSet::new(&model, [("floor", disc.into())])?;
    let (q, v) = rolling_start(&model, &set, 0.35, [0.5, 12.0, 1.5])?;
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(ConstraintOptions::default().integrator))
        .constraints(set.clone())
        .dt(2e-3)
        .without(Effect::Dissipation)
        .constraint_options(ConstraintOptions::default(), DriftCorrection::Position { tolerance: 1e-12 })
        .build()
        .unwrap();
    let run = simulation.run_steps_from(&q, &v, 30_000, RunOptions::new().sample_ends())?;
    let record = simulation.constraint_record().ok_or("no record")?;
    println!("{:?}, per step {:?}, energy {:e}", record.drift, record.step_drift, run.energy_account.drift());
    assert_eq!((run.steps, record.smallest_rank), (30_000, 3));
    assert!(record.drift.velocity < 1e-10, "{:?}", record.drift);
    assert!(record.drift.position <= 1e-12, "{:?}", record.drift);
    // Order 4 at 2 ms and 12 rad/s: (0.024)⁴ = 3e-7 a radian for an error constant of one; bounded, not
    // exact.
    assert!(run.energy_account.drift() < 1e-6, "{}", run.energy_account.drift());
    Ok(())
}

/// A cart with two driven wheels on a planar base. Its wheels roll for a minute, and the side row of the
/// second wheel is redundant.
#[test]
fn cart_on_wheels_rolls_for_a_minute() -> Tested {
    let (radius, half_track) = (0.1, 0.2);
    let mut robot = RobotDescription::new("cart");
    robot.links.push(LinkDescription::new("floor", None));
    let chassis = MassProperties::solid_box(500.0, Vector3::new(0.4, 0.3, 0.1))?;
    robot.links.push(LinkDescription::new("chassis", chassis));
    let base = JointKind::Planar { normal: [0.0, 0.0, 1.0] };
    let at = Pose::from_translation([0.0, 0.0, radius]);
    robot.joints.push(JointDescription::new("base", base, "floor", "chassis", at));
    for (name, y) in [("left", half_track), ("right", -half_track)] {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.25, 0.5, 0.25)) * (2.0 * radius * radius);
        let wheel = MassProperties::new(2.0, Vector3::zeros(), inertia)?;
        robot.links.push(LinkDescription::new(name, wheel));
        let axle = JointKind::Continuous { axis: [0.0, 1.0, 0.0] };
        let at = Pose::from_translation([0.0, y, 0.0]);
        robot.joints.push(JointDescription::new(format!("{name}_axle"), axle, "chassis", name, at));
    }
    let model = Model::new(robot)?;
    let wheel = |name: &str| {
        let rows = vec![RollingRow::Forward, RollingRow::Side];
        let frame = model.frame(name).expect("a wheel");
        RollingDisc { frame, axle: [0.0, 1.0, 0.0], radius, plane: Plane::level(0.0), rows }
    };
    let set = ConstraintSet::new(&model, [("left", wheel("left").into()), ("right", wheel("right").into())])?;
    let w = &mut Workspace::new(&model);
    let (mut q, mut v) = (vec![0.0; 5], vec![0.0; 5]);
    let options = ConstraintOptions::default();
    let (mut worst, mut report) = (0.0f64, None::<ConstrainedStepReport>);
    for step in 0..30_000 {
        let time = f64::from(step) * 2e-3;
        // Motors against a drag, which bounds the speed.
        let drive = [0.6 * (0.7 * time).sin(), 0.5 * (0.9 * time).cos()];
        let tau = [0.0, 0.0, 0.0, drive[0] - 0.05 * v[3], drive[1] - 0.05 * v[4]];
        let forces = StepForces::new(&tau, false);
        let done = constrained_step(
            &model,
            w,
            StepConstraints { set: &set, options: &options, correction: DriftCorrection::Velocity },
            &forces,
            2e-3,
            &mut q,
            &mut v,
        )?;
        worst = worst.max(done.corrected.velocity);
        report = Some(done);
    }
    println!("slip {worst:e}, {report:?}, q {q:?}");
    assert!(worst < 1e-10, "{worst}");
    assert_eq!(report.map(|report| report.rank), Some(3));
    assert!(constraint_drift(&model, w, &set, &q, &v).velocity < 1e-10);
    // θ follows from the angles of the wheels: θ = r (φ_right − φ_left)/(2 w), a holonomic consequence of the
    // rows.
    let heading = radius * (q[4] - q[3]) / (2.0 * half_track);
    assert!((heading - q[2]).abs() < 1e-9, "{heading} {}", q[2]);
    assert!(matrix![v[3], v[4]].amax() > 0.1, "the cart moves");
    let motion = constrained_forward_dynamics(&model, w, &set, &options, &q, &v, &[0.0; 5])?;
    assert_eq!(motion.dependent[0].name, "right.side");
    assert!(motion.dependent[0].combination_of.contains(&"left.side".to_owned()));
    Ok(())
}
