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
mod plan;
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
use robot_dynamics::simulation::{Controller, Effect, Method, StepInfo};
use robot_dynamics::text::one_line;

pub(crate) use self::arguments::Arguments;
use self::csv::OptionalColumns;
use self::files::{Files, WrittenFiles};
use self::hold::Hold;
use self::plan::RunPlan;
use self::plot::Plot;
use self::recorder::Recorder;
use self::run::RunResult;
use self::setup::Setup;
use self::summary::Summary;
use crate::failure::{CommandResult, Failure};
use crate::interruption;
use crate::output::{print, print_error};
use crate::robot_file::LoadedRobot;

pub(crate) fn run(arguments: &mut Arguments) -> CommandResult {
    let LoadedRobot { model, report, .. } = arguments.robot.load_to_compute()?;
    let arguments = &*arguments;
    let mut plan = RunPlan::choose(arguments, &model)?;
    let mut hold = if plan.is_held {
        Some(Hold::new(&model, &plan.goal, arguments.gains, arguments.dt).map_err(Failure::new)?)
    } else {
        None
    };
    // From here on no signal leaves an unfinished file.
    interruption::end_between_steps()?;
    let touching = plan.setup.ground_links().to_vec();
    let columns = OptionalColumns { touching: &touching, has_losses: plan.setup.has_losses() };
    let mut files = open_files(arguments, &model, &report.files, columns)?;
    let print_summary = if files.use_standard_output() { print_error } else { print };

    let Recording { recorder, files, ran, seconds } =
        take_steps(arguments, &model, &mut plan, hold.as_mut(), files);
    let RunResult { run, failure, .. } = &ran;
    if let Some(error) = failure
        && run.trajectory.is_empty()
    {
        return Err(Failure::new(error));
    }
    let is_whole = failure.is_none() && !run.interrupted;
    let picture = Plot {
        model: &model,
        recorder: &recorder,
        columns,
        caption: &caption((arguments, &plan.setup), &model, run.time, plan.is_held, is_whole),
        scale: recorder.energy_scale(&run.energy_account, failure.is_some()).0,
        conserves: !plan.is_held && plan.setup.conserves(),
        diverged: failure.is_some(),
    };
    let written = files.finish(&picture, is_whole);
    if written.reader_left {
        return Ok(ExitCode::SUCCESS);
    }
    let summary = Summary {
        arguments,
        model: &model,
        plan: &plan,
        hold: hold.as_ref(),
        ran: &ran,
        recorder: &recorder,
        seconds,
        written: &written,
    };
    print_summary(&summary.text())?;
    outcome(arguments, &ran, &written)
}

/// Opens the files of the results. `read` has the files that the run reads, which must not be overwritten.
fn open_files(
    arguments: &Arguments,
    model: &Model,
    read: &[PathBuf],
    columns: OptionalColumns<'_>,
) -> Result<Files, Failure> {
    let (csv, plot) = (arguments.csv.as_deref(), arguments.plot.as_deref());
    let stride = arguments.steps_between_rows().map_err(Failure::new)?;
    Files::open(model, (arguments.robot.path(), read), (csv, stride, columns), plot)
}

/// A run with its samples and its unfinished files.
struct Recording {
    recorder: Recorder,
    files: Files,
    ran: RunResult,
    /// Wall-clock time of the run \[s\].
    seconds: f64,
}

/// Takes all steps, and records and shows the progress.
fn take_steps(
    arguments: &Arguments,
    model: &Model,
    plan: &mut RunPlan,
    hold: Option<&mut Hold<'_>>,
    files: Files,
) -> Recording {
    let progress = progress(plan.steps);
    let recorder = Recorder::new(model);
    let mut observer =
        Observer { recorder, files, progress: &progress, steps: plan.steps, step: arguments.dt };
    let RunPlan { steps, setup, start, drive, .. } = plan;
    let clock = Instant::now();
    let controller = hold.map(|hold| &mut hold.controller as &mut dyn Controller);
    let ran = run::run(arguments, model, start, (setup, drive.as_ref()), *steps, controller, |info| {
        observer.record(info)
    });
    let seconds = clock.elapsed().as_secs_f64();
    progress.finish_and_clear();
    let Observer { mut recorder, files, .. } = observer;
    recorder.finish();
    Recording { recorder, files, ran, seconds }
}

/// The outcome of the command after its summary.
fn outcome(arguments: &Arguments, ran: &RunResult, written: &WrittenFiles) -> CommandResult {
    let RunResult { run, failure, .. } = ran;
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
