//! Operational-space dynamics against forces and accelerations at a frame, and the controllers that use it.

use std::error::Error;
use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_dynamics::InputProblem;
use robot_dynamics::algorithms::{
    MotionError, ReferenceFrame, SpatialAcceleration, Twist, bias, forward_dynamics, frame_acceleration,
    frame_pose, frame_velocity,
};
use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::{
    ComputedTorque, OperationalSpace, OperationalSpaceInputs, OperationalSpaceWorkspace, PoseReference,
    Reference, TaskControl, TaskGains, TaskReference, operational_space, operational_space_into,
};
use robot_dynamics::description::{
    JointDescription, JointKind, JointKinds, LinkDescription, Pose, Quaternion, RandomRobotOptions,
    RobotDescription, random_robot,
};
use robot_dynamics::model::{Model, Workspace, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Controller, ControllerError, Effect, Integrator, Method, RunError, RunOptions, Simulation,
    SimulationBuilder,
};

use crate::common::{Family, families};

type Tested = Result<(), Box<dyn Error>>;

const ROWS: [SpatialAxis; 6] =
    [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z, SpatialAxis::Rx, SpatialAxis::Ry, SpatialAxis::Rz];

/// On random trees the requested acceleration results from its torque, and torques of the null space do not
/// accelerate the frame. J J̄ = 1, and Λ is the inverse of the response to unit forces.
#[test]
fn operational_space_laws_on_random_trees() {
    let mut tested = 0;
    for robot in families().iter().flat_map(|family: &Family| family.robots().take(12)) {
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        let (q, v) = (&robot.state.q[..], &robot.state.v[..]);
        let random = &mut SplitMix64::new(robot.seed);
        let frame = model.frames().last().and_then(|frame| model.frame(&frame.name)).expect("a frame");
        let rows: Vec<SpatialAxis> =
            ROWS.into_iter().filter(|_| random.uniform(0.0, 1.0) < 0.4).take(model.nv()).collect();
        if rows.is_empty() {
            continue;
        }
        let Ok(space) = operational_space(model, w, q, v, frame, &rows) else { continue };
        let eigen = space.inertia.clone().symmetric_eigenvalues();
        let condition = robot.condition() * eigen.max() / eigen.min();
        if condition > 1e8 {
            continue;
        }
        tested += 1;
        let rounding = 1e3 * condition * f64::EPSILON;
        let pick = |rate: SpatialAcceleration| {
            let all = [rate.linear, rate.angular].concat();
            DVector::from_iterator(rows.len(), rows.iter().map(|row| all[*row as usize]))
        };
        let accelerate = |w: &mut Workspace, tau: &[f64]| {
            let mut a = vec![0.0; model.nv()];
            forward_dynamics(model, w, q, v, tau, &mut a);
            let size = a.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
            (pick(frame_acceleration(model, w, q, v, &a, frame, ReferenceFrame::LocalWorldAligned)), size)
        };
        let wanted = DVector::from_fn(rows.len(), |_, _| random.uniform(-3.0, 3.0));
        let tau = space.torque(wanted.as_slice()).unwrap();
        let (found, size) = accelerate(w, tau.as_slice());
        let scale = 1.0 + size + space.bias_acceleration.amax();
        robot.require("ẍ", (&found - &wanted).amax(), rounding * scale);
        let more = &tau + space.null_torque(&robot.state.tau).unwrap();
        let (again, size) = accelerate(w, more.as_slice());
        robot.require("null space", (&again - &wanted).amax(), rounding * (scale + size));
        let mut both = vec![0.0; model.nv()];
        space.torque_with_posture(wanted.as_slice(), &robot.state.tau, &mut both).unwrap();
        let (again, size) = accelerate(w, &both);
        robot.require("ẍ beside a posture", (&again - &wanted).amax(), rounding * (scale + size));
        let sum = (DVector::from_vec(both) - &more).amax();
        robot.require(
            "τ = JᵀF + (1 − JᵀJ̄ᵀ) τ₀",
            sum,
            rounding * (1.0 + more.amax() + robot.state.tau[0].abs()),
        );
        let one = &space.jacobian * &space.consistent_inverse - DMatrix::identity(rows.len(), rows.len());
        robot.require("J J̄ = 1", one.amax(), rounding * (1.0 + space.consistent_inverse.amax()));
        // Column k of Λ⁻¹ is the acceleration of the frame that the force Jᵀe_k adds.
        for k in 0..rows.len() {
            let push = space.jacobian.row(k).transpose();
            let (pushed, size) = accelerate(w, (&tau + &push).as_slice());
            let force = &space.inertia * (pushed - &found);
            let unit = DVector::from_fn(rows.len(), |i, _| f64::from(u8::from(i == k)));
            robot.require("Λ", (force - unit).amax(), rounding * (1.0 + eigen.max() * (scale + size)));
        }
    }
    assert!(tested > 60, "{tested}");
}

fn arm() -> Result<Model, Box<dyn Error>> {
    let options = RandomRobotOptions {
        joints: 6,
        chain: 1.0,
        kinds: JointKinds::Turning,
        passive: 0.0,
        massless: 0.0,
        ..RandomRobotOptions::default()
    };
    Ok(Model::new(random_robot(4, &options))?)
}

/// Computed torque: the error of every joint obeys ë + 2k ė + k² e = 0, e(t) = (e₀ + (ė₀ + k e₀) t) e^(−kt).
///
/// The torque is held over each step of h, a mean delay of ½h, so that the error is off by O(h).
#[test]
fn computed_torque_has_linear_errors() -> Tested {
    let model = arm()?;
    let nv = model.nv();
    let reference = |t: f64| {
        let each = |f: &dyn Fn(f64) -> f64| (0..nv).map(|k| f(k as f64)).collect::<Vec<f64>>();
        Reference { q: each(&|k| (t + k).sin()), v: each(&|k| (t + k).cos()), a: each(&|k| -(t + k).sin()) }
    };
    let (rate, time) = (6.0, 0.5);
    let start = reference(0.0);
    let q: Vec<f64> = start.q.iter().map(|q| q - 0.2).collect();
    let mut off = Vec::new();
    for steps in [500, 2000] {
        let h = time / steps as f64;
        let mut control =
            ComputedTorque::new(&model, reference, &vec![rate * rate; nv], &vec![2.0 * rate; nv])?;
        let mut simulation = SimulationBuilder::new(&model)
            .method(Method::Fixed(Integrator::RungeKutta4))
            .dt(h)
            .without(Effect::Dissipation)
            .without(Effect::EffortLimits)
            .build()
            .unwrap();
        let run = simulation.run_steps_from(
            &q,
            &start.v,
            steps,
            RunOptions::new().sample_ends().controller(&mut control),
        )?;
        let expected = 0.2 * (1.0 + rate * time) * f64::exp(-rate * time);
        let end = reference(time);
        let worst = (0..nv).map(|k| (end.q[k] - run.q[k] - expected).abs()).fold(0.0, f64::max);
        off.push(worst);
    }
    println!("{off:?}");
    assert!(off[0] < 2e-3 && off[1] < 0.3 * off[0], "{off:?}");
    Ok(())
}

/// A frame's position converges to its target by the same law.
#[test]
fn task_control_has_linear_errors() -> Tested {
    let model = arm()?;
    let frame = model.frames().last().and_then(|frame| model.frame(&frame.name)).ok_or("no frame")?;
    let w = &mut Workspace::new(&model);
    let q = random_state(&model, &mut SplitMix64::new(8)).q;
    let v = vec![0.0; model.nv()];
    let x = frame_pose(&model, w, &q, frame).translation;
    let target = [x[0] + 0.05, x[1] - 0.03, x[2] + 0.02];
    let (rate, time, steps) = (8.0, 0.4, 2000);
    let h = time / steps as f64;
    let reference = |_| TaskReference { position: target, velocity: [0.0; 3], acceleration: [0.0; 3] };
    let gains = TaskGains { stiffness: rate * rate, damping: 2.0 * rate, null_damping: 5.0 };
    let mut control = TaskControl::new(&model, frame, reference, gains)?;
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(Integrator::RungeKutta4))
        .dt(h)
        .without(Effect::Dissipation)
        .without(Effect::EffortLimits)
        .build()
        .unwrap();
    let run =
        simulation.run_steps_from(&q, &v, steps, RunOptions::new().sample_ends().controller(&mut control))?;
    let found = frame_pose(&model, w, &run.q, frame).translation;
    let decay = (1.0 + rate * time) * f64::exp(-rate * time);
    for k in 0..3 {
        let expected = target[k] + (x[k] - target[k]) * decay;
        // The held torque has a delay of ½h: O(h) of the path of 5 cm.
        assert!((found[k] - expected).abs() < 1e-4, "{k}: {} {expected}", found[k]);
    }
    assert!(
        frame_velocity(&model, w, &run.q, &run.v, frame, ReferenceFrame::LocalWorldAligned).linear[0] > 0.0
    );
    Ok(())
}

/// The error names the direction in which the frame cannot move at a singular pose.
#[test]
fn singular_poses_are_errors() -> Tested {
    let model = arm()?;
    let first = model.frame("link0").ok_or("no link")?;
    let w = &mut Workspace::new(&model);
    let (q, v) = (vec![0.3; model.nv()], vec![0.0; model.nv()]);
    let error = operational_space(&model, w, &q, &v, first, &[SpatialAxis::Z]).unwrap_err();
    assert!(matches!(error, ControllerError::SingularPose { row: "z", .. }), "{error}");
    let error = operational_space(&model, w, &[f64::NAN; 6], &v, first, &[SpatialAxis::Z]).unwrap_err();
    let ControllerError::Motion(MotionError::Input(error)) = error else { panic!("{error}") };
    assert!(matches!(error.problem, InputProblem::NotFinite { index: Some(0), .. }), "{error}");
    Ok(())
}

/// An arm with seven hinges, an upper arm and a forearm of 0.4 m, and a hand of 0.1 m. The elbow can turn
/// about the line from the shoulder to the wrist.
fn seven_joint_arm() -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("arm");
    robot.links.push(LinkDescription::new("base", None));
    let joints = [("z", 0.3), ("y", 0.0), ("z", 0.4), ("y", 0.0), ("z", 0.4), ("y", 0.0), ("z", 0.1)];
    let mut parent = "base".to_owned();
    for (k, (axis, height)) in joints.into_iter().enumerate() {
        let (name, child) = (format!("joint{}", k + 1), format!("link{}", k + 1));
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.005));
        let mass =
            robot_dynamics::description::MassProperties::new(2.0, Vector3::new(0.01, 0.02, 0.1), inertia)?;
        robot.links.push(LinkDescription::new(child.clone(), mass));
        let axis = if axis == "z" { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let place = Pose::from_translation([0.0, 0.0, height]);
        robot.joints.push(JointDescription::new(&name, JointKind::Revolute { axis }, &parent, &child, place));
        parent = child;
    }
    Ok(Model::new(robot)?)
}

const READY: [f64; 7] = [0.2, 0.6, 0.3, 1.3, -0.2, 0.7, 0.1];

fn run_of(model: &Model, step: f64) -> Simulation {
    let integrator = Integrator::RungeKutta4;
    SimulationBuilder::new(model)
        .method(Method::Fixed(integrator))
        .dt(step)
        .without(Effect::Dissipation)
        .without(Effect::EffortLimits)
        .build()
        .unwrap()
}

/// The law that holds the elbow besides the hand.
enum Posture {
    None,
    Weight,
    Spring,
}

/// The hand of a redundant arm is held still for ten seconds after a push that turns only the elbow.
///
/// With τ = JᵀF alone the elbow falls. With its weight compensated it drifts with the push. With τ₀ = C
/// v + g − k (q − q*) − d v it returns. The hand does not move in any of these cases.
#[test]
fn posture_holds_elbow() -> Tested {
    let model = seven_joint_arm()?;
    let hand = model.frame("link7").ok_or("no hand")?;
    let w = &mut Workspace::new(&model);
    let place = frame_pose(&model, w, &READY, hand).translation;
    let position = [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z];
    // 1 − J̄J times a turn of all joints: it does not move the hand.
    let space = operational_space(&model, w, &READY, &[0.0; 7], hand, &position)?;
    let turn = DVector::from_element(7, 0.3);
    let push = &turn - &space.consistent_inverse * (&space.jacobian * &turn);
    assert!(push[2].abs() > 0.05, "{push}");

    let mut attempt = |posture: &Posture| -> Result<(f64, f64, f64), Box<dyn Error>> {
        let mut space = OperationalSpace::zeros(&model, 3);
        let mut memory = OperationalSpaceWorkspace::new(&model);
        let (mut scratch, mut tau0) = (Workspace::new(&model), vec![0.0; 7]);
        let mut control = |_: f64, q: &[f64], v: &[f64], tau: &mut [f64]| -> Result<(), ControllerError> {
            operational_space_into(
                &model,
                &mut memory,
                OperationalSpaceInputs { q, v, frame: hand, rows: &position },
                &mut space,
            )?;
            let x = frame_pose(&model, &mut scratch, q, hand).translation;
            let rate =
                frame_velocity(&model, &mut scratch, q, v, hand, ReferenceFrame::LocalWorldAligned).linear;
            let wanted: [f64; 3] = std::array::from_fn(|k| 400.0 * (place[k] - x[k]) - 40.0 * rate[k]);
            match posture {
                Posture::None => tau0.fill(0.0),
                Posture::Weight => bias(&model, &mut scratch, q, v, &mut tau0),
                Posture::Spring => {
                    bias(&model, &mut scratch, q, v, &mut tau0);
                    for k in 0..7 {
                        tau0[k] -= 20.0 * (q[k] - READY[k]) + 5.0 * v[k];
                    }
                }
            }
            space.torque_with_posture(&wanted, &tau0, tau)?;
            Ok(())
        };
        let (mut farthest, mut off) = (0.0f64, 0.0f64);
        let ran = run_of(&model, 1e-3).run_steps_from(
            &READY,
            push.as_slice(),
            10_000,
            RunOptions::new().sample_ends().controller(&mut control).observer(&mut |info| {
                farthest = crate::common::max_difference(info.q, &READY).max(farthest);
                let x = frame_pose(&model, w, info.q, hand).translation;
                off = crate::common::max_difference(&x, &place).max(off);
                ControlFlow::Continue(())
            }),
        );
        let end = match ran {
            Ok(run) => run.q,
            // While it falls it may reach a pose at which the hand cannot be held.
            Err(failure) if matches!(posture, Posture::None) => failure.until.q,
            Err(failure) => return Err(failure.into()),
        };
        Ok((farthest, crate::common::max_difference(&end, &READY), off))
    };
    let (fallen, _, _) = attempt(&Posture::None)?;
    let (_, drifted, off_drifted) = attempt(&Posture::Weight)?;
    let (farthest, left, off) = attempt(&Posture::Spring)?;
    println!("falls by {fallen:.3} rad, drifts by {drifted:.3}, held {farthest:.4} and {left:.1e}");
    println!("hand off by {off_drifted:.1e} m and {off:.1e} m");
    assert!(fallen > 1.0, "{fallen}");
    assert!(drifted > 0.3, "{drifted}");
    assert!(farthest < 0.2 && left < 1e-6, "{farthest} {left:e}");
    // A held torque has a delay of ½h.
    assert!(off < 1e-5, "{off:e}");
    Ok(())
}

/// R of a turn by φ about a unit axis after `first`, both as rows.
fn turned(first: &[[f64; 3]; 3], axis: [f64; 3], angle: f64) -> [[f64; 3]; 3] {
    let turn = Quaternion::exp(axis.map(|x| x * angle));
    let column = |k: usize| turn.rotate([first[0][k], first[1][k], first[2][k]]);
    let columns = [column(0), column(1), column(2)];
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

/// The angle between two orientations, by cos φ = ½ (tr R₁R₂ᵀ − 1).
fn angle_between(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> f64 {
    let trace: f64 = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum();
    (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos()
}

/// Position and orientation obey ë + kd ė + kp e = 0 for a turn about one axis of the world. A posture term
/// acts on the elbow.
#[test]
fn pose_errors_are_linear() -> Tested {
    let model = seven_joint_arm()?;
    let hand = model.frame("link7").ok_or("no hand")?;
    let w = &mut Workspace::new(&model);
    let start = frame_pose(&model, w, &READY, hand);
    let (axis, angle) = ([0.6, 0.0, 0.8], 0.5);
    let shift = [0.04, -0.03, 0.05];
    let pose = Pose {
        rotation: turned(&start.rotation, axis, angle),
        translation: std::array::from_fn(|k| start.translation[k] + shift[k]),
    };
    let (rate, time) = (8.0, 0.4);
    let gains = TaskGains { stiffness: rate * rate, damping: 2.0 * rate, null_damping: 2.0 * rate };
    let decay = (1.0 + rate * time) * f64::exp(-rate * time);
    let mut off = Vec::new();
    for steps in [1000, 4000] {
        let mut control = TaskControl::new(&model, hand, |_| PoseReference::at_rest(pose), gains)?
            .with_posture(&READY, rate * rate)?;
        let run = run_of(&model, time / f64::from(steps)).run_steps_from(
            &READY,
            &[0.0; 7],
            usize::try_from(steps)?,
            RunOptions::new().sample_ends().controller(&mut control),
        )?;
        let found = frame_pose(&model, w, &run.q, hand);
        let shifted = (0..3).map(|k| pose.translation[k] - found.translation[k] - shift[k] * decay);
        let shifted = shifted.fold(0.0, |most: f64, x| most.max(x.abs()));
        // The remaining rotation, not only its angle, is a turn about that axis.
        let expected = turned(&start.rotation, axis, angle * (1.0 - decay));
        off.push(shifted.max(angle_between(&found.rotation, &expected)));
    }
    println!("off by {off:?}");
    // O(h) from the delay of a held torque.
    assert!(off[0] < 2e-3 && off[1] < 0.3 * off[0], "{off:?}");
    Ok(())
}

/// A hand that turns and moves with its reference follows it without error: ω* and ω̇* are fed forward.
#[test]
fn moving_pose_is_followed() -> Tested {
    let model = seven_joint_arm()?;
    let hand = model.frame("link7").ok_or("no hand")?;
    let w = &mut Workspace::new(&model);
    let start = frame_pose(&model, w, &READY, hand);
    let axis = [0.0, 0.6, 0.8];
    let reference = |t: f64| {
        let along = |x: f64| axis.map(|a| a * x);
        // φ = 0.4 (1 − cos 2t), x = 0.05 (1 − cos 2t)
        let (s, c) = (2.0 * t).sin_cos();
        let moved = |x: f64| [0.05 * x, 0.0, 0.0];
        PoseReference {
            pose: Pose {
                rotation: turned(&start.rotation, axis, 0.4 * (1.0 - c)),
                translation: std::array::from_fn(|k| start.translation[k] + moved(1.0 - c)[k]),
            },
            velocity: Twist { linear: moved(2.0 * s), angular: along(0.4 * 2.0 * s) },
            acceleration: SpatialAcceleration { linear: moved(4.0 * c), angular: along(0.4 * 4.0 * c) },
        }
    };
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 10.0 };
    let mut control = TaskControl::new(&model, hand, reference, gains)?.with_posture(&READY, 25.0)?;
    let mut off = 0.0f64;
    run_of(&model, 5e-4).run_steps_from(
        &READY,
        &[0.0; 7],
        3000,
        RunOptions::new().sample_ends().controller(&mut control).observer(&mut |info| {
            let (found, wanted) = (frame_pose(&model, w, info.q, hand), reference(info.time).pose);
            off = off.max(crate::common::max_difference(&found.translation, &wanted.translation));
            off = off.max(angle_between(&found.rotation, &wanted.rotation));
            ControlFlow::Continue(())
        }),
    )?;
    println!("off by {off:e}");
    assert!(off < 1e-3, "{off:e}");
    Ok(())
}

/// With a posture the elbow returns after a push; without one it stays displaced.
#[test]
fn task_control_has_a_posture() -> Tested {
    let model = seven_joint_arm()?;
    let hand = model.frame("link7").ok_or("no hand")?;
    let w = &mut Workspace::new(&model);
    let start = frame_pose(&model, w, &READY, hand);
    let pose = Pose { rotation: start.rotation, translation: start.translation };
    let space = operational_space(&model, w, &READY, &[0.0; 7], hand, &ROWS)?;
    let turn = DVector::from_element(7, 1.0);
    let push = &turn - &space.consistent_inverse * (&space.jacobian * &turn);
    let gains = TaskGains { stiffness: 400.0, damping: 40.0, null_damping: 2.0 };
    let control = || TaskControl::new(&model, hand, move |_| PoseReference::at_rest(pose), gains);
    let mut ends = Vec::new();
    for mut control in [control()?, control()?.with_posture(&READY, 4.0)?] {
        let run = run_of(&model, 1e-3).run_steps_from(
            &READY,
            push.as_slice(),
            10_000,
            RunOptions::new().sample_ends().controller(&mut control),
        )?;
        let found = frame_pose(&model, w, &run.q, hand);
        assert!(crate::common::max_difference(&found.translation, &pose.translation) < 1e-6);
        assert!(angle_between(&found.rotation, &pose.rotation) < 1e-6);
        ends.push(crate::common::max_difference(&run.q, &READY));
    }
    println!("elbow off by {ends:?}");
    assert!(ends[0] > 0.05 && ends[1] < 1e-3 * ends[0], "{ends:?}");
    Ok(())
}

/// The run ends with the time and the cause if the frame cannot follow, the reference fails, or the reference
/// is invalid.
#[test]
fn failed_task_ends_run() -> Tested {
    let model = seven_joint_arm()?;
    let hand = model.frame("link7").ok_or("no hand")?;
    let start = frame_pose(&model, &mut Workspace::new(&model), &READY, hand);
    let pose = Pose { rotation: start.rotation, translation: start.translation };
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 10.0 };
    let rest = [0.0; 7];
    // Two joints do not move a frame in six directions.
    let second = model.frame("link2").ok_or("no link")?;
    let mut control = TaskControl::new(&model, second, |_| PoseReference::at_rest(pose), gains)?;
    let ran = run_of(&model, 1e-3).run_steps_from(
        &rest,
        &rest,
        10,
        RunOptions::new().sample_ends().controller(&mut control),
    );
    let failure = ran.unwrap_err();
    let RunError::Controller { step: 0, time: 0.0, source } = &failure.error else { panic!("{failure}") };
    assert!(matches!(source, ControllerError::SingularPose { .. }));

    let camera =
        |t: f64| if t < 0.0045 { Ok(PoseReference::at_rest(pose)) } else { Err("the camera sees no mark") };
    let mut control = TaskControl::new(&model, hand, camera, gains)?;
    let ran = run_of(&model, 1e-3).run_steps_from(
        &READY,
        &rest,
        10,
        RunOptions::new().sample_ends().controller(&mut control),
    );
    let failure = ran.unwrap_err();
    let RunError::Controller { step: 5, time, source: ControllerError::Callback(cause) } = &failure.error
    else {
        panic!("{failure}")
    };
    assert_eq!((*time, cause.to_string().as_str()), (0.005, "the camera sees no mark"));
    assert_eq!((failure.until.steps, failure.until.trajectory.len()), (5, 1));

    let stretched = Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, 1.0]], ..pose };
    let mut control = TaskControl::new(&model, hand, |_| PoseReference::at_rest(stretched), gains)?;
    let error = control.torque(0.0, &READY, &rest, &mut [0.0; 7]).unwrap_err();
    let ControllerError::Motion(MotionError::Input(error)) = error else { panic!("{error}") };
    let InputProblem::NotARotation { defect } = error.problem else { panic!("{error}") };
    assert!((defect - 0.21).abs() < 1e-12, "{error}");
    Ok(())
}

/// Near a stretched elbow the torque stays bounded: without damping it grows as 1/angle, to 1e8 N m.
#[test]
fn torques_stay_bounded_near_a_singular_pose() -> Tested {
    let model = seven_joint_arm()?;
    let hand = model.frame("link7").ok_or("no hand")?;
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 5.0 };
    let torque = |elbow: f64| -> Result<f64, Box<dyn Error>> {
        let mut q = READY;
        q[3] = elbow;
        let w = &mut Workspace::new(&model);
        let pose = frame_pose(&model, w, &q, hand);
        let inwards = pose.translation.map(|x| 0.9 * x);
        let target = PoseReference::at_rest(Pose { rotation: pose.rotation, translation: inwards });
        let mut tau = [0.0; 7];
        TaskControl::new(&model, hand, |_| target, gains)?.torque(0.0, &q, &[0.0; 7], &mut tau)?;
        Ok(tau.iter().fold(0.0, |most: f64, tau| most.max(tau.abs())))
    };
    let good = torque(READY[3])?;
    for elbow in [0.3, 0.1, 0.03, 1e-2, 1e-3, 1e-4, 1e-6] {
        let found = torque(elbow)?;
        println!("{elbow}: {found} N m, {good} in a good pose");
        assert!(found < 16.0 * good, "{elbow}: {found} {good}");
    }
    Ok(())
}
