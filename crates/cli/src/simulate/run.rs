//! One run, by fixed or by adaptive steps.

use std::ops::ControlFlow;

use multibody::simulator::{Effect, RunOptions, StepFailure};
use multibody::{
    AdaptiveError, AdaptiveFailure, AdaptiveMethod, AdaptiveSimulation, ControlTiming, Controller, Event,
    Model, Moment, Run, RunError, SingularMass, StepStatistics, ZeroTorque,
};

use super::Arguments;
use super::drive::Drive;
use super::method::TOLERANCE;
use super::setup::Setup;
use super::start::Start;
use crate::interruption;
use crate::singular_poses::advice;
use crate::table::short;

/// Adaptive steps for a second between two samples before the run is given up, and those for any two samples. An
/// ordinary robot takes some hundred a second.
const MOST_STEPS: (f64, usize) = (1e5, 10_000);

/// A run, whole or not.
pub(crate) struct Ran {
    pub run: Run,
    /// What only adaptive steps have.
    pub adaptive: Option<AdaptiveDetails>,
    /// Why it failed, in one line.
    pub failure: Option<String>,
}

/// What adaptive steps tell beside the run.
pub(crate) struct AdaptiveDetails {
    pub tolerance: f64,
    pub method: AdaptiveMethod,
    pub statistics: StepStatistics,
    /// max | |quaternion| − 1 |; none of a robot without quaternions.
    pub quaternion_error: Option<f64>,
}

/// Runs `steps` steps, or to the same end, with a controller or none.
pub(crate) fn run(
    arguments: &Arguments,
    model: &Model,
    start: &Start,
    (setup, drive): (&mut Setup, Option<&Drive>),
    steps: usize,
    controller: Option<&mut dyn Controller>,
    mut observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
) -> Ran {
    let is_dissipative = setup.acts(Effect::Dissipation);
    let Some(simulation) = &mut setup.simulation else {
        return adaptive((arguments, is_dissipative), model, start, steps, controller, observer);
    };
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
    Ran { run, adaptive: None, failure }
}

/// The joints' position limits, as instants where the run ends, where that is asked for.
fn stops<'a>(arguments: &Arguments, model: &Model) -> Vec<Event<'a>> {
    if !arguments.stop_at_limits {
        return Vec::new();
    }
    Event::joint_limits(model).into_iter().map(Event::terminal).collect()
}

/// By adaptive steps, sampled every `--step`: motors are asked and held at these instants, as with fixed steps.
fn adaptive(
    (arguments, dissipation): (&Arguments, bool),
    model: &Model,
    start: &Start,
    steps: usize,
    controller: Option<&mut dyn Controller>,
    observer: impl FnMut(&Moment<'_>) -> ControlFlow<()>,
) -> Ran {
    let h = arguments.step;
    let tolerance = arguments.tolerance.unwrap_or(TOLERANCE);
    let control = match controller {
        Some(_) => ControlTiming::Held { period: h },
        None => ControlTiming::Continuous,
    };
    // At most 1e5 times the longest --step that makes sense, and saturating beyond.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let max_steps = ((MOST_STEPS.0 * h) as usize).saturating_add(MOST_STEPS.1);
    let simulation = AdaptiveSimulation {
        tolerance,
        dissipation,
        control,
        max_steps,
        interrupt: Some(interruption::flag()),
        keep_samples: false,
        ..AdaptiveSimulation::of(model)
    };
    let mut limits =
        if arguments.stop_at_limits { stops(arguments, model) } else { Event::joint_limits(model) };
    let times = (0..=steps).map(|k| k as f64 * h);
    let mut none = ZeroTorque;
    let controller = controller.unwrap_or(&mut none);
    let (found, failure) = match simulation.run(&start.q, &start.v, times, controller, &mut limits, observer)
    {
        Ok(found) => (found, None),
        Err(failure) => {
            let AdaptiveFailure { error, until, .. } = *failure;
            (until, Some(given_up(model, &error)))
        }
    };
    let has_quaternions = model.nq() > model.nv();
    let details = AdaptiveDetails {
        tolerance,
        method: found.method,
        statistics: found.statistics,
        quaternion_error: has_quaternions.then_some(found.quaternion_error),
    };
    Ran { run: found.into(), adaptive: Some(details), failure }
}

/// Why a run of fixed steps ended early, with the step to change.
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
        RunError::Step { step, source, .. } => {
            format!("no step from t = {} s (step {step}): {source}", short(*step as f64 * h))
        }
        other => other.to_string(),
    }
}

/// Why a run of adaptive steps ended early, with the options to change.
fn given_up(model: &Model, error: &AdaptiveError) -> String {
    let instead = "a larger --tolerance may do; --integrator rk4 takes steps of --step whatever their error";
    match error {
        AdaptiveError::SingularMass { time, source } => singular(model, source, *time),
        AdaptiveError::TooManySteps { steps, time, step, coordinate } => format!(
            "given up at t = {} s after {steps} steps since the sample before: `{coordinate}` asks for steps of \
             {step:.1e} s there, as a stiff or a very light joint does (its inertia, damping or torque may be wrong); \
             {instead}",
            short(*time)
        ),
        AdaptiveError::StepTooSmall { time, step, coordinate } => format!(
            "at t = {} s the tolerance asks for steps below {step:.1e} s, most of all at `{coordinate}`: the forces are \
             not smooth there, or the tolerance is below rounding; {instead}",
            short(*time)
        ),
        other => other.to_string(),
    }
}

fn singular(model: &Model, mass: &SingularMass, time: f64) -> String {
    format!("no step from t = {} s: {}", short(time), advice(mass, model))
}
