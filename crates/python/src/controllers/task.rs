//! A controller that moves a frame along a reference, through its operational-space inertia.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_dynamics::algorithms::{SpatialAcceleration, Twist};
use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::{PoseReference, TaskGains, TaskReference};
use robot_dynamics::model::FrameId;
use robot_dynamics::simulation::ControllerError;

use super::law::{Controls, Law, ReferenceSource, check_own, parts, torque};
use crate::constraints::spatial_axes;
use crate::errors::{Class, exception_of};
use crate::numbers::{configuration, halves, numbers, pose_of, several, shaped};
use crate::operand::shown;
use crate::robot::Robot;

/// Moves a frame along a reference: τ = Jᵀ(Λ (ẍʳ + kp e + kd (ẋʳ − ẋ)) + μ + p) + (1 − JᵀJ̄ᵀ) τ₀.
///
/// In the null space, which leaves the frame at rest, τ₀ = C v + g + M (kr (qʳ ⊖ q) − kn v). Coordinates
/// without a motor (`robot.actuated_dofs`), as those of a floating base, have torque 0. The base recoils, and
/// the frame follows in spite of it while nothing else touches the robot. The controller is a function of
/// (t, q, v); in `simulate` it runs in the library. A call raises `ControlError` where the frame cannot
/// accelerate in every chosen direction.
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
///     A row is unknown, given twice, or a turn of a reference without orientation.
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
    frame: FrameId,
    reference: ControlledDirections,
    gains: TaskGains,
    rows: Option<Vec<SpatialAxis>>,
    posture: Option<(Vec<f64>, f64)>,
}

/// The directions that are controlled.
enum ControlledDirections {
    Position(ReferenceSource<TaskReference>),
    Pose(ReferenceSource<PoseReference>),
}

#[pymethods]
impl TaskControl {
    #[new]
    #[pyo3(signature = (robot, frame, reference, *, stiffness, damping, null_damping=0.0, rows=None,
                        posture=None, posture_stiffness=0.0))]
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
    ) -> PyResult<Self> {
        let own = robot.get();
        let first = if reference.is_callable() { &reference.call1((0.0,))? } else { reference };
        let (place, _) = parts(first)?;
        let (shape, _) = numbers(py, "the reference", &place)?;
        let reference = match shape[..] {
            [4, 4] => ControlledDirections::Pose(ReferenceSource::of(reference, pose_reference)?),
            [3] => ControlledDirections::Position(ReferenceSource::of(reference, task_reference)?),
            _ => {
                let found = shown(&shape);
                let message = format!(
                    "the reference has shape {found}, it must have (3,), a position, or (4, 4), a pose"
                );
                return Err(Class::Shape.error(py, message));
            }
        };
        let control = Self {
            frame: own.frame_of(frame)?,
            reference,
            gains: TaskGains { stiffness, damping, null_damping },
            rows: rows.map(|rows| task_rows(&rows, &shape)).transpose()?,
            posture: match posture {
                Some(posture) => Some((configuration(py, own, posture)?, posture_stiffness)),
                None => None,
            },
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
                    self.frame,
                    reference,
                    self.gains,
                )
                .map_err(exception_of::<ControllerError>)?;
                let law = match &self.posture {
                    Some((posture, stiffness)) => {
                        law.with_posture(posture, *stiffness).map_err(exception_of::<ControllerError>)?
                    }
                    None => law,
                };
                let law = match &self.rows {
                    Some(rows) => law.with_rows(rows),
                    None => law,
                };
                Ok(Law { controller: Box::new(law), is_called })
            }};
        }
        match &self.reference {
            ControlledDirections::Position(followed) => law!(followed, task_reference),
            ControlledDirections::Pose(followed) => law!(followed, pose_reference),
        }
    }
}

/// The rows of a reference of this shape by their names.
fn task_rows(names: &[String], shape: &[usize]) -> PyResult<Vec<SpatialAxis>> {
    let rows = spatial_axes(names)?;
    if rows.is_empty() {
        return Err(PyValueError::new_err("rows is empty; name at least one of x, y, z, rx, ry, rz"));
    }
    if let Some(index) = (1..rows.len()).find(|&k| rows[..k].contains(&rows[k])) {
        return Err(PyValueError::new_err(format!("the row {:?} is given twice", names[index])));
    }
    match rows.iter().position(|row| shape == [3] && row.is_turn()) {
        None => Ok(rows),
        Some(index) => Err(PyValueError::new_err(format!(
            "the reference is a position, and the row {:?} is a turn; rows of a position are x, y, z",
            names[index]
        ))),
    }
}

const VELOCITY: &str = "the reference's velocity";
const ACCELERATION: &str = "the reference's acceleration";

fn task_reference(given: &Bound<'_, PyAny>) -> PyResult<TaskReference> {
    let (place, rates) = parts(given)?;
    let (velocity, acceleration) = match rates {
        Some((velocity, acceleration)) => {
            (several(VELOCITY, &velocity)?, several(ACCELERATION, &acceleration)?)
        }
        None => ([0.0; 3], [0.0; 3]),
    };
    Ok(TaskReference { position: several("the reference's position", &place)?, velocity, acceleration })
}

fn pose_reference(given: &Bound<'_, PyAny>) -> PyResult<PoseReference> {
    let (place, rates) = parts(given)?;
    let (_, pose) = shaped(given.py(), "the reference's pose", &place, &[4, 4])?;
    let at_rest = PoseReference::at_rest(pose_of(&pose));
    let Some((velocity, acceleration)) = rates else { return Ok(at_rest) };
    let two_vectors = |name, object: &Bound<'_, PyAny>| several(name, object).map(halves);
    let [linear, angular] = two_vectors(VELOCITY, &velocity)?;
    let velocity = Twist { linear, angular };
    let [linear, angular] = two_vectors(ACCELERATION, &acceleration)?;
    Ok(PoseReference { velocity, acceleration: SpatialAcceleration { linear, angular }, ..at_rest })
}
