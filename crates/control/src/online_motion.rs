//! Online motion: the fastest motion with limited velocity, acceleration and jerk from any state to a target,
//! computed again whenever the target changes.
//!
//! Each coordinate moves with a jerk of −j_max, 0 or j_max, in at most seven phases after a phase that brings
//! it within its limits. All coordinates reach the target at the same time, that of the slowest. The dynamics
//! of the robot do not enter: limits of acceleration bound torques only if they are chosen for the load.
//! Source: Berscheid, Kröger, *Jerk-limited real-time trajectory generation with arbitrary target states*,
//! Robotics: Science and Systems (2021).
//!
//! Cost: some microseconds a coordinate for a new target, and a cubic polynomial a coordinate for a step.

mod error;
mod limits;

use robot_dynamics_core::Model;
use robot_dynamics_number::{InvalidInput, check_finite, check_positive};
use rsruckig::prelude::{
    DataArrayOrVec, InputParameter, Ruckig, RuckigError, RuckigErrorHandler, RuckigResult, Trajectory,
};

pub use error::OnlineMotionError;
pub use limits::OnlineLimits;

/// Whether a motion has reached its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The state is on the way to the target.
    Moving,
    /// The state is at the target, or beyond it with the target's acceleration.
    Arrived,
}

/// A motion that follows targets at a control rate.
///
/// ```
/// use robot_dynamics::control::online_motion::{OnlineLimits, OnlineMotion, Progress};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let limits = OnlineLimits::new(vec![1.0], vec![2.0], vec![10.0]);
/// let mut motion = OnlineMotion::new(&model, limits, 0.001)?;
/// motion.set_state(&[0.0], &[0.5], &[0.0])?; // it moves already
/// motion.set_target(&[1.0], &[0.0], &[0.0])?;
/// while motion.step()? == Progress::Moving {
///     assert!(motion.v()[0].abs() <= 1.0 + 1e-12);
/// }
/// assert!((motion.q()[0] - 1.0).abs() < 1e-9 && motion.v()[0].abs() < 1e-2);
/// # Ok::<(), robot_dynamics::Error>(())
/// ```
#[derive(Debug)]
pub struct OnlineMotion {
    names: Vec<String>,
    limits: OnlineLimits,
    period: f64,
    solver: Ruckig<0, ResultCodes>,
    input: InputParameter<0>,
    trajectory: Trajectory<0>,
    /// q, v, a and jerk.
    state: [DataArrayOrVec<f64, 0>; 4],
    /// The time since the trajectory was computed; `None` if it is not computed for this state and target.
    time: Option<f64>,
}

/// Invalid inputs of the solver are errors; failures of its calculation are codes.
#[derive(Debug)]
struct ResultCodes;

impl RuckigErrorHandler for ResultCodes {
    fn handle_validation_error(message: &str) -> Result<(), RuckigError> {
        Err(RuckigError::ValidationError(message.to_owned()))
    }

    fn handle_calculator_error(_message: &str) -> Result<(), RuckigError> {
        Ok(())
    }
}

/// The limit of doublings of the time at which a moving target is met, from one period.
const MOST_DOUBLINGS: usize = 30;

/// The accuracy of that time \[s\].
const MEETING: f64 = 1e-9;

impl OnlineMotion {
    /// Creates a motion at rest at q = 0, with the target there, for steps of `period` \[s\].
    ///
    /// # Errors
    /// [`OnlineMotionError::Input`] if
    /// - a limit is not positive, a limit of acceleration or jerk is not finite, or a range of positions is
    ///   empty;
    /// - the period is not positive and finite;
    /// - the robot has quaternions.
    ///
    /// # Panics
    /// Panics if a limit has the wrong length.
    #[track_caller]
    pub fn new(model: &Model, limits: OnlineLimits, period: f64) -> Result<Self, OnlineMotionError> {
        limits.check(model)?;
        check_positive("the period of an online motion", period, "s")?;
        if !model.is_vector_space() {
            let owner = format!("an online motion of robot `{}`", model.name());
            return Err(InvalidInput::unmet(owner, "needs a robot without quaternions").into());
        }
        let count = Some(model.nv());
        let zero = || DataArrayOrVec::new(count, 0.0);
        let mut input = InputParameter::new(count);
        input.max_velocity.copy_from_slice(&limits.velocity);
        input.max_acceleration.copy_from_slice(&limits.acceleration);
        input.max_jerk.copy_from_slice(&limits.jerk);
        if limits.has_positions() {
            let (mut lower, mut upper) = (zero(), zero());
            lower.copy_from_slice(&limits.lower);
            upper.copy_from_slice(&limits.upper);
            (input.min_position, input.max_position) = (Some(lower), Some(upper));
        }
        Ok(Self {
            names: model.coordinate_names(),
            limits,
            period,
            solver: Ruckig::new(count, period),
            input,
            trajectory: Trajectory::new(count),
            state: [zero(), zero(), zero(), zero()],
            time: None,
        })
    }

    /// Sets the state from which the next step starts, such as a measured one. It may exceed the limits of
    /// velocity and acceleration; the motion then returns within them first.
    ///
    /// # Errors
    /// [`OnlineMotionError::Input`] if a length is wrong or a number is not finite.
    pub fn set_state(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Result<(), OnlineMotionError> {
        self.check_numbers(["q", "v", "a"], [q, v, a])?;
        for (state, value) in self.state.iter_mut().zip([q, v, a]) {
            state.copy_from_slice(value);
        }
        self.time = None;
        Ok(())
    }

    /// Sets the target; the motion to it starts with the next step. A target equal to the last one changes
    /// nothing.
    ///
    /// # Errors
    /// [`OnlineMotionError`] if a length is wrong, a number is not finite, or the target is beyond a limit or
    /// can only be reached from beyond one. The last target then stays.
    pub fn set_target(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Result<(), OnlineMotionError> {
        self.check_numbers(["the target's q", "the target's v", "the target's a"], [q, v, a])?;
        self.limits.check_target(&self.names, [q, v, a])?;
        let input = &mut self.input;
        let targets =
            [&mut input.target_position, &mut input.target_velocity, &mut input.target_acceleration];
        for (target, value) in targets.into_iter().zip([q, v, a]) {
            if target.iter().ne(value) {
                target.copy_from_slice(value);
                self.time = None;
            }
        }
        Ok(())
    }

    /// Sets a target that moves on with this v and a. The motion meets it and then stays on it.
    ///
    /// The meeting is at a time T at which a motion of duration T leads to q + v T + ½ a T². It exists if the
    /// target is slower than the limits, and is found by doubling and bisection. For a target that is
    /// measured in each period, call this before each step. All coordinates meet it at the same time.
    ///
    /// ```
    /// use robot_dynamics::control::online_motion::{OnlineLimits, OnlineMotion};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let limits = OnlineLimits::new(vec![2.0], vec![8.0], vec![80.0]);
    /// let mut motion = OnlineMotion::new(&model, limits, 0.001)?;
    /// for step in 0..2000 {
    ///     motion.follow_target(&[1.0 + 0.5 * 0.001 * f64::from(step)], &[0.5], &[0.0])?;
    ///     motion.step()?;
    /// }
    /// assert!((motion.q()[0] - 2.0).abs() < 1e-5 && (motion.v()[0] - 0.5).abs() < 1e-3);
    /// # Ok::<(), robot_dynamics::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`set_target`](Self::set_target) and [`plan`](Self::plan), for the target at the time of the meeting.
    pub fn follow_target(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Result<(), OnlineMotionError> {
        self.set_target(q, v, a)?;
        let goal = [q, v, a];
        let (mut early, mut late) = (0.0, self.period);
        if self.meets(goal, 0.0) {
            return Ok(());
        }
        for _doubling in 0..MOST_DOUBLINGS {
            if self.meets(goal, late) {
                break;
            }
            (early, late) = (late, 2.0 * late);
        }
        while late - early > MEETING {
            let middle = 0.5 * (early + late);
            *(if self.meets(goal, middle) { &mut late } else { &mut early }) = middle;
        }
        let planned = self.aim(goal, late).and_then(|()| self.plan_for(late));
        if planned.is_err() {
            self.aim(goal, 0.0)?;
        }
        planned.map(|_duration| ())
    }

    /// Whether the motion to the place of a moving target after the time t can take that time. A target that
    /// leaves its limits until then counts as met, so that the search goes on at earlier times.
    fn meets(&mut self, goal: [&[f64]; 3], t: f64) -> bool {
        self.aim(goal, t).is_err() || self.plan_for(t).is_ok_and(|duration| duration <= t + MEETING)
    }

    /// Makes the place of a moving target after the time t the target.
    fn aim(&mut self, [q, v, a]: [&[f64]; 3], t: f64) -> Result<(), OnlineMotionError> {
        self.time = None;
        let input = &mut self.input;
        for k in 0..q.len() {
            input.target_position[k] = q[k] + t * (v[k] + 0.5 * t * a[k]);
            input.target_velocity[k] = v[k] + t * a[k];
        }
        let target: [&[f64]; 3] = [&input.target_position, &input.target_velocity, a];
        self.limits.check_target(&self.names, target)
    }

    /// The duration of the motion to the target that takes at least the time t.
    fn plan_for(&mut self, t: f64) -> Result<f64, OnlineMotionError> {
        self.input.minimum_duration = (t > 0.0).then_some(t);
        let planned = self.plan();
        self.input.minimum_duration = None;
        planned
    }

    /// Computes the motion from the state to the target, if it is not computed yet, and returns its remaining
    /// duration \[s\].
    ///
    /// ```
    /// use robot_dynamics::control::online_motion::{OnlineLimits, OnlineMotion};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let limits = OnlineLimits::new(vec![10.0], vec![10.0], vec![4.0]);
    /// let mut motion = OnlineMotion::new(&model, limits, 0.001)?;
    /// motion.set_target(&[1.0], &[0.0], &[0.0])?;
    /// // Four phases of jerk j: q = 2 j (T/4)³.
    /// assert!((motion.plan()? - 4.0 * f64::cbrt(1.0 / 8.0)).abs() < 1e-9);
    /// # Ok::<(), robot_dynamics::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`OnlineMotionError`] if no motion within the limits of position leads to the target.
    pub fn plan(&mut self) -> Result<f64, OnlineMotionError> {
        if let Some(time) = self.time {
            return Ok((self.trajectory.get_duration() - time).max(0.0));
        }
        let input = &mut self.input;
        let starts =
            [&mut input.current_position, &mut input.current_velocity, &mut input.current_acceleration];
        for (start, state) in starts.into_iter().zip(&self.state) {
            start.copy_from_slice(state);
        }
        match self.solver.calculate(&self.input, &mut self.trajectory) {
            Ok(RuckigResult::Working | RuckigResult::Finished) => {
                self.time = Some(0.0);
                Ok(self.trajectory.get_duration())
            }
            Ok(RuckigResult::ErrorPositionalLimits) => Err(OnlineMotionError::PositionLimits),
            Ok(result) => Err(OnlineMotionError::NoMotion { reason: format!("{result:?}") }),
            Err(error) => Err(OnlineMotionError::NoMotion { reason: error.to_string() }),
        }
    }

    /// Moves the state by one period.
    ///
    /// After the target it continues with the target's acceleration. A step does not allocate memory.
    ///
    /// # Errors
    /// As [`plan`](Self::plan); the state then stays.
    pub fn step(&mut self) -> Result<Progress, OnlineMotionError> {
        self.plan()?;
        let time = self.time.unwrap_or(0.0) + self.period;
        self.time = Some(time);
        let [q, v, a, jerk] = &mut self.state;
        let jerk = &mut Some(jerk);
        self.trajectory.at_time(time, &mut Some(q), &mut Some(v), &mut Some(a), jerk, &mut Some(0));
        let arrived = time >= self.trajectory.get_duration();
        Ok(if arrived { Progress::Arrived } else { Progress::Moving })
    }

    /// q of the state, nq.
    pub fn q(&self) -> &[f64] {
        &self.state[0]
    }

    /// v of the state, nv \[rad/s or m/s\].
    pub fn v(&self) -> &[f64] {
        &self.state[1]
    }

    /// a of the state, nv \[rad/s² or m/s²\].
    pub fn a(&self) -> &[f64] {
        &self.state[2]
    }

    /// The jerk of the state, nv \[rad/s³ or m/s³\].
    pub fn jerk(&self) -> &[f64] {
        &self.state[3]
    }

    fn check_numbers(&self, names: [&str; 3], values: [&[f64]; 3]) -> Result<(), InvalidInput> {
        for (name, value) in names.into_iter().zip(values) {
            if value.len() != self.names.len() {
                let requirement =
                    format!("has {} numbers, the robot needs {}", value.len(), self.names.len());
                return Err(InvalidInput::unmet(name, requirement));
            }
            check_finite(name, value)?;
        }
        Ok(())
    }
}
