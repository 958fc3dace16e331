//! Samples of a timed path at equal intervals of time.

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;

use super::sample::Sampler;
use super::{TimedPath, TreePath};
use crate::joint_trajectory::{JointTrajectory, JointTrajectoryPoint};

impl TimedPath {
    /// The motion at `count` equally spaced times from the start to the end, with τ by inverse dynamics.
    ///
    /// `dissipation` adds damping and friction of the joints to τ; see
    /// [`MotionLimits::dissipation`](crate::MotionLimits::dissipation).
    ///
    /// ```
    /// use robot_dynamics::control::{CubicSpline, MotionLimits, TimeOptimal, time_optimal};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let path = CubicSpline::through(&[vec![0.0], vec![1.0]])?;
    /// let limits = MotionLimits::new(vec![12.0], vec![2.0]);
    /// let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits, 200))?;
    /// let trajectory = timed.trajectory(&model, &path, true, 101)?;
    /// let last = trajectory.points().last().expect("101 points");
    /// assert!((last.q[0] - 1.0).abs() < 1e-12 && (last.time - timed.duration()).abs() < 1e-12);
    /// assert!(trajectory.to_ros_yaml()?.starts_with("header:"));
    /// # Ok::<(), robot_dynamics::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] if `count` is below two, or a number is not finite.
    ///
    /// # Panics
    /// Panics if the path is not of this robot.
    #[track_caller]
    pub fn trajectory(
        &self,
        model: &Model,
        path: &impl TreePath,
        dissipation: bool,
        count: usize,
    ) -> Result<JointTrajectory, InvalidInput> {
        if count < 2 {
            return Err(InvalidInput::unmet(
                "the number of samples",
                format!("is {count}; it must be at least two"),
            ));
        }
        let mut trajectory = JointTrajectory::new(model);
        let mut sampler = Sampler::new(model, path, self, dissipation);
        for k in 0..count {
            let time = self.duration() * k as f64 / (count - 1) as f64;
            let (interval, s) = self.interval(time);
            let (from, to) = (self.grid()[interval], self.grid()[interval + 1]);
            let sample = sampler.at(interval, ((s - from) / (to - from)).clamp(0.0, 1.0));
            let (q, v, a, tau) = (sample.q, sample.v, sample.a, sample.tau);
            trajectory.push(JointTrajectoryPoint { time, q, v, a, tau })?;
        }
        Ok(trajectory)
    }
}
