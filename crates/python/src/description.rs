//! Robots derived from another robot: joints locked, a payload attached, gravity scaled. [`JointMap`]
//! converts coordinates between the two.

use pyo3::prelude::*;
use robot_dynamics::description::{ModelError, RobotDescription};
use robot_dynamics::model::{Model, lock_massless};

use crate::edits::mass_properties;
use crate::errors::exception;
use crate::numbers::{array, configuration, vector};
use crate::robot::Robot;

impl Robot {
    /// The state of a robot with another description; the Python half makes the robot from it.
    pub(crate) fn edited(
        &self,
        edit: impl FnOnce(&mut RobotDescription) -> Result<(), ModelError>,
    ) -> PyResult<String> {
        let mut description = self.model.description().clone();
        edit(&mut description).map_err(exception)?;
        self.state_of(&description)
    }
}

#[pymethods]
impl Robot {
    /// See `lock`.
    fn _lock(&self, joints: Vec<(String, Option<Vec<f64>>)>) -> PyResult<String> {
        self.edited(|description| {
            joints.iter().try_for_each(|(joint, position)| {
                let rest = match position {
                    Some(position) => position.clone(),
                    None => description.resting_position(joint)?,
                };
                description.lock_joint(joint, &rest)
            })
        })
    }

    /// See `lock_massless`.
    fn _lock_massless(&self) -> PyResult<(String, Vec<String>)> {
        let mut locked = Vec::new();
        let state = self.edited(|description| {
            locked = lock_massless(description)?;
            Ok(())
        })?;
        Ok((state, locked))
    }

    /// See `with_payload`.
    fn _with_payload(
        &self,
        py: Python<'_>,
        link: &str,
        mass: f64,
        center_of_mass: &Bound<'_, PyAny>,
        inertia: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let load = mass_properties(py, mass, center_of_mass, inertia)?;
        self.edited(|description| description.attach_payload(link, &load))
    }

    /// See `with_actuated_joints`.
    fn _with_actuated_joints(&self, joints: Vec<String>) -> PyResult<String> {
        self.edited(|description| description.set_actuated_joints(joints))
    }

    /// See `with_gravity_scaled`.
    fn _with_gravity_scaled(&self, factor: f64) -> PyResult<String> {
        self.edited(|description| description.scale_gravity(factor))
    }
}

/// Converts q and v between a robot with joints locked and the whole robot.
///
/// Parameters
/// ----------
/// full : Robot
///     The whole robot.
/// reduced : Robot
///     The part: the same robot with joints locked.
/// reference : array_like, shape (nq of the whole robot,), optional
///     Configuration in which the locked joints stay; default: that of `Robot.lock`.
///
/// Raises
/// ------
/// DescriptionError
///     The part is not the whole robot with joints locked.
/// StateError
///     `reference` is invalid.
/// ShapeError
///     `reference` has the wrong shape.
///
/// Examples
/// --------
/// >>> whole = rd.example("panda")
/// >>> part = whole.lock("panda_joint7")
/// >>> joints = rd.JointMap(whole, part)
/// >>> joints.expand_velocity(np.ones(part.nv))
/// array([1., 1., 1., 1., 1., 1., 0.])
#[pyclass(frozen, module = "robot_dynamics._native")]
#[derive(Debug)]
pub(crate) struct JointMap {
    map: robot_dynamics::model::JointMap,
    full: Py<Robot>,
    reduced: Py<Robot>,
}

#[pymethods]
impl JointMap {
    #[new]
    #[pyo3(signature = (full, reduced, reference=None))]
    fn new(
        py: Python<'_>,
        full: &Bound<'_, Robot>,
        reduced: &Bound<'_, Robot>,
        reference: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (whole, part) = (full.get(), reduced.get());
        let reference = match reference {
            Some(reference) => configuration(py, whole, reference)?,
            None => resting(&whole.model),
        };
        let map =
            robot_dynamics::model::JointMap::new(&whole.model, &part.model, &reference).map_err(exception)?;
        Ok(Self { map, full: full.clone().unbind(), reduced: reduced.clone().unbind() })
    }

    /// The indices of the part's q in the whole robot's q.
    #[getter]
    fn q_indices(&self) -> Vec<usize> {
        self.map.q_indices().to_vec()
    }

    /// The indices of the part's v in the whole robot's v.
    #[getter]
    fn v_indices(&self) -> Vec<usize> {
        self.map.v_indices().to_vec()
    }

    /// The joints that are locked in the part.
    #[getter]
    fn locked_joints(&self) -> Vec<String> {
        self.map.locked_joints().to_vec()
    }

    /// Computes the whole robot's q from the part's q.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (nq of the part,)
    ///     Configuration of the part.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (nq of the whole robot,)
    ///     Configuration of the whole robot.
    ///
    /// Raises
    /// ------
    /// StateError
    ///     `q` is invalid.
    /// ShapeError
    ///     `q` has the wrong shape.
    fn expand_configuration<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut full = vec![0.0; self.full.get().model.nq()];
        self.map.expand_configuration(&configuration(py, self.reduced.get(), q)?, &mut full);
        array(py, &full)
    }

    /// Computes the whole robot's v from the part's v; it is 0 for the locked joints.
    ///
    /// Parameters
    /// ----------
    /// v : array_like, shape (nv of the part,)
    ///     Velocity of the part [rad/s or m/s].
    ///
    /// Returns
    /// -------
    /// ndarray, shape (nv of the whole robot,)
    ///     Velocity of the whole robot [rad/s or m/s].
    ///
    /// Raises
    /// ------
    /// StateError
    ///     `v` is invalid.
    /// ShapeError
    ///     `v` has the wrong shape.
    fn expand_velocity<'py>(&self, py: Python<'py>, v: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let mut full = vec![0.0; self.full.get().model.nv()];
        self.map.expand_velocity(&vector(py, self.reduced.get(), "v", v)?, &mut full);
        array(py, &full)
    }

    /// Computes the part's q from the whole robot's q.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (nq of the whole robot,)
    ///     Configuration of the whole robot.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (nq of the part,)
    ///     Configuration of the part.
    ///
    /// Raises
    /// ------
    /// StateError
    ///     `q` is invalid.
    /// ShapeError
    ///     `q` has the wrong shape.
    fn restrict_configuration<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut reduced = vec![0.0; self.reduced.get().model.nq()];
        self.map.restrict_configuration(&configuration(py, self.full.get(), q)?, &mut reduced);
        array(py, &reduced)
    }

    /// Computes the part's v from the whole robot's v.
    ///
    /// Parameters
    /// ----------
    /// v : array_like, shape (nv of the whole robot,)
    ///     Velocity of the whole robot [rad/s or m/s].
    ///
    /// Returns
    /// -------
    /// ndarray, shape (nv of the part,)
    ///     Velocity of the part [rad/s or m/s].
    ///
    /// Raises
    /// ------
    /// StateError
    ///     `v` is invalid.
    /// ShapeError
    ///     `v` has the wrong shape.
    fn restrict_velocity<'py>(&self, py: Python<'py>, v: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let mut reduced = vec![0.0; self.reduced.get().model.nv()];
        self.map.restrict_velocity(&vector(py, self.full.get(), "v", v)?, &mut reduced);
        array(py, &reduced)
    }
}

/// The configuration at which `lock` holds joints by default.
fn resting(model: &Model) -> Vec<f64> {
    let mut q = robot_dynamics::model::neutral(model);
    for joint in model.joints() {
        if let Ok(position) = model.description().resting_position(&joint.name)
            && position.len() == joint.nq
        {
            q[joint.q()].copy_from_slice(&position);
        }
    }
    q
}
