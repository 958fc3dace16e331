//! Gradients through time: the pullback of rollouts, of one state and of many.

mod by_stepper;

use std::collections::HashMap;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_dynamics::batch::{self, Rollout, RolloutError, Torques};
use robot_dynamics::derivatives::{
    LinearizedSteps, MotionCotangents, RobotState, RolloutPullbackWorkspace, TrajectoryCotangents,
    parameter_count, rollout_pullback,
};
use robot_dynamics::simulation::{Effect, Integrator, Method, SimulationStepper, StepError};

use crate::errors::{Class, exception};
use crate::ffi::{self, Array, Kind};
use crate::interrupts::{FEW_STEPS, interruptible, until};
use crate::number::Number;
use crate::operand::{ArrayArgument, common_kind, given};
use crate::results::MOST_RESULTS;
use crate::robot::Robot;
use crate::rollout::{NOT_FINITE, describe_bad, threads_for};
use crate::row::{Operand, Width};
use crate::simulation::options::Setup;
use crate::simulation::set_controls;
use crate::{numbers, outcome, threads};

/// Gradients by the initial q and v, and by τ and the parameters if they are asked for.
type Gradients<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Option<Bound<'py, PyAny>>, Option<Bound<'py, PyAny>>);

/// The numbers of steps with analytic derivatives, of those of them at a transition, and of steps with
/// differences, and the reason for the first differences.
type StepCounts = (usize, usize, usize, Option<&'static str>);

#[pymethods]
impl Robot {
    /// See `rollout_pullback`. All arrays have the leading dimensions of the batch.
    #[pyo3(signature = (q, v, tau, by_position, by_velocity, trajectory, *, each_step, steps, stride, spacing, parameters,
                        threads, controls, **options))]
    fn _rollout_pullback<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tau: Option<&Bound<'py, PyAny>>,
        by_position: &Bound<'py, PyAny>,
        by_velocity: &Bound<'py, PyAny>,
        trajectory: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
        each_step: bool,
        steps: usize,
        stride: usize,
        spacing: usize,
        parameters: bool,
        threads: Option<&Bound<'py, PyAny>>,
        controls: Option<HashMap<String, f64>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<(Gradients<'py>, Option<StepCounts>)> {
        let (motion, step, dissipates) = self.differentiable_motion(py, controls, options)?;
        let how = Steps { step, steps, dissipates, stride };
        let array = |name, width, object: &Bound<'py, PyAny>| {
            given(py, &self.model, &Operand { name, width }, 0, object, None)
        };
        let mut all = vec![
            array("q", Width::Nq, q)?,
            array("v", Width::Nv, v)?,
            array("by_position", Width::Nv, by_position)?,
            array("by_velocity", Width::Nv, by_velocity)?,
        ];
        for (name, object) in [
            ("tau", tau),
            ("by_position of the trajectory", trajectory.as_ref().map(|(by_position, _)| by_position)),
            ("by_velocity of the trajectory", trajectory.as_ref().map(|(_, by_velocity)| by_velocity)),
        ] {
            if let Some(object) = object {
                all.push(array(name, Width::Nv, object)?);
            }
        }
        let call = RolloutPullbackRequest {
            py,
            robot: self,
            motion,
            how,
            each_step,
            has_tau: tau.is_some(),
            spacing,
            parameters,
            threads: threads::count_of(threads)?,
        };
        match (&call.motion, common_kind(py, &all)? == Kind::F32) {
            (Motion::Row(row), true) => call.run_row::<f32>(*row, &all).map(|gradients| (gradients, None)),
            (Motion::Row(row), false) => call.run_row::<f64>(*row, &all).map(|gradients| (gradients, None)),
            (Motion::Steps(_), true) => {
                Err(PyTypeError::new_err("this motion is computed in float64; give it q.astype(float)"))
            }
            (Motion::Steps(_), false) if parameters => Err(PyValueError::new_err(
                "gradients by parameters need an explicit integrator, \"rk4\" for one",
            )),
            (Motion::Steps(stepper), false) => {
                let mut counts = LinearizedSteps::default();
                let gradients = call.run::<f64>(&all, |numbers, states| {
                    let (bad, own) = call.by_stepper(stepper, states, numbers)?;
                    counts = own;
                    Ok(bad)
                })?;
                let LinearizedSteps { analytic, at_transition, differences, reason, .. } = counts;
                Ok((gradients, Some((analytic, at_transition, differences, reason))))
            }
        }
    }

    /// The explicit method of a simulation with these options whose gradients are known, and whether damping
    /// and friction act.
    #[pyo3(signature = (**options))]
    fn _differentiable_row(
        &self,
        py: Python<'_>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<(&'static str, bool)> {
        let (row, _, dissipates) = self.differentiable_row(py, options)?;
        if row.is_explicit() {
            return Ok((row.name(), dissipates));
        }
        Err(exception(RolloutError::Implicit { integrator: row }))
    }
}

impl Robot {
    /// The steps of a simulation with these options whose gradients are known, the step \[s\], and whether
    /// damping and friction act.
    fn differentiable_motion(
        &self,
        py: Python<'_>,
        controls: Option<HashMap<String, f64>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<(Motion, f64, bool)> {
        let setup = Setup::of(options)?;
        if !setup.has_linearized_steps() {
            if controls.is_some_and(|controls| !controls.is_empty()) {
                return Err(PyValueError::new_err("controls need integrator=\"implicit\" or \"mujoco\""));
            }
            let (row, step, dissipates) = self.differentiable_row(py, options)?;
            return Ok((Motion::Row(row), step, dissipates));
        }
        setup.with_prepared(py, self, |simulation| {
            set_controls(self, simulation, controls)?;
            let stepper = Box::new(simulation.stepper());
            Ok((Motion::Steps(stepper), simulation.dt(), simulation.dissipates()))
        })
    }

    /// The same with the step [s]. The error names the effects that act and have no gradients.
    fn differentiable_row(
        &self,
        py: Python<'_>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<(Integrator, f64, bool)> {
        let simulation = Setup::of(options)?.without_contacts().build(py, self)?;
        if let Some(row) = simulation.stepper().row() {
            return Ok((row, simulation.dt(), simulation.dissipates()));
        }
        let (name, method) = (self.model.name(), simulation.method());
        let text = match method {
            Method::Fixed(_) => {
                let acts = |effect: &&Effect| simulation.acting().contains(effect);
                let mut unknown: Vec<&str> = [Effect::Springs, Effect::Actuators, Effect::Equalities]
                    .iter()
                    .filter(acts)
                    .map(|effect| effect.name())
                    .collect();
                if unknown.is_empty() {
                    unknown.push(Effect::Dissipation.name());
                }
                format!(
                    "the gradients of {} of robot `{name}` are not known; without={unknown:?} leaves them out",
                    unknown.join(", ")
                )
            }
            _ => format!(
                "the gradients of `{method}` steps are not known; give an explicit integrator, \"rk4\" for one"
            ),
        };
        Err(PyValueError::new_err(text))
    }
}

/// The steps of a motion.
enum Motion {
    /// A row of the table of integrators.
    Row(Integrator),
    /// Steps with contact, stops and friction.
    Steps(Box<SimulationStepper>),
}

#[derive(Clone, Copy)]
struct Steps {
    step: f64,
    steps: usize,
    dissipates: bool,
    stride: usize,
}

struct RolloutPullbackRequest<'a, 'py> {
    py: Python<'py>,
    robot: &'a Robot,
    motion: Motion,
    how: Steps,
    each_step: bool,
    has_tau: bool,
    spacing: usize,
    parameters: bool,
    threads: Option<usize>,
}

/// The numbers that a rollout's pullback reads and writes.
struct PullbackTables<'a, T> {
    q: &'a [T],
    v: &'a [T],
    tau: &'a [T],
    trajectory: (&'a [T], &'a [T]),
    by_position: &'a mut [T],
    by_velocity: &'a mut [T],
    by_force: &'a mut [T],
    by_parameters: &'a mut [T],
}

fn header<'a>(array: Option<&'a Bound<'_, PyAny>>) -> Array<'a> {
    array.and_then(Array::of).unwrap_or(Array::NONE)
}

impl<'py> RolloutPullbackRequest<'_, 'py> {
    /// Computes by a row of the table of integrators.
    fn run_row<T: Number>(&self, row: Integrator, all: &[ArrayArgument<'py>]) -> PyResult<Gradients<'py>> {
        let Steps { step, steps, dissipates, stride } = self.how;
        let how = &Rollout::new(row, step, steps).with_dissipation(dissipates).with_stride(stride);
        self.run::<T>(all, |numbers, states| match states {
            None => self.one(how, numbers).map(|()| Vec::new()),
            Some(states) => self.many(how, states, numbers),
        })
    }

    /// Calls `pull` with the numbers, and with the number of states unless there is a single one. It returns
    /// the states without a valid gradient. The arrays are q, v, the cotangents of the end, then τ and the
    /// trajectory's cotangents if there are any.
    fn run<T: Number>(
        &self,
        all: &[ArrayArgument<'py>],
        pull: impl FnOnce(PullbackTables<'_, T>, Option<usize>) -> PyResult<Vec<usize>>,
    ) -> PyResult<Gradients<'py>> {
        let Self { py, robot, has_tau, .. } = *self;
        let lead = all[0].lead();
        // They are changed in place, so the arguments are copied.
        let copy = |given: &ArrayArgument<'py>| given.array.call_method1("copy", ("C",));
        let (by_position, by_velocity) = (copy(&all[2])?, copy(&all[3])?);
        let tau = has_tau.then(|| &all[4]);
        let by_force = tau.map(|tau| outcome::new::<T>(py, &tau.shape));
        let row = [lead, &[parameter_count(&robot.model)]].concat();
        let by_parameters = self.parameters.then(|| outcome::new::<T>(py, &row));
        let none = Array::NONE;
        let read = |k: usize| header(all.get(k).map(|given| &given.array));
        let first_of_trajectory = 4 + usize::from(has_tau);
        // Two calls, as one reads at most five arrays. The written arrays are new, so they overlap nothing.
        let first = ffi::slices::<T>(
            &[read(0), read(1), header(tau.map(|tau| &tau.array)), none, none],
            &[Some(&by_position), Some(&by_velocity), by_force.as_ref(), by_parameters.as_ref()].map(header),
        );
        let second = ffi::slices::<T>(
            &[read(first_of_trajectory), read(first_of_trajectory + 1), none, none, none],
            &[none; MOST_RESULTS],
        );
        let (Some((x, moved)), Some((y, _))) = (first, second) else {
            return Err(Class::Shape.error(py, "the arrays cannot be read where they lie"));
        };
        let [by_q, by_v, by_tau, parameters] = moved;
        let numbers = PullbackTables {
            q: x[0],
            v: x[1],
            tau: x[2],
            trajectory: (y[0], y[1]),
            by_position: by_q,
            by_velocity: by_v,
            by_force: by_tau,
            by_parameters: parameters,
        };
        let bad = pull(numbers, (!lead.is_empty()).then(|| lead.iter().product()))?;
        let results = (by_position, by_velocity, by_force, by_parameters);
        if bad.is_empty() {
            return Ok(results);
        }
        Err(outcome::bad_states(
            py,
            &bad,
            describe_bad(&bad, lead, NOT_FINITE),
            numbers::object(py, results)?,
        )?)
    }

    /// Computes one state, in float64.
    fn one<T: Number>(&self, how: &Rollout, numbers: PullbackTables<'_, T>) -> PyResult<()> {
        let double = |x: &[T]| x.iter().map(|x| x.double()).collect::<Vec<f64>>();
        let model = &self.robot.model;
        let PullbackTables { q, v, tau, trajectory, by_position, by_velocity, by_force, by_parameters } =
            numbers;
        let (q, v, tau) = (double(q), double(v), double(tau));
        let trajectory = (double(trajectory.0), double(trajectory.1));
        let mut results = [&*by_position, &*by_velocity, &*by_force, &*by_parameters].map(double);
        let [by_q, by_v, by_tau, parameters] = &mut results;
        let workspace = &mut RolloutPullbackWorkspace::new(model, how, self.spacing);
        let cotangents =
            MotionCotangents { by_position: by_q, by_velocity: by_v, by_force: by_tau, parameters };
        let computed = rollout_pullback(
            model,
            how,
            workspace,
            RobotState { q: &q, v: &v },
            &tau,
            TrajectoryCotangents { by_position: &trajectory.0, by_velocity: &trajectory.1 },
            cotangents,
        );
        computed.map_err(|error| match error {
            StepError::SingularMass(error) => exception(error),
            error => exception(error),
        })?;
        for (numbers, computed) in
            [by_position, by_velocity, by_force, by_parameters].into_iter().zip(&results)
        {
            for (number, computed) in numbers.iter_mut().zip(computed) {
                *number = T::of(*computed);
            }
        }
        Ok(())
    }

    /// Computes many states. Returns those without a valid gradient; their rows are NaN.
    fn many<T: Number>(
        &self,
        how: &Rollout,
        states: usize,
        numbers: PullbackTables<'_, T>,
    ) -> PyResult<Vec<usize>> {
        let PullbackTables { q, v, tau, trajectory, by_position, by_velocity, by_force, by_parameters } =
            numbers;
        let torques = self.torques(tau);
        let work = states * self.how.steps;
        let threads = self.threads.unwrap_or_else(|| threads_for(work));
        let (model, spacing) = (&self.robot.model, self.spacing);
        let mut memory = T::batches(self.robot).take(model, threads)?;
        let workspace = &mut memory.workspace;
        let outcome = interruptible(self.py, work <= FEW_STEPS, |cancelled| {
            let inputs = batch::RolloutPullbackInputs {
                spacing,
                torques,
                q,
                v,
                trajectory: batch::TrajectoryCotangents {
                    by_position: trajectory.0,
                    by_velocity: trajectory.1,
                },
            };
            let cotangents =
                batch::MotionCotangents { by_position, by_velocity, by_force, parameters: by_parameters };
            batch::rollout_pullback(model, workspace, how, &inputs, cotangents, Some(&until(cancelled)))
        });
        T::batches(self.robot).give(memory);
        match outcome? {
            Ok(()) => Ok(Vec::new()),
            Err(RolloutError::BadStates(bad)) => Ok(bad.states),
            Err(error) => Err(exception(error)),
        }
    }

    fn torques<'a, T>(&self, tau: &'a [T]) -> Torques<'a, T> {
        match (self.has_tau, self.each_step) {
            (false, _) => Torques::Zero,
            (true, true) => Torques::EachStep(tau),
            (true, false) => Torques::Held(tau),
        }
    }
}
