//! Position control, wrenches and measurements of many simulations, as arrays.

use pyo3::prelude::*;
use robot_dynamics::simulation::{AppliedWrench, Simulation as Single, SimulationError};

use super::batch::{SimulationBatch, rows_of};
use crate::errors::{exception, exception_of};
use crate::outcome;
use crate::row::reference_frame_of;

#[pymethods]
impl SimulationBatch {
    /// The mean accelerations of the last step (count, nv) [rad/s² or m/s²].
    #[getter]
    fn acceleration<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robots[0].get().model.nv(), Single::acceleration)
    }

    /// The torques that acted in the last step, within the effort limits (count, nv) [N·m or N].
    #[getter]
    fn applied_torques<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.robots[0].get().model.nv(), Single::applied_torques)
    }

    /// The activations of the actuators of each simulation, and then the states of controllers and motors
    /// (count, activations); (activations,) sets those of all.
    #[setter]
    fn set_activations(&mut self, py: Python<'_>, activations: &Bound<'_, PyAny>) -> PyResult<()> {
        let width = self.activation_count();
        self.set_each(py, "activations", activations, width, Single::set_activations)
    }

    #[getter]
    fn activations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, self.activation_count(), Single::activations)
    }

    /// The targets of the position control (count, nv), held until they are set again; (nv,) sets those of
    /// all [rad or m]. See `set_position_control`.
    #[setter]
    fn set_targets(&mut self, py: Python<'_>, targets: &Bound<'_, PyAny>) -> PyResult<()> {
        let size = (self.count()?, self.robots[0].get().model.nv());
        let rows = rows_of(py, "targets", targets, size)?;
        self.stepped.position_control().set_targets(&rows);
        Ok(())
    }

    #[getter]
    fn targets<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let size = [self.count()?, self.robots[0].get().model.nv()];
        outcome::filled(py, &size, self.stepped.position_control().targets())
    }

    /// See `set_position_control`.
    fn _set_gains(
        &mut self,
        py: Python<'_>,
        stiffness: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        limits: &Bound<'_, PyAny>,
        delays: Vec<usize>,
    ) -> PyResult<()> {
        let size = (self.count()?, self.robots[0].get().model.nv());
        let table = |name: &str, object| rows_of(py, name, object, size);
        let (stiffness, damping) = (table("stiffness", stiffness)?, table("damping", damping)?);
        let limits = table("limits", limits)?;
        let control = self.stepped.position_control();
        control.set_gains(&stiffness, &damping, &limits).map_err(exception_of::<SimulationError>)?;
        control.set_delays(&delays);
        Ok(())
    }

    /// See `set_wrenches`.
    fn _set_wrenches(
        &mut self,
        py: Python<'_>,
        frames: Vec<String>,
        wrenches: &Bound<'_, PyAny>,
        axes: &str,
    ) -> PyResult<()> {
        let axes = reference_frame_of("axes", axes)?;
        let width = 6 * frames.len();
        let rows = rows_of(py, "wrenches", wrenches, (self.stepped.simulations().len(), width))?;
        for (simulation, row) in self.stepped.simulations_mut().iter_mut().zip(rows.chunks(width.max(1))) {
            let mut applied = Vec::with_capacity(frames.len());
            for (name, numbers) in frames.iter().zip(row.as_chunks::<6>().0) {
                let [fx, fy, fz, mx, my, mz] = *numbers;
                let frame = simulation.model().frame_named(name).map_err(exception)?;
                applied.push(AppliedWrench { frame, axes, force: [fx, fy, fz], moment: [mx, my, mz] });
            }
            simulation.set_wrenches(&applied);
        }
        Ok(())
    }

    /// See `contact_forces`.
    fn _contact_forces<'py>(&self, py: Python<'py>, names: Vec<String>) -> PyResult<Bound<'py, PyAny>> {
        let fill = |own: &Single, row: &mut [f64]| {
            for contact in own.contacts() {
                for (link, sign) in [(Some(contact.link), 1.0), (contact.other_link, -1.0)] {
                    let Some(k) = link.and_then(|link| names.iter().position(|name| name == link)) else {
                        continue;
                    };
                    row[3 * k..][..3].iter_mut().zip(contact.force).for_each(|(sum, f)| *sum += sign * f);
                }
            }
        };
        let forces = py.detach(|| self.stepped.table(3 * names.len(), fill));
        outcome::filled(py, &[self.stepped.simulations().len(), names.len(), 3], &forces)
    }

    /// See `sensors`.
    fn _sensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let first = self.stepped.simulations().first();
        let width = first.map_or(0, |own| own.sensors().iter().map(|(_, values)| values.len()).sum());
        let fill = |own: &Single, row: &mut [f64]| {
            let values = own.sensors().into_iter().flat_map(|(_, values)| values);
            row.iter_mut().zip(values).for_each(|(x, value)| *x = value);
        };
        let values = py.detach(|| self.stepped.table(width, fill));
        outcome::filled(py, &[self.stepped.simulations().len(), width], &values)
    }
}
