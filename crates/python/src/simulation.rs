//! Motions of one robot in time: free and constrained, under torques from arrays or from Python.

pub(crate) mod batch;
mod batch_measurements;
mod batch_variants;
mod contact_fields;
mod energy_account;
mod ground;
pub(crate) mod options;
pub(crate) mod setup;
pub(crate) mod stepping;
pub(crate) mod torques;

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use robot_dynamics::simulation::{
    CallbackError, ControllerError, Event, Run, RunError, RunOptions, SampleInterval, Simulation,
    SimulationError, StepInfo, steps_in,
};

use self::energy_account::{energy_account_of, losses_of, statistics_of};
use self::options::Setup;
use self::setup::controls_of;
use self::torques::Torques;
use crate::errors::{Class, exception, exception_of};
use crate::interrupts::interruptible_by;
use crate::numbers::{array, configuration, object, record, vector, vector_or_zeros};
use crate::outcome;
use crate::robot::Robot;

/// How often a run checks for an interrupt.
const PATIENCE: Duration = Duration::from_millis(100);

/// Events as the Python half describes them: name, function of (t, q, v), direction, whether it ends the run.
type EventFields = (String, Py<PyAny>, i8, bool);

fn events_of(robot: &Robot, given: Vec<EventFields>, stop_at_limits: bool) -> Vec<Event<'_>> {
    let own = given.into_iter().map(|(name, function, direction, is_terminal)| {
        let event = Event::new(name, move |t: f64, q: &[f64], v: &[f64]| {
            Python::attach(|py| function.bind(py).call1((t, array(py, q)?, array(py, v)?))?.extract::<f64>())
        });
        let event = match direction {
            1 => event.rising(),
            -1 => event.falling(),
            _ => event,
        };
        if is_terminal { event.terminal() } else { event }
    });
    let mut events: Vec<_> = own.collect();
    if stop_at_limits {
        events.extend(Event::joint_limits(&robot.model).into_iter().map(Event::terminal));
    }
    events
}

/// The time between samples \[s\], or `ends`.
#[derive(FromPyObject)]
enum SamplePeriod {
    Seconds(f64),
    Word(String),
}

fn sample_interval(period: Option<SamplePeriod>) -> PyResult<SampleInterval> {
    match period {
        None => Ok(SampleInterval::default()),
        Some(SamplePeriod::Seconds(seconds)) => Ok(SampleInterval::Seconds(seconds)),
        Some(SamplePeriod::Word(word)) if word == "ends" => Ok(SampleInterval::Ends),
        Some(SamplePeriod::Word(word)) => Err(PyValueError::new_err(format!(
            "sample_period = {word:?} must be a time in seconds, None or \"ends\""
        ))),
    }
}

/// Ends a run when Python has a signal to handle.
struct SignalCheck {
    last: Instant,
    steps: u32,
    signal: Option<PyErr>,
}

impl SignalCheck {
    fn check(&mut self) -> ControlFlow<()> {
        self.steps = self.steps.wrapping_add(1);
        if !self.steps.is_multiple_of(16) || self.last.elapsed() < PATIENCE {
            return ControlFlow::Continue(());
        }
        self.last = Instant::now();
        #[allow(clippy::redundant_closure_for_method_calls)]
        // the method has one lifetime, `attach` asks for any
        match Python::attach(|py| py.check_signals()) {
            Ok(()) => ControlFlow::Continue(()),
            Err(signal) => {
                self.signal = Some(signal);
                ControlFlow::Break(())
            }
        }
    }
}

/// The arguments of a run.
struct RunPlan<'a> {
    robot: &'a Robot,
    steps: usize,
    samples: SampleInterval,
    /// Number of steps between samples; 0 keeps the first and the last state.
    stride: usize,
    events: Vec<EventFields>,
    stop_at_limits: bool,
    is_adaptive: bool,
    /// Ends adaptive steps when it is set.
    flag: Arc<AtomicBool>,
}

/// A run, which may have ended with an error.
struct Recording {
    run: Run,
    error: Option<RunError>,
    /// The forces of the actuators at each sample.
    actuator_forces: Vec<f64>,
}

impl RunPlan<'_> {
    /// Runs the simulation. An interrupt ends it with its exception.
    fn run(
        self,
        py: Python<'_>,
        simulation: &mut Simulation,
        torques: &mut Torques<'_>,
    ) -> PyResult<Recording> {
        let has_callbacks = torques.is_called() || !self.events.is_empty();
        let (is_adaptive, flag) = (self.is_adaptive, Arc::clone(&self.flag));
        let mut watch = SignalCheck { last: Instant::now(), steps: 0, signal: None };
        let run = || self.run_watched(simulation, torques, &mut watch);
        // A run that calls Python at each step keeps the interpreter's lock.
        let recording = if has_callbacks {
            run()
        } else if is_adaptive {
            interruptible_by(py, &flag, run)?
        } else {
            py.detach(run)
        };
        watch.signal.map_or(Ok(recording), Err)
    }

    fn run_watched(
        self,
        simulation: &mut Simulation,
        torques: &mut Torques<'_>,
        watch: &mut SignalCheck,
    ) -> Recording {
        let Self { robot, steps, stride, .. } = self;
        let events = &mut events_of(robot, self.events, self.stop_at_limits);
        let mut actuator_forces = Vec::new();
        let mut observer = |info: &StepInfo<'_>| {
            let is_kept = info.step == steps || (stride > 0 && info.step.is_multiple_of(stride));
            if is_kept || info.step == 0 {
                actuator_forces.extend_from_slice(info.actuator_forces);
            }
            watch.check()
        };
        let mut options = RunOptions::new().controller(torques).events(events);
        options.samples = self.samples;
        // Adaptive steps check the flag. They evaluate only the samples that are kept, unless forces of
        // actuators are kept too.
        let is_observed = !self.is_adaptive || simulation.control_names().next().is_some();
        let options = if is_observed { options.observer(&mut observer) } else { options };
        let (run, error) = match simulation.run_steps(steps, options) {
            Ok(run) => (run, None),
            Err(failure) => (failure.until, Some(failure.error)),
        };
        Recording { run, error, actuator_forces }
    }
}

/// A run's numbers.
fn recorded<'py>(py: Python<'py>, robot: &Robot, run: &Run) -> PyResult<Bound<'py, PyDict>> {
    let (nq, nv, rows) = (robot.model.nq(), robot.model.nv(), run.trajectory.len());
    let column = |pick: fn(robot_dynamics::simulation::Sample<'_>) -> f64| {
        array(py, &run.trajectory.iter().map(pick).collect::<Vec<_>>())
    };
    let mut tables = [const { Vec::new() }; 3];
    for sample in run.trajectory.iter() {
        tables[0].extend_from_slice(sample.q);
        tables[1].extend_from_slice(sample.v);
        tables[2].extend_from_slice(sample.tau);
    }
    let events = PyList::empty(py);
    for event in &run.events {
        events.append((&event.name, event.time, event.rising, array(py, &event.q)?, array(py, &event.v)?))?;
    }
    record(
        py,
        [
            ("times", column(|sample| sample.time)?),
            ("q", outcome::filled(py, &[rows, nq], &tables[0])?),
            ("v", outcome::filled(py, &[rows, nv], &tables[1])?),
            ("tau", outcome::filled(py, &[rows, nv], &tables[2])?),
            ("kinetic", column(|sample| sample.kinetic)?),
            ("potential", column(|sample| sample.potential)?),
            ("energy_account", energy_account_of(py, &run.energy_account)?.into_any()),
            ("peak_torque", array(py, &run.peak_torque)?),
            ("losses", losses_of(py, run.losses)?),
            ("events", events.into_any()),
            ("steps", object(py, run.steps)?),
            ("ended_by_event", object(py, run.ended_by_event)?),
        ],
    )
}

/// Adds the simulation's own results: method, left-out features, limits, adaptive steps and constraints.
fn record_simulation(py: Python<'_>, record: &Bound<'_, PyDict>, simulation: &Simulation) -> PyResult<()> {
    record.set_item("method", simulation.method().name())?;
    record.set_item("left_out", PyTuple::new(py, simulation.left_out())?)?;
    record.set_item("steps_at_effort_limits", array_of_counts(py, simulation.steps_at_effort_limits())?)?;
    if let Some(adaptive) = simulation.adaptive_record() {
        record.set_item("statistics", statistics_of(py, adaptive)?)?;
        record.set_item("steps", adaptive.statistics.accepted)?;
    }
    if let Some(constraints) = simulation.constraint_record() {
        record.set_item("position_drift", constraints.drift.position)?;
        record.set_item("velocity_drift", constraints.drift.velocity)?;
        record.set_item("energy_removed", constraints.energy_removed)?;
    }
    Ok(())
}

/// Adds the forces of the actuators that act, by samples and actuators.
fn record_actuators(
    py: Python<'_>,
    record: &Bound<'_, PyDict>,
    simulation: &Simulation,
    forces: &[f64],
) -> PyResult<()> {
    let names: Vec<&str> = simulation.control_names().collect();
    if names.is_empty() {
        return Ok(());
    }
    let shape = [forces.len() / names.len(), names.len()];
    record.set_item("actuator_forces", outcome::filled(py, &shape, forces)?)?;
    record.set_item("actuator_names", PyTuple::new(py, names)?)
}

/// Adds the forces of the ground, by samples and links.
fn record_contacts(
    py: Python<'_>,
    record: &Bound<'_, PyDict>,
    simulation: &Simulation,
    run: &Run,
) -> PyResult<()> {
    let links = simulation.ground_links();
    if links.is_empty() {
        return Ok(());
    }
    let forces: Vec<f64> =
        run.trajectory.iter().flat_map(|sample| sample.contact_forces.as_flattened().to_vec()).collect();
    let shape = [run.trajectory.len(), links.len(), 3];
    record.set_item("contact_forces", outcome::filled(py, &shape, &forces)?)?;
    record.set_item("contact_links", PyTuple::new(py, links)?)
}

/// The exception of a run that failed, with the run until then and the exception that Python itself had
/// raised.
fn failed<'py>(py: Python<'py>, error: &RunError, until: Bound<'py, PyDict>) -> PyErr {
    let raised = Class::of(error).error_with(py, error, &[("until", until.into_any())]);
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(error) = cause {
        let callback = match error.downcast_ref() {
            Some(ControllerError::Callback(callback)) => Some(callback),
            _ => error.downcast_ref::<CallbackError>(),
        };
        let own = callback.and_then(CallbackError::downcast_ref::<PyErr>);
        if let Some(own) = own {
            // An interrupt is not an error of the motion.
            if !own.is_instance_of::<PyException>(py) {
                return own.clone_ref(py);
            }
            raised.set_cause(py, Some(own.clone_ref(py)));
            break;
        }
        cause = error.source();
    }
    raised
}

#[pymethods]
impl Robot {
    /// See `simulate`.
    #[pyo3(signature = (q, v, tau, *, duration, sample_period, events, stop_at_limits, controls, **options))]
    fn _simulate<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        tau: Option<&Bound<'py, PyAny>>,
        duration: f64,
        sample_period: Option<SamplePeriod>,
        events: Vec<EventFields>,
        stop_at_limits: bool,
        controls: Option<HashMap<String, f64>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let setup = Setup::of(options)?;
        let (step, is_adaptive) = (setup.dt(), setup.is_adaptive());
        let steps = steps_of(duration, step)?;
        let samples = sample_interval(sample_period)?;
        let stride = samples.steps(step).map_err(exception_of::<SimulationError>)?;
        let mut torques = Torques::of(py, self, tau, steps, step)?;
        let flag = Arc::new(AtomicBool::new(false));
        let setup = setup.holding(torques.period()).interrupted_by(Arc::clone(&flag));
        let mut simulation = setup.build(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector_or_zeros(py, self, "v", v)?);
        simulation.reset(&q, &v).map_err(exception)?;
        set_controls(self, &mut simulation, controls)?;
        let plan = RunPlan { robot: self, steps, samples, stride, events, stop_at_limits, is_adaptive, flag };
        let Recording { run, error, actuator_forces } = plan.run(py, &mut simulation, &mut torques)?;
        let record = recorded(py, self, &run)?;
        record_simulation(py, &record, &simulation)?;
        record_actuators(py, &record, &simulation, &actuator_forces)?;
        record_contacts(py, &record, &simulation, &run)?;
        match error {
            None => Ok(record),
            Some(error) => Err(failed(py, &error, record)),
        }
    }

    /// The effort limits of all coordinates.
    fn _effort_limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let limits: Vec<f64> = self.model.coordinate_limits().iter().map(|limits| limits.effort).collect();
        array(py, &limits)
    }

    /// See `step`.
    #[pyo3(signature = (q, v, tau, controls, **options))]
    fn _step<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        controls: Option<HashMap<String, f64>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let mut simulation = Setup::of(options)?.refuse_adaptive(py)?.build(py, self)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        simulation.reset(&q, &v).map_err(exception)?;
        set_controls(self, &mut simulation, controls)?;
        simulation.set_torques(&tau);
        simulation.step().map_err(exception)?;
        Ok((array(py, simulation.q())?, array(py, simulation.v())?))
    }
}

/// Sets controls by the actuators' names, if some are given.
pub(crate) fn set_controls(
    robot: &Robot,
    simulation: &mut Simulation,
    controls: Option<HashMap<String, f64>>,
) -> PyResult<()> {
    if let Some(controls) = controls {
        let mut values = simulation.controls().to_vec();
        controls_of(robot, simulation, controls, &mut values)?;
        simulation.set_controls(&values);
    }
    Ok(())
}

/// Counts as an array.
fn array_of_counts<'py>(py: Python<'py>, counts: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    #[allow(clippy::cast_precision_loss)] // steps
    let counts: Vec<f64> = counts.iter().map(|count| *count as f64).collect();
    array(py, &counts)
}

/// How many steps a time takes.
fn steps_of(duration: f64, step: f64) -> PyResult<usize> {
    steps_in(duration, step).map_err(exception_of::<SimulationError>)
}
