//! This project's program in the comparison with peers. It times, counts or prints one algorithm on one
//! robot, for one state at a time or a batch ([`BatchName`]).
//!
//! Called by `bench/peers/run.py`; the file of states and the output are those of `bench/peers/side.hpp`.
use std::process::ExitCode;
use std::time::Instant;

use bench::{BatchName, BatchTask, StateTable, Task, described_robot, named};
use robot_dynamics::batch::{BatchFloat, BatchOptions};
use robot_dynamics::model::{InstructionSet, Model};
use robot_dynamics::quantity::Quantity;
use robot_dynamics_functions::with_native_code;

const USAGE: &str =
    "usage: peer_side ROBOT STATES ALGORITHM (time MILLISECONDS | calls N | write FILE) [portable]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let (arguments, portable) = match arguments {
        [first @ .., last] if last == "portable" => (first, true),
        _ => (arguments, false),
    };
    let [robot, states, algorithm, mode, value] = arguments else { return Err(USAGE.into()) };
    let model = with_native_code(described_robot(robot)?);
    let states = StateTable::read(states)?;
    if states.count() < BLOCK {
        return Err(format!("{} states; at least {BLOCK} are needed", states.count()).into());
    }
    if let Some(name) = BatchName::parse(algorithm) {
        let run = if name.single { run_batch::<f32> } else { run_batch::<f64> };
        return run(&model, &states, name, portable, mode, value);
    }
    let algorithm = named(algorithm).ok_or_else(|| format!("no algorithm {algorithm}"))?;
    let mut task = if portable { Task::portable(&model, &states) } else { Task::new(&model, &states) };
    match mode.as_str() {
        "time" => println!("{}", time(&mut task, algorithm, states.count(), value.parse()?)),
        "calls" => (0..value.parse()?).for_each(|i: usize| task.call(algorithm, i % states.count())),
        "write" => {
            let mut out = Vec::new();
            for i in 0..states.count() {
                task.call(algorithm, i);
                out.extend(task.result(algorithm).into_iter().flat_map(f64::to_le_bytes));
            }
            std::fs::write(value, out)?;
        }
        _ => return Err(USAGE.into()),
    }
    Ok(())
}

/// Calls between two clock readings: short relative to time slices, long relative to the clock's resolution.
const BLOCK: usize = 128;

/// A batch: one call computes all its states.
fn run_batch<T: BatchFloat + Into<f64>>(
    model: &Model,
    states: &StateTable,
    name: BatchName,
    portable: bool,
    mode: &str,
    value: &str,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut options = BatchOptions::default();
    options.threads = name.threads.unwrap_or(1);
    options.limit = portable.then_some(InstructionSet::Portable);
    let mut task = BatchTask::<T>::new(model, states, name.repetitions(), options);
    match mode {
        "time" => {
            let count = task.count();
            let blocks = blocks(value.parse()?, |times| {
                let before = Instant::now();
                task.call(name.algorithm);
                times.push(before.elapsed().as_secs_f64() * 1e9 / count as f64);
            });
            println!("{}", summary(blocks));
        }
        "calls" => (0..value.parse()?).step_by(task.count()).for_each(|_: usize| task.call(name.algorithm)),
        "write" => {
            task.call(name.algorithm);
            // Once each, for any number of copies in the batch.
            let numbers: Vec<u8> = task.result().flat_map(f64::to_le_bytes).collect();
            std::fs::write(value, &numbers[..numbers.len() / name.repetitions()])?;
        }
        _ => return Err(USAGE.into()),
    }
    Ok(())
}

/// Runs through all states block by block for that long. Returns median and smallest nanoseconds per call of
/// a block.
fn time(task: &mut Task, algorithm: Quantity, count: usize, milliseconds: f64) -> String {
    summary(blocks(milliseconds, |times| {
        for first in (0..=count - BLOCK).step_by(BLOCK) {
            let before = Instant::now();
            (first..first + BLOCK).for_each(|i| task.call(algorithm, i));
            times.push(before.elapsed().as_secs_f64() * 1e9 / BLOCK as f64);
        }
    }))
}

/// The times of passes over all states for that many milliseconds, after an untimed one.
fn blocks(milliseconds: f64, mut pass: impl FnMut(&mut Vec<f64>)) -> Vec<f64> {
    let mut times = Vec::new();
    pass(&mut times);
    times.clear();
    let start = Instant::now();
    while times.is_empty() || start.elapsed().as_secs_f64() * 1e3 < milliseconds {
        pass(&mut times);
    }
    times
}

fn summary(mut blocks: Vec<f64>) -> String {
    blocks.sort_by(f64::total_cmp);
    let (median, least) = (blocks[blocks.len() / 2], blocks[0]);
    format!(r#"{{"median_ns": {median:.3}, "min_ns": {least:.3}, "blocks": {}}}"#, blocks.len())
}
