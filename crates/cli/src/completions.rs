//! `dynamics completions`: scripts for shell completion.

use std::process::ExitCode;

use clap_complete::Shell;

use crate::failure::{CommandResult, Failure};
use crate::output::print_as_it_is;

/// Print a script for shell completion.
///
/// In Bash: source <(dynamics completions bash)
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Shell for which the script is.
    shell: Shell,
}

pub(crate) fn run(arguments: &Arguments, mut command: clap::Command) -> CommandResult {
    let mut script = Vec::new();
    let name = command.get_name().to_owned();
    clap_complete::generate(arguments.shell, &mut command, name, &mut script);
    print_as_it_is(&String::from_utf8(script).map_err(Failure::new)?)?;
    Ok(ExitCode::SUCCESS)
}
