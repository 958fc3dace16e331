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
mod suspect;
#[cfg(test)]
mod tests;

use std::process::ExitCode;

use multibody::plausibility::{Suspicion, suspicions};
use serde::Serialize;

use self::check::{Check, Verdict, shown};
use self::probe::Probe;
use self::suspect::Suspect;
use crate::failure::{Failure, Outcome};
use crate::output::print;
use crate::robot_file::{Loaded, RobotFile};
use crate::size::refuse_beyond_memory;
use crate::table::Table;

/// Check a robot's file and its dynamics against independent derivations.
///
/// Every check is made at random states within the limits (seeded: the same every time) and shows the worst
/// one. What two routes to the same number may differ by is rounding: 1e-12 of the largest term where terms
/// are added up, and of a solved equation M a = f what 64 ε (ε = 2.2e-16) of each row's terms makes of a by
/// M⁻¹. Where a robot's numbers leave no accuracy, the condition number κ(M) itself falls short. The energy of a free motion must converge to a constant with the order of the
/// integrator. The exit code is 1 if something falls short.
///
/// Numbers that no law forbids but no robot has (masses in grams, angles in degrees) are suspected of a wrong
/// unit, each with the range that was expected and the likely cause. They do not change the exit code unless
/// --strict is given.
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
    suspicions: Vec<Suspect<'a>>,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let Loaded { model, report, shapes, angles, .. } = arguments.robot.load()?;
    arguments.robot.print_warnings(&report);
    refuse_beyond_memory(&model)?;
    let mut checks = vec![load::ignored_physics(&report)];
    checks.extend(inertia::triangle(&model));
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
    let suspicions = suspicions(model.description(), &shapes, &angles);
    let passed = short == 0 && (suspicions.is_empty() || !arguments.robot.is_strict());
    let text = if arguments.json {
        let Arguments { states, seed, .. } = *arguments;
        let suspicions = suspicions.iter().map(Suspect::new).collect();
        let audit = Audit { robot: model.name(), passed, states, seed, checks: &checks, suspicions };
        serde_json::to_string(&audit).map_err(Failure::new)? + "\n"
    } else {
        text(arguments, model.name(), &checks, short, &suspicions)
    };
    print(&text)?;
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(
    arguments: &Arguments,
    name: &str,
    checks: &[Check],
    short: usize,
    suspicions: &[Suspicion],
) -> String {
    let mut table = Table::new(&["check", ">worst found", ">allowed", "verdict", "where"]);
    for check in checks {
        table.row([
            check.law.clone(),
            shown(check.found),
            format!("≤ {}", shown(check.allowed)),
            check.verdict.shown().into(),
            check.place.clone(),
        ]);
    }
    let Arguments { states, seed, .. } = arguments;
    let verdict = match short {
        0 => "Nothing falls short".to_owned(),
        1 => "1 check falls short".to_owned(),
        short => format!("{short} checks fall short"),
    };
    let suspected = match suspicions.len() {
        0 => String::new(),
        1 => "; 1 suspicion".to_owned(),
        many => format!("; {many} suspicions"),
    };
    format!(
        "{name} ({}): {states} random states, seed {seed}\n\n{}\n{}\n{verdict}{suspected}.\n",
        arguments.robot.shown(),
        table.text(),
        suspect::text(suspicions)
    )
}
