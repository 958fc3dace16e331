//! One run, by fixed or by adaptive steps.

use std::ops::ControlFlow;

use robot_dynamics::algorithms::SingularMass;
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{
    AdaptiveRecord, Controller, Event, Method, Run, RunError, RunOptions, StepError, StepInfo,
};

use super::arguments::Arguments;
use super::drive::ActuatorControls;
use super::setup::Setup;
use super::start::Start;
use crate::singular_poses::advice;
use crate::table::short;

/// A run, complete or not.
pub(crate) struct RunResult {
    pub run: Run,
    /// The record of adaptive steps.
    pub adaptive: Option<AdaptiveRecord>,
    /// The cause of a failure, in one line.
    pub failure: Option<String>,
}

/// Runs `steps` steps, or adaptive steps to the same end, with an optional controller.
pub(crate) fn run(
    arguments: &Arguments,
    model: &Model,
    start: &Start,
    (setup, drive): (&mut Setup, Option<&ActuatorControls>),
    steps: usize,
    controller: Option<&mut dyn Controller>,
    mut observer: impl FnMut(&StepInfo<'_>) -> ControlFlow<()>,
) -> RunResult {
    let simulation = &mut setup.simulation;
    let mut limits = stops(arguments, model);
    let mut options = RunOptions::new().sample_ends().events(&mut limits).observer(&mut observer);
    // Shortens the lifetime to that of this call.
    options.controller = controller.map(|controller| controller as &mut dyn Controller);
    let (run, failure) = match simulation.reset(&start.q, &start.v) {
        Ok(()) => {
            if let Some(drive) = drive {
                simulation.set_controls(&drive.controls);
            }
            match simulation.run_steps(steps, options) {
                Ok(run) => (run, None),
                Err(failure) => (failure.until, Some(failure_message(model, &failure.error, arguments.dt))),
            }
        }
        Err(error) => (simulation.record().clone(), Some(failure_message(model, &error, arguments.dt))),
    };
    RunResult { run, adaptive: simulation.adaptive_record().copied(), failure }
}

/// The joints' position limits as events: terminal if requested, and otherwise recorded by adaptive steps
/// only.
fn stops<'a>(arguments: &Arguments, model: &Model) -> Vec<Event<'a>> {
    if arguments.stop_at_limits {
        Event::joint_limits(model).into_iter().map(Event::terminal).collect()
    } else if arguments.integrator == Some(Method::Adaptive) {
        Event::joint_limits(model)
    } else {
        Vec::new()
    }
}

/// The cause of an early end, with the option to change.
fn failure_message(model: &Model, error: &RunError, h: f64) -> String {
    match error {
        RunError::NotFinite { quantity, coordinate, step, .. } => format!(
            "the motion diverged at t = {} s (step {step}): {quantity} is not finite at `{coordinate}`; use a smaller \
             --dt than {h} s",
            short(*step as f64 * h)
        ),
        RunError::Diverged { coordinate, speed, step, time, suggested_step, cause, .. } => format!(
            "the motion diverged: `{coordinate}` has v = {speed:.1e} at t = {} s (step {step}); try --dt {suggested_step:.1e}, \
             {cause}",
            short(*time)
        ),
        RunError::SingularMass { time, source, .. } => singular(model, source, *time),
        RunError::Step { step, time, source, .. } => step_message(source, *step, *time),
        other => other.to_string(),
    }
}

/// The cause of a failed step, with the options to change.
fn step_message(error: &StepError, step: usize, time: f64) -> String {
    let instead = "use a larger --tolerance, or --integrator rk4 with fixed steps";
    match error {
        StepError::TooManySteps { steps, step, coordinate } => format!(
            "stopped at t = {} s after {steps} steps since the previous sample: `{coordinate}` needs steps of \
             {step:.1e} s, as a stiff or very light joint does (check its inertia, damping and torque); {instead}",
            short(time)
        ),
        StepError::StepTooSmall { step, coordinate } => format!(
            "stopped at t = {} s: the tolerance needs steps below {step:.1e} s, mainly because of `{coordinate}`; the forces \
             are not smooth there, or the tolerance is below rounding; {instead}",
            short(time)
        ),
        grown @ StepError::Diverged { .. } => format!("t = {} s: {grown}", short(time)),
        other => format!("step failed at t = {} s (step {step}): {other}", short(time)),
    }
}

fn singular(model: &Model, mass: &SingularMass, time: f64) -> String {
    format!("step failed at t = {} s: {}", short(time), advice(mass, model))
}
