//! Control of a frame through its operational-space inertia.

use std::borrow::Borrow;

use robot_dynamics_core::{
    FrameId, Model, ReferenceFrame, check_configuration, difference, frame_pose, frame_velocity,
    inverse_dynamics,
};
use robot_dynamics_description::check_length;
use robot_dynamics_number::check_number;
use robot_dynamics_simulation::motion::simulate::{check_controller_input, check_torque};
use robot_dynamics_simulation::{Controller, ControllerError, SpatialAxis};

use super::mobility::MOST_ROWS;
use super::{
    OperationalSpace, OperationalSpaceInputs, OperationalSpaceWorkspace, TaskTarget, operational_space_into,
};

/// A row is damped if its mobility independent of the others is below this fraction of its own.
const DAMPING: f64 = 1e-3;

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
/// Near a singular pose Λ is damped. Let r be the independent mobility of a row as a fraction of its own
/// mobility (J M⁻¹Jᵀ)_kk. If r < 1e-3, the fraction (1e-3 − r) of each row's mobility is added to it. The
/// frame then lags in that direction, and the torque for it stays within about 16 times that of a regular
/// pose. Elsewhere Λ is exact. At a singular pose, where a row has no independent mobility, the controller
/// returns an error, and a run ends.
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
    frame: FrameId,
    reference: F,
    /// The controlled rows, and the index of each among the rows of the target.
    rows: Vec<SpatialAxis>,
    places: Vec<usize>,
    gains: TaskGains,
    /// q\* and kr.
    posture: Option<(Vec<f64>, f64)>,
    workspace: OperationalSpaceWorkspace,
    space: OperationalSpace,
    /// kr (q\* ⊖ q) − kn v.
    rest_acceleration: Vec<f64>,
    /// τ₀.
    rest_torque: Vec<f64>,
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
        check_number("the null damping", gains.null_damping)?;
        let model: &Model = robot.borrow();
        let nv = model.nv();
        Ok(Self {
            frame,
            reference,
            rows: T::ROWS.to_vec(),
            places: (0..T::ROWS.len()).collect(),
            gains,
            posture: None,
            workspace: OperationalSpaceWorkspace::of_actuated(model, DAMPING),
            space: OperationalSpace::zeros(model, T::ROWS.len()),
            rest_acceleration: vec![0.0; nv],
            rest_torque: vec![0.0; nv],
            model: robot,
        })
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
        assert!(!rows.is_empty(), "a task has at least one row");
        let place = |(index, row): (usize, &SpatialAxis)| {
            assert!(!rows[..index].contains(row), "the row `{}` is given twice", row.name());
            T::ROWS.iter().position(|own| own == row).unwrap_or_else(|| {
                let names: Vec<&str> = T::ROWS.iter().map(|row| row.name()).collect();
                panic!("the row `{}` is not among {}, which the reference has", row.name(), names.join(", "))
            })
        };
        self.places = rows.iter().enumerate().map(place).collect();
        self.rows = rows.to_vec();
        self.space = OperationalSpace::zeros(self.model.borrow(), rows.len());
        self
    }

    /// Adds a spring to the posture q\* with kr \[1/s²\]; kn = 2 √kr is critically damped.
    ///
    /// # Errors
    /// [`ControllerError`] if q\* is an invalid configuration, or kr is not finite.
    pub fn with_posture(mut self, posture: &[f64], stiffness: f64) -> Result<Self, ControllerError> {
        check_configuration(self.model.borrow(), posture)?;
        check_number("the posture's stiffness", stiffness)?;
        self.posture = Some((posture.to_vec(), stiffness));
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
        let Self { model, frame, gains, workspace, space, .. } = self;
        let model: &Model = (*model).borrow();
        let TaskGains { stiffness, damping, null_damping } = *gains;
        check_length("tau", tau.len(), model.nv());
        check_controller_input(model, t, q, v)?;
        operational_space_into(
            model,
            workspace,
            OperationalSpaceInputs { q, v, frame: *frame, rows: &self.rows },
            space,
        )?;
        let OperationalSpaceWorkspace { dynamics, scratch } = workspace;
        let pose = frame_pose(model, dynamics, q, *frame);
        let velocity = frame_velocity(model, dynamics, q, v, *frame, ReferenceFrame::LocalWorldAligned);
        let command = (self.reference)(t).acceleration(&pose, &velocity, stiffness, damping)?;

        let rest = &mut self.rest_acceleration[..];
        match &self.posture {
            Some((posture, _)) => difference(model, q, posture, rest),
            None => rest.fill(0.0),
        }
        let spring = self.posture.as_ref().map_or(0.0, |(_, spring)| *spring);
        rest.iter_mut().zip(v).for_each(|(rest, v)| *rest = spring * *rest - null_damping * v);
        if let Some(part) = &scratch.part {
            part.clear_unactuated(rest);
        }
        inverse_dynamics(model, dynamics, q, v, rest, &mut self.rest_torque);
        if let Some(part) = &mut scratch.part {
            part.reduce(&mut self.rest_torque);
        }
        check_torque(&self.rest_torque)?;
        let mut chosen = [0.0; MOST_ROWS];
        chosen.iter_mut().zip(&self.places).for_each(|(entry, &place)| *entry = command[place]);
        space.torque_with_posture(&chosen[..self.rows.len()], &self.rest_torque, tau)
    }
}
