//! Control of a frame through its operational-space inertia.

use std::borrow::Borrow;

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Pose;
use robot_dynamics_number::check_number;
use robot_dynamics_simulation::{Controller, ControllerError, SpatialAxis};

use super::effort_limits::EffortScales;
use super::frame_law::{FrameCommand, FrameLaw};
use super::mobility::MOST_ROWS;
use super::{TaskDeviation, TaskTarget};

/// The gains of a frame's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskGains {
    /// kp \[1/s²\].
    pub stiffness: f64,
    /// kd \[1/s\]; 2 √kp is critically damped.
    pub damping: f64,
    /// kn \[1/s\], the damping in the null space.
    pub null_damping: f64,
}

/// τ = Jᵀ(Λ (ẍ\* + kp e + kd (ẋ\* − ẋ)) + μ + p) + (1 − JᵀJ̄ᵀ) τ₀, τ₀ = C v + g + M (kr (q\* ⊖ q) − kn v).
/// The type of the reference selects the controlled directions: a [`TaskReference`](super::TaskReference) the
/// position, a [`PoseReference`](super::PoseReference) position and orientation.
/// [`with_rows`](Self::with_rows) selects some of these.
///
/// Coordinates without a motor ([`Model::actuated_dofs`]) get no torque. For a floating base without
/// contacts, J, Λ and μ are those of the joints while the base recoils. The error obeys ë + kd ė + kp e = 0;
/// that of orientation does so for rotations about one axis. The motion in the null space is damped with kn,
/// and [`with_posture`](Self::with_posture) pulls it to a posture q\*. Without a posture, an arm with more
/// joints than the task has directions drifts, even with exact gravity compensation.
///
/// Near a singular pose Λ is damped. Let d be the typical mobility of a row, the mean of (J M⁻¹Jᵀ)_kk over
/// random configurations, and r the least mobility of a row independent of the others, divided by its d. If
/// r < 1e-3, (1e-3 − r) d is added to the mobility of each row. The frame then lags in that direction, and
/// the torque for it stays bounded, also at the singular pose. Elsewhere Λ is exact.
/// [`is_damped`](Self::is_damped) tells whether it was damped. If a row depends on the others at every pose,
/// such as y of an arm in the plane of x and z, the controller returns an error, and a run ends.
///
/// The torque is within the effort limits of the joints, or those of [`with_limits`](Self::with_limits). If
/// the command exceeds them, ẍ is scaled by the largest s₁ ≤ 1 that they allow beside the torque at ẍ = 0.
/// The frame then keeps its direction. The acceleration in the null space is scaled to the rest of the
/// effort. [`effort_scales`](Self::effort_scales) returns both fractions. A coordinate whose limit is
/// exceeded at ẍ = 0 is clipped.
///
/// It does not allocate. [`new`](TaskControl::new) borrows the robot; [`owning`](Self::owning) stores it, for
/// example as an `Arc<Model>`.
///
/// ```
/// use robot_dynamics::algorithms::frame_pose;
/// use robot_dynamics::control::{PoseReference, TaskControl, TaskGains};
/// use robot_dynamics::description::{JointKinds, Pose, RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, Workspace};
/// use robot_dynamics::simulation::Controller;
/// let options = RandomRobotOptions { joints: 7, kinds: JointKinds::Turning, chain: 1.0, ..Default::default() };
/// let model = Model::new(random_robot(4, &options))?;
/// let hand = model.frame(&model.frames()[model.frames().len() - 1].name).expect("a frame");
/// let q = [0.4; 7];
/// let pose = frame_pose(&model, &mut Workspace::new(&model), &q, hand);
/// let here = PoseReference::at_rest(Pose { rotation: pose.rotation, translation: pose.translation });
/// let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 10.0 };
/// let mut control = TaskControl::new(&model, hand, |_t| here, gains)?.with_posture(&q, 25.0)?;
/// let mut tau = [0.0; 7];
/// control.torque(0.0, &q, &[0.0; 7], &mut tau)?; // at rest, τ compensates the weight
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TaskControl<M, F> {
    model: M,
    reference: F,
    gains: TaskGains,
    law: FrameLaw,
}

impl<'a, F, T> TaskControl<&'a Model, F>
where
    F: FnMut(f64) -> T,
    T: TaskTarget,
{
    /// Follows `reference(t)`, which returns a target or a `Result` of one.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if a gain is not finite.
    pub fn new(
        model: &'a Model,
        frame: FrameId,
        reference: F,
        gains: TaskGains,
    ) -> Result<Self, ControllerError> {
        Self::owning(model, frame, reference, gains)
    }
}

impl<M, F, T> TaskControl<M, F>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> T,
    T: TaskTarget,
{
    /// [`new`](TaskControl::new) with a robot that the controller stores: an `Arc<Model>`, a `Model`, or a reference.
    ///
    /// # Errors
    /// As [`new`](TaskControl::new).
    pub fn owning(robot: M, frame: FrameId, reference: F, gains: TaskGains) -> Result<Self, ControllerError> {
        check_number("the stiffness", gains.stiffness)?;
        check_number("the damping", gains.damping)?;
        let law = FrameLaw::new::<T>(robot.borrow(), frame, gains.null_damping)?;
        Ok(Self { model: robot, reference, gains, law })
    }

    /// Controls only these of the target's rows, such as x and z for an arm that moves in a plane. The other
    /// directions belong to the null space.
    ///
    /// ```
    /// use robot_dynamics::constraints::SpatialAxis;
    /// use robot_dynamics::control::{TaskControl, TaskGains, TaskReference};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Controller;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let below = |_t| TaskReference { position: [0.0, 0.0, -0.5], velocity: [0.0; 3], acceleration: [0.0; 3] };
    /// let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 0.0 };
    /// let mut control = TaskControl::new(&model, model.frame_named("tip")?, below, gains)?.with_rows(&[SpatialAxis::Z]);
    /// let mut tau = [0.0];
    /// control.torque(0.0, &[0.0], &[0.0], &mut tau)?; // horizontal rod: z̈ = −50 m/s², and the weight is 19.62 N
    /// assert!((tau[0].abs() - 0.5 * 2.0 * (50.0 - 9.81)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if no row is given, if a row is given twice, or if a row is not among the target's.
    #[must_use]
    #[track_caller]
    pub fn with_rows(mut self, rows: &[SpatialAxis]) -> Self {
        self.law.select_rows::<T>(self.model.borrow(), rows);
        self
    }

    /// Replaces the joints' effort limits; nv entries \[N·m or N\], infinite without a limit.
    ///
    /// ```
    /// use robot_dynamics::constraints::SpatialAxis;
    /// use robot_dynamics::control::{TaskControl, TaskGains, TaskReference};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Controller;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let below = |_t| TaskReference { position: [0.0, 0.0, -0.5], velocity: [0.0; 3], acceleration: [0.0; 3] };
    /// let gains = TaskGains { stiffness: 100.0, damping: 20.0, null_damping: 0.0 };
    /// let control = TaskControl::new(&model, model.frame_named("tip")?, below, gains)?;
    /// let mut control = control.with_rows(&[SpatialAxis::Z]).with_limits(&[30.0]);
    /// let mut tau = [0.0];
    /// control.torque(0.0, &[0.0], &[0.0], &mut tau)?; // 50 N·m downwards would be needed, beside 9.81 N·m upwards
    /// assert!((tau[0].abs() - 30.0).abs() < 1e-12);
    /// assert!((control.effort_scales().task - (30.0 + 9.81) / 50.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if the length is wrong, or a limit is negative or NaN.
    #[must_use]
    #[track_caller]
    pub fn with_limits(mut self, limits: &[f64]) -> Self {
        self.law.limits.set(limits);
        self
    }

    /// Whether Λ was damped in the last call, near a singular pose.
    pub fn is_damped(&self) -> bool {
        self.law.is_damped()
    }

    /// The fractions of the last command that the effort limits allowed.
    pub fn effort_scales(&self) -> EffortScales {
        self.law.limits.scales
    }

    /// Adds a spring to the posture q\* with kr \[1/s²\]; kn = 2 √kr is critically damped.
    ///
    /// # Errors
    /// [`ControllerError`] if q\* is an invalid configuration, or kr is not finite.
    pub fn with_posture(mut self, posture: &[f64], stiffness: f64) -> Result<Self, ControllerError> {
        self.law.set_posture(self.model.borrow(), posture, stiffness)?;
        Ok(self)
    }
}

impl<M, F, T> Controller for TaskControl<M, F>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> T,
    T: TaskTarget,
{
    /// # Panics
    /// Panics if τ has the wrong length, or the frame belongs to another model.
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        let Self { model, reference, gains, law } = self;
        let command = |deviation: &TaskDeviation, _: &Pose| {
            let acceleration = deviation.acceleration(gains.stiffness, gains.damping);
            Ok(FrameCommand { acceleration, force: [0.0; MOST_ROWS] })
        };
        law.torque((*model).borrow(), (t, q, v), || reference(t), command, tau)
    }
}
