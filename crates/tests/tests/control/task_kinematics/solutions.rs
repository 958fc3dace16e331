//! Configurations for several tasks against forward kinematics.

use robot_dynamics::constraints::{ConstraintSet, Coupling, constraint_drift};
use robot_dynamics::control::task_kinematics::{
    KinematicObjective, KinematicTask, TaskKinematics, TaskKinematicsError,
};
use robot_dynamics::control::{InverseKinematicsOptions, inverse_kinematics};
use robot_dynamics::description::{Base, Pose};
use robot_dynamics::model::{FrameId, Model, Workspace, neutral};
use robot_dynamics::number::SplitMix64;

use super::{arm, last_frame, load, random_q, with_objective};

type Options = InverseKinematicsOptions;

fn pose(model: &Model, q: &[f64], frame: FrameId) -> Pose {
    model.frame_pose(q, frame).expect("a pose")
}

/// The distance of the origins, and the largest difference of the rotations' entries.
fn off(one: &Pose, two: &Pose) -> (f64, f64) {
    let position = (0..3).map(|i| (one.translation[i] - two.translation[i]).powi(2)).sum::<f64>().sqrt();
    let entries = (0..9).map(|k| (one.rotation[k / 3][k % 3] - two.rotation[k / 3][k % 3]).abs());
    (position, entries.fold(0.0, f64::max))
}

#[track_caller]
fn assert_within_limits(model: &Model, q: &[f64]) {
    for joint in model.joints().iter().filter(|joint| joint.nq == 1 && joint.mimic.is_none()) {
        let x = q[joint.q_index];
        assert!(x >= joint.limits.lower && x <= joint.limits.upper, "`{}` at {x}", joint.name);
    }
}

/// One pose of one frame, as for [`inverse_kinematics`].
#[test]
fn poses_are_reached_within_limits() {
    for seed in 0..20 {
        let model = arm(seed);
        let (hand, mut random) = (last_frame(&model), SplitMix64::new(seed));
        let target = pose(&model, &random_q(&model, &mut random), hand);
        let mut kinematics = with_objective(&model, KinematicObjective::pose(hand, target));
        let found = kinematics.solve(&neutral(&model), &Options::default()).expect("a solution");
        let (position, rotation) = off(&pose(&model, &found.q, hand), &target);
        assert!(position < 1.1e-9 && rotation < 1.1e-9, "seed {seed}: {position:e} {rotation:e}");
        assert_within_limits(&model, &found.q);
        let workspace = &mut Workspace::new(&model);
        let one = inverse_kinematics(&model, workspace, hand, target, &neutral(&model), &Options::default());
        assert!(one.is_ok());
    }
}

/// A hand, a second frame relative to it, and a posture at a later level.
#[test]
fn both_hands_hold_one_object() {
    let model = load("dual_arm.urdf", Base::Fixed);
    let frames: Vec<&str> = model.frames().iter().map(|frame| frame.name.as_str()).collect();
    let ends = ["left", "right"].map(|side| {
        let name = frames.iter().rev().find(|name| name.contains(side)).expect("a hand");
        model.frame_named(name).expect("a hand")
    });
    let mut random = SplitMix64::new(5);
    for _ in 0..5 {
        let wanted = random_q(&model, &mut random);
        let [left, right] = ends.map(|end| pose(&model, &wanted, end));
        let between = left.inverse().compose(&right);
        let mut kinematics = TaskKinematics::new(&model);
        kinematics.add_task(KinematicObjective::pose(ends[0], left)).expect("a task");
        kinematics.add_task(KinematicObjective::relative_pose(ends[1], ends[0], between)).expect("a task");
        let found = kinematics.solve(&neutral(&model), &Options::default()).expect("a solution");
        assert!(off(&pose(&model, &found.q, ends[0]), &left).0 < 1.1e-9);
        let (position, rotation) = off(&pose(&model, &found.q, ends[1]), &right);
        assert!(position < 4e-9 && rotation < 4e-9, "{position:e} {rotation:e}");
        assert_within_limits(&model, &found.q);
    }
}

/// The later level approaches its posture without moving the hand.
#[test]
fn postures_are_approached_in_the_null_space() {
    let model = load("panda.urdf", Base::Fixed);
    let hand = model.frame_named("panda_link8").expect("a frame");
    let start = [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8];
    let mut target = pose(&model, &start, hand);
    target.translation[1] += 0.2;
    let alone = with_objective(&model, KinematicObjective::pose(hand, target))
        .solve(&start, &Options::default())
        .expect("a solution");
    let wanted = [0.4, -0.2, 0.1, -2.0, 0.0, 1.9, 0.8];
    let mut kinematics = with_objective(&model, KinematicObjective::pose(hand, target));
    let posture = KinematicObjective::Posture { target: wanted.to_vec() };
    kinematics.add_task(KinematicTask::new(posture).with_level(1)).expect("a task");
    let found = kinematics.solve(&start, &Options::default()).expect("a solution");
    assert!(off(&pose(&model, &found.q, hand), &target).0 < 1.1e-9);
    let distance = |q: &[f64]| q.iter().zip(wanted).map(|(q, w)| (q - w).powi(2)).sum::<f64>();
    let best = distance(&found.q);
    assert!(best < distance(&alone.q) - 1e-3, "{best} and {}", distance(&alone.q));
    // Along the one motion that keeps the hand, the distance is stationary.
    let jacobian = kinematics.linearized_tasks(&found.q).expect("rows").remove(0).jacobian;
    let gradient = nalgebra::DVector::from_iterator(7, found.q.iter().zip(wanted).map(|(q, w)| q - w));
    let rows = jacobian.svd(true, true).v_t.expect("V");
    let rest = &gradient - rows.transpose() * (&rows * &gradient);
    assert!(rest.amax() < 1e-4, "{rest}");
}

/// The axis of the hand points at a point, and the centre of mass is where it should be.
#[test]
fn axes_point_and_masses_balance() {
    let model = load("panda.urdf", Base::Fixed);
    let hand = model.frame_named("panda_link8").expect("a frame");
    let start = [0.3, -0.4, 0.2, -2.2, 0.1, 1.9, 0.8];
    let point = [1.0, 0.5, 0.2];
    let look = KinematicObjective::LookAt { frame: hand, axis: [0.0, 0.0, 1.0], point };
    let mut kinematics = with_objective(&model, look);
    let center = model.center_of_mass(&start).expect("a centre");
    let wanted = [center[0] + 0.02, center[1] - 0.03, center[2] + 0.01];
    kinematics.add_task(KinematicObjective::center_of_mass(wanted)).expect("a task");
    let found = kinematics.solve(&start, &Options::default()).expect("a solution");
    let reached = pose(&model, &found.q, hand);
    let away: Vec<f64> = (0..3).map(|i| point[i] - reached.translation[i]).collect();
    let length = away.iter().map(|x| x * x).sum::<f64>().sqrt();
    for i in 0..3 {
        assert!((reached.rotation[i][2] - away[i] / length).abs() < 1.1e-9);
    }
    let center = model.center_of_mass(&found.q).expect("a centre");
    assert!((0..3).all(|i| (center[i] - wanted[i]).abs() < 1.1e-9));
}

/// A point of the coupler of a four-bar linkage, with its loop closed.
#[test]
fn closed_loops_hold() {
    let model = load("linkage.xml", Base::Fixed);
    let set = ConstraintSet::from_equalities(&model).expect("a loop");
    let mut kinematics = with_objective(&model, KinematicObjective::Constraints(set.clone()));
    let crank = Coupling::new(&model, &[("crank", 1.0)], 0.3).expect("a coordinate");
    let crank = ConstraintSet::new(&model, [("crank", crank.into())]).expect("a set");
    kinematics.add_task(KinematicObjective::Constraints(crank)).expect("a task");
    let found = kinematics.solve(&neutral(&model), &Options::default()).expect("a solution");
    let drift = constraint_drift(&model, &mut Workspace::new(&model), &set, &found.q, &[0.0; 3]);
    assert!(drift.position < 1e-9 && (found.q[0] - 0.3).abs() < 1e-9, "{drift:?} {:?}", found.q);
    // From there steps turn the crank back, and the loop stays closed: it is a level before the posture.
    let mut kinematics = with_objective(&model, KinematicObjective::Constraints(set.clone()));
    let posture = KinematicTask::new(KinematicObjective::Posture { target: vec![0.0; 3] });
    kinematics.add_task(posture.with_level(1).with_gain(0.1)).expect("a task");
    let (mut q, v) = (found.q, vec![0.0; 3]);
    for _ in 0..200 {
        q.clone_from(&kinematics.step(&q, &v, 0.01).expect("a step").q);
        let drift = constraint_drift(&model, &mut Workspace::new(&model), &set, &q, &[0.0; 3]);
        // A step of 0.03 rad leaves its curvature, ½ 0.03² of half a metre; the next step removes it.
        assert!(drift.position < 5e-4, "{drift:?}");
    }
    assert!(q.iter().all(|q| q.abs() < 1e-6), "{q:?}");
}

/// Results do not depend on the number of threads, bit for bit.
#[test]
fn threads_do_not_change_results() {
    let model = load("panda.urdf", Base::Fixed);
    let hand = model.frame_named("panda_link8").expect("a frame");
    let mut random = SplitMix64::new(8);
    let targets: Vec<Pose> = (0..12).map(|_| pose(&model, &random_q(&model, &mut random), hand)).collect();
    let mut kinematics = TaskKinematics::new(&model);
    let task = kinematics.add_task(KinematicObjective::pose(hand, targets[0])).expect("a task");
    let solve = |threads: usize| {
        kinematics.solve_many(12, threads, &Options::default(), |i, own| {
            *own.objective_mut(task) = KinematicObjective::pose(hand, targets[i]);
            neutral(&model)
        })
    };
    let one = solve(1);
    for solution in &one {
        assert!(solution.is_ok(), "{solution:?}");
    }
    for threads in [2, 3, 12] {
        assert_eq!(one, solve(threads), "{threads} threads");
    }
}

/// The error names the task, its distance, and the coordinates at their limits.
#[test]
fn failures_name_their_reasons() {
    let model = load("panda.urdf", Base::Fixed);
    let hand = model.frame_named("panda_link8").expect("a frame");
    let mut kinematics = with_objective(&model, KinematicObjective::pose(hand, [3.0, 0.0, 0.333]));
    let mut limits = kinematics.limits().clone();
    limits.position[1] = [-0.1, 0.1];
    kinematics.set_limits(limits.clone()).expect("valid limits");
    let options = Options::default().with_restarts(3, 1);
    match kinematics.solve(&neutral(&model), &options) {
        Err(TaskKinematicsError::Unreached { unreached, best, restarts, limits: named, .. }) => {
            assert_eq!((unreached.len(), restarts), (1, 3));
            assert!(unreached[0].contains("panda_link8"), "{unreached:?}");
            let reached = pose(&model, &best.q, hand).translation;
            let distance =
                ((3.0 - reached[0]).powi(2) + reached[1].powi(2) + (0.333 - reached[2]).powi(2)).sqrt();
            assert!((best.errors[0].position - distance).abs() < 1e-12);
            let at_limit = best.q.iter().zip(&limits.position).filter(|(q, limits)| limits.contains(q));
            assert_eq!(named.len(), at_limit.count());
            // The shoulder would turn down by 90 degrees.
            assert_eq!(best.q[1].abs(), 0.1);
            assert!(named.iter().any(|name| name.contains("joint2")), "{named:?}");
        }
        other => panic!("{other:?}"),
    }
}
