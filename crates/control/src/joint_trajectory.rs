//! Sampled motions, and their texts for tables and for ROS.
//!
//! The message is `trajectory_msgs/JointTrajectory` of ROS 2: joint names, and for each point positions,
//! velocities, accelerations, efforts and the time from the start in seconds and nanoseconds.

mod ros;

use std::fmt::Write as _;

use robot_dynamics_core::Model;
use robot_dynamics_number::{InputProblem, InvalidInput, check_finite};

/// A point of a sampled motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointTrajectoryPoint {
    /// The time from the start \[s\].
    pub time: f64,
    /// q, nq.
    pub q: Vec<f64>,
    /// v, nv \[rad/s or m/s\].
    pub v: Vec<f64>,
    /// a, nv \[rad/s² or m/s²\].
    pub a: Vec<f64>,
    /// τ, nv \[N·m or N\].
    pub tau: Vec<f64>,
}

/// A motion as a list of points with increasing times.
///
/// ```
/// use robot_dynamics::control::joint_trajectory::{JointTrajectory, JointTrajectoryPoint};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let mut trajectory = JointTrajectory::new(&model);
/// let point = |time, q| JointTrajectoryPoint { time, q: vec![q], v: vec![2.0], a: vec![0.0], tau: vec![9.81] };
/// trajectory.push(point(0.0, 0.0))?;
/// trajectory.push(point(0.25, 0.5))?;
/// assert_eq!(trajectory.to_csv().lines().nth(2), Some("0.25,0.5,2.0,0.0,9.81"));
/// # Ok::<(), robot_dynamics::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct JointTrajectory {
    positions: Vec<String>,
    velocities: Vec<String>,
    points: Vec<JointTrajectoryPoint>,
}

impl JointTrajectory {
    /// Creates a motion of this robot without points.
    pub fn new(model: &Model) -> Self {
        let joints = model.joints().iter().filter(|joint| joint.nv > 0);
        let names = joints.flat_map(|joint| {
            joint.kind.positions().iter().map(|coordinate| coordinate.of_joint(&joint.name))
        });
        Self::with_names(names.collect(), model.coordinate_names())
    }

    /// Creates a motion without points from the names of the numbers of q and of v.
    ///
    /// ```
    /// use robot_dynamics::control::joint_trajectory::JointTrajectory;
    /// let names = || vec!["shoulder".to_owned(), "elbow".to_owned()];
    /// let text = JointTrajectory::with_names(names(), names()).to_ros_yaml()?;
    /// assert!(text.contains("joint_names: [\"shoulder\", \"elbow\"]"));
    /// # Ok::<(), robot_dynamics::Error>(())
    /// ```
    pub fn with_names(positions: Vec<String>, velocities: Vec<String>) -> Self {
        Self { positions, velocities, points: Vec::new() }
    }

    /// Appends a point.
    ///
    /// ```
    /// use robot_dynamics::control::joint_trajectory::{JointTrajectory, JointTrajectoryPoint};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut trajectory = JointTrajectory::new(&Model::new(pendulum(2.0, 0.5))?);
    /// let point = JointTrajectoryPoint { q: vec![0.0; 2], ..Default::default() };
    /// assert!(trajectory.push(point).is_err()); // one coordinate
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] if a length is wrong, a number is not finite, or the time is negative or not above
    /// that of the last point.
    pub fn push(&mut self, point: JointTrajectoryPoint) -> Result<(), InvalidInput> {
        let (nq, nv) = (self.positions.len(), self.velocities.len());
        let rows = [("q", &point.q, nq), ("v", &point.v, nv), ("a", &point.a, nv), ("tau", &point.tau, nv)];
        for (name, row, expected) in rows {
            if row.len() != expected {
                let (found, owner) = (row.len(), "the trajectory".to_owned());
                return Err(InvalidInput::new(
                    name,
                    InputProblem::WrongLength { found, expected, owner, hint: "" },
                ));
            }
            check_finite(name, row)?;
        }
        check_finite("the time", &[point.time])?;
        let after = self.points.last().map_or(-f64::MIN_POSITIVE, |last| last.time);
        if point.time <= after {
            let requirement = format!("is {} s; it must increase from point to point, from 0 s", point.time);
            return Err(InvalidInput::unmet("the time", requirement));
        }
        self.points.push(point);
        Ok(())
    }

    /// The points in order.
    pub fn points(&self) -> &[JointTrajectoryPoint] {
        &self.points
    }

    /// The motion as a table of comma-separated values: `time`, `q.NAME`, `v.NAME`, `a.NAME`, `tau.NAME`.
    ///
    /// Numbers are decimal and read back without loss. Names with a comma, a quotation mark or a line break
    /// are quoted (RFC 4180).
    ///
    /// ```
    /// use robot_dynamics::control::joint_trajectory::JointTrajectory;
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let trajectory = JointTrajectory::new(&Model::new(pendulum(2.0, 0.5))?);
    /// assert_eq!(trajectory.to_csv(), "time,q.hinge,v.hinge,a.hinge,tau.hinge\n");
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn to_csv(&self) -> String {
        let groups = [
            ("q", &self.positions),
            ("v", &self.velocities),
            ("a", &self.velocities),
            ("tau", &self.velocities),
        ];
        let mut text = String::from("time");
        for (quantity, names) in groups {
            for name in names {
                text.push(',');
                text.push_str(&quoted_field(&format!("{quantity}.{name}")));
            }
        }
        text.push('\n');
        for point in &self.points {
            text.push_str(&decimal(point.time));
            for x in point.q.iter().chain(&point.v).chain(&point.a).chain(&point.tau) {
                let _ = write!(text, ",{}", decimal(*x));
            }
            text.push('\n');
        }
        text
    }
}

/// A finite number with a decimal point and without an exponent, as CSV, JSON and YAML read it.
fn decimal(x: f64) -> String {
    let text = format!("{x}");
    if text.contains('.') { text } else { text + ".0" }
}

fn quoted_field(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
