//! `dynamics completions`: what a shell needs to complete this command's options.

use std::process::ExitCode;

use clap_complete::Shell;

use crate::failure::{Failure, Outcome};
use crate::output::print_as_it_is;

/// Print a script that completes this command's options in a shell.
///
/// Bash, for one, reads it with: source <(dynamics completions bash)
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// For which shell.
    shell: Shell,
}

pub(crate) fn run(arguments: &Arguments, mut command: clap::Command) -> Outcome {
    let mut script = Vec::new();
    let name = command.get_name().to_owned();
    clap_complete::generate(arguments.shell, &mut command, name, &mut script);
    print_as_it_is(&String::from_utf8(script).map_err(Failure::new)?)?;
    Ok(ExitCode::SUCCESS)
}
