//! Impedance control: a frame that answers a wrench as a mass, a damper and a spring.

use std::borrow::Borrow;

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Pose;
use robot_dynamics_number::{InvalidInput, check_finite, check_positive};
use robot_dynamics_simulation::{Controller, ControllerError, IntoCallbackResult, SpatialAxis};

use super::effort_limits::EffortScales;
use super::frame_law::{FrameCommand, FrameLaw};
use super::mobility::MOST_ROWS;
use super::{TaskDeviation, TaskTarget};

/// The impedance of a frame along the world's axes x, y, z, rx, ry, rz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpedanceGains {
    /// K \[N/m, N·m/rad\].
    pub stiffness: [f64; MOST_ROWS],
    /// D \[N·s/m, N·m·s/rad\].
    pub damping: [f64; MOST_ROWS],
    /// kn \[1/s\], the damping in the null space.
    pub null_damping: f64,
}

/// The desired inertia of a frame, and the measured wrench that it needs.
#[derive(Clone, Debug)]
struct DesiredInertia<W> {
    /// The reciprocals of M_d.
    mobility: [f64; MOST_ROWS],
    /// `frame_from_sensor`.
    sensor: Pose,
    wrench: W,
}

impl<W> DesiredInertia<W> {
    /// A wrench of the sensor as force and moment at the frame, along the world's axes.
    fn in_world(&self, wrench: [f64; MOST_ROWS], world_from_frame: &Pose) -> [f64; MOST_ROWS] {
        let sensor = world_from_frame.compose(&self.sensor);
        let [force, moment] = [[0, 1, 2], [3, 4, 5]].map(|part| sensor.rotate(part.map(|k| wrench[k])));
        let arm = world_from_frame.rotate(self.sensor.translation);
        let turned = [
            arm[1] * force[2] - arm[2] * force[1],
            arm[2] * force[0] - arm[0] * force[2],
            arm[0] * force[1] - arm[1] * force[0],
        ];
        core::array::from_fn(|k| if k < 3 { force[k] } else { moment[k - 3] + turned[k - 3] })
    }
}

/// Impedance control of a frame. With e = x\* ⊖ x and the external wrench f_ext that acts on the frame,
///
/// > Λ (ẍ − ẍ\*) = D ė + K e + f_ext,  τ = Jᵀ(Λ ẍ\* + D ė + K e + μ + p) + (1 − JᵀJ̄ᵀ) τ₀.
///
/// The frame keeps its own inertia Λ, and f_ext is not measured. [`with_inertia`](Self::with_inertia)
/// replaces Λ by a constant diagonal M_d. That needs the measured wrench:
///
/// > M_d (ẍ − ẍ\*) = D ė + K e + f_ext,  τ = Jᵀ(Λ (ẍ\* + M_d⁻¹(D ė + K e + f_ext)) + μ + p − f_ext) + …
///
/// τ₀, rows, damping near a singular pose and effort limits are those of [`TaskControl`](super::TaskControl).
/// It does not allocate.
///
/// Source: Hogan, *Impedance control: an approach to manipulation*, J. Dynamic Systems, Measurement and
/// Control 107 (1985).
///
/// ```
/// use robot_dynamics::constraints::SpatialAxis;
/// use robot_dynamics::control::{ImpedanceControl, ImpedanceGains, TaskReference};
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics::simulation::Controller;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let raised = |_t| TaskReference { position: [0.5, 0.0, 0.1], velocity: [0.0; 3], acceleration: [0.0; 3] };
/// let gains = ImpedanceGains { stiffness: [300.0; 6], damping: [20.0; 6], null_damping: 0.0 };
/// let control = ImpedanceControl::new(&model, model.frame_named("tip")?, raised, gains)?;
/// let mut control = control.with_rows(&[SpatialAxis::Z]);
/// let mut tau = [0.0];
/// control.torque(0.0, &[0.0], &[0.0], &mut tau)?; // horizontal rod, 0.1 m below the reference
/// assert!((tau[0].abs() - 0.5 * (300.0 * 0.1 + 2.0 * 9.81)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ImpedanceControl<M, F, W = fn(f64) -> [f64; MOST_ROWS]> {
    model: M,
    reference: F,
    gains: ImpedanceGains,
    inertia: Option<DesiredInertia<W>>,
    law: FrameLaw,
}

impl<'a, F, T> ImpedanceControl<&'a Model, F>
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
        gains: ImpedanceGains,
    ) -> Result<Self, ControllerError> {
        Self::owning(model, frame, reference, gains)
    }
}

impl<M, F, T> ImpedanceControl<M, F>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> T,
    T: TaskTarget,
{
    /// [`new`](ImpedanceControl::new) with a robot that the controller stores: an `Arc<Model>`, a `Model`, or
    /// a reference.
    ///
    /// # Errors
    /// As [`new`](ImpedanceControl::new).
    pub fn owning(
        robot: M,
        frame: FrameId,
        reference: F,
        gains: ImpedanceGains,
    ) -> Result<Self, ControllerError> {
        check_finite("the stiffness", &gains.stiffness)?;
        check_finite("the damping", &gains.damping)?;
        let law = FrameLaw::new::<T>(robot.borrow(), frame, gains.null_damping)?;
        Ok(Self { model: robot, reference, gains, inertia: None, law })
    }

    /// Sets M_d \[kg, kg·m²\] along the world's axes, and the measured wrench. `wrench(t)` returns force and
    /// moment that the environment exerts on the robot at a sensor's frame, along that frame's axes, or a
    /// `Result` of them. The sensor belongs to the link of the controlled frame.
    ///
    /// ```
    /// use robot_dynamics::constraints::SpatialAxis;
    /// use robot_dynamics::control::{ImpedanceControl, ImpedanceGains, TaskReference};
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Controller;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let tip = model.frame_named("tip")?;
    /// let here = |_t| TaskReference { position: [0.5, 0.0, 0.0], velocity: [0.0; 3], acceleration: [0.0; 3] };
    /// let gains = ImpedanceGains { stiffness: [0.0; 6], damping: [0.0; 6], null_damping: 0.0 };
    /// let push = |_t| [0.0, 0.0, 10.0, 0.0, 0.0, 0.0];
    /// let control = ImpedanceControl::new(&model, tip, here, gains)?.with_inertia([20.0; 6], tip, push)?;
    /// let mut control = control.with_rows(&[SpatialAxis::Z]);
    /// let mut tau = [0.0];
    /// control.torque(0.0, &[0.0], &[0.0], &mut tau)?;
    /// // The push moves the tip as a mass of 20 kg, not 2 kg: the motor takes 9 N of it.
    /// assert!((tau[0].abs() - 0.5 * (2.0 * 9.81 - 9.0)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if an entry of M_d is not positive and finite, or the sensor moves
    /// relative to the frame.
    pub fn with_inertia<W, R>(
        self,
        inertia: [f64; MOST_ROWS],
        sensor: FrameId,
        wrench: W,
    ) -> Result<ImpedanceControl<M, F, W>, ControllerError>
    where
        W: FnMut(f64) -> R,
        R: IntoCallbackResult<[f64; MOST_ROWS]>,
    {
        for entry in inertia {
            check_positive("the desired inertia", entry, "")?;
        }
        let model: &Model = self.model.borrow();
        let [own, other] = [self.law.frame, sensor].map(|frame| model.frame_of(frame));
        if own.body != other.body {
            let requirement = format!("must belong to the link of the controlled frame `{}`", own.name);
            return Err(InvalidInput::unmet(format!("the sensor `{}`", other.name), requirement).into());
        }
        let sensor = own.body_from_frame.inverse().compose(&other.body_from_frame);
        let inertia = DesiredInertia { mobility: inertia.map(f64::recip), sensor, wrench };
        let Self { model, reference, gains, law, .. } = self;
        Ok(ImpedanceControl { model, reference, gains, inertia: Some(inertia), law })
    }
}

impl<M, F, W, T> ImpedanceControl<M, F, W>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> T,
    T: TaskTarget,
{
    /// Controls only these of the target's rows, as [`TaskControl::with_rows`](super::TaskControl::with_rows).
    ///
    /// # Panics
    /// Panics if no row is given, if a row is given twice, or if a row is not among the target's.
    #[must_use]
    #[track_caller]
    pub fn with_rows(mut self, rows: &[SpatialAxis]) -> Self {
        self.law.select_rows::<T>(self.model.borrow(), rows);
        self
    }

    /// Adds a spring to the posture q\* with kr \[1/s²\]; kn = 2 √kr is critically damped.
    ///
    /// # Errors
    /// [`ControllerError`] if q\* is an invalid configuration, or kr is not finite.
    pub fn with_posture(mut self, posture: &[f64], stiffness: f64) -> Result<Self, ControllerError> {
        self.law.set_posture(self.model.borrow(), posture, stiffness)?;
        Ok(self)
    }

    /// Replaces the joints' effort limits; nv entries \[N·m or N\], infinite without a limit.
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
}

impl<M, F, W, T, R> Controller for ImpedanceControl<M, F, W>
where
    M: Borrow<Model>,
    F: FnMut(f64) -> T,
    T: TaskTarget,
    W: FnMut(f64) -> R,
    R: IntoCallbackResult<[f64; MOST_ROWS]>,
{
    /// # Panics
    /// Panics if τ has the wrong length, or the frame belongs to another model.
    fn torque(&mut self, t: f64, q: &[f64], v: &[f64], tau: &mut [f64]) -> Result<(), ControllerError> {
        let Self { model, reference, gains, inertia, law } = self;
        let command = |deviation: &TaskDeviation, pose: &Pose| {
            let TaskDeviation { position, velocity, acceleration } = *deviation;
            let restoring: [f64; MOST_ROWS] =
                core::array::from_fn(|k| gains.damping[k] * velocity[k] + gains.stiffness[k] * position[k]);
            let Some(desired) = inertia else {
                return Ok(FrameCommand { acceleration, force: restoring });
            };
            let wrench = (desired.wrench)(t).outcome()?;
            check_finite("the measured wrench", &wrench)?;
            let external = desired.in_world(wrench, pose);
            let acceleration = core::array::from_fn(|k| {
                acceleration[k] + desired.mobility[k] * (restoring[k] + external[k])
            });
            Ok(FrameCommand { acceleration, force: external.map(|entry| -entry) })
        };
        law.torque((*model).borrow(), (t, q, v), || reference(t), command, tau)
    }
}
