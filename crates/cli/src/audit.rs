//! `dynamics audit`: the project's oracles, run on one robot file.

mod suspect;

use std::process::ExitCode;

use multibody::audit::{Check, Verdict, audit, ignored_physics};
use multibody::plausibility::{Suspicion, suspicions};
use multibody::text::one_line;
use serde::Serialize;

use self::suspect::Suspect;
use crate::failure::{Failure, Outcome};
use crate::output::{print, print_json};
use crate::robot_file::{Loaded, RobotFile};
use crate::size::refuse_beyond_memory;
use crate::table::{Table, short};

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
    let Loaded { model, report, angles, .. } = arguments.robot.load()?;
    arguments.robot.print_warnings(&report);
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
            shown(check.found),
            format!("≤ {}", shown(check.allowed)),
            if check.verdict == Verdict::Ok { "ok".into() } else { "FALLS SHORT".into() },
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
        "{} ({}): {states} random states, seed {seed}\n\n{}\n{}\n{verdict}{suspected}.\n",
        one_line(name),
        one_line(&arguments.robot.shown().to_string()),
        table.text(),
        suspect::text(suspicions)
    )
}

/// A number in the table: of usual size as it is, all else by its power of ten.
pub(super) fn shown(x: f64) -> String {
    match x {
        x if x.is_nan() => "NaN".into(),
        x if x.is_infinite() => "∞".into(),
        x if x == 0.0 || (0.01..10_000.0).contains(&x.abs()) => short(x),
        x => format!("{x:.1e}"),
    }
}
