//! The command `dynamics`: a robot's dynamics from its file.
//!
//! Every subcommand is a module with its arguments and one `run`; a failure is one line on standard error
//! and exit code 1 (2 for a command line that does not parse).

mod arguments;
mod columns;
mod compute;
mod failure;
mod inspect;
mod inspection;
mod joint_values;
mod numbers;
mod output;
mod robot_file;
mod simulate;
mod table;
mod whole_file;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Robot dynamics: M(q) a + C(q,v) v + g(q) + b = τ, for any robot from its URDF file.
#[derive(Parser)]
#[command(name = "dynamics", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Print the worked example of the two-link arm, computed.
    Numbers,
    /// Show a robot: tree, joints, limits, masses, and what its file did not say or is not read.
    Inspect(inspect::Arguments),
    /// Compute M, C, g, torques and accelerations for states read as JSON lines.
    Compute(compute::Arguments),
    /// Let a robot move from a pose, or hold it, and account for the energy.
    Simulate(simulate::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Numbers => numbers::run(),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Compute(arguments) => compute::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}
