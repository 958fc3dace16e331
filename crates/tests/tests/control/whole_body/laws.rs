//! Equality with other control laws where no limit is active, statics, and priorities.

use robot_dynamics::algorithms::{ReferenceFrame, center_of_mass, frame_acceleration, frame_pose};
use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::whole_body::{ALL_AXES, WholeBodyLimits};
use robot_dynamics::control::{ComputedTorque, PoseReference, TaskControl, TaskGains, TaskReference};
use robot_dynamics::simulation::Controller;

use super::*;

const GAINS: PdGains = PdGains { stiffness: 100.0, damping: 20.0 };

/// A posture alone gives the computed torque; a pose alone gives the operational-space law of a robot with
/// six joints. Both also with damping and friction compensated.
#[test]
fn laws_without_active_limits_are_those_of_other_controllers() {
    for (file, hand) in [("ur5.urdf", "tool0"), ("panda.urdf", "panda_link8")] {
        let model = load(file, Base::Fixed);
        let nv = model.nv();
        let home = vec![0.4; nv];
        for seed in 0..5 {
            let (q, v) = near(&model, &home, 0.1, seed);
            let mut control = WholeBodyControl::new(&model);
            control.set_limits(WholeBodyLimits::none(&model)).expect("no limits");
            control.add_task(posture(&model, &home, 100.0), 3.0).expect("a task");
            let Objective::Posture { reference, .. } = posture(&model, &home, 100.0) else {
                unreachable!("a posture")
            };
            let (stiffness, damping) = (vec![100.0; nv], vec![20.0; nv]);
            let mut other =
                ComputedTorque::new(&model, |_| reference.clone(), &stiffness, &damping).expect("a law");
            let (mut own, mut expected) = (vec![0.0; nv], vec![0.0; nv]);
            control.torque(0.0, &q, &v, &mut own).expect("a torque");
            other.torque(0.0, &q, &v, &mut expected).expect("a torque");
            let size = largest(expected.iter().copied());
            // The regularization of 1e-8 acts twice before the change of z is negligible.
            assert!(largest(own.iter().zip(&expected).map(|(a, b)| a - b)) < 1e-10 * size, "{file}");
            let mut with = WholeBodyControl::new(&model).with_dissipation();
            with.set_limits(WholeBodyLimits::none(&model)).expect("no limits");
            with.add_task(posture(&model, &home, 100.0), 3.0).expect("a task");
            let mut other = ComputedTorque::new(&model, |_| reference.clone(), &stiffness, &damping)
                .expect("a law")
                .with_dissipation();
            with.torque(0.0, &q, &v, &mut own).expect("a torque");
            other.torque(0.0, &q, &v, &mut expected).expect("a torque");
            assert!(largest(own.iter().zip(&expected).map(|(a, b)| a - b)) < 1e-10 * size, "{file}");
        }
        if nv > 6 {
            continue;
        }
        let frame = model.frame(hand).or_else(|| model.frame(&model.frames().last()?.name)).expect("a hand");
        for seed in 0..5 {
            let (q, v) = near(&model, &home, 0.1, seed);
            let target =
                PoseReference::at_rest(frame_pose(&model, &mut Workspace::new(&model), &home, frame));
            let mut control = WholeBodyControl::new(&model);
            control.set_limits(WholeBodyLimits::none(&model)).expect("no limits");
            let pose =
                Objective::FramePose { frame, axes: ALL_AXES.to_vec(), reference: target, gains: GAINS };
            control.add_task(pose, 1.0).expect("a task");
            let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 0.0 };
            let mut other = TaskControl::new(&model, frame, |_| target, gains).expect("a law");
            let (mut own, mut expected) = (vec![0.0; nv], vec![0.0; nv]);
            control.torque(0.0, &q, &v, &mut own).expect("a torque");
            other.torque(0.0, &q, &v, &mut expected).expect("a torque");
            let size = largest(expected.iter().copied());
            // The condition number of J Jᵀ is below 1e4.
            assert!(largest(own.iter().zip(&expected).map(|(a, b)| a - b)) < 1e-8 * size, "{file} {seed}");
        }
    }
}

/// At rest the feet carry the weight, inside their cones, and the motors' torques balance it.
#[test]
fn a_standing_quadruped_carries_its_weight() {
    let model = quadruped();
    let q = standing(&model);
    let rest = vec![0.0; model.nv()];
    let mut control = on_feet(&model, 0.5);
    control.add_task(posture(&model, &q, 100.0), 1.0).expect("a task");
    control.add_task_at(1, Objective::ContactForces, 1.0).expect("a task");
    let solution = control.solve(&q, &rest).expect("a solution");
    let sum = |k: usize| solution.forces.iter().map(|point| point.force[k]).sum::<f64>();
    let weight = model.mass() * 9.81;
    // Forces of 100 N with eleven digits.
    assert!(sum(0).abs() < 1e-9 * weight && sum(1).abs() < 1e-9 * weight);
    assert!((sum(2) - weight).abs() < 1e-9 * weight);
    let c = center_of_mass(&model, &mut Workspace::new(&model), &q);
    for axis in 0..2 {
        let moment: f64 = solution.forces.iter().map(|p| (p.position[axis] - c[axis]) * p.force[2]).sum();
        let height: f64 = solution.forces.iter().map(|p| (p.position[2] - c[2]) * p.force[axis]).sum();
        assert!((moment - height).abs() < 1e-9 * weight, "the moment about the centre of mass");
    }
    for point in &solution.forces {
        assert!(point.force[0].hypot(point.force[1]) < 0.5 * point.force[2]);
        assert!(point.position[2].abs() < 1e-12, "the lowest point of the ball is on the ground");
    }
    assert!(largest(solution.acceleration.iter().copied()) < 1e-8);
    assert!(solution.active_limits.is_empty());
    let forces = forces_at(&frames(&model, &FEET), solution);
    let tau = torque_of(&model, (&q, &rest, &solution.acceleration), &forces);
    assert!(largest(tau[..6].iter().copied()) < 1e-9 * weight);
}

/// A released foot has no force and follows its task, while three feet carry the weight.
#[test]
fn a_released_foot_follows_its_task() {
    let model = quadruped();
    let q = standing(&model);
    let rest = vec![0.0; model.nv()];
    let mut control = WholeBodyControl::new(&model);
    let mut contacts = Vec::new();
    for foot in FEET {
        let frame = model.frame_named(foot).expect("a foot");
        contacts.push(
            control.add_contact(HeldContact::new(frame, ContactGeometry::Ball(RADIUS))).expect("a contact"),
        );
    }
    let foot = model.frame_named(FEET[0]).expect("a foot");
    let mut target = PoseReference::at_rest(frame_pose(&model, &mut Workspace::new(&model), &q, foot));
    target.acceleration.linear = [0.5, 0.0, 2.0];
    let axes = ALL_AXES[..3].to_vec();
    control
        .add_task(Objective::FramePose { frame: foot, axes, reference: target, gains: GAINS }, 1e2)
        .unwrap();
    control.add_task(posture(&model, &q, 100.0), 1e-4).expect("a task");
    let four = control.solve(&q, &rest).expect("four feet").forces.len();
    control.hold_contact(contacts[0], false);
    let solution = control.solve(&q, &rest).expect("three feet");
    assert_eq!((four, solution.forces.len()), (4, 3));
    let a = &solution.acceleration;
    let aligned = ReferenceFrame::LocalWorldAligned;
    let w = &mut Workspace::new(&model);
    let found = frame_acceleration(&model, w, &q, &rest, a, foot, aligned).linear;
    // The weights differ by 1e6; the posture asks for accelerations of order 1.
    assert!(largest((0..3).map(|k| found[k] - target.acceleration.linear[k])) < 1e-3);
    assert!(solution.forces.iter().all(|point| point.contact != contacts[0]));
    control.hold_contact(contacts[0], true);
    assert_eq!(control.solve(&q, &rest).expect("four feet").forces.len(), 4);
}

/// Tasks of a lower level do not change the errors of the levels above, with and without active limits.
#[test]
fn lower_levels_do_not_disturb_higher_ones() {
    let model = quadruped();
    let home = standing(&model);
    let trunk = model.frame_named("trunk").expect("a trunk");
    let mut saturated = 0;
    for seed in 0..10 {
        let (q, v) = near(&model, &home, 0.08, seed);
        let w = &mut Workspace::new(&model);
        let mut target = PoseReference::at_rest(frame_pose(&model, w, &home, trunk));
        // Twice that of gravity saturates torques at odd seeds.
        target.acceleration.linear[2] = if seed % 2 == 1 { 60.0 } else { 0.5 };
        let pose = |axes: &[SpatialAxis]| Objective::FramePose {
            frame: trunk,
            axes: axes.to_vec(),
            reference: target,
            gains: GAINS,
        };
        let c = center_of_mass(&model, w, &home);
        let rest = [0.0; 3];
        let point = TaskReference { position: [c[0] + 0.02, c[1], c[2]], velocity: rest, acceleration: rest };
        let tasks = [
            (0, pose(&ALL_AXES[2..3]), 2.0),
            (1, pose(&ALL_AXES[3..]), 1.0),
            (2, Objective::CenterOfMass { reference: point, gains: GAINS }, 10.0),
            (3, posture(&model, &home, 50.0), 1.0),
            (7, Objective::ContactForces, 1.0),
        ];
        let mut before: Vec<f64> = Vec::new();
        let mut is_saturated = false;
        for count in 1..=tasks.len() {
            let mut control = on_feet(&model, 0.7);
            // The order of the calls does not matter.
            let mut ids: Vec<_> = tasks[..count]
                .iter()
                .rev()
                .map(|(level, objective, weight)| {
                    control.add_task_at(*level, objective.clone(), *weight).expect("a task")
                })
                .collect();
            ids.reverse();
            let Ok(solution) = control.solve(&q, &v) else { break };
            let errors: Vec<f64> = ids.iter().map(|id| solution.task_errors[id.index()]).collect();
            for (k, (own, before)) in errors.iter().zip(&before).enumerate() {
                assert!((own - before).abs() < 1e-8 * (1.0 + before), "{seed}: level {k} of {count}");
            }
            is_saturated |= !solution.active_limits.is_empty();
            before = errors;
        }
        saturated += usize::from(is_saturated && before.len() == tasks.len());
    }
    assert!(saturated >= 3, "{saturated}");
}

/// Both feet of a humanoid are held flat. At rest they carry its weight, and the centre of pressure of each
/// foot is inside its sole.
#[test]
fn a_humanoid_stands_on_its_soles() {
    let model = load("humanoid.urdf", Base::Floating);
    let q = neutral(&model);
    let rest = vec![0.0; model.nv()];
    let mut control = WholeBodyControl::new(&model);
    let corners: Vec<[f64; 3]> = [[0.15, 0.045], [0.15, -0.045], [-0.06, 0.045], [-0.06, -0.045]]
        .map(|[x, y]| [x, y, -0.06825])
        .to_vec();
    for foot in ["left_foot", "right_foot"] {
        let frame = model.frame_named(foot).expect("a foot");
        control
            .add_contact(HeldContact::new(frame, ContactGeometry::Face(corners.clone())))
            .expect("a contact");
    }
    control.add_task(posture(&model, &q, 50.0), 1.0).expect("a task");
    let solution = control.solve(&q, &rest).expect("a solution");
    let weight = model.mass() * 9.81;
    let carried: f64 = solution.forces.iter().map(|point| point.force[2]).sum();
    assert!((carried - weight).abs() < 1e-9 * weight);
    assert_eq!(solution.forces.len(), 8);
    assert!(solution.forces.iter().all(|point| point.force[2] >= -1e-7));
    assert!(largest(solution.acceleration.iter().copied()) < 1e-7);
    let w = &mut Workspace::new(&model);
    for foot in frames(&model, &["left_foot", "right_foot"]) {
        let aligned = ReferenceFrame::LocalWorldAligned;
        let rate = frame_acceleration(&model, w, &q, &rest, &solution.acceleration, foot, aligned);
        assert!(largest([rate.linear, rate.angular].concat()) < 1e-8);
    }
}
