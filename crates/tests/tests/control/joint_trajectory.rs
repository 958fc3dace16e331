//! Sampled motions: CSV, JSON and YAML read back, and the samples are the motion.

use std::error::Error;

use robot_dynamics::algorithms::{dissipation, inverse_dynamics};
use robot_dynamics::control::joint_trajectory::{JointTrajectory, JointTrajectoryPoint};
use robot_dynamics::control::{MotionLimits, TimeOptimal, time_optimal};
use robot_dynamics::description::{Base, PassiveForces};
use robot_dynamics::model::{Model, Workspace};
use serde_json::Value;

use crate::time_optimal::{arm, arm_limits, reach};

type Tested = Result<(), Box<dyn Error>>;

fn sampled(model: &Model, limits: &MotionLimits) -> Result<JointTrajectory, Box<dyn Error>> {
    let timed = time_optimal(model, &reach(), &TimeOptimal::from_rest_to_rest(limits.clone(), 100))?;
    Ok(timed.trajectory(model, &reach(), limits.dissipation, 41)?)
}

fn damped_arm() -> Result<Model, Box<dyn Error>> {
    let mut description = arm()?.description().clone();
    for joint in &mut description.joints {
        joint.passive = PassiveForces::default().with_damping(1.0).with_friction(0.5);
    }
    Ok(Model::new(description)?)
}

/// v is the rate of q, and τ inverse dynamics and dissipation at each sample.
#[test]
fn samples_are_the_motion() -> Tested {
    let model = damped_arm()?;
    let with = sampled(&model, &arm_limits())?;
    let w = &mut Workspace::new(&model);
    for point in &with.points()[1..40] {
        let (mut tau, mut losses) = ([0.0; 2], [0.0; 2]);
        inverse_dynamics(&model, w, &point.q, &point.v, &point.a, &mut tau);
        dissipation(&model, &point.v, &mut losses);
        for k in 0..2 {
            assert!((tau[k] + losses[k] - point.tau[k]).abs() < 1e-10, "{point:?}");
        }
    }
    for pair in with.points().windows(2) {
        let dt = pair[1].time - pair[0].time;
        for k in 0..2 {
            let mean = 0.5 * (pair[0].v[k] + pair[1].v[k]);
            // Accelerations up to 45 rad/s² jump inside a period of 0.04 s.
            assert!((pair[1].q[k] - pair[0].q[k] - dt * mean).abs() < 45.0 * dt * dt / 4.0, "{pair:?}");
        }
    }
    // The motion starts against friction, with the direction of the first interval.
    let without = sampled(&model, &arm_limits().with_dissipation(false))?;
    assert!(without.points()[20].tau != with.points()[20].tau);
    Ok(())
}

/// Every number of the CSV is that of the samples, bit for bit.
#[test]
fn csv_reads_back() -> Tested {
    let trajectory = sampled(&arm()?, &arm_limits())?;
    let text = trajectory.to_csv();
    let mut lines = text.lines();
    let names = "time,q.shoulder,q.elbow,v.shoulder,v.elbow,a.shoulder,a.elbow,tau.shoulder,tau.elbow";
    assert_eq!(lines.next(), Some(names));
    for point in trajectory.points() {
        let numbers = lines.next().expect("a line").split(',').map(str::parse::<f64>);
        let numbers = numbers.collect::<Result<Vec<f64>, _>>()?;
        let expected = [&[point.time], &point.q[..], &point.v, &point.a, &point.tau].concat();
        assert_eq!(numbers, expected);
    }
    assert_eq!(lines.next(), None);
    let quoted = JointTrajectory::with_names(vec!["a,\"b\"".into()], vec!["c".into()]).to_csv();
    assert_eq!(quoted, "time,\"q.a,\"\"b\"\"\",v.c,a.c,tau.c\n");
    Ok(())
}

/// The JSON has the fields of the message, the numbers of the samples, and times to the nanosecond.
#[test]
fn json_is_the_message() -> Tested {
    let trajectory = sampled(&arm()?, &arm_limits())?;
    let message: Value = serde_json::from_str(&trajectory.to_ros_json()?)?;
    assert_eq!(message["joint_names"], serde_json::json!(["shoulder", "elbow"]));
    assert_eq!(message["header"]["stamp"]["sec"], 0);
    let points = message["points"].as_array().expect("points");
    assert_eq!(points.len(), 41);
    for (found, point) in points.iter().zip(trajectory.points()) {
        let rows = [
            ("positions", &point.q),
            ("velocities", &point.v),
            ("accelerations", &point.a),
            ("effort", &point.tau),
        ];
        for (name, row) in rows {
            assert_eq!(found[name], serde_json::json!(row));
        }
        let since = &found["time_from_start"];
        let (sec, nanosec) =
            (since["sec"].as_u64().expect("sec"), since["nanosec"].as_u64().expect("nanosec"));
        assert!(nanosec < 1_000_000_000);
        assert!((sec as f64 + nanosec as f64 * 1e-9 - point.time).abs() <= 0.5e-9 + 1e-15);
    }
    Ok(())
}

/// The YAML has the same lines for any point, with each number as a decimal.
#[test]
fn yaml_is_the_message() -> Tested {
    let names = || vec!["a \"b\"\n".to_owned()];
    let mut trajectory = JointTrajectory::with_names(names(), names());
    let row = |x: f64| vec![x];
    let point =
        |time| JointTrajectoryPoint { time, q: row(1.0), v: row(-2.5e-7), a: row(1e22), tau: row(0.1) };
    trajectory.push(point(0.9999999999))?;
    let expected = "header: {stamp: {sec: 0, nanosec: 0}, frame_id: \"\"}\n\
        joint_names: [\"a \\\"b\\\"\\u000a\"]\n\
        points:\n\
        - positions: [1.0]\n  velocities: [-0.00000025]\n  accelerations: [10000000000000000000000.0]\n  \
        effort: [0.1]\n  time_from_start: {sec: 1, nanosec: 0}\n";
    assert_eq!(trajectory.to_ros_yaml()?, expected);
    Ok(())
}

/// Points of another length, with a NaN or a time that does not increase are errors, and so are messages of a
/// robot with quaternions.
#[test]
fn invalid_points_are_errors() -> Tested {
    let mut floating = arm()?.description().clone();
    floating.base = Base::Floating;
    let mut trajectory = JointTrajectory::new(&Model::new(floating)?);
    let zero = |count| vec![0.0; count];
    let point = |time| JointTrajectoryPoint { time, q: zero(9), v: zero(8), a: zero(8), tau: zero(8) };
    trajectory.push(point(0.0))?;
    assert_eq!(trajectory.push(point(0.0)).unwrap_err().quantity, "the time");
    assert_eq!(trajectory.push(JointTrajectoryPoint { a: zero(9), ..point(1.0) }).unwrap_err().quantity, "a");
    let nan = JointTrajectoryPoint { tau: vec![f64::NAN; 8], ..point(1.0) };
    assert!(trajectory.push(nan).is_err());
    assert!(trajectory.to_ros_json().is_err() && trajectory.to_ros_yaml().is_err());
    assert!(trajectory.to_csv().starts_with("time,q.floating_base.x,q.floating_base.y"));
    Ok(())
}
