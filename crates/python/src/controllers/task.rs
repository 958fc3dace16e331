//! A controller that moves a frame along a reference, through its operational-space inertia.

use pyo3::prelude::*;
use robot_dynamics::control::TaskGains;
use robot_dynamics::simulation::ControllerError;

use super::frame_task::{ControlledDirections, FrameTask, pose_reference, task_reference, with_task};
use super::law::{Controls, Law, check_own, torque};
use crate::errors::exception_of;
use crate::robot::Robot;

/// Moves a frame along a reference: τ = Jᵀ(Λ (ẍʳ + kp e + kd (ẋʳ − ẋ)) + μ + p) + (1 − JᵀJ̄ᵀ) τ₀.
///
/// In the null space, which leaves the frame at rest, τ₀ = C v + g + M (kr (qʳ ⊖ q) − kn v). Coordinates
/// without a motor (`robot.actuated_dofs`), as those of a floating base, have torque 0. The base recoils, and
/// the frame follows in spite of it while nothing else touches the robot. The controller is a function of
/// (t, q, v); in `simulate` it runs in the library. Near a singular pose Λ is damped. A call raises
/// `ControlError` if a chosen direction depends on the others at every pose. A command beyond the effort
/// limits is scaled: the frame keeps its direction, and the null space has the rest of the effort.
///
/// Parameters
/// ----------
/// robot : Robot
///     Robot to control.
/// frame : str or int
///     Name of the frame, or its index in `frame_names`.
/// reference : array_like, tuple of three array_like, or function
///     Target of the frame in the world: its origin (3,) with free orientation [m], or its pose (4, 4). With
///     its velocity and acceleration along the world's axes it is (xʳ, ẋʳ, ẍʳ), for a pose with six numbers
///     each. A function of t [s] returns one of these; it is called once at t = 0 to find which.
/// stiffness : float
///     kp [1/s²].
/// damping : float
///     kd [1/s]; kd = 2 √kp is critically damped.
/// null_damping : float
///     kn, damping in the null space [1/s].
/// rows : sequence of str, optional
///     Controlled directions among x, y, z, rx, ry, rz along the world's axes, for example ("x", "z") for an
///     arm in that plane; default: all directions of the reference.
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
///     The frame does not exist.
/// ShapeError
///     The reference or `posture` has the wrong shape.
/// StateError
///     `posture` is not a configuration.
/// ControlError
///     A gain is invalid.
/// ValueError
///     A row is unknown, given twice, or a turn of a reference without orientation; or a limit is negative.
///
/// Examples
/// --------
///
/// >>> robot, q = rd.example("panda"), np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.6])
/// >>> goal = robot.frame_pose(q, "panda_link8") @ np.block([[np.eye(3), np.full((3, 1), 0.05)], [0.0, 0.0, 0.0, 1.0]])
/// >>> lead = rd.TaskControl(robot, "panda_link8", goal, stiffness=100.0, damping=20.0, null_damping=10.0)
/// >>> motion = robot.simulate(q, tau=lead, duration=1.5)
/// >>> bool(np.allclose(robot.frame_pose(motion.q[-1], "panda_link8"), goal, atol=1e-3))
/// True
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct TaskControl {
    robot: Py<Robot>,
    task: FrameTask,
    gains: TaskGains,
}

#[pymethods]
impl TaskControl {
    #[new]
    #[pyo3(signature = (robot, frame, reference, *, stiffness, damping, null_damping=0.0, rows=None,
                        posture=None, posture_stiffness=0.0, limits=None))]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        frame: &Bound<'_, PyAny>,
        reference: &Bound<'_, PyAny>,
        stiffness: f64,
        damping: f64,
        null_damping: f64,
        rows: Option<Vec<String>>,
        posture: Option<&Bound<'_, PyAny>>,
        posture_stiffness: f64,
        limits: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let own = robot.get();
        let posture = (posture, posture_stiffness);
        let control = Self {
            task: FrameTask::of(py, own, (frame, reference), rows, posture, limits)?,
            gains: TaskGains { stiffness, damping, null_damping },
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

impl Controls for TaskControl {
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>> {
        check_own(py, self.robot.get(), robot)?;
        macro_rules! law {
            ($followed:expr, $read:expr) => {{
                let followed = $followed.share(py);
                let is_called = followed.is_called();
                let reference = move |t: f64| followed.at(t, $read);
                let law = robot_dynamics::control::TaskControl::new(
                    &robot.model,
                    self.task.frame,
                    reference,
                    self.gains,
                )
                .map_err(exception_of::<ControllerError>)?;
                Ok(Law { controller: Box::new(with_task!(law, &self.task)), is_called })
            }};
        }
        match &self.task.reference {
            ControlledDirections::Position(followed) => law!(followed, task_reference),
            ControlledDirections::Pose(followed) => law!(followed, pose_reference),
        }
    }
}
