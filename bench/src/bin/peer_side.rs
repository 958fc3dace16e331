//! This project's side of the comparison with peers: one algorithm on one robot, timed, counted or written out.
//!
//! Called by `bench/peers/run.py`; the file of states and the output are those of `bench/peers/side.hpp`.

use std::process::ExitCode;
use std::time::Instant;

use bench::{Algorithm, StateTable, Task, described_robot};

const USAGE: &str = "usage: peer_side ROBOT STATES ALGORITHM (time MILLISECONDS | calls N | write FILE)";

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
    let [robot, states, algorithm, mode, value] = arguments else { return Err(USAGE.into()) };
    let model = described_robot(robot)?;
    let states = StateTable::read(states)?;
    let algorithm = Algorithm::named(algorithm).ok_or_else(|| format!("no algorithm {algorithm}"))?;
    if states.count() < BLOCK {
        return Err(format!("{} states; at least {BLOCK} are needed", states.count()).into());
    }
    let mut task = Task::new(&model, &states);
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

/// Calls between two looks at the clock: short beside the time slices of a busy machine, long beside the clock.
const BLOCK: usize = 128;

/// Goes through all states, block by block, for that long; median and least nanoseconds per call of a block.
fn time(task: &mut Task, algorithm: Algorithm, count: usize, milliseconds: f64) -> String {
    (0..count).for_each(|i| task.call(algorithm, i));
    let start = Instant::now();
    let mut blocks = Vec::new();
    while blocks.is_empty() || start.elapsed().as_secs_f64() * 1e3 < milliseconds {
        for first in (0..=count - BLOCK).step_by(BLOCK) {
            let before = Instant::now();
            (first..first + BLOCK).for_each(|i| task.call(algorithm, i));
            blocks.push(before.elapsed().as_secs_f64() * 1e9 / BLOCK as f64);
        }
    }
    blocks.sort_by(f64::total_cmp);
    let (median, least) = (blocks[blocks.len() / 2], blocks[0]);
    format!(r#"{{"median_ns": {median:.3}, "min_ns": {least:.3}, "blocks": {}}}"#, blocks.len())
}
