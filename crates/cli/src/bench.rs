//! `dynamics bench`: times the computations of a robot on this machine.

#[cfg_attr(not(feature = "batch"), path = "bench/no_batches.rs")]
mod batch;
mod entry;
mod json;
mod machine;
mod report;
mod results;
mod single_states;
mod states;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use self::batch::Batch;
use self::entry::{Entry, Precision, Task, median};
use self::machine::Machine;
use self::results::Results;
use self::single_states::SingleStateBench;
use self::states::{States, tip};
use crate::failure::{CommandResult, Failure};
use crate::interruption;
use crate::output::{print, print_json};
use crate::robot_file::RobotFile;

/// Measure how fast a robot is computed on this machine.
///
/// Times every quantity of the equation of motion at random states, which depend only on --seed. It times
/// single states, batches of f64 and f32 on one thread and on all, rollouts, and the speed-up with more
/// threads. Each time includes reading the state, sines and cosines, and writing the result. Every round
/// measures everything once, so that a disturbance affects all quantities alike. A number is the median of
/// the rounds, and ± is half their range. Ctrl-C ends the run early (exit code 130) and shows the results so
/// far.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Take three short rounds: a few seconds instead of half a minute.
    #[arg(long)]
    quick: bool,
    /// Print JSON lines instead of tables: one for the machine, then one for each quantity.
    #[arg(long)]
    json: bool,
    /// Number of random states.
    #[arg(long, default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1024..=1_000_000))]
    states: u32,
    /// Seed of the random states.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Largest number of threads; 0 for all hardware threads.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
}

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    let model = arguments.robot.load_to_compute()?.model;
    if model.nv() == 0 {
        return Err(Failure::new(format!(
            "{}: the robot has no degree of freedom to measure (--floating-base adds six)",
            arguments.robot.shown()
        )));
    }
    interruption::end_between_steps()?;
    if machine::IS_DEBUG {
        eprintln!(
            "warning: this is a debug build, slower than a release build (cargo run --release -- bench …)"
        );
    }
    let load_before = machine::load();
    let (rounds, slice) = if arguments.quick { (3, 20) } else { (5, 100) };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let all = if arguments.threads == 0 { cores } else { arguments.threads.into() };
    let threads = machine::thread_counts(all);

    let count = arguments.states as usize;
    let (tip, tip_name) = tip(&model);
    let states = States::random(&model, count, arguments.seed);
    let mut measurement = Measurement {
        single: SingleStateBench::new(&model, &states, tip),
        doubles: Batch::new(&model, States::random(&model, count, arguments.seed), tip, &threads)?,
        singles: Batch::new(&model, States::random(&model, count, arguments.seed), tip, &threads)?,
    };
    let mut entries = Entry::all(&threads);
    let interrupted = measurement.measure(&mut entries, rounds, Duration::from_millis(slice));

    let results = Results {
        model: &model,
        file: arguments.robot.shown().to_string(),
        machine: measurement.machine(cores, load_before),
        tip: tip_name,
        states: arguments.states,
        seed: arguments.seed,
        rounds,
        threads,
        entries,
        interrupted,
    };
    if arguments.json {
        print_json(&json::lines(&results).map_err(Failure::new)?)?;
    } else {
        print(&report::text(&results))?;
    }
    if interrupted {
        let done = results.entries.iter().map(|entry| entry.rounds.len()).sum::<usize>();
        eprintln!("interrupted after {done} of {} measurements", results.entries.len() * rounds);
        return Ok(interruption::code());
    }
    Ok(ExitCode::SUCCESS)
}

/// The robot's states and memory for all measurements.
struct Measurement<'a> {
    single: SingleStateBench<'a>,
    doubles: Batch<'a, f64>,
    singles: Batch<'a, f32>,
}

impl Measurement<'_> {
    /// Measures all entries in each round. Returns whether a signal ended the run.
    fn measure(&mut self, entries: &mut [Entry], rounds: usize, slice: Duration) -> bool {
        let bar = ProgressBar::new((entries.len() * rounds) as u64);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta} left") {
            bar.set_style(style);
        }
        'rounds: for _ in 0..rounds {
            for entry in &mut *entries {
                if entry.rounds.is_empty() && entry.trouble.is_none() {
                    entry.trouble = self.trial(entry).err();
                }
                if entry.trouble.is_none() {
                    self.round(entry, slice);
                }
                bar.inc(1);
                if interruption::interrupted() {
                    break 'rounds;
                }
            }
        }
        bar.finish_and_clear();
        interruption::interrupted()
    }

    /// Runs one block without timing: it warms memory and caches, and shows whether there is a result.
    fn trial(&mut self, entry: &mut Entry) -> Result<(), String> {
        self.block(entry)?;
        match entry.what {
            Task::Single(quantity) if !self.single.is_finite(quantity) => {
                Err("the result is not finite; the mass matrix may be singular".into())
            }
            _ => Ok(()),
        }
    }

    /// Times blocks for as long as `slice`, at least one. Their median becomes the time of the round.
    fn round(&mut self, entry: &mut Entry, slice: Duration) {
        let (start, mut times) = (Instant::now(), Vec::new());
        while times.is_empty() || (start.elapsed() < slice && !interruption::interrupted()) {
            let before = Instant::now();
            match self.block(entry) {
                Ok(count) => times.push(before.elapsed().as_secs_f64() * 1e9 / count as f64),
                Err(trouble) => {
                    entry.trouble = Some(trouble);
                    return;
                }
            }
        }
        entry.rounds.extend(median(&mut times));
    }

    fn block(&mut self, entry: &mut Entry) -> Result<usize, String> {
        let cursor = &mut entry.cursor;
        match entry.what {
            Task::Single(quantity) => Ok(self.single.block(quantity, cursor)),
            Task::Batch { work, precision: Precision::Double, threads } => {
                self.doubles.block(work, threads, cursor)
            }
            Task::Batch { work, precision: Precision::Single, threads } => {
                self.singles.block(work, threads, cursor)
            }
        }
    }

    fn machine(&self, cores: usize, load_before: Option<f64>) -> Machine {
        let ((lanes_f64, set), (lanes_f32, _)) = (self.doubles.lanes(), self.singles.lanes());
        Machine {
            processor: machine::processor(),
            threads: cores,
            system: std::env::consts::OS.to_owned(),
            load_before,
            build: if machine::IS_DEBUG { "debug" } else { "release" },
            version: env!("CARGO_PKG_VERSION"),
            single_instructions: self.single.instruction_set().to_string(),
            batch_instructions: set.to_string(),
            lanes_f64,
            lanes_f32,
        }
    }
}
