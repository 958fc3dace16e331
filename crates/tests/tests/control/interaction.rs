//! Controllers of robots that touch their environment: effort limits, impedance, admittance, implicit gains,
//! external torques, and controls of actuators.

use std::error::Error;

use robot_dynamics::algorithms::{
    FrameWrench, ReferenceFrame, SpatialAcceleration, Twist, forward_dynamics,
    forward_dynamics_with_wrenches, frame_acceleration, frame_jacobian, frame_pose, frame_velocity,
};
use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::{
    Admittance, ImpedanceControl, ImpedanceGains, MomentumObserver, PoseReference, TaskControl, TaskGains,
    TaskTarget, operational_space,
};
use robot_dynamics::description::{
    Base, FrameDescription, JointKinds, Pose, RandomRobotOptions, random_robot,
};
use robot_dynamics::model::{FrameId, Model, RandomState, Workspace, integrate, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{
    Controller, ControllerError, Effect, GravityCompensatedPd, ImplicitGains, Integrator, Method, RunOptions,
    SimulationBuilder, WithImplicitGains,
};

type Tested = Result<(), Box<dyn Error>>;

const ALIGNED: ReferenceFrame = ReferenceFrame::LocalWorldAligned;

/// Arms of seven hinges with a sensor before the last frame, at states away from singular poses.
fn arms() -> Vec<(Model, RandomState, FrameId, FrameId)> {
    let options = RandomRobotOptions {
        joints: 7,
        kinds: JointKinds::Turning,
        chain: 1.0,
        massless: 0.0,
        ..RandomRobotOptions::default()
    };
    let arm = |seed: u64| {
        let mut robot = random_robot(seed, &options);
        let last = robot.links.last().expect("a link").name.clone();
        let tool = Pose::from_xyz_rpy([0.1, -0.05, 0.2], [0.3, 0.5, -0.7]);
        let sensor = Pose::from_xyz_rpy([-0.02, 0.04, 0.03], [-1.1, 0.2, 0.6]);
        robot.frames.push(FrameDescription::new("tool", &last, tool));
        robot.frames.push(FrameDescription::new("sensor", &last, sensor));
        let model = Model::new(robot).expect("a robot");
        let state = random_state(&model, &mut SplitMix64::new(seed));
        let [tool, sensor] = ["tool", "sensor"].map(|name| model.frame_named(name).expect("its frame"));
        (model, state, tool, sensor)
    };
    (0..20).map(arm).collect()
}

/// The world-aligned acceleration of a frame under a torque and a wrench.
fn motion_under(
    model: &Model,
    state: &RandomState,
    frame: FrameId,
    tau: &[f64],
    wrenches: &[FrameWrench],
) -> [f64; 6] {
    let (w, mut a) = (&mut Workspace::new(model), vec![0.0; model.nv()]);
    forward_dynamics_with_wrenches(model, w, &state.q, &state.v, tau, wrenches, &mut a);
    let SpatialAcceleration { linear, angular } =
        frame_acceleration(model, w, &state.q, &state.v, &a, frame, ALIGNED);
    core::array::from_fn(|k| if k < 3 { linear[k] } else { angular[k - 3] })
}

/// A moving reference near a frame's pose.
fn reference_near(model: &Model, state: &RandomState, frame: FrameId) -> PoseReference {
    let pose = frame_pose(model, &mut Workspace::new(model), &state.q, frame);
    PoseReference {
        pose: pose.compose(&Pose::from_xyz_rpy([0.03, -0.02, 0.05], [0.1, -0.2, 0.15])),
        velocity: Twist { linear: [0.1, 0.2, -0.3], angular: [0.4, -0.1, 0.2] },
        acceleration: SpatialAcceleration { linear: [1.0, -0.5, 0.3], angular: [-0.7, 0.6, 0.2] },
    }
}

/// Within effort limits the frame accelerates along its command, with the largest possible fraction of it.
#[test]
fn limited_task_keeps_its_direction() -> Tested {
    let (mut scaled, mut whole) = (0, 0);
    for (model, state, tool, _) in arms() {
        let reference = reference_near(&model, &state, tool);
        let w = &mut Workspace::new(&model);
        let pose = frame_pose(&model, w, &state.q, tool);
        let velocity = frame_velocity(&model, w, &state.q, &state.v, tool, ALIGNED);
        let command = reference.deviation(&pose, &velocity)?.acceleration(100.0, 20.0);
        let hold = model.bias(&state.q, &state.v)?;
        for factor in [1.05, 1.5, 3.0, 100.0] {
            let limits: Vec<f64> = hold.iter().map(|tau| factor * (tau.abs() + 1.0)).collect();
            let control = |null_damping: f64| {
                let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping };
                TaskControl::new(&model, tool, |_| reference, gains).map(|own| own.with_limits(&limits))
            };
            let mut tau = vec![0.0; 7];
            let mut with_posture = control(5.0)?.with_posture(&state.q, 25.0)?;
            with_posture.torque(0.0, &state.q, &state.v, &mut tau)?;
            assert!(tau.iter().zip(&limits).all(|(tau, limit)| tau.abs() <= *limit));
            let scales = with_posture.effort_scales();
            if scales.overloaded.is_some() || with_posture.is_damped() {
                continue;
            }
            let moved = motion_under(&model, &state, tool, &tau, &[]);
            let size = command.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            for k in 0..6 {
                assert!((moved[k] - scales.task * command[k]).abs() < 1e-8 * size, "{moved:?} {command:?}");
            }
            if scales.task < 1.0 {
                // Without a motion in the null space, the command alone reaches a limit.
                let mut alone = control(0.0)?;
                alone.torque(0.0, &state.q, &state.v, &mut tau)?;
                assert!((alone.effort_scales().task - scales.task).abs() < 1e-12);
                let largest = tau.iter().zip(&limits).map(|(tau, limit)| tau.abs() / limit);
                assert!(largest.fold(0.0, f64::max) > 1.0 - 1e-12);
                scaled += 1;
            } else {
                whole += 1;
            }
        }
    }
    assert!(scaled >= 10 && whole >= 10, "{scaled} {whole}");
    Ok(())
}

/// M_d (ẍ − ẍ*) = D ė + K e + f, and the same with Λ, where f comes from a sensor at another frame.
#[test]
fn impedance_answers_wrenches() -> Tested {
    let gains = ImpedanceGains {
        stiffness: [500.0, 300.0, 200.0, 30.0, 20.0, 10.0],
        damping: [40.0, 30.0, 20.0, 3.0, 2.0, 1.0],
        null_damping: 2.0,
    };
    let inertia = [5.0, 3.0, 2.0, 0.3, 0.2, 0.4];
    let mut tested = 0;
    for (model, state, tool, sensor) in arms() {
        let reference = reference_near(&model, &state, tool);
        let w = &mut Workspace::new(&model);
        let pose = frame_pose(&model, w, &state.q, tool);
        let velocity = frame_velocity(&model, w, &state.q, &state.v, tool, ALIGNED);
        let deviation = reference.deviation(&pose, &velocity)?;
        let restoring: Vec<f64> = (0..6)
            .map(|k| gains.damping[k] * deviation.velocity[k] + gains.stiffness[k] * deviation.position[k])
            .collect();
        let measured = [3.0, -7.0, 5.0, 0.4, 0.8, -0.3];
        let acting = FrameWrench {
            frame: sensor,
            force_in_frame: [3.0, -7.0, 5.0],
            moment_in_frame: [0.4, 0.8, -0.3],
        };
        // The same wrench at the tool: Jᵀf of the sensor, through J̄ᵀ of the tool.
        let space = operational_space(&model, w, &state.q, &state.v, tool, PoseReference::ROWS)?;
        let mut jacobian = vec![0.0; 6 * 7];
        frame_jacobian(&model, w, &state.q, sensor, ReferenceFrame::Local, &mut jacobian);
        let joint: Vec<f64> =
            (0..7).map(|i| (0..6).map(|k| jacobian[k * 7 + i] * measured[k]).sum()).collect();
        let external = space.consistent_inverse.tr_mul(&nalgebra::DVector::from_vec(joint));

        let free = vec![f64::INFINITY; 7];
        let mut tau = vec![0.0; 7];
        let control = ImpedanceControl::new(&model, tool, |_| reference, gains)?.with_limits(&free);
        let mut own_inertia = control.clone();
        own_inertia.torque(0.0, &state.q, &state.v, &mut tau)?;
        if own_inertia.is_damped() {
            continue;
        }
        tested += 1;
        let moved = motion_under(&model, &state, tool, &tau, &[acting]);
        let relative =
            nalgebra::DVector::from_iterator(6, (0..6).map(|k| moved[k] - deviation.acceleration[k]));
        let force = &space.inertia * relative;
        for k in 0..6 {
            assert!((force[k] - restoring[k] - external[k]).abs() < 1e-7 * force.amax(), "{force}");
        }

        let mut control = control.with_inertia(inertia, sensor, |_| measured)?;
        control.torque(0.0, &state.q, &state.v, &mut tau)?;
        let moved = motion_under(&model, &state, tool, &tau, &[acting]);
        for k in 0..6 {
            let wanted = deviation.acceleration[k] + (restoring[k] + external[k]) / inertia[k];
            assert!((moved[k] - wanted).abs() < 1e-7 * (1.0 + wanted.abs()), "{k}: {} {wanted}", moved[k]);
        }
    }
    assert!(tested > 12, "{tested}");
    Ok(())
}

/// A sensor on another link is refused by name, and so is an inertia of zero.
#[test]
fn impedance_refuses_other_sensors() -> Tested {
    let (model, _, tool, _) = arms().swap_remove(0);
    let gains = ImpedanceGains { stiffness: [1.0; 6], damping: [1.0; 6], null_damping: 0.0 };
    let at_rest = |_| PoseReference::at_rest(Pose::IDENTITY);
    let control = || ImpedanceControl::new(&model, tool, at_rest, gains);
    let first = model.frame_named(&model.links()[1].name)?;
    let error = control()?.with_inertia([1.0; 6], first, |_| [0.0; 6]).map(drop).unwrap_err().to_string();
    assert!(error.contains(&model.links()[1].name) && error.contains("tool"), "{error}");
    let error = control()?.with_inertia([0.0; 6], tool, |_| [0.0; 6]).map(drop).unwrap_err().to_string();
    assert!(error.contains("inertia"), "{error}");
    Ok(())
}

/// From the stretched arm, where Λ does not exist, the hand is pulled back to a pose nearer to the base.
#[test]
fn task_leaves_a_singular_pose() -> Tested {
    let model = robot_dynamics::load("../../robots/panda.urdf")?.model;
    let hand = model.frame_named("panda_link8")?;
    let start = [0.0, 0.0, 0.0, -1e-3, 0.0, 1.5, 0.0];
    let bent = [0.2, 0.5, 0.1, -1.4, 0.1, 1.9, 0.3];
    let w = &mut Workspace::new(&model);
    let pose = |w: &mut Workspace, q: &[f64]| frame_pose(&model, w, q, hand);
    let target = PoseReference::at_rest(pose(w, &bent));
    let gains = TaskGains { stiffness: 25.0, damping: 10.0, null_damping: 2.0 };
    let mut tau = [0.0; 7];
    let mut control = TaskControl::new(&model, hand, |_| target, gains)?.with_posture(&bent, 4.0)?;
    // At q = 0 exactly the arm is singular, and the torque is finite and within the limits.
    control.torque(0.0, &[0.0; 7], &[0.0; 7], &mut tau)?;
    assert!(control.is_damped());
    let mut simulation = SimulationBuilder::new(&model).without(Effect::Limits).build()?;
    let run = simulation.run_from(&start, &[0.0; 7], 4.0, RunOptions::new().controller(&mut control))?;
    let found = pose(w, &run.q);
    let distance = (0..3).map(|k| (found.translation[k] - target.pose.translation[k]).abs());
    assert!(distance.fold(0.0, f64::max) < 2e-3, "{found:?} {target:?}");
    Ok(())
}

fn trees() -> Vec<Model> {
    let options =
        |base| RandomRobotOptions { base, joints: 6, massless: 0.0, ..RandomRobotOptions::default() };
    let tree = |seed: u64| {
        let base = if seed.is_multiple_of(2) { Base::Fixed } else { Base::Floating };
        Model::new(random_robot(seed, &options(base))).expect("a robot")
    };
    (0..12).map(tree).collect()
}

/// τ equals −K (q ⊕ h v₊) − D v₊ with the velocity v₊ = v + h a of its own motion, on driven coordinates.
#[test]
fn implicit_gains_are_those_of_the_next_velocity() -> Tested {
    let mut random = SplitMix64::new(3);
    for model in trees() {
        let (nv, h) = (model.nv(), 2e-3);
        let RandomState { q, v, tau: law, .. } = random_state(&model, &mut random);
        let law: Vec<f64> = (0..nv).map(|k| if model.actuated_dofs()[k] { law[k] } else { 0.0 }).collect();
        for gain in [1.0, 1e4] {
            let stiffness: Vec<f64> = (0..nv).map(|k| gain * (1.0 + k as f64)).collect();
            let damping: Vec<f64> = (0..nv).map(|k| 0.1 * gain / (1.0 + k as f64)).collect();
            let mut gains = ImplicitGains::new(&model, &stiffness, &damping, h)?;
            let mut tau = law.clone();
            gains.apply(&model, &mut Workspace::new(&model), &q, &v, &mut tau)?;
            let mut a = vec![0.0; nv];
            forward_dynamics(&model, &mut Workspace::new(&model), &q, &v, &tau, &mut a);
            for k in 0..nv {
                let change = h * stiffness[k] * (v[k] + h * a[k]) + h * damping[k] * a[k];
                let wanted = if model.actuated_dofs()[k] { law[k] - change } else { 0.0 };
                let scale = 1.0 + tau[k].abs() + (h * stiffness[k] * v[k]).abs();
                assert!((tau[k] - wanted).abs() < 1e-8 * scale, "{k}: {} {wanted}", tau[k]);
            }
        }
    }
    Ok(())
}

/// Gains a million times beyond the explicit limit hold a pose; with explicit gains the run fails.
#[test]
fn implicit_gains_are_stable() -> Tested {
    for (model, ..) in &arms() {
        let (nv, h) = (model.nv(), 2e-3);
        let target = random_state(model, &mut SplitMix64::new(5)).q;
        let mut start = target.clone();
        integrate(model, &target, &vec![1e-2; nv], &mut start);
        let (stiffness, damping, none) = (vec![1e10; nv], vec![1e3; nv], vec![f64::INFINITY; nv]);
        let explicit = || GravityCompensatedPd::new(model, &target, &stiffness, &damping);
        let mut simulation = SimulationBuilder::new(model)
            .method(Method::Fixed(Integrator::RungeKutta4))
            .dt(h)
            .without(Effect::EffortLimits)
            .without(Effect::Dissipation)
            .build()?;
        let mut run = |control: &mut dyn Controller| {
            simulation.run_from(&start, &vec![0.0; nv], 0.2, RunOptions::new().controller(control))
        };
        assert!(run(&mut explicit()?.with_limits(&none)).is_err());
        let mut of_library = explicit()?.with_limits(&none).with_implicit_gains(h)?;
        let held = run(&mut of_library)?;
        let mut error = vec![0.0; nv];
        robot_dynamics::model::difference(model, &held.q, &target, &mut error);
        assert!(error.iter().all(|x| x.abs() < 1e-8), "{error:?}");
        // The wrapper of any law does the same.
        let mut own = explicit()?.with_limits(&none);
        let law = |t: f64, q: &[f64], v: &[f64], tau: &mut [f64]| own.torque(t, q, v, tau);
        let wrapped = WithImplicitGains::new(model, law, &stiffness, &damping, h)?;
        let again = run(&mut wrapped.with_limits(&none))?;
        assert_eq!((again.q, again.v), (held.q, held.v));
    }
    Ok(())
}

/// r follows Jᵀf of a wrench through the filter of first order, on robots with floating bases and ball
/// joints; the error falls with the square of the sampling time.
#[test]
fn momentum_observer_finds_wrenches() -> Tested {
    for (index, model) in trees().iter().enumerate() {
        let frame = model.frame_named(&model.links().last().expect("a link").name)?;
        let wrench =
            FrameWrench { frame, force_in_frame: [4.0, -3.0, 6.0], moment_in_frame: [0.3, -0.2, 0.5] };
        let state = random_state(model, &mut SplitMix64::new(index as u64));
        let errors = [250, 500].map(|samples| observer_error(model, &state, &wrench, samples));
        let [coarse, fine] = errors;
        println!("{index}: {coarse:e} {fine:e}");
        assert!(coarse < 2e-3 && fine < coarse / 3.0, "{index}: {errors:?}");
    }
    Ok(())
}

/// The largest |r − filtered Jᵀf| relative to the largest entry of Jᵀf, over 0.1 s of a motion whose steps
/// are much shorter than the samples.
fn observer_error(model: &Model, state: &RandomState, wrench: &FrameWrench, samples: u32) -> f64 {
    const GAIN: f64 = 60.0;
    let h = 0.1 / f64::from(samples);
    let (nv, w) = (model.nv(), &mut Workspace::new(model));
    let tau: Vec<f64> = (0..nv).map(|k| if model.actuated_dofs()[k] { state.tau[k] } else { 0.0 }).collect();
    let mut observer = MomentumObserver::new(model, &vec![GAIN; nv]).expect("gains");
    let external = |w: &mut Workspace, q: &[f64]| -> Vec<f64> {
        let mut jacobian = vec![0.0; 6 * nv];
        frame_jacobian(model, w, q, wrench.frame, ReferenceFrame::Local, &mut jacobian);
        let force = [wrench.force_in_frame, wrench.moment_in_frame];
        let force = force.as_flattened();
        (0..nv).map(|i| (0..6).map(|k| jacobian[k * nv + i] * force[k]).sum()).collect()
    };
    let (mut q, mut v) = (state.q.clone(), state.v.clone());
    observer.update(&q, &v, &tau, h).expect("a sample");
    let mut filtered = vec![0.0; nv];
    let mut before = external(w, &q);
    let (mut worst, mut size) = (0.0_f64, 0.0_f64);
    for _ in 0..samples {
        advance(model, w, (&mut q, &mut v), &tau, wrench, h);
        let r = observer.update(&q, &v, &tau, h).expect("a sample");
        let now = external(w, &q);
        let share = -f64::exp_m1(-GAIN * h);
        for k in 0..nv {
            filtered[k] += share * (0.5 * (before[k] + now[k]) - filtered[k]);
            worst = worst.max((r[k] - filtered[k]).abs());
            size = size.max(now[k].abs());
        }
        before = now;
    }
    worst / size
}

/// One sampling time of the motion under a constant torque and wrench, by 16 midpoint steps.
fn advance(
    model: &Model,
    w: &mut Workspace,
    (q, v): (&mut Vec<f64>, &mut Vec<f64>),
    tau: &[f64],
    wrench: &FrameWrench,
    h: f64,
) {
    let (nv, h) = (model.nv(), h / 16.0);
    let mut a = vec![0.0; nv];
    let mut accelerate = |q: &[f64], v: &[f64], a: &mut [f64]| {
        forward_dynamics_with_wrenches(model, w, q, v, tau, &[*wrench], a);
    };
    for _ in 0..16 {
        accelerate(q, v, &mut a);
        let middle_v: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + 0.5 * h * a).collect();
        let mut middle_q = q.clone();
        integrate(model, q, &v.iter().map(|v| 0.5 * h * v).collect::<Vec<_>>(), &mut middle_q);
        accelerate(&middle_q, &middle_v, &mut a);
        let mut end = q.clone();
        integrate(model, q, &middle_v.iter().map(|v| h * v).collect::<Vec<_>>(), &mut end);
        *q = end;
        v.iter_mut().zip(&a).for_each(|(v, a)| *v += h * a);
    }
}

/// The filter of a law that changes with the state is exact: two half steps are one step. The commanded
/// velocity and acceleration are the derivatives of the commanded pose along a moving reference.
#[test]
fn admittance_is_exact() -> Tested {
    let inertia = [2.0, 3.0, 1.0, 0.1, 0.2, 0.15];
    let damping = [10.0, 0.0, 200.0, 0.5, 0.3, 0.0];
    for stiffness in [[0.0; 6], [40.0, 90.0, 7.0, 2.0, 0.0, 3.0]] {
        let wrench = [1.0, -2.0, 3.0, 0.1, 0.3, -0.2];
        let reference = |t: f64| {
            let angle = 0.4 * t;
            PoseReference {
                pose: Pose::from_xyz_rpy([0.1 * t, 0.0, 0.3], [angle, 0.0, 0.0]),
                velocity: Twist { linear: [0.1, 0.0, 0.0], angular: [0.4, 0.0, 0.0] },
                acceleration: SpatialAcceleration { linear: [0.0; 3], angular: [0.0; 3] },
            }
        };
        let run = |h: f64, steps: usize| -> Result<(Admittance, PoseReference), Box<dyn Error>> {
            let mut lead = Admittance::new(inertia, damping, stiffness)?;
            let mut command = reference(0.0);
            for k in 1..=steps {
                command = lead.step(&reference(k as f64 * h), &wrench, h)?;
            }
            Ok((lead, command))
        };
        let (one, two) = (run(0.7, 1)?.0.displacement(), run(0.35, 2)?.0.displacement());
        for k in 0..6 {
            assert!((one[k] - two[k]).abs() < 1e-13 * (1.0 + one[k].abs()), "{one:?} {two:?}");
        }
        let (h, steps) = (1e-4, 7000);
        let [before, middle, after] = [steps - 1, steps, steps + 1].map(|steps| run(h, steps));
        let (before, middle, after) = (before?.1, middle?.1, after?.1);
        for k in 0..3 {
            let at = |c: &PoseReference| (c.pose.translation[k], c.velocity.linear[k], c.velocity.angular[k]);
            let ((p0, v0, w0), (_, v1, _), (p2, v2, w2)) = (at(&before), at(&middle), at(&after));
            assert!(((p2 - p0) / (2.0 * h) - v1).abs() < 1e-6);
            assert!(((v2 - v0) / (2.0 * h) - middle.acceleration.linear[k]).abs() < 1e-6);
            assert!(((w2 - w0) / (2.0 * h) - middle.acceleration.angular[k]).abs() < 1e-5);
        }
        let turn = after.pose.compose(&before.pose.inverse());
        let (_, angle) = Pose { translation: [0.0; 3], ..turn }.log();
        for k in 0..3 {
            assert!((angle[k] / (2.0 * h) - middle.velocity.angular[k]).abs() < 1e-5);
        }
    }
    let bad = Admittance::new([0.0; 6], [1.0; 6], [0.0; 6]).unwrap_err().to_string();
    assert!(bad.contains("inertia"), "{bad}");
    Ok(())
}

/// A frame whose rows depend on each other at every pose is an error, not a damped motion.
#[test]
fn dependent_rows_are_errors() -> Tested {
    let (model, state, ..) = arms().swap_remove(0);
    let third = model.frame_named(&model.links()[3].name)?;
    let gains = TaskGains { stiffness: 1.0, damping: 1.0, null_damping: 0.0 };
    let at_rest = |_| PoseReference::at_rest(Pose::IDENTITY);
    let mut tau = [0.0; 7];
    let mut control = TaskControl::new(&model, third, at_rest, gains)?;
    let error = control.torque(0.0, &state.q, &state.v, &mut tau).unwrap_err();
    assert!(matches!(error, ControllerError::SingularPose { .. }), "{error}");
    let mut part = TaskControl::new(&model, third, at_rest, gains)?.with_rows(&[SpatialAxis::X]);
    part.torque(0.0, &state.q, &state.v, &mut tau)?;
    Ok(())
}
