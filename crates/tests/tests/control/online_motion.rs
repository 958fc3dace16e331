//! Online motion: durations and states of Ruckig, limits, continuity over new targets, errors.

use std::error::Error;
use std::path::Path;

use robot_dynamics::control::online_motion::{OnlineLimits, OnlineMotion, OnlineMotionError, Progress};
use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
use robot_dynamics::model::Model;
use robot_dynamics::number::SplitMix64;
use serde_json::Value;

type Tested = Result<(), Box<dyn Error>>;

fn robot(joints: usize) -> Model {
    let options = RandomRobotOptions { kinds: JointKinds::Turning, joints, ..Default::default() };
    Model::new(random_robot(3, &options)).expect("a robot")
}

fn three(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Durations and states of the wheel `ruckig`, at rest and in motion, from random states to random targets.
#[test]
fn motions_are_those_of_ruckig() -> Tested {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/online_motion/golden.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let model = robot(3);
    let cases = golden["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 300);
    for case in cases {
        let limits =
            OnlineLimits::new(three(&case["velocity"]), three(&case["acceleration"]), three(&case["jerk"]));
        let state = |of: &str| ["q", "v", "a"].map(|name| three(&case[of][name]));
        let duration = case["duration"].as_f64().expect("a number");
        // One step of a third of the duration.
        let mut motion = OnlineMotion::new(&model, limits, duration / 3.0)?;
        let ([q, v, a], [to_q, to_v, to_a]) = (state("start"), state("target"));
        motion.set_state(&q, &v, &a)?;
        motion.set_target(&to_q, &to_v, &to_a)?;
        // Both solve quartic equations by Newton's method to about 1e-9.
        let found = motion.plan()?;
        assert!((found - duration).abs() < 1e-8 * duration, "{found} {case}");
        motion.step()?;
        for (found, expected) in [motion.q(), motion.v(), motion.a()].into_iter().zip(state("third")) {
            assert!(crate::common::max_difference(found, &expected) < 1e-6, "{found:?} {case}");
        }
    }
    Ok(())
}

/// q, v and a obey their limits at every step, change by no more than the limits allow, and are the target in
/// the end, although the target changes on the way.
#[test]
fn limits_hold_over_new_targets() -> Tested {
    let (joints, period) = (4, 2e-3);
    let model = robot(joints);
    let random = &mut SplitMix64::new(77);
    let mut draw =
        |low: f64, high: f64| -> Vec<f64> { (0..joints).map(|_| random.uniform(low, high)).collect() };
    for _ in 0..40 {
        let limits = OnlineLimits::new(draw(0.5, 2.0), draw(1.0, 5.0), draw(5.0, 50.0));
        let mut motion = OnlineMotion::new(&model, limits.clone(), period)?;
        motion.set_state(&draw(-1.0, 1.0), &vec![0.0; joints], &vec![0.0; joints])?;
        let mut last: [Vec<f64>; 3] = [motion.q(), motion.v(), motion.a()].map(<[f64]>::to_vec);
        for target in 0..5 {
            let (q, v) = (draw(-1.5, 1.5), draw(-0.4, 0.4));
            let v = if target == 4 { vec![0.0; joints] } else { v };
            motion.set_target(&q, &v, &vec![0.0; joints])?;
            let remaining = motion.plan()?;
            // The first targets change in the middle of the motion.
            let steps = (remaining / period) * if target == 4 { 1.0 } else { 0.5 };
            for step in 1.. {
                if f64::from(step) > steps {
                    break;
                }
                assert_eq!(motion.step()?, Progress::Moving);
                let now = [motion.q(), motion.v(), motion.a()].map(<[f64]>::to_vec);
                for k in 0..joints {
                    let (v_max, a_max, j_max) = (limits.velocity[k], limits.acceleration[k], limits.jerk[k]);
                    assert!(now[1][k].abs() <= v_max * (1.0 + 1e-9), "v {} {v_max}", now[1][k]);
                    assert!(now[2][k].abs() <= a_max * (1.0 + 1e-9), "a {} {a_max}", now[2][k]);
                    assert!((now[2][k] - last[2][k]).abs() <= j_max * period * (1.0 + 1e-6));
                    // The trapezoid's error is a third derivative times h²/12, twice that at a switch.
                    let by_a = 0.5 * period * (now[2][k] + last[2][k]);
                    let by_v = 0.5 * period * (now[1][k] + last[1][k]);
                    assert!((now[1][k] - last[1][k] - by_a).abs() <= j_max * period * period);
                    assert!(
                        (now[0][k] - last[0][k] - by_v).abs() <= a_max * period * period * period.max(1e-2)
                    );
                }
                last = now;
            }
            if target == 4 {
                assert_eq!(motion.step()?, Progress::Arrived);
                assert!(crate::common::max_difference(motion.q(), &q) < 1e-8);
                assert!(crate::common::max_difference(motion.v(), &v) < 1e-8);
            }
        }
    }
    Ok(())
}

/// A target that moves at 1 rad/s is given anew in each period. The motion catches up with it and stays on
/// it.
#[test]
fn moving_target_is_followed_at_control_rate() -> Tested {
    let (model, period) = (robot(1), 1e-3);
    let limits = OnlineLimits::new(vec![2.0], vec![8.0], vec![80.0]);
    let mut motion = OnlineMotion::new(&model, limits, period)?;
    motion.set_state(&[0.5], &[0.0], &[0.0])?;
    for step in 0..3000 {
        let t = f64::from(step) * period;
        motion.follow_target(&[t], &[1.0], &[0.0])?;
        motion.step()?;
    }
    // The step ends one period after the time of its target, which moves on by 1e-3 rad in each. New motions
    // in each period leave errors of its jerk, 80 rad/s³ · (1e-3 s)³, many times.
    assert!((motion.q()[0] - 3.0).abs() < 1e-5 && (motion.v()[0] - 1.0).abs() < 1e-3, "{:?}", motion.q());
    // A target that accelerates is met, too: q = 2 + (t − 1) + 0.25 (t − 1)².
    motion.set_state(&[0.0], &[0.0], &[0.0])?;
    for step in 0..2000 {
        let t = f64::from(step) * period - 1.0;
        motion.follow_target(&[2.0 + t + 0.25 * t * t], &[1.0 + 0.5 * t], &[0.5])?;
        motion.step()?;
    }
    assert!((motion.q()[0] - 3.25).abs() < 1e-5 && (motion.v()[0] - 1.5).abs() < 1e-3, "{:?}", motion.q());
    Ok(())
}

/// Seven coordinates that meet a moving target together stay on it, and do not leave it again.
#[test]
fn coordinates_stay_on_a_moving_target() -> Tested {
    let (model, period) = (robot(7), 1e-3);
    let limits = OnlineLimits::new(vec![2.0; 7], vec![8.0; 7], vec![200.0; 7]);
    let mut motion = OnlineMotion::new(&model, limits, period)?;
    let random = &mut SplitMix64::new(5);
    let mut draw = |range: f64| -> Vec<f64> { (0..7).map(|_| random.uniform(-range, range)).collect() };
    let (start, v, rest) = (draw(1.5), draw(0.7), [0.0; 7]);
    motion.set_state(&draw(1.5), &draw(1.0), &rest)?;
    for step in 0..4000 {
        let t = f64::from(step) * period;
        let at = |t: f64| -> Vec<f64> { start.iter().zip(&v).map(|(q, v)| q + v * t).collect() };
        motion.follow_target(&at(t), &v, &rest)?;
        motion.step()?;
        // 3 rad take less than 2.5 s at 2 rad/s and 8 rad/s².
        if step > 2500 {
            let away = crate::common::max_difference(motion.q(), &at(t + period));
            assert!(away < 1e-5, "{t}: {away}");
            assert!(crate::common::max_difference(motion.v(), &v) < 1e-2, "{t}: {:?}", motion.v());
        }
    }
    // A target that is met before it leaves its range is followed, whatever comes later.
    let mut limits = OnlineLimits::new(vec![2.0; 7], vec![8.0; 7], vec![200.0; 7]);
    limits.upper = vec![0.55; 7];
    let mut motion = OnlineMotion::new(&model, limits, period)?;
    motion.follow_target(&[0.0; 7], &[0.5; 7], &rest)?;
    assert!(motion.plan()? < 1.0);
    let gone = motion.follow_target(&[0.5; 7], &[0.5; 7], &rest);
    assert!(
        matches!(gone, Err(OnlineMotionError::TargetBeyondLimit { quantity: "position", .. })),
        "{gone:?}"
    );
    Ok(())
}

/// A state beyond the limits of velocity returns within them; limits of position hold on the way.
#[test]
fn states_beyond_limits_return_within() -> Tested {
    let model = robot(1);
    let mut limits = OnlineLimits::new(vec![1.0], vec![4.0], vec![40.0]);
    let mut motion = OnlineMotion::new(&model, limits.clone(), 1e-3)?;
    motion.set_state(&[0.0], &[1.5], &[0.0])?;
    motion.set_target(&[2.0], &[0.0], &[0.0])?;
    let mut fastest_late: f64 = 0.0;
    for step in 0.. {
        let arrived = motion.step()? == Progress::Arrived;
        // 0.5 / 4 + 4 / 40 s are enough to lose 0.5 rad/s.
        if step > 230 {
            fastest_late = fastest_late.max(motion.v()[0]);
        }
        if arrived {
            break;
        }
    }
    assert!(fastest_late <= 1.0 + 1e-9 && (motion.q()[0] - 2.0).abs() < 1e-6, "{fastest_late}");

    // From 1 rad/s the way to stop is above 0.1 rad.
    (limits.lower, limits.upper) = (vec![-1.0], vec![0.1]);
    let mut motion = OnlineMotion::new(&model, limits, 1e-3)?;
    motion.set_state(&[0.0], &[1.0], &[0.0])?;
    motion.set_target(&[0.05], &[0.0], &[0.0])?;
    assert_eq!(motion.step(), Err(OnlineMotionError::PositionLimits));
    assert_eq!(motion.q(), [0.0], "the state stays");
    Ok(())
}

/// Errors name the coordinate, the quantity and the limit.
#[test]
fn unreachable_targets_are_errors() -> Tested {
    let model = robot(2);
    let names = model.coordinate_names();
    let mut limits = OnlineLimits::new(vec![1.0; 2], vec![4.0; 2], vec![40.0; 2]);
    limits.upper[1] = 1.0;
    let mut motion = OnlineMotion::new(&model, limits.clone(), 1e-3)?;
    let mut refused = |q: [f64; 2], v: [f64; 2], a: [f64; 2]| match motion.set_target(&q, &v, &a) {
        Err(OnlineMotionError::TargetBeyondLimit { quantity, coordinate, value, limit }) => {
            (quantity, coordinate, value, limit)
        }
        other => panic!("{other:?}"),
    };
    assert_eq!(refused([0.0, 1.5], [0.0; 2], [0.0; 2]), ("position", names[1].clone(), 1.5, 1.0));
    assert_eq!(refused([0.0; 2], [-2.0, 0.0], [0.0; 2]), ("velocity", names[0].clone(), -2.0, -1.0));
    assert_eq!(refused([0.0; 2], [0.0; 2], [0.0, 5.0]), ("acceleration", names[1].clone(), 5.0, 4.0));
    // Before v = −0.9 with a = 4 the velocity was −0.9 − 16/80 = −1.1.
    let (quantity, _, value, limit) = refused([0.0; 2], [-0.9, 0.0], [4.0, 0.0]);
    assert!(quantity == "velocity" && (value + 1.1).abs() < 1e-15 && limit == -1.0);
    assert!(matches!(motion.set_target(&[0.0], &[0.0], &[0.0]), Err(OnlineMotionError::Input(_))));
    limits.jerk[1] = 0.0;
    let Err(OnlineMotionError::Input(error)) = OnlineMotion::new(&model, limits, 1e-3) else {
        panic!("a jerk of zero")
    };
    assert_eq!(error.quantity, format!("the jerk limit of coordinate `{}`", names[1]));
    Ok(())
}
