//! `dynamics audit`: compares a robot's dynamics with independent derivations.

mod suspect;

use std::process::ExitCode;

use robot_dynamics::plausibility::{Suspicion, suspicions};
use robot_dynamics::text::one_line;
use robot_dynamics::verification::audit::{
    Check, DEFAULT_SEED, DEFAULT_STATES, Verdict, audit, ignored_physics,
};
use serde::Serialize;

use self::suspect::Suspect;
use crate::failure::{CommandResult, Failure};
use crate::output::{print, print_json};
use crate::robot_file::{LoadedRobot, RobotFile};
use crate::size::refuse_beyond_memory;
use crate::table::{Table, short_or_exponent};

/// Check a robot's file and its dynamics against independent derivations.
///
/// Each check runs at random states within the limits and shows its worst result. The states depend only on
/// --seed. Two routes to the same number may differ by rounding only. For sums, that is 1e-12 of the largest
/// term. For a solution a of M a = f, it is M⁻¹ times 64 ε of each row's terms, with ε = 2.2e-16. If the
/// numbers of a robot leave no accuracy, the check of the condition number κ(M) fails. The energy of a free
/// motion must converge to a constant with the order of the integrator. The exit code is 1 if a check fails.
///
/// The audit also lists values that no law forbids but that suggest a wrong unit, such as masses in grams or
/// angles in degrees. Each is shown with the expected range and the likely cause. They change the exit code
/// only with --strict.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    robot: RobotFile,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// Number of random states for each check.
    #[arg(long, default_value_t = DEFAULT_STATES, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    states: u32,
    /// Seed of the random states.
    #[arg(long, default_value_t = DEFAULT_SEED)]
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

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    let LoadedRobot { model, report, angles, .. } = arguments.robot.load_with_warnings()?;
    refuse_beyond_memory(&model)?;
    let mut checks = vec![ignored_physics(&report)];
    checks.extend(audit(&model, arguments.states, arguments.seed));
    let short = checks.iter().filter(|check| check.verdict == Verdict::Short).count();
    let suspicions = suspicions(model.description(), &angles);
    let passed = short == 0 && (suspicions.is_empty() || !arguments.robot.is_strict());
    if arguments.json {
        let Arguments { states, seed, .. } = *arguments;
        let suspicions = suspicions.iter().map(Suspect::new).collect();
        let audit = Audit { robot: model.name(), passed, states, seed, checks: &checks, suspicions };
        print_json(&(serde_json::to_string(&audit).map_err(Failure::new)? + "\n"))?;
    } else {
        print(&text(arguments, model.name(), &checks, short, &suspicions))?;
    }
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
            short_or_exponent(check.found),
            format!("≤ {}", short_or_exponent(check.allowed)),
            if check.verdict == Verdict::Ok { "ok".into() } else { "FAILED".into() },
            check.place.clone(),
        ]);
    }
    let Arguments { states, seed, .. } = arguments;
    let verdict = match short {
        0 => "All checks pass".to_owned(),
        1 => "1 check fails".to_owned(),
        short => format!("{short} checks fail"),
    };
    let suspected = match suspicions.len() {
        0 => String::new(),
        1 => "; 1 suspicious value".to_owned(),
        many => format!("; {many} suspicious values"),
    };
    format!(
        "{} ({}): {states} random states, seed {seed}\n\n{}\n{}\n{verdict}{suspected}.\n",
        one_line(name),
        one_line(&arguments.robot.shown().to_string()),
        table.text(),
        suspect::text(suspicions)
    )
}
