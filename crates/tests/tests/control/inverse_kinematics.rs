//! Inverse kinematics against forward kinematics: targets in reach are found, other targets are approximated.

use nalgebra::Matrix3;
use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::control::{
    FrameTarget, InverseKinematicsError, InverseKinematicsOptions, InverseKinematicsSolution,
    inverse_kinematics,
};
use robot_dynamics::description::{
    Base, JointDescription, JointKind, JointKinds, Limits, LinkDescription, MassProperties, Mimic, Pose,
    RandomRobotOptions, RobotDescription, random_robot,
};
use robot_dynamics::model::{FrameId, Model, Workspace, check_configuration, neutral, random_within_limits};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{InputProblem, InvalidInput};

type LoadOptions = InverseKinematicsOptions;
type Error = InverseKinematicsError;

fn solve(
    model: &Model,
    frame: FrameId,
    target: impl Into<FrameTarget>,
    start: &[f64],
    options: &LoadOptions,
) -> Result<InverseKinematicsSolution, InverseKinematicsError> {
    inverse_kinematics(model, &mut Workspace::new(model), frame, target, start, options)
}

fn pose_of(model: &Model, q: &[f64], frame: FrameId) -> Pose {
    frame_pose(model, &mut Workspace::new(model), q, frame)
}

/// |p − p\*| and the angle θ of R\*ᵀR, by |R − R\*|² = 8 sin² ½θ, which is accurate for small angles.
fn distance(found: &Pose, wanted: &Pose) -> (f64, f64) {
    let off = |i: usize, j: usize| found.rotation[i][j] - wanted.rotation[i][j];
    let squared: f64 = (0..9).map(|k| off(k / 3, k % 3).powi(2)).sum();
    let angle = 2.0 * (squared / 8.0).sqrt().min(1.0).asin();
    let position = (0..3).map(|i| (found.translation[i] - wanted.translation[i]).powi(2)).sum::<f64>().sqrt();
    (position, angle)
}

/// Asserts that every coordinate is within its limits, mimic joints up to their rounding.
#[track_caller]
fn assert_within_limits(model: &Model, q: &[f64], context: &str) {
    check_configuration(model, q).unwrap_or_else(|error| panic!("{context}: {error}"));
    for joint in model.joints().iter().filter(|joint| joint.nq == joint.nv) {
        let values = match &joint.mimic {
            Some(_) => vec![mimic_value(model, joint, q)],
            None => q[joint.q()].to_vec(),
        };
        let rounding = if joint.mimic.is_some() { 1e-14 } else { 0.0 };
        let Limits { lower, upper, .. } = joint.limits;
        for x in values {
            assert!((lower - rounding..=upper + rounding).contains(&x), "{context}: `{}` at {x}", joint.name);
        }
    }
}

fn mimic_value(model: &Model, joint: &robot_dynamics::model::Joint, q: &[f64]) -> f64 {
    match &joint.mimic {
        Some(mimic) => mimic.ratio * mimic_value(model, model.joint(&mimic.joint).unwrap(), q) + mimic.offset,
        None => q[joint.q_index],
    }
}

/// Targets come from forward kinematics of random configurations within the limits, on robots with every kind
/// of joint. Each is reached from the neutral configuration, to the tolerance and within the limits.
#[test]
fn reachable_targets_are_reached() {
    let base = RandomRobotOptions { joints: 7, ..Default::default() };
    let arms = RandomRobotOptions { kinds: JointKinds::Turning, chain: 1.0, ..base.clone() };
    let families = [
        ("arms of six", RandomRobotOptions { joints: 6, ..arms.clone() }),
        ("arms of seven", arms.clone()),
        ("arms of twelve", RandomRobotOptions { joints: 12, ..arms }),
        ("trees of all joints", base.clone()),
        ("floating trees", RandomRobotOptions { base: Base::Floating, ..base.clone() }),
        ("slides and screws", RandomRobotOptions { kinds: JointKinds::SingleDof, ..base.clone() }),
        ("mimic joints", RandomRobotOptions { mimic: 0.4, chain: 0.9, ..base }),
    ];
    for (family, robots) in families {
        let (mut restarts, mut steps) = (0, 0);
        for seed in 0..40 {
            let model = Model::new(random_robot(seed, &robots)).unwrap();
            let mut random = SplitMix64::new(seed ^ 0x1f);
            let frames = model.frames();
            let hand = model.frame_named(&frames[frames.len() - 1 - (seed % 2) as usize].name).unwrap();
            // Mimic joints may have limits that a random configuration violates; then the next draw gives the
            // target.
            let wanted = (0..200).map(|_| random_within_limits(&model, &mut random)).find(|q| {
                model.joints().iter().filter(|joint| joint.mimic.is_some()).all(|joint| {
                    let x = mimic_value(&model, joint, q);
                    joint.limits.lower <= x && x <= joint.limits.upper
                })
            });
            let Some(wanted) = wanted else { continue };
            let target = pose_of(&model, &wanted, hand);
            let context = format!("{family}, seed {seed}");
            let found = solve(&model, hand, target, &neutral(&model), &LoadOptions::default())
                .unwrap_or_else(|error| panic!("{context}: {error}"));
            assert_within_limits(&model, &found.q, &context);
            let (position, angle) = distance(&pose_of(&model, &found.q, hand), &target);
            // The tolerance, and the rounding of a pose after twelve joints.
            assert!(position <= 1e-9 + 1e-14 && angle <= 1e-9 + 1e-14, "{context}: {position:e} {angle:e}");
            assert!(
                (position - found.position_error).abs() < 1e-14 && (angle - found.angle_error).abs() < 1e-14
            );

            let point = target.translation;
            let found_point = solve(&model, hand, point, &neutral(&model), &LoadOptions::default())
                .unwrap_or_else(|error| panic!("{context}, place: {error}"));
            assert_within_limits(&model, &found_point.q, &context);
            let (position, _) = distance(&pose_of(&model, &found_point.q, hand), &target);
            assert!(position <= 1e-9 + 1e-14 && found_point.angle_error == 0.0, "{context}: {position:e}");
            restarts += found.restarts;
            steps += found.iterations;
        }
        println!("{family}: {restarts} restarts, {steps} steps for 40 poses");
        assert!(restarts < 40 * 5, "{family}: {restarts} restarts for 40 poses");
    }
}

/// The solution near a start is found in few steps without a restart, as the last steps converge
/// quadratically.
#[test]
fn near_targets_take_few_steps() {
    let options =
        RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    for seed in 0..50 {
        let model = Model::new(random_robot(seed, &options)).unwrap();
        let mut random = SplitMix64::new(seed);
        let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name).unwrap();
        let start = random_within_limits(&model, &mut random).iter().map(|q| 0.8 * q).collect::<Vec<_>>();
        let near: Vec<f64> = start.iter().map(|q| q + random.uniform(-0.02, 0.02)).collect();
        let target = pose_of(&model, &near, hand);
        let found = solve(&model, hand, target, &start, &LoadOptions::default().with_restarts(0, 0))
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert!(found.iterations <= 8 && found.restarts == 0, "seed {seed}: {} steps", found.iterations);
        let moved = found.q.iter().zip(&start).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Each step is the smallest one, so the joints move by the distance of the target times a condition
        // number below a hundred.
        assert!(moved < 0.5, "seed {seed}: moved by {moved}");
    }
}

/// A target at the frame's current pose takes no step; a start outside the limits is moved onto them.
#[test]
fn solution_depends_on_start() {
    let model =
        Model::new(random_robot(4, &RandomRobotOptions { kinds: JointKinds::Turning, ..Default::default() }))
            .unwrap();
    let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name).unwrap();
    let q = vec![0.1; model.nq()];
    let found = solve(&model, hand, pose_of(&model, &q, hand), &q, &LoadOptions::default()).unwrap();
    assert_eq!((found.q, found.iterations, found.restarts), (q, 0, 0));
    let outside = vec![100.0; model.nq()];
    let target = pose_of(&model, &vec![0.2; model.nq()], hand);
    let found = solve(&model, hand, target, &outside, &LoadOptions::default()).unwrap();
    assert_within_limits(&model, &found.q, "from outside");
}

/// Rods of 1 m and 0.5 m on hinges about z, limits ±`limit`.
fn planar_arm(limit: f64) -> Model {
    let mut robot = RobotDescription::new("planar");
    let rod = MassProperties::new(1.0, [0.5, 0.0, 0.0].into(), Matrix3::identity()).ok();
    for (name, mass_properties) in [("base", None), ("upper", rod), ("fore", rod), ("hand", None)] {
        robot.links.push(LinkDescription::new(name, mass_properties));
    }
    let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    let mut add = |name: &str, kind, parent: &str, child: &str, x: f64| {
        let mut joint =
            JointDescription::new(name, kind, parent, child, Pose::from_translation([x, 0.0, 0.0]));
        if kind != JointKind::Fixed {
            (joint.limits.lower, joint.limits.upper) = (-limit, limit);
        }
        robot.joints.push(joint);
    };
    add("shoulder", hinge, "base", "upper", 0.0);
    add("elbow", hinge, "upper", "fore", 1.0);
    add("wrist", JointKind::Fixed, "fore", "hand", 0.5);
    Model::new(robot).unwrap()
}

/// A target out of reach is approximated as closely as possible: the stretched arm points at it, or the
/// joints are at their limits.
#[test]
fn unreachable_targets_are_approximated() {
    let best = |model: &Model, target: [f64; 3]| {
        let hand = model.frame_named("hand").unwrap();
        let options = LoadOptions::default().with_restarts(10, 3);
        match solve(model, hand, target, &[0.3, 0.4], &options) {
            Err(InverseKinematicsError::NoSolution { best, frame, robot }) => {
                assert_eq!((frame.as_str(), robot.as_str(), best.restarts), ("hand", "planar", 10));
                *best
            }
            other => panic!("{other:?}"),
        }
    };
    // The arm is 1.5 m long, the target 2 m away. The distance is flat at its minimum, so its position is
    // accurate to √ε only.
    let far = best(&planar_arm(3.0), [0.0, 2.0, 0.0]);
    assert!((far.position_error - 0.5).abs() < 1e-10, "{far:?}");
    assert!((far.q[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-5 && far.q[1].abs() < 1e-5, "{far:?}");
    // Out of the plane by 0.3 m.
    let above = best(&planar_arm(3.0), [0.9, 0.3, 0.3]);
    assert!((above.position_error - 0.3).abs() < 1e-10, "{above:?}");
    // No joint turns beyond ±1. The configuration nearest to (−1.5, 0) has both joints at a limit. The hand
    // is then at (cos 1 + ½ cos 2, sin 1 + ½ sin 2) or its mirror image.
    let held = best(&planar_arm(1.0), [-1.5, 0.0, 0.0]);
    let (x, y) = (1f64.cos() + 0.5 * 2f64.cos(), 1f64.sin() + 0.5 * 2f64.sin());
    assert_eq!((held.q[0].abs(), held.q[1]), (1.0, held.q[0]));
    assert!((held.position_error - (x + 1.5).hypot(y)).abs() < 1e-12, "{held:?}");
}

/// The leader keeps the limits of its mimic joint: here ±0.5 of a mimic joint at −2 q + 0.2.
#[test]
fn limits_of_mimic_joints_hold() {
    let mut robot = planar_arm(3.0).description().clone();
    let elbow = robot.joints.iter_mut().find(|joint| joint.name == "elbow").unwrap();
    elbow.mimic = Some(Mimic::new("shoulder", -2.0, 0.2));
    (elbow.limits.lower, elbow.limits.upper) = (-0.5, 0.5);
    let model = Model::new(robot).unwrap();
    let hand = model.frame_named("hand").unwrap();
    let error = solve(&model, hand, [-1.0, 0.5, 0.0], &[0.0], &LoadOptions::default()).unwrap_err();
    let InverseKinematicsError::NoSolution { best, .. } = error else { panic!("{error}") };
    // −0.5 ≤ −2 q + 0.2 ≤ 0.5: q is in [−0.15, 0.35], and the upper end is nearest.
    assert!((best.q[0] - 0.35).abs() < 1e-15, "{best:?}");
    let found = solve(&model, hand, pose_of(&model, &[0.3], hand), &[0.0], &LoadOptions::default()).unwrap();
    assert!((found.q[0] - 0.3).abs() < 1e-8, "{found:?}");
}

/// Equal seeds give equal solutions, bit for bit.
#[test]
fn equal_seeds_give_equal_solutions() {
    let options =
        RandomRobotOptions { joints: 6, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    let model = Model::new(random_robot(9, &options)).unwrap();
    let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name).unwrap();
    let target = pose_of(&model, &random_within_limits(&model, &mut SplitMix64::new(3)), hand);
    let once = solve(&model, hand, target, &neutral(&model), &LoadOptions::default());
    assert!(once.is_ok());
    assert_eq!(once, solve(&model, hand, target, &neutral(&model), &LoadOptions::default()));
}

#[test]
fn invalid_input_is_an_error() {
    let model = planar_arm(3.0);
    let hand = model.frame_named("hand").unwrap();
    let failed = |target: FrameTarget, start: &[f64], options: &LoadOptions| {
        solve(&model, hand, target, start, options).expect_err("invalid input")
    };
    let refused = |target: FrameTarget, start: &[f64], options: &LoadOptions| {
        let Error::Input(InvalidInput { quantity, problem, .. }) = failed(target, start, options) else {
            panic!("not an invalid input")
        };
        (quantity, problem)
    };
    let (good, start) = (FrameTarget::Position([1.0, 0.5, 0.0]), [0.1, 0.2]);
    assert!(solve(&model, hand, good, &start, &LoadOptions::default()).is_ok());
    let nan = FrameTarget::Position([0.0, f64::NAN, 0.0]);
    let (quantity, problem) = refused(nan, &start, &LoadOptions::default());
    assert_eq!(quantity, "the target's position");
    assert!(matches!(problem, InputProblem::NotFinite { index: Some(1), .. }), "{problem:?}");
    let mut pose = Pose::IDENTITY;
    pose.rotation[2][1] = f64::INFINITY;
    let (quantity, problem) = refused(pose.into(), &start, &LoadOptions::default());
    assert_eq!(quantity, "the target's rotation");
    let (index, coordinate, value) = (Some(7), None, f64::INFINITY);
    assert_eq!(problem, InputProblem::NotFinite { index, coordinate, value });
    pose.rotation[2][1] = 0.1;
    let (_, problem) = refused(pose.into(), &start, &LoadOptions::default());
    assert!(matches!(problem, InputProblem::NotARotation { .. }), "{problem:?}");
    let (quantity, problem) = refused(good, &[0.1, f64::NAN], &LoadOptions::default());
    assert_eq!(quantity, "the start's q");
    assert!(matches!(problem, InputProblem::NotFinite { index: Some(1), .. }), "{problem:?}");
    let (quantity, problem) = refused(good, &[0.1], &LoadOptions::default());
    assert_eq!(quantity, "the start's q");
    assert!(matches!(problem, InputProblem::WrongLength { found: 1, expected: 2, .. }), "{problem:?}");
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let (quantity, problem) = refused(good, &start, &LoadOptions::default().with_tolerances(1e-6, bad));
        assert_eq!(quantity, "the angle tolerance");
        assert!(matches!(problem, InputProblem::OutOfRange { .. }), "{problem:?}");
    }
    let error = failed(FrameTarget::Position([3.0, 0.0, 0.0]), &start, &LoadOptions::default());
    let Error::NoSolution { frame, robot, best } = &error else { panic!("{error}") };
    assert_eq!((frame.as_str(), robot.as_str()), ("hand", "planar"));
    assert!((best.position_error - 1.5).abs() < 1e-6, "{best:?}");
}

#[test]
fn frame_of_another_robot_panics() {
    let (one, other) = (planar_arm(3.0), planar_arm(2.0));
    let hand = other.frame_named("hand").unwrap();
    let call = std::panic::AssertUnwindSafe(|| {
        drop(solve(&one, hand, [1.0, 0.0, 0.0], &[0.0, 0.0], &LoadOptions::default()));
    });
    assert!(std::panic::catch_unwind(call).is_err());
}
