//! The command `dynamics`: a robot's dynamics from its file.
//!
//! Every subcommand is a module with `Arguments` and `run`. An error prints one line on standard error. The
//! exit code is then 1, or 2 for an invalid command line.

mod arguments;
mod audit;
mod bench;
mod certify;
mod columns;
mod completions;
mod compute;
mod convert;
mod destination;
mod failure;
mod generate;
mod inspect;
mod inspection;
mod interruption;
mod joint_values;
mod locks;
mod man;
mod numbers;
mod output;
mod output_file;
mod robot_file;
mod simulate;
mod singular_poses;
mod size;
mod table;
mod whole_file;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

/// Robot dynamics M(q) a + C(q,v) v + g(q) + b = τ for any robot described in URDF, MJCF, SDF or USD.
#[derive(Parser)]
#[command(name = "dynamics", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Print the worked example of the two-link arm.
    Numbers,
    Inspect(inspect::Arguments),
    Compute(compute::Arguments),
    Simulate(Box<simulate::Arguments>),
    Audit(audit::Arguments),
    Bench(bench::Arguments),
    Certify(certify::Arguments),
    Convert(convert::Arguments),
    Generate(generate::Arguments),
    Completions(completions::Arguments),
    Man(man::Arguments),
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return usage(&error),
    };
    let result = match arguments.command {
        Command::Numbers => numbers::run(),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Compute(arguments) => compute::run(&arguments),
        Command::Simulate(mut arguments) => simulate::run(&mut arguments),
        Command::Audit(arguments) => audit::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Certify(arguments) => certify::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments, Arguments::command()),
        Command::Man(arguments) => man::run(&arguments, Arguments::command()),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// Prints help unchanged, and an error of the command line on one line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // A closed pipe is not an error.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let text = error.to_string();
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        eprint!("{text}");
        return ExitCode::from(2);
    }
    let paragraphs = text.split("\n\n").map(|part| part.split_whitespace().collect::<Vec<_>>().join(" "));
    let told: Vec<String> = paragraphs
        .filter(|part| !part.is_empty() && !part.starts_with("Usage:") && !part.starts_with("For more"))
        .collect();
    output::print_line(format_args!("{} (see --help)", told.join("; ")));
    ExitCode::from(2)
}
