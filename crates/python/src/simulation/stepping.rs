//! A simulation as Python steps it.

use std::collections::HashMap;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use robot_dynamics::simulation::{AppliedWrench, Simulation as Stepped, SimulationError, Snapshot as Kept};

use super::contact_fields::ContactFields;
use super::energy_account::{energy_account_of, losses_of};
use super::options::Setup;
use super::setup::{controls_of, failed_step};
use crate::errors::{exception, exception_of};
use crate::numbers::{array, configuration, shaped, vector, vector_or_zeros};
use crate::robot::Robot;
use crate::row::reference_frame_of;

/// The native half of `robot_dynamics.Simulation`.
#[pyclass(subclass, module = "robot_dynamics._native")]
pub(crate) struct Simulation {
    robot: Py<Robot>,
    stepped: Stepped,
    wrenches: Vec<AppliedWrench>,
}

/// The state of a simulation with all that changes in it, made by `Simulation.snapshot`.
#[pyclass(frozen, module = "robot_dynamics._native")]
pub(crate) struct Snapshot(Kept, Vec<AppliedWrench>);

impl Simulation {
    /// The simulation of a robot, as it is.
    pub(super) fn of(robot: Py<Robot>, stepped: Stepped) -> Self {
        let wrenches = stepped.wrenches().to_vec();
        Self { robot, stepped, wrenches }
    }

    /// The simulation of the library.
    pub(crate) fn stepped(&self) -> &Stepped {
        &self.stepped
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (robot, **options))]
    fn new(py: Python<'_>, robot: Py<Robot>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let like = options.map(|options| options.get_item("like")).transpose()?.flatten();
        if let Some(like) = like {
            let like = like.cast::<Self>()?.borrow();
            let (stepped, wrenches) = (like.stepped.clone(), like.wrenches.clone());
            return Ok(Self { robot: like.robot.clone_ref(py), stepped, wrenches });
        }
        let stepped = Setup::of(options)?.build(py, robot.get())?;
        Ok(Self { robot, stepped, wrenches: Vec::new() })
    }

    /// The robot.
    #[getter]
    pub(crate) fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.robot.clone_ref(py)
    }

    /// Length of a step [s].
    #[getter]
    fn dt(&self) -> f64 {
        self.stepped.dt()
    }

    /// The method by which steps are taken.
    #[getter]
    fn method(&self) -> &'static str {
        self.stepped.method().name()
    }

    /// Why that method was chosen.
    #[getter]
    fn reason(&self) -> &str {
        self.stepped.reason()
    }

    /// The features that the robot's file states and this simulation leaves out, each with the reason.
    #[getter]
    fn left_out<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.stepped.left_out())
    }

    /// The time [s].
    #[getter]
    fn time(&self) -> f64 {
        self.stepped.time()
    }

    /// Steps since the last reset.
    #[getter]
    fn steps(&self) -> usize {
        self.stepped.steps()
    }

    /// The configuration (nq,), a copy.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.q())
    }

    /// The velocity (nv,), a copy.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.v())
    }

    /// The mean acceleration of the last step (nv,) [rad/s² or m/s²].
    #[getter]
    fn acceleration<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.acceleration())
    }

    /// The torques that acted in the last step, within the effort limits (nv,) [N·m or N].
    #[getter]
    fn applied_torques<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.applied_torques())
    }

    /// The number of steps in which each coordinate's torque was cut off at the effort limit.
    #[getter]
    fn steps_at_effort_limits(&self) -> Vec<usize> {
        self.stepped.steps_at_effort_limits().to_vec()
    }

    /// The names of the actuators that act, in the order of `controls`.
    #[getter]
    fn control_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.stepped.control_names().collect::<Vec<_>>())
    }

    /// The controls of the actuators, held until they are set again: an array, or numbers by name.
    #[getter]
    fn controls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.controls())
    }

    #[setter]
    fn set_controls(&mut self, py: Python<'_>, controls: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = if let Ok(named) = controls.extract::<HashMap<String, f64>>() {
            let mut values = self.stepped.controls().to_vec();
            controls_of(self.robot.get(), &self.stepped, named, &mut values)?;
            values
        } else {
            shaped(py, "controls", controls, &[self.stepped.controls().len()])?.1
        };
        self.stepped.set_controls(&values);
        Ok(())
    }

    /// The activations of the actuators, and then the states of controllers and motors.
    #[getter]
    fn activations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.activations())
    }

    #[setter]
    fn set_activations(&mut self, py: Python<'_>, activations: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = shaped(py, "activations", activations, &[self.stepped.activations().len()])?.1;
        self.stepped.set_activations(&values);
        Ok(())
    }

    /// The torques of the next steps (nv,), held until they are set again [N·m or N].
    #[setter]
    fn set_torques(&mut self, py: Python<'_>, torques: &Bound<'_, PyAny>) -> PyResult<()> {
        let torques = vector(py, self.robot.get(), "torques", torques)?;
        self.stepped.set_torques(&torques);
        Ok(())
    }

    #[getter]
    fn torques<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.torques())
    }

    /// The force of each actuator before its gear, the mean over the last step [N·m or N].
    #[getter]
    fn actuator_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.actuator_forces())
    }

    /// The generalised forces of all actuators together, the mean over the last step [N·m or N].
    #[getter]
    fn actuator_torques<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.stepped.actuator_torques())
    }

    /// See `apply_wrench`.
    fn _apply_wrench(
        &mut self,
        frame: &Bound<'_, PyAny>,
        force: [f64; 3],
        moment: [f64; 3],
        axes: &str,
    ) -> PyResult<()> {
        let axes = reference_frame_of("axes", axes)?;
        let frame = self.robot.get().frame_of(frame)?;
        self.wrenches.push(AppliedWrench { frame, axes, force, moment });
        self.stepped.set_wrenches(&self.wrenches);
        Ok(())
    }

    /// Removes all wrenches.
    fn clear_wrenches(&mut self) {
        self.wrenches.clear();
        self.stepped.set_wrenches(&[]);
    }

    /// See `reset`.
    fn _reset(
        &mut self,
        py: Python<'_>,
        q: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
        pose: Option<&str>,
    ) -> PyResult<()> {
        let robot = self.robot.get();
        if let Some(pose) = pose {
            self.stepped.reset_to(pose).map_err(exception)?;
        } else {
            let q = match q {
                Some(q) => configuration(py, robot, q)?,
                None => robot.model.initial_configuration(),
            };
            let v = vector_or_zeros(py, robot, "v", v)?;
            self.stepped.reset(&q, &v).map_err(exception)?;
        }
        self.wrenches.clear();
        Ok(())
    }

    /// Continues from (q, v) at the same time, with the same inputs. The energy account starts again.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (nq,)
    ///     Configuration.
    /// v : array_like, shape (nv,)
    ///     Velocity [rad/s or m/s].
    ///
    /// Raises
    /// ------
    /// StateError
    ///     `q` or `v` is invalid.
    /// ShapeError
    ///     An array has the wrong shape.
    /// SimulationError
    ///     The state violates the constraints, or the simulation cannot start there.
    fn set_state(&mut self, py: Python<'_>, q: &Bound<'_, PyAny>, v: &Bound<'_, PyAny>) -> PyResult<()> {
        let (q, v) = (configuration(py, self.robot.get(), q)?, vector(py, self.robot.get(), "v", v)?);
        self.stepped.set_state(&q, &v).map_err(exception)
    }

    /// Takes steps; an interrupt ends them between two steps.
    ///
    /// Parameters
    /// ----------
    /// count : int
    ///     Number of steps.
    ///
    /// Raises
    /// ------
    /// SimulationError
    ///     A step fails; the simulation stays at the state before it.
    #[pyo3(signature = (count=1))]
    fn step(&mut self, py: Python<'_>, count: usize) -> PyResult<()> {
        for done in 0..count {
            self.stepped.step().map_err(|error| failed_step(py, &error))?;
            if done % 64 == 63 {
                py.check_signals()?;
            }
        }
        Ok(())
    }

    /// Steps for a time.
    ///
    /// Parameters
    /// ----------
    /// duration : float
    ///     Time [s], rounded to whole steps.
    ///
    /// Raises
    /// ------
    /// SimulationError
    ///     `duration` is invalid, or a step fails.
    fn run_for(&mut self, py: Python<'_>, duration: f64) -> PyResult<()> {
        let steps = self.stepped.steps_in(duration).map_err(exception_of::<SimulationError>)?;
        self.step(py, steps)
    }

    /// Saves all that changes, for `restore`.
    ///
    /// Returns
    /// -------
    /// Snapshot
    ///     State, inputs and energy account.
    fn snapshot(&self) -> Snapshot {
        Snapshot(self.stepped.snapshot(), self.wrenches.clone())
    }

    /// Restores a snapshot exactly.
    ///
    /// Parameters
    /// ----------
    /// snapshot : Snapshot
    ///     Snapshot of this simulation or of a copy of it.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     The snapshot is of another simulation.
    fn restore(&mut self, snapshot: &Snapshot) -> PyResult<()> {
        if !self.stepped.fits(&snapshot.0) {
            return Err(PyValueError::new_err("the snapshot is of another simulation"));
        }
        self.stepped.restore(&snapshot.0);
        self.wrenches.clone_from(&snapshot.1);
        Ok(())
    }

    /// See `contacts`.
    fn _contacts<'py>(&self, py: Python<'py>) -> PyResult<Vec<ContactFields<'py>>> {
        let fields = |contact: robot_dynamics::contact::ContactPoint<'_>| {
            Ok((
                contact.link.to_owned(),
                contact.shape.to_owned(),
                contact.other_link.map(str::to_owned),
                contact.other_shape.to_owned(),
                contact.ground,
                array(py, &contact.point)?,
                array(py, &contact.normal)?,
                contact.gap,
                array(py, &contact.force)?,
                array(py, &contact.moment)?,
            ))
        };
        self.stepped.contacts().into_iter().map(fields).collect()
    }

    /// The point about which the normal forces of the grounds have no moment (3,) [m]; `None` if nothing
    /// presses on a ground.
    #[getter]
    fn center_of_pressure<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.stepped.center_of_pressure().map(|point| array(py, &point)).transpose()
    }

    /// The multiplier of each row of the equalities by its name, the mean over the last step [N or N·m].
    #[getter]
    fn constraint_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let forces = PyDict::new(py);
        for (name, force) in self.stepped.constraint_forces() {
            forces.set_item(name, force)?;
        }
        Ok(forces)
    }

    /// The force [N] and moment [N·m] that each joint transmits to its child, by its name, fixed joints
    /// included. Each is (6,) along the axes of the child's frame and about its origin, as a force-torque
    /// sensor there reads. Forces of equalities are not counted.
    #[getter]
    fn joint_reactions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let reactions = PyDict::new(py);
        for (joint, numbers) in self.robot.get().model.joints().iter().zip(self.stepped.joint_reactions()) {
            reactions.set_item(&joint.name, array(py, &numbers)?)?;
        }
        Ok(reactions)
    }

    /// The values of the robot's sensors by name, at the end of the last step.
    #[getter]
    fn sensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let sensors = PyDict::new(py);
        for (name, values) in self.stepped.sensors() {
            sensors.set_item(name, array(py, &values)?)?;
        }
        Ok(sensors)
    }

    /// See `energy_account`.
    fn _energy_account<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        energy_account_of(py, self.stepped.energy_account())
    }

    /// The energy [J] that damping, friction, stops, sliding and impacts took; `None` if the method does not
    /// separate them.
    #[getter]
    fn losses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        losses_of(py, self.stepped.losses())
    }
}
