//! One run, by fixed or by adaptive steps.

use std::ops::ControlFlow;

use multibody::simulator::{Method, MethodError, RunOptions, StepFailure};
use multibody::{
    AdaptiveRecord, AdaptiveStepError, Controller, Event, Model, Run, RunError, SingularMass, StepInfo,
};

use super::Arguments;
use super::drive::Drive;
use super::setup::Setup;
use super::start::Start;
use crate::singular_poses::advice;
use crate::table::short;

/// A run, whole or not.
pub(crate) struct Ran {
    pub run: Run,
    /// What only adaptive steps have.
    pub adaptive: Option<AdaptiveRecord>,
    /// Why it failed, in one line.
    pub failure: Option<String>,
}

/// Runs `steps` steps, or to the same end, with a controller or none.
pub(crate) fn run(
    arguments: &Arguments,
    model: &Model,
    start: &Start,
    (setup, drive): (&mut Setup, Option<&Drive>),
    steps: usize,
    controller: Option<&mut dyn Controller>,
    mut observer: impl FnMut(&StepInfo<'_>) -> ControlFlow<()>,
) -> Ran {
    let simulation = &mut setup.simulation;
    let mut limits = stops(arguments, model);
    let mut options = RunOptions::new().sample_every(0).events(&mut limits).observer(&mut observer);
    // Shortened to the life of this call.
    options.controller = controller.map(|controller| controller as &mut dyn Controller);
    let (run, failure) = match simulation.reset(&start.q, &start.v) {
        Ok(()) => {
            if let Some(drive) = drive {
                simulation.set_controls(&drive.controls);
            }
            match simulation.run(steps, options) {
                Ok(run) => (run, None),
                Err(failure) => (failure.until, Some(blow_up(model, &failure.error, arguments.step))),
            }
        }
        Err(error) => (simulation.record().clone(), Some(blow_up(model, &error, arguments.step))),
    };
    Ran { run, adaptive: simulation.adaptive_record().copied(), failure }
}

/// The joints' position limits, as instants where the run ends, where that is asked for; adaptive steps tell when they are crossed.
fn stops<'a>(arguments: &Arguments, model: &Model) -> Vec<Event<'a>> {
    if arguments.stop_at_limits {
        Event::joint_limits(model).into_iter().map(Event::terminal).collect()
    } else if arguments.integrator == Some(Method::Adaptive) {
        Event::joint_limits(model)
    } else {
        Vec::new()
    }
}

/// Why a run ended early, with the option to change.
fn blow_up(model: &Model, error: &StepFailure, h: f64) -> String {
    match error {
        RunError::NotFinite { quantity, coordinate, step, .. } => format!(
            "the motion blew up at t = {} s (step {step}): {quantity} is not finite at `{coordinate}`; take a smaller \
             --step than {h} s",
            short(*step as f64 * h)
        ),
        RunError::Diverged { coordinate, speed, step, time, suggested_step, cause, .. } => format!(
            "the motion grows without bound: `{coordinate}` has v = {speed:.1e} at t = {} s (step {step}); try --step {suggested_step:.1e}, \
             {cause}",
            short(*time)
        ),
        RunError::SingularMass { time, source, .. } => singular(model, source, *time),
        RunError::Step { time, source: MethodError::Adaptive(source), .. } => given_up(source, *time),
        RunError::Step { step, source, .. } => {
            format!("no step from t = {} s (step {step}): {source}", short(*step as f64 * h))
        }
        other => other.to_string(),
    }
}

/// Why adaptive steps ended early, with the options to change.
fn given_up(error: &AdaptiveStepError, time: f64) -> String {
    let instead = "a larger --tolerance may do; --integrator rk4 takes steps of --step whatever their error";
    match error {
        AdaptiveStepError::TooManySteps { steps, step, coordinate } => format!(
            "given up at t = {} s after {steps} steps since the sample before: `{coordinate}` asks for steps of \
             {step:.1e} s there, as a stiff or a very light joint does (its inertia, damping or torque may be wrong); \
             {instead}",
            short(time)
        ),
        AdaptiveStepError::StepTooSmall { step, coordinate } => format!(
            "at t = {} s the tolerance asks for steps below {step:.1e} s, most of all at `{coordinate}`: the forces are \
             not smooth there, or the tolerance is below rounding; {instead}",
            short(time)
        ),
        grown @ AdaptiveStepError::Diverged { .. } => format!("t = {} s: {grown}", short(time)),
        other => format!("no step from t = {} s: {other}", short(time)),
    }
}

fn singular(model: &Model, mass: &SingularMass, time: f64) -> String {
    format!("no step from t = {} s: {}", short(time), advice(mass, model))
}
