//! `dynamics certify`: proven bounds of a robot's quantities.

mod digits;
mod intervals;
mod mass_matrix;
mod motion;
mod reach;
mod results;
mod torques;

use std::process::ExitCode;

use robot_dynamics_certified::CHECKER;

use crate::failure::CommandResult;
use crate::output::print_as_it_is;

/// Prove bounds of a robot's quantities by interval arithmetic.
///
/// Each number that this command calls proven holds for every state and robot of the stated set, with all
/// rounding errors of the computation. It holds for the robot as it is compiled, with constants in double
/// precision. The exit code is 0 if the claim is proven, and 1 if not.
///
/// --certificate writes the robot's constants and the claim as JSON. `dynamics certify checker` prints a
/// Python program that proves the claim again from this file, by exact integers and without this program's
/// code.
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
    Motion(motion::Arguments),
    /// Print the program that checks certificates, for Python 3.8 or later.
    Checker,
}

pub(crate) fn run(arguments: &Arguments) -> CommandResult {
    match &arguments.task {
        Task::Digits(arguments) => digits::run(arguments),
        Task::Torques(arguments) => torques::run(arguments),
        Task::MassMatrix(arguments) => mass_matrix::run(arguments),
        Task::Reach(arguments) => reach::run(arguments),
        Task::Motion(arguments) => motion::run(arguments),
        Task::Checker => print_as_it_is(CHECKER).map(|()| ExitCode::SUCCESS),
    }
}
