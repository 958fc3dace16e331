//! `dynamics simulate`: simulates a robot and checks its energy balance.

mod arguments;
mod csv;
mod drive;
mod files;
mod ground;
mod hold;
mod loops;
mod method;
mod option_values;
mod plot;
mod recorder;
mod run;
mod setup;
mod start;
mod summary;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Controller, Effect, Method, StepInfo, steps_in};
use robot_dynamics::text::one_line;

pub(crate) use self::arguments::Arguments;
use self::csv::OptionalColumns;
use self::files::Files;
use self::ground::Floor;
use self::hold::Hold;
use self::plot::Plot;
use self::recorder::Recorder;
use self::run::RunResult;
use self::setup::Setup;
use self::start::Start;
use self::summary::Summary;
use crate::failure::{Failure, Outcome};
use crate::interruption;
use crate::joint_values::{Numbers, set};
use crate::output::{print, print_error};
use crate::robot_file::LoadedRobot;
use crate::table::short;

/// Largest number of steps, which only a mistyped step exceeds.
const MAX_STEPS: f64 = 1e9;

pub(crate) fn run(arguments: &mut Arguments) -> Outcome {
    let LoadedRobot { model, report, .. } = arguments.robot.load_to_compute()?;
    if model.nv() == 0 {
        return Err(Failure::new(format!(
            "{}: the robot has no degree of freedom to simulate (--floating-base adds six)",
            arguments.robot.shown()
        )));
    }
    let arguments = &*arguments;
    method::check(arguments)?;
    let steps = steps(arguments)?;
    let is_held = arguments.hold || !arguments.goal.is_empty();
    let mut setup = Setup::choose(arguments, &model, is_held)?;
    let loops = loops::choose(arguments, &model, &setup)?;
    let mut start = Start::choose(&model, &arguments.pose, &arguments.velocity, !is_held)?;
    if let Some(loops) = &loops {
        loops::close(&model, loops, &mut start, !is_held && arguments.pose.is_empty())?;
    }
    let floor = Floor::choose(arguments, &model, &setup, &mut start)?;
    let drive = drive::choose(arguments, &model, &setup, &start)?;
    let mut goal = start.q.clone();
    set(&model, "--goal", &arguments.goal, Numbers::Configuration, &mut goal)?;
    let mut hold = if is_held {
        Some(Hold::new(&model, &goal, arguments.gains, arguments.dt).map_err(Failure::new)?)
    } else {
        None
    };
    // From here on no signal leaves an unfinished file.
    interruption::end_between_steps()?;
    let (csv, plot) = (arguments.csv.as_deref(), arguments.plot.as_deref());
    let touching = setup.ground_links().to_vec();
    let columns = OptionalColumns { touching: &touching, has_losses: setup.has_losses() };
    let stride = arguments.steps_between_rows().map_err(Failure::new)?;
    let read: Vec<PathBuf> = report.files.iter().chain(&arguments.srdf).cloned().collect();
    let mut files = Files::open(&model, (arguments.robot.path(), &read), (csv, stride, columns), plot)?;
    let print_summary = if files.use_standard_output() { print_error } else { print };

    let progress = progress(steps);
    let recorder = Recorder::new(&model);
    let mut observer = Observer { recorder, files, progress: &progress, steps, step: arguments.dt };
    let clock = Instant::now();
    let controller = hold.as_mut().map(|hold| &mut hold.controller as &mut dyn Controller);
    let ran = run::run(arguments, &model, &start, (&mut setup, drive.as_ref()), steps, controller, |info| {
        observer.record(info)
    });
    let seconds = clock.elapsed().as_secs_f64();
    progress.finish_and_clear();

    let Observer { mut recorder, files, .. } = observer;
    let RunResult { run, failure, .. } = &ran;
    if let Some(error) = failure
        && run.trajectory.is_empty()
    {
        return Err(Failure::new(error));
    }
    let is_whole = failure.is_none() && !run.interrupted;
    recorder.finish();
    let picture = Plot {
        model: &model,
        recorder: &recorder,
        columns,
        caption: &caption((arguments, &setup), &model, run.time, is_held, is_whole),
        scale: recorder.energy_scale(&run.ledger, failure.is_some()).0,
        conserves: !is_held && setup.conserves(),
        diverged: failure.is_some(),
    };
    let written = files.finish(&picture, is_whole);
    if written.reader_left {
        return Ok(ExitCode::SUCCESS);
    }
    let summary = Summary {
        arguments,
        model: &model,
        start: &start,
        goal: &goal,
        hold: hold.as_ref(),
        drive: drive.as_ref(),
        setup: &setup,
        loops: loops.as_ref(),
        floor: floor.as_ref(),
        ran: &ran,
        recorder: &recorder,
        seconds,
        written: &written,
    };
    print_summary(&summary.text())?;
    let causes: Vec<&str> = failure.iter().chain(&written.troubles).map(String::as_str).collect();
    if !causes.is_empty() {
        return Err(Failure::new(format!("{}{}", causes.join("; "), written.kept())));
    }
    if run.interrupted {
        eprintln!("interrupted at t = {} s of {} s", run.time, arguments.duration);
        return Ok(interruption::code());
    }
    Ok(ExitCode::SUCCESS)
}

/// The whole number of steps that is nearest to the duration, at least one.
fn steps(arguments: &Arguments) -> Result<usize, Failure> {
    let steps = arguments.duration / arguments.dt;
    if steps > MAX_STEPS {
        let [duration, step, steps] = [arguments.duration, arguments.dt, steps].map(short);
        return Err(Failure::new(format!(
            "{duration} s in steps of {step} s are {steps} steps, at most {MAX_STEPS:e} are allowed; take a longer \
             --dt or a shorter --duration"
        )));
    }
    let nearest = steps_in(arguments.duration, arguments.dt);
    nearest.map(|steps| steps.max(1)).map_err(|error| Failure::new(error.to_string()))
}

/// A progress bar, which only a terminal shows.
fn progress(steps: usize) -> ProgressBar {
    let bar = ProgressBar::new(steps as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    bar
}

/// The line above the plot.
fn caption(
    (arguments, setup): (&Arguments, &Setup),
    model: &Model,
    time: f64,
    is_held: bool,
    is_whole: bool,
) -> String {
    let motors = if is_held { "PD hold" } else { "passive" };
    let damping = if setup.acts(Effect::Dissipation) { "with damping and friction" } else { "no damping" };
    let partial = if is_whole { String::new() } else { format!(" · ends early at {time:.3} s") };
    let name = one_line(model.name());
    let steps = match setup.method() {
        Method::Adaptive => format!("tolerance {:e}", arguments.adaptive_tolerance()),
        _ => format!("h = {} s", arguments.dt),
    };
    format!("{name}: {motors}, {damping} · {}, {steps}{partial}", setup.method())
}

/// Records the samples of a run.
struct Observer<'a> {
    recorder: Recorder,
    files: Files,
    progress: &'a ProgressBar,
    steps: usize,
    /// Sampling period \[s\].
    step: f64,
}

impl Observer<'_> {
    fn record(&mut self, info: &StepInfo<'_>) -> ControlFlow<()> {
        self.recorder.record(info);
        let is_interrupted = interruption::interrupted() && info.step < self.steps;
        // A sample between two grid instants is where a limit ended the run.
        let is_stop = (info.time - info.step as f64 * self.step).abs() > 1e-9 * self.step;
        self.files.record(info, is_interrupted || is_stop || info.step == self.steps)?;
        if info.step.is_multiple_of(1024) {
            self.progress.set_position(info.step as u64);
        }
        if is_interrupted { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
