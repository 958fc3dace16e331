//! `dynamics audit`: the project's oracles, run on one robot file.

mod check;
mod drift;
mod forward;
mod gravity;
mod inertia;
mod inverse;
mod lagrange;
mod load;
mod mass_matrix;
mod power;
mod probe;
mod skew;

use std::process::ExitCode;

use serde::Serialize;

use self::check::{Check, Verdict, shown};
use self::probe::Probe;
use crate::failure::{Failure, Outcome};
use crate::output::print;
use crate::robot_file::{Loaded, RobotFile};
use crate::size::refuse_beyond_memory;
use crate::table::Table;

/// Check a robot's file and its dynamics against independent derivations.
///
/// Every check is made at random states within the limits (seeded: the same every time) and shows the worst
/// one. What two routes to the same number may differ by is rounding: 1e-12 of the largest term where terms
/// are added up, 64 ε κ(M) where M is inverted (ε = 2.2e-16, κ the condition number of M at that state: a
/// robot of heavy and light links has a large one). Where a robot's numbers leave no such accuracy, κ(M)
/// itself falls short. The energy of a free motion must converge to a constant with the order of the
/// integrator. The exit code is 1 if something falls short.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// How many random states each check is made at.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    states: u32,
    /// The seed of the random states.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The result of an audit.
#[derive(Serialize)]
struct Audit<'a> {
    robot: &'a str,
    passed: bool,
    states: u32,
    seed: u64,
    checks: &'a [Check],
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let Loaded { model, report } = arguments.robot.load()?;
    arguments.robot.print_warnings(&report);
    refuse_beyond_memory(&model)?;
    let mut checks = vec![load::ignored_physics(&report)];
    checks.extend(inertia::checks(&model));
    if model.nv() > 0 {
        let probe = Probe::new(&model, arguments.states, arguments.seed);
        checks.extend(mass_matrix::checks(&probe));
        checks.extend(lagrange::checks(&probe));
        checks.push(gravity::slope_of_potential(&probe));
        checks.push(skew::defect(&probe));
        if probe.has_accelerations() {
            checks.push(inverse::undoes_forward(&probe));
            checks.push(forward::two_routes(&probe));
            checks.push(power::balance(&probe));
            checks.extend(drift::checks(&probe));
        }
    }
    let short = checks.iter().filter(|check| check.verdict == Verdict::Short).count();
    let text = if arguments.json {
        let Arguments { states, seed, .. } = *arguments;
        let audit = Audit { robot: model.name(), passed: short == 0, states, seed, checks: &checks };
        serde_json::to_string(&audit).map_err(Failure::new)? + "\n"
    } else {
        text(arguments, model.name(), &checks, short)
    };
    print(&text)?;
    Ok(if short == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(arguments: &Arguments, name: &str, checks: &[Check], short: usize) -> String {
    let mut table = Table::new(&["check", ">worst found", ">allowed", "verdict", "where"]);
    for check in checks {
        table.row([
            check.law.clone(),
            shown(check.found),
            format!("{} {}", check.relation.sign(), shown(check.allowed)),
            check.verdict.shown().into(),
            check.place.clone(),
        ]);
    }
    let Arguments { states, seed, .. } = arguments;
    let verdict = match short {
        0 => "Nothing falls short.".to_owned(),
        1 => "1 check falls short.".to_owned(),
        short => format!("{short} checks fall short."),
    };
    format!(
        "{name} ({}): {states} random states, seed {seed}\n\n{}\n{verdict}\n",
        arguments.robot.shown(),
        table.text()
    )
}
