//! `dynamics certify digits`.

use robot_dynamics::model::random_state;
use robot_dynamics::number::SplitMix64;
use robot_dynamics::text::one_line;
use robot_dynamics_certified::{Certificate, EnclosedQuantity, EnclosedState, enclose_state};
use serde_json::json;

use super::results::Results;
use crate::failure::{CommandResult, Context};
use crate::robot_file::RobotFile;
use crate::table::{Table, count};

/// Prove how many digits of M, C, g, τ and a are right.
///
/// Encloses the exact numbers at random states, and compares this library's results in double precision with
/// the enclosures. Errors are relative to the largest entry of the matrix or vector.
#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Number of random states.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    states: u32,
    /// Seed of the random states.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    results: Results,
}

pub(super) fn run(arguments: &Arguments) -> CommandResult {
    let model = arguments.robot.load_to_compute()?.model;
    let random = &mut SplitMix64::new(arguments.seed);
    let states: Vec<_> = (0..arguments.states).map(|_| random_state(&model, random)).collect();
    let mut enclosed: Vec<(EnclosedState<'_>, Vec<EnclosedQuantity>)> = Vec::new();
    for state in &states {
        let state = EnclosedState { q: &state.q, v: &state.v, a: &state.a, tau: &state.tau };
        enclosed.push((state, enclose_state(&model, state).context(arguments.robot.shown())?));
    }
    let mut table = Table::new(&["quantity", ">digits proven", ">largest error"]);
    let mut rows = Vec::new();
    let names = enclosed.first().map_or(Vec::new(), |(_, all)| all.iter().map(|one| one.name).collect());
    for (k, name) in names.iter().enumerate() {
        let error = enclosed.iter().fold(0.0, |most: f64, (_, all)| most.max(all[k].relative_error()));
        let digits = enclosed.iter().fold(f64::INFINITY, |least, (_, all)| least.min(all[k].digits()));
        table.row([
            (*name).to_owned(),
            format!("{:.1}", (10.0 * digits).floor() / 10.0),
            format!("{error:.1e}"),
        ]);
        rows.push(json!({ "quantity": name, "digits": digits, "relative_error": error }));
    }
    let text = format!(
        "{}: {}, seed {}\n\n{}\nThe errors include those of the enclosures, so double precision may be better.\n",
        one_line(model.name()),
        count(states.len(), "random state"),
        arguments.seed,
        table.text()
    );
    let json = json!({ "robot": model.name(), "states": arguments.states, "seed": arguments.seed, "quantities": rows });
    arguments.results.finish(true, &text, &json, || Some(Certificate::of_digits(&model, &enclosed)))
}
