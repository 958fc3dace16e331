//! `dynamics certify`: proven bounds of a robot's quantities.

mod digits;
mod intervals;
mod mass_matrix;
mod reach;
mod torques;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use robot_dynamics_certified::{CHECKER, Certificate};
use serde_json::Value;

use crate::failure::{CommandResult, Context, Failure};
use crate::output::{print_as_it_is, print_json, print_line};
use crate::output_file::{OutputFile, finish_all};

/// Prove bounds of a robot's quantities by interval arithmetic.
///
/// Each number that this command calls proven holds for every state and robot of the stated set, with all
/// rounding errors of the computation. It holds for the robot as it is compiled, with constants in double
/// precision. The exit code is 0 if the claim is proven, and 1 if not.
///
/// --certificate writes the robot's constants and the claim as JSON. `dynamics certify checker` prints a Python
/// program that proves the claim again from this file, by exact integers and without this program's code.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(clap::Subcommand)]
enum Task {
    Digits(digits::Arguments),
    Torques(Box<torques::Arguments>),
    MassMatrix(mass_matrix::Arguments),
    Reach(reach::Arguments),
    /// Print the program that checks certificates, for Python 3.8 or later.
    Checker,
}

/// Options of all tasks.
#[derive(clap::Args)]
struct Results {
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// Write a certificate that a separate program can check; `-` for standard output.
    #[arg(long, value_name = "FILE.json")]
    certificate: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    match &arguments.task {
        Task::Digits(arguments) => digits::run(arguments),
        Task::Torques(arguments) => torques::run(arguments),
        Task::MassMatrix(arguments) => mass_matrix::run(arguments),
        Task::Reach(arguments) => reach::run(arguments),
        Task::Checker => print_as_it_is(CHECKER).map(|()| ExitCode::SUCCESS),
    }
}

impl Results {
    /// Prints the results and writes the certificate. The exit code tells whether the claim is proven.
    fn finish<E: std::fmt::Display>(
        &self,
        is_proven: bool,
        text: &str,
        json: &Value,
        certificate: impl FnOnce() -> Result<Certificate, E>,
    ) -> CommandResult {
        let mut is_text_wanted = true;
        if let Some(path) = &self.certificate {
            if is_proven {
                let certificate = certificate().context("--certificate")?;
                let mut output = OutputFile::create(path)?;
                is_text_wanted = !output.is_standard_output();
                writeln!(output, "{certificate}").context(path.display())?;
                finish_all(&mut [&mut output]).context(path.display())?;
            } else {
                print_line(format_args!("note: no certificate is written, since the claim is not proven"));
            }
        }
        if is_text_wanted {
            if self.json {
                print_json(&(serde_json::to_string(json).map_err(Failure::new)? + "\n"))?;
            } else {
                crate::output::print(text)?;
            }
        }
        Ok(if is_proven { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}
