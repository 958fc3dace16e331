//! Motions of one robot in time: free and constrained, under torques from arrays or from Python.

mod adaptive;
mod books;
pub(crate) mod method;
mod torques;

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use robot_dynamics::{
    AdaptiveSimulation, CallbackError, ConstrainedSimulation, ControllerError, DriftCorrection, Event,
    LinearizeStepWorkspace, Model, Moment, Run, Simulation, StepForces, StepWorkspace, Stepper,
    linearize_by_differences, linearize_step, step,
};

use self::books::{ledger_of, losses_of, statistics_of};
use self::method::{GroundFields, Method};
use self::torques::Torques;
use crate::constraints::{Constraints, options_of};
use crate::errors::Class;
use crate::interrupts::interruptible;
use crate::numbers::{self, array, configuration, object, record, vector, vector_or_zeros};
use crate::outcome;
use crate::robot::Robot;

/// How often a run looks for an interrupt.
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

/// Ends a run when Python has a signal for it.
struct Watch {
    last: Instant,
    steps: u32,
    signal: Option<PyErr>,
}

impl Watch {
    fn look(&mut self) -> ControlFlow<()> {
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

/// A run's numbers.
fn recorded<'py>(py: Python<'py>, robot: &Robot, run: &Run) -> PyResult<Bound<'py, PyDict>> {
    let (nq, nv, rows) = (robot.model.nq(), robot.model.nv(), run.trajectory.len());
    let column = |pick: fn(robot_dynamics::Sample<'_>) -> f64| {
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
            ("ledger", ledger_of(py, &run.ledger)?.into_any()),
            ("peak_torque", array(py, &run.peak_torque)?),
            ("losses", losses_of(py, run.losses)?),
            ("events", events.into_any()),
            ("steps", object(py, run.steps)?),
            ("ended_by_event", object(py, run.ended_by_event)?),
        ],
    )
}

/// The ground's forces, by samples and links.
fn contact_forces<'py>(py: Python<'py>, run: &Run, links: usize) -> PyResult<Bound<'py, PyAny>> {
    let forces: Vec<f64> =
        run.trajectory.iter().flat_map(|sample| sample.contact_forces.as_flattened().to_vec()).collect();
    outcome::filled(py, &[run.trajectory.len(), links, 3], &forces)
}

/// The exception of a run that failed: with the run until then, and what Python itself had raised.
fn failed<'py>(
    py: Python<'py>,
    error: &(dyn std::error::Error + 'static),
    until: Bound<'py, PyDict>,
) -> PyErr {
    let raised = Class::Simulation.error_with(py, error, &[("until", until.into_any())]);
    let mut cause = Some(error);
    while let Some(error) = cause {
        let callback = match error.downcast_ref() {
            Some(ControllerError::Callback(callback)) => Some(callback),
            _ => error.downcast_ref::<CallbackError>(),
        };
        let own = callback.and_then(CallbackError::downcast_ref::<PyErr>);
        if let Some(own) = own {
            // An interrupt is no error of the motion.
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
    #[pyo3(signature = (q, v, tau, *, duration, step, integrator, dissipation, sample_every, events, stop_at_limits,
                        constraints, stabilization, correction, stops, controls, ground, tolerance, control_period))]
    fn _simulate<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        tau: Option<&Bound<'py, PyAny>>,
        duration: f64,
        step: f64,
        integrator: &str,
        dissipation: bool,
        sample_every: usize,
        events: Vec<EventFields>,
        stop_at_limits: bool,
        constraints: Option<&Bound<'py, Constraints>>,
        stabilization: Option<f64>,
        correction: &str,
        stops: bool,
        controls: Option<HashMap<String, f64>>,
        ground: Option<GroundFields>,
        tolerance: Option<f64>,
        control_period: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let method =
            Method::of(py, self, integrator, stops, controls, ground, (tolerance, control_period), step)?;
        let (steps, correction) = (steps_of(py, duration, step)?, correction_of(correction)?);
        let (q, v) = (configuration(py, self, q)?, vector_or_zeros(py, self, "v", v)?);
        let mut torques = Torques::of(py, self, tau, steps, step)?;
        let has_callbacks = torques.is_called() || !events.is_empty();
        let mut watch = Watch { last: Instant::now(), steps: 0, signal: None };
        // Whoever calls Python at each step keeps the interpreter's lock.
        macro_rules! run {
            ($simulation:expr) => {{
                let simulation = $simulation.with_dissipation(dissipation).with_samples_every(sample_every);
                let mut run = |events: Vec<EventFields>| {
                    let events = &mut events_of(self, events, stop_at_limits);
                    let watch = |_: &Moment<'_>| watch.look();
                    simulation.run_with_events(&q, &v, steps, &mut torques, events, watch)
                };
                let outcome = if has_callbacks { run(events) } else { py.detach(|| run(Vec::new())) };
                if let Some(signal) = watch.signal {
                    return Err(signal);
                }
                match outcome {
                    Ok(run) => (run, None),
                    Err(failure) => (failure.until, Some(Box::<dyn std::error::Error>::from(failure.error))),
                }
            }};
        }
        // Implicit steps hold them as rows of their own problem.
        let (method, constraints) = match (method, constraints) {
            (Method::Implicit(implicit, links), Some(constraints)) => {
                let set = constraints.get().of(py, self)?;
                (Method::Implicit(Box::new(implicit.with_constraints(&self.model, set)), links), None)
            }
            others => others,
        };
        let (recorded, error) = match constraints {
            None => {
                let (mut links, mut statistics) = (Vec::new(), None);
                let (run, error) = match method {
                    Method::Row(row) => run!(Simulation::new(&self.model, row, step)),
                    Method::Implicit(implicit, touching) => {
                        links = touching;
                        run!(Simulation::new(&self.model, *implicit, step))
                    }
                    Method::Mujoco(stepper, touching) => {
                        links = touching;
                        run!(Simulation::new(&self.model, *stepper, step))
                    }
                    Method::Adaptive(adaptive) => {
                        let times = adaptive::times(steps, step, sample_every);
                        let simulation = adaptive.of(&self.model, dissipation, torques.period());
                        let mut run = |simulation: &AdaptiveSimulation<'_>, events: Vec<EventFields>| {
                            let events = &mut events_of(self, events, stop_at_limits);
                            let go_on = |_: &Moment<'_>| ControlFlow::Continue(());
                            simulation.run(&q, &v, times.iter().copied(), &mut torques, events, go_on)
                        };
                        let outcome = if has_callbacks {
                            // Python looks for signals where it is called.
                            run(&simulation, events)
                        } else {
                            interruptible(py, false, |cancelled| {
                                let interrupt = Some(cancelled);
                                run(&AdaptiveSimulation { interrupt, ..simulation }, Vec::new())
                            })?
                        };
                        let (run, error) = match outcome {
                            Ok(run) => (run, None),
                            Err(failure) => (failure.until, Some(Box::from(failure.error))),
                        };
                        statistics = Some(statistics_of(py, &run)?);
                        (Run::from(run), error)
                    }
                };
                let recorded = recorded(py, self, &run)?;
                recorded.set_item("statistics", statistics)?;
                if !links.is_empty() {
                    recorded.set_item("contact_forces", contact_forces(py, &run, links.len())?)?;
                    recorded.set_item("contact_links", PyTuple::new(py, links)?)?;
                }
                (recorded, error)
            }
            Some(constraints) => {
                let Method::Row(method) = method else {
                    return Err(PyValueError::new_err(format!(
                        "integrator={integrator:?} does not hold constraints; 'implicit' does, and the rows of the table, 'rk4' for one",
                    )));
                };
                let set = constraints.get().of(py, self)?;
                let (run, error) = run!(
                    ConstrainedSimulation::new(&self.model, set, step)
                        .with_options(options_of(method, stabilization))
                        .with_correction(correction)
                );
                let recorded = recorded(py, self, &run.motion)?;
                recorded.set_item("position_drift", run.record.drift.position)?;
                recorded.set_item("velocity_drift", run.record.drift.velocity)?;
                recorded.set_item("energy_removed", run.record.energy_removed)?;
                (recorded, error)
            }
        };
        match error {
            None => Ok(recorded),
            Some(error) => Err(failed(py, &*error, recorded)),
        }
    }

    /// See `step`.
    fn _step<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        step_size: f64,
        integrator: &str,
        dissipation: bool,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let method = numbers::integrator(py, integrator)?;
        let (mut q, mut v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let forces = StepForces::new(&tau, dissipation);
        step(&self.model, method, &mut StepWorkspace::new(&self.model), &forces, step_size, &mut q, &mut v)
            .map_err(|error| Class::Simulation.error(py, error))?;
        Ok((array(py, &q)?, array(py, &v)?))
    }

    /// See `linearize_step`.
    fn _linearize_step<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        step_size: f64,
        name: &str,
        dissipation: bool,
        stops: bool,
        controls: Option<HashMap<String, f64>>,
        ground: Option<GroundFields>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let method = Method::of(py, self, name, stops, controls, ground, (None, None), step_size)?;
        let (q, v) = (configuration(py, self, q)?, vector(py, self, "v", v)?);
        let tau = vector_or_zeros(py, self, "tau", tau)?;
        let nv = self.model.nv();
        let (mut by_state, mut by_force) = (vec![0.0; 4 * nv * nv], vec![0.0; 2 * nv * nv]);
        let (model, forces) = (&self.model, StepForces::new(&tau, dissipation));
        let slopes = (&mut by_state[..], &mut by_force[..]);
        match method {
            Method::Row(row) => {
                let (a, b) = slopes;
                let workspace = &mut LinearizeStepWorkspace::new(model);
                linearize_step(model, row, workspace, &forces, step_size, &q, &v, a, b)
                    .map_err(|error| Class::Simulation.error(py, error))
            }
            Method::Implicit(stepper, _) => {
                by_differences(py, model, *stepper, &forces, step_size, (&q, &v), slopes)
            }
            Method::Mujoco(stepper, _) => {
                by_differences(py, model, *stepper, &forces, step_size, (&q, &v), slopes)
            }
            Method::Adaptive(_) => {
                Err(PyValueError::new_err("integrator='adaptive' has no step of one length to linearise"))
            }
        }?;
        Ok((
            outcome::filled(py, &[2 * nv, 2 * nv], &by_state)?,
            outcome::filled(py, &[2 * nv, nv], &by_force)?,
        ))
    }
}

/// The slopes of a step, whose contacts are those that a step from there finds.
fn by_differences<S: Stepper + Clone>(
    py: Python<'_>,
    model: &Model,
    mut stepper: S,
    forces: &StepForces<'_>,
    h: f64,
    (q, v): (&[f64], &[f64]),
    (by_state, by_force): (&mut [f64], &mut [f64]),
) -> PyResult<()> {
    let workspace = &mut StepWorkspace::new(model);
    let refused = |error: S::Error| Class::Simulation.error(py, error);
    stepper.step(model, workspace, forces, h, &mut q.to_vec(), &mut v.to_vec()).map_err(refused)?;
    linearize_by_differences(model, &stepper, workspace, forces, h, q, v, by_state, by_force).map_err(refused)
}

/// What is projected after each step under constraints.
fn correction_of(word: &str) -> PyResult<DriftCorrection> {
    match word {
        "none" => Ok(DriftCorrection::None),
        "velocity" => Ok(DriftCorrection::Velocity),
        "position" => Ok(DriftCorrection::Position { tolerance: 1e-12 }),
        _ => Err(PyValueError::new_err(format!(
            "correction = {word:?} must be \"none\", \"velocity\" or \"position\""
        ))),
    }
}

/// How many steps a time takes.
fn steps_of(py: Python<'_>, duration: f64, step: f64) -> PyResult<usize> {
    let steps = (duration / step).round();
    if step > 0.0 && duration >= 0.0 && (0.0..1e12).contains(&steps) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // looked at above
        return Ok(steps as usize);
    }
    Err(Class::Simulation.error(
        py,
        format!("duration = {duration} s and step = {step} s: both must be finite, the step positive"),
    ))
}
