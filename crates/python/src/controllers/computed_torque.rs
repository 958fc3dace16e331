//! The motion's own inverse dynamics, and feedback through M.

use pyo3::prelude::*;
use robot_dynamics::control::Reference;
use robot_dynamics::simulation::ControllerError;

use super::law::{Controls, Law, ReferenceSource, check_own, parts, torque};
use crate::errors::exception_of;
use crate::numbers::{configuration, vector};
use crate::robot::Robot;

/// Follows a motion: τ = M(q)(aʳ + Kp (qʳ ⊖ q) + Kd (vʳ − v)) + C v + g with diagonal gains.
///
/// The error of plain coordinates obeys ë + Kd ė + Kp e = 0 whatever the robot. MLS §4.5. Coordinates without
/// a motor (`robot.actuated_dofs`), as those of a floating base, have torque 0 and move freely. The others
/// follow the motion in spite of it while nothing else touches the robot. The controller is a function of
/// (t, q, v); in `simulate` it runs in the library.
///
/// Parameters
/// ----------
/// robot : Robot
///     Robot to control.
/// reference : array_like, tuple of three array_like, or function
///     Reference (qʳ, vʳ, aʳ), or qʳ alone at rest, or a function of t [s] that returns one of these.
/// stiffness : array_like, shape (nv,)
///     Kp [1/s²].
/// damping : array_like, shape (nv,)
///     Kd [1/s]; Kd = 2 √Kp is critically damped.
/// dissipation : bool
///     Whether to compensate the damping and friction of the joints.
///
/// Raises
/// ------
/// StateError
///     A number is not finite, or the reference is not a configuration.
/// ShapeError
///     An array has the wrong shape.
///
/// Examples
/// --------
///
/// >>> robot = rd.example("two_r")
/// >>> swing = lambda t: ([np.sin(t), np.cos(t)], [np.cos(t), -np.sin(t)], [-np.sin(t), -np.cos(t)])
/// >>> follow = rd.ComputedTorque(robot, swing, [100.0, 100.0], [20.0, 20.0])
/// >>> motion = robot.simulate([0.0, 0.5], tau=follow, duration=2.0, without=["effort-limits"])
/// >>> bool(np.abs(motion.q[-1] - [np.sin(2.0), np.cos(2.0)]).max() < 1e-2)
/// True
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct ComputedTorque {
    robot: Py<Robot>,
    reference: ReferenceSource<Reference>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    dissipation: bool,
}

#[pymethods]
impl ComputedTorque {
    #[new]
    #[pyo3(signature = (robot, reference, stiffness, damping, *, dissipation=false))]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        reference: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        dissipation: bool,
    ) -> PyResult<Self> {
        let own = robot.get();
        Ok(Self {
            reference: ReferenceSource::of(reference, |given| reference_of(own, given))?,
            stiffness: vector(py, own, "stiffness", stiffness)?,
            damping: vector(py, own, "damping", damping)?,
            dissipation,
            robot: robot.clone().unbind(),
        })
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

impl Controls for ComputedTorque {
    fn law<'a>(&self, py: Python<'_>, robot: &'a Robot) -> PyResult<Law<'a>> {
        check_own(py, self.robot.get(), robot)?;
        let followed = self.reference.share(py);
        let is_called = followed.is_called();
        let reference = move |t: f64| followed.at(t, |given| reference_of(robot, given));
        let law = robot_dynamics::control::ComputedTorque::new(
            &robot.model,
            reference,
            &self.stiffness,
            &self.damping,
        )
        .map_err(exception_of::<ControllerError>)?;
        let law = if self.dissipation { law.with_dissipation() } else { law };
        Ok(Law { controller: Box::new(law), is_called })
    }
}

/// (q, v, a), or q alone.
fn reference_of(robot: &Robot, given: &Bound<'_, PyAny>) -> PyResult<Reference> {
    let (py, nv) = (given.py(), robot.model.nv());
    let (place, rates) = parts(given)?;
    let q = configuration(py, robot, &place)?;
    let (v, a) = match rates {
        Some((v, a)) => {
            (vector(py, robot, "v of the reference", &v)?, vector(py, robot, "a of the reference", &a)?)
        }
        None => (vec![0.0; nv], vec![0.0; nv]),
    };
    Ok(Reference { q, v, a })
}
