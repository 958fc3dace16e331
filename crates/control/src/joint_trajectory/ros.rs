//! `trajectory_msgs/JointTrajectory` as JSON and YAML.

use std::fmt::Write as _;

use robot_dynamics_number::InvalidInput;

use super::{JointTrajectory, JointTrajectoryPoint, decimal};

impl JointTrajectory {
    /// The motion as a `trajectory_msgs/JointTrajectory` of ROS 2 in JSON.
    ///
    /// ```
    /// use robot_dynamics::control::joint_trajectory::{JointTrajectory, JointTrajectoryPoint};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut trajectory = JointTrajectory::new(&Model::new(pendulum(2.0, 0.5))?);
    /// let point = |time| JointTrajectoryPoint { time, q: vec![0.5], v: vec![0.0], a: vec![0.0], tau: vec![8.0] };
    /// trajectory.push(point(1.25))?;
    /// let text = trajectory.to_ros_json()?;
    /// assert!(text.contains(r#""joint_names":["hinge"]"#) && text.contains(r#""effort":[8.0]"#));
    /// assert!(text.contains(r#""time_from_start":{"sec":1,"nanosec":250000000}"#));
    /// # Ok::<(), robot_dynamics::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] if the robot has a joint with a quaternion, for which the message has no place.
    pub fn to_ros_json(&self) -> Result<String, InvalidInput> {
        let names: Vec<String> = self.joint_names()?.iter().map(|name| quoted(name)).collect();
        let stamp = r#"{"stamp":{"sec":0,"nanosec":0},"frame_id":""}"#;
        let mut text = format!("{{\"header\":{stamp},\"joint_names\":[{}],\"points\":[", names.join(","));
        for (index, point) in self.points().iter().enumerate() {
            text.push_str(if index == 0 { "\n{" } else { ",\n{" });
            for (name, values) in fields(point) {
                let _ = write!(text, "\"{name}\":{},", numbers(values, ","));
            }
            let (sec, nanosec) = duration(point.time);
            let _ = write!(text, "\"time_from_start\":{{\"sec\":{sec},\"nanosec\":{nanosec}}}}}");
        }
        text.push_str("\n]}\n");
        Ok(text)
    }

    /// The motion as a `trajectory_msgs/JointTrajectory` of ROS 2 in YAML, as `ros2 topic pub` takes it.
    ///
    /// ```
    /// use robot_dynamics::control::joint_trajectory::{JointTrajectory, JointTrajectoryPoint};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut trajectory = JointTrajectory::new(&Model::new(pendulum(2.0, 0.5))?);
    /// let point = |time| JointTrajectoryPoint { time, q: vec![0.5], v: vec![0.0], a: vec![0.0], tau: vec![8.0] };
    /// trajectory.push(point(1.25))?;
    /// let text = trajectory.to_ros_yaml()?;
    /// assert!(text.contains("joint_names: [\"hinge\"]\n") && text.contains("- positions: [0.5]\n"));
    /// assert!(text.contains("  time_from_start: {sec: 1, nanosec: 250000000}\n"));
    /// # Ok::<(), robot_dynamics::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] if the robot has a joint with a quaternion, for which the message has no place.
    pub fn to_ros_yaml(&self) -> Result<String, InvalidInput> {
        let names: Vec<String> = self.joint_names()?.iter().map(|name| quoted(name)).collect();
        let mut text = String::from("header: {stamp: {sec: 0, nanosec: 0}, frame_id: \"\"}\n");
        let _ = writeln!(text, "joint_names: [{}]", names.join(", "));
        text.push_str(if self.points().is_empty() { "points: []\n" } else { "points:\n" });
        for point in self.points() {
            for (index, (name, values)) in fields(point).into_iter().enumerate() {
                let lead = if index == 0 { "-" } else { " " };
                let _ = writeln!(text, "{lead} {name}: {}", numbers(values, ", "));
            }
            let (sec, nanosec) = duration(point.time);
            let _ = writeln!(text, "  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}");
        }
        Ok(text)
    }

    /// The name of each coordinate, if q has one number for each of v.
    fn joint_names(&self) -> Result<&[String], InvalidInput> {
        if self.positions.len() == self.velocities.len() {
            return Ok(&self.positions);
        }
        let requirement = "has one position for each velocity; this robot has quaternions, write CSV instead";
        Err(InvalidInput::unmet("a joint trajectory message", requirement))
    }
}

/// The arrays of a point under the names of the message.
fn fields(point: &JointTrajectoryPoint) -> [(&'static str, &[f64]); 4] {
    [("positions", &point.q), ("velocities", &point.v), ("accelerations", &point.a), ("effort", &point.tau)]
}

fn numbers(values: &[f64], separator: &str) -> String {
    let values: Vec<String> = values.iter().map(|x| decimal(*x)).collect();
    format!("[{}]", values.join(separator))
}

/// Whole seconds and the remaining nanoseconds, rounded to the nearest nanosecond.
fn duration(time: f64) -> (f64, f64) {
    let (sec, nanosec) = (time.floor(), ((time - time.floor()) * 1e9).round());
    if nanosec >= 1e9 { (sec + 1.0, 0.0) } else { (sec, nanosec) }
}

/// A string of JSON, which is one of YAML, too.
fn quoted(name: &str) -> String {
    let mut text = String::from("\"");
    for letter in name.chars() {
        match letter {
            '"' | '\\' => text.extend(['\\', letter]),
            letter if letter < ' ' => {
                let _ = write!(text, "\\u{:04x}", u32::from(letter));
            }
            letter => text.push(letter),
        }
    }
    text + "\""
}
