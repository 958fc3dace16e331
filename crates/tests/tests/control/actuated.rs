//! Controllers of robots with passive coordinates: no torque acts there, and the actuated coordinates move as
//! asked.

use std::error::Error;

use nalgebra::DMatrix;
use robot_dynamics::algorithms::{
    ReferenceFrame, forward_dynamics, frame_acceleration, frame_jacobian, frame_pose, frame_velocity, gravity,
};
use robot_dynamics::control::{
    ComputedTorque, PoseReference, Reference, TaskControl, TaskGains, TaskReference,
};
use robot_dynamics::description::{Base, JointKinds, ModelError, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, Workspace, difference, random_state};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{Controller, ControllerError, GravityCompensatedPd};
use robot_dynamics::{Classified, ErrorKind};

type Tested = Result<(), Box<dyn Error>>;

/// Robots with a floating base, and fixed ones whose first joint has no motor.
fn robots() -> Vec<Model> {
    let mut robots = Vec::new();
    for seed in 0..12 {
        let floating = RandomRobotOptions {
            base: Base::Floating,
            joints: 7,
            kinds: JointKinds::Turning,
            massless: 0.0,
            ..RandomRobotOptions::default()
        };
        robots.push(Model::new(random_robot(seed, &floating)).expect("a robot"));
        let mut fixed = random_robot(seed, &RandomRobotOptions { base: Base::Fixed, chain: 0.7, ..floating });
        let moving: Vec<String> =
            fixed.joints.iter().filter(|j| j.kind.nv() > 0).map(|j| j.name.clone()).collect();
        fixed.set_actuated_joints(&moving[1..]).expect("its own joints");
        robots.push(Model::new(fixed).expect("a robot"));
    }
    robots
}

/// The acceleration of a state under a torque.
fn accelerate(model: &Model, q: &[f64], v: &[f64], tau: &[f64]) -> Vec<f64> {
    let mut a = vec![0.0; model.nv()];
    forward_dynamics(model, &mut Workspace::new(model), q, v, tau, &mut a);
    a
}

/// The smallest share of its mobility that a direction of the frame's position keeps when the other two are
/// held, by actuated coordinates. It comes from R M̃ Rᵀ by dense inverses. R has the actuated columns of
/// J M⁻¹, and M̃ is the inverse of the actuated block of M⁻¹.
fn least_mobility(model: &Model, q: &[f64], frame: robot_dynamics::model::FrameId) -> f64 {
    let nv = model.nv();
    let driven: Vec<usize> = (0..nv).filter(|&k| model.actuated_dofs()[k]).collect();
    let inverse = model.inverse_mass_matrix(q).expect("M⁻¹");
    let mut jacobian = vec![0.0; 6 * nv];
    frame_jacobian(
        model,
        &mut Workspace::new(model),
        q,
        frame,
        ReferenceFrame::LocalWorldAligned,
        &mut jacobian,
    );
    let jacobian = DMatrix::from_row_slice(6, nv, &jacobian).rows(0, 3).into_owned();
    let responses = (jacobian * &inverse).select_columns(&driven);
    let part = inverse.select_rows(&driven).select_columns(&driven).try_inverse().expect("M̃");
    let mobility = &responses * part * responses.transpose();
    let Some(inertia) = mobility.clone().try_inverse() else { return 0.0 };
    (0..3).map(|k| 1.0 / (inertia[(k, k)] * mobility[(k, k)])).fold(1.0, f64::min)
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(1.0, |most: f64, x| most.max(x.abs()))
}

/// Computed torque: the actuated coordinates accelerate with a* + Kp (q* ⊖ q) + Kd (v* − v), whatever the
/// others do.
///
/// Tolerance: 1e-9 of the accelerations and torques; κ(M) of these robots is below 1e6.
#[test]
fn computed_torque_controls_actuated_coordinates() -> Tested {
    for (index, model) in robots().iter().enumerate() {
        let random = &mut SplitMix64::new(index as u64);
        let (here, wanted) = (random_state(model, random), random_state(model, random));
        let (kp, kd) = (vec![30.0; model.nv()], vec![8.0; model.nv()]);
        let reference = |_: f64| Reference { q: wanted.q.clone(), v: wanted.v.clone(), a: wanted.a.clone() };
        let mut tau = vec![0.0; model.nv()];
        ComputedTorque::new(model, reference, &kp, &kd)?.torque(0.0, &here.q, &here.v, &mut tau)?;
        let found = accelerate(model, &here.q, &here.v, &tau);
        let mut error = vec![0.0; model.nv()];
        difference(model, &here.q, &wanted.q, &mut error);
        for k in 0..model.nv() {
            if !model.actuated_dofs()[k] {
                assert_eq!(tau[k], 0.0, "robot {index}: {tau:?}");
                continue;
            }
            let expected = wanted.a[k] + 30.0 * error[k] + 8.0 * (wanted.v[k] - here.v[k]);
            let size = largest(&found).max(largest(&tau));
            assert!((found[k] - expected).abs() < 1e-9 * size, "robot {index}, {k}: {} {expected}", found[k]);
        }
    }
    Ok(())
}

/// Task control: the frame accelerates as asked by actuated coordinates alone, and the base recoils.
#[test]
fn frame_follows_without_torque_on_base() -> Tested {
    let mut tested = 0;
    for (index, model) in robots().iter().enumerate() {
        let random = &mut SplitMix64::new(index as u64 + 50);
        let state = random_state(model, random);
        let hand = model.frame_named(&model.frames().last().expect("a frame").name.clone())?;
        let w = &mut Workspace::new(model);
        let pose = frame_pose(model, w, &state.q, hand);
        let velocity = frame_velocity(model, w, &state.q, &state.v, hand, ReferenceFrame::LocalWorldAligned);
        let target = pose.translation.map(|x| x + random.uniform(-0.1, 0.1));
        let still = TaskReference { position: target, velocity: [0.0; 3], acceleration: [0.0; 3] };
        let gains = TaskGains { stiffness: 40.0, damping: 9.0, null_damping: 3.0 };
        let mut control = TaskControl::new(model, hand, |_| still, gains)?
            .with_posture(&random_state(model, random).q, 5.0)?
            .with_limits(&vec![f64::INFINITY; model.nv()]);
        let mut tau = vec![0.0; model.nv()];
        if control.torque(0.0, &state.q, &state.v, &mut tau).is_err() {
            continue; // the robot's joints cannot move this frame in three directions
        }
        let a = accelerate(model, &state.q, &state.v, &tau);
        let moved =
            frame_acceleration(model, w, &state.q, &state.v, &a, hand, ReferenceFrame::LocalWorldAligned)
                .linear;
        let size = largest(&a).max(largest(&tau));
        if control.is_damped() || least_mobility(model, &state.q, hand) < 2e-3 {
            continue; // near a singular pose, where the law is damped
        }
        tested += 1;
        for k in 0..3 {
            let expected = 40.0 * (target[k] - pose.translation[k]) - 9.0 * velocity.linear[k];
            assert!((moved[k] - expected).abs() < 1e-8 * size, "robot {index}: {moved:?} {expected}");
        }
        let free = tau.iter().zip(model.actuated_dofs()).filter(|(_, driven)| !**driven);
        assert!(
            free.clone().count() > 0 && free.clone().all(|(tau, _)| *tau == 0.0),
            "robot {index}: {tau:?}"
        );
    }
    assert!(tested > 12, "{tested}");
    Ok(())
}

/// A spring to a pose: the joints get g + Kp e and the base gets nothing. If the robot's actuated joints are
/// the thrusters of its base, only the base gets a force.
#[test]
fn joints_hold_pose() -> Tested {
    let options = RandomRobotOptions {
        base: Base::Floating,
        kinds: JointKinds::Turning,
        ..RandomRobotOptions::default()
    };
    let mut description = random_robot(3, &options);
    let legs = Model::new(description.clone())?;
    description.set_actuated_joints([description.floating_base_name()])?;
    let satellite = Model::new(description.clone())?;
    assert_ne!(legs.fingerprint(), satellite.fingerprint());
    let state = random_state(&legs, &mut SplitMix64::new(1));
    let nv = legs.nv();
    let mut weight = vec![0.0; nv];
    gravity(&legs, &mut Workspace::new(&legs), &state.q, &mut weight);
    for (model, base_is_driven) in [(&legs, false), (&satellite, true)] {
        let mut hold = GravityCompensatedPd::new(model, &state.q, &vec![10.0; nv], &vec![0.0; nv])?
            .with_limits(&vec![f64::INFINITY; nv]);
        let mut tau = vec![0.0; nv];
        hold.torque(0.0, &state.q, &vec![0.0; nv], &mut tau)?;
        for k in 0..nv {
            let driven = (k < 6) == base_is_driven;
            assert_eq!(model.actuated_dofs()[k], driven);
            assert_eq!(tau[k], if driven { weight[k] } else { 0.0 }, "{k}");
        }
    }
    let error = description.set_actuated_joints(["tail"]).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::UnknownName);
    description.actuated_joints = Some(vec!["tail".into()]);
    let error = Model::new(description).unwrap_err();
    assert!(
        matches!(&error, ModelError::UnknownName { sort: "joint", name, .. } if name == "tail"),
        "{error}"
    );
    Ok(())
}

/// A planar arm follows the rows that it can move: x and z of its tip, or z and its rotation.
#[test]
fn planar_arm_follows_two_rows() -> Tested {
    use robot_dynamics::constraints::SpatialAxis::{Rx, Ry, X, Y, Z};
    use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose, RobotDescription};
    let mut robot = RobotDescription::new("planar");
    robot.links.push(LinkDescription::new("base", None));
    for (i, (name, parent)) in [("upper", "base"), ("fore", "upper")].into_iter().enumerate() {
        let rod = robot_dynamics::description::MassProperties::solid_box(500.0, [1.0, 0.05, 0.05].into())?;
        robot.links.push(LinkDescription::new(name, rod));
        let hinge = JointKind::Revolute { axis: [0.0, -1.0, 0.0] };
        let at = Pose::from_translation([i as f64, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(format!("{name} joint"), hinge, parent, name, at));
    }
    robot.frames.push(robot_dynamics::description::FrameDescription::new(
        "tip",
        "fore",
        Pose::from_translation([0.8, 0.0, 0.0]),
    ));
    let model = Model::new(robot)?;
    let (tip, w) = (model.frame_named("tip")?, &mut Workspace::new(&model));
    let (q, v) = ([0.3, 0.9], [0.7, -1.1]);
    let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 0.0 };
    let wanted = [1.2, 5.0, 0.8];
    let pose = frame_pose(&model, w, &q, tip);
    let velocity = frame_velocity(&model, w, &q, &v, tip, ReferenceFrame::LocalWorldAligned);
    let position = |_| TaskReference { position: wanted, velocity: [0.0; 3], acceleration: [0.0; 3] };
    let at_rest = |_| PoseReference::at_rest(Pose::from_translation(wanted));
    let mut tau = [0.0; 2];
    TaskControl::new(&model, tip, position, gains)?.with_rows(&[X, Z]).torque(0.0, &q, &v, &mut tau)?;
    let a = accelerate(&model, &q, &v, &tau);
    let moved = frame_acceleration(&model, w, &q, &v, &a, tip, ReferenceFrame::LocalWorldAligned).linear;
    for k in [0, 2] {
        let expected = 100.0 * (wanted[k] - pose.translation[k]) - 20.0 * velocity.linear[k];
        assert!((moved[k] - expected).abs() < 1e-9 * largest(&a), "{moved:?} {expected}");
    }
    // The forearm is at an angle of 1.2 about −y; the reference is at 0.
    TaskControl::new(&model, tip, at_rest, gains)?.with_rows(&[Ry, Z]).torque(0.0, &q, &v, &mut tau)?;
    let a = accelerate(&model, &q, &v, &tau);
    let moved = frame_acceleration(&model, w, &q, &v, &a, tip, ReferenceFrame::LocalWorldAligned);
    let turn = 100.0 * 1.2 - 20.0 * velocity.angular[1];
    assert!((moved.angular[1] - turn).abs() < 1e-9 * largest(&a), "{moved:?} {turn}");
    let lift = 100.0 * (wanted[2] - pose.translation[2]) - 20.0 * velocity.linear[2];
    assert!((moved.linear[2] - lift).abs() < 1e-9 * largest(&a), "{moved:?} {lift}");
    // The error names a direction in which the tip cannot move.
    for rows in [[X, Y], [Rx, Z]] {
        let error =
            TaskControl::new(&model, tip, at_rest, gains)?.with_rows(&rows).torque(0.0, &q, &v, &mut tau);
        let name = rows.iter().find(|row| [Y, Rx].contains(row)).expect("one of them").name();
        let error = error.unwrap_err();
        let ControllerError::SingularPose { row, .. } = error else { panic!("{error}") };
        assert_eq!(row, name);
    }
    Ok(())
}

/// Rows that a reference does not say anything about are a mistake of the caller.
#[test]
fn rows_of_other_target_panic() {
    let model = &robots()[0];
    let hand = model.frame(&model.frames()[1].name).expect("a frame");
    let position = |_| TaskReference { position: [0.0; 3], velocity: [0.0; 3], acceleration: [0.0; 3] };
    let gains = TaskGains { stiffness: 1.0, damping: 1.0, null_damping: 0.0 };
    let control = TaskControl::new(model, hand, position, gains).expect("finite gains");
    let rows = [robot_dynamics::constraints::SpatialAxis::X, robot_dynamics::constraints::SpatialAxis::Rx];
    let call = std::panic::AssertUnwindSafe(|| drop(control.with_rows(&rows)));
    assert!(std::panic::catch_unwind(call).is_err());
}
