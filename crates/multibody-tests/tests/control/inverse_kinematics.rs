//! Inverse kinematics against forward kinematics: what is reachable is reached, what is not is approached.

use dynamics::{MassProperties, SplitMix64};
use multibody::{
    Base, FrameId, FrameTarget, InverseKinematicsError, InverseKinematicsOptions, InverseKinematicsSolution,
    JointDescription, JointKind, JointKinds, Limits, LinkDescription, Mimic, Model, Pose, RandomRobotOptions,
    RobotDescription, Workspace, check_configuration, frame_pose, inverse_kinematics, neutral, random_robot,
    random_within_limits,
};
use nalgebra::Matrix3;

type Options = InverseKinematicsOptions;

fn solve(
    model: &Model,
    frame: FrameId,
    target: impl Into<FrameTarget>,
    start: &[f64],
    options: &Options,
) -> Result<InverseKinematicsSolution, InverseKinematicsError> {
    inverse_kinematics(model, &mut Workspace::new(model), frame, target, start, options)
}

fn pose_of(model: &Model, q: &[f64], frame: FrameId) -> Pose {
    frame_pose(model, &mut Workspace::new(model), q, frame).into()
}

/// |p − p\*| and the angle θ of R\*ᵀR, by |R − R\*|² = 8 sin² ½θ, which sees small angles too.
fn distance(found: &Pose, wanted: &Pose) -> (f64, f64) {
    let off = |i: usize, j: usize| found.rotation[i][j] - wanted.rotation[i][j];
    let squared: f64 = (0..9).map(|k| off(k / 3, k % 3).powi(2)).sum();
    let angle = 2.0 * (squared / 8.0).sqrt().min(1.0).asin();
    let position = (0..3).map(|i| (found.translation[i] - wanted.translation[i]).powi(2)).sum::<f64>().sqrt();
    (position, angle)
}

/// Asserts that every coordinate, those of followers too, is within its limits, exactly but for a follower's rounding.
#[track_caller]
fn assert_within_limits(model: &Model, q: &[f64], context: &str) {
    check_configuration(model, q).unwrap_or_else(|error| panic!("{context}: {error}"));
    for joint in model.joints().iter().filter(|joint| joint.nq == joint.nv) {
        let values = match &joint.mimic {
            Some(_) => vec![follower_value(model, joint, q)],
            None => q[joint.q_index..joint.q_index + joint.nq].to_vec(),
        };
        let rounding = if joint.mimic.is_some() { 1e-14 } else { 0.0 };
        let Limits { lower, upper, .. } = joint.limits;
        for x in values {
            assert!((lower - rounding..=upper + rounding).contains(&x), "{context}: `{}` at {x}", joint.name);
        }
    }
}

fn follower_value(model: &Model, joint: &multibody::Joint, q: &[f64]) -> f64 {
    match &joint.mimic {
        Some(mimic) => {
            mimic.ratio * follower_value(model, model.joint(&mimic.joint).unwrap(), q) + mimic.offset
        }
        None => q[joint.q_index],
    }
}

/// Targets by forward kinematics of random configurations within the limits, on robots of every kind of joint: each is
/// reached from the neutral configuration, to the tolerance, within the limits, whatever its followers.
#[test]
fn what_is_reachable_is_reached() {
    let base = RandomRobotOptions { joints: 7, ..Default::default() };
    let arms = RandomRobotOptions { kinds: JointKinds::Turning, chain: 1.0, ..base.clone() };
    let families = [
        ("arms of six", RandomRobotOptions { joints: 6, ..arms.clone() }),
        ("arms of seven", arms.clone()),
        ("arms of twelve", RandomRobotOptions { joints: 12, ..arms }),
        ("trees of all joints", base.clone()),
        ("floating trees", RandomRobotOptions { base: Base::Floating, ..base.clone() }),
        ("slides and screws", RandomRobotOptions { kinds: JointKinds::SingleFreedom, ..base.clone() }),
        ("followers", RandomRobotOptions { mimic: 0.4, chain: 0.9, ..base }),
    ];
    for (family, robots) in families {
        let (mut restarts, mut steps) = (0, 0);
        for seed in 0..40 {
            let model = Model::new(random_robot(seed, &robots)).unwrap();
            let mut random = SplitMix64::new(seed ^ 0x1f);
            let frames = model.frames();
            let hand = model.frame_named(&frames[frames.len() - 1 - (seed % 2) as usize].name).unwrap();
            // Followers may have limits that their leaders' do not keep: then the target is that of the next draw.
            let wanted = (0..200).map(|_| random_within_limits(&model, &mut random)).find(|q| {
                model.joints().iter().filter(|joint| joint.mimic.is_some()).all(|joint| {
                    let x = follower_value(&model, joint, q);
                    joint.limits.lower <= x && x <= joint.limits.upper
                })
            });
            let Some(wanted) = wanted else { continue };
            let target = pose_of(&model, &wanted, hand);
            let context = format!("{family}, seed {seed}");
            let found = solve(&model, hand, target, &neutral(&model), &Options::default())
                .unwrap_or_else(|error| panic!("{context}: {error}"));
            assert_within_limits(&model, &found.q, &context);
            let (position, angle) = distance(&pose_of(&model, &found.q, hand), &target);
            // The tolerance, and the rounding of a pose behind twelve joints.
            assert!(position <= 1e-9 + 1e-14 && angle <= 1e-9 + 1e-14, "{context}: {position:e} {angle:e}");
            assert!(
                (position - found.position_error).abs() < 1e-14 && (angle - found.angle_error).abs() < 1e-14
            );

            let point = target.translation;
            let found_point = solve(&model, hand, point, &neutral(&model), &Options::default())
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

/// Near the start the solution is near, found in few steps without a restart: the last ones square the error.
#[test]
fn a_short_way_takes_few_steps() {
    let options =
        RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    for seed in 0..50 {
        let model = Model::new(random_robot(seed, &options)).unwrap();
        let mut random = SplitMix64::new(seed);
        let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name).unwrap();
        let start = random_within_limits(&model, &mut random).iter().map(|q| 0.8 * q).collect::<Vec<_>>();
        let near: Vec<f64> = start.iter().map(|q| q + random.uniform(-0.02, 0.02)).collect();
        let target = pose_of(&model, &near, hand);
        let found = solve(&model, hand, target, &start, &Options::default().with_restarts(0, 0))
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert!(found.iterations <= 8 && found.restarts == 0, "seed {seed}: {} steps", found.iterations);
        let moved = found.q.iter().zip(&start).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Each step is the smallest one, so the joints move by what is asked times a condition number of some tens.
        assert!(moved < 0.5, "seed {seed}: moved by {moved}");
    }
}

/// A target where the frame already is takes no step, a start outside the limits is moved to them.
#[test]
fn the_start_counts() {
    let model =
        Model::new(random_robot(4, &RandomRobotOptions { kinds: JointKinds::Turning, ..Default::default() }))
            .unwrap();
    let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name).unwrap();
    let q = vec![0.1; model.nq()];
    let found = solve(&model, hand, pose_of(&model, &q, hand), &q, &Options::default()).unwrap();
    assert_eq!((found.q, found.iterations, found.restarts), (q, 0, 0));
    let outside = vec![100.0; model.nq()];
    let target = pose_of(&model, &vec![0.2; model.nq()], hand);
    let found = solve(&model, hand, target, &outside, &Options::default()).unwrap();
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

/// What is out of reach is approached as near as can be: the stretched arm points at it, or the shoulder stands at its limit.
#[test]
fn what_is_out_of_reach_is_approached() {
    let best = |model: &Model, target: [f64; 3]| {
        let hand = model.frame_named("hand").unwrap();
        let options = Options::default().with_restarts(10, 3);
        match solve(model, hand, target, &[0.3, 0.4], &options) {
            Err(InverseKinematicsError::NoSolution { best, frame, robot }) => {
                assert_eq!((frame.as_str(), robot.as_str(), best.restarts), ("hand", "planar", 10));
                *best
            }
            other => panic!("{other:?}"),
        }
    };
    // 1.5 m of arm, 2 m away; a distance is flat at its least, so its place is known to √ε only.
    let far = best(&planar_arm(3.0), [0.0, 2.0, 0.0]);
    assert!((far.position_error - 0.5).abs() < 1e-10, "{far:?}");
    assert!((far.q[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-5 && far.q[1].abs() < 1e-5, "{far:?}");
    // Off the plane by 0.3 m.
    let above = best(&planar_arm(3.0), [0.9, 0.3, 0.3]);
    assert!((above.position_error - 0.3).abs() < 1e-10, "{above:?}");
    // Neither joint turns beyond ±1: the nearest to (−1.5, 0) is at both limits, where the hand is at
    // (cos 1 + ½ cos 2, sin 1 + ½ sin 2) or its mirror image.
    let held = best(&planar_arm(1.0), [-1.5, 0.0, 0.0]);
    let (x, y) = (1f64.cos() + 0.5 * 2f64.cos(), 1f64.sin() + 0.5 * 2f64.sin());
    assert_eq!((held.q[0].abs(), held.q[1]), (1.0, held.q[0]));
    assert!((held.position_error - (x + 1.5).hypot(y)).abs() < 1e-12, "{held:?}");
}

/// A follower's limits are kept by its leader: here ±0.5 of a follower that goes −2 q + 0.2.
#[test]
fn limits_of_followers_hold() {
    let mut robot = planar_arm(3.0).description().clone();
    let elbow = robot.joints.iter_mut().find(|joint| joint.name == "elbow").unwrap();
    elbow.mimic = Some(Mimic::new("shoulder", -2.0, 0.2));
    (elbow.limits.lower, elbow.limits.upper) = (-0.5, 0.5);
    let model = Model::new(robot).unwrap();
    let hand = model.frame_named("hand").unwrap();
    let error = solve(&model, hand, [-1.0, 0.5, 0.0], &[0.0], &Options::default()).unwrap_err();
    let InverseKinematicsError::NoSolution { best, .. } = error else { panic!("{error}") };
    // −0.5 ≤ −2 q + 0.2 ≤ 0.5: q in [−0.15, 0.35], and the upper end is nearest.
    assert!((best.q[0] - 0.35).abs() < 1e-15, "{best:?}");
    let found = solve(&model, hand, pose_of(&model, &[0.3], hand), &[0.0], &Options::default()).unwrap();
    assert!((found.q[0] - 0.3).abs() < 1e-8, "{found:?}");
}

/// Equal seeds give equal solutions, bit by bit.
#[test]
fn a_solution_is_the_same_twice() {
    let options =
        RandomRobotOptions { joints: 6, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
    let model = Model::new(random_robot(9, &options)).unwrap();
    let hand = model.frame_named(&model.frames()[model.frames().len() - 1].name).unwrap();
    let target = pose_of(&model, &random_within_limits(&model, &mut SplitMix64::new(3)), hand);
    let once = solve(&model, hand, target, &neutral(&model), &Options::default());
    assert!(once.is_ok());
    assert_eq!(once, solve(&model, hand, target, &neutral(&model), &Options::default()));
}

#[test]
fn what_is_no_problem_is_refused() {
    let model = planar_arm(3.0);
    let hand = model.frame_named("hand").unwrap();
    let message = |target: FrameTarget, start: &[f64], options: &Options| {
        solve(&model, hand, target, start, options).expect_err("no problem").to_string()
    };
    let (good, start) = (FrameTarget::Position([1.0, 0.5, 0.0]), [0.1, 0.2]);
    assert!(solve(&model, hand, good, &start, &Options::default()).is_ok());
    let nan = FrameTarget::Position([0.0, f64::NAN, 0.0]);
    let found = message(nan, &start, &Options::default());
    assert_eq!(found, "the target's position[1] is NaN; every number must be finite");
    let mut pose = Pose::IDENTITY;
    pose.rotation[2][1] = f64::INFINITY;
    assert!(message(pose.into(), &start, &Options::default()).contains("rotation[7] is inf"));
    pose.rotation[2][1] = 0.1;
    assert!(message(pose.into(), &start, &Options::default()).contains("not orthonormal"));
    assert!(
        message(good, &[0.1, f64::NAN], &Options::default())
            .contains("the start: q[1] (joint `elbow`) is NaN")
    );
    assert!(message(good, &[0.1], &Options::default()).contains("q has 1 numbers"));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = message(good, &start, &Options::default().with_tolerances(1e-6, bad));
        assert!(found.contains("the angle tolerance is"), "{found}");
    }
    let far = message(FrameTarget::Position([3.0, 0.0, 0.0]), &start, &Options::default());
    assert!(far.contains("frame `hand` of robot `planar` came no nearer than 1.5e0 m"), "{far}");
}

#[test]
#[should_panic(expected = "the frame is another robot's")]
fn a_frame_of_another_robot_is_refused() {
    let (one, other) = (planar_arm(3.0), planar_arm(2.0));
    let _ =
        solve(&one, other.frame_named("hand").unwrap(), [1.0, 0.0, 0.0], &[0.0, 0.0], &Options::default());
}
