//! `dynamics bench`: how fast a robot is computed on this machine.

#[cfg_attr(not(feature = "batch"), path = "bench/no_batch.rs")]
mod batch;
mod entry;
mod json;
mod machine;
mod report;
mod single;
mod states;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use multibody::Model;

use self::batch::Batch;
use self::entry::{Entry, Precision, What, median};
use self::machine::Machine;
use self::single::Single;
use self::states::{States, tip};
use crate::failure::{Failure, Outcome};
use crate::interruption;
use crate::output::{print, print_json};
use crate::robot_file::RobotFile;

/// Measure how fast a robot is computed on this machine.
///
/// Times every quantity of the equation of motion at random states (seeded: the same every time): one state
/// at a time, batches of f64 and f32 on one thread and on all, rollouts, and what more threads bring. Reading the
/// state, sines and cosines, and writing the result count. Everything is measured once a round, so that a
/// disturbance hits all alike; a number is the median of the rounds, and ± is half their range. Ctrl-C
/// ends it early (exit code 130) and shows what was measured.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// A few seconds instead of half a minute: three short rounds.
    #[arg(long)]
    quick: bool,
    /// Print JSON lines instead of tables: one about the machine, then one a quantity.
    #[arg(long)]
    json: bool,
    /// How many random states.
    #[arg(long, default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1024..=1_000_000))]
    states: u32,
    /// The seed of the random states.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many threads are all; 0 for as many as the machine runs at once.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
}

/// What the report says.
struct Results<'a> {
    model: &'a Model,
    file: String,
    machine: Machine,
    tip: String,
    states: u32,
    seed: u64,
    rounds: usize,
    threads: Vec<usize>,
    entries: Vec<Entry>,
    interrupted: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let model = arguments.robot.load_to_compute()?.model;
    if model.nv() == 0 {
        return Err(Failure::new(format!(
            "{}: no joint moves, so there is nothing to measure (--floating-base frees the root link)",
            arguments.robot.shown()
        )));
    }
    interruption::end_between_steps()?;
    if machine::IS_DEBUG {
        eprintln!(
            "warning: this is a debug build: it is slower than a release build (cargo run --release -- bench …)"
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
    let mut stand = Stand {
        single: Single::new(&model, &states, tip),
        doubles: Batch::new(&model, States::random(&model, count, arguments.seed), tip, &threads)?,
        singles: Batch::new(&model, States::random(&model, count, arguments.seed), tip, &threads)?,
    };
    let mut entries = Entry::all(&threads);
    let interrupted = stand.measure(&mut entries, rounds, Duration::from_millis(slice));

    let results = Results {
        model: &model,
        file: arguments.robot.shown().to_string(),
        machine: stand.machine(cores, load_before),
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

/// Where everything is measured.
struct Stand<'a> {
    single: Single<'a>,
    doubles: Batch<'a, f64>,
    singles: Batch<'a, f32>,
}

impl Stand<'_> {
    /// Rounds over all entries; whether it was interrupted.
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

    /// A block that is not timed: memory and caches are warm after it, and it shows whether there is a result.
    fn trial(&mut self, entry: &mut Entry) -> Result<(), String> {
        self.block(entry)?;
        match entry.what {
            What::Single(quantity) if !self.single.is_finite(quantity) => {
                Err("the result is not finite: a singular mass matrix?".into())
            }
            _ => Ok(()),
        }
    }

    /// Blocks for as long as `slice`, at least one; the median of their times becomes the round's.
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
            What::Single(quantity) => Ok(self.single.block(quantity, cursor)),
            What::Batch { work, precision: Precision::Double, threads } => {
                self.doubles.block(work, threads, cursor)
            }
            What::Batch { work, precision: Precision::Single, threads } => {
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
