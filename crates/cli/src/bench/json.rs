//! The results as JSON lines.

use serde::Serialize;

use super::batch::Work;
use super::entry::{Task, Time};
use super::machine::Machine;
use super::results::Results;

/// The first line.
#[derive(Serialize)]
struct Head<'a> {
    robot: &'a str,
    file: &'a str,
    nq: usize,
    nv: usize,
    tip: &'a str,
    machine: &'a Machine,
    /// The functions that machine code computes.
    native: String,
    states: u32,
    seed: u64,
    rounds: usize,
    interrupted: bool,
}

/// A line for each quantity. It has no time if there was a trouble, or before the first round.
#[derive(Serialize)]
struct Line<'a> {
    /// "single", "batch" or "rollout".
    group: &'static str,
    quantity: String,
    number: &'static str,
    threads: usize,
    /// "state" or "step".
    per: &'static str,
    ns: Option<f64>,
    /// The minimum and the maximum of the rounds.
    spread_ns: Option<[f64; 2]>,
    per_second: Option<f64>,
    rounds: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    trouble: Option<&'a str>,
}

pub(super) fn lines(results: &Results<'_>) -> Result<String, serde_json::Error> {
    let Results { model, file, machine, tip, states, seed, rounds, interrupted, .. } = results;
    let mut text = serde_json::to_string(&Head {
        robot: model.name(),
        file,
        nq: model.nq(),
        nv: model.nv(),
        tip,
        machine,
        native: model.native().summary(),
        states: *states,
        seed: *seed,
        rounds: *rounds,
        interrupted: *interrupted,
    })? + "\n";
    for entry in &results.entries {
        let (group, quantity, number, threads, per) = match entry.what {
            Task::Single(quantity) => ("single", quantity.name().to_owned(), "f64", 1, "state"),
            Task::Batch { work: Work::Compute(quantity), precision, threads } => {
                ("batch", quantity.name().to_owned(), precision.key(), threads, "state")
            }
            Task::Batch { work: Work::Rollout(integrator), precision, threads } => {
                ("rollout", integrator.name().replace('-', "_"), precision.key(), threads, "step")
            }
        };
        let time = entry.time();
        text += &serde_json::to_string(&Line {
            group,
            quantity,
            number,
            threads,
            per,
            ns: time.map(|time| time.median),
            spread_ns: time.map(|time| [time.least, time.most]),
            per_second: time.map(Time::per_second),
            rounds: entry.rounds.len(),
            trouble: entry.trouble.as_deref(),
        })?;
        text.push('\n');
    }
    Ok(text)
}
