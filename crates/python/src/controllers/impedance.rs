//! A controller that makes a frame answer a wrench as a mass, a damper and a spring.

use pyo3::prelude::*;
use robot_dynamics::control::ImpedanceGains;
use robot_dynamics::model::FrameId;
use robot_dynamics::simulation::ControllerError;

use super::frame_task::{ControlledDirections, FrameTask, pose_reference, task_reference, with_task};
use super::law::{Controls, Law, ReferenceSource, check_own, torque};
use crate::errors::exception_of;
use crate::numbers::several;
use crate::robot::Robot;

/// Makes a frame answer a wrench f as a damped spring: Λ (ẍ − ẍʳ) = D ė + K e + f with e = xʳ ⊖ x.
///
/// τ = Jᵀ(Λ ẍʳ + D ė + K e + μ + p) + (1 − JᵀJ̄ᵀ) τ₀. The frame keeps its own inertia Λ, and f is not
/// measured. With `inertia`, M_d (ẍ − ẍʳ) = D ė + K e + f for a constant diagonal M_d; that needs the
/// measured `wrench`. Gains are along the world's axes x, y, z, rx, ry, rz. Null space, rows, damping near
/// singular poses and effort limits are those of `TaskControl`. The controller is a function of (t, q, v); in
/// `simulate` it runs in the library.
///
/// Parameters
/// ----------
/// robot : Robot
///     Robot to control.
/// frame : str or int
///     Name of the frame, or its index in `frame_names`.
/// reference : array_like, tuple of three array_like, or function
///     Target of the frame, as for `TaskControl`.
/// stiffness : array_like, shape (6,)
///     K [N/m, N·m/rad].
/// damping : array_like, shape (6,)
///     D [N·s/m, N·m·s/rad].
/// null_damping : float
///     kn, damping in the null space [1/s].
/// inertia : array_like, shape (6,), optional
///     M_d [kg, kg·m²]; default: the frame's own Λ.
/// wrench : array_like, shape (6,), or function, optional
///     Force and moment that the environment exerts at the sensor, along the sensor's axes [N, N·m]. A
///     function of t [s] returns them. It is needed with `inertia`.
/// sensor : str or int, optional
///     Frame of the sensor, on the link of `frame`; default: `frame`.
/// rows : sequence of str, optional
///     Controlled directions, as for `TaskControl`.
/// posture : array_like, shape (nq,), optional
///     Configuration qʳ to which the null space is pulled.
/// posture_stiffness : float
///     kr [1/s²].
/// limits : array_like, shape (nv,), optional
///     Largest torques [N·m or N]; default: the effort limits of the robot.
///
/// Raises
/// ------
/// FrameError
///     A frame does not exist.
/// ShapeError
///     An array has the wrong shape.
/// StateError
///     `posture` is not a configuration.
/// ControlError
///     A gain is invalid, or the sensor is on another link.
/// ValueError
///     A row is unknown, given twice, or a turn of a reference without orientation; a limit is negative; or
///     only one of `inertia` and `wrench` is given.
///
/// Examples
/// --------
///
/// >>> robot, q = rd.example("panda"), np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
/// >>> here = robot.frame_pose(q, "panda_link8")
/// >>> soft = rd.ImpedanceControl(robot, "panda_link8", here, stiffness=[400, 400, 400, 30, 30, 30],
/// ...                            damping=[40, 40, 40, 3, 3, 3], null_damping=5.0)
/// >>> sim = rd.Simulation(robot, dt=1e-3)
/// >>> sim.reset(q)
/// >>> sim.apply_wrench("panda_link8", force=(0.0, 8.0, 0.0))
/// >>> for _ in range(3000):
/// ...     sim.torques = soft(sim.time, sim.q, sim.v)
/// ...     sim.step()
/// >>> bool(abs((robot.frame_pose(sim.q, "panda_link8") - here)[1, 3] - 8.0 / 400.0) < 2e-3)  # f / K
/// True
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct ImpedanceControl {
    robot: Py<Robot>,
    task: FrameTask,
    gains: ImpedanceGains,
    inertia: Option<([f64; 6], FrameId, ReferenceSource<[f64; 6]>)>,
}

#[pymethods]
impl ImpedanceControl {
    #[new]
    #[pyo3(signature = (robot, frame, reference, *, stiffness, damping, null_damping=0.0, inertia=None,
                        wrench=None, sensor=None, rows=None, posture=None, posture_stiffness=0.0,
                        limits=None))]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        frame: &Bound<'_, PyAny>,
        reference: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        null_damping: f64,
        inertia: Option<&Bound<'_, PyAny>>,
        wrench: Option<&Bound<'_, PyAny>>,
        sensor: Option<&Bound<'_, PyAny>>,
        rows: Option<Vec<String>>,
        posture: Option<&Bound<'_, PyAny>>,
        posture_stiffness: f64,
        limits: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let own = robot.get();
        let inertia = match (inertia, wrench) {
            (Some(inertia), Some(wrench)) => {
                let sensor = own.frame_of(sensor.unwrap_or(frame))?;
                Some((several("inertia", inertia)?, sensor, ReferenceSource::of(wrench, wrench_of)?))
            }
            (None, None) => None,
            _ => {
                let message =
                    "inertia and wrench belong together: a desired inertia needs the measured wrench";
                return Err(pyo3::exceptions::PyValueError::new_err(message));
            }
        };
        let posture = (posture, posture_stiffness);
        let control = Self {
            task: FrameTask::of(py, own, (frame, reference), rows, posture, limits)?,
            gains: ImpedanceGains {
                stiffness: several("stiffness", stiffness)?,
                damping: several("damping", damping)?,
                null_damping,
            },
            inertia,
            robot: robot.clone().unbind(),
        };
        control.law(py, own)?;
        Ok(control)
    }

    /// τ (nv,) of a state.
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        torque(py, self, self.robot.get(), (t, q, v))
    }
}

impl Controls for ImpedanceControl {
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>> {
        check_own(py, self.robot.get(), robot)?;
        macro_rules! law {
            ($followed:expr, $read:expr) => {{
                let followed = $followed.share(py);
                let mut is_called = followed.is_called();
                let reference = move |t: f64| followed.at(t, $read);
                let law = robot_dynamics::control::ImpedanceControl::new(
                    &robot.model,
                    self.task.frame,
                    reference,
                    self.gains,
                )
                .map_err(exception_of::<ControllerError>)?;
                let law = with_task!(law, &self.task);
                let controller: Box<dyn robot_dynamics::simulation::Controller + Send + 'a> =
                    match &self.inertia {
                        None => Box::new(law),
                        Some((inertia, sensor, wrench)) => {
                            let wrench = wrench.share(py);
                            is_called |= wrench.is_called();
                            let measured = move |t: f64| wrench.at(t, wrench_of);
                            let law = law.with_inertia(*inertia, *sensor, measured);
                            Box::new(law.map_err(exception_of::<ControllerError>)?)
                        }
                    };
                Ok(Law { controller, is_called })
            }};
        }
        match &self.task.reference {
            ControlledDirections::Position(followed) => law!(followed, task_reference),
            ControlledDirections::Pose(followed) => law!(followed, pose_reference),
        }
    }
}

/// Force and moment.
fn wrench_of(given: &Bound<'_, PyAny>) -> PyResult<[f64; 6]> {
    several("wrench", given)
}
